// The page of a world: bodies that touch, drawn as often as the browser likes, while the march follows the clock.
import { Camera } from "vademecum/camera";
import { drawStrip, short } from "vademecum/chart";
import { gradient } from "vademecum/colors";
import { Crowd } from "vademecum/crowd";
import { element, find } from "vademecum/elements";
import { drawWorld } from "vademecum/marks";
import { History } from "vademecum/player";
import { Pulling } from "vademecum/pulling";
import { Recorder } from "vademecum/record";
import { Renderer } from "vademecum/render";
import { Share } from "vademecum/share";
import { staged } from "vademecum/stage";
import { Striking } from "vademecum/striking";
import { norm, scaled } from "vademecum/vectors";
import { viewButtons } from "vademecum/views";

/** Most wall time [ms] that the march may take of a frame; what does not fit is given up and shows in the real-time factor. */
const BUDGET = 20;
/** Steps between two records of the energy, at most. */
const RECORDED = 16;
/** More bodies than this are told apart by their colours at first. */
const FEW = 3;
/** Gravity of a world without [m/s²], for its slider. */
const EARTH = 9.81;

const FIELDS = { part: ["body", ""], u: ["displacement", "m"], v: ["velocity", "m/s"] };

function decode(text) {
  const binary = atob(text.trim());
  return Uint8Array.from(binary, (letter) => letter.charCodeAt(0));
}

/** The files: inside an exported page, beside a served one. */
function files() {
  return Promise.all([...document.querySelectorAll("script[data-file]")].map(async ({ textContent, dataset }) => {
    if (!dataset.src) return decode(textContent);
    const answer = await fetch(dataset.src);
    if (!answer.ok) throw new Error(`a file cannot be read (${answer.status})`);
    return new Uint8Array(await answer.arrayBuffer());
  }));
}

class World {
  constructor(stage, scene) {
    Object.assign(this, { stage, scene, paused: false, speed: 1, owed: 0, stiffness: 1, refusal: "", peak: 0, late: false });
    this.crowd = new Crowd(stage, scene);
    this.history = new History(["energy", "kinetic and elastic", "forces", "contacts"]);
    this.report = stage.report();
    /** Up in this world: against gravity, else z. */
    this.up = norm(scene.gravity) > 0 ? scene.gravity.map(Math.abs).reduce((best, x, i, all) => (x > all[best] ? i : best), 0) : 2;
    this.nominal = norm(scene.gravity) > 0 ? scene.gravity : [0, 1, 2].map((axis) => (axis === this.up ? -EARTH : 0));
    this.gravity = scene.gravity;
    this.spent = { seconds: 0, steps: 0 };
    this.heard = { strikes() {}, rest() {} };
  }

  get time() {
    return this.report.time;
  }

  step(steps) {
    const start = performance.now();
    this.stage.step(steps);
    this.spent.seconds += (performance.now() - start) / 1000;
    this.spent.steps += steps;
    this.heard.strikes(this.stage.strikes());
    this.record();
  }

  record() {
    this.report = this.stage.report();
    this.touches = this.stage.touches();
    const { time, energy, potential, pressed } = this.report;
    const forces = this.touches.reduce((sum, { force }) => sum + norm(force), 0);
    this.history.push(time - this.scene.step, this.scene.step, [energy + potential, energy, forces, pressed]);
  }

  /** Lets `seconds` of wall time pass. */
  advance(seconds) {
    if (this.paused) return;
    this.owed += seconds * this.speed;
    const end = performance.now() + BUDGET;
    this.late = false;
    while (this.owed >= this.scene.step) {
      // Few enough that a frame ends in time.
      const each = this.spent.steps > 0 ? this.spent.seconds / this.spent.steps : 1e-3;
      const due = Math.max(1, Math.min(RECORDED, Math.floor(this.owed / this.scene.step), Math.floor((BUDGET * 1e-3) / each)));
      this.step(due);
      this.owed -= due * this.scene.step;
      if (performance.now() > end && this.owed >= this.scene.step) {
        this.owed = 0;
        this.late = true;
      }
    }
  }

  pause(paused) {
    this.paused = paused;
    find("pause").setAttribute("aria-pressed", String(paused));
    find("pause").textContent = paused ? "Go on" : "Pause";
  }

  reset() {
    this.stage.reset();
    this.stage.setGravity(this.gravity);
    this.history.clear();
    Object.assign(this, { owed: 0, refusal: "", peak: 0 });
    this.heard.rest();
    this.record();
  }

  setGravity(gravity) {
    this.gravity = gravity;
    this.stage.setGravity(gravity);
    this.report = this.stage.report();
  }
}

