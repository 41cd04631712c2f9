"use strict";
// The module of the studio in a worker: one request after the other, in messages of JSON and files.

// A message: the length of the JSON, the JSON with the names and lengths of the files, the bytes of the files.
function packed(json, files) {
  const names = files.map(({ name, bytes }) => ({ name, bytes: bytes.length }));
  const head = new TextEncoder().encode(JSON.stringify({ ...json, files: names }));
  const message = new Uint8Array(4 + head.length + files.reduce((sum, { bytes }) => sum + bytes.length, 0));
  new DataView(message.buffer).setUint32(0, head.length, true);
  message.set(head, 4);
  let at = 4 + head.length;
  for (const { bytes } of files) {
    message.set(bytes, at);
    at += bytes.length;
  }
  return message;
}

function unpacked(message) {
  const length = new DataView(message.buffer, message.byteOffset).getUint32(0, true);
  const { files = [], ...json } = JSON.parse(new TextDecoder().decode(message.subarray(4, 4 + length)));
  let at = 4 + length;
  const split = files.map(({ name, bytes }) => ({ name, bytes: message.slice(at, (at += bytes)) }));
  return { json, files: split };
}

// An instance of the module: `ask` sends it a request and returns its answer.
class Module {
  constructor(compiled, progress) {
    const text = (at, length) =>
      new TextDecoder().decode(new Uint8Array(this.exports.memory.buffer, at, length).slice());
    const luenberger = {
      now: () => performance.now(),
      progress: (at, length) => progress(JSON.parse(text(at, length))),
      panicked: (at, length) => {
        this.panic = text(at, length);
      },
    };
    this.exports = new WebAssembly.Instance(compiled, { luenberger }).exports;
  }

  ask(json, files) {
    const { exports } = this;
    const request = packed(json, files);
    const at = exports.allocate(request.length) >>> 0;
    new Uint8Array(exports.memory.buffer, at, request.length).set(request);
    const from = exports.call(at, request.length) >>> 0;
    const length = new DataView(exports.memory.buffer).getUint32(from, true);
    const answer = unpacked(new Uint8Array(exports.memory.buffer, from + 4, length).slice());
    exports.release(from);
    return answer;
  }
}

// The bytes of a module that LZMA has compressed.
function decompressed(unpack, packed) {
  const { exports } = new WebAssembly.Instance(new WebAssembly.Module(unpack), {});
  const at = exports.allocate(packed.length) >>> 0;
  new Uint8Array(exports.memory.buffer, at, packed.length).set(packed);
  const from = exports.unpack(at, packed.length) >>> 0;
  if (from === 0) throw new Error("it is damaged");
  const length = new DataView(exports.memory.buffer).getUint32(from, true);
  return new Uint8Array(exports.memory.buffer, from + 4, length);
}

let compiled = null,
  module = null,
  asked = 0;
const kept = new Map();

onmessage = ({ data }) => {
  if (data.packed) {
    try {
      postMessage({ compiled: new WebAssembly.Module(decompressed(data.unpack, data.packed)) });
    } catch (error) {
      postMessage({ failure: String(error.message ?? error) });
    }
    return;
  }
  if (data.compiled) {
    compiled = data.compiled;
    return;
  }
  for (const { name, bytes } of data.keep ?? []) kept.set(name, bytes);
  for (const name of data.forget ?? []) kept.delete(name);
  if (!data.json) return;
  asked = data.id;
  try {
    module ??= new Module(compiled, (progress) => postMessage({ id: asked, progress }));
    const named = (data.names ?? []).filter((name) => kept.has(name)).map((name) => ({ name, bytes: kept.get(name) }));
    const { json, files } = module.ask(data.json, [...named, ...(data.files ?? [])]);
    postMessage(
      { id: data.id, json, files },
      files.map(({ bytes }) => bytes.buffer),
    );
  } catch (error) {
    const memory = module ? module.exports.memory.buffer.byteLength : 0;
    postMessage({
      id: data.id,
      failure: module?.panic ?? String(error.message ?? error),
      panicked: Boolean(module?.panic),
      memory,
    });
    // What is left of the instance is in no known state.
    module = null;
  }
};
