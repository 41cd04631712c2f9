
// The live blocks: experiments that the module runs while sliders are moved.
class Live {
  constructor(root, data, exports) {
    Object.assign(this, { root, exports, colours: data.colours, experiment: data.experiment });
    this.sliders = [...root.querySelectorAll("[data-slider]")];
    this.state = root.querySelector("[data-state]");
    this.note = root.querySelector(".live-note");
    this.slow = 0;
    this.verdicts = [];
    const bytes = new TextEncoder().encode(JSON.stringify(data.experiment));
    const buffer = exports.luenberger_buffer(bytes.length);
    new Uint8Array(exports.memory.buffer, buffer, bytes.length).set(bytes);
    const failure = this.answer(exports.luenberger_load(buffer, bytes.length));
    if (failure) throw new Error(failure);
    this.experiment.states.forEach((name, k) => this.state.add(new Option(name, k)));
    this.state.addEventListener("change", () => this.draw());
    for (const slider of this.sliders) {
      slider.addEventListener("input", () => this.moved(false));
      slider.addEventListener("change", () => this.moved(true));
    }
    root.querySelector("[data-reset]").addEventListener("click", () => {
      for (const slider of this.sliders) slider.value = slider.defaultValue;
      this.moved(true);
    });
    dark.addEventListener("change", () => this.draw());
    this.run();
    this.reference = this.outcome;
    this.verify();
    this.draw();
  }

  answer(length) {
    const { memory, luenberger_answer } = this.exports;
    return new TextDecoder().decode(new Uint8Array(memory.buffer, luenberger_answer(), length));
  }

  // The factor of a slider; the lowest position of the cubic gain is none.
  factor(name) {
    const slider = this.sliders.find((slider) => slider.dataset.slider === name);
    if (!slider) return 1;
    if (slider.dataset.scale === "linear") return Number(slider.value);
    return name === "cubic" && slider.value === slider.min ? 0 : 2 ** Number(slider.value);
  }

  moved(ended) {
    for (const slider of this.sliders) {
      const factor = this.factor(slider.dataset.slider);
      slider.nextElementSibling.textContent = `\u00d7 ${short(factor, 3)}`;
      slider.setAttribute("aria-valuetext", `${short(factor, 3)} times the value of the report`);
    }
    // A run that takes long waits for the end of the movement.
    if (!this.pending && (ended || this.slow < 250)) {
      this.pending = requestAnimationFrame(() => {
        this.pending = 0;
        this.run();
        this.draw();
      });
    }
    if (this.factors().join() !== this.verified) {
      clearTimeout(this.verifying);
      this.verifying = setTimeout(() => { this.verify(); this.table(); }, 120);
    }
    this.table();
  }

  // A certificate can suppose bounds of the noise and of the first error: all of them decide on a verdict.
  factors() {
    return ["gain", "cubic", "noise", "error", "period"].map((name) => this.factor(name));
  }

  run() {
    const start = performance.now();
    this.text = this.answer(this.exports.luenberger_run(...this.factors()));
    this.outcome = JSON.parse(this.text);
    this.slow = performance.now() - start;
    this.note.textContent = `simulated in ${short(this.slow, 2)} ms` + (this.slow < 250 ? "" : ", when a slider is released");
  }

  verify() {
    const factors = this.factors();
    this.verified = factors.join();
    this.verdictText = this.answer(this.exports.luenberger_verify(...factors));
    this.verdicts = JSON.parse(this.verdictText);
  }

