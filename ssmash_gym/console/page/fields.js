/**
 * Fields made from a JSON schema. One small renderer for what pydantic writes for this package's descriptions: numbers,
 * booleans, texts, choices, vectors and tensors, lists, sections, what may be left out, unions by `type`, and ranges.
 *
 * A field writes through a scope: `scope.set(path, value)` with the path from the scope's own place, `scope.unset(path)`
 * where the value is the base's again.
 */
import { make } from "./dom.js";
import { kindOf, plainOf, titleOf, unitOf } from "./labels.js";

const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
const asNumber = (text) => (text.trim() !== "" && Number.isFinite(Number(text)) ? Number(text) : text); // the server tells
const shown = (value) => (value === null || value === undefined ? "" : String(value));

/** The fields of a section. */
export function fieldsOf(schema, root, value, path, scope) {
  const section = resolved(schema, root);
  return Object.entries(section.properties ?? {})
    .filter(([key, part]) => !("const" in part) && key !== "description")
    .map(([key, part]) => field(part, root, value?.[key], [...path, key], scope));
}

/** A field, or a section that opens. */
export function field(schema, root, value, path, scope) {
  const part = resolved(schema, root);
  const key = path.at(-1);
  const about = { key, part, root, value, path, scope, title: titleOf(key), description: schema.description ?? part.description };
  if (schema["x-form"] || part["x-form"]) return scope.special(part["x-form"], about);
  if (part.discriminator) return union(about);
  const [other, nullable] = optional(part, root);
  if (nullable && other?.properties && !isRange(part, root)) return leftOut(about, other);
  if (part.properties && !isRange(part, root)) return section(about, () => fieldsOf(part, root, value, path, scope));
  if (part.type === "array" && resolved(items(part), root).properties) {
    const rows = value.map((row, k) => [row, k]);
    return section(about, () => rows.map(([row, k]) =>
      section({ ...about, title: `${about.title} ${k + 1}`, description: "" }, () => fieldsOf(items(part), root, row, [...path, k], scope))));
  }
  return line(about, entryOf(about, nullable));
}

export function resolved(schema, root) {
  return schema.$ref ? { ...root.$defs[schema.$ref.split("/").at(-1)], ...schema } : schema;
}

const items = (part) => part.items ?? {};
const isRange = (part) => (part.anyOf ?? []).some((option) => option.$ref?.endsWith("/Uniform"));

/** The option beside null, and whether null is one. */
function optional(part, root) {
  const options = part.anyOf ?? [];
  const nullable = options.some((option) => option.type === "null");
  const rest = options.filter((option) => option.type !== "null").map((option) => resolved(option, root));
  return [rest.length === 1 ? rest[0] : null, nullable];
}

/** A section that makes its fields when it is opened for the first time. */
export function section({ title, description, path, open = false }, content) {
  const head = make("summary", { text: title }, description ? make("small", { text: `  ${plainOf(description)}` }) : null);
  const box = make("details", { "data-section": path.join(".") }, head);
  const fill = () => box.childElementCount === 1 && box.append(...content());
  box.addEventListener("toggle", () => box.open && fill());
  if (open) {
    fill();
    box.open = true;
  }
  return box;
}

/** A section of one of several kinds; another kind than the base's is sent as a whole. */
function union({ part, root, value, path, scope, title, description }) {
  const kinds = part.discriminator.mapping;
  const choice = make("select", { "aria-label": `${title}: kind`, "data-path": [...path, "type"].join(".") },
    ...Object.keys(kinds).map((kind) => make("option", { value: kind, text: kindOf(kind) })));
  choice.value = value.type;
  const body = make("div");
  const fill = () => {
    const kind = choice.value;
    const chosen = resolved({ $ref: kinds[kind] }, root);
    if (kind === value.type) {
      scope.unset(path);
      return body.replaceChildren(...fieldsOf(chosen, root, value, path, scope));
    }
    const whole = { ...defaults(chosen, root), type: kind };
    const start = structuredClone(whole);
    scope.set(path, whole);
    const inner = {
      special: scope.special,
      set: (to, given) => (place(whole, to, given), scope.set(path, whole)),
      unset: (to) => inner.set(to, valueAt(start, to)),
    };
    body.replaceChildren(...fieldsOf(chosen, root, start, [], inner));
  };
  choice.addEventListener("change", fill);
  return section({ title, description, path, open: path.length < 3 }, () => {
    const rows = make("div", { class: "field" }, make("div", { class: "label", text: "Kind" }), make("div", { class: "entry" }, choice));
    body.replaceChildren(...fieldsOf(resolved({ $ref: kinds[value.type] }, root), root, value, path, scope));
    return [rows, body];
  });
}

