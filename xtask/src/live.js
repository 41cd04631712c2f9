"use strict";
const errors = [];
addEventListener("error", (event) => errors.push(String(event.message)));
addEventListener("unhandledrejection", (event) => errors.push(String(event.reason)));
const consoleError = console.error;
console.error = (...words) => { errors.push(words.join(" ")); consoleError(...words); };

// The elements that are wider than the page, but for those within an element that scrolls.
function wide(page) {
  const { clientWidth, scrollWidth } = page.documentElement;
  const found = scrollWidth > clientWidth ? [`the page, ${scrollWidth} of ${clientWidth} px`] : [];
  const scrolls = (element) => element && element !== page.body
    && (page.defaultView.getComputedStyle(element).overflowX !== "visible" || scrolls(element.parentElement));
  for (const element of page.querySelectorAll("body *")) {
    if (element.closest("svg, math") || !element.getClientRects().length) continue;
    const over = element.getBoundingClientRect().right > clientWidth + 1;
    if (over && !scrolls(element.parentElement)) found.push(`${element.tagName} ${element.id} ${element.className}`);
  }
  return found;
}

// The same at 400 px, less than the least width of a window: the page within a frame, without its figures.
async function onPhone() {
  const copy = document.documentElement.cloneNode(true);
  for (const script of copy.querySelectorAll("script, iframe")) script.remove();
  for (const plot of copy.querySelectorAll(".plot")) plot.replaceChildren();
  const frame = document.createElement("iframe");
  frame.style.cssText = "width: 400px; height: 800px; border: 0";
  const loaded = new Promise((done) => frame.addEventListener("load", done));
  frame.srcdoc = `<!DOCTYPE html>${copy.outerHTML}`;
  document.body.append(frame);
  await loaded;
  const found = wide(frame.contentDocument).map((what) => `at 400 px: ${what}`);
  frame.remove();
  return found;
}

// The badges that differ from the verdict where one slider is at its end and the others are as in the report.
async function badges(block) {
  const wrong = [];
  for (const moved of block.sliders) {
    for (const slider of block.sliders) slider.value = slider === moved ? slider.max : slider.defaultValue;
    moved.dispatchEvent(new Event("input"));
    moved.dispatchEvent(new Event("change"));
    const factors = ["gain", "cubic", "noise", "error", "period"].map((name) => block.factor(name));
    const verdicts = JSON.parse(block.answer(block.exports.luenberger_verify(...factors)));
    const expected = verdicts.map((verdict) => !verdict ? "no certificate" : verdict === "elsewhere" ? "see the report"
      : "proved" in verdict || "proved-anew" in verdict ? "proved" : "not certified");
    const shown = () => [...block.root.querySelectorAll("tbody .badge")].map((badge) => badge.textContent);
    for (let wait = 0; wait < 600 && shown().join() !== expected.join(); wait++) {
      await new Promise((done) => setTimeout(done, 100));
    }
    if (shown().join() !== expected.join()) wrong.push(`${moved.dataset.slider}: ${shown()} for ${expected}`);
  }
  return wrong;
}

(async () => {
  const found = { errors, wide: [], results: [], moved: true, badges: [], dark: matchMedia("(prefers-color-scheme: dark)").matches };
  try {
    await plotting;
    for (const block of await live) {
      const results = [];
      for (const [gain, cubic, noise, error, period] of POSITIONS) {
        const outcome = block.answer(block.exports.luenberger_run(gain, cubic, noise, error, period));
        results.push([outcome, block.answer(block.exports.luenberger_verify(gain, cubic, noise, error, period))]);
      }
      found.results.push(results);
      // Twice the gain, which is the second of the positions.
      const slider = block.root.querySelector("[data-slider=gain]");
      const curves = () => block.root.querySelector("[data-live=norm]").data.filter((trace) => trace.showlegend !== false);
      const before = JSON.stringify(curves().map((trace) => trace.y));
      slider.value = 1;
      slider.dispatchEvent(new Event("input"));
      slider.dispatchEvent(new Event("change"));
      const expected = JSON.parse(results[1][0]).runs.filter((run) => run.t.length).map((run) => run.norm);
      let after = before;
      for (let wait = 0; wait < 600 && after !== JSON.stringify(expected); wait++) {
        await new Promise((done) => setTimeout(done, 100));
        after = JSON.stringify(curves().map((trace) => trace.y));
      }
      found.moved &&= after !== before && after === JSON.stringify(expected);
      found.badges.push(...await badges(block));
    }
    found.wide = [...wide(document), ...await onPhone()];
  } catch (error) {
    errors.push(String(error));
  }
  const result = document.createElement("pre");
  result.id = "test-result";
  result.textContent = JSON.stringify(found);
  document.body.append(result);
})();
