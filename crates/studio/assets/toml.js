// TOML, read with the place of everything, for completion and the form. What is right and wrong is the module's to say.

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
    const header = this.headers.findLast(({ from }) => from <= place);
    if (header && place <= this.lineEnd(header.from) && place > header.from) {
      const word = /[^[\]]*$/.exec(this.text.slice(header.from, place))[0];
      return place <= header.to ? { mode: "header", from: place - word.length, array: header.array, path: [] } : null;
    }
    const path = header?.path ?? [];
    const statement = this.statements.findLast(({ from }) => from <= place);
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
