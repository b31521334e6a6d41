// Replay of one or more runs in one scene: the first solid, the others as translucent helicopters beside it, with a time
// slider, load traces, the moments of the peaks, and views.
//
//   const player = new Player(element, runs);   // runs: see ssmash_gym/console/runs.py
//   player.seek(12.5); player.play(); player.pause(); player.dispose();
//
// Its look is in player.css beside it. Keys, while the focus is inside: space plays and pauses, the arrow keys go a
// second back and on (with shift: one interval), Home and End to the ends, 1 to 4 choose the view.
import { frameAt } from "./interpolate.js";
import { Stage, VIEWS } from "./stage.js";
import { LINES, TINTS, Traces } from "./traces.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4];
const LEAD_S = 2; // before a moment, where its replay begins
const READ_MS = 90; // between two writings of the numbers
const ENDINGS = {
  goal: "goal held", ultimate_load: "ultimate probe load", probe_lost: "probe lost", overturning: "overturned",
  corridor: "left the corridor", divergence: "simulation diverged", time: "time was up",
};

/** An element with properties and children. */
function make(tag, properties = {}, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(properties)) {
    if (key in node && typeof value !== "string") node[key] = value;
    else node.setAttribute(key === "className" ? "class" : key, value);
  }
  node.append(...children);
  return node;
}

/** A sample of a run's line, as in the traces. */
function swatch(i) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 34 10");
  svg.setAttribute("class", "player-swatch");
  svg.setAttribute("aria-hidden", "true");
  const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
  const given = { x1: 1, x2: 33, y1: 5, y2: 5, stroke: TINTS[i % TINTS.length], "stroke-width": 3 };
  for (const [key, value] of Object.entries(given)) line.setAttribute(key, value);
  line.setAttribute("stroke-dasharray", LINES[i % LINES.length].join(" "));
  svg.append(line);
  return svg;
}

/** A number in words, without a minus before a zero. */
function fixed(value, places) {
  return value.toFixed(places).replace(/^-(0\.?0*)$/, "$1");
}

/** How a run ended, in words. */
export function outcome(run) {
  const result = run.result;
  if (!result) return "";
  return `${ENDINGS[result.reason] ?? result.reason} after ${result.time_s.toFixed(1)} s`;
}

export class Player {
  /**
   * @param root Element to fill.
   * @param runs One or more runs; the first is the solid helicopter, and its deck moves.
   * @param options quality: see Stage; camera: view to begin with.
   */
  constructor(root, runs, { quality = null, camera = "follow" } = {}) {
    if (!runs.length) throw new Error("there is no run to show");
    this.root = root;
    this.runs = runs;
    this.playing = false;
    this.speed = 1;
    this.read = 0;
    this.start = Math.min(...runs.map((run) => run.frames[0].t));
    this.end = Math.max(...runs.map((run) => run.frames[run.frames.length - 1].t));
    this.time = this.start;
    this.#build();
    this.stage = new Stage(this.canvas, { quality });
    this.stage.setup(runs[0].setup);
    this.ghosts = runs.slice(1).map((run, i) => this.stage.addGhost(run.setup, TINTS[(i + 1) % TINTS.length]));
    this.view(camera, true);
    this.traces = new Traces(this.tracesBox, runs, (time, marker) => this.#pick(time, marker));
    this.pressed = (event) => this.#key(event);
    root.addEventListener("keydown", this.pressed);
    this.tick = (now) => this.#tick(now);
    this.seek(this.start);
  }

  #build() {
    this.root.classList.add("player");
    this.root.tabIndex = -1;
    this.canvas = make("canvas", { role: "img", "aria-label": "Helicopter, claw and deck in three dimensions" });
    this.views = Object.entries(VIEWS).map(([name, words]) =>
      make("button", { type: "button", "data-view": name, "aria-pressed": "false", onclick: () => this.view(name) }, words));
    const cameras = make("div", { className: "player-views", role: "group", "aria-label": "View" }, ...this.views);
    const picture = make("div", { className: "player-picture" }, this.canvas, cameras);
    this.tracesBox = make("div", { className: "player-traces", "aria-hidden": "true" });
    const side = make("aside", { className: "player-side" }, this.#legend(), this.#moments());
    const caption = make("p", { className: "player-caption" }, "In-plane load of the probe, peak of each interval");
    const bottom = make("div", { className: "player-bottom" }, caption, this.tracesBox, this.#controls());
    this.root.replaceChildren(picture, side, bottom);
  }

  /** Runs with their lines and their numbers at the present time. */
  #legend() {
    const titles = ["Load", "Peak", "Yaw", "To go"];
    const row = (cells, tag = "td") => make("tr", {}, ...cells.map((cell) => make(tag, {}, cell)));
    const head = row(titles, "th");
    head.querySelectorAll("th").forEach((cell) => (cell.scope = "col"));
    const bodies = [];
    this.cells = this.runs.map((run, i) => {
      const name = make("th", { scope: "rowgroup", colSpan: 4 }, swatch(i), run.name);
      const cells = titles.map(() => make("td"));
      const body = make("tbody", {}, make("tr", {}, name), make("tr", {}, ...cells));
      const ended = outcome(run);
      const words = [run.driver && `Driven by: ${run.driver}.`, ended && `${ended[0].toUpperCase()}${ended.slice(1)}.`, run.note];
      const told = words.filter(Boolean).join(" ");
      if (told) body.append(make("tr", { className: "player-told" }, make("td", { colSpan: 4 }, told)));
      bodies.push(body);
      return cells;
    });
    const parts = [make("h2", {}, "Runs"), make("table", {}, make("thead", {}, head), ...bodies)];
    const others = this.runs.filter((run) => run.seed !== this.runs[0].seed || run.configuration !== this.runs[0].configuration);
    if (others.length) {
      const names = others.map((run) => run.name).join(", ");
      parts.push(make("p", { className: "player-note" },
        `Not the same sea and helicopter as the first run: ${names}. The deck moves as in the first run.`));
    }
    return make("section", { className: "player-legend" }, ...parts);
  }

  #moments() {
    const list = make("ol");
    this.buttons = [];
    const all = this.runs.flatMap((run, i) => (run.moments ?? []).map((moment) => ({ moment, run, i })));
    for (const { moment, i } of all.sort((a, b) => a.i - b.i || a.moment.time_s - b.moment.time_s)) {
      const when = make("strong", {}, `${moment.time_s.toFixed(1)} s · ${moment.peak_kN.toFixed(1)} kN`);
      const button = make("button", { type: "button", onclick: () => this.#pick(moment.time_s, { moment }) },
        swatch(i), when, make("span", {}, moment.words));
      this.buttons.push({ button, moment });
      list.append(make("li", {}, button));
    }
    const section = make("section", { className: "player-moments" }, make("h2", {}, "What caused the peaks"), list);
    section.hidden = all.length === 0;
    return section;
  }

  #controls() {
    this.playButton = make("button", { type: "button", className: "player-play", onclick: () => this.toggle() }, "Play");
    const interval = this.runs[0].interval_s ?? 0.1;
    this.interval = interval;
    this.slider = make("input", {
      type: "range", min: String(this.start), max: String(this.end), step: "any", "aria-label": "Time",
      oninput: () => this.seek(Number(this.slider.value)),
    });
    this.clockText = make("output", { className: "player-time" });
    const speeds = SPEEDS.map((speed) => make("option", { value: String(speed), selected: speed === 1 }, `${speed} ×`));
    this.speedChoice = make("select", { "aria-label": "Speed", onchange: () => (this.speed = Number(this.speedChoice.value)) }, ...speeds);
    return make("div", { className: "player-controls" }, this.playButton, this.slider, this.clockText, this.speedChoice);
  }

