/**
 * The three-dimensional picture and its cameras. Without WebGL, or with ?quality=off in the address, gauges and traces go
 * on by themselves; ?quality=0 (best) to 4 keeps one quality instead of the one that the computer can follow.
 */
const asked = new URLSearchParams(location.search).get("quality");
const options = /^[0-4]$/.test(asked ?? "") ? { quality: Number(asked) } : {};

export class View {
  #stage = null;
  #setup = null;
  #frame = null;
  #camera = "follow"; // forward is away from the eye, as it is up on keys and stick

  constructor(canvas, buttons) {
    this.canvas = canvas;
    this.buttons = [...buttons.querySelectorAll("button")];
    for (const button of this.buttons) button.addEventListener("click", () => this.camera(button.dataset.camera));
    addEventListener("keydown", (event) => {
      const chosen = this.buttons[["Digit1", "Digit2", "Digit3", "Digit4"].indexOf(event.code)];
      const typing = event.target instanceof Element && event.target.closest("input, select, textarea");
      if (chosen && !typing && !event.ctrlKey && !event.metaKey && !event.altKey) this.camera(chosen.dataset.camera);
    });
    if (asked === "off") return;
    import("./scene/stage.js").then(({ Stage }) => this.#begin(new Stage(canvas, options)), (error) => console.error(error));
  }

  #begin(stage) {
    this.#stage = stage;
    stage.camera(this.#camera);
    if (this.#setup) stage.setup(this.#setup);
    if (this.#frame) stage.push(this.#frame);
  }

  setup(setup) {
    this.#setup = setup;
    this.#frame = null;
    this.#stage?.setup(setup);
  }

  push(frame) {
    this.#frame = frame;
    this.#stage?.push(frame);
  }

  camera(name) {
    this.#camera = name;
    this.#stage?.camera(name);
    for (const button of this.buttons) button.setAttribute("aria-pressed", String(button.dataset.camera === name));
  }

  get framesPerSecond() {
    return this.#stage?.frames_per_second ?? 0;
  }

  /** Newest step that has been drawn; what the gauges show where there is no picture. */
  get shownStep() {
    const step = asked === "off" || this.#stage?.works === false ? this.#frame?.k : this.#stage?.last_drawn_step;
    return step ?? -1;
  }
}
