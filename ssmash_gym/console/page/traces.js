/** Loads of the last 30 seconds on one canvas: the probe's with its limits above, the wheels' below. */
import { clamp, number } from "./dom.js";
import { auxiliaryName } from "./gauges.js";
import { fitted } from "./scene/canvas.js";

const SPAN_S = 30;
const LEFT = 44;
const RIGHT = 74; // names at the lines' ends
const NARROW = 600; // pixels
const LINES = [
  { name: "port", index: 2, dash: [] },
  { name: null, index: 0, dash: [2, 3] },
  { name: "starboard", index: 1, dash: [7, 4] },
];

export class Traces {
  #rows = [];
  #dirty = true;

  constructor(canvas) {
    this.canvas = canvas;
    this.limits = null;
    new ResizeObserver(() => (this.#dirty = true)).observe(canvas);
    const loop = () => {
      if (this.#dirty) this.#paint();
      requestAnimationFrame(loop);
    };
    requestAnimationFrame(loop);
  }

  setup(setup) {
    this.limits = setup.limits;
    this.#rows = [];
    this.#dirty = true;
  }

  /** Add a frame; one from before the newest begins anew. */
  add(frame) {
    const last = this.#rows.at(-1);
    if (last && frame.t < last.t) this.#rows = [];
    if (last && frame.t === last.t) this.#rows.pop();
    this.auxiliary = auxiliaryName(frame).toLowerCase();
    this.#rows.push({ t: frame.t, probe: Math.max(frame.probe_kN, frame.probe_peak_kN ?? 0), loads: frame.load_kN });
    while (this.#rows[0].t < frame.t - SPAN_S - 1) this.#rows.shift();
    this.#dirty = true;
  }

  #paint() {
    this.#dirty = false;
    const box = this.canvas.getBoundingClientRect();
    if (!box.width || !box.height) return;
    const g = fitted(this.canvas, box);
    const look = getComputedStyle(document.documentElement);
    this.ink = (name) => look.getPropertyValue(`--${name}`).trim();
    const below = box.width < NARROW; // one under the other
    const [width, height] = below ? [box.width, 0.5 * box.height] : [0.5 * box.width, box.height];
    const plot = { x: LEFT, top: 20, width: width - LEFT - RIGHT, height: height - 38 };
    this.#probe(g, plot);
    this.#wheels(g, below ? { ...plot, top: plot.top + height } : { ...plot, x: plot.x + width });
  }

  #probe(g, plot) {
    const most = Math.max(0, ...this.#rows.map((row) => row.probe));
    const limit = this.limits?.probe_kN ?? 15;
    const top = Math.max(1.3 * limit, 1.1 * most);
    this.#axes(g, plot, "Probe load, kN", top, stepOf(top));
    this.#line(g, plot, top, (row) => row.probe, [], "accent");
    if (this.limits) {
      this.#level(g, plot, top, this.limits.probe_soft_kN, "soft", [2, 4], "line-strong");
      this.#level(g, plot, top, limit, "limit", [8, 4], "bad");
    }
    const last = this.#rows.at(-1);
    if (last) this.#end(g, plot, top, last.probe, `${number(last.probe)} kN`, "text");
  }

  #wheels(g, plot) {
    const limit = this.limits?.station_kN ?? 90;
    const top = 1.15 * limit;
    this.#axes(g, plot, "Wheel loads, kN", top, 30);
    for (const { index, dash } of LINES) this.#line(g, plot, top, (row) => row.loads[index], dash, "wheel");
    if (this.limits) this.#level(g, plot, top, limit, "limit", [8, 4], "bad");
    const last = this.#rows.at(-1);
    if (!last) return;
    let free = -Infinity;
    const ends = LINES.map((line) => ({ ...line, y: yOf(plot, top, last.loads[line.index]) })).sort((a, b) => a.y - b.y);
    for (const { name, y } of ends) {
      free = Math.max(y, free + 13); // names do not cover each other
      g.fillStyle = this.ink("text");
      g.textAlign = "left";
      g.fillText(name ?? this.auxiliary, plot.x + plot.width + 6, free + 4);
    }
  }

  #axes(g, plot, title, top, step) {
    g.textAlign = "left";
    g.fillStyle = this.ink("text");
    g.fillText(title, plot.x, plot.top - 8);
    g.fillStyle = this.ink("dim");
    g.strokeStyle = this.ink("line");
    g.lineWidth = 1;
    for (let value = 0; value <= top; value += step) {
      const y = yOf(plot, top, value);
      stroke(g, [], (path) => path.moveTo(plot.x, y).lineTo(plot.x + plot.width, y));
      g.textAlign = "right";
      g.fillText(String(value), plot.x - 6, y + 4);
    }
    for (const seconds of [0, 10, 20, 30]) {
      g.textAlign = "center";
      g.fillText(seconds ? `\u2212${seconds} s` : "now", plot.x + plot.width * (1 - seconds / SPAN_S), plot.top + plot.height + 14);
    }
  }

  #level(g, plot, top, value, word, dash, ink) {
    const y = yOf(plot, top, value);
    g.strokeStyle = this.ink(ink);
    g.lineWidth = 1.5;
    stroke(g, dash, (path) => path.moveTo(plot.x, y).lineTo(plot.x + plot.width, y));
    g.textAlign = "left";
    const width = g.measureText(word).width + 8;
    g.fillStyle = this.ink("page");
    g.fillRect(plot.x + 2, y - 8, width, 16);
    g.fillStyle = this.ink("dim");
    g.fillText(word, plot.x + 6, y + 4);
  }

  #line(g, plot, top, value, dash, ink) {
    if (this.#rows.length < 2) return;
    const now = this.#rows.at(-1).t;
    g.save();
    g.beginPath();
    g.rect(plot.x, plot.top - 4, plot.width, plot.height + 6);
    g.clip();
    g.strokeStyle = this.ink(ink);
    g.lineWidth = 1.8;
    g.lineJoin = "round";
    stroke(g, dash, (path) => {
      for (const row of this.#rows) path.lineTo(plot.x + plot.width * (1 - (now - row.t) / SPAN_S), yOf(plot, top, value(row)));
    });
    g.restore();
  }

  #end(g, plot, top, value, text, ink) {
    g.fillStyle = this.ink(ink);
    g.textAlign = "left";
    g.fillText(text, plot.x + plot.width + 6, yOf(plot, top, value) + 4);
  }
}

const yOf = (plot, top, value) => plot.top + plot.height * (1 - clamp(value / top, 0, 1));
const stepOf = (top) => [5, 10, 20, 50].find((step) => top / step <= 5) ?? 100;

function stroke(g, dash, along) {
  g.setLineDash(dash);
  g.beginPath();
  const path = { moveTo: (x, y) => (g.moveTo(x, y), path), lineTo: (x, y) => (g.lineTo(x, y), path) };
  along(path);
  g.stroke();
  g.setLineDash([]);
}
