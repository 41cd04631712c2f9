// The page: study and results, and what joins them.

const STORED = "luenberger-studio";
const LIMITS = { study: 2e6, log: 64e6, stored: 1.5e6, link: 2e6, certificate: 16e6 };
// A run that takes longer is asked for, in seconds.
const LONG = 20;
// The chip that is about no observer: no name has a line break.
const WARNINGS = "\n";
const TONES = { proved: "good", refuted: "bad" };
// A plant to begin with, in the list of templates.
const OWN = {
  name: "own-plant",
  about: "your own plant: one state to begin with",
  text: `[plant]\n${BEGINNINGS.matrices}\n`,
};
// What the command's options are called under Export.
const FIELDS = [
  [/--period\b/g, "the field period"],
  [/--format f64\b/g, "numbers binary64"],
  [/--format f32\b/g, "numbers binary32"],
  [/--format\b/g, "numbers"],
  [/--unproved\b/g, "the box “also without a certificate”"],
  [/--feedback\b/g, "the box “with the feedback”"],
  [/--to fmu\b/g, "an FMU"],
  [/--to c\b/g, "C"],
  [/--[a-z]+\b/g, "$& of the command luenberger export"],
];
const inPage = (text) => FIELDS.reduce((said, [option, field]) => said.replace(option, field), text);
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
    this.watch();
    this.ready = new Promise((done) => {
      this.isReady = done;
    });
  }

  // What goes wrong in the page itself is said, and the page goes on; what its policy stopped is listed.
  watch() {
    this.faults = [];
    const told = (what) => {
      this.faults.push(what);
      if (this.faults.length < 4) this.banner(`A mistake of this page: ${sentence(what)} The study is as it was.`, "bad");
    };
    addEventListener("error", (event) => told(String(event.message)));
    addEventListener("unhandledrejection", (event) => told(String(event.reason?.message ?? event.reason)));
    addEventListener("securitypolicyviolation", (event) => {
      this.faults.push(`${event.violatedDirective}: ${event.blockedURI}`);
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
    const [unpack, packed] = ["unpack", "module"].map((id) => packedBytes(at(id).textContent));
    at("module").textContent = "";
    let compiled;
    try {
      compiled = await compiledModule(await through(unpack, new DecompressionStream("gzip"), 1e6), packed);
    } catch (error) {
      throw new Error(`The program in this page does not load: ${sentence(error.message)}`);
    }
    [this.checker, this.runner] = [new Engine(compiled), new Engine(compiled)];
    this.runner.start();
    const { json, files } = await this.checker.ask({ do: "about" });
    this.about = json;
    this.templateFiles = files;
    this.schema = new Schema(json.schema);
    at("version").textContent = json.version ?? "";
    for (const { name, title, about } of [OWN, ...json.templates]) {
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
    on("cancel", () =>
      this.cancel(
        `The run was cancelled; ${this.results ? "the results are those of the run before" : "there are no results yet"}.`,
      ),
    );
    on("undo", () => Editor.undo(this.editor.view));
    on("redo", () => Editor.redo(this.editor.view));
    at("auto").addEventListener("change", () => {
      this.keep();
      if (at("auto").checked) this.check();
    });
    picker(at("template"), (chosen) =>
      this.template([OWN, ...this.about.templates].find(({ name }) => name === chosen)),
    );
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
    this.saysDone = false;
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
      for (const [name, content] of Object.entries(kept.files ?? {})) this.files.set(name, encode(content));
      this.editor.begin(kept.text);
      this.language();
      this.saved = kept.saved ?? "";
      if (kept.left?.length)
        this.banner(`Not kept in the browser: ${kept.left.join(", ")}. Choose the file again under Log.`);
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
      const text = sum < LIMITS.stored ? decode(bytes) : null;
      // What is no text in UTF-8 would come back as another file.
      if (text !== null && !text.includes("\ufffd")) files[name] = text;
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
      "Nothing of this page is stored in the browser any more. The study stays here until you close it, and is " +
        "stored again when you change it.",
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
        "This is a study: a plant, a run and some observers for it, as text or as a form. Its results follow what " +
          "you write. Nothing leaves this page.",
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
    if (!update.transactions.some((transaction) => transaction.annotation(fromForm))) {
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
      this.checked = null;
      this.mistakes([], null, text);
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
    else this.starting = setTimeout(() => this.run(), this.results ? 250 : 0);
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
    const parts = [stage, subject, known && `${done} of ${of}`].filter((part) => part);
    this.status(`${what}: ${parts.join(", ")} …`);
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
    const time = seconds < 10 ? seconds.toPrecision(2) : Math.round(seconds);
    this.drawResults();
    this.stale();
    this.status(`${json.stopped ? `Stopped: ${json.stopped}` : "Done"} in ${time} s.`);
    this.saysDone = true;
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
    const of = old ? "of an earlier version of the study" : "";
    at("results").classList.toggle("stale", old);
    at("chips").title = of;
    if (this.bar) this.bar.textContent = of;
    if (old && this.saysDone) this.status("The results are of an earlier version of the study.");
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
      const chip = button("", () => this.tell(observer, ended), {
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
    if (still) this.tell(still, rows.find((row) => row.observer === still.name && row.failure)?.failure, true);
  }

  // What is said of an observer; once more closes it.
  tell({ name, kind, design, failure }, ended, again = false) {
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
      element(
        "div",
        { class: "line" },
        button(
          "Advise: which observer?",
          () => {
            this.showTab(at("tab-log"), false);
            this.other("advise");
            at("advice").scrollIntoView({ block: "nearest" });
          },
          { id: "advise-summary", disabled: !this.runner },
        ),
      ),
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
        "A certificate holds the data of a theorem. It is verified here from that data alone, with all rounding " +
          "errors enclosed, by the checker that luenberger verify is.",
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
              element("tr", {}, element("th", {}, "file"), element("th", { class: "number" }, "size"), element("td")),
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
        "The step of an observer as source code for the target, with a test that repeats its results to the last " +
          "bit, a README and a certificate.",
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
      at("exported").replaceChildren(
        element("pre", { class: "said" }, inPage(json.rendered || json.error.message)),
      );
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
        if (exported.json.error) left.set(observer, inPage(exported.json.error.message));
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
        `The archive has no code of ${[...left.keys()].join(", ")}: code/not-exported.txt says why, and Export has ` +
          "what may help.",
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
        "Measured data: a CSV file with a line of names, a column of times, the inputs and the measured outputs. It " +
          "stays in this page.",
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
        "Advise tries every kind of observer on the study and orders them. Tune fits what the table [tune] names to " +
          "the log.",
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
      const named = value(time) ? `time = ${quoted(value(time))}\n` : "";
      return `[log]\nfile = ${quoted(name)}\n${named}${line("inputs")}${line("outputs")}`;
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
        `The link cannot be read: ${sentence(error.message || "it is cut or was changed")} The study is as it was.`,
        "bad",
      );
    }
  }
}

const studio = new Studio();
