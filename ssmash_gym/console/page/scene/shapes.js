// Geometry shared by the modules of the scene. Axes as in the data: z down; only the scene's root turns them.
import * as THREE from "three";

const SMOOTH_COSINE = Math.cos((42 * Math.PI) / 180); // edges less sharp than this are shaded as round

/** Linear colour of 0-255 sRGB numbers. */
export function colour(r, g, b) {
  return new THREE.Color().setRGB(r / 255, g / 255, b / 255, THREE.SRGBColorSpace);
}

/** Geometry of a mesh of the setup: colours of its triangles, normals rounded over blunt edges. */
export function geometryOf(mesh) {
  const { positions, indices, colours } = mesh;
  const count = indices.length / 3;
  const points = new Float32Array(9 * count);
  const tints = new Float32Array(9 * count);
  const flat = [];
  const around = new Map();
  const a = new THREE.Vector3();
  const b = new THREE.Vector3();
  for (let f = 0; f < count; f++) {
    const tint = colour(colours[3 * f], colours[3 * f + 1], colours[3 * f + 2]);
    for (let c = 0; c < 3; c++) {
      const v = 3 * indices[3 * f + c];
      for (let j = 0; j < 3; j++) points[9 * f + 3 * c + j] = positions[v + j];
      tint.toArray(tints, 9 * f + 3 * c);
      const key = `${positions[v]},${positions[v + 1]},${positions[v + 2]}`;
      if (!around.has(key)) around.set(key, []);
      around.get(key).push(f);
    }
    const p = 9 * f;
    a.set(points[p + 3] - points[p], points[p + 4] - points[p + 1], points[p + 5] - points[p + 2]);
    b.set(points[p + 6] - points[p], points[p + 7] - points[p + 1], points[p + 8] - points[p + 2]);
    flat.push(a.clone().cross(b)); // twice the area long
  }
  const unit = flat.map((n) => n.clone().normalize());
  const normals = new Float32Array(9 * count);
  for (let f = 0; f < count; f++) {
    for (let c = 0; c < 3; c++) {
      const v = 3 * indices[3 * f + c];
      a.set(0, 0, 0);
      for (const g of around.get(`${positions[v]},${positions[v + 1]},${positions[v + 2]}`)) {
        if (unit[f].dot(unit[g]) > SMOOTH_COSINE) a.add(flat[g]);
      }
      a.normalize().toArray(normals, 9 * f + 3 * c);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(normals, 3));
  geometry.setAttribute("color", new THREE.BufferAttribute(tints, 3));
  return geometry;
}

/** Several geometries, each with its colour, in one: one call to the graphics card instead of many. */
export function merged(parts) {
  const flat = parts.map(([geometry, tint]) => [geometry.index ? geometry.toNonIndexed() : geometry, tint]);
  const count = flat.reduce((sum, [geometry]) => sum + geometry.getAttribute("position").count, 0);
  const whole = new THREE.BufferGeometry();
  const arrays = { position: new Float32Array(3 * count), normal: new Float32Array(3 * count) };
  const tints = new Float32Array(3 * count);
  let at = 0;
  for (const [geometry, tint] of flat) {
    for (const name in arrays) arrays[name].set(geometry.getAttribute(name).array, at);
    const end = at + geometry.getAttribute("position").array.length;
    for (; at < end; at += 3) tint.toArray(tints, at);
  }
  for (const name in arrays) whole.setAttribute(name, new THREE.BufferAttribute(arrays[name], 3));
  whole.setAttribute("color", new THREE.BufferAttribute(tints, 3));
  return whole;
}

/** A box between two corners [x, y, z]. */
export function boxBetween(low, high) {
  const box = new THREE.BoxGeometry(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  return box.translate((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2);
}

const UP = new THREE.Vector3(0, 1, 0);
const along = new THREE.Vector3();

/** Lay an object made along y, of length 1 about its middle, between two points (flat arrays with offsets). */
export function stretch(object, from, i, to, j) {
  along.set(to[j] - from[i], to[j + 1] - from[i + 1], to[j + 2] - from[i + 2]);
  const length = along.length();
  object.position.set((to[j] + from[i]) / 2, (to[j + 1] + from[i + 1]) / 2, (to[j + 2] + from[i + 2]) / 2);
  object.scale.y = Math.max(length, 1e-6);
  if (length > 1e-6) object.quaternion.setFromUnitVectors(UP, along.divideScalar(length));
}

/** Set position and attitude from x, y, z and a quaternion w, x, y, z. */
export function place(object, pose) {
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[4], pose[5], pose[6], pose[3]);
}

/** Free what an object and its children hold on the graphics card. */
export function dispose(object) {
  object.traverse((part) => {
    part.geometry?.dispose();
    for (const material of [part.material ?? []].flat()) {
      material.map?.dispose();
      material.dispose();
    }
  });
  object.removeFromParent();
}
