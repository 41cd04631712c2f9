// The module, in workers.

let workerAddress = null;
const newWorker = () => {
  workerAddress ??= URL.createObjectURL(new Blob([at("worker").textContent], { type: "text/javascript" }));
  return new Worker(workerAddress);
};

// The module, decompressed and compiled by a worker, whose memory goes with it.
function compiledModule(unpack, packed) {
  const worker = newWorker();
  return new Promise((done, fail) => {
    worker.onmessage = ({ data }) => (data.compiled ? done(data.compiled) : fail(new Error(data.failure)));
    worker.onerror = (event) => fail(new Error(event.message || "the worker ended"));
    worker.postMessage({ unpack, packed }, [packed.buffer]);
  }).finally(() => worker.terminate());
}

// A worker with the module. A request that is cancelled ends its worker; the next one starts another.
class Engine {
  constructor(compiled) {
    this.compiled = compiled;
    this.count = 0;
    this.pending = new Map();
    this.sent = new Map();
  }

  start() {
    this.worker = newWorker();
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
