"use strict";
// The studio: a study on the left, as text and as a form; its results on the right. The module runs in workers.
// Parts: elements, bytes, TOML, schema, formulas, editor, form, workers, and the page that joins them.

// ---- Elements ----

const at = (id) => document.getElementById(id);

function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (name === "value") node.value = value;
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return node;
}

const button = (text, click, attributes = {}) =>
  element("button", { type: "button", onclick: click, ...attributes }, text);

// A list whose choice does something: chosen with the mouse at once, with the keys by Enter, since arrow keys choose on their
// way.
function picker(select, act) {
  let keys = false;
  const pick = () => {
    const { value } = select;
    select.value = "";
    if (value) act(value);
  };
  select.title ||= "Enter applies the choice";
  select.addEventListener("pointerdown", () => {
    keys = false;
  });
  select.addEventListener("keydown", (event) => {
    keys = event.key !== "Enter";
    if (keys || !select.value) return;
    event.preventDefault();
    pick();
  });
  select.addEventListener("change", () => {
    if (!keys) pick();
  });
  return select;
}

// Tabs of which the arrow keys choose one.
function tabs(list, chosen) {
  const all = [...list.querySelectorAll("[role=tab]")];
  const choose = (tab, focus) => {
    for (const other of all) {
      other.setAttribute("aria-selected", String(other === tab));
      other.tabIndex = other === tab ? 0 : -1;
    }
    if (focus) tab.focus();
    chosen(tab);
  };
  list.addEventListener("click", ({ target }) => {
    const tab = target.closest("[role=tab]");
    if (tab) choose(tab, false);
  });
  list.addEventListener("keydown", (event) => {
    const from = all.indexOf(event.target);
    if (from < 0) return;
    const to = { ArrowRight: from + 1, ArrowLeft: from - 1, Home: 0, End: all.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    choose(all[(to + all.length) % all.length], true);
  });
  return choose;
}

const panels = (list, then) =>
  tabs(list, (chosen) => {
    for (const tab of list.querySelectorAll("[role=tab]")) {
      at(tab.getAttribute("aria-controls")).hidden = tab !== chosen;
    }
    then?.(chosen.id);
  });

// ---- Bytes ----

const encode = (text) => new TextEncoder().encode(text);
const decode = (bytes) => new TextDecoder().decode(bytes);

// A size in the units of files.
function size(bytes) {
  if (bytes < 1000) return `${bytes} B`;
  if (bytes < 1e6) return `${(bytes / 1e3).toPrecision(3)} kB`;
  return `${(bytes / 1e6).toPrecision(3)} MB`;
}

// From offsets in UTF-8, as the module counts, to offsets in a text of JavaScript.
function places(text) {
  const bytes = encode(text);
  if (bytes.length === text.length) return (offset) => Math.min(offset, text.length);
  const map = new Uint32Array(bytes.length + 1);
  let unit = 0;
  for (let byte = 0; byte < bytes.length; byte++) {
    map[byte] = unit;
    // The last byte of a character ends it; one of four bytes is two units.
    const next = bytes[byte + 1];
    if (next === undefined || (next & 0xc0) !== 0x80) {
      let first = byte;
      while ((bytes[first] & 0xc0) === 0x80) first--;
      unit += bytes[first] >= 0xf0 ? 2 : 1;
    }
  }
  map[bytes.length] = text.length;
  return (offset) => map[Math.min(offset, bytes.length)];
}

// The bytes that an element of the page holds as gzip, in base 64 or in the base 85 of reports.
function packedBytes(letters) {
  const text = letters.trim();
  if (text.startsWith("H4sI")) return Uint8Array.from(atob(text.replace(/\s/g, "")), (letter) => letter.charCodeAt(0));
  const digits = new Uint8Array(128);
  for (let code = 33, digit = 0; code < 127; code++) {
    if (!"\"&'<>\\`,;".includes(String.fromCharCode(code))) digits[code] = digit++;
  }
  const bytes = new Uint8Array(Math.floor((text.length * 4) / 5));
  for (let from = 0, to = 0; from < text.length; from += 5) {
    let word = 0;
    for (let place = from; place < from + 5; place++) {
      word = word * 85 + (place < text.length ? digits[text.charCodeAt(place)] : 84);
    }
    for (let shift = 24; shift >= 0 && to < bytes.length; shift -= 8) bytes[to++] = word / 2 ** shift;
  }
  return bytes;
}

// What a stream gives, up to a number of bytes.
async function gathered(stream, most) {
  const parts = [];
  let sum = 0;
  const reader = stream.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    sum += value.length;
    if (sum > most) {
      reader.cancel().catch(() => {});
      throw new Error(`it has more than ${size(most)}`);
    }
    parts.push(value);
  }
  const bytes = new Uint8Array(sum);
  let place = 0;
  for (const part of parts) {
    bytes.set(part, place);
    place += part.length;
  }
  return bytes;
}

const through = (bytes, transform, most) => gathered(new Blob([bytes]).stream().pipeThrough(transform), most);

// A text as letters that may stand in an address, compressed, and back. The sum of zlib tells what was cut or changed.
async function toLetters(text) {
  const bytes = await through(encode(text), new CompressionStream("deflate"), 1e9);
  let letters = "";
  for (let from = 0; from < bytes.length; from += 8192)
    letters += String.fromCharCode(...bytes.subarray(from, from + 8192));
  return btoa(letters).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "");
}

async function fromLetters(letters, most) {
  if (!/^[A-Za-z0-9_-]+$/.test(letters)) throw new Error("it has letters that no link has");
  const bytes = Uint8Array.from(atob(letters.replace(/-/g, "+").replace(/_/g, "/")), (letter) => letter.charCodeAt(0));
  return new TextDecoder("utf-8", { fatal: true }).decode(
    await through(bytes, new DecompressionStream("deflate"), most),
  );
}

function download(name, bytes, type = "application/octet-stream") {
  const address = URL.createObjectURL(new Blob([bytes], { type }));
  const link = element("a", { href: address, download: name.split("/").pop() });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}

const types = {
  html: "text/html",
  json: "application/json",
  csv: "text/csv",
  svg: "image/svg+xml",
  png: "image/png",
  zip: "application/zip",
};
const typeOf = (name) => types[name.split(".").pop()] ?? (isText(name) ? "text/plain" : "application/octet-stream");
const isText = (name) =>
  /\.(html|json|csv|svg|toml|c|h|rs|md|txt|py|xml|v|lock|gitignore)$|(^|\/)(CMakeLists|Makefile)[^/]*$/.test(name);

// ---- TOML ----

const escapes = { b: "\b", t: "\t", n: "\n", f: "\f", r: "\r", e: "\x1b", '"': '"', "\\": "\\" };
const NUMBER =
  /^[+-]?(?:inf|nan|(?:\d+(?:_\d+)*)(?:\.\d+(?:_\d+)*)?(?:[eE][+-]?\d+(?:_\d+)*)?|0x[0-9a-fA-F_]+|0o[0-7_]+|0b[01_]+)$/;

const quoted = (text) =>
  `"${text
    .replace(/[\\"]/g, "\\$&")
    .replace(/\n/g, "\\n")
    .replace(/\t/g, "\\t")
    .replace(/[\u0000-\u001f\u007f]/g, (letter) => `\\u${letter.charCodeAt(0).toString(16).padStart(4, "0")}`)}"`;
const keyText = (key) => (/^[A-Za-z0-9_-]+$/.test(key) ? key : quoted(key));

// A text in TOML as a tree of tables, arrays and values, each with its place. What is not TOML is a value of the kind
// "bad" up to the end of its line, and the reading goes on behind it: the module decides what a mistake is.
class Toml {
  constructor(text) {
    this.text = text;
    this.place = 0;
    this.statements = [];
    this.headers = [];
    this.root = this.table(0, 0);
    this.current = this.root;
    this.path = [];
    while (this.place < text.length) this.statement();
  }

  table(from, to) {
    return { kind: "table", from, to, members: [], header: null, inline: false };
  }

  member(table, key) {
    return table.members?.find((member) => member.key === key);
  }

  // The node of a path of keys and numbers.
  get(path) {
    let node = this.root;
    for (const step of path) {
      node = typeof step === "number" ? node?.items?.[step] : node && this.member(node, step)?.node;
    }
    return node;
  }

  value(path) {
    return this.get(path)?.value;
  }

  space(lines) {
    const { text } = this;
    for (;;) {
      const letter = text[this.place];
      if (letter === " " || letter === "\t" || (lines && (letter === "\n" || letter === "\r"))) this.place++;
      else if (letter === "#") while (this.place < text.length && text[this.place] !== "\n") this.place++;
      else return;
    }
  }

  lineEnd(from) {
    const end = this.text.indexOf("\n", from);
    return end < 0 ? this.text.length : end;
  }

  // Keys with dots between them; null if there is none.
  keys() {
    const keys = [];
    for (;;) {
      this.space(false);
      const from = this.place;
      const letter = this.text[from];
      if (letter === '"' || letter === "'") {
        const node = this.string();
        if (node.kind !== "string") return null;
        keys.push({ key: node.value, from, to: this.place });
      } else {
        const pattern = /[A-Za-z0-9_-]+/y;
        pattern.lastIndex = from;
        if (!pattern.test(this.text)) return null;
        this.place = pattern.lastIndex;
        keys.push({ key: this.text.slice(from, this.place), from, to: this.place });
      }
      this.space(false);
      if (this.text[this.place] !== ".") return keys;
      this.place++;
    }
  }

  // The table of a path from another one, made where there is none; of an array of tables the last.
  descend(from, keys, path) {
    let table = from;
    for (const { key, from: place, to } of keys) {
      let member = this.member(table, key);
      if (!member) {
        member = { key, keyFrom: place, keyTo: to, node: this.table(place, to) };
        table.members.push(member);
      }
      table = member.node;
      path.push(key);
      if (table.kind === "tables") {
        path.push(table.items.length - 1);
        table = table.items.at(-1);
      }
      if (table.kind !== "table") return null;
    }
    return table;
  }

  statement() {
    this.space(true);
    const from = this.place;
    if (from >= this.text.length) return;
    if (this.text[from] === "[") {
      this.head(from);
    } else {
      const table = this.current;
      const keys = this.keys();
      const path = [...this.path];
      if (keys && this.text[this.place] === "=") {
        this.place++;
        this.assign(table, keys, path);
      } else {
        this.place = this.lineEnd(from);
      }
      // What follows on the line is no part of the statement.
      const to = this.place;
      this.statements.push({ from, to, path: this.path, table });
      if (table.header || table === this.root) table.to = Math.max(table.to, to);
      this.space(false);
      if (this.place < this.text.length && !/[\r\n]/.test(this.text[this.place])) this.place = this.lineEnd(this.place);
    }
  }

  assign(table, keys, path) {
    const last = keys.pop();
    const target = this.descend(table, keys, path);
    const node = this.read(0);
    if (!target || this.member(target, last.key)) return;
    target.members.push({ key: last.key, keyFrom: last.from, keyTo: last.to, node });
  }

  head(from) {
    const array = this.text[from + 1] === "[";
    this.place = from + (array ? 2 : 1);
    const keys = this.keys();
    const end = this.lineEnd(from);
    const closed = keys && this.text.startsWith(array ? "]]" : "]", this.place);
    const to = closed ? this.place + (array ? 2 : 1) : end;
    this.place = end;
    const path = [];
    const header = { from, to, array, closed: Boolean(closed), path };
    this.headers.push(header);
    const last = keys?.pop();
    const parent = keys && this.descend(this.root, keys, path);
    let table = this.table(from, to);
    if (parent && last) {
      const member = this.member(parent, last.key);
      path.push(last.key);
      if (array) {
        const tables = member?.node ?? { kind: "tables", from, to, items: [] };
        if (!member) parent.members.push({ key: last.key, keyFrom: last.from, keyTo: last.to, node: tables });
        if (tables.kind === "tables") {
          tables.items.push(table);
          path.push(tables.items.length - 1);
        }
      } else if (member?.node.kind === "table" && !member.node.header) {
        table = member.node;
        Object.assign(table, { from, to });
      } else if (!member) {
        parent.members.push({ key: last.key, keyFrom: last.from, keyTo: last.to, node: table });
      }
    }
    table.header = header;
    this.current = table;
    this.path = path;
  }

