// The WebAssembly module of worlds as a JavaScript object. No mechanics here: every number comes from the module.
// Memory: what is lent to the module (files, surfaces, ways) stays where it is put for ever, since a world lives as long as its module.

const ELEMENTS = { 0: Uint8Array, 1: Uint32Array, 3: Float32Array, 4: Float64Array };

/** Nodes of a place at most, and where the module finds target, stiffness and damping of a hand. */
const MAX_NODES = 16, HAND = 40;

/** The axes of a point of a rigid body. */
const UNITS = [1, 0, 0, 0, 1, 0, 0, 0, 1];

/** A part that stands where its file has it. */
const STILL = [0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];

/** Numbers of the kinds of joints. */
export const KINDS = { ball: 0, hinge: 1, slider: 2, cable: 3 };

export class Stage {
  /** `exports` of an instance of the module; refusals throw an error of the class `Refused`. */
  constructor(exports, Refused = Error) {
    Object.assign(this, { wasm: exports, Refused, files: [], members: [], joints: [], nodes: 0 });
  }

  /** Throws the module's last sentence unless `done`. */
  must(done) {
    if (done) return done;
    const { message_at, message_len, memory } = this.wasm;
    const bytes = new Uint8Array(memory.buffer, message_at(), message_len());
    throw new this.Refused(new TextDecoder().decode(bytes) || "the world refused");
  }

  /** The module's exchange buffer; a new view each time, since growing memory ends old ones. */
  exchange(length) {
    return new Float64Array(this.wasm.memory.buffer, this.wasm.exchange(), length);
  }

  /** Numbers of the last long answer: a copy. */
  answer(length) {
    return new Float64Array(this.wasm.memory.buffer, this.wasm.answer(), length).slice();
  }

  /** Puts numbers into memory that is lent for ever; their address. */
  lend(numbers) {
    const at = this.wasm.lend(Math.max(numbers.byteLength, 8));
    new numbers.constructor(this.wasm.memory.buffer, at, numbers.length).set(numbers);
    return at;
  }

  /** Opens a file; its number. */
  open(bytes) {
    const file = this.must(this.wasm.open(this.lend(bytes), bytes.length)) - 1;
    this.must(this.wasm.describe(file));
    const [surfaceNodes, loadNodes, triangles, loadTriangles, modes, timeStep] = this.exchange(6);
    this.files.push({ surfaceNodes, loadNodes, triangles, loadTriangles, modes, timeStep });
    return file;
  }

  /** A copy of a section's numbers (bytes for text) of a file; null if absent or compressed. */
  section(file, kind) {
    const at = this.wasm.section(file, kind);
    if (at === 0) return null;
    const [length, element] = this.exchange(2);
    return new ELEMENTS[element](this.wasm.memory.buffer.slice(at, at + length));
  }

  /** Adds a body of a file; `start` are position, quaternion, velocity and angular velocity, one after the other. Its number. */
  addBody(file, timeStep, contacts, start = STILL) {
    this.exchange(13).set(start);
    const member = this.must(this.wasm.add_body(file, timeStep, contacts)) - 1;
    this.member({ file, nodes: this.files[file].surfaceNodes });
    return member;
  }

  /** Adds a rigid body of flat lists of nodes [m] and triangles; `mass` are mass, centre, moments and axes of one that moves. Its number. */
  addRigid(nodes, triangles, mass = null, start = STILL) {
    const [places, corners] = [this.lend(Float64Array.from(nodes)), this.lend(Uint32Array.from(triangles))];
    this.exchange(29).set([...start, ...(mass ?? [])]);
    const member = this.must(this.wasm.add_rigid(places, nodes.length / 3, corners, triangles.length / 3, mass ? 1 : 0)) - 1;
    this.member({ file: null, nodes: nodes.length / 3 });
    return member;
  }

  member({ file, nodes }) {
    this.members.push({ file, first: this.nodes, nodes });
    this.nodes += nodes;
  }