  draw() {
    this.table();
    const ink = getComputedStyle(document.documentElement).getPropertyValue("--ink").trim();
    const { states, units, time_unit, scale } = this.experiment;
    const time = time_unit ? `time t (${time_unit})` : "time t";
    const colour = (k) => (this.colours[k % this.colours.length] === "#000000" ? ink : this.colours[k % this.colours.length]);
    const k = Number(this.state.value);
    const line = (name, x, y, colour, dash, width = 1.8) => ({ name, x, y, mode: "lines", line: { color: colour, dash, width } });
    const neutral = this.text === this.first || !this.reference;
    this.first ??= this.text;
    const before = neutral ? [] : this.reference.runs.filter((run) => run.t.length);
    // Metres and pascals have no norm in common: without a scale the error is that of the chosen state.
    const error = (run) => (scale ? run.norm : run.x[k].map((x, at) => Math.abs(x - run.xhat[k][at])));
    const norm = [], state = [];
    for (const [i, run] of before.entries()) {
      norm.push({ ...line(`${run.name}, report`, run.t, error(run), colour(i), "dot", 1), showlegend: false, opacity: 0.55 });
    }
    this.outcome.runs.forEach((run, i) => {
      if (!run.t.length) return;
      if (!state.length) state.push(line(states[k], run.t, run.x[k], ink, "solid", 1.4));
      norm.push(line(run.name, run.t, error(run), colour(i), "solid"));
      state.push(line(run.name, run.t, run.xhat[k], colour(i), "solid"));
    });
    const values = norm.flatMap((trace) => trace.y).filter((y) => y > 0);
    const decades = Math.log10(values.reduce((a, b) => Math.max(a, b), 1e-300) / values.reduce((a, b) => Math.min(a, b), 1e300));
    const axis = { zeroline: false, showline: true, ticks: "outside", ticklen: 4, exponentformat: "power", automargin: true };
    const layout = (title, type) => themed({
      margin: { l: 60, r: 12, t: 30, b: 44 }, height: 300, hovermode: "x unified", uirevision: "kept",
      legend: { orientation: "h", y: 1.03, yanchor: "bottom" }, xaxis: { ...axis, title: { text: time } },
      yaxis: { ...axis, title: { text: title }, type, ...(type === "log" && decades > 1 ? { dtick: Math.ceil(decades / 6) } : {}) },
    });
    const unit = units[k] ? ` (${units[k]})` : "";
    const config = { responsive: true, displayModeBar: false };
    const [left, right] = ["norm", "state"].map((name) => this.root.querySelector(`[data-live="${name}"]`));
    for (const plot of [left, right]) plot.style.height = "300px";
    Plotly.react(left, norm, layout(scale ? "|e|" : `|error of ${states[k]}|${unit}`, "log"), config);
    Plotly.react(right, state, layout(states[k] + unit, "linear"), config);
  }

  table() {
    const body = this.root.querySelector("tbody");
    const stale = this.factors().join() !== this.verified;
    const rows = this.outcome.runs.map((run, i) => {
      const row = document.createElement("tr");
      const cell = (text, kind) => {
        const cell = row.insertCell();
        cell.textContent = text;
        if (kind) cell.className = kind;
        return cell;
      };
      const swatch = document.createElement("span");
      swatch.className = "swatch";
      swatch.style.background = this.colours[i % this.colours.length];
      cell(run.name).prepend(swatch);
      if (run.failure) {
        cell(run.failure, "why").colSpan = 4;
      } else {
        const { rms, peak, settled, last } = (this.experiment.scale ? run.scores : run.states?.[Number(this.state.value)]) ?? {};
        [rms, peak].forEach((x) => cell(short(x, 4), "number"));
        cell(settled === null ? "no" : short(settled, 4), "number");
        cell(short(last, 4), "number");
      }
      const verdict = this.verdicts[i];
      const badge = document.createElement("span");
      const why = document.createElement("span");
      why.className = "why";
      if (!verdict) {
        [badge.className, badge.textContent] = ["badge open", "no certificate"];
      } else if (verdict === "elsewhere") {
        [badge.className, badge.textContent] = ["badge open", "see the report"];
      } else if (stale) {
        [badge.className, badge.textContent] = ["badge open", "checking"];
      } else if ("proved" in verdict) {
        [badge.className, badge.textContent] = ["badge good", "proved"];
        if (verdict.proved !== null) why.textContent = ` margin >= ${below(verdict.proved, 4)}`;
      } else if ("proved-anew" in verdict) {
        [badge.className, badge.textContent] = ["badge good", "proved"];
        why.textContent = " that the error tends to 0, by a P for these gains; the report's rate is not";
      } else {
        [badge.className, badge.textContent] = ["badge bad", "not certified"];
        why.textContent = ` ${verdict.open}`;
      }
      cell("").append(badge, why);
      return row;
    });
    body.replaceChildren(...rows);
  }
}

function short(x, digits) {
  return x === null || x === undefined ? "\u2013" : String(Number(x.toPrecision(digits)));
}

// A lower bound is rounded down.
function below(x, digits) {
  const near = Number(x.toPrecision(digits));
  const unit = 10 ** (Math.floor(Math.log10(x)) + 1 - digits);
  return String(near > x ? Number((near - unit).toPrecision(digits)) : near);
}

// Every block has a module of its own, which holds its experiment.
const live = (async () => {
  const roots = [...document.querySelectorAll(".live")];
  if (!roots.length) return [];
  const module = await WebAssembly.compile(await (await unpack("live-module")).arrayBuffer());
  await plotting;
  return Promise.all(roots.map(async (root) => {
    try {
      const { exports } = await WebAssembly.instantiate(module);
      return new Live(root, JSON.parse(document.getElementById(`${root.id}-data`).textContent), exports);
    } catch (error) {
      root.querySelector(".live-note").textContent = `This part does not run in this browser: ${error.message}`;
      console.error(error);
      return null;
    }
  }));
})();
