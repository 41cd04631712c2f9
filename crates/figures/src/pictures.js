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

function draw() {
  const config = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d"] };
  const ink = getComputedStyle(document.documentElement).getPropertyValue("--ink").trim();
  for (const place of document.querySelectorAll("[data-picture]")) {
    const { data, layout } = pictures[place.dataset.picture];
    // Black curves take the colour of the text, so that they are seen on a dark page.
    const traces = data.map((trace) => trace.line?.color === "#000000"
      ? { ...trace, line: { ...trace.line, color: ink }, marker: { ...trace.marker, color: ink } } : trace);
    Plotly.react(place, traces, themed(layout), config);
  }
}

// The response with the bytes of an element that holds gzip in base64.
async function unpack(id) {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip")));
}

// The plotting library, once it is there.
const plotting = (async () => {
  const script = document.createElement("script");
  script.textContent = await (await unpack("plotting-library")).text();
  document.head.append(script);
  pictures = await (await unpack("pictures")).json();
  draw();
  dark.addEventListener("change", draw);
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

// On paper nothing can be opened.
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((details) => { details.open = true; }));
