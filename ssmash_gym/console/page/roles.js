/** Who holds the claw, who drives, which phase it is; the buttons that follow from it, and the banner. */
import { byId, show, write } from "./dom.js";

const PHASES = { preparing: "being prepared", ready: "ready", countdown: "get ready", running: "running", over: "over", done: "session done" };
const REFUSED_MS = 6000; // for which a refusal stays

export class Roles {
  me = null;
  mode = "drive";
  policy = null;
  form = true;
  driver = null;
  viewers = 0;
  by = "none";
  phase = "ready";
  #wants = !document.hidden; // at the start the claw is taken by itself if nobody holds it
  #expired = false;
  #refused = "";
  #asked = false; // a start is under way
  #first = true; // nothing has been driven yet: the picture of the controls is shown

  constructor(link, input) {
    Object.assign(this, { link, input });
    link.addEventListener("welcome", ({ detail }) => this.#welcome(detail));
    link.addEventListener("roles", ({ detail }) => this.#roles(detail));
    link.addEventListener("phase", ({ detail }) => this.#phase(detail));
    link.addEventListener("refused", ({ detail }) => this.#refuse(detail));
    link.addEventListener("down", () => this.#down());
    for (const name of ["pause", "resume"]) input.addEventListener(name, () => this.#banner());
    const say = (id, message) => byId(id).addEventListener("click", () => link.send(message));
    say("take", { type: "take" });
    say("release", { type: "release" });
    say("abort", { type: "abort" });
    say("again", { type: "again" });
    say("next", { type: "next" });
    say("hand-over", { type: "drive", by: "policy" });
    say("take-over", { type: "drive", by: "person" });
    for (const id of ["start", "go"]) byId(id).addEventListener("click", () => this.start());
    this.#draw();
  }

  /** Whether this page holds the claw. */
  get mine() {
    return this.link.up && this.me !== null && this.driver === this.me;
  }

  get trial() {
    return this.mode === "trial";
  }

  start() {
    if (!this.mine || this.phase !== "ready" || this.#asked) return;
    this.#asked = this.link.send({ type: "start" });
  }

  /** A key, stick or pad was moved: that starts the episode, and takes over from a policy. */
  touched() {
    if (!this.mine) return;
    if (this.by === "policy" && !this.trial) this.link.send({ type: "drive", by: "person" });
    this.start();
  }

  /** Who moved the claw in the newest frame. */
  claw(who) {
    const expired = who === "expired";
    if (expired === this.#expired) return;
    this.#expired = expired;
    this.#banner();
  }

  /** Called a few times a second. */
  look({ silent }) {
    if (silent !== this.silent) {
      this.silent = silent;
      this.#banner();
    }
  }

  #welcome({ you, mode, policy, form }) {
    Object.assign(this, { me: you, mode, policy: policy ?? null, form: form ?? mode === "drive", driver: null });
    this.#draw();
  }

  #roles({ driver, viewers, by }) {
    Object.assign(this, { driver, viewers, by });
    if (driver === null && this.#wants && this.mode !== "view" && !document.hidden) this.link.send({ type: "take" });
    this.#wants = false;
    this.input.driving = this.mine;
    if (by === "none" || (this.mine && by === "person")) this.input.reflect([0, 0]);
    this.#draw();
  }

  #phase({ phase, seconds }) {
    this.phase = phase;
    this.#asked = false;
    if (phase === "running" && this.mine) this.#first = false;
    if (phase !== "running") this.#expired = false;
    show(byId("countdown"), phase === "countdown");
    if (phase === "countdown") write(byId("countdown"), String(Math.max(1, Math.ceil(seconds))));
    this.#draw();
  }

  #refuse({ message, about }) {
    if (about === "configure" || about === "yaml" || about === "schema") return; // the form tells them
    this.#asked = false;
    this.#refused = message;
    setTimeout(() => {
      if (this.#refused === message) this.#refused = "";
      this.#banner();
    }, REFUSED_MS);
    this.#banner();
  }

  #down() {
    this.#wants = this.driver !== null && this.driver === this.me; // taken again after the link has come back
    this.driver = null;
    this.by = "none";
    this.input.driving = false;
    this.#draw();
  }

  #draw() {
    const { mine, phase, by } = this;
    Object.assign(document.body.dataset, { phase, mine: mine ? "yes" : "no", by });
    write(byId("phase"), this.link.up ? PHASES[phase] ?? phase : "no link");
    const [who, words] = this.#driverWords();
    byId("driver").dataset.who = who;
    write(byId("driver"), words);
    write(byId("viewers"), this.viewers ? `${this.viewers} watching` : "");
    const drives = mine && !this.trial && this.policy !== null && phase !== "done";
    show(byId("take"), !mine && this.mode !== "view");
    byId("take").disabled = !this.link.up || this.driver !== null;
    show(byId("release"), mine);
    show(byId("start"), mine && phase === "ready");
    show(byId("abort"), mine && (phase === "running" || phase === "countdown"));
    show(byId("again"), mine && !this.trial && phase === "over");
    show(byId("next"), mine && (phase === "over" || (phase === "ready" && !this.trial)));
    show(byId("hand-over"), drives && by !== "policy" && phase !== "over");
    show(byId("take-over"), drives && by === "policy" && phase !== "over");
    show(byId("open-form"), this.form);
    show(byId("go"), mine && phase === "ready");
    show(byId("first"), mine && phase === "ready" && by !== "policy" && this.#first);
    this.#banner();
    this.onchange?.();
  }

  #driverWords() {
    if (this.driver === null) return ["nobody", "nobody at the claw"];
    if (this.by === "policy") return ["policy", `${this.policy ?? "the agent"} drives${this.mine ? ", you watch over it" : ""}`];
    return this.mine ? ["you", "you hold the claw"] : ["other", "somebody else holds the claw"];
  }

  #banner() {
    const text = this.#warning();
    if (text) write(byId("banner"), text);
    show(byId("banner"), Boolean(text));
  }

  #warning() {
    if (this.me !== null && !this.link.up) return "The link to the simulator is lost: the claw stands still. Trying again\u2026";
    if (this.silent) return "The simulator is silent: this picture is old.";
    if (this.#refused) return this.#refused;
    if (this.mine && this.input.paused) return "This page is not in focus, so the claw stands still. Click here to go on.";
    if (this.mine && this.#expired) return "Your commands come too late: the claw stands still.";
    return "";
  }
}
