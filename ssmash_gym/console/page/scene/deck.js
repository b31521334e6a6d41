// The ship above and below the deck edge: plating, markings, hangar with its opening, superstructure, hull. S axes.
// Walls of the hangar show their inner sides only, so that it can be looked into from everywhere.
import * as THREE from "three";
import { boxBetween, colour, geometryOf, merged } from "./shapes.js";

const PLATING = colour(98, 106, 113);
const WALL = colour(150, 160, 168);
const HULL = colour(118, 130, 142);
const KEEL = colour(86, 44, 42);
const DARK = colour(44, 49, 55);
const LAMP = colour(255, 244, 214);

/** Small numbers that look like chance and are the same in every picture. */
export function shuffler(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 4294967296;
  };
}

/** A picture painted once on a canvas of w by h pixels. */
export function painted(w, h, paint, options = {}) {
  const canvas = document.createElement("canvas");
  canvas.width = w;
  canvas.height = h;
  paint(canvas.getContext("2d"), w, h);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.anisotropy = 8;
  return Object.assign(texture, options);
}

/** Non-skid plating: grain, seams, tie-down points and the stains of use; one pixel is 2.5 cm. */
function platingTexture(length, width) {
  const scale = 40;
  return painted(Math.round(length * scale), Math.round(width * scale), (g, w, h) => {
    const chance = shuffler(7);
    g.fillStyle = "#6b747b";
    g.fillRect(0, 0, w, h);
    for (let i = 0; i < 26000; i++) {
      const v = chance() < 0.5 ? 0 : 255;
      g.fillStyle = `rgba(${v},${v},${v},${0.02 + 0.05 * chance()})`;
      g.fillRect(chance() * w, chance() * h, 1 + 2 * chance(), 1 + 2 * chance());
    }
    for (let i = 0; i < 90; i++) {
      const x = chance() * w;
      const y = chance() * h;
      const r = 20 + 90 * chance();
      const stain = g.createRadialGradient(x, y, 0, x, y, r);
      stain.addColorStop(0, `rgba(40,44,48,${0.1 * chance()})`);
      stain.addColorStop(1, "rgba(40,44,48,0)");
      g.fillStyle = stain;
      g.fillRect(x - r, y - r, 2 * r, 2 * r);
    }
    g.strokeStyle = "rgba(30,34,38,0.35)";
    g.lineWidth = 1.5;
    for (let x = 0; x < w; x += 3.2 * scale) g.strokeRect(x, -9, 3.2 * scale, h + 18);
    for (let y = 0; y < h; y += 2.13 * scale) g.strokeRect(-9, y, w + 18, 2.13 * scale);
    for (let x = 0.8 * scale; x < w; x += 1.6 * scale) {
      for (let y = 0.53 * scale; y < h; y += 1.06 * scale) {
        g.fillStyle = "rgba(28,31,35,0.75)";
        g.beginPath();
        g.arc(x, y, 2.4, 0, 7);
        g.fill();
        g.strokeStyle = "rgba(190,196,200,0.35)";
        g.lineWidth = 0.8;
        g.stroke();
      }
    }
  });
}

/** A flat quadrilateral on the deck, z upwards of it in metres. */
function patch(x0, x1, y0, y1, above, material) {
  const mesh = new THREE.Mesh(new THREE.PlaneGeometry(x1 - x0, y1 - y0), material);
  mesh.rotation.x = Math.PI; // its face looks up: -z
  mesh.position.set((x0 + x1) / 2, (y0 + y1) / 2, -above);
  mesh.receiveShadow = true;
  return mesh;
}

export class Ship {
  constructor(setup) {
    this.group = new THREE.Group();
    this.m = setup.ship;
    this.end = this.m.door_x + this.m.hangar_length;
    this.painted = new THREE.MeshLambertMaterial({ vertexColors: true });
    this.glowing = new THREE.MeshBasicMaterial({ vertexColors: true });
    this.#deck(setup);
    this.#hangar();
    this.#face();
    this.#superstructure();
    this.#hull();
    this.#nets();
  }

