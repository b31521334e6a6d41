/**
 * The form: a drawer with the inputs, made from the schemas that the server sends (ssmash_gym/console/form.py). Only what
 * differs from the base is sent; whether it is allowed is for the server to say, in one sentence.
 */
import { byId, make, show, write } from "./dom.js";
import { fieldsOf, place, section } from "./fields.js";

const PARTS = [
  ["scenario", "Sea, ship and landing"],
  ["task", "Task, claw and limits"],
  ["helicopter", "Helicopter"],
];

export class Form {
  open = false;
  #form = null; // what the server has sent
  #base = {};
  #edits = new Map(); // by part and path, as text
  #saved = null; // the message that a `yaml` answers

  constructor(root, link, roles) {
    Object.assign(this, { root, link, roles });
    link.addEventListener("schema", ({ detail }) => this.#take(detail));
    link.addEventListener("yaml", ({ detail }) => this.#save(detail.files));
    link.addEventListener("refused", ({ detail }) => this.open && ["configure", "yaml", "schema"].includes(detail.about) && this.#refuse(detail.message));
    link.addEventListener("setup", () => this.#applied());
    addEventListener("keydown", (event) => event.key === "Escape" && this.open && this.toggle());
    roles.onchange = () => this.#allow();
  }

  toggle() {
    this.open = !this.open;
    show(this.root, this.open);
    if (!this.open) return byId("open-form").focus();
    if (!this.#form) this.link.send({ type: "schema" });
    return this.root.querySelector("button, select")?.focus();
  }

  #take(form) {
    this.#form = form;
    this.#base = { ...form.base };
    this.#edits.clear();
    this.#draw();
  }

  #draw() {
    const choose = ([part, title]) => {
      const list = make("select", { "data-base": part }, ...this.#form.names[part].map((name) => make("option", { text: name })));
      list.value = this.#base[part];
      list.addEventListener("change", () => this.#rebase(part, list.value));
      return make("label", {}, title, list);
    };
    const button = (id, text, act, attributes = {}) => make("button", { type: "button", id, text, onclick: act, ...attributes });
    this.fields = make("div", { class: "fields" });
    this.root.replaceChildren(
      make("header", {},
        make("div", { class: "row between" }, make("h1", { text: "Inputs" }), button("form-close", "\u00d7", () => this.toggle(), { "aria-label": "Close" })),
        make("div", { class: "bases" }, ...PARTS.map(choose))),
      this.fields,
      make("footer", {},
        make("p", { id: "form-error", class: "refused", role: "alert", hidden: true }),
        make("div", { class: "row" },
          button("form-apply", "Apply", () => this.#apply(), { class: "primary" }), button("form-save", "Save YAML", () => this.#ask()),
          button("form-undo", "Undo all", () => this.#take(this.#form)), make("span", { id: "form-note", class: "dim", role: "status" })),
        make("p", { id: "form-files", class: "files", hidden: true })),
    );
    this.#fill();
    this.#allow();
  }

  #fill() {
    this.fields.replaceChildren(...PARTS.map(([part, title], k) => {
      const schema = this.#form.schemas[part];
      const values = this.#form.values[part][this.#base[part]];
      return section({ title, description: values.description, path: [part], open: k === 0 },
        () => fieldsOf(schema, schema, values, [part], this.#scope));
    }));
    this.#count();
  }

  #rebase(part, name) {
    this.#base[part] = name;
    for (const key of [...this.#edits.keys()]) if (JSON.parse(key)[0] === part) this.#edits.delete(key);
    this.#fill();
  }

  get #scope() {
    return {
      set: (path, value) => {
        this.unsetBelow(path);
        this.#edits.set(JSON.stringify(path), value);
        this.#count();
      },
      unset: (path) => {
        this.unsetBelow(path);
        this.#count();
      },
      special: (_, about) => this.#ship(about),
    };
  }

  /** Forget an edit and those below it: a kind that is chosen anew takes its fields' edits with it. */
  unsetBelow(path) {
    const start = JSON.stringify(path).slice(0, -1);
    for (const key of this.#edits.keys()) if (key === `${start}]` || key.startsWith(`${start},`)) this.#edits.delete(key);
  }

  /** The ship: a name, and changes to what it names. */
  #ship({ root, value, path, scope, description }) {
    const names = this.#form.names.ship;
    const given = typeof value === "object" && value !== null ? value : { base: value };
    const list = make("select", { "aria-label": "Ship", "data-path": path.join(".") },
      ...[...new Set([given.base, ...names])].map((name) => make("option", { text: name ?? "own" })));
    list.value = given.base ?? "own";
    const body = make("div");
    const fill = () => {
      const changes = list.value === given.base ? structuredClone(given) : { base: list.value };
      const send = () => {
        const ship = Object.keys(changes).length > 1 ? changes : list.value;
        if (JSON.stringify(ship) === JSON.stringify(value)) scope.unset(path);
        else scope.set(path, ship);
      };
      const inner = {
        special: scope.special,
        set: (to, entry) => (place(changes, to, entry), send()),
        unset: (to) => (remove(changes, to), send()),
      };
      send();
      const schema = this.#form.schemas.ship;
      const values = this.#form.values.ship[list.value];
      body.replaceChildren(values ? section({ title: `Changes to the ${list.value}`, description: values.description, path: [] },
        () => fieldsOf(schema, schema, values, [], inner)) : "");
    };
    list.addEventListener("change", fill);
    const row = make("div", { class: "field" }, make("div", { class: "label" }, "Ship", make("small", { text: description })),
      make("div", { class: "entry" }, list));
    fill();
    return make("div", {}, row, body);
  }

  get #request() {
    const changes = {};
    for (const [key, value] of this.#edits) {
      const [part, ...path] = JSON.parse(key);
      changes[part] ??= {};
      if (part === "helicopter") changes[part][path.join(".")] = value;
      else place(changes[part], path, value);
    }
    return { base: this.#base, changes };
  }

  #apply() {
    show(byId("form-error"), false);
    this.#saved = null;
    this.waiting = this.link.send({ type: "configure", ...this.#request });
    if (this.waiting) write(byId("form-note"), "Checking\u2026");
  }

  #applied() {
    if (!this.waiting) return;
    this.waiting = false;
    write(byId("form-note"), "Applied.");
  }

  #ask() {
    show(byId("form-error"), false);
    this.#saved = this.link.send({ type: "yaml", ...this.#request });
  }

  /** Offer the files, and save those of the parts that were changed: several at once are asked for by the browser. */
  #save(files) {
    if (!this.#saved) return;
    this.#saved = null;
    const changed = new Set([...this.#edits.keys()].map((key) => `${JSON.parse(key)[0]}.yaml`));
    for (const address of this.addresses ?? []) URL.revokeObjectURL(address);
    this.addresses = [];
    const links = Object.entries(files).map(([name, text]) => {
      const address = URL.createObjectURL(new Blob([text], { type: "application/yaml" }));
      this.addresses.push(address);
      return make("a", { href: address, download: name, text: name });
    });
    byId("form-files").replaceChildren(
      "Files: ", ...links.flatMap((link, k) => (k ? [", ", link] : [link])),
      make("code", { text: "ssmash console --scenario scenario.yaml --task task.yaml --helicopter helicopter.yaml" }),
    );
    show(byId("form-files"), true);
    for (const link of links) if (changed.has(link.download)) link.click();
  }

  #refuse(message) {
    this.waiting = false;
    if (!this.#form) return this.root.replaceChildren(make("p", { class: "refused", text: message }));
    write(byId("form-note"), "");
    write(byId("form-error"), message);
    show(byId("form-error"), true);
  }

  #count() {
    const note = byId("form-note");
    if (byId("form-files")) show(byId("form-files"), false); // they are not what stands in the form any more
    if (note) write(note, this.#edits.size ? `${this.#edits.size} changed` : "as in the files");
  }

  #allow() {
    const apply = byId("form-apply");
    if (!apply) return;
    apply.disabled = !this.roles.mine || ["running", "countdown"].includes(this.roles.phase);
    apply.title = apply.disabled ? "Take the claw first; not while an episode runs" : "";
  }
}

function remove(target, [key, ...rest]) {
  if (!rest.length) delete target[key];
  else if (target[key]) {
    remove(target[key], rest);
    if (!Object.keys(target[key]).length) delete target[key];
  }
}
