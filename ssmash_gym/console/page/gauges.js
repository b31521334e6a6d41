/** The gauges beside the scene: loads with their limits, the claw, the way, the alignment, the deck. */
import { clamp, finite, make, number, write } from "./dom.js";
import { Deviation, Horizon, LoadBar, SpeedCross, StationBar, Way } from "./instruments.js";

const ORDER = [2, 0, 1]; // port, auxiliary, starboard, as one looks along the helicopter
const SHORT = { right: "Starboard", left: "Port" };
const SPANS = { lateral_m: 0.3, yaw_deg: 10 }; // ends of the scales

export class Gauges {
  constructor(root) {
    this.probe = new LoadBar();
    this.stations = ORDER.map(() => new StationBar());
    this.cross = new SpeedCross();
    this.way = new Way();
    this.lateral = new Deviation();
    this.yaw = new Deviation();
    this.horizon = new Horizon();
    this.text = {};
    root.replaceChildren(this.#probe(), this.#goal(), this.#claw(), this.#stations(), this.#deck());
  }

  #word(name, tag = "span", attributes = {}) {
    this.text[name] = make(tag, { "data-gauge": name, ...attributes });
    return this.text[name];
  }

  #head(title, value, state) {
    return make("div", { class: "head" }, make("h2", { text: title }), this.#word(state, "em"), this.#word(value, "b"));
  }

  #probe() {
    return make("section", { class: "gauge" }, this.#head("Probe load", "probe", "probe-state"), this.probe.root);
  }

