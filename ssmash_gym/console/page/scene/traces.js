// Load traces of several runs on one canvas: interval peaks of the in-plane probe load against time, limits, moments.
import { fitted } from "./canvas.js";

export const LINES = [[], [9, 4], [2, 3], [12, 4, 2, 4], [5, 2]]; // told apart without colours
export const TINTS = ["#ff9a55", "#4da3ff", "#ffd34d", "#c58cff", "#4fd18b"];
const INK = { grid: "#263241", text: "#9fb0c3", soft: "#f4be3c", limit: "#f0483e", area: "#141c26" };
const EDGE = { left: 46, right: 12, top: 10, bottom: 22 };
const NEAR_PX = 11; // within which a click means a marker

/** A round step so that `span` has at most `most` of them. */
function step(span, most) {
  const size = 10 ** Math.floor(Math.log10(span / most));
  return size * ([1, 2, 5, 10].find((factor) => span / (size * factor) <= most) ?? 10);
}

export class Traces {
  /**
   * @param parent Element that it fills.
   * @param runs What is drawn, see ssmash_gym/console/runs.py.
   * @param picked Called with a time [s] when a place or a marker is clicked.
   */
  constructor(parent, runs, picked) {
    this.runs = runs;
    this.picked = picked;
    this.canvas = document.createElement("canvas");
    this.cursor = document.createElement("div");
    this.cursor.className = "player-cursor";
    parent.append(this.canvas, this.cursor);
    this.parent = parent;
    this.end = Math.max(...runs.map((run) => run.frames[run.frames.length - 1].t), 1e-3);
    this.start = Math.min(...runs.map((run) => run.frames[0].t));
    const peaks = runs.flatMap((run) => run.frames.map((frame) => frame.probe_peak_kN));
    const limits = runs[0].setup.limits;
    this.limits = limits;
    this.top = Math.max(1.08 * Math.max(...peaks), limits ? 1.12 * limits.probe_kN : 1);
    this.observer = new ResizeObserver(() => this.draw());
    this.observer.observe(parent);
    this.dragging = false;
    parent.addEventListener("pointerdown", (event) => this.#press(event));
    parent.addEventListener("pointermove", (event) => this.#hover(event));
    parent.addEventListener("pointerup", () => (this.dragging = false));
    this.draw();
  }

  dispose() {
    this.observer.disconnect();
  }

  x(time) {
    return EDGE.left + ((time - this.start) / (this.end - this.start)) * (this.width - EDGE.left - EDGE.right);
  }

  y(load) {
    return this.height - EDGE.bottom - (load / this.top) * (this.height - EDGE.top - EDGE.bottom);
  }

  /** Put the line of the present time. */
  mark(time) {
    if (this.width) this.cursor.style.transform = `translateX(${this.x(time).toFixed(1)}px)`;
  }

  draw() {
    const box = this.parent.getBoundingClientRect();
    if (box.width < 60 || box.height < 40) return;
    [this.width, this.height] = [box.width, box.height];
    const g = fitted(this.canvas, box);
    this.#axes(g);
    this.#limits(g);
    for (let i = this.runs.length - 1; i >= 0; i--) this.#trace(g, i);
    this.#limitNames(g);
    this.markers = [];
    for (let i = this.runs.length - 1; i >= 0; i--) this.#moments(g, i);
    this.mark(this.now ?? this.start);
  }

  #axes(g) {
    g.fillStyle = INK.area;
    g.fillRect(EDGE.left, EDGE.top, this.width - EDGE.left - EDGE.right, this.height - EDGE.top - EDGE.bottom);
    g.strokeStyle = INK.grid;
    g.fillStyle = INK.text;
    g.lineWidth = 1;
    g.textBaseline = "middle";
    g.textAlign = "right";
    const loads = step(this.top, Math.max(2, Math.floor(this.height / 34)));
    for (let v = 0; v <= this.top; v += loads) {
      g.beginPath();
      g.moveTo(EDGE.left, this.y(v));
      g.lineTo(this.width - EDGE.right, this.y(v));
      g.stroke();
      g.fillText(`${v} kN`, EDGE.left - 6, this.y(v));
    }
    g.textBaseline = "top";
    g.textAlign = "center";
    const span = this.end - this.start;
    const times = step(span, Math.max(3, Math.floor(this.width / 90)));
    for (let t = Math.ceil(this.start / times) * times; t <= this.end; t += times) {
      g.fillText(`${Number(t.toFixed(3))} s`, this.x(t), this.height - EDGE.bottom + 5);
    }
  }

  #limits(g) {
    if (!this.limits) return;
    const lines = [["probe_soft_kN", INK.soft, [3, 4]], ["probe_kN", INK.limit, []]];
    for (const [key, tint, dash] of lines) {
      const y = this.y(this.limits[key]);
      g.setLineDash(dash);
      g.strokeStyle = tint;
      g.lineWidth = 1.5;
      g.beginPath();
      g.moveTo(EDGE.left, y);
      g.lineTo(this.width - EDGE.right, y);
      g.stroke();
      g.setLineDash([]);
    }
  }

