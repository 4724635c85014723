// Numbers and elements.
const $ = (id) => document.getElementById(id);

const digits = (value, count = 3) => (value === 0 ? "0" : Number(value.toPrecision(count)).toString());
const isPlain = (value) => value === 0 || (Math.abs(value) >= 1e-3 && Math.abs(value) < 1e4);
const short = (value) => (isPlain(value) ? digits(value) : value.toExponential(1));
const percent = (value) => `${short(value)} %`;

// An element of the page; text is never read as markup.
function add(parent, name, text = "", className = "") {
  const element = document.createElement(name);
  element.textContent = text;
  element.className = className;
  return parent.appendChild(element);
}

function svg(parent, name, attributes) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return parent.appendChild(element);
}

// {a: {b: 1}} as [["a.b", 1]].
function flatten(value, path = "") {
  const isBranch = value !== null && typeof value === "object" && Object.keys(value).length > 0;
  if (!isBranch || (Array.isArray(value) && value.every((v) => typeof v !== "object"))) return [[path, value]];
  return Object.entries(value).flatMap(([key, below]) => flatten(below, path ? `${path}.${key}` : key));
}
