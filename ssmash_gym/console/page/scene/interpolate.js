// From frames (see ssmash_gym/console/scene.py) to the pose at any instant between two of them.

const WIDTHS = { ship: 7, body: 7, claw: 5, probe: 6, force: 3, command: 2, load_kN: 3 };

/** Room for one pose: plain arrays that are written over at every picture, so that nothing is thrown away. */
export function blankPose(tires = 6) {
  const pose = { t: 0, k: -1, captured: true, struts: new Float64Array(18), tires: new Float64Array(7 * tires) };
  for (const [name, width] of Object.entries(WIDTHS)) pose[name] = new Float64Array(width);
  return pose;
}

function lerp(a, b, s, out, start, end, offset = 0) {
  for (let i = start; i < end; i++) out[offset + i] = a[i] + s * (b[i] - a[i]);
}

/** Spherical interpolation of quaternions w, x, y, z at places 3 to 6 of two poses. */
function slerp(a, b, s, out) {
  let dot = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6];
  const sign = dot < 0 ? -1 : 1;
  dot = Math.min(1, dot * sign);
  let u = 1 - s;
  let v = s * sign;
  if (dot < 0.9995) {
    const angle = Math.acos(dot);
    u = Math.sin((1 - s) * angle) / Math.sin(angle);
    v = (sign * Math.sin(s * angle)) / Math.sin(angle);
  }
  let size = 0;
  for (let i = 3; i < 7; i++) {
    out[i] = u * a[i] + v * b[i];
    size += out[i] * out[i];
  }
  size = 1 / Math.sqrt(size);
  for (let i = 3; i < 7; i++) out[i] *= size;
}

/** Write the pose between frames a (s = 0) and b (s = 1). */
export function blend(a, b, s, pose) {
  for (const name in WIDTHS) {
    const rigid = name === "ship" || name === "body";
    lerp(a[name], b[name], s, pose[name], 0, rigid ? 3 : WIDTHS[name]);
    if (rigid) slerp(a[name], b[name], s, pose[name]);
  }
  for (let i = 0; i < 3; i++) lerp(a.struts[i], b.struts[i], s, pose.struts, 0, 6, 6 * i);
  for (let i = 0; i < a.tires.length; i++) lerp(a.tires[i], b.tires[i], s, pose.tires, 0, 7, 7 * i);
  const newer = s >= 1 ? b : a;
  pose.t = a.t + s * (b.t - a.t);
  pose.k = newer.k;
  pose.captured = newer.captured;
}

/** Index of the last frame at or before a time; 0 before the first. */
export function frameAt(frames, time) {
  let low = 0;
  let high = frames.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (frames[middle].t <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** Write the pose of a recorded run at a time; held at its first and last frame. */
export function poseAt(frames, time, pose) {
  const i = frameAt(frames, time);
  const a = frames[i];
  const b = frames[Math.min(i + 1, frames.length - 1)];
  const s = b.t > a.t ? Math.min(1, Math.max(0, (time - a.t) / (b.t - a.t))) : 0;
  blend(a, b, s, pose);
}

/**
 * Frames as they arrive. The picture runs one interval behind the newest, on a clock that follows the arrivals slowly,
 * so that it moves evenly although messages do not come evenly.
 */
export class Timeline {
  constructor() {
    this.clear();
  }

  clear() {
    this.frames = [];
    this.behind = null; // arrival minus the frame's own time, smoothed [s]
    this.interval = 0.1;
  }

  /** @param now When it arrived [s], on any clock that `pose` is asked by. */
  push(frame, now) {
    let last = this.frames[this.frames.length - 1];
    if (last && frame.t < last.t) {
      this.clear(); // a new episode
      last = undefined;
    }
    const standing = last !== undefined && frame.t === last.t; // before the start: the same instant again
    if (standing) this.frames.pop();
    else if (last) this.interval = frame.t - last.t;
    this.frames.push(frame);
    if (this.frames.length > 8) this.frames.shift();
    const sample = now - frame.t;
    const gap = this.behind === null ? Infinity : sample - this.behind;
    if (standing || Math.abs(gap) > Math.max(0.3, 3 * this.interval)) this.behind = sample;
    else this.behind += (gap < 0 ? 0.3 : 0.04) * gap; // a late message says less about the clock than an early one
  }

  /** Write the pose to be drawn now [s]; false while there is none. */
  pose(now, pose) {
    if (!this.frames.length) return false;
    const newest = this.frames[this.frames.length - 1].t;
    poseAt(this.frames, Math.min(newest, now - this.behind - this.interval), pose);
    return true;
  }
}