/** A section that may be left out altogether. */
function leftOut(about, other) {
  const { root, value, path, scope } = about;
  return section(about, () => {
    const body = make("div");
    const tick = make("input", { type: "checkbox", "aria-label": `${about.title}: given`, "data-path": path.join(".") });
    tick.checked = Boolean(value);
    const fill = () => {
      if (tick.checked === Boolean(value)) scope.unset(path);
      else scope.set(path, tick.checked ? defaults(other, root) : null);
      if (!tick.checked) return body.replaceChildren();
      if (value) return body.replaceChildren(...fieldsOf(other, root, value, path, scope));
      const whole = defaults(other, root);
      const inner = { special: scope.special, set: (to, given) => (place(whole, to, given), scope.set(path, whole)), unset: () => {} };
      return body.replaceChildren(...fieldsOf(other, root, structuredClone(whole), [], inner));
    };
    tick.addEventListener("change", fill);
    if (value) body.replaceChildren(...fieldsOf(other, root, value, path, scope));
    return [make("label", { class: "field" }, make("span", { class: "label", text: "Given" }), make("span", { class: "entry" }, tick)), body];
  });
}

/** Label, entry, unit, and the way back to the base's value. */
function line({ key, part, value, path, scope, title, description }, entry) {
  const undo = make("button", { type: "button", class: "undo", hidden: true, title: "as it was", "aria-label": `${title}: as it was`, text: "\u21ba" });
  const unit = unitOf(key, description);
  const told = plainOf(description ?? part.description);
  const row = make("div", { class: `field${entry.wide ? " wide" : ""}`, "data-path": path.join(".") },
    make("div", { class: "label" }, title, told.toLowerCase() === title.toLowerCase() ? null : make("small", { text: told })),
    make("div", { class: "entry" }, ...entry.nodes, unit ? make("span", { class: "unit", text: unit }) : null, undo));
  const note = () => {
    const given = entry.read();
    const changed = !same(given, value ?? null);
    if (changed) scope.set(path, given);
    else scope.unset(path);
    row.classList.toggle("changed", changed);
    undo.hidden = !changed;
  };
  for (const node of entry.nodes) node.addEventListener("change", note);
  undo.addEventListener("click", () => (entry.write(value ?? null), note()));
  for (const node of entry.nodes) node.querySelectorAll?.("input").forEach((input) => input.setAttribute("aria-label", title));
  entry.write(value ?? null);
  for (const node of entry.nodes) if (node.matches("input, select") && !node.hasAttribute("aria-label")) node.setAttribute("aria-label", title);
  return row;
}

function entryOf({ part, root, value }, nullable) {
  if (isRange(part)) return rangeEntry(nullable);
  const [other] = optional(part, root);
  const plain = other ?? (part.anyOf ? matching(part.anyOf.map((option) => resolved(option, root)), value) : part);
  const choices = part["x-choices"] ?? plain.enum;
  if (choices) return choiceEntry(nullable ? [null, ...choices] : choices);
  if (plain.type === "boolean") return tickEntry();
  if (plain.type === "array" && Array.isArray(value?.[0])) return tensorEntry(value);
  if (plain.type === "array") return listEntry(plain, root);
  return textEntry(plain.type === "string" ? (text) => text : asNumber, nullable);
}

const matching = (options, value) => options.find((o) => (o.type === "array") === Array.isArray(value)) ?? options[0];

function textEntry(parse, nullable) {
  const box = make("input", { type: "text", inputmode: parse === asNumber ? "decimal" : "text", placeholder: nullable ? "not given" : "" });
  return { nodes: [box], read: () => (nullable && box.value.trim() === "" ? null : parse(box.value)), write: (value) => (box.value = shown(value)) };
}

