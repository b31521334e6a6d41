/**
 * The instruments that the gauges are made of, as SVG. What matters is told three times: by place, by a word and by
 * colour, so that it is legible in grey.
 */
import { clamp, draw, finite, number } from "./dom.js";

const WIDTH = 300;

/** Square-root scale: low loads, at which one drives, get room; the ultimate load still fits. */
const rooted = (value, top) => Math.sqrt(clamp(value / top, 0, 1));

/** Load of the probe from zero to ultimate, with its limits as marks and the largest one so far. */
export class LoadBar {
  constructor() {
    this.bar = draw("rect", { class: "fill", x: 0, y: 14, height: 20, width: 0, rx: 3 });
    this.peak = draw("path", { class: "peak", d: "" });
    this.marks = draw("g", { class: "marks" });
    this.root = draw(
      "svg", { viewBox: `0 0 ${WIDTH} 62`, class: "instrument load-bar", "aria-hidden": "true" },
      hatch("over-limit", 5), draw("rect", { class: "ground", x: 0, y: 14, height: 20, width: WIDTH, rx: 3 }),
      this.marks, this.bar, this.peak,
    );
  }

  scale({ probe_soft_kN: soft, probe_kN: limit, probe_ultimate_kN: ultimate }) {
    this.top = ultimate;
    const x = (load) => WIDTH * rooted(load, ultimate);
    const mark = (load, word, anchor) => [
      draw("path", { class: `mark ${word}`, d: `M${x(load)} 10v28` }),
      draw("text", { x: clamp(x(load), 0, WIDTH), y: 51, "text-anchor": anchor, text: `${word} ${number(load, 0)}` }),
    ];
    this.marks.replaceChildren(
      draw("rect", { class: "zone", x: x(limit), y: 14, height: 20, width: WIDTH - x(limit), fill: "url(#over-limit)" }),
      ...mark(soft, "soft", "middle"), ...mark(limit, "limit", "middle"), ...mark(ultimate, "ultimate", "end"),
    );
  }

  show(load, peak) {
    if (!this.top) return;
    this.bar.setAttribute("width", (WIDTH * rooted(load, this.top)).toFixed(1));
    const x = WIDTH * rooted(peak, this.top);
    this.peak.setAttribute("d", peak > 0 ? `M${x.toFixed(1)} 13l-5 -8h10z` : "");
  }
}

/** Vertical load of one station, with the limit (where it has one) and the load below which it counts as lifted. */
export class StationBar {
  constructor() {
    this.bar = draw("rect", { class: "fill", x: 27, width: 26, y: 74, height: 0, rx: 3 });
    this.marks = draw("g", { class: "marks" });
    this.root = draw(
      "svg", { viewBox: "0 0 80 78", class: "instrument station", "aria-hidden": "true" },
      draw("rect", { class: "ground", x: 27, y: 4, width: 26, height: 70, rx: 3 }), this.bar, this.marks,
    );
  }

  scale(limit, top, liftOff) {
    this.top = top;
    const y = (load) => 74 - 70 * clamp(load / top, 0, 1);
    this.marks.replaceChildren(
      limit ? draw("path", { class: "mark limit", d: `M20 ${y(limit)}h40` }) : "",
      draw("path", { class: "mark soft", d: `M23 ${y(liftOff)}h34` }),
    );
  }

  show(load) {
    const height = 70 * clamp(load / this.top, 0, 1);
    this.bar.setAttribute("y", (74 - height).toFixed(1));
    this.bar.setAttribute("height", height.toFixed(1));
  }
}

/** The claw's command (ring) and what it does (dot), as shares of its greatest speeds; up is towards the hangar. */
export class SpeedCross {
  constructor() {
    this.ring = draw("circle", { class: "command", r: 9 });
    this.dot = draw("circle", { class: "actual", r: 5 });
    this.root = draw(
      "svg", { viewBox: "-60 -60 120 120", class: "instrument cross", "aria-hidden": "true" },
      draw("rect", { class: "ground", x: -50, y: -50, width: 100, height: 100, rx: 8 }),
      draw("path", { class: "axis", d: "M-50 0H50M0 -50V50M-25 -3v6M25 -3v6M-3 -25h6M-3 25h6" }),
      draw("path", { class: "tip", d: "M0 -58l4 6h-8z" }), this.ring, this.dot,
    );
  }

