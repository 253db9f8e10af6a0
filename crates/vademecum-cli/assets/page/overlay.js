// What is drawn over the body: arrows of pushes, a ring where Enter pushes, the axes, a scale bar.
import { round125 } from "vademecum/body";
import { short } from "vademecum/chart";
import { add, AXES, dot, scaled, unit } from "vademecum/vectors";

/** A trail lasts so long [s]. */
const LASTS = 1.5;

/** The way that the point of the last push goes, as it is drawn. */
export class Trail {
  constructor(player, body) {
    Object.assign(this, { player, body, point: null, way: [] });
  }

  /** Called for each frame, `now` in milliseconds; a mode that is shown has no trail. */
  frame(mode, now) {
    const last = [...this.player.contacts.values()].at(-1);
    if (mode || this.player.atRest) this.way = [];
    if (last && last.point !== this.point) Object.assign(this, { point: last.point, way: [] });
    if (!this.point || mode || this.player.paused) return;
    this.way.push({ now, place: this.body.place(this.point) });
    while (now - this.way[0].now > 1000 * LASTS) this.way.shift();
  }

  /** Paler where it is older. */
  draw(context, camera, color) {
    const { way } = this;
    if (way.length < 2) return;
    const newest = way.at(-1).now;
    Object.assign(context, { strokeStyle: color, lineWidth: 1.5 });
    for (let i = 1; i < way.length; i++) {
      const [from, to] = [camera.pixel(way[i - 1].place), camera.pixel(way[i].place)];
      if (!from || !to) continue;
      context.globalAlpha = 0.7 * Math.max(0, 1 - (newest - way[i].now) / (1000 * LASTS));
      context.beginPath();
      context.moveTo(...from);
      context.lineTo(...to);
      context.stroke();
    }
    context.globalAlpha = 1;
  }
}

/** Draws all of it. */
export function drawOver(canvas, player, camera, controls, { focused, trail }) {
  const { ratio } = controls.renderer;
  const [w, h] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, w, h);
  const { body } = player;
  trail?.draw(context, camera, controls.style.arrow);
  for (const { point, force } of player.contacts.values()) arrow(context, camera, body.place(point), force, lengthOf(force, body), controls.style.arrow);
  const tool = player.tool && player.evaluator.tool();
  if (tool) pushes(context, camera, tool, drawnTool(player, controls.magnification), body, controls.style.arrow);
  if (focused && body.loadTriangles > 0) {
    const at = camera.pixel(body.place(body.flexible.point));
    if (at) ring(context, at, controls.style.arrow);
  }
  axes(context, camera, canvas.clientHeight, controls.style);
  bar(context, camera, canvas.clientHeight, controls.style);
}

/** Where the sphere is drawn: moved as much farther as the body under it is. */
export function drawnTool({ tool, evaluator }, magnification) {
  const { centre, radius, point } = tool;
  return { centre: add(centre, scaled(evaluator.point(point), magnification - 1)), radius };
}

/** One arrow for all pushes of the sphere, where they act. */
function pushes(context, camera, { centre, touches }, drawn, body, color) {
  const sizes = touches.map(({ force }) => Math.hypot(...force));
  const all = sizes.reduce((sum, size) => sum + size, 0);
  if (all === 0) return;
  const [place, force] = [[0, 0, 0], [0, 0, 0]];
  touches.forEach((touch, t) => {
    for (let i = 0; i < 3; i++) {
      place[i] += (sizes[t] / all) * (touch.place[i] - centre[i] + drawn.centre[i]);
      force[i] += touch.force[i];
    }
  });
  arrow(context, camera, place, force, lengthOf(force, body), color);
}

/** Length of the arrow of a push [m]. */
const lengthOf = (force, body) => body.size * Math.min(0.2, Math.max(0.05, 0.1 * Math.cbrt(Math.hypot(...force) / body.flexible.force)));

/** An arrow with its tip at a place, along a force, `length` [m] long; `width` of its line in pixels. */
export function arrow(context, camera, place, force, length, color, width = 3) {
  const tip = camera.pixel(place);
  if (!tip || Math.hypot(...force) === 0) return;
  const tail = camera.pixel(add(place, scaled(unit(force), -length)));
  if (!tail) return;
  const angle = Math.atan2(tip[1] - tail[1], tip[0] - tail[0]);
  const head = (13 * width) / 3;
  context.strokeStyle = context.fillStyle = color;
  context.lineWidth = width;
  context.beginPath();
  context.moveTo(...tail);
  context.lineTo(tip[0] - 0.6 * head * Math.cos(angle), tip[1] - 0.6 * head * Math.sin(angle));
  context.stroke();
  context.beginPath();
  context.moveTo(...tip);
  for (const side of [-0.4, 0.4]) context.lineTo(tip[0] - head * Math.cos(angle + side), tip[1] - head * Math.sin(angle + side));
  context.fill();
}

function ring(context, [x, y], color) {
  context.strokeStyle = color;
  context.lineWidth = 2;
  context.beginPath();
  context.arc(x, y, 7, 0, 2 * Math.PI);
  context.stroke();
}

/** Where x, y and z point, in the lower left corner. */
export function axes(context, camera, height, style) {
  const [x, y] = [34, height - 34];
  context.font = "11px system-ui, sans-serif";
  context.textAlign = "center";
  Object.entries(AXES).forEach(([name, axis], k) => {
    const [dx, dy] = [22 * dot(axis, camera.view.right), -22 * dot(axis, camera.view.up)];
    context.strokeStyle = style.series[[1, 2, 0][k]];
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + dx, y + dy);
    context.stroke();
    context.fillStyle = style.soft;
    context.fillText(name, x + 1.35 * dx, y + 1.35 * dy + 4);
  });
}

/** How long a round length is in the middle of the body. */
export function bar(context, camera, height, style) {
  const length = round125(110 * camera.metresPerPixel);
  const [x, y, width] = [74, height - 14, length / camera.metresPerPixel];
  context.strokeStyle = context.fillStyle = style.soft;
  context.lineWidth = 1.5;
  context.beginPath();
  for (const end of [x, x + width]) {
    context.moveTo(end, y - 4);
    context.lineTo(end, y + 4);
  }
  context.moveTo(x, y);
  context.lineTo(x + width, y);
  context.stroke();
  context.fillText(short(length, "m"), x + width / 2, y - 7);
}
