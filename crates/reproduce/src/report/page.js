"use strict";
const claims = [...document.querySelectorAll(".claim")];
const byId = (id) => document.getElementById(id);

function open(claim, show) {
  claim.querySelector(".details").hidden = !show;
  claim.querySelector(".more").setAttribute("aria-expanded", String(show));
}
for (const claim of claims) {
  claim.querySelector(".row").addEventListener("click", () => open(claim, claim.querySelector(".details").hidden));
}

function filter() {
  const words = byId("text").value.toLowerCase().split(/\s+/).filter(Boolean);
  const [verdict, paper] = [byId("verdict").value, byId("paper").value];
  let shown = 0;
  for (const claim of claims) {
    const text = claim.textContent.toLowerCase();
    const fits = (!verdict || claim.dataset.verdict === verdict) && (!paper || claim.dataset.paper === paper)
      && words.every((word) => text.includes(word));
    claim.hidden = !fits;
    shown += fits;
  }
  byId("shown").value = `${shown} of ${claims.length}`;
}
byId("filter").addEventListener("input", filter);
byId("filter").addEventListener("submit", (event) => event.preventDefault());
for (const count of document.querySelectorAll(".count")) {
  count.addEventListener("click", () => {
    byId("verdict").value = count.dataset.show;
    filter();
    byId("claims").scrollIntoView({ behavior: "smooth" });
  });
}
filter();

// A link to a claim shows it, whatever the filter says.
function follow() {
  const claim = byId(decodeURIComponent(location.hash.slice(1)));
  if (claim?.classList.contains("claim")) {
    byId("filter").reset();
    filter();
    open(claim, true);
    claim.scrollIntoView({ block: "center" });
  }
}
addEventListener("hashchange", follow);

const pictures = JSON.parse(byId("pictures").textContent);
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
draw();
dark.addEventListener("change", draw);
follow();
