// Studies in JavaScript: requests to the WebAssembly module of the studio, and its answers.

/** What the module says of a study that it cannot read, or of a request without a result. */
export class StudioError extends Error {
  constructor({ message, diagnostics = [] }, rendered = "") {
    super(message);
    this.name = "StudioError";
    this.diagnostics = diagnostics;
    this.rendered = rendered;
  }
}

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

const bytesOf = (content) => (typeof content === "string" ? new TextEncoder().encode(content) : content);
const listed = (files) => Object.entries(files).map(([name, content]) => ({ name, bytes: bytesOf(content) }));
const described = (study) =>
  typeof study === "string" ? { study } : { study: study.text, name: study.name, format: study.format };

/**
 * Compiles the module (its bytes, decompressed, or a `WebAssembly.Module`) and gives what asks it.
 * A request runs in the calling thread until it is done; in a page, load it in a worker.
 */
export async function load(module) {
  const compiled = module instanceof WebAssembly.Module ? module : await WebAssembly.compile(module);
  return new Studio(compiled);
}

export class Studio {
  #compiled;
  #exports = null;
  #progress = null;
  #panic = null;

  constructor(compiled) {
    this.#compiled = compiled;
  }

  #instance() {
    const text = (at, length) =>
      new TextDecoder().decode(new Uint8Array(this.#exports.memory.buffer, at, length).slice());
    const luenberger = {
      now: () => performance.now(),
      progress: (at, length) => this.#progress?.(JSON.parse(text(at, length))),
      panicked: (at, length) => {
        this.#panic = text(at, length);
      },
    };
    this.#panic = null;
    this.#exports = new WebAssembly.Instance(this.#compiled, { luenberger }).exports;
  }

  /** A request as the module takes it; throws what is wrong with it. */
  ask(json, files = {}, progress = null) {
    if (!this.#exports) this.#instance();
    this.#progress = progress;
    let answer;
    try {
      const exports = this.#exports;
      const request = packed(json, listed(files));
      const at = exports.allocate(request.length) >>> 0;
      new Uint8Array(exports.memory.buffer, at, request.length).set(request);
      const from = exports.call(at, request.length) >>> 0;
      const length = new DataView(exports.memory.buffer).getUint32(from, true);
      answer = unpacked(new Uint8Array(exports.memory.buffer, from + 4, length).slice());
      exports.release(from);
    } catch (error) {
      // What is left of the instance is in no known state: the next request has another one.
      const message = this.#panic ?? `the module stopped: ${error.message}`;
      this.#exports = null;
      throw new StudioError({ message });
    }
    const { error, ...rest } = answer.json;
    if (error) throw new StudioError(error, rest.rendered);
    return { ...rest, files: Object.fromEntries(answer.files.map(({ name, bytes }) => [name, bytes])) };
  }

  /** Version, schema of studies, kinds and templates; files of templates are named TEMPLATE/FILE. */
  about() {
    return this.ask({ do: "about" });
  }

  /** Mistakes of a study, its outline and what it would cost to run; a study with mistakes is no error. */
  check(study, files = {}) {
    return this.ask({ do: "check", ...described(study) }, files);
  }

  /** Runs a study: its results, and the files of the results folder. */
  run(study, files = {}, { step = "run", figures = true, limit_seconds = null, progress = null } = {}) {
    return this.ask({ do: "run", step, figures, limit_seconds, ...described(study) }, files, progress);
  }

  /** The step of an observer as C ("c"), Rust ("rust") or an FMU ("fmu2", "fmu3"). */
  export(
    study,
    files = {},
    { observer = null, language = "c", period = null, scalar = "f64", feedback = false, unproved = false } = {},
  ) {
    return this.ask(
      { do: "export", observer, language, period, scalar, feedback, unproved, ...described(study) },
      files,
    );
  }

  /** Whether a certificate holds, verified from its data alone. */
  verify(certificate, name = "certificate.json") {
    return this.ask({ do: "verify" }, { [name]: certificate });
  }

  /** Which observers to use, of all kinds. */
  advise(study, files = {}, { limit_seconds = null, progress = null } = {}) {
    return this.ask({ do: "advise", limit_seconds, ...described(study) }, files, progress);
  }

  /** What the table [tune] names, fitted to the log. */
  tune(study, files = {}, { limit_seconds = null, progress = null } = {}) {
    return this.ask({ do: "tune", limit_seconds, ...described(study) }, files, progress);
  }

  /** The columns of a log, and a table [log] for the study, if one is given. */
  columns(name, csv, study = null) {
    return this.ask({ do: "columns", ...(study === null ? {} : described(study)) }, { [name]: csv });
  }

  /** All files in one archive. */
  zip(files) {
    return this.ask({ do: "zip" }, files).files["archive.zip"];
  }
}
