/** After an episode: the score in words and figures, and the own run beside the agent's. */
import { byId, finite, make, number, show, write } from "./dom.js";

const FIGURES = [
  ["time_s", "Time", (v) => `${number(v)} s`],
  ["peak_probe_kN", "Highest load", (v) => `${number(v)} kN`],
  ["over_limit_s", "Over the limit", (v) => `${number(v)} s`],
  ["return", "Score", (v) => number(v)],
];

export class Outcome {
  result = null;
  #player = null;

  constructor(link, roles) {
    Object.assign(this, { link, roles });
    link.addEventListener("result", ({ detail }) => this.show(detail));
    link.addEventListener("review", ({ detail }) => this.#review(detail.runs));
    link.addEventListener("refused", ({ detail }) => detail.about === "review" && this.#waiting(false));
    link.addEventListener("phase", ({ detail }) => detail.phase !== "over" && detail.phase !== "done" && this.clear());
    const say = (id, message) => byId(id).addEventListener("click", () => link.send(message));
    say("result-again", { type: "again" });
    say("result-next", { type: "next" });
    byId("result-close").addEventListener("click", () => show(byId("result"), false));
    byId("review").addEventListener("click", () => this.#waiting(link.send({ type: "review" })));
    byId("review-close").addEventListener("click", () => this.#close());
    addEventListener("keydown", (event) => event.key === "Escape" && this.reviewing && this.#close());
  }

  get reviewing() {
    return !byId("review-box").hidden;
  }

  clear() {
    this.result = null;
    show(byId("result"), false);
  }

  /** The card. What is said of the run comes from the server. */
  show(result) {
    this.result = result;
    const { metrics, words, valid } = result;
    const good = Boolean(metrics?.success);
    byId("result").dataset.outcome = !valid ? "void" : good ? "good" : "bad";
    write(byId("result-title"), title(metrics, valid));
    byId("result-words").replaceChildren(...(words ?? []).map((text) => make("li", { text })));
    const figures = FIGURES.filter(([key]) => finite(metrics?.[key]));
    byId("result-numbers").replaceChildren(
      ...figures.map(([key, name, shown]) => make("div", {}, make("dt", { text: name }), make("dd", { text: shown(metrics[key]) }))),
    );
    write(byId("result-small"), small(result));
    const { mine, trial } = this.roles;
    show(byId("result-again"), mine && !trial);
    show(byId("result-next"), mine);
    this.#waiting(false);
    show(byId("result"), true);
    if (mine) byId("result-next").focus({ preventScroll: true });
  }

  #waiting(waiting) {
    byId("review").disabled = waiting;
    const agent = this.result?.beside;
    const [ask, wait] = agent ? ["Watch beside the agent", "The agent drives the same sea\u2026"] : ["Watch it again", "In a moment\u2026"];
    write(byId("review"), waiting ? wait : ask);
  }

  async #review(runs) {
    this.#waiting(false);
    const { Player } = await import("./scene/player.js");
    show(byId("review-box"), true);
    this.#player = new Player(byId("player"), runs);
    write(byId("review-title"), runs.length > 1 ? `Your run beside ${runs[1].name}, in the same sea` : "Your run");
    byId("player").focus();
  }

  #close() {
    this.#player?.dispose();
    this.#player = null;
    show(byId("review-box"), false);
    byId("review").focus();
  }
}

function title(metrics, valid) {
  if (!metrics) return "Broken off";
  if (!valid) return "This run does not count";
  return metrics.success ? "In the hangar position, straight" : "Not in the hangar this time";
}

function small({ file, latency_ms: latency, late_share: late }) {
  const parts = [];
  if (file) parts.push(`Recorded in ${file}`);
  if (finite(latency?.p95)) parts.push(`input delay ${number(latency.p50, 0)} ms, 95 % below ${number(latency.p95, 0)} ms`);
  if (finite(late)) parts.push(`late steps ${number(100 * late)} %`);
  return parts.join(" \u00b7 ");
}