  #stations() {
    const columns = this.stations.map((bar, k) =>
      make(
        "div", { class: "column" }, bar.root, this.#word(`station-${k}`, "b"), this.#word(`station-${k}-name`),
        this.#word(`station-${k}-state`, "em"),
      ),
    );
    return make("section", { class: "gauge" }, make("div", { class: "head" }, make("h2", { text: "Wheel loads" })),
      make("div", { class: "columns" }, ...columns));
  }

  #claw() {
    return make(
      "section", { class: "gauge claw" }, this.cross.root,
      make("div", { class: "lines" }, make("h2", { text: "Claw" }), this.#word("along", "p"), this.#word("across", "p"),
        this.#word("travel", "p", { class: "dim" })),
    );
  }

  #goal() {
    const row = (name, dial, title) =>
      make("div", { class: "deviation-row" },
        make("div", { class: "head" }, make("h3", { text: title }), this.#word(`${name}-state`, "em"), this.#word(name, "b")),
        dial.root);
    this.hold = make("progress", { max: 1, value: 0, "aria-label": "time held in the goal" });
    return make(
      "section", { class: "gauge" }, this.#head("To go", "to-go", "to-go-state"), this.way.root,
      row("lateral", this.lateral, "Off the centre line"), row("yaw", this.yaw, "Heading"),
      make("div", { class: "hold" }, make("span", { text: "Held" }), this.hold, this.#word("held", "b")),
    );
  }

  #deck() {
    return make(
      "section", { class: "gauge deck-tile" }, this.horizon.root,
      make("div", { class: "lines" }, make("h2", { text: "Deck" }), this.#word("deck", "p"), this.#word("sea", "p", { class: "dim" })),
    );
  }

  /** What does not move in an episode. */
  setup(setup) {
    this.about = setup;
    const { limits, track, sea } = setup;
    this.probe.scale(limits);
    this.stations.forEach((bar, k) => {
      const name = setup.stations[ORDER[k]];
      bar.scale(name === "auxiliary" ? null : limits.station_kN, 1.15 * limits.station_kN, limits.lift_off_kN);
      write(this.text[`station-${k}-name`], SHORT[name] ?? "");
    });
    if (track) {
      this.way.scale(track);
      this.lateral.scale(track.lateral_tolerance_m, SPANS.lateral_m);
      this.yaw.scale(track.yaw_tolerance_deg, SPANS.yaw_deg);
    }
    write(this.text.sea, sea ? `Waves ${number(sea.hs_m)} m, ${number(sea.speed_kn, 0)} kn` : "No sea");
  }

  /** A frame. */
  show(frame) {
    if (!this.about) return;
    this.#showLoads(frame);
    this.#showClaw(frame);
    if (this.about.track) this.#showGoal(frame, this.about.track);
    this.horizon.show(frame.deck_roll_deg);
    write(this.text.deck, `Roll ${number(Math.abs(frame.deck_roll_deg))}\u00b0 ${sided(frame.deck_roll_deg, "to starboard", "to port")}`);
  }

  #showLoads(frame) {
    const { limits } = this.about;
    const load = Math.max(frame.probe_kN, frame.probe_peak_kN ?? 0);
    this.probe.show(load, frame.peak_kN);
    write(this.text.probe, `${number(load)} kN`);
    const level = load > limits.probe_kN ? "over" : load > limits.probe_soft_kN ? "raised" : "fine";
    const passed = frame.peak_kN > limits.probe_kN;
    const peak = `${passed ? "\u25b2 " : ""}peak ${number(frame.peak_kN)}`;
    this.#state("probe-state", level, { over: "\u25b2 over the limit", raised: passed ? peak : "raised", fine: peak });
    ORDER.forEach((station, k) => {
      const kN = frame.load_kN[station];
      const main = this.about.stations[station] !== "auxiliary";
      if (!main) write(this.text[`station-${k}-name`], auxiliaryName(frame));
      this.stations[k].show(kN);
      write(this.text[`station-${k}`], `${number(kN, 0)} kN`);
      const is = main && kN > limits.station_kN ? "over" : kN < limits.lift_off_kN ? "lifted" : "fine";
      this.#state(`station-${k}-state`, is, { over: "\u25b2 over", lifted: "\u25b3 lifted", fine: "" });
    });
  }

  #showClaw(frame) {
    const [vx, vy] = frame.claw.slice(3);
    const { claw } = this.about;
    this.cross.show(frame.command, claw ? [vx / claw.speed_along_m_s, vy / claw.speed_across_m_s] : [0, 0]);
    write(this.text.along, `${number(Math.abs(vx), 2)} m/s ${sided(vx, "forward", "aft", 0.005)}`);
    write(this.text.across, `${number(Math.abs(vy), 2)} m/s ${sided(vy, "to starboard", "to port", 0.005)}`);
    if (!claw) return;
    const left = claw.y_travel_m - Math.abs(frame.claw[1]);
    write(this.text.travel, left < 0.01 ? "\u25b2 at the end of its travel" : `${number(left, 2)} m of travel left`);
  }

  #showGoal(frame, track) {
    this.way.show(track.goal_x_m - frame.to_go_m);
    write(this.text["to-go"], `${number(Math.max(0, frame.to_go_m), 2)} m`);
    const near = Math.abs(frame.to_go_m) <= track.goal_tolerance_m;
    this.#state("to-go-state", near ? "good" : "fine", { good: "\u2713 there", fine: "" });
    this.lateral.show(frame.lateral_m);
    write(this.text.lateral, `${number(100 * Math.abs(frame.lateral_m), 0)} cm ${sided(frame.lateral_m, "stbd", "port")}`);
    this.#within("lateral-state", Math.abs(frame.lateral_m) <= track.lateral_tolerance_m);
    this.yaw.show(frame.yaw_deg);
    write(this.text.yaw, `${number(Math.abs(frame.yaw_deg))}\u00b0 ${sided(frame.yaw_deg, "stbd", "port")}`);
    this.#within("yaw-state", Math.abs(frame.yaw_deg) <= track.yaw_tolerance_deg);
    const held = clamp(frame.held ?? 0, 0, 1);
    const needed = this.about.goal_hold_s;
    this.hold.value = held;
    write(this.text.held, finite(needed) ? `${number(held * needed)} of ${number(needed, 0)} s` : `${number(100 * held, 0)} %`);
  }

  #within(name, inside) {
    this.#state(name, inside ? "good" : "fine", { good: "\u2713 within", fine: "off" });
  }

  #state(name, level, words) {
    this.text[name].dataset.level = level;
    write(this.text[name], words[level]);
  }
}

/** Where the auxiliary gear is, as pilots call it. */
export const auxiliaryName = ({ struts }) => (struts[0][0] > struts[1][0] ? "Nose" : "Tail");

function sided(value, positive, negative, none = 0) {
  if (Math.abs(value) <= none) return "";
  return value > 0 ? positive : negative;
}