  read(depth) {
    this.space(false);
    const { text } = this;
    const from = this.place;
    const letter = text[from];
    if (letter === '"' || letter === "'") return this.string();
    if (depth < 60 && letter === "[") return this.array(depth);
    if (depth < 60 && letter === "{") return this.inline(depth);
    const pattern = /[^\s,\]}#=]*/y;
    pattern.lastIndex = from;
    pattern.test(text);
    this.place = pattern.lastIndex;
    const word = text.slice(from, this.place);
    if (word === "true" || word === "false") return { kind: "boolean", from, to: this.place, value: word === "true" };
    if (NUMBER.test(word)) {
      const value = Number(word.replace(/_/g, "").replace(/^\+/, "").replace("inf", "Infinity").replace("nan", "NaN"));
      return { kind: "number", from, to: this.place, value };
    }
    if (/^\d{4}-|^\d\d:/.test(word)) return { kind: "datetime", from, to: this.place, value: word };
    if (!word)
      this.place = Math.max(from, text[from] === undefined || /[\r\n,\]}#]/.test(letter) ? from : this.lineEnd(from));
    return { kind: "bad", from, to: this.place };
  }

  string() {
    const { text } = this;
    const from = this.place;
    const mark = text[from];
    const long = text.startsWith(mark.repeat(3), from);
    const close = long ? mark.repeat(3) : mark;
    let place = from + close.length;
    if (long && text[place] === "\r") place++;
    if (long && text[place] === "\n") place++;
    let value = "";
    while (place < text.length) {
      if (text.startsWith(close, place)) {
        place += close.length;
        // Up to two marks before the end belong to the text.
        while (long && text[place] === mark && text.startsWith(close, place - close.length + 1)) {
          value += mark;
          place++;
        }
        this.place = place;
        return { kind: "string", from, to: place, value, long, literal: mark === "'" };
      }
      const letter = text[place];
      if (!long && (letter === "\n" || letter === "\r")) break;
      if (letter === "\\" && mark === '"') {
        const next = text[place + 1];
        const code = /^(?:u([0-9a-fA-F]{4})|U([0-9a-fA-F]{8})|x([0-9a-fA-F]{2}))/.exec(
          text.slice(place + 1, place + 10),
        );
        if (code) {
          const number = parseInt(code[1] ?? code[2] ?? code[3], 16);
          value += number <= 0x10ffff ? String.fromCodePoint(number) : "";
          place += 1 + code[0].length;
        } else if (next in escapes) {
          value += escapes[next];
          place += 2;
        } else if (long && /\s/.test(next ?? "x")) {
          place++;
          while (/\s/.test(text[place] ?? "x")) place++;
        } else {
          place += 2;
        }
      } else {
        value += letter;
        place++;
      }
    }
    this.place = long ? text.length : this.lineEnd(from);
    return { kind: "bad", from, to: this.place };
  }

  array(depth) {
    const node = { kind: "array", from: this.place, to: 0, items: [], closed: false };
    this.place++;
    for (;;) {
      this.space(true);
      const letter = this.text[this.place];
      if (letter === undefined) break;
      if (letter === "]") {
        this.place++;
        node.closed = true;
        break;
      }
      if (letter === ",") {
        this.place++;
        continue;
      }
      const before = this.place;
      const item = this.read(depth + 1);
      node.items.push(item);
      // A key or a header in an array that was not closed: the array ends before it.
      if (item.kind === "bad" || this.place === before || this.text[this.place] === "=") break;
    }
    node.to = this.place;
    if (!node.closed) node.kind = "bad";
    else node.value = node.items.map((item) => item.value);
    return node;
  }

  inline(depth) {
    const node = Object.assign(this.table(this.place, 0), { inline: true, closed: false });
    this.place++;
    for (;;) {
      this.space(true);
      const letter = this.text[this.place];
      if (letter === "}") {
        this.place++;
        node.closed = true;
        break;
      }
      if (letter === ",") {
        this.place++;
        continue;
      }
      const keys = letter === undefined ? null : this.keys();
      if (!keys || this.text[this.place] !== "=") break;
      this.place++;
      const last = keys.pop();
      const target = this.descend(node, keys, []);
      const value = this.read(depth + 1);
      if (target && !this.member(target, last.key))
        target.members.push({ key: last.key, keyFrom: last.from, keyTo: last.to, node: value });
      if (value.kind === "bad") break;
    }
    node.to = this.place;
    if (!node.closed) node.kind = "bad";
    return node;
  }

  // Where a place is: in a header, at a key or in a value, with the path and the start of the word.
  context(place) {
    const header = this.headers.findLast((header) => header.from <= place);
    if (header && place <= this.lineEnd(header.from) && place > header.from) {
      const word = /[^[\]]*$/.exec(this.text.slice(header.from, place))[0];
      return place <= header.to ? { mode: "header", from: place - word.length, array: header.array, path: [] } : null;
    }
    const path = header?.path ?? [];
    const statement = this.statements.findLast((statement) => statement.from <= place);
    const start = statement && statement.from > (header?.from ?? -1) ? statement.from : null;
    if (start !== null) {
      const found = this.within(start, place, path, statement.to);
      if (found !== undefined) return found;
    }
    const line = this.text.slice(this.text.lastIndexOf("\n", place - 1) + 1, place);
    if (!/^\s*[A-Za-z0-9_-]*$/.test(line)) return null;
    return { mode: "key", from: place - /[A-Za-z0-9_-]*$/.exec(line)[0].length, path };
  }

  // The same within a statement; undefined where the statement ends before the place.
  within(from, place, path, end) {
    const { text } = this;
    const stack = [{ path, key: null, keys: true, list: false }];
    let now = from;
    while (now < place) {
      const top = stack.at(-1);
      const letter = text[now];
      if (letter === "#") {
        const stop = this.lineEnd(now);
        if (stop >= place) return null;
        now = stop;
      } else if (/[\r\n]/.test(letter)) {
        if (stack.length === 1 && now >= end) return undefined;
        now++;
      } else if (/[ \t]/.test(letter)) {
        now++;
      } else if (top.keys) {
        const word = /[A-Za-z0-9_.-]+|"[^"\n]*"?|'[^'\n]*'?/y;
        word.lastIndex = now;
        if (letter === "=") {
          [top.keys, now] = [false, now + 1];
        } else if (letter === "}" && stack.length > 1) {
          stack.pop();
          now++;
        } else if (word.test(text)) {
          if (word.lastIndex >= place) {
            const written = text.slice(now, place);
            const dots = written.split(".");
            return { mode: "key", from: place - dots.at(-1).length, path: [...top.path, ...dots.slice(0, -1)] };
          }
          top.key = text.slice(now, word.lastIndex).replace(/^["']|["']$/g, "");
          now = word.lastIndex;
        } else {
          now++;
        }
      } else if (letter === '"' || letter === "'") {
        this.place = now;
        const string = this.string();
        const open = now + (string.long ? 3 : 1);
        if (string.to > place || (string.kind === "bad" && string.to >= place)) {
          return {
            mode: "value",
            path: [...top.path, ...(top.key === null ? [] : top.key.split("."))],
            from: open,
            string: true,
            to: string.kind === "bad" ? place : string.to - 1,
          };
        }
        now = string.to;
      } else if (letter === "[" || letter === "{") {
        const inner = [...top.path, ...(top.key === null ? [] : top.key.split("."))];
        stack.push({ path: inner, key: null, keys: letter === "{", list: letter === "[" });
        now++;
      } else if (letter === "]" || letter === "}") {
        if (stack.length > 1) stack.pop();
        now++;
      } else if (letter === ",") {
        if (!top.list && stack.length > 1) [top.keys, top.key] = [true, null];
        now++;
      } else {
        const word = /[^\s,\]}#"'[{]+/y;
        word.lastIndex = now;
        word.test(text);
        if (word.lastIndex >= place)
          return { mode: "value", path: [...top.path, ...(top.key === null ? [] : top.key.split("."))], from: now };
        now = word.lastIndex;
      }
    }
    const top = stack.at(-1);
    if (stack.length === 1 && place > end && /\n/.test(text.slice(end, place))) return undefined;
    if (top.keys) return { mode: "key", from: place, path: top.path };
    const before = text.slice(from, place).trimEnd();
    // Behind a complete value nothing is offered.
    if (!/[=[,]$/.test(before)) return null;
    return { mode: "value", path: [...top.path, ...(top.key === null ? [] : top.key.split("."))], from: place };
  }
}

// ---- The schema ----

// study.schema.json: what may stand at a path, and what it is for.
class Schema {
  constructor(schema) {
    this.schema = schema;
  }

  // The schemas of a path; of the kinds of an observer that one whose `kind` the text has.
  at(path, toml) {
    let found = [this.schema];
    const walked = [];
    for (const step of path) {
      found = found.flatMap((schema) => this.step(schema, step));
      walked.push(step);
      found = found.flatMap((schema) => this.narrowed(schema, toml?.get(walked)));
    }
    return found;
  }

  step(schema, step) {
    const inner = [...(schema.anyOf ?? []), ...(schema.oneOf ?? [])].flatMap((one) => this.step(one, step));
    if (typeof step === "number") return schema.items ? [schema.items] : inner;
    if (schema.properties?.[step]) return [schema.properties[step]];
    if (schema.additionalProperties && schema.type === "object") return [schema.additionalProperties];
    // The items of an array that is asked for a key: an inline table in it.
    if (schema.items?.properties || schema.items?.oneOf) return this.step(schema.items, step);
    return inner;
  }

  narrowed(schema, node) {
    if (!schema.oneOf?.some((one) => one.properties)) return [schema];
    const fits = schema.oneOf.filter((one) =>
      Object.entries(one.properties).every(([key, { const: value }]) => {
        const written = node?.members?.find((member) => member.key === key)?.node.value;
        return value === undefined || written === undefined || written === value;
      }),
    );
    return fits.length ? fits : schema.oneOf;
  }

  // The keys of a table: name, description, schema, whether it is required.
  keys(path, toml) {
    const keys = new Map();
    for (const schema of this.at(path, toml)) {
      for (const one of [schema, ...(schema.anyOf ?? [])]) {
        for (const [name, inner] of Object.entries(one.properties ?? {})) {
          if (!keys.has(name)) keys.set(name, { name, schema: inner, required: one.required?.includes(name) });
        }
      }
    }
    return [...keys.values()];
  }

  // The values of a key that has only a few: value and description.
  choices(path, toml) {
    const choices = new Map();
    const walk = (schema) => {
      if (schema.const !== undefined) choices.set(schema.const, schema.description ?? "");
      for (const value of schema.enum ?? []) choices.set(value, "");
      if (schema.type === "boolean") for (const value of [true, false]) choices.set(value, "");
      for (const one of [...(schema.oneOf ?? []), ...(schema.anyOf ?? [])]) walk(one);
      if (schema.items) walk(schema.items);
    };
    const parent = path.slice(0, -1);
    const key = path.at(-1);
    // A tag such as `kind` is that of every variant, not of the chosen one.
    const tagged = this.untagged(parent).flatMap((schema) =>
      (schema.oneOf ?? []).flatMap((one) => (one.properties?.[key]?.const === undefined ? [] : [one.properties[key]])),
    );
    for (const schema of tagged.length ? tagged : this.at(path, toml)) walk(schema);
    return [...choices].map(([value, description]) => ({ value, description }));
  }

  untagged(path) {
    let found = [this.schema];
    for (const step of path) found = found.flatMap((schema) => this.step(schema, step));
    return found;
  }

  describe(path, toml) {
    return (
      this.at(path, toml)
        .map((schema) => schema.description)
        .find((text) => text) ?? ""
    );
  }

  // Whether a value of the path may be a text, as an expression in place of a number may.
  texts(path, toml) {
    const may = (schema) =>
      schema.type === "string" ||
      (Array.isArray(schema.type) && schema.type.includes("string")) ||
      [...(schema.anyOf ?? []), ...(schema.oneOf ?? [])].some(may) ||
      (schema.items && may(schema.items)) ||
      schema.enum?.some((value) => typeof value === "string");
    return this.at(path, toml).some(may);
  }

  // What is written for a new value.
  template(schema) {
    const type = Array.isArray(schema.type) ? schema.type[0] : schema.type;
    const first = schema.const ?? schema.oneOf?.find((one) => one.const !== undefined)?.const ?? schema.enum?.[0];
    if (first !== undefined) return typeof first === "string" ? quoted(first) : String(first);
    if (type === "string") return '""';
    if (type === "boolean") return "true";
    if (type === "number" || type === "integer") return String(schema.minimum ?? 1);
    if (type === "array") {
      const inner = schema.items ? this.template(schema.items) : "";
      return `[${Array(schema.minItems ?? 1)
        .fill(inner)
        .join(", ")}]`;
    }
    if (type === "object") {
      const needed = (schema.required ?? []).map((key) => `${key} = ${this.template(schema.properties[key])}`);
      return needed.length ? `{ ${needed.join(", ")} }` : "{}";
    }
    const one = schema.anyOf?.[0] ?? schema.oneOf?.[0];
    return one ? this.template(one) : '""';
  }
}

// ---- Formulas ----

const GREEK =
  "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi chi psi omega".split(
    " ",
  );
const LETTERS = "αβγδεζηθικλμνξπρστυφχψω";

const mathml = (tag, ...children) => {
  const node = document.createElementNS("http://www.w3.org/1998/Math/MathML", tag);
  node.append(...children);
  return node;
};

function mathWord(name) {
  const index = GREEK.indexOf(name.toLowerCase());
  if (index >= 0) return mathml("mi", name === name.toLowerCase() ? LETTERS[index] : LETTERS[index].toUpperCase());
  return mathml(/^\d+$/.test(name) ? "mn" : "mi", name);
}

// A name with its index; `over` puts a mark over its stem, as of a derivative.
function mathName(name, over = (stem) => stem) {
  const parts = /^([A-Za-z]+)_(.+)$/.exec(name) ?? /^([A-Za-z]+)(\d+)$/.exec(name);
  return parts ? mathml("msub", over(mathWord(parts[1])), mathWord(parts[2])) : over(mathWord(name));
}

// An expression as a formula; null if it is none that is understood here, of which the module says why.
function typeset(text) {
  const tokens =
    text.match(
      /\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|[A-Za-z_][A-Za-z0-9_]*|\*\*|<=|>=|==|!=|&&|\|\||\S/g,
    ) ?? [];
  let place = 0;
  const operators = {
    "||": 1,
    "&&": 2,
    "<": 3,
    ">": 3,
    "<=": 3,
    ">=": 3,
    "==": 3,
    "!=": 3,
    "+": 5,
    "-": 5,
    "*": 7,
    "/": 7,
  };
  const shown = { "<=": "≤", ">=": "≥", "==": "=", "!=": "≠", "&&": "∧", "||": "∨", "-": "−" };
  const fail = () => {
    throw new Error("no formula");
  };
  const row = (...children) => mathml("mrow", ...children);
  const mark = (text) => {
    const node = mathml("mo", text);
    if (/[()|]/.test(text)) node.setAttribute("stretchy", "false");
    return node;
  };
  // Brackets grow with a fraction or a power between them.
  const brackets = (node) => {
    const grow = node.querySelector("mfrac, msup") || ["mfrac", "msup"].includes(node.localName);
    return row(grow ? mathml("mo", "(") : mark("("), node, grow ? mathml("mo", ")") : mark(")"));
  };
  // A part with its strength, and brackets around it where it is weaker than its place asks for.
  const held = (part, least) => (part.strength < least ? brackets(part.node) : part.node);
  const part = (node, strength, number = false) => ({ node, strength, number });

  function operand(depth) {
    const token = tokens[place++];
    if (token === undefined || depth > 200) fail();
    if (token === "-" || token === "+" || token === "!") {
      const inner = expression(8, depth + 1);
      return part(row(mark({ "!": "¬", "-": "−", "+": "+" }[token]), held(inner, 8)), 6);
    }
    if (token === "(") {
      const inner = expression(0, depth + 1);
      if (tokens[place++] !== ")") fail();
      return inner;
    }
    if (/^[\d.]/.test(token)) {
      const parts = /^(.*)[eE]\+?(-?\d+)$/.exec(token);
      if (!parts) return part(mathml("mn", token), 10, true);
      const [, digits, exponent] = parts;
      const sign = exponent.startsWith("-") ? [mark("−"), mathml("mn", exponent.slice(1))] : [mathml("mn", exponent)];
      return part(row(mathml("mn", digits), mark("·"), mathml("msup", mathml("mn", "10"), row(...sign))), 7, true);
    }
    if (!/^[A-Za-z_]/.test(token)) fail();
    if (tokens[place] !== "(") return part(mathName(token), 10);
    place++;
    const given = [];
    while (tokens[place] !== ")") {
      given.push(expression(0, depth + 1));
      if (tokens[place] === ",") place++;
      else if (tokens[place] !== ")") fail();
    }
    place++;
    const nodes = given.map(({ node }) => node);
    if (token === "sqrt" && nodes.length === 1) return part(mathml("msqrt", nodes[0]), 10);
    if (token === "abs" && nodes.length === 1) return part(row(mark("|"), nodes[0], mark("|")), 10);
    if (token === "exp" && nodes.length === 1) return part(mathml("msup", mathml("mi", "e"), nodes[0]), 9);
    const list = nodes.flatMap((node, k) => (k ? [mark(","), node] : [node]));
    return part(row(mathName(token), brackets(row(...list))), 10);
  }

  function expression(least, depth) {
    let left = operand(depth);
    for (;;) {
      const token = tokens[place];
      if (token === "^" || token === "**") {
        if (9 < least) return left;
        place++;
        const right = expression(8, depth + 1);
        left = part(mathml("msup", held(left, 10), right.node), 9);
        continue;
      }
      const strength = operators[token];
      if (strength === undefined || strength < least) return left;
      place++;
      const right = expression(strength + 1, depth + 1);
      if (token === "/") left = part(mathml("mfrac", left.node, right.node), 9);
      else if (token === "*") {
        const between = right.number ? mark("·") : mark("\u2062");
        const gap = mathml("mspace");
        gap.setAttribute("width", "0.17em");
        left = part(row(held(left, 6), between, gap, held(right, 7)), 7);
      } else left = part(row(held(left, strength), mark(shown[token] ?? token), held(right, strength + 1)), strength);
    }
  }

  try {
    const { node } = expression(0, 0);
    return place === tokens.length ? node : null;
  } catch {
    return null;
  }
}

const math = (...children) => mathml("math", ...children);