/** What the page shows and sets beside the bodies. */
class Panel {
  constructor(world, renderer) {
    Object.assign(this, { world, renderer });
    const on = (id, act) => find(id).addEventListener("click", act);
    on("pause", () => world.pause(!world.paused));
    on("step", () => {
      world.pause(true);
      this.guarded(() => world.step(1));
    });
    on("rest", () => this.guarded(() => world.reset()));
    on("help", () => find("keys").showModal());
    on("theme", () => this.theme(!this.dark));
    for (const id of ["pull", "speed", "gravity", "color"]) find(id).addEventListener("input", () => this.read());
    for (const id of ["wire", "ground"]) find(id).addEventListener("change", () => (renderer[id] = find(id).checked));
    const { scene, crowd } = world;
    // Bodies of few are told apart by their places.
    find("color").value = crowd.seen.length > FEW ? "part" : "u";
    find("wire").checked = renderer.wire;
    renderer.ground = find("ground").checked;
    find("gravity").value = norm(scene.gravity) > 0 ? "1" : "0";
    this.bodies();
    this.joints();
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => this.theme(dark.matches));
    this.theme(dark.matches);
    this.read();
  }

  /** Numbers that are not finite any more stop the march: "Restart" begins anew. */
  guarded(act) {
    try {
      act();
    } catch (error) {
      this.world.refusal = `Stopped: ${error.message}`;
      this.world.pause(true);
    }
  }

  theme(dark) {
    document.documentElement.classList.toggle("dark", dark);
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(`--${name}`).trim();
    this.dark = dark;
    this.style = { soft: color("soft"), line: color("line"), panel: color("panel"), stage: color("stage-plain"), ink: color("ink"), arrow: color("arrow"), series: [0, 1, 2, 3].map((k) => color(`series${k}`)) };
  }

  bodies() {
    const { scene, stage } = this.world;
    const lines = scene.members.slice(0, 40).filter(({ file, nodes }) => file !== null || nodes.length > 0);
    for (const { name, file } of lines) {
      const member = scene.members.findIndex((one) => one.name === name);
      const mass = stage.mass(member);
      const kind = file === null ? "rigid" : `${stage.files[file].modes} modes, ${stage.files[file].surfaceNodes} nodes`;
      find("file").append(element("dt", name), element("dd", `${kind}${mass > 0 ? `, ${short(1000 * mass, "g")}` : ", held"}`));
    }
    if (scene.members.length > 40) find("file").append(element("dt", "…"), element("dd", `${scene.members.length} in all`));
    find("bodies").textContent = String(this.world.crowd.seen.length);
  }

  /** A button for each joint that breaks it. */
  joints() {
    const { world } = this;
    this.breakers = world.scene.joints.slice(0, 24).map(({ name }, joint) => {
      const button = element("button", name);
      button.title = "breaks this joint";
      button.addEventListener("click", () => {
        world.stage.breakJoint(joint);
        world.report = world.stage.report();
      });
      return button;
    });
    find("joints").append(...(this.breakers.length > 0 ? [element("p", "Break a joint"), ...this.breakers] : []));
  }

  read() {
    const { world } = this;
    world.stiffness = 10 ** Number(find("pull").value);
    find("pull-out").textContent = `× ${Number(world.stiffness.toPrecision(2))}`;
    world.speed = 10 ** Number(find("speed").value);
    find("speed-out").textContent = world.speed > 0.98 ? "real time" : `× ${Number(world.speed.toPrecision(2))} slow motion`;
    const gravity = scaled(world.nominal, Number(find("gravity").value));
    if (norm(gravity.map((x, i) => x - world.gravity[i])) > 0) world.setGravity(gravity);
    find("gravity-out").textContent = `${Number(norm(world.gravity).toPrecision(3))} m/s²`;
    this.kind = find("color").value;
    this.component = this.kind === "part" ? -3 : -1;
    const [name, unit] = FIELDS[this.kind];
    find("quantity").textContent = name;
    find("ramp").style.background = gradient(false);
    this.unit = unit;
    world.peak = 0;
  }

  /** The colour range: follows a growing field at once and a dying one slowly. */
  scale(field, seconds) {
    const { world } = this;
    const end = (low, high) => {
      [find("low").textContent, find("high").textContent] = [low, high];
    };
    if (this.kind === "part") {
      end("first", "last");
      return 1;
    }
    let largest = 0;
    for (let i = 0; i < field.length; i += 3) largest = Math.max(largest, Math.hypot(field[i], field[i + 1], field[i + 2]));
    world.peak = Math.max(largest, world.peak * Math.exp(-seconds / 4));
    const still = world.peak <= 1e-9 * world.crowd.size;
    end(still ? "at rest" : "0", still ? "" : short(world.peak, this.unit));
    return still ? Infinity : world.peak;
  }

  /** The line under the bodies, a few times a second. */
  pace({ factor, frame, frames, perStep }) {
    const { world } = this;
    const { report } = world;
    find("step-time").textContent = perStep > 0 ? short(perStep, "s") : "–";
    find("factor").textContent = world.paused ? "paused" : `× ${factor.toPrecision(2)}`;
    find("frame").textContent = `${(1000 * frame).toFixed(1)} ms, ${Math.round(frames)}/s`;
    find("contacts").textContent = `${report.pressed} of ${report.contacts}`;
    find("joule").textContent = short(report.energy + report.potential, "J");
    find("time").textContent = `${report.time.toFixed(2)} s`;
    const late = world.late && !world.paused ? "Behind: this machine cannot take that many steps per second beside drawing." : "";
    const without = report.leftOut > 0 ? `No room for ${report.leftOut} contacts: more \`contacts\` under [world].` : "";
    const broken = report.jointsBroken > 0 ? `${report.jointsBroken} ${report.jointsBroken === 1 ? "joint is" : "joints are"} broken.` : "";
    const text = world.refusal || without || broken || late;
    if (find("status").textContent !== text) find("status").textContent = text;
    const [pull] = world.stage.pulls();
    find("held-force").textContent = pull ? `${world.scene.members[pull.member].name} is pulled with ${short(norm(pull.force), "N")}.` : "Press on a body to pull it.";
    const joints = world.stage.jointStates();
    this.breakers.forEach((button, joint) => (button.disabled = joints[joint].broken));
  }

  signals() {
    const { history, time } = this.world;
    const span = Number(find("span").value);
    const common = { span, now: Math.max(time, span) };
    const [total, moving, forces, contacts] = history.columns;
    drawStrip(find("energy"), history, { ...common, columns: [total, moving], names: ["with gravity", "kinetic and elastic"], unit: "J", nothing: 1e-15 }, this.style);
    drawStrip(find("forces"), history, { ...common, columns: [forces], names: [""], unit: "N", positive: true, nothing: 1e-15 }, this.style);
    drawStrip(find("counts"), history, { ...common, columns: [contacts], names: [""], unit: "", positive: true, nothing: 0 }, this.style);
  }
}

