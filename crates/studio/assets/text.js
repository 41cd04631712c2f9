// The study as text: CodeMirror with completion, descriptions and mistakes.

const fromForm = Editor.Annotation.define();

const FUNCTIONS = [
  ..."sqrt exp ln log10 sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh pow".split(" "),
  ..."abs min max sat sign step floor wrap mod if".split(" "),
];
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
    this.view.dispatch({ changes, annotations: own ? [fromForm.of(true)] : [], userEvent: "input" });
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
          element("p", {}, prose(text)),
        ),
      }),
    };
  }
}
