// Small vectors and matrices: arrays of 3, column-major Float32Array of 16.

/** Unit vectors of the axes. */
export const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const norm = (a) => Math.hypot(a[0], a[1], a[2]);

export function unit(a) {
  const length = norm(a);
  return length > 0 ? scaled(a, 1 / length) : [0, 0, 0];
}

/** Looks through a pinhole at `eye` along `-back`, `right` and `up` completing the frame; near and far along the axis. */
export function viewProjection({ right, up, back, eye }, tangent, aspect, near, far) {
  const f = 1 / tangent;
  const [a, b] = [-(far + near) / (far - near), (-2 * far * near) / (far - near)];
  const rows = [
    [...scaled(right, f / aspect), (-f / aspect) * dot(right, eye)],
    [...scaled(up, f), -f * dot(up, eye)],
    [...scaled(back, a), -a * dot(back, eye) + b],
    [...scaled(back, -1), dot(back, eye)],
  ];
  return Float32Array.from({ length: 16 }, (_, i) => rows[i % 4][i >> 2]);
}

/** Clip coordinates of a point. */
export function transformed(m, p) {
  return [0, 1, 2, 3].map((i) => m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i]);
}