async function start() {
  const scene = JSON.parse(find("plan").textContent);
  const bytes = await files();
  const { instance } = await WebAssembly.instantiate(decode(find("wasm").textContent), {});
  const stage = staged(instance.exports, scene, bytes);
  const world = new World(stage, scene);
  const renderer = new Renderer(find("view"), world.crowd);
  const camera = new Camera(world.crowd.box, world.up);
  world.camera = camera;
  const panel = new Panel(world, renderer);
  const hands = new Pulling(find("view"), world, camera);
  find("throw").addEventListener("click", () => hands.throw());
  const share = new Share(camera, viewButtons(camera));
  const sound = new Striking(stage, scene, bytes, decode(find("ringing").textContent));
  world.heard = { strikes: (strikes) => sound.hear(strikes), rest: () => sound.silence() };
  const recorder = new Recorder(panel, sound);
  world.record();
  const page = { world, stage, scene, crowd: world.crowd, renderer, camera, panel, hands, share, sound, recorder };
  offer(page);
  let [last, pace] = [performance.now(), null];
  const tick = (now) => {
    // A page that was hidden does not catch up.
    const seconds = Math.min(Math.max((now - last) / 1000, 0), 0.1);
    last = now;
    pace = frame(page, seconds, pace ?? { wall: 0, busy: 0, frames: 0, from: world.time });
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
}

/** One frame: march, reconstruct, draw. */
function frame(page, seconds, pace) {
  const { world, stage, crowd, renderer, camera, panel, recorder } = page;
  const start = performance.now();
  panel.guarded(() => world.advance(seconds));
  const size = renderer.resize();
  const { nodes, field } = stage.surfaces(panel.kind === "v");
  const moved = crowd.place(nodes);
  camera.follow(crowd.drawn, seconds);
  camera.update(...size);
  const shown = panel.kind === "part" ? crowd.parts : field;
  renderer.fill(moved, shown);
  renderer.draw(camera, { magnification: 1, component: -1, dark: panel.dark, tool: null, scale: panel.scale(shown, seconds) });
  drawWorld(find("over"), page, find("forces-shown").checked);
  recorder.frame();
  panel.signals();
  pace.wall += seconds;
  pace.busy += (performance.now() - start) / 1000;
  pace.frames += 1;
  if (pace.wall < 0.25) return pace;
  const { spent } = world;
  page.pace = { factor: (world.time - pace.from) / pace.wall, frame: pace.busy / pace.frames, frames: pace.frames / pace.wall, perStep: spent.steps > 0 ? spent.seconds / spent.steps : 0 };
  panel.pace(page.pace);
  world.spent = { seconds: 0, steps: 0 };
  return null;
}

/** What tests and curious people may use. */
function offer(page) {
  const { world, stage, hands, scene } = page;
  const number = (name) => scene.members.findIndex((member) => member.name === name);
  Object.assign(window.vademecum, {
    ...page,
    pause: (paused = true) => world.pause(paused),
    step: (steps) => world.step(steps),
    reset: () => world.reset(),
    throw: () => hands.throw(),
    number,
    pose: (name) => stage.poses()[number(name)],
    state: () => ({ ...world.report, paused: world.paused, refusal: world.refusal, touches: world.touches, joints: stage.jointStates(), pulls: stage.pulls(), pace: page.pace }),
  });
}

window.vademecum = {};
window.vademecum.ready = start().then(() => true).catch((error) => {
  find("status").textContent = `The world cannot be shown: ${error.message}`;
  throw error;
});
