let pictures = {};
const dark = matchMedia("(prefers-color-scheme: dark)");

function themed(layout) {
  const style = getComputedStyle(document.documentElement);
  const [ink, grid] = ["--ink", "--grid"].map((name) => style.getPropertyValue(name).trim());
  const copy = { ...layout, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)" };
  copy.font = { color: ink, size: 14, family: getComputedStyle(document.body).fontFamily };
  copy.modebar = { bgcolor: "rgba(0,0,0,0)", color: grid, activecolor: ink };
  copy.hoverlabel = { bgcolor: style.getPropertyValue("--card").trim(), font: { color: ink } };
  for (const key of Object.keys(copy).filter((key) => /^[xy]axis/.test(key))) {
    copy[key] = { ...copy[key], gridcolor: grid, linecolor: ink, tickcolor: ink };
  }
  return copy;
}

// Panels side by side are stacked where the page is narrow.
const narrow = matchMedia("(max-width: 40rem)");
function stacked(layout) {
  const insets = layout.meta?.insets ?? [];
  const numbers = Object.keys(layout).filter((key) => key.startsWith("xaxis")).map((key) => key.slice(5))
    .filter((n) => insets.every(([inset]) => inset !== n));
  if (!narrow.matches || numbers.every((n) => layout[`xaxis${n}`].domain[0] === 0)) return layout;
  const { t, b } = layout.margin, gap = 95;
  const before = layout.height - t - b;
  const heights = numbers.map((n) => layout[`yaxis${n}`].domain).map(([from, to]) => (to - from) * before);
  const inner = heights.reduce((sum, height) => sum + height, gap * (numbers.length - 1));
  const copy = { ...layout, height: inner + t + b, legend: { ...layout.legend, y: 1 + (t - 34) / inner } };
  let top = 1;
  for (const [i, n] of numbers.entries()) {
    const bottom = Math.max(0, top - heights[i] / inner);
    copy[`xaxis${n}`] = { ...layout[`xaxis${n}`], domain: [0, 1] };
    copy[`yaxis${n}`] = { ...layout[`yaxis${n}`], domain: [bottom, top] };
    top = bottom - gap / inner;
  }
  // An inset keeps its place in its panel.
  for (const [inset, of] of insets) {
    for (const axis of ["xaxis", "yaxis"]) {
      const [from, to] = layout[axis + of].domain, [low, high] = copy[axis + of].domain;
      const moved = (place) => low + (place - from) / (to - from) * (high - low);
      copy[axis + inset] = { ...layout[axis + inset], domain: layout[axis + inset].domain.map(moved) };
    }
  }
  return copy;
}

function draw() {
  const config = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d"] };
  if (narrow.matches) config.displayModeBar = false;
  const ink = getComputedStyle(document.documentElement).getPropertyValue("--ink").trim();
  for (const place of document.querySelectorAll("[data-picture]")) {
    const { data, layout: wide } = pictures[place.dataset.picture];
    const layout = stacked(wide);
    // Black curves take the colour of the text, so that they are seen on a dark page.
    const traces = data.map((trace) => trace.line?.color === "#000000"
      ? { ...trace, line: { ...trace.line, color: ink }, marker: { ...trace.marker, color: ink } } : trace);
    // When the window changes its size, a figure takes that of its element.
    place.style.height = `${layout.height}px`;
    Plotly.react(place, traces, themed(layout), config);
  }
}

// The values of the letters in base 85: five letters are four bytes.
const digits = new Uint8Array(128);
for (let code = 33, digit = 0; code < 127; code++) {
  if (!"\"&'<>\\`,;".includes(String.fromCharCode(code))) digits[code] = digit++;
}

// The response with the bytes of an element that holds gzip in base 85.
async function unpack(id) {
  const text = document.getElementById(id).textContent;
  const bytes = new Uint8Array(Math.floor(text.length * 4 / 5));
  for (let from = 0, to = 0; from < text.length; from += 5) {
    let word = 0;
    for (let place = from; place < from + 5; place++) {
      word = word * 85 + (place < text.length ? digits[text.charCodeAt(place)] : 84);
    }
    for (let shift = 24; shift >= 0 && to < bytes.length; shift -= 8) bytes[to++] = word / 2 ** shift;
  }
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip")));
}

// The numbers of a curve from the differences of their counts, or those of an earlier curve.
function restored(packed, earlier) {
  if (typeof packed === "number") return earlier[packed].x;
  if (!packed?.by) return packed;
  let count = 0;
  return packed.by.map((by) => {
    if (by === null) return null;
    count += by;
    return packed.log ? 10 ** (count * packed.of) : count * packed.of;
  });
}

// The plotting library, once it is there.
const plotting = (async () => {
  const script = document.createElement("script");
  script.textContent = await (await unpack("plotting-library")).text();
  document.head.append(script);
  pictures = await (await unpack("pictures")).json();
  for (const { data } of Object.values(pictures)) {
    for (const trace of data) [trace.x, trace.y] = [restored(trace.x, data), restored(trace.y, data)];
  }
  draw();
  for (const query of [dark, narrow]) query.addEventListener("change", draw);
})();

// Formulas are copied as LaTeX.
document.addEventListener("copy", (event) => {
  const selection = getSelection();
  if (selection.isCollapsed) return;
  const copy = selection.getRangeAt(0).cloneContents();
  const formulas = copy.querySelectorAll("math");
  const within = selection.getRangeAt(0).commonAncestorContainer.parentElement?.closest("math");
  if (!formulas.length && !within) return;
  for (const math of formulas) math.replaceWith(`$${math.getAttribute("alttext")}$\n`);
  event.clipboardData.setData("text/plain", within ? `$${within.getAttribute("alttext")}$` : copy.textContent);
  event.preventDefault();
});

// On paper nothing can be opened, and a figure has the width of the paper: what it was drawn in becomes its view.
addEventListener("beforeprint", () => {
  for (const details of document.querySelectorAll("details")) details.open = true;
  for (const svg of document.querySelectorAll(".main-svg")) {
    const [width, height] = ["width", "height"].map((name) => svg.getAttribute(name));
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.closest(".js-plotly-plot").style.aspectRatio = `${width} / ${height}`;
  }
});
addEventListener("afterprint", () => {
  for (const svg of document.querySelectorAll(".main-svg")) {
    svg.removeAttribute("viewBox");
    svg.closest(".js-plotly-plot").style.aspectRatio = "";
  }
});
