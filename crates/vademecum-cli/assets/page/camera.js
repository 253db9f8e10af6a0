// An orbit camera: z is up, the body stays in view.
import { add, cross, dot, norm, scaled, sub, transformed, viewProjection } from "vademecum/vectors";

const TANGENT = Math.tan((30 / 2) * (Math.PI / 180));
const START = { yaw: -1.05, pitch: 0.42 };

export class Camera {
  /** Around a box `{ low, high }` [m]. */
  constructor(box) {
    this.box = box;
    this.radius = norm(sub(box.high, box.low)) / 2;
    this.aspect = 1;
    this.reset();
  }

  reset() {
    Object.assign(this, START);
    this.target = scaled(add(this.box.low, this.box.high), 0.5);
    this.zoom = 1;
  }

  frame() {
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    const back = [cp * cy, cp * sy, sp];
    const right = [-sy, cy, 0];
    return { back, right, up: cross(back, right) };
  }

  /** Distance at which all corners of the box are in view, whatever the shape of the window. */
  distance(frame) {
    const margin = 1.12;
    let distance = 0;
    const middle = scaled(add(this.box.low, this.box.high), 0.5);
    for (let corner = 0; corner < 8; corner++) {
      const p = [0, 1, 2].map((i) => ((corner >> i) & 1 ? this.box.high[i] : this.box.low[i]) - middle[i]);
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
    this.view = { ...frame, eye: add(this.target, scaled(frame.back, distance)) };
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
