// Elements of the page: how they are made, tabs, and lists whose choice does something.

const at = (id) => document.getElementById(id);

function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (name === "value") node.value = value;
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return node;
}

const button = (text, click, attributes = {}) =>
  element("button", { type: "button", onclick: click, ...attributes }, text);

// A description, in which words between backticks are code.
const prose = (text) => text.split("`").map((part, k) => (k % 2 ? element("code", {}, part) : part));

// A list whose choice does something: chosen with the mouse at once, with the keys by Enter, since arrow keys choose on
// their way.
function picker(select, act) {
  let keys = false;
  const pick = () => {
    const { value } = select;
    select.value = "";
    if (value) act(value);
  };
  select.title ||= "Enter applies the choice";
  select.addEventListener("pointerdown", () => {
    keys = false;
  });
  select.addEventListener("keydown", (event) => {
    keys = event.key !== "Enter";
    if (keys || !select.value) return;
    event.preventDefault();
    pick();
  });
  select.addEventListener("change", () => {
    if (!keys) pick();
  });
  return select;
}

// Tabs of which the arrow keys choose one.
function tabs(list, chosen) {
  const all = [...list.querySelectorAll("[role=tab]")];
  const choose = (tab, focus) => {
    for (const other of all) {
      other.setAttribute("aria-selected", String(other === tab));
      other.tabIndex = other === tab ? 0 : -1;
    }
    if (focus) tab.focus();
    chosen(tab);
  };
  list.addEventListener("click", ({ target }) => {
    const tab = target.closest("[role=tab]");
    if (tab) choose(tab, false);
  });
  list.addEventListener("keydown", (event) => {
    const from = all.indexOf(event.target);
    if (from < 0) return;
    const to = { ArrowRight: from + 1, ArrowLeft: from - 1, Home: 0, End: all.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    choose(all[(to + all.length) % all.length], true);
  });
  return choose;
}

const panels = (list, then) =>
  tabs(list, (chosen) => {
    for (const tab of list.querySelectorAll("[role=tab]")) {
      at(tab.getAttribute("aria-controls")).hidden = tab !== chosen;
    }
    then?.(chosen.id);
  });

// A text as a sentence, with one full stop.
const sentence = (text) => `${text.replace(/[.\s]+$/, "")}.`;
