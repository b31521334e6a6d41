// Sea and sky. Axes N, z down: the sea stays level, the ship moves on it. What is drawn of the waves is for the eye:
// their height and course follow the setup, the deck's motion itself comes with the frames.
import * as THREE from "three";
import { painted, shuffler } from "./deck.js";

export const SUN = new THREE.Vector3(-0.42, 0.62, -0.72).normalize(); // towards it, N axes
const HORIZON = [206, 222, 233];
const ZENITH = [58, 112, 178];

const VERTEX = `
varying vec2 place;
varying vec3 world;
void main() {
  vec4 at = modelMatrix * vec4(position, 1.0);
  world = at.xyz;
  place = vec2(world.x, world.z); // N: x forward, y starboard
  gl_Position = projectionMatrix * viewMatrix * at;
}`;

const FRAGMENT = `
uniform sampler2D ripples;
uniform float seconds, speed, steep, foamy;
uniform vec2 course, beam;
uniform vec3 sun, horizon, zenith, deep, eye;
uniform vec3 hull; // stern x, length, half beam
varying vec2 place;
varying vec3 world;

vec3 sky(float up) { return mix(horizon, zenith, pow(clamp(up, 0.0, 1.0), 0.55)); }

void main() {
  vec2 p = place + vec2(speed * seconds, 0.0);
  vec2 along = vec2(dot(p, course), dot(p, vec2(-course.y, course.x)));
  vec3 a = texture2D(ripples, along / vec2(90.0, 120.0) - vec2(seconds * 0.06, 0.0)).xyz - 0.5;
  vec3 b = texture2D(ripples, along.yx / 31.0 + vec2(seconds * 0.02, -seconds * 0.06)).xyz - 0.5;
  vec3 c = texture2D(ripples, p / 7.9 - course * seconds * 0.14).xyz - 0.5;
  vec3 d = texture2D(ripples, p.yx / 2.3 + vec2(0.0, seconds * 0.2)).xyz - 0.5;
  vec3 toEye = eye - world;
  float distance = length(toEye);
  toEye /= distance;
  float near = 1.0 / (1.0 + distance / 420.0);
  float close = 1.0 / (1.0 + distance / 60.0);
  vec2 slope = steep * near * (0.75 * a.xy + 0.6 * b.xy) + 0.34 * c.xy * near + 0.3 * d.xy * close;
  vec3 normal = normalize(vec3(-slope.x, 1.0, -slope.y));
  float facing = max(dot(normal, toEye), 0.0);
  float fresnel = 0.02 + 0.55 * pow(1.0 - facing, 4.0); // a rough sea mirrors less than a smooth one
  vec3 mirror = reflect(-toEye, normal);
  float height = 0.55 * a.z + 0.45 * b.z;
  vec3 tint = deep * (1.0 + 1.2 * height + 0.35 * c.z) + vec3(0.0, 0.02, 0.02) * smoothstep(0.0, 0.4, height);
  vec3 sea = mix(tint, sky(0.25 + 0.75 * max(mirror.y, 0.0)), fresnel);
  float glint = max(dot(mirror, sun), 0.0);
  sea += vec3(1.0, 0.93, 0.78) * (0.7 * pow(glint, 220.0) + 0.10 * pow(glint, 18.0));
  // White water: crests, along the hull, and the wake.
  float x = place.x - hull.x;
  float side = abs(place.y);
  float lace = 0.5 + 0.5 * b.z + 0.9 * c.z + 0.7 * d.z;
  float crest = foamy * smoothstep(0.20, 0.34, height) * smoothstep(0.42, 0.75, lace);
  float moving = clamp(speed / 6.0, 0.0, 1.0);
  float spread = hull.z * (0.75 + 0.012 * max(-x, 0.0));
  float wake = moving * step(x, 2.0) * exp(x / 130.0) * smoothstep(spread + 3.0, spread - 3.5, side);
  float wash = moving * step(0.0, x) * step(x, hull.y) * smoothstep(hull.z + 3.2, hull.z - 0.2, side);
  float foam = clamp(crest + max(wake, wash) * smoothstep(0.45, 0.85, lace + 0.1), 0.0, 1.0);
  sea = mix(sea, vec3(0.80, 0.86, 0.89), 0.85 * foam * near);
  sea = mix(sea, horizon, smoothstep(250.0, 2600.0, distance) * 0.92);
  gl_FragColor = vec4(sea, 1.0);
  #include <colorspace_fragment>
}`;

