// An orbit camera: one axis is up, the body stays in view, and every change of the view can be undone.
import { add, cross, dot, norm, scaled, sub, transformed, viewProjection } from "vademecum/vectors";

const TANGENT = Math.tan((30 / 2) * (Math.PI / 180));
const START = { yaw: -1.05, pitch: 0.42 };
/** Views that can be undone. */
const REMEMBERED = 100;
/** A body that runs away is followed up to this many of its own sizes. */
const FOLLOWED = 3;
/** So far (of half the body's diagonal) it moves without the view: there is room for it. */
const FREE = 0.04;

const middle = ({ low, high }) => scaled(add(low, high), 0.5);

export class Camera {
  /** Around a box `{ low, high }` [m]; axis `up` (0, 1, 2) points upwards; the part to be seen first faces `facing`, zero if it is all around. */
  constructor(box, up, facing = [0, 0, 0]) {
    Object.assign(this, { box, up, facing, aspect: 1, past: [] });
    this.radius = norm(sub(box.high, box.low)) / 2;
    this.reset();
    this.past = [];
  }

  /** The view as built, with the axis that is up kept. */
  reset() {
    this.remember();
    Object.assign(this, this.start, { target: middle(this.box), zoom: 1, around: this.box });
  }

  /** The first view: the one of four turns that looks most at the side to be seen, from below only if no view from above sees it. */
  get start() {
    const least = 1e-3 * norm(this.facing);
    const seen = (pose) => dot(this.frame(pose).back, this.facing);
    const best = (pitch) => [0, 1, 2, 3].map((turn) => ({ yaw: START.yaw + (turn * Math.PI) / 2, pitch })).reduce((a, b) => (seen(b) > seen(a) + least ? b : a));
    const above = best(START.pitch);
    return seen(above) >= 0 ? above : best(-START.pitch);
  }

  /** What makes the view, and back to it. */
  get pose() {
    const { up, yaw, pitch, target, zoom } = this;
    return { up, yaw, pitch, target, zoom };
  }

  set pose(pose) {
    Object.assign(this, pose);
  }

  /** Keeps the view as it is now for `undo`. */
  remember() {
    if (this.target) this.past.push(this.pose);
    if (this.past.length > REMEMBERED) this.past.shift();
  }

  undo() {
    if (this.past.length > 0) this.pose = this.past.pop();
  }

  /** Axis `up` points upwards from now on. */
  stand(up) {
    this.remember();
    this.up = up;
    Object.assign(this, this.start);
  }

  /** Looks along an axis, from its far end; from the other end if it does so already. */
  lookFrom(axis) {
    this.remember();
    const there = axis === this.up ? { yaw: -Math.PI / 2, pitch: Math.PI / 2 } : { yaw: axis === (this.up + 1) % 3 ? 0 : Math.PI / 2, pitch: 0 };
    const already = Math.abs(this.yaw - there.yaw) < 1e-9 && Math.abs(this.pitch - there.pitch) < 1e-9;
    if (already && axis === this.up) there.pitch = -there.pitch;
    else if (already) there.yaw += Math.PI;
    Object.assign(this, there);
  }

  frame({ yaw, pitch } = this) {
    const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    const turned = (along, across, above) => {
      const v = [0, 0, 0];
      [v[(this.up + 1) % 3], v[(this.up + 2) % 3], v[this.up]] = [along, across, above];
      return v;
    };
    const [back, right] = [turned(cp * cy, cp * sy, sp), turned(-sy, cy, 0)];
    return { back, right, up: cross(back, right) };
  }

  /** Makes room for a body that is drawn in `box`: at once where it grows, slowly back. Who turned the wheel or moved the view chose for himself. */
  follow(box, seconds) {
    if (this.zoom !== 1 || norm(sub(this.target, middle(this.box))) > 1e-9 * this.radius) return;
    const [most, free] = [FOLLOWED * 2 * this.radius, FREE * this.radius];
    const [grow, shrink] = [1 - Math.exp(-seconds / 0.08), 1 - Math.exp(-seconds / 8)];
    const side = (now, wanted, rest, sign) => {
      const to = sign * Math.max(sign * rest, Math.min(sign * wanted - free, sign * rest + most));
      return now + (to - now) * (sign * to > sign * now ? grow : shrink);
    };
    const { low, high } = this.around;
    this.around = {
      low: low.map((x, i) => side(x, box.low[i], this.box.low[i], -1)), high: high.map((x, i) => side(x, box.high[i], this.box.high[i], 1)),
    };
  }

  /** Distance at which all corners of the box are in view, whatever the shape of the window. */
  distance(frame) {
    const margin = 1.12;
    let distance = 0;
    const centre = middle(this.around);
    const { low, high } = this.around;
    for (let corner = 0; corner < 8; corner++) {
      const p = [0, 1, 2].map((i) => ((corner >> i) & 1 ? high[i] : low[i]) - centre[i]);
      const across = Math.abs(dot(p, frame.right)) / (TANGENT * this.aspect);
      const along = Math.abs(dot(p, frame.up)) / TANGENT;
      distance = Math.max(distance, dot(p, frame.back) + margin * Math.max(across, along));
    }
    return distance / this.zoom;
  }

  /** Fixes the matrices for this frame's window. */
  update(width, height) {
    this.aspect = width / height;
    [this.width, this.height] = [width, height];
    const frame = this.frame();
    const distance = this.distance(frame);
    // The middle of a body that has moved away is looked at, as far as the visitor has not chosen another point.
    const looked = add(this.target, sub(middle(this.around), middle(this.box)));
    this.view = { ...frame, eye: add(looked, scaled(frame.back, distance)) };
    const far = distance + 6 * this.radius;
    this.matrix = viewProjection(this.view, TANGENT, this.aspect, Math.max(distance - 4 * this.radius, 0.03 * distance), far);
    this.metresPerPixel = (2 * TANGENT * distance) / height;
  }

  orbit(dx, dy) {
    this.yaw -= dx * 0.008;
    this.pitch = Math.min(1.55, Math.max(-1.55, this.pitch + dy * 0.008));
  }

  pan(dx, dy) {
    const move = add(scaled(this.view.right, -dx), scaled(this.view.up, dy));
    this.target = add(this.target, scaled(move, this.metresPerPixel));
  }

  closer(factor) {
    this.zoom = Math.min(100, Math.max(0.1, this.zoom * factor));
  }

  /** Pixel of a point; null behind the eye. */
  pixel(p) {
    const [x, y, , w] = transformed(this.matrix, p);
    return w > 0 ? [((x / w + 1) / 2) * this.width, ((1 - y / w) / 2) * this.height] : null;
  }

  /** The ray `{ from, along }` through a pixel. */
  ray(px, py) {
    const x = ((2 * px) / this.width - 1) * TANGENT * this.aspect;
    const y = (1 - (2 * py) / this.height) * TANGENT;
    const across = add(scaled(this.view.right, x), scaled(this.view.up, y));
    return { from: this.view.eye, along: sub(across, this.view.back) };
  }

  /** Displacement [m] in the view plane at a point's depth that moves it by (dx, dy) pixels. */
  inPlane(p, dx, dy) {
    const depth = dot(sub(this.view.eye, p), this.view.back);
    const scale = (2 * TANGENT * depth) / this.height;
    return add(scaled(this.view.right, dx * scale), scaled(this.view.up, -dy * scale));
  }
}