  /** A pair that may touch; `nodes` are those of both (0), the first (1) or the second (2). */
  addPair(a, b, friction = 0, restitution = 1, nodes = 0) {
    this.wasm.add_pair(a, b, friction, restitution, nodes);
  }

  /** A joint; `numbers` are compliance, force at which it breaks (below 0 for none), length, and 13 for each side. */
  addJoint(kind, a, b, numbers) {
    this.exchange(numbers.length).set(numbers);
    this.wasm.add_joint(kind, a, b);
    this.joints.push({ kind, members: [a, b] });
    return this.joints.length - 1;
  }

  /** The 13 numbers of a side of a joint: a port by its number, or a point of a rigid body. */
  static side({ port = -1, at = [0, 0, 0], axes = UNITS }) {
    return [port, ...at, ...axes];
  }

  /** Leads a member: flat stops (time, displacement) and amplitude, frequency and ramp of a shake. */
  lead(member, stops = [], shake = [0, 0, 0, 0, 0]) {
    const at = this.lend(Float64Array.from(stops));
    this.exchange(5).set(shake);
    this.must(this.wasm.lead(member, at, stops.length / 4));
  }

  bind(timeStep, { gravity = [0, 0, 0], reach = -1, tolerance = -1, sweeps = 200, contacts = 256 } = {}) {
    this.exchange(7).set([...gravity, reach, tolerance, sweeps, contacts]);
    this.must(this.wasm.bind(timeStep));
    this.timeStep = timeStep;
    this.drawn = ["nodes", "field"].map(() => this.wasm.lend(12 * this.nodes));
  }

  step(steps = 1) {
    this.must(this.wasm.step(steps));
  }

  report() {
    this.must(this.wasm.report());
    const [time, contacts, pressed, leftOut, sweeps, converged, deepest, givenAway, jointsBroken, energy, potential] = this.exchange(11);
    return { time, contacts, pressed, leftOut, sweeps, converged: converged === 1, deepest, givenAway, jointsBroken, energy, potential };
  }

  /** Contacts of the last step that carry a force. */
  touches() {
    const count = this.wasm.touches();
    const numbers = this.answer(9 * count);
    return Array.from({ length: count }, (_, i) => {
      const [a, b, x, y, z, fx, fy, fz, pressure] = numbers.subarray(9 * i, 9 * i + 9);
      return { members: [a, b], place: [x, y, z], force: [fx, fy, fz], pressure };
    });
  }

  /** Force on the first member of each joint [N], and whether it is broken. */
  jointStates() {
    const count = this.wasm.joints();
    const numbers = this.answer(4 * count);
    return Array.from({ length: count }, (_, i) => ({ force: Array.from(numbers.subarray(4 * i, 4 * i + 3)), broken: numbers[4 * i + 3] === 1 }));
  }

  /** Impulses in space [N s] at which members began to be touched, since the last call. */
  strikes() {
    const numbers = this.answer(this.wasm.strikes());
    const heard = [];
    for (let i = 0; i < numbers.length; ) {
      const [member, x, y, z, count] = numbers.subarray(i, i + 5);
      const [nodes, weights] = [0, 1].map((part) => Array.from(numbers.subarray(i + 5 + part * count, i + 5 + (part + 1) * count)));
      heard.push({ member, impulse: [x, y, z], place: { nodes, weights } });
      i += 5 + 2 * count;
    }
    return heard;
  }

  /** Place of the origin [m] and quaternion of each member. */
  poses() {
    const count = this.wasm.poses();
    const numbers = this.answer(7 * count);
    return Array.from({ length: count }, (_, i) => ({ position: Array.from(numbers.subarray(7 * i, 7 * i + 3)), rotation: Array.from(numbers.subarray(7 * i + 3, 7 * i + 7)) }));
  }

