// One helicopter with its landing gear, the claw that holds it, the probe and the probe's force. S axes.
import * as THREE from "three";
import { colour, geometryOf, merged, place, stretch } from "./shapes.js";

const GOOD = colour(60, 200, 112);
const SOFT = colour(250, 184, 40);
const BAD = colour(240, 60, 50);
const LIFTED = colour(96, 170, 255);
const HELD = colour(236, 240, 244);
const FREE = colour(96, 170, 255);
const METRES_PER_KN = 0.22; // length of the force arrow
const LONGEST_ARROW = 6;

/** Green below half the limit, amber at four fifths of it, red from the limit on; blue while lifted. */
export function loadColour(load, limits, target) {
  if (load < limits.lift_off_kN) return target.copy(LIFTED);
  const share = load / limits.station_kN;
  if (share < 0.8) return target.lerpColors(GOOD, SOFT, Math.min(1, Math.max(0, (share - 0.5) / 0.3)));
  return target.lerpColors(SOFT, BAD, Math.min(1, (share - 0.8) / 0.2));
}

/** Colour of an in-plane probe load [kN] by the task's soft limit and limit. */
export function probeColour(load, limits, target) {
  return target.copy(load < limits.probe_soft_kN ? GOOD : load < limits.probe_kN ? SOFT : BAD);
}

export class Helicopter {
  /**
   * @param setup What does not move.
   * @param ghost Tint (a THREE.Color) of a translucent one beside the first; none: the solid one.
   */
  constructor(setup, ghost = null) {
    this.limits = setup.limits;
    this.stations = setup.tires.map((tire) => tire.station);
    this.radii = setup.tires.map((tire) => tire.diameter_m / 2);
    this.ghost = ghost;
    this.group = new THREE.Group();
    this.before = null; // tire centres of the picture before, for the rolling
    this.rolled = new Float64Array(setup.tires.length);
    this.loads = new Float64Array(3);
    this.tint = new THREE.Color();
    this.basis = new THREE.Matrix4();
    this.x = new THREE.Vector3();
    this.y = new THREE.Vector3();
    this.z = new THREE.Vector3();
    this.materials = [];
    this.#build(setup);
  }