  /** Take a view of the scene. */
  view(name, first = false) {
    this.stage.camera(name);
    for (const button of this.views) button.setAttribute("aria-pressed", String(button.dataset.view === name));
    if (first && this.stage.works) this.stage.cameras.since = Infinity;
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.playing) return;
    if (this.time >= this.end - 1e-6) this.seek(this.start);
    this.playing = true;
    this.last = null;
    this.playButton.textContent = "Pause";
    this.waiting = requestAnimationFrame(this.tick);
  }

  pause() {
    this.playing = false;
    this.playButton.textContent = "Play";
    cancelAnimationFrame(this.waiting);
  }

  /** Show all runs at a time [s]. */
  seek(time) {
    this.time = Math.min(this.end, Math.max(this.start, time));
    this.stage.show(this.runs[0], this.time);
    this.ghosts.forEach((ghost, i) => ghost.show(this.runs[i + 1], this.time));
    this.slider.value = String(this.time);
    this.traces.now = this.time;
    this.traces.mark(this.time);
    const now = performance.now();
    if (this.playing && now - this.read < READ_MS) return;
    this.read = now;
    this.#write();
  }

  #write() {
    const words = `${this.time.toFixed(1)} s of ${this.end.toFixed(1)} s`;
    this.clockText.textContent = words;
    this.slider.setAttribute("aria-valuetext", words);
    this.runs.forEach((run, i) => {
      const frame = run.frames[frameAt(run.frames, this.time + 1e-9)];
      const to_go = frame.to_go_m === null ? "–" : `${fixed(frame.to_go_m, 2)} m`;
      const numbers = [
        `${frame.probe_peak_kN.toFixed(1)} kN`, `${frame.peak_kN.toFixed(1)} kN`, `${fixed(frame.yaw_deg, 1)}°`, to_go,
      ];
      numbers.forEach((text, n) => (this.cells[i][n].textContent = text));
      const limit = run.setup.limits?.probe_kN ?? Infinity;
      this.cells[i][0].classList.toggle("over", frame.probe_peak_kN > limit);
    });
    for (const { button, moment } of this.buttons) {
      button.classList.toggle("present", Math.abs(moment.time_s - this.time) < 1);
    }
  }

  /** A place of the traces, or a moment: its replay begins a little before. */
  #pick(time, marker) {
    this.seek(marker ? Math.max(this.start, time - (this.playing ? LEAD_S : 0)) : time);
  }

  #tick(now) {
    if (!this.playing) return;
    const elapsed = this.last === null ? 0 : Math.min(0.25, (now - this.last) / 1000);
    this.last = now;
    this.seek(this.time + this.speed * elapsed);
    if (this.time >= this.end) {
      this.pause();
      this.#write();
      return;
    }
    this.waiting = requestAnimationFrame(this.tick);
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const tag = event.target.tagName;
    const pace = event.shiftKey ? this.interval : 1;
    const views = Object.keys(VIEWS);
    const act = {
      " ": () => this.toggle(),
      ArrowLeft: () => this.seek(this.time - pace),
      ArrowRight: () => this.seek(this.time + pace),
      Home: () => this.seek(this.start),
      End: () => this.seek(this.end),
    }[event.key] ?? (event.key in { 1: 0, 2: 0, 3: 0, 4: 0 } ? () => this.view(views[event.key - 1]) : null);
    if (!act || tag === "SELECT" || (event.key === " " && tag === "BUTTON")) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  }

  dispose() {
    this.pause();
    this.root.removeEventListener("keydown", this.pressed);
    this.traces.dispose();
    this.stage.dispose();
    this.root.replaceChildren();
    this.root.classList.remove("player");
  }
}
