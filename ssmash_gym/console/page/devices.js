/** What a hand can move: held keys, a gamepad, a stick on the screen. Each holds `along` and `across`, -1 to 1. */
import { clamp } from "./dom.js";

const KEYS = {
  ArrowUp: [1, 0], KeyW: [1, 0], ArrowDown: [-1, 0], KeyS: [-1, 0],
  ArrowRight: [0, 1], KeyD: [0, 1], ArrowLeft: [0, -1], KeyA: [0, -1],
};
const SLOW = 0.35; // of the full command while Shift is held
const DEAD = 0.15; // of a gamepad's travel: worn sticks do not return further
const DPAD = { 12: [1, 0], 13: [-1, 0], 14: [0, -1], 15: [0, 1] }; // buttons of the standard layout

/** A text field, list or slider takes the keys for itself. */
const typesIn = (target) => target instanceof Element && target.closest("input, select, textarea, [contenteditable]");

/** Keys by events: a page is told when a key goes down and when it comes up, and forgets all of them on `clear`. */
export class Keyboard {
  name = "keyboard";
  along = 0;
  across = 0;
  #held = new Set();
  #slow = false;

  constructor(changed) {
    this.changed = changed;
    addEventListener("keydown", (event) => this.#down(event));
    addEventListener("keyup", (event) => this.#up(event));
  }

  #down(event) {
    if (event.key === "Shift") this.#shift(true);
    if (!(event.code in KEYS) || event.ctrlKey || event.metaKey || event.altKey || typesIn(event.target)) return;
    event.preventDefault(); // no scrolling
    if (event.repeat || this.#held.has(event.code)) return;
    this.#held.add(event.code);
    this.#sum();
  }

  #up(event) {
    if (event.key === "Shift") this.#shift(false);
    if (event.key === "Meta" && this.#held.size) this.clear(); // the system swallows the key-ups under it
    if (this.#held.delete(event.code)) this.#sum();
  }

  #shift(slow) {
    if (this.#slow === slow) return;
    this.#slow = slow;
    if (this.#held.size) this.#sum();
  }

  #sum() {
    const size = this.#slow ? SLOW : 1;
    let along = 0;
    let across = 0;
    for (const code of this.#held) {
      along += KEYS[code][0];
      across += KEYS[code][1];
    }
    this.along = size * clamp(along, -1, 1);
    this.across = size * clamp(across, -1, 1);
    this.changed(this);
  }

  clear() {
    this.#held.clear();
    this.#slow = false;
    this.along = this.across = 0;
  }
}

/** The first gamepad, polled. After `clear` it counts again only when it has been let go. */
export class Gamepad {
  name = "gamepad";
  along = 0;
  across = 0;
  connected = false;
  #armed = false;
  #pressed = false;

  constructor(changed) {
    this.changed = changed;
  }

  poll() {
    const pad = Array.from(navigator.getGamepads?.() ?? []).find((p) => p?.connected && p.axes.length >= 2);
    this.connected = Boolean(pad);
    if (!pad) {
      this.#armed = false;
      return this.#set(0, 0);
    }
    const [along, across] = this.#read(pad);
    if (!this.#armed) {
      this.#armed = along === 0 && across === 0;
      return this.#set(0, 0);
    }
    const pressed = pad.buttons.some((button, k) => button.pressed && !(k in DPAD));
    if (pressed && !this.#pressed) this.changed(this, true);
    this.#pressed = pressed;
    return this.#set(along, across);
  }

  #read(pad) {
    let [along, across] = [0, 0];
    for (const [k, [x, y]] of Object.entries(DPAD)) {
      if (pad.buttons[k]?.pressed) [along, across] = [along + x, across + y];
    }
    if (along || across) return [clamp(along, -1, 1), clamp(across, -1, 1)];
    const [x, y] = [pad.axes[0] || 0, pad.axes[1] || 0];
    const size = Math.hypot(x, y);
    if (size <= DEAD) return [0, 0];
    const share = Math.min(1, (size - DEAD) / (1 - DEAD)) / size; // no jump at the edge of the dead zone
    return [clamp(-y * share, -1, 1), clamp(x * share, -1, 1)];
  }

  #set(along, across) {
    if (along === this.along && across === this.across) return;
    [this.along, this.across] = [along, across];
    this.changed(this);
  }

  clear() {
    this.#armed = false;
    this.along = this.across = 0;
  }
}

/** A round stick for a mouse or a finger; it springs back when it is let go. */
export class Stick {
  name = "stick";
  along = 0;
  across = 0;
  #pointer = null;

  constructor(root, knob, changed) {
    Object.assign(this, { root, knob, changed });
    root.addEventListener("pointerdown", (event) => this.#grip(event));
    root.addEventListener("pointermove", (event) => event.pointerId === this.#pointer && this.#move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      root.addEventListener(name, (event) => event.pointerId === this.#pointer && this.#let());
    }
  }

  #grip(event) {
    if (this.#pointer !== null || event.button > 0) return;
    event.preventDefault();
    this.#pointer = event.pointerId;
    try {
      this.root.setPointerCapture(event.pointerId);
    } catch {
      // a pointer that is not there any more cannot be captured
    }
    this.#move(event);
  }

  #move(event) {
    const box = this.root.getBoundingClientRect();
    const radius = 0.36 * box.width; // of the knob's travel
    let x = (event.clientX - box.left - 0.5 * box.width) / radius;
    let y = (box.top + 0.5 * box.height - event.clientY) / radius;
    const size = Math.hypot(x, y);
    if (size > 1) [x, y] = [x / size, y / size];
    [this.along, this.across] = [Math.abs(y) < 0.05 ? 0 : y, Math.abs(x) < 0.05 ? 0 : x];
    this.show(this.along, this.across);
    this.changed(this);
  }

  #let() {
    this.clear();
    this.changed(this);
  }

  get held() {
    return this.#pointer !== null;
  }

  /** Put the knob where a command is; another device's command shows here too. */
  show(along, across) {
    this.knob.style.setProperty("--x", across.toFixed(3));
    this.knob.style.setProperty("--y", (-along).toFixed(3));
  }

  clear() {
    this.#pointer = null;
    this.along = this.across = 0;
    this.show(0, 0);
  }
}
