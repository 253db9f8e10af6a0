// What is drawn over the bodies of a world: contact forces, hands, joints that are lines, the axes, a scale bar.
import { arrow, axes, bar } from "vademecum/overlay";
import { toSpace } from "vademecum/pulling";
import { add, norm, scaled } from "vademecum/vectors";

/** Length of the arrow of the largest force, as a share of the size of the bodies, and how fast a shrinking range is followed [1/frame]. */
const LONGEST = 0.16, SLOW = 0.02;

/** Draws all of it. */
export function drawWorld(canvas, page, forces) {
  const { world, stage, scene, camera, renderer, panel } = page;
  const { ratio } = renderer;
  const [w, h] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, w, h);
  if (scene.joints.length > 0) joints(context, page);
  if (forces) contacts(context, page);
  for (const { place, target, force } of stage.pulls()) {
    line(context, camera, place, target, panel.style.series[0], 2);
    dot(context, camera, target, panel.style.series[0], 5);
    const size = norm(force);
    if (size > 0) arrow(context, camera, add(place, scaled(force, (0.1 * world.crowd.size) / size)), force, 0.1 * world.crowd.size, panel.style.series[0]);
  }
  axes(context, camera, canvas.clientHeight, panel.style);
  bar(context, camera, canvas.clientHeight, panel.style);
}

/** An arrow for each contact, as long as its force is large beside the largest of late. */
function contacts(context, { world, camera, panel }) {
  const { touches, crowd } = world;
  const largest = touches.reduce((most, { force }) => Math.max(most, norm(force)), 0);
  world.range = Math.max(largest, (world.range ?? 0) * (1 - SLOW));
  for (const { place, force } of touches) {
    const length = LONGEST * crowd.size * (norm(force) / world.range);
    if (length > 0.01 * crowd.size) arrow(context, camera, add(place, scaled(force, length / norm(force))), force, length, panel.style.arrow, 1.5);
  }
}

/** Joints: a line between the two points, or a dot where they meet; paler where they are broken. */
function joints(context, { stage, scene, camera, panel, world }) {
  const poses = stage.poses();
  const at = (member, point) => add(poses[member].position, toSpace(point, poses[member].rotation));
  stage.jointStates().forEach(({ broken }, i) => {
    const { members, points } = scene.joints[i];
    const [a, b] = [0, 1].map((side) => at(members[side], points[side]));
    const color = broken ? panel.style.arrow : panel.style.ink;
    if (!broken && norm([0, 1, 2].map((k) => a[k] - b[k])) > 0.02 * world.crowd.size) line(context, camera, a, b, color, 2);
    dot(context, camera, a, color, broken ? 2 : 3);
    if (broken) dot(context, camera, b, color, 2);
  });
}

function line(context, camera, from, to, color, width) {
  const [a, b] = [camera.pixel(from), camera.pixel(to)];
  if (!a || !b) return;
  Object.assign(context, { strokeStyle: color, lineWidth: width });
  context.beginPath();
  context.moveTo(...a);
  context.lineTo(...b);
  context.stroke();
}

function dot(context, camera, place, color, radius) {
  const at = camera.pixel(place);
  if (!at) return;
  context.fillStyle = color;
  context.beginPath();
  context.arc(...at, radius, 0, 2 * Math.PI);
  context.fill();
}
