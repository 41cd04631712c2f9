"use strict";
const errors = [];
addEventListener("error", (event) => errors.push(String(event.message)));
addEventListener("unhandledrejection", (event) => errors.push(String(event.reason)));
const consoleError = console.error;
console.error = (...words) => { errors.push(words.join(" ")); consoleError(...words); };
(async () => {
  const found = { errors, wide: [], results: [], moved: true, dark: matchMedia("(prefers-color-scheme: dark)").matches };
  try {
    await plotting;
    for (const block of await live) {
      const results = [];
      for (const [gain, cubic, noise, error, period] of POSITIONS) {
        const outcome = block.answer(block.exports.luenberger_run(gain, cubic, noise, error, period));
        results.push([outcome, block.answer(block.exports.luenberger_verify(gain, cubic, period))]);
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
    }
    const width = document.documentElement.clientWidth;
    for (const element of document.querySelectorAll("body *")) {
      if (element.closest(".wide, .formulas, pre, nav, svg, math") || !element.getClientRects().length) continue;
      if (element.getBoundingClientRect().right > width + 1) found.wide.push(`${element.tagName} ${element.id} ${element.className}`);
    }
    if (document.documentElement.scrollWidth > width) found.wide.push("the page");
  } catch (error) {
    errors.push(String(error));
  }
  const result = document.createElement("pre");
  result.id = "test-result";
  result.textContent = JSON.stringify(found);
  document.body.append(result);
})();