// ---- The editor ----

const external = Editor.Annotation.define();

const FUNCTIONS =
  "sqrt exp ln log10 sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh pow abs min max sat sign step floor wrap mod if".split(
    " ",
  );
const NAMES = new Set(["states", "inputs", "outputs", "observers"]);
const EXPRESSIONS = new Set(["f", "h", "expressions", "parameters", "w", "v"]);

// The text of the study: `changed` is called after each change, `schema()` gives the schema once it is there.
class StudyEditor {
  constructor(parent, { changed, schema, run, save }) {
    this.schema = schema;
    this.themes = new Editor.Compartment();
    this.language = new Editor.Compartment();
    this.reading = null;
    const highlight = Editor.HighlightStyle.define([
      { tag: Editor.tags.comment, color: "var(--soft)", fontStyle: "italic" },
      { tag: Editor.tags.string, color: "var(--string)" },
      { tag: [Editor.tags.number, Editor.tags.bool, Editor.tags.atom], color: "var(--number)" },
      { tag: [Editor.tags.propertyName, Editor.tags.keyword], color: "var(--link)" },
    ]);
    const leave = { key: "Tab", run: Editor.indentMore, shift: Editor.indentLess };
    this.extensions = [
      Editor.lineNumbers(),
      Editor.highlightActiveLineGutter(),
      Editor.highlightSpecialChars(),
      Editor.history(),
      Editor.drawSelection(),
      Editor.highlightActiveLine(),
      Editor.bracketMatching(),
      Editor.closeBrackets(),
      Editor.highlightSelectionMatches(),
      Editor.lintGutter(),
      Editor.search({ top: true }),
      Editor.syntaxHighlighting(highlight),
      Editor.autocompletion({ override: [(context) => this.complete(context)], icons: false }),
      Editor.hoverTooltip((view, place) => this.about(place)),
      Editor.keymap.of([
        { key: "Mod-Enter", run: () => (run(), true) },
        { key: "Mod-s", run: () => (save(), true), preventDefault: true },
        ...Editor.closeBracketsKeymap,
        ...Editor.completionKeymap,
        ...Editor.searchKeymap,
        ...Editor.lintKeymap,
        ...Editor.historyKeymap,
        ...Editor.defaultKeymap,
        leave,
      ]),
      Editor.EditorView.lineWrapping,
      Editor.EditorView.contentAttributes.of({ "aria-label": "Study file, TOML. Escape, then Tab leaves the editor." }),
      Editor.EditorView.updateListener.of((update) => {
        if (!update.docChanged) return;
        this.reading = null;
        changed(update);
      }),
      this.themes.of([]),
      this.language.of(Editor.StreamLanguage.define(Editor.toml)),
    ];
    this.view = new Editor.EditorView({ parent, state: this.state("") });
  }

  state(text) {
    return Editor.EditorState.create({ doc: text, extensions: this.extensions });
  }

  get text() {
    return this.view.state.doc.toString();
  }

  // The tree of the text as it is now.
  get toml() {
    return (this.reading ??= new Toml(this.text));
  }

  // Another text, with the one before in the history.
  replace(text) {
    const { view } = this;
    const { length } = view.state.doc;
    const marks = [Editor.isolateHistory.of("full"), Editor.Transaction.userEvent.of("input.replace")];
    view.dispatch({
      changes: { from: 0, to: length, insert: text },
      selection: { anchor: 0 },
      annotations: marks,
      scrollIntoView: true,
    });
  }

  // The first text, before which there is none.
  begin(text) {
    this.view.setState(this.state(text));
    this.reading = null;
    this.dark(this.isDark);
  }

  edit(changes, own = false) {
    this.view.dispatch({ changes, annotations: own ? [external.of(true)] : [], userEvent: "input" });
  }

  dark(dark) {
    this.isDark = dark;
    this.view.dispatch({ effects: this.themes.reconfigure(Editor.EditorView.theme({}, { dark })) });
  }

  show(mistakes) {
    this.view.dispatch(Editor.setDiagnostics(this.view.state, mistakes));
  }

  go(from, to = from) {
    this.view.dispatch({
      selection: { anchor: Math.min(from, this.text.length), head: Math.min(to, this.text.length) },
      scrollIntoView: true,
    });
    this.view.focus();
  }

