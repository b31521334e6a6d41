/**
 * From hands to commands. The device that was moved last counts. While the page holds the claw a command leaves 40 times
 * a second, also a zero one: the server stops the claw when they cease. They leave from the page's own thread on purpose:
 * a page that hangs must not go on commanding.
 *
 * A hidden tab, a lost focus and a page that goes away let go of everything at once, tell the server so, and pause until
 * the page is back.
 */
import { Gamepad, Keyboard, Stick } from "./devices.js";

const PERIOD_MS = 25;

export class Input extends EventTarget {
  #active = null;
  #paused = false;
  #driving = false;

  /**
   * @param {HTMLElement} root of the on-screen stick
   * @param {HTMLElement} knob in it
   * @param {(command: {along: number, across: number, device: string}) => void} send
   */
  constructor(root, knob, send) {
    super();
    this.send = send;
    const changed = (device, touched = false) => this.#changed(device, touched);
    this.keyboard = new Keyboard(changed);
    this.gamepad = new Gamepad(changed);
    this.stick = new Stick(root, knob, changed);
    this.#active = this.keyboard;
    setInterval(() => this.#tick(), PERIOD_MS);
    addEventListener("blur", () => this.pause());
    addEventListener("pagehide", () => this.pause());
    document.addEventListener("visibilitychange", () => (document.hidden ? this.pause() : this.resume()));
    addEventListener("focus", () => this.resume());
    addEventListener("pageshow", () => this.resume());
    addEventListener("pointerdown", () => this.resume(), { capture: true });
    addEventListener("keydown", () => this.resume(), { capture: true });
  }

  /** Whether this page holds the claw. */
  set driving(driving) {
    if (driving === this.#driving) return;
    this.#driving = driving;
    this.#clear();
  }

  get paused() {
    return this.#paused;
  }

  /** Show on the stick what somebody else commands. */
  reflect([along, across]) {
    if (!this.stick.held) this.stick.show(along, across);
  }

  get command() {
    const { along, across, name } = this.#active;
    return { along, across, device: name };
  }

  /** Let go of everything, say so, and be silent. */
  pause() {
    if (this.#paused) return;
    this.#clear();
    if (this.#driving) this.send(this.command);
    this.#paused = true;
    this.dispatchEvent(new Event("pause"));
  }

  resume() {
    if (!this.#paused || document.hidden) return;
    this.#paused = false;
    this.dispatchEvent(new Event("resume"));
  }

  #clear() {
    for (const device of [this.keyboard, this.gamepad, this.stick]) device.clear();
  }

  #changed(device, touched) {
    if (this.#paused) return;
    const moved = device.along !== 0 || device.across !== 0;
    if (moved) this.#active = device;
    if (device === this.#active) {
      if (this.#driving) this.send(this.command);
      if (!this.stick.held) this.stick.show(device.along, device.across);
    }
    if (moved || touched) this.dispatchEvent(new CustomEvent("moved", { detail: device.name }));
  }

  #tick() {
    if (this.#paused) return;
    this.gamepad.poll();
    if (this.#driving) this.send(this.command);
  }
}
