// Bodies that touch and are joined, by names. The numbers come from the WebAssembly module of worlds (stage.js); here are names and refusals.
// The types and what everything means: world.d.ts.
import { Refused } from "./evaluator.js";
import { bytesOf, compiledAt } from "./module.js";
import { KINDS, Stage } from "./stage.js";

export { Refused };

/** Options of `World.create`. */
const OPTIONS = ["step", "gravity", "reach", "tolerance", "sweeps", "contacts", "wasm"];
/** Sections of a file: triangles of the surface, names of the ports. */
const TRIANGLES = 3, PORT_NAMES = 95;
const NODES = ["both", "first", "second"];

const shown = (value) => (typeof value === "string" ? `"${value}"` : Array.isArray(value) || value?.constructor === Object ? JSON.stringify(value) : String(value));

/** Numbers of a list of this length; throws with what was given. */
function numbers(what, given, length) {
  const isList = Array.isArray(given) || ArrayBuffer.isView(given);
  if (!isList || given.length !== length || !Array.from(given).every(Number.isFinite)) {
    throw new Refused(`${what} is ${shown(given)}; expected ${length} finite numbers`);
  }
  return Array.from(given);
}

function positive(what, given) {
  if (!(typeof given === "number" && given > 0 && Number.isFinite(given))) throw new Refused(`${what} is ${shown(given)}; expected a number above 0`);
  return given;
}

/** Refuses keys that there are not. */
function known(what, given, keys) {
  const slip = Object.keys(given).find((key) => !keys.includes(key));
  if (slip !== undefined) throw new Refused(`there is no ${what} "${slip}"; there are ${keys.join(", ")}`);
}

const PLACED = ["position", "rotation", "velocity", "spin", "path", "shake"];

/** Position, quaternion, velocity and angular velocity, one after the other. */
function start({ position = [0, 0, 0], rotation = [1, 0, 0, 0], velocity = [0, 0, 0], spin = [0, 0, 0] }) {
  return [...numbers("the position", position, 3), ...numbers("the rotation", rotation, 4), ...numbers("the velocity", velocity, 3), ...numbers("the spin", spin, 3)];
}

export class World {
  #stage;
  #options;
  #isBound = false;

  static async create(options) {
    known("option", options ?? {}, OPTIONS);
    const { step, gravity = [0, 0, 0], wasm } = options ?? {};
    positive("the step", step);
    numbers("gravity", gravity, 3);
    const module = await compiledAt(wasm, () => new URL("./world.wasm", import.meta.url), "World.create({ wasm })");
    const { exports } = await WebAssembly.instantiate(module, {});
    return new World(new Stage(exports, Refused), options);
  }

  /** Use `World.create`. */
  constructor(stage, options) {
    this.#stage = stage;
    this.#options = options;
  }

  /** The stage while parts can be added to it. */
  get #open() {
    if (this.#isBound) throw new Refused("the world has begun: parts, pairs and joints are added before its first step");
    return this.#stage;
  }

  /** The stage as it moves. */
  get #bound() {
    const { step, wasm, ...options } = this.#options;
    if (!this.#isBound) this.#stage.bind(step, options);
    this.#isBound = true;
    return this.#stage;
  }

  #member(member) {
    if (Number.isInteger(member) && member >= 0 && member < this.#stage.members.length) return member;
    throw new Refused(`there is no member ${shown(member)}; the world has ${this.#stage.members.length}, counted from 0`);
  }

  async open(source) {
    const bytes = await bytesOf(source);
    if (!bytes) throw new Refused(`the file is given as ${shown(source)}; expected its bytes, a URL, or an answer of fetch`);
    return this.#open.open(bytes);
  }

  add(file, options = {}) {
    known("key of a body", options, PLACED);
    const stage = this.#open;
    if (!(Number.isInteger(file) && file >= 0 && file < stage.files.length)) throw new Refused(`the file is ${shown(file)}; expected a number that \`open\` gave`);
    return this.#led(stage.addBody(file, this.#options.step, this.#options.contacts ?? 256, start(options)), options);
  }

  addRigid({ nodes, triangles, body = null, ...options }) {
    known("key of a rigid body", options, PLACED);
    const [places, corners] = [Array.from(nodes ?? []).flat(), Array.from(triangles ?? []).flat()];
    numbers("the nodes", places, 3 * Math.floor(places.length / 3));
    numbers("the triangles", corners, 3 * Math.floor(corners.length / 3));
    const { mass, centre, moments, axes = [1, 0, 0, 0, 1, 0, 0, 0, 1] } = body ?? {};
    const heavy = body && [positive("the mass", mass), ...numbers("the centre", centre, 3), ...numbers("the moments", moments, 3), ...numbers("the axes", Array.from(axes).flat(), 9)];
    return this.#led(this.#open.addRigid(places, corners, heavy, start(options)), options);
  }

