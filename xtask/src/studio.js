"use strict";
// Uses the page as a visitor does and leaves what it found in the element `test-result`: `errors`, `requests`, `wide`
// and `wrong` are empty for a page that does what it should.
const errors = [],
  requests = [],
  wrong = [];
const consoleError = console.error;
console.error = (...words) => {
  errors.push(words.join(" "));
  consoleError(...words);
};

// Under a virtual clock, waiting takes no time in which the workers could do anything: some work at every step of 20 ms
// gives them about as much.
let spun = 1;
const spinning = setInterval(() => {
  for (let k = 0; k < 1e7; k++) spun = Math.imul(spun, 48271);
}, 20);

const pause = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));

// Waits for what is expected; what does not come within a minute is wrong.
async function expect(what, holds) {
  for (let wait = 0; wait < 3000; wait++) {
    if (holds()) return true;
    await pause(20);
  }
  wrong.push(`${what}: ${document.getElementById("status").textContent}`);
  return false;
}

const equal = (what, found, expected) => {
  const [one, other] = [JSON.stringify(found), JSON.stringify(expected)];
  if (one !== other) wrong.push(`${what}: ${one} for ${other}`);
};

// That the page is higher than its window, and the elements that are wider than the page, but for those within an element that scrolls.
function wide(page) {
  const { clientWidth, scrollWidth, clientHeight, scrollHeight } = page.documentElement;
  const found = scrollWidth > clientWidth ? [`the page, ${scrollWidth} of ${clientWidth} px`] : [];
  // Its parts scroll by themselves.
  if (scrollHeight > clientHeight) found.push(`the page, ${scrollHeight} of ${clientHeight} px high`);
  const scrolls = (element) =>
    element &&
    element !== page.body &&
    (page.defaultView.getComputedStyle(element).overflowX !== "visible" || scrolls(element.parentElement));
  for (const element of page.querySelectorAll("body *")) {
    if (element.closest("svg, math, .skip") || !element.getClientRects().length) continue;
    const over = element.getBoundingClientRect().right > clientWidth + 1;
    if (over && !scrolls(element.parentElement)) found.push(`${element.tagName} ${element.id} ${element.className}`);
  }
  // What scrolls sideways within a panel has an element of its own.
  for (const panel of page.querySelectorAll("[role=tabpanel]:not([hidden])")) {
    const { clientWidth: own, scrollWidth: content } = panel;
    if (content > own + 1) found.push(`${panel.id}, ${content} of ${own} px`);
  }
  return found;
}

// The page as it stands within a frame of a width, without its scripts; a window has a least width.
async function atWidth(width, side) {
  const copy = document.documentElement.cloneNode(true);
  for (const script of copy.querySelectorAll("script, iframe")) script.remove();
  copy.querySelector("body").dataset.side = side;
  const frame = document.createElement("iframe");
  frame.style.cssText = `width: ${width}px; height: 900px; border: 0; flex: none`;
  const loaded = new Promise((done) => frame.addEventListener("load", done));
  frame.srcdoc = `<!DOCTYPE html>${copy.outerHTML}`;
  document.body.append(frame);
  await loaded;
  frame.contentDocument.adoptedStyleSheets = [];
  const found = wide(frame.contentDocument).map((what) => `at ${width} px, ${side}: ${what}`);
  frame.remove();
  return found;
}

const done = () =>
  !studio.running &&
  studio.ranVersion === studio.version &&
  studio.version >= 0 &&
  /^Done/.test(document.getElementById("status").textContent);
const shown = () => [...document.querySelectorAll("#chips .chip .badge")].map((badge) => badge.textContent);
const banners = () => [...document.querySelectorAll(".banner span")].map((banner) => banner.textContent);
const press = (id) => document.getElementById(id).click();
const example = (name) => studio.about.templates.find((template) => template.name === name);

// Another study, with the results that it has.
async function study(text, name = "study.toml") {
  studio.show(text, name);
  return expect(`results of ${name}`, done);
}