  complete(context) {
    const schema = this.schema();
    if (!schema) return null;
    const { toml } = this;
    const found = toml.context(context.pos);
    if (!found) return null;
    const word = this.text.slice(found.from, context.pos);
    if (!context.explicit && !word && !(found.mode === "value" && found.string)) return null;
    if (found.mode === "header") return this.headers(schema, toml, found);
    if (found.mode === "key") {
      const there = new Set(toml.get(found.path)?.members?.map(({ key }) => key) ?? []);
      there.delete(word);
      const options = schema
        .keys(found.path, toml)
        .filter(({ name }) => !there.has(name))
        .map((key) => ({
          label: key.name,
          info: key.schema.description,
          boost: key.required ? 2 : 0,
          detail: key.required ? "required" : undefined,
          apply: (view, completion, from, to) => this.writeKey(view, key, from, to),
        }));
      return options.length ? { from: found.from, options, validFor: /^[A-Za-z0-9_-]*$/ } : null;
    }
    const key = found.path.at(-1);
    const choices = schema.choices(found.path, toml);
    const names =
      ["observer", "observers"].includes(key) && found.path.length > 1
        ? (toml.get(["observer"])?.items ?? []).map((_, k) => ({
            value: toml.value(["observer", k, "name"]),
            description: "An observer of this study.",
          }))
        : [];
    const options = [...choices, ...names]
      .filter(({ value }) => value !== undefined)
      .map(({ value, description }) => ({
        label: String(value),
        info: description || undefined,
        apply: typeof value !== "string" ? String(value) : found.string ? value : quoted(value),
      }));
    if (options.length) return { from: found.from, options, validFor: /^[^"'\n]*$/ };
    if (!found.string || !EXPRESSIONS.has(key)) return null;
    const name = /[A-Za-z_][A-Za-z0-9_]*$/.exec(word);
    if (!name && !context.explicit) return null;
    const from = context.pos - (name?.[0].length ?? 0);
    return { from, options: this.names(toml), validFor: /^[A-Za-z0-9_]*$/ };
  }

  // What an expression may name.
  names(toml) {
    const named = (key, type) =>
      (toml.value(["plant", key]) ?? [])
        .filter((name) => typeof name === "string")
        .map((label) => ({ label, detail: type, boost: 2 }));
    const parameters = toml.get(["plant", "parameters"])?.members ?? [];
    return [
      ...named("states", "state"),
      ...named("inputs", "input"),
      ...parameters.map(({ key, node }) => ({
        label: key,
        detail: node.value === undefined ? "parameter" : `= ${node.value}`,
        boost: 1,
      })),
      { label: "t", detail: "time" },
      { label: "pi", detail: "3.14159..." },
      ...FUNCTIONS.map((label) => ({ label, detail: "function", apply: `${label}(` })),
    ];
  }

  headers(schema, toml, found) {
    const options = [];
    const walk = (path, depth) => {
      for (const { name, schema: inner } of schema.keys(path, null)) {
        const tables = inner.type === "array" && (inner.items?.properties || inner.items?.oneOf);
        const table = inner.type === "object" || inner.oneOf?.some((one) => one.properties);
        if (!tables && !table) continue;
        if (Boolean(tables) === found.array)
          options.push({ label: [...path, name].join("."), info: inner.description });
        if (depth < 1) walk([...path, name], depth + 1);
      }
    };
    walk([], 0);
    return { from: found.from, options, validFor: /^[A-Za-z0-9_.-]*$/ };
  }

  // A key with what its value begins with; the cursor stands where one goes on to write.
  writeKey(view, { name, schema }, from, to) {
    const rest = view.state.sliceDoc(to, view.state.doc.lineAt(to).to);
    if (/^\s*=/.test(rest)) {
      view.dispatch({
        changes: { from, to, insert: name },
        selection: { anchor: from + name.length },
        userEvent: "input.complete",
      });
      return;
    }
    const value = this.schema().template(schema);
    const inner = value === '""' || value.startsWith("[") || value.startsWith("{") ? 1 : 0;
    const start = from + name.length + 3 + inner;
    const choice = schema.oneOf || schema.enum;
    const head =
      inner || choice
        ? choice && value.startsWith('"')
          ? from + name.length + 3 + value.length - 1
          : start
        : from + name.length + 3 + value.length;
    view.dispatch({
      changes: { from, to, insert: `${name} = ${value}` },
      selection: choice
        ? { anchor: from + name.length + 4, head }
        : { anchor: start, head: value === '""' ? start : from + name.length + 3 + value.length - inner },
      userEvent: "input.complete",
    });
    if (choice || value === '""') setTimeout(() => Editor.startCompletion(view));
  }

  // The description of the key, table or value at a place.
  about(place) {
    const schema = this.schema();
    if (!schema) return null;
    const { toml } = this;
    let found = null;
    const walk = (node, path) => {
      for (const { key, keyFrom, keyTo, node: inner } of node.members ?? []) {
        const own = [...path, key];
        if (keyFrom <= place && place <= keyTo) found = { path: own, from: keyFrom, to: keyTo };
        if (inner.kind === "string" && inner.from <= place && place <= inner.to) {
          const choice = schema.choices(own, toml).find(({ value }) => value === inner.value);
          if (choice?.description) found = { path: own, from: inner.from, to: inner.to, text: choice.description };
        }
        if (inner.kind === "tables") inner.items.forEach((item, k) => walk(item, [...own, k]));
        else walk(inner, own);
      }
    };
    walk(toml.root, []);
    const header = toml.headers.find(({ from, to }) => from <= place && place <= to);
    if (header) found = { path: header.path, from: header.from, to: header.to };
    const text = found && (found.text ?? schema.describe(found.path, toml));
    if (!text) return null;
    return {
      pos: found.from,
      end: found.to,
      create: () => ({
        dom: element(
          "div",
          { class: "cm-about" },
          element("p", {}, element("code", {}, found.path.filter((step) => typeof step === "string").join("."))),
          element("p", {}, text),
        ),
      }),
    };
  }
}

// ---- The form ----

const same = (one, other) => one.length === other.length && one.every((step, k) => step === other[k]);

// The same document as fields: what is written here changes the text at the place of the value, and nothing else of it.
class Form {
  constructor(root, editor, schema) {
    Object.assign(this, { root, editor, schema, serial: 0 });
    // Which sections a study has, in the order in which they are shown.
    this.order = [
      "plant",
      "operating_point",
      "estimate",
      "input",
      "simulation",
      "truth",
      "log",
      "observer",
      "sweep",
      "frequency",
      "plot",
      "advise",
      "tune",
    ];
  }

  get toml() {
    return this.editor.toml;
  }

  // Writes a value; `own` keeps the form as it is, since the field shows the value already.
  write(path, text, own) {
    const node = this.toml.get(path);
    if (!node || node.kind === "bad") return;
    if (this.toml.text.slice(node.from, node.to) === text) return;
    this.editor.edit({ from: node.from, to: node.to, insert: text }, own);
  }

  draw() {
    const active = this.root.contains(document.activeElement) ? document.activeElement : null;
    const id = active?.id;
    const selection = active?.selectionStart === undefined ? null : [active.selectionStart, active.selectionEnd];
    const { scrollTop } = this.root;
    this.serial = 0;
    const { toml } = this;
    const top = this.card("The study", [], (key, node) => !["table", "tables"].includes(node.kind), toml.root);
    const tables = toml.root.members.filter(({ node }) => ["table", "tables"].includes(node.kind) && !node.inline);
    const rank = ({ key }) => (this.order.includes(key) ? this.order.indexOf(key) : 99);
    tables.sort((one, other) => rank(one) - rank(other));
    const cards = tables.flatMap(({ key, node }) =>
      node.kind === "tables"
        ? node.items.map((item, k) => this.card(key === "observer" ? "Observer" : key, [key, k], () => true, item))
        : [key === "plant" ? this.plant(node) : this.card(key, [key], () => true, node)],
    );
    this.root.replaceChildren(top, ...cards, this.adding());
    this.root.scrollTop = scrollTop;
    if (!id) return;
    const again = document.getElementById(id);
    (again ?? this.root).focus({ preventScroll: true });
    if (again && selection?.[0] !== null && selection) again.setSelectionRange?.(...selection);
  }

  // A table: its keys, those that could be added, and a button that removes it.
  card(title, path, chosen, table, { actions = [], before = [] } = {}) {
    const name = table.members?.find(({ key }) => key === "name")?.node.value;
    const kind = table.members?.find(({ key }) => key === "kind")?.node.value;
    const heading =
      path[0] === "observer" && path.length === 2 ? `${name ?? "Observer"}${kind ? ` (${kind})` : ""}` : title;
    const fields = (table.members ?? [])
      .filter(({ key, node }) => chosen(key, node))
      .map((member) => this.field([...path, member.key], member));
    const what = path.length ? heading : "the study";
    const removing =
      path.length && path[0] !== "plant"
        ? button("Remove", () => this.removeTable(path), { "aria-label": `Remove ${what}` })
        : null;
    return element(
      "section",
      { class: "card", "aria-label": heading },
      element("div", { class: "head" }, element(path.length > 2 ? "h3" : "h2", {}, heading), actions, removing),
      path.length ? element("p", { class: "small" }, this.schema().describe(path, this.toml)) : null,
      before,
      fields,
      this.addKey(path, table, what),
    );
  }

  identity(path, role) {
    return `field-${path.join("-").replace(/[^A-Za-z0-9-]/g, "_")}-${role}`;
  }

  field(path, { key, node }) {
    if (node.kind === "table") return this.card(key, path, () => true, node);
    const id = this.identity(path, "value");
    const about = this.schema().describe(path, this.toml);
    const unit = this.unit(path);
    const control = this.control(path, node, id, key);
    const label = control.dataset?.single
      ? element("label", { for: id, title: about }, key)
      : element("span", { class: "label", title: about, id: this.identity(path, "label") }, key);
    if (unit) label.append(element("span", { class: "unit" }, ` (${unit})`));
    return element(
      "div",
      { class: "field" },
      label,
      control,
      button("×", () => this.removeKey(path), { class: "remove", "aria-label": `Remove ${key}`, title: "Remove" }),
    );
  }

  // The unit that the plant gives a name.
  unit(path) {
    const table = this.toml.get(["plant", "units"]);
    const time = this.toml.value(["plant", "time_unit"]);
    const name = path.at(-1);
    if (path.length === 3 && path[1] === "parameters")
      return table?.members?.find(({ key }) => key === name)?.node.value;
    if (path.length === 2 && path[0] === "simulation" && ["duration", "hold"].includes(name)) return time;
    if (name === "period" && path[0] === "observer") return time;
    return undefined;
  }

  control(path, node, id, key) {
    const holder = (single, ...children) => {
      const control = element("div", { class: "control" }, ...children);
      if (single) control.dataset.single = "yes";
      else control.setAttribute("aria-labelledby", this.identity(path, "label"));
      if (!single) control.setAttribute("role", "group");
      return control;
    };
    if (node.kind === "boolean") {
      const box = element("input", {
        type: "checkbox",
        id,
        onchange: ({ target }) => this.write(path, String(target.checked), true),
      });
      box.checked = node.value;
      return holder(true, box);
    }
    if (node.kind === "string") {
      const choices = this.schema().choices(path, this.toml);
      if (choices.length) return holder(true, this.choice(path, node, id, choices));
      if (this.isExpression(path)) return holder(false, this.equation(path, node, id, key, ""));
      const long = node.long || node.value.length > 44;
      const input = element(long ? "textarea" : "input", {
        type: long ? null : "text",
        id,
        rows: long ? 3 : null,
        value: node.value,
        oninput: ({ target }) => this.write(path, quoted(target.value), true),
      });
      return holder(true, input);
    }
    if (node.kind === "number") return holder(true, ...this.number(path, node, id, key));
    if (node.kind === "tables")
      return holder(
        false,
        node.items.map((item, k) => this.card(`${key} ${k + 1}`, [...path, k], () => true, item)),
      );
    if (node.kind === "array") {
      const { items } = node;
      const scalar = (item) => ["number", "string", "boolean"].includes(item.kind);
      if (items.length && items.every((item) => item.kind === "string") && this.isExpression(path))
        return holder(false, this.equations(path, items));
      if (items.length && items.every(scalar)) return holder(false, this.list(path, items));
      if (items.length && items.every((item) => item.kind === "array" && item.items.length && item.items.every(scalar)))
        return holder(false, this.matrix(path, items));
    }
    // What has no field of its own is its text.
    const input = element("textarea", {
      id,
      rows: 2,
      class: "code",
      value: this.toml.text.slice(node.from, node.to),
      onchange: ({ target }) => this.write(path, target.value, false),
    });
    return holder(true, input);
  }

  choice(path, node, id, choices) {
    const select = element(
      "select",
      { id, onchange: ({ target }) => this.write(path, quoted(target.value), false) },
      choices.map(({ value, description }) =>
        element("option", { value: String(value), title: description }, String(value)),
      ),
    );
    if (!choices.some(({ value }) => value === node.value))
      select.prepend(element("option", { value: node.value }, `${node.value} (unknown)`));
    select.value = node.value;
    return select;
  }

  // A number with a slider over a decade to either side, which stands in the middle again when it is released.
  number(path, node, id, key) {
    const cell = this.cell(path, node, id, key);
    if (
      !(node.value > 0) ||
      !Number.isFinite(node.value) ||
      !(path[0] === "observer" || path[1] === "parameters") ||
      this.schema()
        .at(path, this.toml)
        .some((schema) => schema.type === "integer")
    )
      return [cell];
    let base = node.value;
    const slider = element("input", {
      type: "range",
      min: -1,
      max: 1,
      step: 0.02,
      value: "0",
      id: `${id}-slider`,
      "aria-label": `${key}, from a tenth to ten times`,
      oninput: ({ target }) => {
        const value = Number((base * 10 ** Number(target.value)).toPrecision(4));
        target.setAttribute("aria-valuetext", String(value));
        cell.value = String(value);
        this.write(path, String(value), true);
      },
      onchange: ({ target }) => {
        const written = this.toml.get(path)?.value;
        if (written > 0) base = written;
        target.value = "0";
      },
    });
    return [cell, slider];
  }

  // A field for a number, or for an expression where one may stand.
  cell(path, node, id, name) {
    const texts = node.kind === "string" || this.schema().texts(path, this.toml);
    const shown = node.kind === "string" ? node.value : this.toml.text.slice(node.from, node.to);
    return element("input", {
      type: "text",
      class:
        node.kind !== "string"
          ? "cell"
          : NAMES.has(path.at(-2))
            ? "cell name"
            : node.value.length > 8
              ? "code"
              : "cell",
      id,
      "aria-label": name,
      value: shown,
      autocomplete: "off",
      spellcheck: "false",
      oninput: ({ target }) => {
        const text = target.value.trim();
        const fits = NUMBER.test(text) || (texts && text !== "");
        target.setAttribute("aria-invalid", String(!fits));
        target.title = fits ? "" : "Not a number: the text keeps the one before.";
        if (fits)
          this.write(
            path,
            NUMBER.test(text) && node.kind !== "string"
              ? text
              : NUMBER.test(text) && !this.onlyText(path)
                ? text
                : quoted(text),
            true,
          );
      },
      onkeydown: (event) => this.move(event),
    });
  }

  onlyText(path) {
    return this.schema()
      .at(path, this.toml)
      .every((schema) => schema.type === "string");
  }

  // Up and down go from row to row.
  move(event) {
    const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    const row = event.target.closest("tr");
    if (!step || !row) return;
    const cells = [...row.querySelectorAll("input")];
    const other = (step < 0 ? row.previousElementSibling : row.nextElementSibling)?.querySelectorAll("input")[
      cells.indexOf(event.target)
    ];
    if (!other) return;
    event.preventDefault();
    other.focus();
    other.select();
  }

  names(path) {
    const key = path.at(-1);
    const plant = (what) => this.toml.value(["plant", what]) ?? [];
    const states = plant("states"),
      inputs = plant("inputs"),
      outputs = plant("outputs");
    const name = (list, letter) => (k) => list[k] ?? `${letter}${k + 1}`;
    const state = name(states, "x"),
      input = name(inputs, "u"),
      output = name(outputs, "y");
    if (path[0] === "plant")
      return (
        { a: [state, state], b: [state, input], c: [output, state], d: [output, input], f: [state], h: [output] }[
          key
        ] ?? []
      );
    if (["x0", "initial", "scale"].includes(key)) return [state];
    if (path[0] === "input" && key === "expressions") return [input];
    return [];
  }

  list(path, items) {
    const [name] = this.names(path);
    const cells = items.map((item, k) =>
      item.kind === "boolean"
        ? element("code", {}, String(item.value))
        : this.cell([...path, k], item, this.identity([...path, k], "cell"), name?.(k) ?? `${path.at(-1)} ${k + 1}`),
    );
    return [
      cells.map((cell, k) => (name && cell.title === "" ? Object.assign(cell, { title: name(k) }) : cell)),
      path[0] === "plant" && NAMES.has(path[1]) ? null : this.ends(path, items),
    ];
  }

  // Buttons that make an array longer or shorter.
  ends(path, items) {
    const last = () => this.toml.text.slice(items.at(-1).from, items.at(-1).to);
    const key = path.at(-1);
    return [
      button("+", () => this.lengthen(path, last()), {
        class: "plain",
        id: this.identity(path, "more"),
        "aria-label": `One more in ${key}`,
        title: "One more",
      }),
      items.length > 1
        ? button("−", () => this.shorten(path), {
            class: "plain",
            id: this.identity(path, "less"),
            "aria-label": `One less in ${key}`,
            title: "One less",
          })
        : null,
    ];
  }

  // The change that appends an item to an array, in the layout of its items.
  appended(node, text) {
    const { items } = node;
    if (!items.length) return { from: node.from + 1, to: node.from + 1, insert: text };
    const last = items.at(-1);
    const before = items.length > 1 ? this.toml.text.slice(items.at(-2).to, last.from) : ", ";
    const gap = /\n/.test(before) ? (/\n[ \t]*$/.exec(before)?.[0] ?? "\n") : " ";
    return { from: last.to, to: last.to, insert: `,${gap}${text}` };
  }

  shortened(node, k = node.items.length - 1) {
    const { items } = node;
    if (k > 0) return { from: items[k - 1].to, to: items[k].to, insert: "" };
    return { from: items[0].from, to: items[1]?.from ?? items[0].to, insert: "" };
  }

  lengthen(path, text) {
    this.editor.edit(this.appended(this.toml.get(path), text));
  }

  shorten(path, k) {
    this.editor.edit(this.shortened(this.toml.get(path), k));
  }

  matrix(path, rows) {
    const [row, column] = this.names(path);
    const width = Math.max(...rows.map(({ items }) => items.length));
    const head = column
      ? element(
          "tr",
          {},
          element("th"),
          Array.from({ length: width }, (_, k) => element("th", { scope: "col" }, column(k))),
        )
      : null;
    const body = rows.map(({ items }, i) =>
      element(
        "tr",
        {},
        element("th", { scope: "row" }, row ? row(i) : ""),
        items.map((item, k) =>
          element(
            "td",
            {},
            this.cell(
              [...path, i, k],
              item,
              this.identity([...path, i, k], "cell"),
              `${path.at(-1)}, ${row ? row(i) : `row ${i + 1}`}, ${column ? column(k) : `column ${k + 1}`}`,
            ),
          ),
        ),
      ),
    );
    const sizes = path[0] === "plant" ? [] : this.ends(path, rows);
    return [element("div", { class: "grid" }, element("table", {}, head, body)), sizes];
  }

  isExpression(path) {
    const key = path.at(-1);
    return (
      (path[0] === "plant" && ["f", "h"].includes(key)) ||
      key === "expressions" ||
      (path[0] === "truth" && ["f", "h"].includes(key))
    );
  }

  equations(path, items) {
    const [name] = this.names(path);
    const key = path.at(-1);
    const dot = key === "f" ? (this.toml.get(["plant", "dt"]) ? "+" : "′") : "";
    const lines = items.map((item, k) =>
      this.equation(
        [...path, k],
        item,
        this.identity([...path, k], "line"),
        `${name?.(k) ?? `${key}${k + 1}`}${dot}`,
        key,
      ),
    );
    return [lines, path[0] === "plant" ? [] : this.ends(path, items)];
  }

  // A line with the formula below it.
  equation(path, node, id, name, key) {
    const place = element("div", { class: "typeset" });
    const draw = (text) => {
      const formula = typeset(text);
      const left = name.replace(/[′+]$/, "");
      const mover = key === "f" && name.endsWith("′");
      const first = mover
        ? mathName(left, (stem) => mathml("mover", stem, mathml("mo", "˙")))
        : key === "f" && name.endsWith("+")
          ? mathml("msup", mathml("mrow", mathName(left)), mathml("mo", "+"))
          : mathName(left);
      place.replaceChildren(
        formula
          ? math(mathml("mrow", first, mathml("mo", "="), formula))
          : element("span", { class: "small" }, "no formula yet"),
      );
    };
    draw(node.value);
    return element(
      "div",
      { class: "equation" },
      element("span", { class: "name" }, `${name} =`),
      element("input", {
        type: "text",
        class: "code",
        id,
        "aria-label": name,
        value: node.value,
        autocomplete: "off",
        spellcheck: "false",
        oninput: ({ target }) => {
          draw(target.value);
          this.write(path, quoted(target.value), true);
        },
      }),
      element("span"),
      place,
    );
  }

  // The plant, whose states, inputs and outputs come and go in all its matrices at once.
  plant(node) {
    const has = (key) => this.toml.get(["plant", key]);
    const sized = (has("a") && has("c")) || (has("f") && has("h"));
    const count = (what) =>
      ({ state: has("a") ?? has("f"), input: has("b")?.items?.[0], output: has("c") ?? has("h") })[what]?.items
        ?.length ?? 0;
    const one = (what) => [
      button(`+ ${what}`, () => this.resize(what, true), { id: `more-${what}` }),
      button("−", () => this.resize(what, false), {
        id: `less-${what}`,
        "aria-label": `One ${what} less`,
        disabled: count(what) <= (what === "input" ? 0 : 1),
      }),
    ];
    const linear = Boolean(has("a"));
    const actions = sized ? [one("state"), linear && has("b") ? one("input") : null, one("output")] : [];
    const switching = linear
      ? button("as equations", () => this.toEquations(), { title: "Writes x' = A x + B u as expressions" })
      : null;
    return this.card("Plant", ["plant"], () => true, node, { actions: [actions, switching] });
  }

  // One state, input or output more or less: in the matrices or equations, the names, x(0) and the expressions of inputs.
  resize(what, more) {
    const { toml } = this;
    const changes = [];
    const get = (...path) => toml.get(path);
    const append = (node, text) =>
      node &&
      node.kind === "array" &&
      changes.push(
        more
          ? this.appended(node, text)
          : node.items.length > 1
            ? this.shortened(node)
            : { from: node.from, to: node.to, insert: "[]" },
      );
    // A new row of a matrix has the new column, too, where both grow.
    const rows = (node, width) => append(node, `[${Array(width).fill("0").join(", ")}]`);
    const columns = (node, but) => node?.items?.slice(0, but).forEach((row) => append(row, "0"));
    const [a, b, c, d, f, h] = ["a", "b", "c", "d", "f", "h"].map((key) => get("plant", key));
    const n = (a ?? f)?.items.length ?? 0,
      m = b?.items?.[0]?.items?.length ?? 0,
      p = (c ?? h)?.items.length ?? 0;
    if (what === "state") {
      if (a) columns(a, more ? n : n - 1);
      rows(a, more ? n + 1 : n);
      if (b) rows(b, m);
      columns(c);
      if (f) append(f, quoted("0"));
      append(get("simulation", "x0"), "0");
      append(get("simulation", "scale"), "1");
      for (const [k] of (get("observer")?.items ?? []).entries()) {
        // What an observer has one of for each state.
        for (const [key, text] of [
          ["initial", "0"],
          ["w", "1"],
          ["p0", "1"],
          ["poles", null],
        ]) {
          const list = get("observer", k, key);
          if (list?.items?.length !== n || !list.items.every(({ kind }) => kind === "number")) continue;
          append(list, text ?? String(Math.min(...list.value) - (get("plant", "dt") ? 0 : 1)));
        }
      }
    } else if (what === "input") {
      columns(b);
      columns(d);
      append(get("input", "expressions"), quoted("0"));
    } else {
      if (c) rows(c, n);
      if (d) rows(d, m);
      if (h) append(h, quoted("0"));
    }
    const names = get("plant", `${what}s`);
    const count = { state: n, input: m, output: p }[what];
    const letter = { state: "x", input: "u", output: "y" }[what];
    if (names?.kind === "array") append(names, quoted(`${letter}${count + 1}`));
    this.editor.edit(changes.sort((one, other) => one.from - other.from));
  }

  // x' = A x + B u and y = C x + D u as expressions, in place of the matrices.
  toEquations() {
    const { toml } = this;
    const value = (key) => toml.value(["plant", key]);
    const named = (key, letter, count) => value(key) ?? Array.from({ length: count }, (_, k) => `${letter}${k + 1}`);
    const [a, b, c, d] = ["a", "b", "c", "d"].map(value);
    const states = named("states", "x", a.length),
      inputs = named("inputs", "u", b?.[0]?.length ?? 0);
    const known = (name) => /^[A-Za-z_][A-Za-z0-9_]*$/.test(name);
    const use = (names, letter) => names.map((name, k) => (known(name) ? name : `${letter}${k + 1}`));
    const sum = (row, names) =>
      (row ?? []).map((factor, k) =>
        factor === 0 ? "" : factor === 1 ? names[k] : factor === -1 ? `-${names[k]}` : `${factor}*${names[k]}`,
      );
    const lines = (one, two) =>
      one.map((row, i) => {
        const terms = [...sum(row, use(states, "x")), ...sum(two?.[i], use(inputs, "u"))].filter((term) => term);
        return quoted(terms.join(" + ").replace(/\+ -/g, "- ") || "0");
      });
    const block = (list) => `[\n${list.map((line) => `  ${line},\n`).join("")}]`;
    const member = (key) => toml.member(toml.get(["plant"]), key);
    const changes = [
      ["a", "f", lines(a, b)],
      ["c", "h", lines(c, d)],
    ].map(([key, other, list]) => ({
      from: member(key).keyFrom,
      to: member(key).node.to,
      insert: `${other} = ${block(list)}`,
    }));
    for (const key of ["b", "d"]) {
      if (member(key)) changes.push(this.lineOf(member(key).keyFrom, member(key).node.to));
    }
    // Inputs without names have those of the matrices.
    this.editor.edit(changes.sort((one, other) => one.from - other.from));
  }

  // A statement with its line, where nothing else stands on it.
  lineOf(from, to) {
    const { text } = this.toml;
    const start = text.lastIndexOf("\n", from - 1) + 1;
    const end = this.toml.lineEnd(to);
    const alone = /^\s*$/.test(text.slice(start, from)) && /^\s*(#.*)?$/.test(text.slice(to, end));
    return alone ? { from: start, to: Math.min(end + 1, text.length), insert: "" } : { from, to, insert: "" };
  }

  removeKey(path) {
    const { toml } = this;
    const parent = toml.get(path.slice(0, -1));
    const k = parent.members.findIndex(({ key }) => key === path.at(-1));
    const member = parent.members[k];
    if (!parent.inline) {
      if (member.node.kind === "table" && member.node.header) return this.removeTable(path);
      return this.editor.edit(this.lineOf(member.keyFrom, member.node.to));
    }
    const before = parent.members[k - 1],
      after = parent.members[k + 1];
    if (before) return this.editor.edit({ from: before.node.to, to: member.node.to, insert: "" });
    return this.editor.edit({ from: member.keyFrom, to: after ? after.keyFrom : member.node.to, insert: "" });
  }

  // The lines from the header of a table to the next one that is not below it; comments above a header are its own.
  extent(path) {
    const { toml } = this;
    const { text } = toml;
    const own = toml.get(path).header;
    if (!own) return null;
    const within = (header) => header.path.length > path.length && same(header.path.slice(0, path.length), path);
    const next = toml.headers.find((header) => header.from > own.from && !within(header));
    const above = (place) => {
      let start = text.lastIndexOf("\n", place - 1) + 1;
      while (start > 0) {
        const before = text.lastIndexOf("\n", start - 2) + 1;
        if (!/^[ \t]*#/.test(text.slice(before, start))) break;
        start = before;
      }
      return start;
    };
    return { from: above(own.from), to: next ? above(next.from) : text.length };
  }

  removeTable(path) {
    const { toml } = this;
    const node = toml.get(path);
    const header = node.kind === "tables" ? null : this.extent(path);
    if (header) return this.editor.edit({ ...header, insert: "" });
    if (node.inline) return this.removeKey(path);
    return undefined;
  }

  // Where a new key of a table goes: behind its last one, before the tables below it.
  insertKey(path, key, value) {
    const { toml } = this;
    const table = toml.get(path);
    const line = `${keyText(key)} = ${value}`;
    if (table.inline) {
      const last = table.members.at(-1);
      const change = last
        ? { from: last.node.to, insert: `, ${line}` }
        : { from: table.from, to: table.to, insert: `{ ${line} }` };
      return this.editor.edit(change);
    }
    const direct = table.members.filter(({ node }) => !(node.header || node.kind === "tables"));
    const end = direct.length ? Math.max(...direct.map(({ node }) => node.to)) : (table.header?.to ?? 0);
    const place = toml.lineEnd(end);
    const start = !direct.length && !table.header;
    return this.editor.edit({ from: start ? 0 : place, insert: start ? `${line}\n` : `\n${line}` });
  }

  addKey(path, table, what) {
    const there = new Set((table.members ?? []).map(({ key }) => key));
    const free = this.isFree(path);
    const keys = this.schema()
      .keys(path, this.toml)
      .filter(
        ({ name, schema }) =>
          !there.has(name) && name !== "$schema" && (path.length || !["object", "array"].includes(schema.type)),
      );
    if (free) return this.addNamed(path);
    if (!keys.length) return null;
    const select = element(
      "select",
      { id: this.identity(path, "add"), "aria-label": `Add a key to ${what}` },
      element("option", { value: "" }, "add a key …"),
      keys.map(({ name, schema, required }) =>
        element("option", { value: name, title: schema.description }, required ? `${name} (required)` : name),
      ),
    );
    return element(
      "div",
      { class: "line" },
      picker(select, (chosen) =>
        this.insertKey(
          path,
          chosen,
          this.fresh(
            path,
            keys.find(({ name }) => name === chosen),
          ),
        ),
      ),
    );
  }

  // A table whose keys are names, such as `parameters`.
  isFree(path) {
    return this.schema()
      .at(path, this.toml)
      .some((schema) => [schema, ...(schema.anyOf ?? [])].some((one) => typeof one.additionalProperties === "object"));
  }

  addNamed(path) {
    const id = this.identity(path, "name");
    const add = () => {
      const name = at(id).value.trim();
      const schema = this.schema().at([...path, name], this.toml)[0];
      if (name && !this.toml.get([...path, name]))
        this.insertKey(path, name, schema ? this.schema().template(schema) : "1");
    };
    const input = element("input", {
      type: "text",
      id,
      placeholder: "name",
      "aria-label": `Name of what is added to ${path.at(-1)}`,
      size: 10,
      onkeydown: (event) => event.key === "Enter" && add(),
    });
    return element("div", { class: "line" }, input, button("Add", add));
  }

  // The value of a new key, with as many entries as there are states, inputs or outputs.
  fresh(path, { name, schema }) {
    const { toml } = this;
    const states = (toml.get(["plant", "a"]) ?? toml.get(["plant", "f"]) ?? toml.get(["plant", "states"]))?.items
      ?.length;
    const outputs = (toml.get(["plant", "c"]) ?? toml.get(["plant", "h"]))?.items?.length;
    const inputs = toml.get(["plant", "b"])?.items?.[0]?.items?.length;
    const row = (length, value) => (length ? `[${Array(length).fill(value).join(", ")}]` : null);
    const known = {
      x0: row(states, "0"),
      initial: row(states, "0"),
      scale: row(states, "1"),
      p0: row(states, "1"),
      states: row(states, '""'),
      poles: states ? `[${Array.from({ length: states }, (_, k) => -1 - k).join(", ")}]` : null,
      expressions: row(inputs, '"0"'),
      duration: "10",
      w: path[0] === "observer" ? row(states, "1") : null,
      v: path[0] === "observer" ? row(outputs, "1") : null,
    }[name];
    return known ?? this.schema().template(schema);
  }

  // What can be added to the study: an observer of a kind, or a table.
  adding() {
    const { toml } = this;
    const kinds = this.schema().choices(["observer", 0, "kind"], null);
    const observer = element(
      "select",
      { id: "add-observer", "aria-label": "Add an observer" },
      element("option", { value: "" }, "add an observer …"),
      kinds.map(({ value, description }) => element("option", { value, title: description }, value)),
    );
    const there = new Set(toml.root.members.map(({ key }) => key));
    const tables = this.schema()
      .keys([], toml)
      .filter(({ name, schema }) => schema.type === "object" && !there.has(name));
    const table = element(
      "select",
      { id: "add-table", "aria-label": "Add a table" },
      element("option", { value: "" }, "add a table …"),
      tables.map(({ name, schema }) => element("option", { value: name, title: schema.description }, name)),
    );
    picker(observer, (kind) => this.addObserver(kind));
    picker(table, (chosen) => {
      const { schema } = tables.find(({ name }) => name === chosen);
      const needed = (schema.required ?? []).map(
        (key) => `${key} = ${this.fresh([chosen], { name: key, schema: schema.properties[key] })}\n`,
      );
      this.append(`[${chosen}]\n${needed.join("")}`);
    });
    return element("div", { class: "line" }, observer, tables.length ? table : null);
  }

  append(text) {
    const before = this.toml.text;
    this.editor.edit({
      from: before.length,
      insert: `${!before || before.endsWith("\n\n") ? "" : before.endsWith("\n") ? "\n" : "\n\n"}${text}`,
    });
  }

  addObserver(kind) {
    const { toml } = this;
    const items = toml.get(["observer"])?.items ?? [];
    const names = new Set(items.map((_, k) => toml.value(["observer", k, "name"])));
    let name = kind;
    for (let k = 2; names.has(name); k++) name = `${kind} ${k}`;
    const variant = this.schema()
      .untagged(["observer", 0])
      .flatMap((schema) => schema.oneOf ?? [])
      .find(({ properties }) => properties?.kind?.const === kind);
    const needed = (variant?.required ?? []).filter((key) => !["name", "kind"].includes(key));
    // The usual way to choose a gain, where a kind leaves it open.
    if (!needed.length && variant?.properties?.poles) needed.push("poles");
    else if (variant?.properties?.w && variant?.properties?.v)
      for (const key of ["w", "v"]) if (!needed.includes(key)) needed.push(key);
    const lines = needed.map(
      (key) => `${key} = ${this.fresh(["observer", items.length], { name: key, schema: variant.properties[key] })}\n`,
    );
    const text = `[[observer]]\nname = ${quoted(name)}\nkind = ${quoted(kind)}\n${lines.join("")}`;
    if (!items.length) return this.append(text);
    const extent = this.extent(["observer", items.length - 1]);
    const before = toml.text.slice(0, extent.to);
    const gap = before.endsWith("\n\n") ? "" : before.endsWith("\n") ? "\n" : "\n\n";
    return this.editor.edit({ from: extent.to, insert: `${gap}${text}${extent.to < toml.text.length ? "\n" : ""}` });
  }
}

// ---- Workers ----

// A worker with the module. A request that is cancelled ends its worker; the next one starts another.
class Engine {
  constructor(compiled) {
    this.compiled = compiled;
    this.count = 0;
    this.pending = new Map();
    this.sent = new Map();
  }

  start() {
    this.address ??= URL.createObjectURL(new Blob([at("worker").textContent], { type: "text/javascript" }));
    this.worker = new Worker(this.address);
    this.worker.onmessage = ({ data }) => this.answered(data);
    this.worker.onerror = (event) => this.broken(event.message || "the worker ended");
    this.worker.postMessage({ compiled: this.compiled });
    this.sent = new Map();
  }

  // The answer to a request. `named` are the files that the worker keeps from request to request.
  async ask(json, { files = [], named = null, progress = null } = {}) {
    if (!this.worker) this.start();
    const forget = named ? [...this.sent.keys()].filter((name) => !named.has(name)) : [];
    for (const name of forget) this.sent.delete(name);
    named ??= new Map();
    const keep = [...named]
      .filter(([name, bytes]) => this.sent.get(name) !== bytes)
      .map(([name, bytes]) => ({ name, bytes }));
    for (const { name, bytes } of keep) this.sent.set(name, bytes);
    const id = ++this.count;
    const answer = new Promise((done, fail) => this.pending.set(id, { done, fail, progress }));
    try {
      this.worker.postMessage({ id, json, files, keep, forget, names: [...named.keys()] });
    } catch (error) {
      this.pending.delete(id);
      throw new Error(`The page has not enough memory for this: ${error.message}`);
    }
    return answer;
  }

  answered({ id, json, files, progress, failure, panicked, memory }) {
    const request = this.pending.get(id);
    if (!request) return;
    if (progress) {
      request.progress?.(progress);
      return;
    }
    this.pending.delete(id);
    if (failure === undefined) {
      request.done({ json, files });
      return;
    }
    const large = memory > 1e9;
    const words = panicked
      ? `The program stopped with an error of its own: ${failure}`
      : large || /memory|allocat/i.test(failure)
        ? `The run outgrew the memory of the page (${size(memory)} used).`
        : `The program stopped: ${failure}`;
    request.fail(new Error(`${words} The page goes on; the study is as it was.`));
    // The memory that the instance grew to goes with its worker.
    this.stop();
  }

  broken(message) {
    for (const { fail } of this.pending.values())
      fail(new Error(`The worker stopped: ${message}. The page goes on; the study is as it was.`));
    this.stop();
  }

  stop() {
    this.worker?.terminate();
    this.worker = null;
    for (const { fail } of this.pending.values()) fail(null);
    this.pending.clear();
  }

  get busy() {
    return this.pending.size > 0;
  }
}

// ---- The page ----

const STORED = "luenberger-studio";
const LIMITS = { study: 2e6, log: 64e6, stored: 1.5e6, link: 2e6, certificate: 16e6 };
// A run that takes longer is asked for, in seconds.
const LONG = 20;
// The chip that is about no observer: no name has a line break.
const WARNINGS = "\n";
const TONES = { proved: "good", refuted: "bad" };
const LANGUAGES = { c: "C", rust: "Rust", fmu2: "FMU (FMI 2.0)", fmu3: "FMU (FMI 3.0)" };

class Studio {
  constructor() {
    Object.assign(this, {
      name: "study.toml",
      files: new Map(),
      about: null,
      checked: null,
      results: null,
      outputs: [],
      version: 0,
      ranVersion: -1,
      saved: "",
      running: null,
      cursor: null,
      chosen: null,
      errors: 0,
      form: null,
    });
    this.ready = new Promise((done) => {
      this.isReady = done;
    });
  }

  async start() {
    this.theme();
    this.wire();
    const first = this.restore();
    try {
      await this.load();
    } catch (error) {
      this.status(error.message, true);
      this.banner(`${error.message} The study can be edited and saved here, not run.`, "bad");
      await this.followLink();
      return;
    }
    if (first) this.begin(this.about.templates[0], first);
    await this.followLink();
    at("run").disabled = at("zip").disabled = false;
    this.check();
    this.isReady();
  }

  // The module, and what it says of itself.
  async load() {
    if (typeof WebAssembly !== "object") throw new Error("This browser has no WebAssembly.");
    if (typeof DecompressionStream !== "function")
      throw new Error("This browser cannot decompress (DecompressionStream): it is older than 2023.");
    const packed = packedBytes(at("module").textContent);
    at("module").textContent = "";
    let compiled;
    try {
      compiled = await WebAssembly.compile(await through(packed, new DecompressionStream("gzip"), 2e8));
    } catch (error) {
      throw new Error(`The program in this page does not load: ${error.message}.`);
    }
    [this.checker, this.runner] = [new Engine(compiled), new Engine(compiled)];
    const { json, files } = await this.checker.ask({ do: "about" });
    this.about = json;
    this.templateFiles = files;
    this.schema = new Schema(json.schema);
    at("version").textContent = json.version ?? "";
    for (const { name, title, about } of json.templates) {
      at("template").append(element("option", { value: name, title: about ?? title }, name));
    }
    this.form.draw();
  }

  wire() {
    this.editor = new StudyEditor(at("editor"), {
      changed: (update) => this.changed(update),
      schema: () => this.schema,
      run: () => this.run({ asked: true }),
      save: () => this.save(),
    });
    this.form = {
      draw: () => {
        if (at("panel-form").hidden || !this.schema) return;
        if (this.format === "json")
          at("panel-form").replaceChildren(element("p", {}, "The form is for studies in TOML; this one is JSON."));
        else (this.fields ??= new Form(at("panel-form"), this.editor, () => this.schema)).draw();
      },
    };
    panels(document.querySelector("#study [role=tablist]"), () => this.form.draw());
    this.showTab = panels(document.querySelector("#results [role=tablist]"));
    this.showSide = tabs(document.querySelector(".sides"), (tab) => {
      document.body.dataset.side = tab.id.slice(5);
    });
    const on = (id, act) => at(id).addEventListener("click", act);
    on("open", () => this.choose());
    on("save", () => this.save());
    on("zip", () => this.zip());
    on("link", () => this.copyLink());
    on("clear", () => this.clear());
    on("run", () => this.run({ asked: true }));
    on("cancel", () => this.cancel("The run was cancelled; the results are those of the run before."));
    on("undo", () => Editor.undo(this.editor.view));
    on("redo", () => Editor.redo(this.editor.view));
    at("auto").addEventListener("change", () => {
      this.keep();
      if (at("auto").checked) this.check();
    });
    picker(at("template"), (chosen) => this.template(this.about.templates.find(({ name }) => name === chosen)));
    at("theme").addEventListener("change", () => {
      this.theme(at("theme").value);
      this.keep();
    });
    at("file").addEventListener("change", async ({ target }) => {
      const files = [...target.files];
      target.value = "";
      await this.take(files);
    });
    this.divider();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.theme(at("theme").value));
    for (const skip of document.querySelectorAll(".skip")) {
      skip.addEventListener("click", (event) => {
        event.preventDefault();
        const side = skip.getAttribute("href").slice(1);
        this.showSide(at(`side-${side}`), false);
        at(side).focus();
      });
    }
    addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.defaultPrevented) return;
      if (event.key === "s") {
        event.preventDefault();
        this.save();
      } else if (event.key === "Enter") {
        event.preventDefault();
        this.run({ asked: true });
      } else if (["z", "y"].includes(event.key.toLowerCase()) && at("panel-form").contains(event.target)) {
        // In the form, too, undo is that of the document.
        event.preventDefault();
        const back = event.key.toLowerCase() === "z" && !event.shiftKey;
        (back ? Editor.undo : Editor.redo)(this.editor.view);
      }
    });
    addEventListener("dragover", (event) => {
      event.preventDefault();
      document.body.classList.add("dragging");
    });
    addEventListener("dragleave", (event) => {
      if (!event.relatedTarget) document.body.classList.remove("dragging");
    });
    addEventListener("drop", (event) => {
      event.preventDefault();
      document.body.classList.remove("dragging");
      this.take([...event.dataTransfer.files]);
    });
    addEventListener("hashchange", () => this.followLink());
    addEventListener("pagehide", () => this.keep());
    document.addEventListener("visibilitychange", () => {
      if (document.visibilityState === "hidden") this.keep();
    });
    addEventListener("beforeunload", (event) => {
      // Where nothing can be stored, closing would lose what was typed.
      if (this.stored === false && this.editor.text !== this.saved) event.preventDefault();
    });
    addEventListener("beforeprint", () => {
      at("print").replaceChildren(
        element("h1", {}, this.results?.results?.title ?? "Study"),
        element("pre", {}, this.results?.summary ?? ""),
        element("h2", {}, this.name),
        element("pre", {}, this.editor.text),
      );
    });
    this.drawResults();
    this.drawLogs();
  }

