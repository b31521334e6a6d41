/** Small helpers for making elements; texts always go in as text, never as markup. */
const SVG = "http://www.w3.org/2000/svg";

export const byId = (id) => document.getElementById(id);

/** An element with attributes (`class`, `text`, listeners as `onclick` functions, anything else) and children. */
export function make(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** The same for SVG. */
export function draw(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") element.textContent = value;
    else if (typeof value === "function") element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, String(value));
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

/** Show or hide; says whether it changed. */
export function show(element, visible) {
  const changed = element.hidden === visible;
  element.hidden = !visible;
  return changed;
}

/** Write a text only when it has changed, so that live regions do not speak twice. */
export function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
export const finite = (value) => typeof value === "number" && Number.isFinite(value);
/** A number with a real minus sign and a fixed number of places. */
export const number = (value, places = 1) => (finite(value) ? value.toFixed(places).replace("-", "\u2212") : "\u2013");