  #add(geometry, material, { cast = false, receive = true } = {}) {
    const mesh = new THREE.Mesh(geometry, material);
    mesh.castShadow = cast;
    mesh.receiveShadow = receive;
    this.group.add(mesh);
    return mesh;
  }

  #deck(setup) {
    const { aft_x: aft, half_beam: half, door_x: door } = this.m;
    const length = this.end + 1 - aft;
    const top = new THREE.MeshLambertMaterial({ map: platingTexture(length, 2 * half) });
    this.group.add(patch(aft, this.end + 1, -half, half, 0, top));
    const white = new THREE.MeshLambertMaterial({ color: colour(226, 228, 224) });
    const rim = [
      [aft + 0.25, door - 0.1, -half + 0.25, -half + 0.4], [aft + 0.25, door - 0.1, half - 0.4, half - 0.25],
      [aft + 0.25, aft + 0.4, -half + 0.25, half - 0.25],
    ];
    for (const [x0, x1, y0, y1] of rim) this.group.add(patch(x0, x1, y0, y1, 0.006, white));
    const circle = new THREE.Mesh(new THREE.RingGeometry(3.0, 3.2, 96), white);
    circle.rotation.x = Math.PI;
    circle.position.set(setup.track ? setup.track.start_x_m : 0, 0, -0.005);
    circle.receiveShadow = true;
    this.group.add(circle);
    this.#paint(setup);
  }

  #paint(setup) {
    const mesh = setup.meshes.find((m) => m.name === "markings");
    if (!mesh || !setup.track) return;
    const geometry = geometryOf(mesh);
    const place = geometry.getAttribute("position");
    const normal = geometry.getAttribute("normal");
    for (let i = 0; i < place.count; i++) {
      place.setZ(i, -0.008 - 0.00012 * Math.floor(i / 6)); // later paint lies on earlier paint
      normal.setXYZ(i, 0, 0, -1);
    }
    const material = new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.DoubleSide });
    this.#add(geometry, material);
    const { start_x_m: start, goal_x_m: goal, corridor_m: wide } = setup.track;
    for (let x = Math.ceil(start); x <= goal; x += 2) this.#number(String(x), x, wide + 1.55);
  }

  #number(text, x, y) {
    const map = painted(64, 64, (g) => {
      g.fillStyle = "#e6e8e4";
      g.font = "bold 44px sans-serif";
      g.textAlign = "center";
      g.textBaseline = "middle";
      g.fillText(text, 32, 34);
    });
    const material = new THREE.MeshLambertMaterial({ map, transparent: true, depthWrite: false });
    const mesh = patch(x - 0.45, x + 0.45, y - 0.45, y + 0.45, 0.01, material);
    mesh.rotation.set(Math.PI, 0, -Math.PI / 2); // read from aft
    this.group.add(mesh);
  }

  /** Floor paint, three walls, roof with lamps, cut-away edges. */
  #hangar() {
    const { door_x: door, hangar_half_width: half, hangar_height: high } = this.m;
    const end = this.end;
    const inner = new THREE.MeshLambertMaterial({ color: WALL, side: THREE.FrontSide });
    const wall = (w, h, x, y, z, turn) => {
      const mesh = this.#add(new THREE.PlaneGeometry(w, h), inner, { cast: true });
      mesh.position.set(x, y, z);
      turn(mesh.rotation);
      mesh.material.shadowSide = THREE.DoubleSide;
    };
    const long = end - door;
    const middle = (door + end) / 2;
    wall(long, high, middle, -half, -high / 2, (r) => r.set(-Math.PI / 2, 0, 0)); // port: looks to starboard
    wall(long, high, middle, half, -high / 2, (r) => r.set(Math.PI / 2, 0, 0));
    wall(2 * half, high, end, 0, -high / 2, (r) => r.set(Math.PI / 2, -Math.PI / 2, 0)); // fore: looks aft
    wall(long, 2 * half, middle, 0, -high, (r) => r.set(0, 0, 0)); // roof: looks down
    const rib = colour(122, 132, 141);
    const ribs = [];
    for (let x = door + 1.6; x < end; x += 2.2) {
      ribs.push([boxBetween([x - 0.07, -half, -high], [x + 0.07, -half + 0.14, 0]), rib]);
    }
    for (let y = -half + 1.25; y < half; y += 1.25) {
      ribs.push([boxBetween([end - 0.12, y - 0.06, -high], [end, y + 0.06, 0]), rib]);
    }
    this.#add(merged(ribs), this.painted);
    const lamps = [];
    for (const y of [-2.2, 2.2]) {
      for (let x = door + 1.8; x < end - 1; x += 3) {
        lamps.push([boxBetween([x, y - 0.1, -high + 0.1], [x + 1.5, y + 0.1, -high + 0.18]), LAMP]);
      }
    }
    this.#add(merged(lamps), this.glowing, { receive: false });
    this.lamp = new THREE.PointLight(0xfff0d2, 55, 22, 1.6);
    this.lamp.position.set(door + 5, 0, -high + 0.7);
    this.group.add(this.lamp);
    const edges = new THREE.EdgesGeometry(boxBetween([door, -half, -high], [end, half, 0]));
    this.group.add(new THREE.LineSegments(edges, new THREE.LineBasicMaterial({ color: colour(60, 68, 76) })));
  }

  /** The after side of the hangar with its opening, striped door frame, shutter box, floodlights. */
  #face() {
    const { door_x: door, door_half_width: gap, door_height: high, hangar_half_width: half, hangar_height: top } = this.m;
    const face = colour(172, 182, 190);
    const x = [door, door + 0.2];
    const parts = [
      [boxBetween([x[0], -half - 0.1, -top - 0.15], [x[1], -gap - 0.2, 0]), face],
      [boxBetween([x[0], gap + 0.2, -top - 0.15], [x[1], half + 0.1, 0]), face],
      [boxBetween([x[0], -gap - 0.2, -top - 0.15], [x[1], gap + 0.2, -high - 0.2]), face],
    ];
    const lit = [[boxBetween([door - 0.1, -1.6, -top + 0.02], [door, 1.6, -top + 0.12]), colour(110, 220, 150)]];
    for (const side of [-1, 1]) {
      const y = side * (half - 1.1);
      parts.push([boxBetween([door - 0.02, y - 0.42, -2.05], [door + 0.02, y + 0.42, -0.15]), DARK]);
      lit.push([boxBetween([door - 0.16, y - 0.2, -5.45], [door, y + 0.2, -5.15]), LAMP]);
    }
    this.#add(merged(parts), this.painted, { cast: true });
    this.#add(merged(lit), this.glowing, { receive: false }); // floodlights, and the bar that pilots line up on
  }

  /** Striped frame of the door, from the setup's own mesh. */
  frame(mesh) {
    if (mesh) this.#add(geometryOf(mesh), this.painted, { cast: true });
  }

  #superstructure() {
    const { hangar_half_width: half, hangar_height: top } = this.m;
    const grey = colour(150, 160, 169);
    const deep = colour(58, 66, 76);
    const e = this.end;
    const boxes = [
      [[e + 0.05, -half, -top - 0.6], [e + 15, half, 0], grey], [[e + 3, -3.2, -top - 3.4], [e + 12, 3.2, -top - 0.6], grey],
      [[e + 15, -half - 0.6, -top - 1.6], [e + 34, half + 0.6, 0], grey],
      [[e + 20, -4.4, -top - 5], [e + 32, 4.4, -top - 1.6], grey],
      [[e + 19.9, -4.5, -top - 4.3], [e + 32.1, 4.5, -top - 3.3], deep],
      [[e + 24, -1.1, -top - 12], [e + 26, 1.1, -top - 5], grey], [[e + 24.7, -0.2, -top - 19], [e + 25.2, 0.2, -top - 12], deep],
      [[e + 24.6, -3.4, -top - 14.2], [e + 25.1, 3.4, -top - 13.9], deep], [[e + 1, -1.2, -top - 2.1], [e + 2.5, 1.2, -top - 0.6], grey],
      [[e + 4.5, -2.3, -top - 6.6], [e + 9.5, 2.3, -top - 3.4], grey], [[e + 4.4, -2.4, -top - 6.75], [e + 9.6, 2.4, -top - 6], deep],
      [[this.m.door_x, -half - 0.15, -top - 0.15], [e, -half, -top], grey],
      [[this.m.door_x, half, -top - 0.15], [e, half + 0.15, -top], grey],
    ];
    const parts = boxes.map(([low, high, tint]) => [boxBetween(low, high), tint]);
    parts.push([new THREE.SphereGeometry(1.5, 20, 14).translate(e + 13.4, 0, -top - 2.2), colour(196, 203, 209)]);
    this.#add(merged(parts), this.painted, { receive: false });
  }

  /** Sides from the deck's edge to below the water, drawn in to a bow. */
  #hull() {
    const { aft_x: aft, half_beam: half, above_sea: above } = this.m;
    const sections = [];
    for (let i = 0; i <= 16; i++) {
      const x = aft + (i / 16) * 118;
      const bow = Math.max(0, (x - aft - 62) / 56);
      const wide = half * (1 - bow ** 2.2);
      const rise = -2.6 * Math.max(0, bow) ** 1.6;
      sections.push([x, wide, rise]);
    }
    this.#strip(sections, (s) => [s[1], s[2]], (s) => [0.93 * s[1], above + 0.15], HULL);
    this.#strip(sections, (s) => [0.93 * s[1] + 0.01, above - 0.3], (s) => [0.8 * s[1], above + 6], KEEL);
    const grey = new THREE.MeshLambertMaterial({ color: HULL, side: THREE.DoubleSide });
    const shape = new THREE.Shape();
    shape.moveTo(-half, 0).lineTo(half, 0).lineTo(0.93 * half, above + 3).lineTo(-0.93 * half, above + 3);
    const stern = this.#add(new THREE.ShapeGeometry(shape), grey);
    stern.rotation.set(Math.PI / 2, Math.PI / 2, 0);
    stern.position.x = aft;
    const fore = sections.filter((s) => s[0] > this.end);
    this.#strip([[this.end + 1, half, 0], ...fore], (s) => [s[1], s[2]], (s) => [0, s[2]], PLATING, 0.02);
  }

  #strip(sections, upper, lower, tint, sink = 0) {
    const points = [];
    for (const side of [-1, 1]) {
      for (let i = 0; i + 1 < sections.length; i++) {
        const [a, b] = [sections[i], sections[i + 1]];
        const corner = (s, f) => [s[0], side * f(s)[0], f(s)[1] + sink];
        const quad = [corner(a, upper), corner(b, upper), corner(b, lower), corner(a, lower)];
        for (const j of side > 0 ? [0, 1, 2, 0, 2, 3] : [0, 2, 1, 0, 3, 2]) points.push(...quad[j]);
      }
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
    geometry.computeVertexNormals();
    this.#add(geometry, new THREE.MeshLambertMaterial({ color: tint, side: THREE.DoubleSide }));
  }

  /** Safety nets beside and behind the deck. */
  #nets() {
    const { aft_x: aft, half_beam: half, door_x: door } = this.m;
    const points = [];
    const net = (p, q, out, bays) => {
      const at = (s, r) => [p[0] + s * (q[0] - p[0]) + r * out[0], p[1] + s * (q[1] - p[1]) + r * out[1], 0.1 - 0.25 * r];
      for (let i = 0; i <= bays; i++) points.push(...at(i / bays, 0), ...at(i / bays, 1));
      for (const r of [0, 0.5, 1]) points.push(...at(0, r), ...at(1, r));
    };
    net([aft, -half], [door, -half], [0, -1.2], 40);
    net([aft, half], [door, half], [0, 1.2], 40);
    net([aft, -half], [aft, half], [-1.2, 0], 20);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
    this.group.add(new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour(52, 58, 66) })));
  }
}