  #led(member, { path, shake }) {
    if (!path && !shake) return member;
    const { amplitude = [0, 0, 0], frequency = 0, ramp = 0 } = shake ?? {};
    const stops = (path ?? []).map((stop) => numbers("a stop", stop, 4));
    if (stops.some((stop, i) => i > 0 && !(stop[0] > stops[i - 1][0]))) throw new Refused("the times of the stops ascend");
    this.#stage.lead(member, stops.flat(), [...numbers("the amplitude", amplitude, 3), frequency, ramp]);
    return member;
  }

  touch(first, second, { friction = 0, restitution = 1, nodes = "both" } = {}) {
    const which = NODES.indexOf(nodes);
    if (which < 0) throw new Refused(`nodes is ${shown(nodes)}; expected one of ${NODES.join(", ")}`);
    this.#open.addPair(this.#member(first), this.#member(second), friction, restitution, which);
  }

  join(kind, first, second, options = {}) {
    known("key of a joint", options, ["stiffness", "breaksAt", "length"]);
    if (!(kind in KINDS)) throw new Refused(`there is no joint ${shown(kind)}; there are ${Object.keys(KINDS).join(", ")}`);
    const { stiffness, breaksAt, length = 0 } = options;
    const compliance = stiffness === undefined ? 0 : 1 / positive("the stiffness", stiffness);
    const bears = breaksAt === undefined ? -1 : positive("breaksAt", breaksAt);
    const sides = [first, second].map(({ member, port, at, axes }) => Stage.side(this.#anchor(this.#member(member), { port, at, axes })));
    return this.#open.addJoint(KINDS[kind], first.member, second.member, [compliance, bears, length, ...sides.flat()]);
  }

  #anchor(member, { port, at, axes }) {
    const { file } = this.#stage.members[member];
    if (file === null) return { at: numbers("the point of a rigid body", at, 3), axes: axes && numbers("its axes", Array.from(axes).flat(), 9) };
    const names = new TextDecoder().decode(this.#stage.section(file, PORT_NAMES) ?? new Uint8Array()).split("\n").filter((name) => name);
    const number = names.indexOf(port);
    if (number < 0) throw new Refused(`the file has no port ${shown(port)}; it has ${names.length ? names.join(", ") : "none"}`);
    return { port: number };
  }

  step(steps = 1) {
    if (!Number.isSafeInteger(steps) || steps < 1 || steps > 2 ** 32 - 1) throw new Refused(`${shown(steps)} steps; expected a whole number from 1 to 4294967295`);
    this.#bound.step(steps);
    return this.report;
  }

  get report() {
    return this.#bound.report();
  }

  get members() {
    return this.#stage.members.map(({ first, nodes, file }, member) => ({ first, nodes, file, mass: this.#stage.mass(member) }));
  }

  surfaces(field = "displacement") {
    if (field !== "displacement" && field !== "velocity") throw new Refused(`the field is ${shown(field)}; expected "displacement" or "velocity"`);
    return this.#bound.surfaces(field === "velocity");
  }

  triangles(member) {
    const { file } = this.#stage.members[this.#member(member)];
    return file === null ? null : this.#stage.section(file, TRIANGLES);
  }

  get poses() {
    return this.#stage.poses();
  }

  get touches() {
    return this.#bound.touches();
  }

  get joints() {
    return this.#bound.jointStates();
  }

  pull(hand, member, grip, { target, stiffness, damping = 0 }) {
    const held = Array.isArray(grip) ? numbers("the point", grip, 3) : grip;
    this.#bound.pull(hand, this.#member(member), held, { target: numbers("the target", target, 3), stiffness: positive("the stiffness", stiffness), damping });
  }

  movePull(hand, target) {
    if (!this.#bound.movePull(hand, numbers("the target", target, 3))) throw new Refused(`there is no hand ${shown(hand)}; \`pull\` lays one on a member`);
  }

  release(hand) {
    this.#bound.release(hand);
  }

  get pulls() {
    return this.#bound.pulls();
  }

  throw(member, velocity, spin = [0, 0, 0]) {
    this.#bound.throw(this.#member(member), numbers("the velocity", velocity, 3), numbers("the spin", spin, 3));
  }

  breakJoint(joint) {
    this.#bound.breakJoint(joint);
  }

  setGravity(gravity) {
    this.#bound.setGravity(numbers("gravity", gravity, 3));
  }

  save() {
    return this.#bound.save();
  }

  restore(state) {
    if (!(state instanceof Uint8Array)) throw new Refused(`the state is ${shown(state)}; expected the Uint8Array that \`save\` gave`);
    this.#bound.restore(state);
  }

  reset() {
    this.#bound.reset();
  }
}
