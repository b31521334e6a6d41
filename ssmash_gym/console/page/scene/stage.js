// The picture: ship, helicopter, sea and sky on one canvas.
//
//   const stage = new Stage(canvas);
//   stage.setup(setup); stage.push(frame);            // live
//   stage.setup(run.setup); stage.show(run, time_s);  // replay
//   stage.addGhost(setup).show(run, time_s);          // another helicopter, translucent, on the same deck
//   stage.camera("follow");
//
// Data are in the axes of ssmash_gym/console/scene.py (z down); this module turns them to those of the picture
// (x, -z, y) in one place: the root of the scene.
import * as THREE from "three";
import { Cameras, VIEWS } from "./cameras.js";
import { Ship } from "./deck.js";
import { Helicopter } from "./helicopter.js";
import { blankPose, poseAt, Timeline } from "./interpolate.js";
import { Sea, SUN } from "./sea.js";
import { dispose, place } from "./shapes.js";

export { VIEWS };
export const NO_WEBGL =
  "This browser shows no 3-D picture: WebGL is missing or switched off; turn on hardware acceleration in its settings, or use another browser.";
export const GHOSTS = ["#4da3ff", "#ffb02e", "#c58cff", "#4fd18b"];
const QUALITY = [
  { ratio: 2, shadows: 2048 }, { ratio: 1.25, shadows: 1024 }, { ratio: 1, shadows: 1024 },
  { ratio: 0.8, shadows: 0 }, { ratio: 0.6, shadows: 0 },
  { ratio: 0.45, shadows: 0 },
];
const SOFTWARE_LEVEL = 3;
const SLOW_MS = 30; // a picture that takes longer, on the average, lowers the quality
const LEAST_PICTURES = 12; // between two changes of the quality

/** Whether the browser draws without a graphics card: then everything dear is left out from the beginning. */
function drawsInSoftware() {
  const probe = document.createElement("canvas").getContext("webgl2", { powerPreference: "high-performance" });
  if (!probe) return false;
  const named = probe.getExtension("WEBGL_debug_renderer_info");
  const name = String(probe.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : probe.RENDERER));
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

