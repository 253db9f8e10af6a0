// The page: opens the file, draws as often as the browser likes, and lets the march follow the clock.
import { Evaluator, SECTION } from "vademecum/evaluator";
import { Body } from "vademecum/body";
import { Camera } from "vademecum/camera";
import { drawBars, drawStrip } from "vademecum/chart";
import { Controls } from "vademecum/controls";
import { find } from "vademecum/elements";
import { Greeting } from "vademecum/greet";
import { Hands } from "vademecum/hands";
import { drawOver, drawnTool, Trail } from "vademecum/overlay";
import { Modes } from "vademecum/modes";
import { Player } from "vademecum/player";
import { Recorder } from "vademecum/record";
import { Renderer } from "vademecum/render";
import { Share } from "vademecum/share";
import { Sound } from "vademecum/sound";
import { upward, viewButtons } from "vademecum/views";

function decode(text) {
  const binary = atob(text.trim());
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** The vademecum: inside an exported page, beside a served one. */
async function file() {
  const { textContent, dataset } = find("vdm");
  if (!dataset.src) return decode(textContent);
  const answer = await fetch(dataset.src);
  if (!answer.ok) throw new Error(`the file cannot be read (${answer.status})`);
  return new Uint8Array(await answer.arrayBuffer());
}

async function start() {
  const bytes = { wasm: decode(find("wasm").textContent), file: await file() };
  const evaluator = await Evaluator.open(bytes.wasm, bytes.file);
  const body = new Body(evaluator);
  const player = new Player(evaluator, body, { double: true });
  const renderer = new Renderer(find("view"), body);
  const camera = new Camera(body.box, upward(body, evaluator.problem), body.facing);
  const controls = new Controls(player, renderer, camera);
  new Hands(find("view"), player, camera, controls);
  const page = { evaluator, body, player, renderer, camera, controls, pace: new Pace(player) };
  // Those at the live parameters as they are.
  Object.defineProperty(page, "modes", { get: () => modes(evaluator) });
  page.shown = new Modes(page);
  page.share = new Share(camera, viewButtons(camera));
  page.sound = new Sound(player, bytes);
  page.recorder = new Recorder(controls, page.sound);
  page.greeting = new Greeting(player, controls);
  page.trail = new Trail(player, body);
  offer(page);
  let last = performance.now();
  const frame = (now) => {
    // A page that was hidden does not catch up, and the greeting lets go in the right frame.
    const seconds = Math.min(Math.max((now - last) / 1000, 0), page.greeting.id === null ? 0.25 : 0.02);
    last = now;
    show(page, seconds, now);
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
  return page;
}

/** One frame: march, reconstruct, draw. */
function show(page, seconds, now) {
  const { evaluator, body, player, renderer, camera, controls, pace } = page;
  const start = performance.now();
  const mode = page.shown.frame(seconds);
  try {
    if (!mode) player.advance(seconds);
    page.greeting.frame();
  } catch (error) {
    // Numbers that are not finite any more: say so and stand still, "Restart" begins anew.
    controls.refusal = `Stopped: ${error.message}`;
    controls.pause(true);
  }
  const size = renderer.resize();
  const displacement = mode?.displacement ?? player.displacement();
  const field = mode?.field ?? controls.bound?.field ?? shown(evaluator, controls, displacement);
  const magnification = mode ? 1 : controls.magnification;
  // In the air the body is drawn where it is in space.
  const drawn = (mode ? null : player.flight?.carried(displacement, magnification)) ?? displacement;
  body.displace(drawn, magnification);
  camera.follow(body.drawn, seconds);
  camera.update(...size);
  renderer.fill(drawn, field);
  const { dark } = controls;
  const component = mode ? -1 : controls.component;
  const tool = player.tool && drawnTool(player, magnification);
  renderer.draw(camera, { magnification, component, dark, tool, scale: mode ? 1 : controls.scale(field, seconds) });
  page.trail.frame(mode !== null, now);
  drawOver(find("over"), player, camera, controls, { focused: find("view").matches(".keys:focus"), trail: find("trail").checked ? page.trail : null });
  page.recorder.frame();
  signals(page);
  const own = controls.component === -1 && !controls.velocity && !controls.stress;
  controls.warn(mode ? 0 : own ? controls.largest : largest(displacement));
  pace.frame(seconds, (performance.now() - start) / 1000, (figures) => controls.pace(figures));
}

/** The field that colours the body. */
function shown(evaluator, { velocity, stress }, displacement) {
  if (stress) return evaluator.equivalentStress();
  return velocity ? evaluator.surface(true) : displacement;
}

function largest(field) {
  let most = 0;
  for (let i = 0; i < field.length; i += 3) most = Math.max(most, Math.hypot(field[i], field[i + 1], field[i + 2]));
  return most;
}

/** The recorded energies and short names of them, since several are drawn side by side. */
function energies(history, { totals }) {
  const of = totals.filter(({ unit }) => unit === "J").map(({ name }) => name);
  return { columns: of.map((name) => history.columns[history.names.indexOf(name)]), names: of.map((name) => name.replace(/_?energy$/, "") || "total") };
}

function signals({ player, evaluator, controls, modes }) {
  const { history } = player;
  const span = Number(find("span").value);
  const probes = evaluator.probeNames.length;
  const shown = probes > 0 ? history.columns.slice(0, probes) : [history.columns[0]];
  const names = probes > 0 ? evaluator.probeNames : ["most flexible point"];
  // What the push of the first press stores when it moves the body by no more than the rounding.
  const nothing = player.body.flexible.force * player.body.size * 1e-16;
  const common = { span, now: Math.max(player.time, span) };
  drawStrip(find("probes"), history, { ...common, columns: shown.slice(0, 4), names, unit: "m", nothing: controls.nothing }, controls.style);
  drawStrip(find("energy"), history, { ...common, ...energies(history, evaluator), unit: "J", positive: true, nothing }, controls.style);
  const state = evaluator.coordinates();
  const { density, stiffness } = evaluator.options;
  const shares = modes.map(({ lambda }, k) => density * state[modes.length + k] ** 2 + stiffness * lambda * state[k] ** 2);
  drawBars(find("shares"), shares, modes.map(({ label }) => label), controls.style);
}

/** Frequency and eigenvalue (or Rayleigh quotient) of each mode. */
function modes(evaluator) {
  const table = evaluator.section(SECTION.modeTable);
  const values = evaluator.section(SECTION.eigenvalues);
  return Array.from({ length: evaluator.counts.modes }, (_, k) => {
    const lambda = values ? values[k] : table ? table[6 * k + 1] : 0;
    const hertz = Math.sqrt(lambda) / (2 * Math.PI);
    return { lambda, hertz, label: hertz >= 100 ? hertz.toFixed(0) : String(Number(hertz.toPrecision(3))) };
  });
}

/** Measured over the last quarter of a second. */
class Pace {
  constructor(player) {
    Object.assign(this, { player, wall: 0, busy: 0, frames: 0, reached: player.reached, last: null });
  }

  frame(seconds, busy, tell) {
    this.wall += seconds;
    this.busy += busy;
    this.frames += 1;
    if (this.wall < 0.25) return;
    const { reached, timeStep } = this.player;
    const factor = (reached - this.reached) / this.wall;
    this.last = { rate: factor / timeStep, factor, frame: this.busy / this.frames, frames: this.frames / this.wall };
    Object.assign(this, { wall: 0, busy: 0, frames: 0, reached });
    tell(this.last);
  }
}

/** What tests and curious people may use. */
function offer(page) {
  const { evaluator, player, controls, camera, body } = page;
  const column = (values) => Array.from({ length: player.history.count - player.history.first }, (_, i) => player.history.at(values, player.history.first + i));
  Object.assign(window.vademecum, {
    evaluator,
    player,
    /** A contact at the loadable point nearest to `point` [m] with `force` [N]; its number. */
    press: (point, force) => player.press(evaluator.locate(point), force),
    release: (id) => player.release(id),
    step: (n) => player.step(n),
    /** Lays a sphere down, `{ radius, friction, speed, centre }`; where it is to go, what it did in the last step, and away with it. */
    hold: (tool) => player.hold({ target: tool.centre, point: evaluator.locate(tool.centre), ...tool }),
    moveTool: (target) => player.moveTool(target, evaluator.locate(target)),
    tool: () => evaluator.tool(),
    lift: () => player.lift(),
    pause: (paused = true) => controls.pause(paused),
    greeting: page.greeting,
    sound: page.sound,
    /** Natural modes as pictures: `shown.show(k)`. */
    shown: page.shown,
    trail: page.trail,
    recorder: page.recorder,
    camera,
    controls,
    set: (parameters) => controls.set(parameters),
    rest: () => {
      player.contacts.clear();
      player.lift();
      controls.rest();
    },
    /** Displacement of the loadable point nearest to `point`. */
    at: (point) => evaluator.point(evaluator.locate(point)),
    /** Where a loadable point is drawn [m]. */
    drawn: (point) => body.place(evaluator.locate(point)),
    /** Pixel of a loadable point, from the canvas's corner. */
    pixel: (point) => camera.pixel(body.place(evaluator.locate(point))),
    series: () => ({
      time: column(player.history.time),
      columns: Object.fromEntries(player.history.names.map((name, c) => [name, column(player.history.columns[c])])),
    }),
    state: () => ({
      time: player.time, steps: player.stepped, paused: player.paused, contacts: player.contacts.size, atRest: player.atRest,
      options: { ...evaluator.options }, structure: evaluator.structure, energy: evaluator.energy(), refusal: controls.refusal ?? "",
      secondsPerStep: player.secondsPerStep, pace: page.pace.last, modes: page.modes.map(({ hertz }) => hertz),
    }),
  });
}

window.vademecum = {};
window.vademecum.ready = start().then(() => true).catch((error) => {
  find("status").textContent = `The body cannot be shown: ${error.message}`;
  throw error;
});
