// The study as a form.

const same = (one, other) => one.length === other.length && one.every((step, k) => step === other[k]);

// What a new plant has.
const BEGINNINGS = {
  matrices: "a = [[-1]]\nb = [[1]]\nc = [[1]]",
  equations:
    'states = ["x1"]\ninputs = ["u1"]\noutputs = ["y1"]\nf = ["-x1 + u1"]\nh = ["x1"]',
};

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
    this.root.replaceChildren(this.adding(), top, ...cards);
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
      path.length ? element("p", { class: "small" }, prose(this.schema().describe(path, this.toml))) : null,
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
          element("td"),
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
    // A plant of nothing yet: matrices or equations, which grow by the buttons above.
    const begun = ["a", "c", "f", "h"].some((key) => has(key));
    const begin = (what, text) =>
      button(what, () => this.editor.edit({ from: this.toml.lineEnd(node.header.to), insert: `\n${text}` }), {
        id: `begin-${what}`,
      });
    const beginning =
      begun || !node.header ? [] : [begin("matrices", BEGINNINGS.matrices), begin("equations", BEGINNINGS.equations)];
    return this.card("Plant", ["plant"], () => true, node, { actions: [actions, switching, beginning] });
  }

  // One state, input or output more or less: in the matrices or equations, the names, x(0) and the expressions of
  // inputs.
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
    const after = (path) => setTimeout(() => this.scrollTo(path), 50);
    picker(observer, (kind) => {
      this.addObserver(kind);
      after(["observer", this.toml.get(["observer"]).items.length - 1]);
    });
    picker(table, (chosen) => {
      const { schema } = tables.find(({ name }) => name === chosen);
      const needed = (schema.required ?? []).map(
        (key) => `${key} = ${this.fresh([chosen], { name: key, schema: schema.properties[key] })}\n`,
      );
      this.append(`[${chosen}]\n${chosen === "plant" ? `${BEGINNINGS.matrices}\n` : needed.join("")}`);
      after([chosen]);
    });
    return element("div", { class: "line adding" }, observer, tables.length ? table : null);
  }

  scrollTo(path) {
    at(this.identity(path, "add"))?.closest(".card").scrollIntoView({ block: "nearest" });
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
