// Expressions as formulas, in MathML, while they are typed.

const GREEK = [
  ..."alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu".split(" "),
  ..."nu xi pi rho sigma tau upsilon phi chi psi omega".split(" "),
];
const LETTERS = "αβγδεζηθικλμνξπρστυφχψω";

const mathml = (tag, ...children) => {
  const node = document.createElementNS("http://www.w3.org/1998/Math/MathML", tag);
  node.append(...children);
  return node;
};

function mathWord(name) {
  const index = GREEK.indexOf(name.toLowerCase());
  if (index >= 0) return mathml("mi", name === name.toLowerCase() ? LETTERS[index] : LETTERS[index].toUpperCase());
  return mathml(/^\d+$/.test(name) ? "mn" : "mi", name);
}

// A name with its index; `over` puts a mark over its stem, as of a derivative.
function mathName(name, over = (stem) => stem) {
  const parts = /^([A-Za-z]+)_(.+)$/.exec(name) ?? /^([A-Za-z]+)(\d+)$/.exec(name);
  return parts ? mathml("msub", over(mathWord(parts[1])), mathWord(parts[2])) : over(mathWord(name));
}

// An expression as a formula; null if it is none that is understood here, of which the module says why.
function typeset(text) {
  const tokens =
    text.match(
      /\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|[A-Za-z_][A-Za-z0-9_]*|\*\*|<=|>=|==|!=|&&|\|\||\S/g,
    ) ?? [];
  let place = 0;
  const operators = {
    "||": 1,
    "&&": 2,
    "<": 3,
    ">": 3,
    "<=": 3,
    ">=": 3,
    "==": 3,
    "!=": 3,
    "+": 5,
    "-": 5,
    "*": 7,
    "/": 7,
  };
  const shown = { "<=": "≤", ">=": "≥", "==": "=", "!=": "≠", "&&": "∧", "||": "∨", "-": "−" };
  const fail = () => {
    throw new Error("no formula");
  };
  const row = (...children) => mathml("mrow", ...children);
  const mark = (sign) => {
    const node = mathml("mo", sign);
    if (/[()|]/.test(sign)) node.setAttribute("stretchy", "false");
    return node;
  };
  // Brackets grow with a fraction or a power between them.
  const brackets = (node) => {
    const grow = node.querySelector("mfrac, msup") || ["mfrac", "msup"].includes(node.localName);
    return row(grow ? mathml("mo", "(") : mark("("), node, grow ? mathml("mo", ")") : mark(")"));
  };
  // A part with its strength, and brackets around it where it is weaker than its place asks for.
  const held = (part, least) => (part.strength < least ? brackets(part.node) : part.node);
  const part = (node, strength, number = false) => ({ node, strength, number });

  function operand(depth) {
    const token = tokens[place++];
    if (token === undefined || depth > 200) fail();
    if (token === "-" || token === "+" || token === "!") {
      const inner = expression(8, depth + 1);
      return part(row(mark({ "!": "¬", "-": "−", "+": "+" }[token]), held(inner, 8)), 6);
    }
    if (token === "(") {
      const inner = expression(0, depth + 1);
      if (tokens[place++] !== ")") fail();
      return inner;
    }
    if (/^[\d.]/.test(token)) {
      const parts = /^(.*)[eE]\+?(-?\d+)$/.exec(token);
      if (!parts) return part(mathml("mn", token), 10, true);
      const [, digits, exponent] = parts;
      const sign = exponent.startsWith("-") ? [mark("−"), mathml("mn", exponent.slice(1))] : [mathml("mn", exponent)];
      return part(row(mathml("mn", digits), mark("·"), mathml("msup", mathml("mn", "10"), row(...sign))), 7, true);
    }
    if (!/^[A-Za-z_]/.test(token)) fail();
    if (tokens[place] !== "(") return part(mathName(token), 10);
    place++;
    const given = [];
    while (tokens[place] !== ")") {
      given.push(expression(0, depth + 1));
      if (tokens[place] === ",") place++;
      else if (tokens[place] !== ")") fail();
    }
    place++;
    const nodes = given.map(({ node }) => node);
    if (token === "sqrt" && nodes.length === 1) return part(mathml("msqrt", nodes[0]), 10);
    if (token === "abs" && nodes.length === 1) return part(row(mark("|"), nodes[0], mark("|")), 10);
    if (token === "exp" && nodes.length === 1) return part(mathml("msup", mathml("mi", "e"), nodes[0]), 9);
    const list = nodes.flatMap((node, k) => (k ? [mark(","), node] : [node]));
    return part(row(mathName(token), brackets(row(...list))), 10);
  }

  function expression(least, depth) {
    let left = operand(depth);
    for (;;) {
      const token = tokens[place];
      if (token === "^" || token === "**") {
        if (9 < least) return left;
        place++;
        const right = expression(8, depth + 1);
        left = part(mathml("msup", held(left, 10), right.node), 9);
        continue;
      }
      const strength = operators[token];
      if (strength === undefined || strength < least) return left;
      place++;
      const right = expression(strength + 1, depth + 1);
      if (token === "/") left = part(mathml("mfrac", left.node, right.node), 9);
      else if (token === "*") {
        const between = right.number ? mark("·") : mark("\u2062");
        const gap = mathml("mspace");
        gap.setAttribute("width", "0.17em");
        left = part(row(held(left, 6), between, gap, held(right, 7)), 7);
      } else left = part(row(held(left, strength), mark(shown[token] ?? token), held(right, strength + 1)), strength);
    }
  }

  try {
    const { node } = expression(0, 0);
    return place === tokens.length ? node : null;
  } catch {
    return null;
  }
}

const math = (...children) => mathml("math", ...children);