function tickEntry() {
  const box = make("input", { type: "checkbox" });
  return { nodes: [box], read: () => box.checked, write: (value) => (box.checked = Boolean(value)) };
}

function choiceEntry(choices) {
  const box = make("select", {}, ...choices.map((choice, k) => make("option", { value: k, text: choice === null ? "not given" : kindOf(choice) })));
  return { nodes: [box], read: () => choices[Number(box.value)], write: (value) => (box.value = String(choices.findIndex((c) => same(c, value)))) };
}

/** Numbers or texts with commas between them; pydantic says which by the items. */
function listEntry(part, root) {
  const first = resolved(part.prefixItems?.[0] ?? items(part), root);
  const parse = first.type === "string" ? (text) => text : asNumber;
  const box = make("input", { type: "text", class: "list" });
  return { nodes: [box], read: () => box.value.split(",").map((text) => parse(text.trim())), write: (value) => (box.value = (value ?? []).join(", ")) };
}

function tensorEntry(value) {
  const boxes = value.map((row) => row.map(() => make("input", { type: "text", inputmode: "decimal" })));
  return {
    wide: true,
    nodes: [make("div", { class: "grid" }, ...boxes.flat())],
    read: () => boxes.map((row) => row.map((box) => asNumber(box.value))),
    write: (given) => boxes.forEach((row, i) => row.forEach((box, k) => (box.value = shown(given?.[i]?.[k])))),
  };
}

const RANGES = { constant: "is", uniform: "between", choice: "one of", normal: "normal" };

/** A range: a number, between two numbers, one of several, or normal within bounds. */
function rangeEntry(nullable) {
  const kinds = nullable ? { none: "not given", ...RANGES } : RANGES;
  const kind = make("select", { class: "kind", "aria-label": "kind of range" },
    ...Object.entries(kinds).map(([value, text]) => make("option", { value, text })));
  const boxes = ["mean, or the values", "to, or the deviation", "at least", "at most"].map((title) =>
    make("input", { type: "text", inputmode: "decimal", title, "aria-label": title }));
  const arrange = () => {
    const count = { none: 0, constant: 1, uniform: 2, choice: 1, normal: 4 }[kind.value];
    boxes.forEach((box, k) => (box.hidden = k >= count));
  };
  kind.addEventListener("change", arrange);
  const number = (k) => asNumber(boxes[k].value);
  return {
    nodes: [kind, ...boxes],
    read: () => ({
      none: () => null,
      constant: () => ({ constant: number(0) }),
      uniform: () => ({ uniform: [number(0), number(1)] }),
      choice: () => ({ choice: boxes[0].value.split(",").map((text) => asNumber(text)) }),
      normal: () => ({ normal: [number(0), number(1)], within: [number(2), number(3)] }),
    })[kind.value](),
    write: (value) => {
      kind.value = value === null ? "none" : Object.keys(RANGES).find((name) => name in value);
      const numbers = value === null ? [] : kind.value === "choice" ? [value.choice.join(", ")] : [value[kind.value], value.within ?? []].flat();
      boxes.forEach((box, k) => (box.value = shown(numbers[k])));
      arrange();
    },
  };
}

/** What a section starts from: its defaults, and zero or nothing where there are none. */
export function defaults(schema, root) {
  const found = {};
  for (const [key, given] of Object.entries(schema.properties ?? {})) {
    const part = resolved(given, root);
    if ("default" in part) found[key] = structuredClone(part.default);
    else if ("const" in part) found[key] = part.const;
    else if (isRange(part)) found[key] = { constant: 0 };
    else if (part.properties) found[key] = defaults(part, root);
    else if (part.enum) found[key] = part.enum[0];
    else found[key] = part.type === "array" ? Array(part.minItems ?? 0).fill(0) : part.type === "string" ? "" : 0;
  }
  return found;
}

export function place(target, path, value) {
  const inner = path.slice(0, -1).reduce((node, key) => (node[key] ??= {}), target);
  inner[path.at(-1)] = value;
}

export const valueAt = (source, path) => path.reduce((node, key) => node?.[key], source);