/** A tile of waves: slopes across and along in red and green, height in blue. */
function ripples() {
  const size = 256;
  const chance = shuffler(11);
  const waves = [];
  for (let i = 0; i < 46; i++) {
    const number = 1 + Math.floor(15 * chance() ** 1.6);
    const angle = (chance() - 0.5) * 2.2;
    const kx = Math.round(number * Math.cos(angle));
    const ky = Math.round(number * Math.sin(angle));
    const k = Math.hypot(kx, ky);
    if (k > 0) waves.push([kx, ky, 6.2832 * chance(), 1 / k ** 1.25]);
  }
  const field = new Float32Array(3 * size * size);
  const top = [0, 0, 0];
  const table = new Float32Array(size).map((_, i) => Math.sin((2 * Math.PI * i) / size));
  for (const [kx, ky, phase, high] of waves) {
    const shift = Math.round((phase / (2 * Math.PI)) * size);
    for (let y = 0, o = 0; y < size; y++) {
      for (let x = 0; x < size; x++, o += 3) {
        const angle = kx * x + ky * y + shift;
        const cosine = table[(angle + size / 4) & (size - 1)];
        field[o] += kx * high * cosine;
        field[o + 1] += ky * high * cosine;
        field[o + 2] += high * table[angle & (size - 1)];
      }
    }
  }
  field.forEach((v, i) => (top[i % 3] = Math.max(top[i % 3], Math.abs(v))));
  const most = Math.max(top[0], top[1]);
  const pixels = new Uint8Array(4 * size * size);
  for (let i = 0; i < size * size; i++) {
    pixels[4 * i] = 127.5 + (127 * field[3 * i]) / most;
    pixels[4 * i + 1] = 127.5 + (127 * field[3 * i + 1]) / most;
    pixels[4 * i + 2] = 127.5 + (127 * field[3 * i + 2]) / top[2];
    pixels[4 * i + 3] = 255;
  }
  const texture = new THREE.DataTexture(pixels, size, size);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.magFilter = THREE.LinearFilter;
  texture.minFilter = THREE.LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
}

function linear([r, g, b]) {
  return new THREE.Color().setRGB(r / 255, g / 255, b / 255, THREE.SRGBColorSpace);
}

export class Sea {
  constructor() {
    this.uniforms = {
      ripples: { value: ripples() }, seconds: { value: 0 }, speed: { value: 0 }, steep: { value: 0.6 },
      foamy: { value: 0.3 }, course: { value: new THREE.Vector2(1, 0) }, beam: { value: new THREE.Vector2() },
      sun: { value: new THREE.Vector3(SUN.x, -SUN.z, SUN.y) }, horizon: { value: linear(HORIZON) },
      zenith: { value: linear(ZENITH) }, deep: { value: linear([20, 60, 86]) }, eye: { value: new THREE.Vector3() },
      hull: { value: new THREE.Vector3(-15, 118, 6) },
    };
    const material = new THREE.ShaderMaterial({ uniforms: this.uniforms, vertexShader: VERTEX, fragmentShader: FRAGMENT });
    this.surface = new THREE.Mesh(new THREE.PlaneGeometry(6400, 6400), material);
    this.surface.rotation.x = -Math.PI / 2; // in the turned axes of the picture: up is y
    this.surface.frustumCulled = false;
    this.dome = this.#sky();
  }

  setup(setup) {
    const u = this.uniforms;
    const sea = setup.sea;
    const course = ((sea ? sea.heading_deg : 35) * Math.PI) / 180; // where the waves travel, from the ship's heading
    const height = sea ? sea.hs_m : 1;
    u.course.value.set(Math.cos(course), Math.sin(course));
    u.speed.value = setup.ship_speed_m_s;
    u.steep.value = 0.45 + 0.35 * Math.min(height, 7) / 3;
    u.foamy.value = Math.min(1, Math.max(0, (height - 1) / 4));
    u.hull.value.set(setup.ship.aft_x, 112, 0.95 * setup.ship.half_beam);
    this.surface.position.y = -setup.ship.above_sea;
  }

  update(seconds, eye) {
    this.uniforms.seconds.value = seconds;
    this.uniforms.eye.value.copy(eye);
    this.surface.position.x = eye.x;
    this.surface.position.z = eye.z;
    this.dome.position.copy(eye);
  }

  #sky() {
    const map = painted(2048, 512, (g, w, h) => {
      const [from, to] = [ZENITH, HORIZON];
      for (let y = 0; y < h; y++) {
        const s = Math.pow(Math.sin((Math.PI / 2) * (1 - Math.min(1, y / (h / 2)))), 0.55);
        g.fillStyle = `rgb(${to.map((v, i) => Math.round(v + s * (from[i] - v))).join(",")})`;
        g.fillRect(0, y, w, 1);
      }
      const chance = shuffler(3);
      for (let bank = 0; bank < 64; bank++) {
        const rise = chance() ** 1.7;
        const cx = chance() * w;
        const cy = h / 2 - 8 - rise * h * 0.33;
        const wide = 40 + 190 * chance();
        for (let i = 0; i < 26; i++) {
          const x = cx + (chance() - 0.5) * 2 * wide;
          const y = cy + (chance() - 0.5) * wide * (0.05 + 0.12 * rise);
          const r = (10 + 40 * chance()) * (0.35 + 0.8 * rise);
          for (const shift of [-w, 0, w]) {
            const puff = g.createRadialGradient(x + shift, y, 0, x + shift, y, r);
            puff.addColorStop(0, `rgba(255,255,255,${0.05 + 0.06 * chance()})`);
            puff.addColorStop(1, "rgba(255,255,255,0)");
            g.fillStyle = puff;
            g.save();
            g.translate(0, y);
            g.scale(1, 0.42);
            g.translate(0, -y);
            g.fillRect(x + shift - r, y - r, 2 * r, 2 * r);
            g.restore();
          }
        }
      }
    });
    const material = new THREE.MeshBasicMaterial({ map, side: THREE.BackSide, depthWrite: false, depthTest: false });
    const dome = new THREE.Mesh(new THREE.SphereGeometry(3000, 32, 20), material);
    dome.renderOrder = -10;
    dome.frustumCulled = false;
    return dome;
  }
}