async function typing(found) {
  const text = studio.editor.text;
  equal("verdicts of the first visit", shown(), ["proved", "proved", "proved"]);
  // A key behind the others of the first observer.
  const at = text.indexOf("rho = 10");
  studio.editor.go(at);
  studio.editor.view.dispatch({
    changes: { from: at, insert: "de" },
    selection: { anchor: at + 2 },
    userEvent: "input.type",
  });
  Editor.startCompletion(studio.editor.view);
  await expect("completion of a key", () =>
    Editor.currentCompletions(studio.editor.view.state).some(({ label }) => label === "decay_rate"),
  );
  await study(text);
  const kind = text.indexOf('kind = "luenberger"') + 8;
  studio.editor.go(kind + 3);
  Editor.startCompletion(studio.editor.view);
  await expect("completion of a kind", () =>
    Editor.currentCompletions(studio.editor.view.state).some(({ label }) => label === "luenberger"),
  );
  if (!studio.editor.about(kind)) wrong.push("no description of a kind");
  // A mistake: its message under its word, and the results of before.
  const poles = text.indexOf("poles = ");
  studio.editor.edit({ from: poles, to: poles + 5, insert: "pols" });
  await expect("the message of a mistake", () =>
    /`pols` is not a key/.test(document.getElementById("mistakes").textContent),
  );
  await expect("a mark under the mistake", () => document.querySelector(".cm-lintRange-error")?.textContent === "pols");
  if (!studio.output("report.html")) wrong.push("a mistake took the report away");
  equal("verdicts of before the mistake are dimmed", getComputedStyle(document.getElementById("chips")).opacity, "0.6");
  if (/^Done/.test(document.getElementById("status").textContent)) wrong.push("a mistake is done");
  found.mistake = document.getElementById("mistakes").textContent;
  Editor.undo(studio.editor.view);
  await expect("results after the mistake", done);
  equal("text after undo", studio.editor.text, text);
  // One observer that cannot be leaves the others.
  await study(
    text.replace(/kind = "luenberger"\npoles.*\nrho.*\n/, 'kind = "unknown-input"\npoles = [-2, -5]\ne = [[0], [1]]\n'),
  );
  equal("verdicts beside one that does not apply", shown(), ["not applicable", "proved", "proved"]);
  await study(text);
}

async function form() {
  press("tab-form");
  const text = studio.editor.text;
  await expect("the form", () => document.getElementById("field-plant-a-0-1-cell"));
  const cell = document.getElementById("field-plant-a-0-1-cell");
  cell.value = "2";
  cell.dispatchEvent(new Event("input"));
  equal("a cell of A", studio.editor.text, text.replace("a = [[0, 1]", "a = [[0, 2]"));
  const slider = document.getElementById("field-observer-0-rho-value-slider");
  slider.value = "1";
  slider.dispatchEvent(new Event("input"));
  slider.dispatchEvent(new Event("change"));
  equal("a slider", studio.editor.toml.value(["observer", 0, "rho"]), 100);
  equal("its comment", studio.editor.text.includes("# Q = rho I"), true);
  await expect("results of the form", done);
  press("more-state");
  equal("one more state", studio.editor.toml.value(["plant", "a"]), [
    [0, 2, 0],
    [0, 0, 0],
    [0, 0, 0],
  ]);
  const add = document.getElementById("add-observer");
  add.value = "kalman";
  add.dispatchEvent(new Event("change"));
  equal("one more observer", studio.editor.toml.value(["observer", 3, "kind"]), "kalman");
  // A plant of nothing yet, and one that is added to an empty study.
  studio.show("[plant]\n", "own.toml");
  await expect("beginnings of a plant", () => document.getElementById("begin-equations"));
  press("begin-equations");
  equal("equations of a new plant", studio.editor.toml.value(["plant", "h"]), ["x1"]);
  studio.show("", "own.toml");
  await expect("an empty form", () => document.querySelectorAll("#panel-form .card").length === 1);
  const table = document.getElementById("add-table");
  table.value = "plant";
  table.dispatchEvent(new Event("change"));
  await expect("the grid of a new plant", () => document.getElementById("more-state"));
  press("more-input");
  equal("one more input", studio.editor.toml.value(["plant", "b"]), [[1, 0]]);
  press("tab-text");
  await study(text);
}

// What the page says of options of the command, and of a run that was stopped before there were results.
async function words() {
  equal(
    "a hint",
    inPage("hint: --period, or simulation.hold in the study"),
    "hint: the field period, or simulation.hold in the study",
  );
  equal("another", inPage("--substeps to take fewer"), "--substeps of the command luenberger export to take fewer");
  const { results } = studio;
  for (const [of, said] of [
    [null, "there are no results yet"],
    [results, "the results are those of the run before"],
  ]) {
    studio.results = of;
    press("cancel");
    equal("the status after cancelling", document.getElementById("status").textContent, `The run was cancelled; ${said}.`);
  }
  location.hash = "study=";
  await expect("the message of an empty link", () =>
    banners().includes("The link cannot be read: it is empty. The study is as it was."),
  );
  if (banners().some((said) => said.includes(".."))) wrong.push(`two full stops: ${banners()}`);
}

