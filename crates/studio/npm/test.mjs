// Tries every request on a module: node test.mjs luenberger_studio.wasm
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { load, StudioError } from "./index.js";

const file = process.argv[2] ?? process.env.LUENBERGER_STUDIO;
assert(file, "the module: node test.mjs luenberger_studio.wasm");
const studio = await load(await readFile(file));
const text = (bytes) => new TextDecoder().decode(bytes);

// The page's worker has the same two functions for messages.
const own = await readFile(new URL("index.js", import.meta.url), "utf8");
const worker = await readFile(new URL("../assets/worker.js", import.meta.url), "utf8");
const part = (code, name) =>
  code.slice(code.indexOf(`function ${name}(`), code.indexOf("\n}\n", code.indexOf(`function ${name}(`)));
for (const name of ["packed", "unpacked"]) assert.equal(part(own, name), part(worker, name));

const about = studio.about();
const template = (name) => about.templates.find((one) => one.name === name).text;
const study = template("double-integrator");

const checked = studio.check(study);
assert.deepEqual(checked.diagnostics, []);
assert.deepEqual(checked.plant.states, ["position", "velocity"]);
assert.deepEqual(
  checked.observers.map(({ name, kind }) => [name, kind]),
  [
    ["linear", "luenberger"],
    ["cubic", "cubic"],
    ["sampled", "sampled-cubic"],
  ],
);

// A mistake on the line where it was made, behind a letter of two bytes.
const wrong = `# \u00e9\n${study.replace("poles = [-2, -5]", "pols = [-2, -5]")}`;
const [mistake] = studio.check(wrong).diagnostics;
assert.equal(text(new TextEncoder().encode(wrong).slice(mistake.from, mistake.to)), "pols");
assert.equal(wrong.split("\n")[mistake.line - 1], "pols = [-2, -5]");
assert.throws(
  () => studio.run(wrong),
  (error) => error instanceof StudioError && error.diagnostics.length === 1 && /pols/.test(error.rendered),
);

let told = 0;
const run = studio.run(study, {}, { figures: false, progress: () => told++ });
// theta = rho = 10, poles -2 and -5: L = [7; 10] by hand, since s^2 + 7 s + 10 has these roots.
const gain = run.results.observers[0].design.matrices.find(({ name }) => name === "L").rows;
assert.deepEqual(
  gain.map(([value]) => Math.round(value * 1e9) / 1e9),
  [7, 10],
);
assert.deepEqual(
  run.results.observers.map(({ design }) => design.verdict),
  ["proved", "proved", "proved"],
);
assert.deepEqual(JSON.parse(text(run.files["study.json"])), run.results);
assert(run.files["report.html"].length > 1e5 && told > 0);
assert(!Object.keys(run.files).some((name) => name.startsWith("figures/")));

const certificate = text(run.files["certificates/linear.json"]);
assert.equal(studio.verify(certificate).verdict, "proved");
assert.equal(studio.verify(certificate.replace('"title": "', '"title": "our ')).verdict, "rejected");
assert.equal(studio.verify("no certificate").verdict, "unreadable");

for (const [language, name] of [
  ["c", "sampled.c"],
  ["rust", "Cargo.toml"],
  ["fmu2", null],
  ["fmu3", null],
]) {
  const { files } = studio.export(study, {}, { observer: "sampled", language });
  assert(name === null ? Object.keys(files).length > 0 : files[name], language);
}
assert.throws(() => studio.export(study, {}, { observer: "nobody" }), StudioError);

const log = Object.fromEntries(Object.entries(about.files).map(([name, bytes]) => [name.split("/").pop(), bytes]));
const bench = template("measured-log");
const columns = studio.columns("measured-log.csv", log["measured-log.csv"], bench);
assert.equal(
  columns.rows,
  text(log["measured-log.csv"])
    .trim()
    .split("\n")
    .filter((line) => !line.startsWith("#")).length - 1,
);
assert(columns.columns.includes("voltage") && /^\[log\]/m.test(columns.suggestion));
assert.equal(studio.run(bench, log, { figures: false }).results.observers.length, 3);
assert.throws(() => studio.run(bench, {}, { figures: false }), StudioError);

const archive = studio.zip({ "a/b.txt": "text" });
assert.equal(text(archive.slice(0, 2)), "PK");
assert.throws(() => studio.zip({ "../b.txt": "text" }), StudioError);
assert.throws(() => studio.ask({ do: "nothing" }), StudioError);
console.log("every request has its answer");