export class Stage {
  /**
   * @param canvas What it draws on; it follows the size that the page gives it.
   * @param options quality: 0 (best) to 5, or null to find it by the pictures' pace.
   */
  constructor(canvas, { quality = null } = {}) {
    this.canvas = canvas;
    this.frames_per_second = 0;
    this.last_drawn_step = -1;
    this.works = false;
    this.ghosts = [];
    this.timeline = new Timeline();
    this.live = false;
    try {
      this.slow = quality === null ? drawsInSoftware() : quality >= SOFTWARE_LEVEL;
      this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !this.slow, powerPreference: "high-performance" });
    } catch {
      this.#sayWhy();
      return;
    }
    this.works = true;
    this.fixed = quality;
    this.level = quality ?? (this.slow ? SOFTWARE_LEVEL : 0);
    this.#scene();
    this.cameras = new Cameras(canvas, () => (this.dirty = true));
    this.pose = blankPose();
    this.clock = { last: 0, pictures: 0, busy: 0, since: 0, counted: 0 };
    this.apply();
    this.observer = new ResizeObserver(() => this.#resize());
    this.observer.observe(canvas.parentElement ?? canvas);
    this.seen = () => document.hidden || this.#wake();
    document.addEventListener("visibilitychange", this.seen);
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault()); // so that it may come back
    canvas.addEventListener("webglcontextrestored", () => {
      this.dirty = true;
      this.#wake();
    });
    this.tick = (now) => this.#tick(now);
    this.#resize();
    this.#wake();
  }

  #sayWhy() {
    const note = document.createElement("p");
    note.className = "stage-note";
    note.setAttribute("role", "status");
    note.textContent = NO_WEBGL;
    this.canvas.hidden = true;
    this.canvas.after(note);
  }

  #scene() {
    this.scene = new THREE.Scene();
    this.root = new THREE.Group(); // axes N
    this.root.rotation.x = Math.PI / 2; // (x, y, z) becomes (x, -z, y)
    this.scene.add(this.root);
    this.deck = new THREE.Group(); // axes S
    this.root.add(this.deck);
    this.sea = new Sea();
    this.scene.add(this.sea.surface, this.sea.dome);
    this.scene.add(new THREE.HemisphereLight(0xd6e6f5, 0x5f6a70, 1.75));
    this.sun = new THREE.DirectionalLight(0xfff1dc, 2.6);
    const shadow = this.sun.shadow;
    Object.assign(shadow.camera, { left: -17, right: 17, top: 15, bottom: -15, near: 5, far: 90 });
    shadow.bias = -0.0006;
    shadow.normalBias = 0.03;
    this.root.add(this.sun, this.sun.target);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
  }

  /** Take the ship, track and helicopter of a setup; what was shown before goes. */
  setup(setup) {
    this.last_drawn_step = -1;
    this.timeline.clear();
    this.live = false;
    if (!this.works) return;
    if (this.ship) dispose(this.ship.group);
    if (this.helicopter) dispose(this.helicopter.group);
    for (const ghost of this.ghosts) dispose(ghost.helicopter.group);
    this.ghosts = [];
    this.ship = new Ship(setup);
    this.ship.frame(setup.meshes.find((mesh) => mesh.name === "door"));
    if (this.slow) this.#plainTextures();
    this.ship.lamp.visible = QUALITY[this.level].shadows > 0;
    this.helicopter = new Helicopter(setup);
    this.helicopter.seeThrough = this.cameras.name === "top";
    this.deck.add(this.ship.group, this.helicopter.group);
    this.helicopter.group.visible = false;
    this.pose = blankPose(setup.tires.length);
    this.sea.setup(setup);
    this.cameras.setup(setup);
    this.dirty = true;
    this.#wake();
  }

  /** Textures without anisotropic filtering, which is the dearest part of a picture drawn in software. */
  #plainTextures() {
    this.sea.uniforms.ripples.value.anisotropy = 1;
    this.scene.traverse((part) => part.material?.map && (part.material.map.anisotropy = 1));
    this.ship.group.traverse((part) => part.material?.map && (part.material.map.anisotropy = 1));
  }

  /** Another helicopter beside the first, translucent; `show(run, time_s)` of what is returned moves it. */
  addGhost(setup, tint = GHOSTS[this.ghosts.length % GHOSTS.length]) {
    if (!this.works) return { show() {}, tint };
    const helicopter = new Helicopter(setup, new THREE.Color(tint));
    const pose = blankPose(setup.tires.length);
    this.deck.add(helicopter.group);
    const ghost = {
      helicopter,
      tint,
      show: (run, time) => {
        poseAt(run.frames, time, pose);
        helicopter.update(pose);
        this.dirty = true;
      },
    };
    this.ghosts.push(ghost);
    return ghost;
  }

  /** A frame as it arrives; the picture follows one interval later. */
  push(frame) {
    this.live = true;
    this.timeline.push(frame, performance.now() / 1000);
    this.#wake();
  }

  /** The pose of a recorded run at a time. */
  show(run, time) {
    this.live = false;
    if (!this.works) return;
    poseAt(run.frames, time, this.pose);
    this.#move();
    this.#wake();
  }

  /** Take the view "station", "top", "follow" or "free". */
  camera(name) {
    if (!this.works) return;
    this.cameras.choose(name);
    if (this.helicopter) this.helicopter.seeThrough = name === "top";
    this.dirty = true;
    this.#wake();
  }

  /** Stop drawing and free the graphics card. */
  dispose() {
    if (!this.works) return;
    this.works = false;
    document.removeEventListener("visibilitychange", this.seen);
    this.observer.disconnect();
    this.cameras.orbit.dispose();
    dispose(this.scene);
    this.renderer.dispose();
  }

  /** Bring resolution and shadows to the present level of quality. */
  apply() {
    const { ratio, shadows } = QUALITY[this.level];
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, ratio));
    this.sun.castShadow = shadows > 0;
    if (this.ship) this.ship.lamp.visible = shadows > 0;
    if (shadows && this.sun.shadow.mapSize.x !== shadows) {
      this.sun.shadow.mapSize.set(shadows, shadows);
      this.sun.shadow.map?.dispose();
      this.sun.shadow.map = null;
    }
    this.dirty = true;
  }

  #resize() {
    const box = (this.canvas.parentElement ?? this.canvas).getBoundingClientRect();
    if (box.width < 2 || box.height < 2) return;
    this.renderer.setSize(box.width, box.height, false);
    this.cameras.resize(box.width, box.height);
    this.dirty = true;
    this.#wake();
  }

  #wake() {
    if (!this.works || this.waiting || document.hidden) return;
    this.waiting = requestAnimationFrame(this.tick);
  }

  /** Put everything where the pose says. */
  #move() {
    const pose = this.pose;
    place(this.deck, pose.ship);
    this.helicopter.group.visible = true;
    this.helicopter.update(pose);
    this.last_drawn_step = pose.k;
    this.dirty = true;
  }

  #tick(now) {
    this.waiting = 0;
    if (!this.works || !this.ship || document.hidden) return;
    const elapsed = Math.min(0.1, Math.max(0, (now - this.clock.last) / 1000));
    if (this.live && this.timeline.pose(performance.now() / 1000, this.pose)) this.#move();
    if (this.dirty) {
      this.dirty = false;
      this.#draw(elapsed);
      this.#count(now);
      this.#wake();
    } else {
      this.clock.pictures = 0; // a standing picture says nothing of the pace
      if (this.live) this.#wake();
    }
    this.clock.last = now;
  }

  #draw(elapsed) {
    const pose = this.pose;
    this.root.updateMatrixWorld();
    if (this.cameras.update(pose, this.deck, elapsed)) this.dirty = true;
    this.sea.update(pose.t, this.cameras.camera.position);
    this.sun.target.position.set(pose.claw[0] + 0.8, 0, 0);
    this.sun.position.copy(SUN).multiplyScalar(45).add(this.sun.target.position);
    this.renderer.render(this.scene, this.cameras.camera);
  }

  /** Pictures a second, and the quality that they allow. */
  #count(now) {
    const clock = this.clock;
    if (clock.pictures === 0) clock.since = now;
    else if (now > clock.since) this.frames_per_second = (1000 * clock.pictures) / (now - clock.since);
    clock.pictures += 1;
    if (clock.pictures < LEAST_PICTURES) return;
    const pace = (now - clock.since) / (clock.pictures - 1);
    clock.pictures = 0;
    if (this.fixed === null && pace > SLOW_MS && this.level < QUALITY.length - 1) {
      this.level = Math.min(QUALITY.length - 1, this.level + (pace > 4 * SLOW_MS ? 2 : 1));
      this.apply();
      this.#resize();
    }
  }
}
