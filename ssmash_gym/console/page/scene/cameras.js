// Where the picture is seen from: the operator's station and the view from above are carried by the ship, so that the
// horizon moves; the following and the free one are level, so that the ship moves.
import * as THREE from "three";
import { OrbitControls } from "../vendor/three/OrbitControls.js";

export const VIEWS = {
  station: "Operator's station",
  top: "From above",
  follow: "Follow",
  free: "Free (drag, wheel)",
};
const FIELD = { station: 60, top: 38, follow: 40, free: 44 }; // degrees, vertical, of a picture 1.6 times as wide as high
const GLIDE_S = 0.7; // from one view to the next

export class Cameras {
  constructor(canvas, changed) {
    this.camera = new THREE.PerspectiveCamera(45, 1.6, 0.3, 7000);
    this.name = "follow";
    this.orbit = new OrbitControls(this.camera, canvas);
    Object.assign(this.orbit, { enabled: false, minDistance: 2.5, maxDistance: 160, maxPolarAngle: 1.68 });
    this.orbit.addEventListener("change", changed);
    this.eye = new THREE.Vector3(-14, 7, 12);
    this.target = new THREE.Vector3(1, 1.5, 0);
    this.up = new THREE.Vector3(0, 1, 0);
    this.wanted = { eye: new THREE.Vector3(), target: new THREE.Vector3(), up: new THREE.Vector3() };
    this.from = { eye: new THREE.Vector3(), target: new THREE.Vector3(), up: new THREE.Vector3(), field: 45 };
    this.since = Infinity;
    this.smooth = null;
    this.aspect = 1.6;
  }

  setup(setup) {
    this.ship = setup.ship;
    this.smooth = null;
  }

  /** Take a view; it glides there. */
  choose(name) {
    if (!(name in VIEWS)) throw new Error(`there is no view ${name}; there are ${Object.keys(VIEWS).join(", ")}`);
    if (name === this.name) return;
    const keep = this.since < GLIDE_S || this.name === "free";
    for (const part of ["eye", "target", "up"]) {
      this.from[part].copy(keep ? this.#present(part) : this.wanted[part]);
    }
    this.from.field = this.camera.fov;
    this.name = name;
    this.since = 0;
    this.orbit.enabled = name === "free";
    if (name === "free") {
      this.orbit.target.copy(this.target);
      this.camera.up.set(0, 1, 0);
      this.since = Infinity;
    }
  }

  #present(part) {
    if (this.name !== "free") return this[part];
    return { eye: this.camera.position, target: this.orbit.target, up: this.camera.up }[part];
  }

  resize(width, height) {
    this.aspect = width / height;
    this.camera.aspect = this.aspect;
    this.camera.updateProjectionMatrix();
  }

  /** Field of view that keeps the width of a picture 1.6 times as wide as high. */
  #field(name) {
    const half = Math.tan((FIELD[name] * Math.PI) / 360);
    const wide = name === "top" ? 1 : Math.min(1.7, Math.max(1, 1.6 / this.aspect));
    return (360 / Math.PI) * Math.atan(half * wide);
  }

  /** @returns whether the camera still glides. */
  update(pose, ship, elapsed) {
    if (this.name === "free") {
      this.#lens(this.#field("free"));
      this.target.copy(this.orbit.target);
      return false;
    }
    this.#aim(pose, ship, elapsed);
    this.since += elapsed;
    const s = Math.min(1, this.since / GLIDE_S);
    const soft = s * s * (3 - 2 * s);
    for (const part of ["eye", "target", "up"]) this[part].lerpVectors(this.from[part], this.wanted[part], s < 1 ? soft : 1);
    this.#lens(s < 1 ? this.from.field + soft * (this.#field(this.name) - this.from.field) : this.#field(this.name));
    this.camera.position.copy(this.eye);
    this.camera.up.copy(this.up).normalize();
    this.camera.lookAt(this.target);
    return s < 1;
  }

  #lens(field) {
    if (Math.abs(this.camera.fov - field) < 1e-3) return;
    this.camera.fov = field;
    this.camera.updateProjectionMatrix();
  }

  #aim(pose, ship, elapsed) {
    const { eye, target, up } = this.wanted;
    const x = pose.claw[0];
    const share = this.smooth === null || Math.abs(x - this.smooth) > 3 ? 1 : 1 - Math.exp(-elapsed / 0.6);
    this.smooth = (this.smooth ?? 0) + share * (x - (this.smooth ?? 0));
    const door = this.ship.door_x;
    up.set(0, 1, 0);
    if (this.name === "station") {
      // A stand at the port edge of the deck before the hangar, above the deck: claw, probe and wheels are in sight.
      eye.set(door - 1.1, -9.6, -4.9);
      target.set(Math.min(this.smooth + 0.1, door - 3.2), 0, -1.2);
      up.set(0, 0, -1);
    } else if (this.name === "top") {
      eye.set(this.smooth - 0.4, 0, -31);
      target.set(this.smooth - 0.4, 0, 0);
      up.set(1, 0, 0);
    } else {
      eye.set(this.smooth - 15.2, 12.2, -6.6);
      target.set(this.smooth + 0.4, 0, -1.7);
      // Level: the deck point is taken as if the ship stood still.
      this.#level(eye);
      this.#level(target);
      return;
    }
    ship.localToWorld(eye);
    ship.localToWorld(target);
    up.transformDirection(ship.matrixWorld);
  }

  /** S to the picture's axes for a ship at its mean place. */
  #level(v) {
    v.set(v.x, -v.z, v.y);
  }
}