  show(command, speed) {
    place(this.ring, command);
    place(this.dot, speed);
  }
}

function place(circle, [along, across]) {
  circle.setAttribute("cx", (46 * clamp(across, -1, 1)).toFixed(1));
  circle.setAttribute("cy", (-46 * clamp(along, -1, 1)).toFixed(1));
}

/** A deviation from zero to either side, with the band that the goal allows. */
export class Deviation {
  constructor() {
    this.band = draw("rect", { class: "band", y: 8, height: 14 });
    this.marker = draw("path", { class: "marker", d: "M0 26l-7 -0l7 -12l7 12z" });
    this.root = draw(
      "svg", { viewBox: "-150 0 300 30", class: "instrument deviation", "aria-hidden": "true" },
      draw("rect", { class: "ground", x: -150, y: 12, width: 300, height: 6, rx: 3 }), this.band,
      draw("path", { class: "axis", d: "M0 4v22" }), this.marker,
    );
  }

  scale(tolerance, top) {
    this.top = top;
    const half = 150 * this.#share(tolerance);
    this.band.setAttribute("x", (-half).toFixed(1));
    this.band.setAttribute("width", (2 * half).toFixed(1));
  }

  #share(value) {
    return Math.sign(value) * rooted(Math.abs(value), this.top);
  }

  show(value) {
    if (this.top) this.marker.setAttribute("transform", `translate(${(143 * this.#share(value)).toFixed(1)} 0)`);
  }
}

/** The way from the start to the goal, with the hangar door. */
export class Way {
  constructor() {
    this.done = draw("rect", { class: "fill", x: 0, y: 8, height: 8, width: 0, rx: 3 });
    this.door = draw("path", { class: "mark limit", d: "" });
    this.claw = draw("circle", { class: "actual", cx: 0, cy: 12, r: 7 });
    this.root = draw(
      "svg", { viewBox: "-8 0 316 24", class: "instrument way", "aria-hidden": "true" },
      draw("rect", { class: "ground", x: 0, y: 8, width: WIDTH, height: 8, rx: 3 }), this.done, this.door,
      draw("path", { class: "goal", d: `M${WIDTH - 1} 2v20` }), this.claw,
    );
  }

  scale({ start_x_m: start, goal_x_m: goal, door_claw_x_m: door }) {
    [this.start, this.goal] = [start, goal];
    const x = WIDTH * clamp((door - start) / (goal - start), 0, 1);
    this.door.setAttribute("d", finite(x) ? `M${x.toFixed(1)} 4v16` : "");
  }

  show(x_m) {
    const x = WIDTH * clamp((x_m - this.start) / (this.goal - this.start), 0, 1);
    this.done.setAttribute("width", x.toFixed(1));
    this.claw.setAttribute("cx", x.toFixed(1));
  }
}

/** The deck's roll against the horizon, seen from astern. */
export class Horizon {
  constructor() {
    this.deck = draw("path", { class: "deck", d: "M-34 0h68M-10 0v-9h20v9" });
    this.root = draw(
      "svg", { viewBox: "-42 -30 84 60", class: "instrument horizon", "aria-hidden": "true" },
      draw("path", { class: "axis", d: "M-42 0H42" }), this.deck,
    );
  }

  show(roll_deg) {
    this.deck.setAttribute("transform", `rotate(${clamp(roll_deg, -45, 45).toFixed(1)})`);
  }
}

function hatch(id, size) {
  return draw(
    "defs", {},
    draw(
      "pattern", { id, width: size, height: size, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
      draw("path", { class: "hatch", d: `M0 0V${size}` }),
    ),
  );
}