  #material(options, glossy = false) {
    const Kind = glossy ? THREE.MeshPhongMaterial : THREE.MeshLambertMaterial;
    const material = new Kind({ side: THREE.DoubleSide, ...options });
    if (this.ghost) {
      material.transparent = true;
      material.opacity = 0.3;
      material.side = THREE.FrontSide;
      if (!options.vertexColors) material.color.lerp(this.ghost, 0.75);
      else material.color.copy(this.ghost);
      material.emissive.copy(this.ghost).multiplyScalar(0.25);
    }
    this.materials.push(material);
    return material;
  }

  #mesh(geometry, material, parent = this.group) {
    const mesh = new THREE.Mesh(geometry, material);
    mesh.castShadow = !this.ghost;
    mesh.receiveShadow = !this.ghost;
    parent.add(mesh);
    return mesh;
  }

  #build(setup) {
    const meshes = Object.fromEntries(setup.meshes.map((mesh) => [mesh.name, mesh]));
    const paint = { vertexColors: true, shininess: 38, specular: colour(70, 76, 84) };
    this.skin = this.#material(paint, true);
    this.body = this.#mesh(geometryOf(meshes.body), this.skin);
    this.claw = this.#mesh(geometryOf(meshes.claw), this.#material({ vertexColors: true }));
    const steel = this.#material({ color: colour(214, 220, 226), shininess: 90, specular: colour(160, 160, 160) }, true);
    const paintwork = this.#material({ color: colour(150, 160, 170) });
    const rod = (radius, material) => this.#mesh(new THREE.CylinderGeometry(radius, radius, 1, 14), material);
    this.cylinders = [0, 1, 2].map((i) => rod(i === 0 ? 0.095 : 0.12, paintwork));
    this.pistons = [0, 1, 2].map((i) => rod(i === 0 ? 0.06 : 0.075, steel));
    this.axles = [0, 1, 2].map(() => rod(0.055, paintwork));
    this.probe = rod(0.055, steel);
    this.tip = this.#mesh(new THREE.SphereGeometry(0.1, 16, 12), this.#material({ color: HELD }));
    this.wheels = setup.tires.map((tire) => this.#wheel(tire));
    this.discs = [0, 1, 2].map(() => this.#disc());
    this.#arrow();
  }

  #wheel(tire) {
    const R = tire.diameter_m / 2;
    const w = tire.width_m;
    const wheel = new THREE.Group();
    const profile = [
      [0.54, -0.36], [0.62, -0.44], [0.8, -0.5], [0.93, -0.42], [0.985, -0.26], [1, -0.08],
      [1, 0.08], [0.985, 0.26], [0.93, 0.42], [0.8, 0.5], [0.62, 0.44], [0.54, 0.36],
    ].map(([r, y]) => new THREE.Vector2(r * R, y * w));
    const dark = colour(60, 66, 74);
    const parts = [
      [new THREE.LatheGeometry(profile, 28), colour(34, 36, 40)],
      [new THREE.CylinderGeometry(0.55 * R, 0.55 * R, 0.66 * w, 20), colour(186, 192, 198)],
    ];
    for (let i = 0; i < 5; i++) {
      const hole = new THREE.CylinderGeometry(0.11 * R, 0.11 * R, 0.69 * w, 8);
      parts.push([hole.translate(0.34 * R * Math.cos(1.2566 * i), 0, 0.34 * R * Math.sin(1.2566 * i)), dark]);
    }
    this.#mesh(merged(parts), this.#material({ vertexColors: true }), wheel);
    const band = new THREE.MeshBasicMaterial({ color: GOOD, side: THREE.DoubleSide });
    if (this.ghost) Object.assign(band, { transparent: true, opacity: 0.35 });
    const ring = (side) =>
      new THREE.RingGeometry(0.6 * R, 0.76 * R, 28).rotateX(Math.PI / 2).translate(0, side * (0.5 * w + 0.004), 0);
    wheel.add(new THREE.Mesh(merged([[ring(-1), dark], [ring(1), dark]]), band));
    this.group.add(wheel);
    return { wheel, band };
  }

  /** A ring on the deck under a station; it grows with the load and takes its colour. */
  #disc() {
    const material = new THREE.MeshBasicMaterial({
      color: GOOD, transparent: true, opacity: this.ghost ? 0.25 : 0.75, side: THREE.DoubleSide, depthWrite: false,
    });
    const disc = new THREE.Mesh(new THREE.RingGeometry(0.86, 1, 48), material);
    disc.position.z = -0.03;
    this.group.add(disc);
    return disc;
  }

  /** The probe's in-plane force; drawn over everything, so that the helicopter never hides it. */
  #arrow() {
    const paint = { transparent: true, opacity: this.ghost ? 0.5 : 0.95, depthTest: false };
    const outline = new THREE.MeshBasicMaterial({ ...paint, color: 0x0b1016, opacity: this.ghost ? 0.2 : 0.6 });
    this.forcePaint = new THREE.MeshBasicMaterial(paint);
    this.arrow = new THREE.Group();
    const part = (geometry, material, order) => {
      const mesh = new THREE.Mesh(geometry, material);
      mesh.renderOrder = order;
      this.arrow.add(mesh);
      return mesh;
    };
    const cylinder = (r) => new THREE.CylinderGeometry(r, r, 1, 12).translate(0, 0.5, 0);
    const cone = (r, h) => new THREE.ConeGeometry(r, h, 20).translate(0, h / 2, 0);
    this.shafts = [part(cylinder(0.1), outline, 20), part(cylinder(0.07), this.forcePaint, 22)];
    this.heads = [part(cone(0.27, 0.6), outline, 21), part(cone(0.21, 0.5), this.forcePaint, 23)];
    this.group.add(this.arrow);
  }

  /** Show the body as a shell, so that claw, probe and wheels are seen through it from above. */
  set seeThrough(wanted) {
    if (this.ghost || this.skin.transparent === wanted) return;
    this.skin.transparent = wanted;
    this.skin.opacity = wanted ? 0.42 : 1;
    this.skin.depthWrite = !wanted;
    this.skin.side = wanted ? THREE.FrontSide : THREE.DoubleSide;
    this.skin.needsUpdate = true;
  }

  update(pose) {
    place(this.body, pose.body);
    this.claw.position.set(pose.claw[0], pose.claw[1], 0);
    stretch(this.probe, pose.probe, 0, pose.probe, 3);
    this.tip.position.set(pose.probe[3], pose.probe[4], pose.probe[5]);
    this.#struts(pose);
    this.#wheels(pose);
    this.#force(pose);
  }

  #struts(pose) {
    const s = pose.struts;
    const inner = (this.inner ??= new Float64Array(6));
    for (let i = 0; i < 3; i++) {
      const o = 6 * i;
      // The cylinder keeps its length, the piston slides in it.
      const length = Math.hypot(s[o + 3] - s[o], s[o + 4] - s[o + 1], s[o + 5] - s[o + 2]);
      this.bores ??= [0, 0, 0];
      this.bores[i] ||= 0.6 * length;
      const bore = Math.min(0.95, this.bores[i] / Math.max(length, 1e-6));
      for (let j = 0; j < 3; j++) {
        inner[j] = s[o + j] + bore * (s[o + 3 + j] - s[o + j]);
        inner[3 + j] = s[o + j] + 0.35 * (s[o + 3 + j] - s[o + j]);
      }
      stretch(this.cylinders[i], s, o, inner, 0);
      stretch(this.pistons[i], inner, 3, s, o + 3);
    }
  }

  #wheels(pose) {
    const t = pose.tires;
    const first = this.before === null;
    this.before ??= new Float64Array(t.length);
    this.loads.fill(0);
    for (let i = 0; i < this.wheels.length; i++) {
      const o = 7 * i;
      const { wheel, band } = this.wheels[i];
      this.y.set(t[o + 3], t[o + 4], t[o + 5]).normalize();
      this.z.set(0, 0, 1).addScaledVector(this.y, -this.y.z).normalize();
      this.x.crossVectors(this.y, this.z);
      if (!first) {
        const way = (t[o] - this.before[o]) * this.x.x + (t[o + 1] - this.before[o + 1]) * this.x.y;
        this.rolled[i] -= way / this.radii[i];
      }
      wheel.quaternion.setFromRotationMatrix(this.basis.makeBasis(this.x, this.y, this.z));
      wheel.rotateY(this.rolled[i]);
      wheel.position.set(t[o], t[o + 1], t[o + 2]);
      this.loads[this.stations[i]] += t[o + 6];
    }
    this.before.set(t);
    for (let i = 0; i < 3; i++) {
      loadColour(this.loads[i], this.limits, this.tint);
      this.#station(i, t);
      this.discs[i].material.color.copy(this.tint);
      this.wheels.forEach(({ band }, k) => this.stations[k] === i && band.color.copy(this.tint));
    }
  }

  /** The axle of a station and the ring under it. */
  #station(i, t) {
    const first = this.stations.indexOf(i);
    const last = this.stations.lastIndexOf(i);
    if (first < 0) return;
    const lone = first === last;
    stretch(this.axles[i], t, 7 * first, t, 7 * last);
    this.axles[i].visible = !lone;
    const size = 0.35 + 0.65 * Math.sqrt(Math.max(0, this.loads[i]) / this.limits.station_kN);
    this.discs[i].position.x = (t[7 * first] + t[7 * last]) / 2;
    this.discs[i].position.y = (t[7 * first + 1] + t[7 * last + 1]) / 2;
    this.discs[i].scale.setScalar(size);
  }

  #force(pose) {
    const [x, y, z] = pose.force;
    const load = Math.hypot(x, y, z);
    this.arrow.visible = pose.captured && load > 0.15;
    this.tip.material.color.copy(pose.captured ? HELD : FREE);
    if (!this.arrow.visible) return;
    probeColour(load, this.limits, this.forcePaint.color);
    const size = Math.min(1, 0.3 + 0.35 * load); // small loads have a small arrow, not only a head
    this.arrow.scale.set(size, 1, size);
    const length = Math.min(LONGEST_ARROW, METRES_PER_KN * load + 0.45 * size);
    this.arrow.position.set(pose.probe[3], pose.probe[4], pose.probe[5] - 0.34);
    this.arrow.quaternion.setFromUnitVectors(this.y.set(0, 1, 0), this.x.set(x, y, z).divideScalar(load));
    for (const shaft of this.shafts) shaft.scale.y = Math.max(0.01, length - 0.45 * size);
    for (const head of this.heads) head.scale.y = size;
    this.heads[0].position.y = length - 0.55 * size;
    this.heads[1].position.y = length - 0.5 * size;
  }
}