  #limitNames(g) {
    if (!this.limits) return;
    const names = [["probe_soft_kN", "soft limit", INK.soft], ["probe_kN", "limit", INK.limit]];
    g.textAlign = "left";
    g.textBaseline = "bottom";
    for (const [key, words, tint] of names) {
      const text = `${words} ${this.limits[key]} kN`;
      const y = this.y(this.limits[key]);
      g.fillStyle = "rgba(20, 28, 38, 0.85)";
      g.fillRect(EDGE.left + 2, y - 16, g.measureText(text).width + 8, 15);
      g.fillStyle = tint;
      g.fillText(text, EDGE.left + 6, y - 2);
    }
  }

  #trace(g, i) {
    g.strokeStyle = TINTS[i % TINTS.length];
    g.setLineDash(LINES[i % LINES.length]);
    g.lineWidth = i === 0 ? 2 : 1.7;
    g.lineJoin = "round";
    g.beginPath();
    for (const frame of this.runs[i].frames) g.lineTo(this.x(frame.t), this.y(frame.probe_peak_kN));
    g.stroke();
    g.setLineDash([]);
  }

  #moments(g, i) {
    (this.runs[i].moments ?? []).forEach((moment, n) => {
      const x = this.x(moment.time_s);
      const y = Math.max(EDGE.top + 12, this.y(moment.peak_kN) - 8);
      g.fillStyle = TINTS[i % TINTS.length];
      g.strokeStyle = "#0b1016";
      g.lineWidth = 1.5;
      g.beginPath();
      g.moveTo(x, y + 6);
      g.lineTo(x - 6, y - 5);
      g.lineTo(x + 6, y - 5);
      g.closePath();
      g.fill();
      g.stroke();
      this.markers.push({ x, y, moment, run: i, n });
    });
  }

  #marker(event) {
    const box = this.parent.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    return this.markers?.find((m) => Math.hypot(m.x - x, m.y - y) < NEAR_PX);
  }

  #time(event) {
    const box = this.parent.getBoundingClientRect();
    const share = (event.clientX - box.left - EDGE.left) / (this.width - EDGE.left - EDGE.right);
    return this.start + Math.min(1, Math.max(0, share)) * (this.end - this.start);
  }

  #press(event) {
    const marker = this.#marker(event);
    this.dragging = !marker;
    if (this.dragging) this.parent.setPointerCapture(event.pointerId);
    this.picked(marker ? marker.moment.time_s : this.#time(event), marker);
  }

  #hover(event) {
    if (this.dragging) {
      this.picked(this.#time(event), null);
      return;
    }
    const marker = this.#marker(event);
    this.parent.classList.toggle("over-marker", Boolean(marker));
    this.parent.title = marker ? marker.moment.words : "";
  }
}
