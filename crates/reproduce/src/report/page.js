const claims = [...document.querySelectorAll(".claim")];
const byId = (id) => document.getElementById(id);

function open(claim, show) {
  claim.querySelector(".details").hidden = !show;
  claim.querySelector(".more").setAttribute("aria-expanded", String(show));
}

// What the rows open, and the notes, which the findings show as well.
(async () => {
  const details = await (await unpack("details")).json();
  for (const claim of claims) {
    const { rows, note } = details[claim.id];
    const all = rows + (note && `<dt>Note<dd>${note}`);
    claim.insertAdjacentHTML("beforeend", `<tr class="details" hidden><td><td colspan="4"><dl>${all}</dl>`);
    open(claim, false);
    claim.querySelector(".row").addEventListener("click", () => open(claim, claim.querySelector(".details").hidden));
  }
  for (const place of document.querySelectorAll(".evidence .note")) {
    place.innerHTML = details[place.parentElement.querySelector("a").hash.slice(1)].note;
  }
  filter();
  addEventListener("hashchange", follow);
  follow();
})();

function filter() {
  const words = byId("text").value.toLowerCase().split(/\s+/).filter(Boolean);
  const [verdict, kind, paper] = ["verdict", "class", "paper"].map((id) => byId(id).value);
  let shown = 0;
  for (const claim of claims) {
    const text = claim.textContent.toLowerCase();
    const { dataset } = claim;
    const fits = (!verdict || dataset.verdict === verdict) && (!paper || dataset.paper === paper)
      && (!kind || (kind === "own" ? dataset.own === "true" : dataset.class === kind)) && words.every((word) => text.includes(word));
    claim.hidden = !fits;
    shown += fits;
  }
  for (const heading of document.querySelectorAll("tbody.paper")) {
    heading.hidden = !claims.some((claim) => !claim.hidden && claim.dataset.paper === heading.dataset.paper);
  }
  byId("shown").value = `${shown} of ${claims.length}`;
}
byId("filter").addEventListener("input", filter);
byId("filter").addEventListener("submit", (event) => event.preventDefault());
for (const count of document.querySelectorAll(".count")) {
  count.addEventListener("click", () => {
    byId("verdict").value = count.dataset.verdict;
    byId("class").value = count.dataset.class;
    filter();
    byId("claims").scrollIntoView({ behavior: "smooth" });
  });
}

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