  /** Mass of a member that moves freely [kg]; 0 of any other. */
  mass(member) {
    return this.wasm.mass(member);
  }

  /**
   * Nodes of all surfaces in space [m], one member after the other (`members` has the first of each), and their displacement in the body or
   * velocity in space, three numbers each; good until the next call.
   */
  surfaces(velocity = false) {
    const [nodes, field] = this.drawn;
    this.must(this.wasm.surfaces(velocity ? 1 : 0, nodes, field, this.nodes));
    const view = (at) => new Float32Array(this.wasm.memory.buffer, at, 3 * this.nodes);
    return { nodes: view(nodes), field: view(field) };
  }

  /** Lays hand `hand` on a member: at a place `{ nodes, weights }` of a body of a file, or at a point of a rigid one. */
  pull(hand, member, grip, { target, stiffness, damping = 0 }) {
    const numbers = this.exchange(HAND + 5);
    numbers.fill(0);
    const isPlace = !Array.isArray(grip);
    if (isPlace) grip.nodes.forEach((node, i) => ([numbers[i], numbers[MAX_NODES + i]] = [node, grip.weights[i]]));
    else numbers.set(grip);
    numbers.set([...target, stiffness, damping], HAND);
    this.must(this.wasm.pull(hand, member, isPlace ? grip.nodes.length : 0));
  }

  movePull(hand, target) {
    return this.wasm.move_pull(hand, ...target) === 1;
  }

  release(hand) {
    this.wasm.release(hand);
  }

  /** The hands: number, member, where each holds, where it is [m], and its force in the last step [N]. */
  pulls() {
    const count = this.wasm.pulls();
    const numbers = this.answer(11 * count);
    return Array.from({ length: count }, (_, i) => {
      const [hand, member, ...rest] = numbers.subarray(11 * i, 11 * i + 11);
      return { hand, member, place: rest.slice(0, 3), target: rest.slice(3, 6), force: rest.slice(6, 9) };
    });
  }

  throw(member, velocity, spin = [0, 0, 0]) {
    this.exchange(6).set([...velocity, ...spin]);
    this.must(this.wasm.throw(member));
  }

  breakJoint(joint) {
    this.must(this.wasm.break_joint(joint));
  }

  setGravity(gravity) {
    this.must(this.wasm.set_gravity(...gravity));
  }

  /** The state of all: a copy. */
  save() {
    const length = this.must(this.wasm.save());
    const at = this.wasm.bytes();
    return new Uint8Array(this.wasm.memory.buffer.slice(at, at + length));
  }

  /** Takes back what `save` gave. */
  restore(bytes) {
    if (!(this.lent?.length >= bytes.length)) this.lent = { at: this.wasm.lend(bytes.length), length: bytes.length };
    new Uint8Array(this.wasm.memory.buffer, this.lent.at, bytes.length).set(bytes);
    this.must(this.wasm.restore(this.lent.at, bytes.length));
  }

  /** Starts over. */
  reset() {
    this.must(this.wasm.reset());
  }
}

/** A stage with everything of a scene, as `vademecum view` writes it, and its files. */
export function staged(exports, scene, files, Refused) {
  const stage = new Stage(exports, Refused);
  files.forEach((bytes) => stage.open(bytes));
  for (const { file, nodes, triangles, mass, start, stops, shake } of scene.members) {
    const member = file === null ? stage.addRigid(nodes.flat(), triangles.flat(), mass, start) : stage.addBody(file, scene.step, scene.contacts, start);
    if (stops) stage.lead(member, stops.flat(), shake);
  }
  for (const pair of scene.pairs) stage.addPair(...pair);
  for (const { kind, members, numbers } of scene.joints) stage.addJoint(kind, ...members, numbers);
  const given = Object.fromEntries(["gravity", "reach", "tolerance", "sweeps", "contacts"].map((key) => [key, scene[key]]).filter(([, value]) => value !== null));
  stage.bind(scene.step, given);
  return stage;
}