async function logs() {
  const { text } = example("measured-log");
  const log = studio.templateFiles.find(({ name }) => name === "measured-log/measured-log.csv").bytes;
  studio.files.clear();
  studio.show(text.replace(/\[log\][^[]*/, ""), "bench.toml");
  const transfer = new DataTransfer();
  transfer.items.add(new File([log], "bench.csv"));
  dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, cancelable: true }));
  await expect("the columns of a log", () => document.getElementById("insert-log"));
  press("insert-log");
  await expect("results of a log", () => done() && studio.results.results.log?.rows?.length > 0);
  studio.files.clear();
}

async function cancelling() {
  const { text } = example("double-integrator");
  // A sweep that takes long.
  await study(text);
  studio.show(text.replace("count = 5", "count = 200\nensemble = 200"), "long.toml");
  const waits = () => studio.running || !document.getElementById("question").hidden;
  if (!(await expect("a long run", waits))) return;
  if (!studio.running) document.querySelector("#question button").click();
  await expect("a run to cancel", () => studio.running);
  await pause(300);
  press("cancel");
  equal("the run after cancelling", studio.running, null);
  await study(text);
}

async function takeHome() {
  const archive = await studio.zip();
  equal("the archive", archive && decode(archive.bytes.slice(0, 2)), "PK");
  const names = archive ? decode(archive.bytes) : "";
  for (const name of [
    "results/report.html",
    "results/study.json",
    "results/certificates/linear.json",
    "code/sampled/c/sampled.c",
  ]) {
    if (!names.includes(name)) wrong.push(`${name} is not in the archive`);
  }
  await expect(
    "the report in its frame",
    () => studio.frame && studio.frame.srcdoc === decode(studio.output("report.html").bytes),
  );
  press("verify-all");
  await expect("certificates", () => document.querySelectorAll("#verified pre").length === 3);
  equal(
    "certificates",
    [...document.querySelectorAll("#verified pre")].map((said) => /: Proved$/m.test(said.textContent)),
    [true, true, true],
  );
  const text = studio.editor.text;
  const [, letters] = (await studio.address()).split("#study=");
  equal("the study of a link", JSON.parse(await fromLetters(letters, 1e6)).text, text);
  location.hash = `study=${letters.slice(0, -9)}`;
  await expect("the message of a cut link", () => banners().some((said) => /^The link cannot be read/.test(said)));
  equal("the study after a cut link", studio.editor.text, text);
}

// What the page reads of a text is what the module reads.
async function outlines() {
  for (const { name, text } of studio.about.templates) {
    const named = new Map(
      studio.templateFiles
        .filter((file) => file.name.startsWith(`${name}/`))
        .map((file) => [file.name.slice(name.length + 1), file.bytes]),
    );
    const { json } = await studio.checker.ask(
      { do: "check", name: `${name}.toml`, study: text, format: "toml", estimate: false },
      { named },
    );
    const place = places(text);
    const toml = new Toml(text);
    for (const { path, from, to, kind } of json.outline) {
      const node = toml.get(path);
      if (!node) wrong.push(`${name}: the page does not read ${path.join(".")}`);
      else if (!["table", "tables"].includes(node.kind) && (node.from !== place(from) || node.to !== place(to)))
        wrong.push(
          `${name}: ${path.join(".")} (${kind}) from ${node.from} to ${node.to} for ${place(from)} to ${place(to)}`,
        );
    }
  }
}

(async () => {
  const found = {
    errors,
    requests,
    wrong,
    wide: [],
    dark: document.documentElement.dataset.theme === "dark",
  };
  try {
    HTMLAnchorElement.prototype.click = () => {};
    await studio.ready;
    if (await expect("results of the first visit", done)) {
      found.milliseconds = Math.round(performance.now());
      await typing(found);
      await form();
      await takeHome();
      await logs();
      await cancelling();
      await words();
      await outlines();
      for (const [side, ids] of [
        ["study", ["text", "form"]],
        ["results", ["report", "summary", "certificates", "files", "export", "log"]],
      ]) {
        for (const id of ids) {
          press(`tab-${id}`);
          for (const width of [400, 800, 1400])
            found.wide.push(...(await atWidth(width, side)).map((what) => `${id} ${what}`));
        }
      }
    }
    requests.push(
      ...performance
        .getEntriesByType("resource")
        .map(({ name }) => name)
        .filter((name) => !/^(blob|data):/.test(name)),
    );
  } catch (error) {
    errors.push(String(error.stack ?? error));
  }
  clearInterval(spinning);
  // From the first moment of the page on.
  errors.push(...studio.faults);
  const result = document.createElement("pre");
  result.id = "test-result";
  result.textContent = JSON.stringify(found);
  document.body.append(result);
})();