  // The border between the sides, moved with the mouse or with arrow keys.
  divider() {
    const divider = at("divider");
    const place = (percent) => {
      const share = Math.min(Math.max(percent, 20), 80);
      document.documentElement.style.setProperty("--share", `${share}%`);
      divider.setAttribute("aria-valuenow", String(Math.round(share)));
      return share;
    };
    let share = 42;
    divider.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -2, ArrowRight: 2 }[event.key];
      if (!step) return;
      event.preventDefault();
      share = place(share + step);
    });
    divider.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      divider.setPointerCapture(event.pointerId);
    });
    divider.addEventListener("pointermove", (event) => {
      if (divider.hasPointerCapture(event.pointerId)) share = place((100 * event.clientX) / innerWidth);
    });
    divider.addEventListener("dblclick", () => {
      share = place(42);
    });
  }

  get format() {
    return this.name.endsWith(".json") ? "json" : "toml";
  }

  // ---- Messages ----

  status(text, bad = false) {
    at("status").textContent = text;
    at("status").classList.toggle("bad", bad);
  }

  banner(text, tone = "", actions = []) {
    const banner = element(
      "p",
      { class: `banner ${tone}`, role: tone === "bad" ? "alert" : "status" },
      element("span", {}, text),
      actions,
      button("×", () => banner.remove(), { class: "plain", "aria-label": "Close this message" }),
    );
    // One that only tells something gives way to the next.
    for (const other of [...at("banners").children]) if (!other.classList.contains("bad")) other.remove();
    const all = at("banners").children;
    if (all.length > 2) all[0].remove();
    at("banners").append(banner);
    return banner;
  }

  theme(chosen = at("theme").value) {
    const dark = chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    for (const frame of document.querySelectorAll("iframe")) frame.style.colorScheme = dark ? "dark" : "light";
    this.editor?.dark(dark);
    this.isDark = dark;
  }

  // ---- What the browser keeps ----

  // Whether the page is new to this browser; otherwise the study is as it was left.
  restore() {
    this.theme();
    let text = null;
    try {
      text = localStorage.getItem(STORED);
      this.stored = true;
    } catch {
      this.stored = false;
    }
    try {
      const kept = JSON.parse(text ?? "null");
      if (typeof kept?.text !== "string") return "first";
      at("theme").value = kept.theme ?? "";
      at("auto").checked = kept.auto !== false;
      this.theme();
      this.name = String(kept.name ?? "study.toml");
      for (const [name, text] of Object.entries(kept.files ?? {})) this.files.set(name, encode(text));
      this.editor.begin(kept.text);
      this.language();
      this.saved = kept.saved ?? "";
      if (kept.left?.length)
        this.banner(`Not kept, being large: ${kept.left.join(", ")}. Choose the file again under Log.`);
      this.drawLogs();
      return null;
    } catch {
      return "first";
    }
  }

  keep() {
    clearTimeout(this.keeping);
    if (!this.editor.text && !this.about) return;
    const files = {},
      left = [];
    let sum = this.editor.text.length;
    for (const [name, bytes] of this.files) {
      sum += bytes.length;
      if (sum < LIMITS.stored) files[name] = decode(bytes);
      else left.push(name);
    }
    const kept = {
      text: this.editor.text,
      name: this.name,
      files,
      left,
      saved: this.saved.length < 1e5 ? this.saved : "",
      theme: at("theme").value,
      auto: at("auto").checked,
    };
    try {
      if (this.cleared === this.editor.text) return;
      localStorage.setItem(STORED, JSON.stringify(kept));
      this.stored = true;
    } catch {
      if (this.stored !== false)
        this.banner("This browser does not keep the study (its storage is full or denied): save it as a file.");
      this.stored = false;
    }
  }

  clear() {
    try {
      localStorage.removeItem(STORED);
    } catch {
      // What cannot be written holds nothing either.
    }
    this.cleared = this.editor.text;
    this.banner(
      "Nothing of this page is stored in the browser any more. The study stays here until you close it, and is stored again when you change it.",
    );
  }

  begin(template, how) {
    this.name = `${template.name}.toml`;
    this.addTemplateFiles(template);
    this.editor.begin(template.text);
    this.saved = template.text;
    this.form.draw();
    if (how === "first") {
      this.banner(
        "This is a study: a plant, a run and some observers for it, as text or as a form. Its results follow what you write. Nothing leaves this page.",
      );
    }
  }

  addTemplateFiles({ name }) {
    for (const file of this.templateFiles) {
      if (file.name.startsWith(`${name}/`)) this.files.set(file.name.slice(name.length + 1), file.bytes);
    }
    this.drawLogs();
  }

  template(template) {
    this.addTemplateFiles(template);
    this.show(template.text, `${template.name}.toml`);
    this.saved = template.text;
    this.banner(`${template.name}: ${template.about ?? template.title}. Undo brings back the study before.`);
  }

  // Another study in place of this one, which undo brings back.
  show(text, name) {
    this.name = name;
    this.language();
    this.editor.replace(text);
  }

  language() {
    const language = this.format === "json" ? [] : Editor.StreamLanguage.define(Editor.toml);
    this.editor.view.dispatch({ effects: this.editor.language.reconfigure(language) });
  }

  // ---- Files ----

  choose(accept) {
    at("file").accept = accept ?? ".toml,.json,.csv,.txt,.tsv";
    at("file").click();
  }

  // Files that were chosen or dropped: a study, logs, certificates.
  async take(files) {
    for (const file of files) {
      const { name } = file;
      try {
        if (/\.(csv|tsv|txt|dat)$/i.test(name)) await this.addLog(file);
        else if (/\.toml$/i.test(name)) await this.openStudy(file);
        else if (/\.json$/i.test(name)) await this.openJson(file);
        else this.banner(`${name}: neither a study (.toml, .json) nor a log (.csv) nor a certificate (.json).`, "bad");
      } catch (error) {
        this.banner(`${name}: ${error.message}`, "bad");
      }
    }
  }

  async read(file, most, what) {
    if (file.size > most)
      throw new Error(`it has ${size(file.size)}; ${what} may have ${size(most)} here. Nothing was changed.`);
    return new Uint8Array(await file.arrayBuffer());
  }

  async openStudy(file) {
    const bytes = await this.read(file, LIMITS.study, "a study");
    let text;
    try {
      text = new TextDecoder("utf-8", { fatal: true }).decode(bytes);
    } catch {
      throw new Error("it is not a text in UTF-8.");
    }
    this.show(text, file.name);
    this.saved = text;
  }

  async openJson(file) {
    const bytes = await this.read(file, LIMITS.certificate, "a file of JSON");
    let value;
    try {
      value = JSON.parse(decode(bytes));
    } catch (error) {
      throw new Error(`it is not JSON: ${error.message}`);
    }
    if (value && typeof value === "object" && "plant" in value && !("sha256" in value)) await this.openStudy(file);
    else await this.verify([{ name: file.name, bytes }]);
  }

  save() {
    download(this.name, encode(this.editor.text), "text/plain");
    this.saved = this.editor.text;
    this.keep();
    this.status(`${this.name} is saved.`);
  }

  // ---- Check and run ----

  request(what, more = {}) {
    return { do: what, name: this.name, study: this.editor.text, format: this.format, ...more };
  }

  changed(update) {
    this.version++;
    at("undo").disabled = Editor.undoDepth(this.editor.view.state) === 0;
    at("redo").disabled = Editor.redoDepth(this.editor.view.state) === 0;
    if (this.running?.of === "study") this.cancel("The study has changed: the run was stopped.");
    at("question").hidden = true;
    this.stale();
    clearTimeout(this.keeping);
    this.keeping = setTimeout(() => this.keep(), 400);
    clearTimeout(this.checking);
    this.checking = setTimeout(() => this.check(), 200);
    if (!update.transactions.some((transaction) => transaction.annotation(external))) {
      clearTimeout(this.drawing);
      this.drawing = setTimeout(() => this.form.draw(), 0);
    }
  }

  // What is wrong with the text, and what it would cost to run it.
  async check() {
    clearTimeout(this.checking);
    if (!this.checker) return;
    const { version } = this;
    const text = this.editor.text;
    if (text.length > LIMITS.study) {
      this.status(
        `The study has ${size(text.length)}; here it may have ${size(LIMITS.study)}. It is kept, and can be saved.`,
        true,
      );
      return;
    }
    if (this.asking) {
      this.again = true;
      return;
    }
    this.asking = true;
    let answer = null;
    try {
      answer = await this.checker.ask(this.request("check"), { named: this.files });
    } catch (error) {
      if (error) this.status(error.message, true);
    }
    this.asking = false;
    if (this.again || version !== this.version) {
      this.again = false;
      if (version !== this.version) this.check();
      else if (answer) this.judge(answer.json, text);
      return;
    }
    if (answer) this.judge(answer.json, text);
  }

  judge(checked, text) {
    this.checked = checked;
    const found = [...(checked.diagnostics ?? []), ...(checked.error?.diagnostics ?? [])];
    this.mistakes(found, checked.error?.message ?? null, text);
    this.drawExport();
    if (checked.title) document.title = `${checked.title} – luenberger studio`;
    clearTimeout(this.starting);
    if (this.errors) {
      this.status(this.results ? "The results are those of the study before the mistake." : "The study has a mistake.");
      return;
    }
    if (this.ranVersion === this.version || !at("auto").checked) {
      if (!at("auto").checked && this.ranVersion !== this.version) this.status(`Ready to run${this.cost()}.`);
      return;
    }
    const seconds = checked.estimate?.seconds ?? 0;
    if (seconds > LONG) this.question(checked.estimate);
    else this.starting = setTimeout(() => this.run(), 250);
  }

  cost() {
    const words = this.checked?.estimate?.in_words;
    return words ? ` (${words})` : "";
  }

  question({ in_words: words }) {
    at("question").replaceChildren(
      element("span", {}, `This run would take ${words}.`),
      button("Run it", () => this.run({ asked: true }), { class: "primary" }),
      button("Not now", () => {
        at("question").hidden = true;
        at("run").focus();
      }),
    );
    at("question").hidden = false;
    this.status("A long run waits for you.");
  }

  mistakes(found, message, text) {
    const place = places(text);
    const shown = found.map((mistake) => {
      const from = place(mistake.from ?? 0);
      let to = Math.max(place(mistake.to ?? 0), from);
      if (to === from && to < text.length && text[to] !== "\n") to++;
      const says = [mistake.message, mistake.expected, mistake.help].filter((part) => part);
      return {
        from,
        to,
        severity: mistake.severity === "warning" ? "warning" : "error",
        message: says.join("\n"),
        mistake,
      };
    });
    shown.sort((one, other) => one.from - other.from);
    if (text === this.editor.text) this.editor.show(shown);
    const errors = shown.filter(({ severity }) => severity === "error");
    this.errors = errors.length || (message && !found.length ? 1 : 0);
    const line = (offset) => text.slice(0, offset).split("\n").length;
    const items = shown.map(({ from, to, severity, mistake }) =>
      element(
        "li",
        {},
        element("span", { class: severity === "error" ? "badge bad" : "badge open" }, severity),
        " ",
        button(
          `line ${mistake.line ?? line(from)}`,
          () => {
            this.toText();
            this.editor.go(from, to);
          },
          { class: "plain" },
        ),
        " ",
        mistake.message,
        mistake.expected ? element("span", { class: "help" }, `: ${mistake.expected}`) : null,
        mistake.help ? element("span", { class: "help" }, `; ${mistake.help}`) : null,
      ),
    );
    const words = this.errors === 1 ? "One mistake" : `${this.errors} mistakes`;
    const head =
      this.errors || shown.length
        ? [
            element(
              "p",
              { role: "status" },
              this.errors ? `${words}: the study does not run as it is.` : "The study runs, with warnings.",
            ),
          ]
        : [];
    const alone = message && !found.length ? [element("p", {}, message)] : [];
    alone.push(
      ...(this.checked?.warnings ?? []).map((warning) =>
        element("p", {}, element("span", { class: "badge open" }, "warning"), ` ${warning}`),
      ),
    );
    at("mistakes").replaceChildren(...head, ...alone, ...(items.length ? [element("ul", {}, items)] : []));
  }

  toText() {
    at("tab-text").click();
    this.showSide(at("side-study"), false);
  }

  // Runs a request in the worker of runs, with its progress shown; null if it was stopped or failed.
  async work(of, what, request, options = {}) {
    if (this.runner.busy) this.cancel("");
    const token = { of };
    this.running = token;
    this.status(`${what} …`);
    at("cancel").hidden = false;
    at("progress").hidden = false;
    at("progress").classList.add("unknown");
    at("progress").removeAttribute("aria-valuenow");
    const began = performance.now();
    try {
      const answer = await this.runner.ask(request, {
        ...options,
        progress: (progress) => {
          if (this.running === token) this.progress(what, progress, began);
        },
      });
      if (this.running !== token) return null;
      return { ...answer, seconds: (performance.now() - began) / 1000 };
    } catch (error) {
      if (error && this.running === token) this.status(error.message, true);
      if (error) this.banner(error.message, "bad");
      return null;
    } finally {
      if (this.running === token) this.idle();
    }
  }

  progress(what, { stage, what: subject, done, of }, began) {
    const known = of > 0;
    const bar = at("progress");
    bar.classList.toggle("unknown", !known);
    if (known) {
      const percent = Math.round((100 * done) / of);
      bar.setAttribute("aria-valuenow", String(percent));
      bar.firstElementChild.style.width = `${percent}%`;
    }
    // Once a second is often enough to be read or heard.
    const now = performance.now();
    if (now - (this.told ?? 0) < 900 && now - began > 900) return;
    this.told = now;
    this.status(`${what}: ${[stage, subject].filter((part) => part).join(", ")}${known ? `, ${done} of ${of}` : ""} …`);
  }

  idle() {
    this.running = null;
    at("cancel").hidden = at("progress").hidden = true;
    at("progress").firstElementChild.style.width = "";
  }

  cancel(words) {
    this.runner?.stop();
    this.idle();
    if (words) this.status(words);
  }

  async run({ asked = false } = {}) {
    if (!this.runner) return;
    clearTimeout(this.starting);
    at("question").hidden = true;
    const { version } = this;
    const answer = await this.work(
      "study",
      asked ? `Running${this.cost()}` : "Running",
      this.request("run", { step: "run", figures: false }),
      { named: this.files },
    );
    if (!answer) return;
    const { json, files, seconds } = answer;
    if (json.error) {
      this.failed(json);
      return;
    }
    this.ranVersion = version;
    this.results = json;
    this.outputs = files;
    this.status(
      `${json.stopped ? `Stopped: ${json.stopped}` : "Done"} in ${seconds < 10 ? seconds.toPrecision(2) : Math.round(seconds)} s.`,
    );
    this.drawResults();
    this.stale();
  }

  failed({ error, rendered }) {
    this.status(error.message, true);
    if (error.diagnostics?.length) this.mistakes(error.diagnostics, null, this.editor.text);
    if (!this.results)
      at("panel-summary").replaceChildren(element("pre", { class: "said" }, rendered || error.message));
  }

  // ---- Results ----

  stale() {
    const old = this.results !== null && this.ranVersion !== this.version;
    this.frames?.classList.toggle("stale", old);
    if (this.bar) this.bar.textContent = old ? "of an earlier version of the study" : "";
  }

  drawResults() {
    this.drawChips();
    this.drawReport();
    this.drawSummary();
    this.drawCertificates();
    this.drawFiles();
    this.drawExport();
  }

  drawChips() {
    const results = this.results?.results;
    const rows = [...(results?.simulation?.rows ?? []), ...(results?.log?.rows ?? [])];
    const chips = (results?.observers ?? []).map((observer) => {
      const { name, design, failure } = observer;
      const word =
        failure || !design ? "not applicable" : design.verdict === "none" ? "no certificate" : design.verdict;
      const tone = failure || !design ? "failed" : (TONES[design.verdict] ?? "open");
      const ended = rows.find((row) => row.observer === name && row.failure)?.failure;
      const chip = button("", () => this.choice(observer, ended), {
        class: `chip ${ended ? "failed" : tone}`,
        "aria-expanded": "false",
        "aria-controls": "chosen",
        "data-of": name,
      });
      chip.append(
        name,
        element("span", { class: `badge ${tone}` }, word),
        ended ? element("span", { class: "badge failed" }, "ended early") : "",
      );
      return chip;
    });
    const warnings = this.results?.warnings ?? results?.warnings ?? [];
    if (warnings.length) {
      const text = warnings.length === 1 ? "one warning" : `${warnings.length} warnings`;
      chips.push(
        button(
          text,
          () =>
            this.explain(WARNINGS, [
              element(
                "ul",
                {},
                warnings.map((warning) => element("li", {}, String(warning.message ?? warning))),
              ),
            ]),
          { class: "chip open", "aria-expanded": "false", "aria-controls": "chosen", "data-of": WARNINGS },
        ),
      );
    }
    at("chips").replaceChildren(...chips);
    const still = (results?.observers ?? []).find(({ name }) => name === this.chosen);
    this.chosen = still?.name ?? null;
    at("chosen").hidden = !still;
    if (still) this.choice(still, rows.find((row) => row.observer === still.name && row.failure)?.failure, true);
  }

  // What is said of an observer; once more closes it.
  choice({ name, kind, design, failure }, ended, again = false) {
    const parts = [element("p", {}, element("strong", {}, name), ` (${kind})`)];
    if (ended) parts.push(element("p", {}, `Its run ended early: ${ended}`));
    if (failure) {
      parts.push(element("p", {}, failure.hypothesis));
      const advice = [
        ...(failure.alternatives ?? []).map((text) => `alternative: ${text}`),
        ...(failure.hints ?? []).map((text) => `hint: ${text}`),
      ];
      if (advice.length)
        parts.push(
          element(
            "ul",
            {},
            advice.map((text) => element("li", {}, text)),
          ),
        );
      if (failure.line) parts.push(button(`to line ${failure.line}`, () => this.toLine(failure.line)));
    } else if (design) {
      parts.push(element("p", {}, design.statement));
      const open = (design.facts ?? []).filter(({ verdict }) => verdict !== "proved");
      if (open.length)
        parts.push(
          element(
            "ul",
            {},
            open.map(({ statement, words }) => element("li", {}, `${statement}: ${words}`)),
          ),
        );
      parts.push(button("in the report", () => this.toReport(`${name} (${kind})`)));
    }
    this.explain(name, parts, again);
  }

  explain(what, parts, again = false) {
    const close = !again && this.chosen === what && !at("chosen").hidden;
    this.chosen = close ? null : what;
    at("chosen").replaceChildren(...parts);
    at("chosen").hidden = close;
    for (const chip of at("chips").children)
      chip.setAttribute("aria-expanded", String(chip.dataset.of === this.chosen));
  }

  toLine(line) {
    this.toText();
    const place = this.editor.view.state.doc.line(Math.min(line, this.editor.view.state.doc.lines));
    this.editor.go(place.from, place.to);
  }

  toReport(heading) {
    this.showTab(at("tab-report"), false);
    const inside = this.frame?.contentDocument;
    const found = [...(inside?.querySelectorAll("h3") ?? [])].find((title) => title.textContent.startsWith(heading));
    found?.scrollIntoView();
  }

  output(name) {
    return this.outputs.find((file) => file.name === name);
  }

  drawReport() {
    const panel = at("panel-report");
    const report = this.output("report.html");
    if (!this.frames) {
      this.bar = element("span", { class: "small" });
      const tab = button("Open in a tab", () => this.openReport(), { id: "open-report" });
      const file = button("Save", () => download("report.html", this.output("report.html").bytes, "text/html"), {
        "aria-label": "Save the report",
      });
      const print = button("Print", () => this.frame?.contentWindow.print(), { "aria-label": "Print the report" });
      this.reportBar = element("div", { class: "report-bar", hidden: true }, this.bar, tab, file, print);
      this.frames = element(
        "div",
        { class: "frames" },
        element("p", { class: "empty" }, "The report of the run appears here."),
      );
      panel.replaceChildren(this.reportBar, this.frames);
    }
    if (!report) return;
    this.reportBar.hidden = false;
    const next = element("iframe", { class: "next", title: "Report of the run" });
    next.style.colorScheme = this.isDark ? "dark" : "light";
    this.coming?.remove();
    this.coming = next;
    next.addEventListener("load", () => this.swap(next));
    // The document has the bytes of the file.
    next.srcdoc = decode(report.bytes);
    this.frames.append(next);
  }

  // The new report takes the place of the old one when its figures stand, at the same height.
  async swap(next) {
    if (this.coming !== next) return;
    const inside = next.contentDocument;
    inside.addEventListener("click", (event) => this.follow(event, inside));
    inside.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.frames.closest("[role=tabpanel]") && at("tab-report").focus();
    });
    for (let wait = 0; wait < 40; wait++) {
      const plots = [...inside.querySelectorAll("[data-picture]")];
      if (plots.every((plot) => plot.querySelector(".main-svg"))) break;
      await new Promise((done) => setTimeout(done, 50));
    }
    if (this.coming !== next) return;
    const old = this.frame;
    const place = old?.contentWindow?.scrollY ?? 0;
    next.contentWindow.scrollTo(0, place);
    next.classList.remove("next");
    for (const other of [...this.frames.children]) if (other !== next) other.remove();
    this.frame = next;
    this.coming = null;
    next.contentWindow.scrollTo(0, place);
    this.stale();
  }

  // Links of the report: to its own headings, and to files of its folder.
  follow(event, inside) {
    const link = event.target.closest?.("a[href]");
    if (!link) return;
    const href = link.getAttribute("href");
    if (href.startsWith("#")) {
      event.preventDefault();
      inside.getElementById(decodeURIComponent(href.slice(1)))?.scrollIntoView();
      return;
    }
    if (/^[a-z]+:/i.test(href)) return;
    event.preventDefault();
    const name = decodeURIComponent(href);
    const file = this.output(name);
    if (file) download(name, file.bytes, typeOf(name));
    else this.banner(`${name} is not among the files of this run: figures are drawn under Files.`);
  }

  openReport() {
    const report = this.output("report.html");
    if (report) this.openBytes(report.bytes, "text/html");
  }

  openBytes(bytes, type) {
    const address = URL.createObjectURL(new Blob([bytes], { type }));
    // The tab reads the bytes when it opens; a closed studio takes them along.
    if (!open(address, "_blank")) this.banner("The browser did not open a tab: save the report instead.");
    setTimeout(() => URL.revokeObjectURL(address), 120000);
  }

  drawSummary() {
    const summary = this.results?.summary;
    const failures = this.results?.failures ?? [];
    at("panel-summary").replaceChildren(
      summary ? element("pre", {}, summary) : element("p", { class: "small" }, "The text of the run appears here."),
      ...(failures.length
        ? [
            element("h2", {}, "What is not proved or did not run"),
            element(
              "ul",
              {},
              failures.map((failure) =>
                element(
                  "li",
                  {},
                  typeof failure === "string"
                    ? failure
                    : `${failure.observer ? `${failure.observer}: ` : ""}${failure.message}`,
                ),
              ),
            ),
          ]
        : []),
    );
  }

  drawCertificates() {
    const certificates = this.outputs.filter(({ name }) => /^certificates\/.*\.json$/.test(name));
    // What was verified stays as long as it is about these certificates.
    const key = certificates.map(({ name, bytes }) => `${name} ${decode(bytes)}`).join();
    const verified = key === this.certified ? [...(at("verified")?.childNodes ?? [])] : [];
    this.certified = key;
    const rows = certificates.map((file) =>
      element(
        "tr",
        {},
        element("td", {}, file.name.slice(13)),
        element(
          "td",
          { class: "acts" },
          button("Verify", () => this.verify([file]), { "aria-label": `Verify ${file.name}` }),
          " ",
          button("Save", () => download(file.name, file.bytes, typeOf(file.name)), {
            "aria-label": `Save ${file.name}`,
          }),
        ),
      ),
    );
    at("panel-certificates").replaceChildren(
      element(
        "p",
        {},
        "A certificate holds the data of a theorem. It is verified here from that data alone, with all rounding errors enclosed, by the checker that luenberger verify is.",
      ),
      element(
        "div",
        { class: "line" },
        certificates.length
          ? button("Verify all", () => this.verify(certificates), { id: "verify-all", class: "primary" })
          : null,
        button("Verify a file …", () => this.choose(".json")),
      ),
      certificates.length
        ? element("table", { class: "rows" }, element("tbody", {}, rows))
        : element("p", { class: "small" }, "The run has no certificates."),
      element("div", { id: "verified", "aria-live": "polite" }, verified),
    );
  }

  async verify(files) {
    this.showTab(at("tab-certificates"), false);
    at("verified").replaceChildren();
    for (const file of files) {
      let said;
      try {
        const { json } = await this.checker.ask({ do: "verify" }, { files: [{ name: file.name, bytes: file.bytes }] });
        said = json.rendered || json.error?.message;
      } catch (error) {
        said = error?.message ?? "stopped";
      }
      at("verified").append(element("pre", { class: "said" }, said));
    }
  }

  drawFiles() {
    const rows = this.outputs.map((file) =>
      element(
        "tr",
        {},
        element(
          "td",
          {},
          isText(file.name) || /\.(png|svg)$/.test(file.name)
            ? button(file.name, () => this.view(file), { class: "plain" })
            : file.name,
        ),
        element("td", { class: "number" }, size(file.bytes.length)),
        element(
          "td",
          { class: "acts" },
          button("Save", () => download(file.name, file.bytes, typeOf(file.name)), {
            "aria-label": `Save ${file.name}`,
          }),
        ),
      ),
    );
    const drawn = this.outputs.some(({ name }) => name.startsWith("figures/"));
    at("panel-files").replaceChildren(
      element(
        "div",
        { class: "line" },
        button("Everything as zip", () => this.zip(), { disabled: !this.runner }),
        this.results && !drawn ? button("Draw the figures (SVG, PNG)", () => this.drawFigures()) : null,
      ),
      rows.length
        ? element(
            "table",
            { class: "rows" },
            element(
              "thead",
              {},
              element("tr", {}, element("th", {}, "file"), element("th", { class: "number" }, "size"), element("th")),
            ),
            element("tbody", {}, rows),
          )
        : element("p", { class: "small" }, "The files of the run appear here."),
      element("div", { id: "viewed" }),
    );
  }

  view(file, place = "viewed") {
    const most = 200000;
    const text = () => {
      const shown = decode(file.bytes.subarray(0, most));
      return [
        element("pre", { tabindex: 0 }, shown),
        file.bytes.length > most
          ? element("p", { class: "small" }, `The first ${size(most)} of ${size(file.bytes.length)}.`)
          : null,
      ];
    };
    const image = () => {
      const address = URL.createObjectURL(new Blob([file.bytes], { type: typeOf(file.name) }));
      return element("img", {
        src: address,
        alt: file.name,
        style: "max-width: 100%",
        onload: () => URL.revokeObjectURL(address),
      });
    };
    at(place).replaceChildren(
      element("h3", {}, file.name),
      ...[/\.(png|svg)$/.test(file.name) ? image() : text()].flat().filter(Boolean),
    );
    at(place).scrollIntoView({ block: "nearest" });
  }

  async drawFigures() {
    const answer = await this.complete();
    if (answer) this.drawFiles();
  }

  // The run with all its files, figures as well.
  async complete() {
    const { version } = this;
    const answer = await this.work(
      "study",
      "Running with figures",
      this.request("run", { step: "run", figures: true }),
      { named: this.files },
    );
    if (!answer) return null;
    if (answer.json.error) {
      this.failed(answer.json);
      return null;
    }
    Object.assign(this, { results: answer.json, outputs: answer.files, ranVersion: version });
    this.status(`Done in ${answer.seconds.toPrecision(2)} s.`);
    return answer;
  }

  // ---- Export ----

  // The observers with what each can be written as; while the study has a mistake, those it had before.
  exportable() {
    if (this.checked?.exports) this.exports = this.checked.exports;
    return this.exports ?? [];
  }

  drawExport() {
    const panel = at("panel-export");
    const list = this.exportable();
    const key = JSON.stringify(list);
    if (panel.dataset.key === key && panel.childElementCount) return;
    panel.dataset.key = key;
    if (!list.length) {
      panel.replaceChildren(element("p", { class: "small" }, "The study has no observer to export."));
      return;
    }
    const language = element("select", { id: "export-language" });
    const fill = () => {
      const { languages } = list.find(({ observer }) => observer === names.value) ?? list[0];
      language.replaceChildren(...languages.map((one) => element("option", { value: one }, LANGUAGES[one] ?? one)));
    };
    const names = element(
      "select",
      { id: "export-observer", onchange: fill },
      list.map(({ observer }) => element("option", { value: observer }, observer)),
    );
    fill();
    const period = element("input", {
      type: "text",
      id: "export-period",
      size: 8,
      placeholder: "as the study",
      inputmode: "decimal",
    });
    const scalar = element(
      "select",
      { id: "export-scalar" },
      [
        ["f64", "binary64"],
        ["f32", "binary32"],
        ["q16.16", "q16.16, fixed point"],
      ].map(([value, text]) => element("option", { value }, text)),
    );
    const unproved = element("input", { type: "checkbox", id: "export-unproved" });
    const feedback = element("input", { type: "checkbox", id: "export-feedback" });
    panel.replaceChildren(
      element(
        "p",
        {},
        "The step of an observer as source code for the target, with a test that repeats its results to the last bit, a README and a certificate.",
      ),
      element(
        "div",
        { class: "line" },
        element("label", {}, "Observer ", names),
        element("label", {}, "as ", language),
        element("label", {}, "numbers ", scalar),
        element("label", {}, "period ", period),
        element("label", {}, unproved, " also without a certificate"),
        element("label", {}, feedback, " with the feedback"),
        button(
          "Export",
          () =>
            this.export({
              observer: names.value,
              language: language.value,
              period: period.value.trim(),
              scalar: scalar.value,
              unproved: unproved.checked,
              feedback: feedback.checked,
            }),
          { id: "export-run", class: "primary" },
        ),
      ),
      element("div", { id: "exported", "aria-live": "polite" }),
      element("div", { id: "exported-file" }),
    );
  }

  exporting({ observer, language, period = "", scalar = "f64", unproved = false, feedback = false }) {
    return this.request("export", {
      observer,
      language,
      scalar,
      unproved,
      feedback,
      period: period ? Number(period) : null,
    });
  }

  async export(options) {
    if (options.period && !(Number(options.period) > 0)) {
      at("exported").replaceChildren(
        element("p", { class: "small" }, `The period is a positive number, not "${options.period}".`),
      );
      return;
    }
    at("exported-file").replaceChildren();
    at("exported").replaceChildren(element("p", { class: "small" }, "Exporting …"));
    const answer = await this.work("export", `Exporting ${options.observer}`, this.exporting(options), {
      named: this.files,
    });
    if (!answer) {
      at("exported").replaceChildren(element("p", { class: "small" }, "Nothing was exported."));
      return;
    }
    const { json, files } = answer;
    if (json.error) {
      this.status("Not exported: the reason is under Export.");
      at("exported").replaceChildren(element("pre", { class: "said" }, json.rendered || json.error.message));
      return;
    }
    this.status(`Exported in ${answer.seconds.toPrecision(2)} s.`);
    this.exported = files;
    const folder = `${options.observer} ${options.language}`.replace(/[^A-Za-z0-9_-]+/g, "-");
    at("exported").replaceChildren(
      element("pre", { class: "said" }, json.text),
      element(
        "div",
        { class: "line" },
        button("Save as zip", () => this.packed(`${folder}.zip`, files)),
      ),
      element(
        "table",
        { class: "rows" },
        element(
          "tbody",
          {},
          files.map((file) =>
            element(
              "tr",
              {},
              element(
                "td",
                {},
                isText(file.name)
                  ? button(file.name, () => this.view(file, "exported-file"), { class: "plain" })
                  : file.name,
              ),
              element("td", { class: "number" }, size(file.bytes.length)),
              element(
                "td",
                { class: "acts" },
                button("Save", () => download(file.name, file.bytes, typeOf(file.name)), {
                  "aria-label": `Save ${file.name}`,
                }),
              ),
            ),
          ),
        ),
      ),
    );
  }

  async packed(name, files) {
    const answer = await this.work("zip", "Packing", { do: "zip" }, { files });
    const archive = answer?.files[0];
    if (!archive) {
      if (answer?.json.error) this.banner(answer.json.error.message, "bad");
      return null;
    }
    this.status(`${name}: ${files.length} files, ${size(archive.bytes.length)}.`);
    download(name, archive.bytes, "application/zip");
    return archive;
  }

  // The study, its logs, the folder of results and the code of every observer that has one.
  async zip() {
    const answer = await this.complete();
    if (!answer) return null;
    this.drawResults();
    const files = [{ name: this.name, bytes: encode(this.editor.text) }];
    for (const [name, bytes] of this.files) if (this.editor.text.includes(name)) files.push({ name, bytes });
    for (const { name, bytes } of answer.files) files.push({ name: `results/${name}`, bytes });
    // The observers without code, with the reason.
    const left = new Map();
    for (const { observer, languages } of this.exportable()) {
      for (const language of languages.filter((one) => ["c", "rust", "fmu2"].includes(one))) {
        const exported = await this.work(
          "export",
          `Exporting ${observer} as ${LANGUAGES[language] ?? language}`,
          this.exporting({ observer, language }),
          { named: this.files },
        );
        if (!exported) return null;
        if (exported.json.error) left.set(observer, exported.json.error.message);
        const folder = `code/${observer.replace(/[^A-Za-z0-9_-]+/g, "-")}/${language}`;
        for (const { name, bytes } of exported.files) files.push({ name: `${folder}/${name}`, bytes });
      }
    }
    if (left.size) {
      files.push({
        name: "code/not-exported.txt",
        bytes: encode([...left.values()].map((why) => `${why}\n`).join("\n")),
      });
      this.banner(
        `The archive has no code of ${[...left.keys()].join(", ")}: code/not-exported.txt says why, and Export has what may help.`,
      );
    }
    return this.packed(`${this.name.replace(/\.[^.]*$/, "")}.zip`, files);
  }

  // ---- Logs ----

  drawLogs() {
    const panel = at("panel-log");
    const rows = [...this.files].map(([name, bytes]) =>
      element(
        "tr",
        {},
        element("td", {}, name),
        element("td", { class: "number" }, size(bytes.length)),
        element(
          "td",
          { class: "acts" },
          button("Columns", () => this.columns(name), { "aria-label": `Columns of ${name}` }),
          " ",
          button(
            "Remove",
            () => {
              this.files.delete(name);
              this.keep();
              this.drawLogs();
              this.check();
            },
            { "aria-label": `Remove ${name}` },
          ),
        ),
      ),
    );
    panel.replaceChildren(
      element(
        "p",
        {},
        "Measured data: a CSV file with a line of names, a column of times, the inputs and the measured outputs. It stays in this page.",
      ),
      element(
        "div",
        { class: "drop" },
        "Drop a CSV file anywhere on the page, or ",
        button("choose one …", () => this.choose(".csv,.txt,.tsv,.dat"), { id: "choose-log" }),
      ),
      rows.length ? element("table", { class: "rows" }, element("tbody", {}, rows)) : "",
      element("div", { id: "columns", "aria-live": "polite" }),
      element("h2", {}, "Advise and tune"),
      element(
        "p",
        {},
        "Advise tries every kind of observer on the study and orders them. Tune fits what the table [tune] names to the log.",
      ),
      element(
        "div",
        { class: "line" },
        button("Advise", () => this.other("advise"), { id: "advise" }),
        button("Tune", () => this.other("tune"), { id: "tune" }),
      ),
      element("div", { id: "advice", "aria-live": "polite" }),
    );
  }

  async addLog(file) {
    const bytes = await this.read(file, LIMITS.log, "a log");
    this.files.set(file.name, bytes);
    this.keep();
    this.drawLogs();
    this.showTab(at("tab-log"), false);
    this.showSide(at("side-results"), false);
    await this.columns(file.name);
    this.check();
  }

  async columns(name) {
    at("columns").replaceChildren(element("p", { class: "small" }, `${name} is read …`));
    let json;
    try {
      await this.ready;
      ({ json } = await this.checker.ask(
        { do: "columns", name: this.name, study: this.editor.text, format: this.format },
        { files: [{ name, bytes: this.files.get(name) }] },
      ));
    } catch (error) {
      json = { error: { message: error?.message ?? "stopped" } };
    }
    if (json.error) {
      at("columns").replaceChildren(element("pre", { class: "said" }, json.rendered || json.error.message));
      return;
    }
    this.chooseColumns(name, json);
  }

  // The columns of a log, offered for the time, the inputs and the outputs of the plant.
  chooseColumns(name, { columns, rows, suggestion }) {
    const { toml } = this.editor;
    const plant = (key) => (toml.value(["plant", key]) ?? []).filter((text) => typeof text === "string");
    const outputs = plant("outputs"),
      inputs = plant("inputs");
    const names = columns.map((column) => column.name ?? column);
    const guess = new Toml(suggestion ?? "");
    const given = (key) => guess.value(["log", key]) ?? guess.value([key]);
    const like = (wanted) => names.find((column) => column.toLowerCase() === wanted.toLowerCase());
    const select = (label, chosen, id) => {
      const field = element(
        "select",
        { id },
        element("option", { value: "" }, "–"),
        names.map((column) => element("option", { value: column }, column)),
      );
      field.value = names.includes(chosen) ? chosen : "";
      return element("label", {}, `${label} `, field);
    };
    const time = select("time", given("time") ?? like("t") ?? like("time") ?? names[0], "column-time");
    const list = (wanted, key) =>
      wanted.map((one, k) => select(one, given(key)?.[k] ?? like(one), `column-${key}-${k}`));
    const fields = { inputs: list(inputs, "inputs"), outputs: list(outputs, "outputs") };
    const text = () => {
      const value = (label) => label.querySelector("select").value;
      const line = (key) => {
        const chosen = fields[key].map(value);
        const own = { inputs, outputs }[key];
        return chosen.length && chosen.every(Boolean) && !same(chosen, own)
          ? `${key} = [${chosen.map(quoted).join(", ")}]\n`
          : "";
      };
      return `[log]\nfile = ${quoted(name)}\n${value(time) ? `time = ${quoted(value(time))}\n` : ""}${line("inputs")}${line("outputs")}`;
    };
    at("columns").replaceChildren(
      element("h3", {}, `${name}: ${rows} rows, ${names.length} columns`),
      element("p", { class: "small" }, names.join(", ")),
      element("div", { class: "line" }, time, fields.inputs, fields.outputs),
      element(
        "div",
        { class: "line" },
        button(
          "Write [log] into the study",
          () => this.insertLog(fields.inputs.length || fields.outputs.length ? text() : (suggestion ?? text())),
          { id: "insert-log", class: "primary" },
        ),
      ),
    );
  }

  // The table in place of the one that is there.
  insertLog(text) {
    const { toml } = this.editor;
    const form = new Form(document.createElement("div"), this.editor, () => this.schema);
    if (this.format === "json") {
      this.banner("In a study in JSON, write the key log by hand.");
      return;
    }
    const extent = toml.get(["log"])?.header ? form.extent(["log"]) : null;
    if (extent)
      this.editor.edit({
        from: toml.get(["log"]).header.from,
        to: extent.to,
        insert: text.trimEnd() + (extent.to < toml.text.length ? "\n\n" : "\n"),
      });
    else form.append(text);
    this.status("The study has a table [log].");
  }

  async other(what) {
    const title = { advise: "Advising", tune: "Tuning" }[what];
    at("advice").replaceChildren(element("p", { class: "small" }, `${title} …`));
    const answer = await this.work(what, title, this.request(what), { named: this.files });
    if (!answer) {
      at("advice").replaceChildren(element("p", { class: "small" }, "Stopped."));
      return;
    }
    const { json, files } = answer;
    if (json.error) {
      this.status("Not done.");
      at("advice").replaceChildren(element("pre", { class: "said" }, json.rendered || json.error.message));
      return;
    }
    this.status(`Done in ${answer.seconds.toPrecision(2)} s.`);
    const report = files.find(({ name }) => name === "report.html");
    const next = { advise: "the study with the advised observers", tune: "the tuned study" }[what];
    at("advice").replaceChildren(
      element(
        "div",
        { class: "line" },
        json.study
          ? button(
              `Use ${next}`,
              () => {
                this.show(json.study, this.name);
                this.banner(`This is ${next}; undo brings back the one before.`);
              },
              { class: "primary", id: "use-advice" },
            )
          : null,
        report ? button("Open the report", () => this.openBytes(report.bytes, "text/html")) : null,
        files.map((file) => button(`Save ${file.name}`, () => download(file.name, file.bytes, typeOf(file.name)))),
      ),
      element("pre", {}, `${json.text}${json.stopped ? `\n${json.stopped}` : ""}`),
    );
  }

  // ---- Links ----

  async address() {
    const letters = await toLetters(JSON.stringify({ version: 1, name: this.name, text: this.editor.text }));
    return `${location.href.split("#")[0]}#study=${letters}`;
  }

  async copyLink() {
    if (typeof CompressionStream !== "function") {
      this.banner("This browser cannot compress (CompressionStream): save the study instead.", "bad");
      return;
    }
    const address = await this.address();
    const without = this.files.size ? ` Its logs (${[...this.files.keys()].join(", ")}) are not in it.` : "";
    const long = address.length > 30000 ? ` It has ${address.length} letters, more than some programs pass on.` : "";
    const local =
      location.protocol === "file:" ? " What follows # works behind the address of any copy of this page." : "";
    try {
      await navigator.clipboard.writeText(address);
      this.banner(`The link is copied: the study stands in it, compressed.${without}${long}${local}`);
    } catch {
      const field = element("input", {
        type: "text",
        readonly: true,
        value: address,
        "aria-label": "Link with the study",
        size: 24,
      });
      this.banner(`Copy this link: the study stands in it, compressed.${without}${long}${local}`, "", [field]);
      field.focus();
      field.select();
    }
  }

  // The study of a link; one that cannot be read changes nothing.
  async followLink() {
    const found = /^#study=(.*)$/s.exec(location.hash);
    if (!found) return;
    try {
      history.replaceState(null, "", location.href.split("#")[0]);
    } catch {
      // The address keeps its fragment.
    }
    try {
      if (found[1].length > LIMITS.link) throw new Error(`it has more than ${size(LIMITS.link)}`);
      const value = JSON.parse(await fromLetters(found[1], LIMITS.study));
      if (value?.version !== 1 || typeof value.text !== "string" || typeof value.name !== "string")
        throw new Error("it holds no study of this page");
      const name = /^[^/\\]{1,120}\.(toml|json)$/.test(value.name) ? value.name : "study.toml";
      if (value.text === this.editor.text) return;
      this.show(value.text, name);
      this.banner("The study of the link is shown. Undo brings back the one before.");
    } catch (error) {
      this.banner(
        `The link cannot be read: ${error.message || "it is cut or was changed"}. The study is as it was.`,
        "bad",
      );
    }
  }
}

const studio = new Studio();
