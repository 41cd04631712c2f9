// Runs studies with the module of the studio: node studio-node.mjs MODULE OUT STUDY...
//
// The results of FOLDER/study.toml are written to OUT/FOLDER, by the name of its folder; files of data are those in it
// that end in .csv. For each study a line of JSON is printed: its name, seconds, bytes of memory, and the error if
// there is one.
import { mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { basename, dirname, join } from "node:path";

const [modulePath, out, ...studies] = process.argv.slice(2);
const compiled = await WebAssembly.compile(readFileSync(modulePath));

// A new instance for each study, as the page has after a run that ended badly.
async function start() {
  const told = [];
  let memory;
  const text = (at, length) => new TextDecoder().decode(new Uint8Array(memory.buffer, at, length));
  const luenberger = {
    now: () => performance.now(),
    progress: (at, length) => told.push(JSON.parse(text(at, length))),
    panicked: (at, length) => { throw new Error(text(at, length)); },
  };
  const { exports } = await WebAssembly.instantiate(compiled, { luenberger });
  memory = exports.memory;
  const ask = (json, files) => {
    const listed = files.map(({ name, bytes }) => ({ name, bytes: bytes.length }));
    const head = new TextEncoder().encode(JSON.stringify({ ...json, files: listed }));
    const request = new Uint8Array(4 + head.length + files.reduce((sum, { bytes }) => sum + bytes.length, 0));
    new DataView(request.buffer).setUint32(0, head.length, true);
    request.set(head, 4);
    let at = 4 + head.length;
    for (const { bytes } of files) { request.set(bytes, at); at += bytes.length; }
    const buffer = exports.allocate(request.length) >>> 0;
    new Uint8Array(memory.buffer).set(request, buffer);
    const answer = exports.call(buffer, request.length) >>> 0;
    const view = new DataView(memory.buffer);
    const length = view.getUint32(answer, true);
    const found = new Uint8Array(memory.buffer, answer + 4, length).slice();
    exports.release(answer);
    const jsonLength = new DataView(found.buffer).getUint32(0, true);
    const answered = JSON.parse(new TextDecoder().decode(found.subarray(4, 4 + jsonLength)));
    let from = 4 + jsonLength;
    const contents = answered.files.map(({ name, bytes }) => ({ name, bytes: found.subarray(from, from += bytes) }));
    return { answered, contents };
  };
  return { ask, told, size: () => memory.buffer.byteLength };
}

for (const study of studies) {
  const folder = dirname(study);
  const name = basename(folder);
  const began = performance.now();
  const line = { name };
  try {
    const { ask, told, size } = await start();
    const data = readdirSync(folder).filter((file) => file.endsWith(".csv"));
    const files = data.map((file) => ({ name: file, bytes: readFileSync(join(folder, file)) }));
    const request = { do: "run", study: readFileSync(study, "utf8"), name: basename(study) };
    const { answered, contents } = ask(request, files);
    line.seconds = (performance.now() - began) / 1000;
    line.memory = size();
    line.progress = told.length;
    if (answered.error) line.error = answered.error.message;
    for (const { name: file, bytes } of contents) {
      const path = join(out, name, file);
      mkdirSync(dirname(path), { recursive: true });
      writeFileSync(path, bytes);
    }
  } catch (error) {
    line.error = String(error && error.stack || error);
  }
  console.log(JSON.stringify(line));
}
