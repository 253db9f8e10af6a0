// The evaluator's WebAssembly module as a JavaScript object. No mechanics here: every number comes from the module.
// Memory: the module's memory only grows; the file and each buffer stay where they are put (see `Lent`).

const PAGE = 65536;

/** Section numbers of the file format (formats/vademecum-1.md). */
export const SECTION = {
  coordinates: 2, triangles: 3, stiffness: 4, eigenvalues: 5, surfaceBasis: 6, patternNames: 12, probeNames: 13,
  modeTable: 16, dampingRatios: 33, staticBound: 40, boundMap: 41, stressPoints: 47, elasticConstants: 51, supportNames: 53, rigidBody: 59,
  embeddedNodes: 76, embeddedWeights: 77, embeddedTriangles: 78, quadrangles: 80,
};

/** Nodes of a place at most. */
const MAX_NODES = 16;

/** Scales of the regions, as built. */
const ONES = Array(8).fill(1);

const ELEMENTS = { 0: Uint8Array, 1: Uint32Array, 3: Float32Array, 4: Float64Array };

/** A range of the module's memory that grows when more is asked of it. */
class Lent {
  constructor(memory) {
    this.memory = memory;
    this.at = 0;
    this.length = 0;
  }

  /** Address of a range of at least `bytes`; what was in it may be gone. */
  hold(bytes) {
    if (bytes > this.length) {
      const pages = Math.ceil(bytes / PAGE);
      this.at = this.memory.grow(pages) * PAGE;
      this.length = pages * PAGE;
    }
    return this.at;
  }
}

/** What the evaluator refused, in its own words. */
export class Refused extends Error {}

export class Evaluator {
  /** Compiles the module and opens the file; throws `Refused` if it is not sound. */
  static async open(wasm, file) {
    const { instance } = await WebAssembly.instantiate(wasm, {});
    return new Evaluator(instance.exports, file);
  }

  constructor(exports, file) {
    this.wasm = exports;
    this.lent = { body: new Lent(exports.memory), records: new Lent(exports.memory), numbers: new Lent(exports.memory) };
    const at = new Lent(exports.memory).hold(Math.max(file.length, 1));
    new Uint8Array(exports.memory.buffer, at, file.length).set(file);
    this.must(exports.open(at, file.length));
    this.describe();
    // Its modes, and so many sections, are those at values of the parameters.
    if (this.has.parametric) this.bind({});
  }

  /** Throws the module's last sentence unless `done`. */
  must(done) {
    if (done) return done;
    const { message_at, message_len, memory } = this.wasm;
    const bytes = new Uint8Array(memory.buffer, message_at(), message_len());
    throw new Refused(new TextDecoder().decode(bytes) || "nothing is bound");
  }

  /** The module's exchange buffer; a new view each time, since growing memory ends old ones. */
  exchange(length) {
    return new Float64Array(this.wasm.memory.buffer, this.wasm.exchange(), length);
  }

  describe() {
    this.must(this.wasm.describe());
    const [nodes, surfaceNodes, loadNodes, triangles, loadTriangles, modes, patterns, probes, terms, diagonal, block, parameters,
      timeStep, alpha, beta, diagonalError, diagonalFloor, blockError, blockFloor, parametric] = this.exchange(20);
    this.counts = { nodes, surfaceNodes, loadNodes, triangles, loadTriangles, modes, patterns, probes, terms };
    this.has = { diagonal: diagonal === 1, block: block === 1, parametric: parametric === 1 };
    this.built = { timeStep, alpha, beta };
    this.certificate = {
      diagonal: { error: diagonalError, floor: diagonalFloor }, block: { error: blockError, floor: blockFloor },
    };
    [this.program, this.problem, this.units, this.scheme] = [0, 1, 2, 3].map((which) => this.text(which));
    this.exact = this.scheme === "exact";
    this.parameters = Array.from({ length: parameters }, (_, index) => this.parameter(index)).filter((known) => known);
    this.tabulate();
    this.probeNames = this.names(SECTION.probeNames);
    this.patternNames = this.names(SECTION.patternNames);
    this.supportNames = this.names(SECTION.supportNames);
  }

  /** What can be read, as the evaluator's table says; how many and how long once something is bound. */
  tabulate() {
    this.quantities = [];
    while (this.wasm.quantity(this.quantities.length)) {
      const [nameAt, nameLength, unitAt, unitLength, rateAt, rateLength, textAt, textLength, count, length, total] = this.exchange(11);
      const row = { number: this.quantities.length, name: this.utf8(nameAt, nameLength), unit: this.utf8(unitAt, unitLength), count, length };
      this.quantities.push({ ...row, velocityUnit: this.utf8(rateAt, rateLength), text: this.utf8(textAt, textLength), total: total === 1 });
    }
    /** Scalars of the whole body. */
    this.totals = this.quantities.filter(({ total }) => total);
  }

  text(which) {
    const at = this.wasm.text(which);
    return this.utf8(at, this.exchange(1)[0]);
  }

  utf8(at, length) {
    return new TextDecoder().decode(new Uint8Array(this.wasm.memory.buffer, at, length));
  }

  /** A live parameter of the file: name, unit, the option it sets (with the region, if it is of one), range. */
  parameter(index) {
    if (!this.wasm.parameter(index)) return null;
    const [nameAt, nameLength, unitAt, unitLength, role, region, log, lower, upper, nominal] = this.exchange(10);
    const key = ["stiffness", "regionStiffness", "density", "regionDensity", "alpha", "beta", "timeStep", "lossFactor", "damping"][role];
    const ofRegion = [1, 3, 7, 8].includes(role) ? region : null;
    return { index, name: this.utf8(nameAt, nameLength), unit: this.utf8(unitAt, unitLength), key, region: ofRegion, log: log === 1, lower, upper, nominal };
  }

  /** A copy of a section's numbers (bytes for text); null if absent or compressed. */
  section(kind) {
    const at = this.wasm.section(kind);
    if (at === 0) return null;
    const [length, element] = this.exchange(2);
    return new ELEMENTS[element](this.wasm.memory.buffer.slice(at, at + length));
  }

  names(kind) {
    const bytes = this.section(kind);
    return bytes && bytes.length ? new TextDecoder().decode(bytes).split("\n") : [];
  }

  /**
   * Binds the file: `{ double, structure (0 chosen, 1 diagonal, 2 block, 4 exact), timeStep [s], stiffness, density, alpha [1/s],
   * beta [s], restBelow, regionStiffness, regionDensity (8 scales each), values (of all parameters of a parametric file) }`. The body
   * is at rest and unloaded afterwards. A refusal throws and leaves nothing bound.
   */
  bind(options) {
    const o = { double: false, structure: 0, stiffness: 1, density: 1, restBelow: 0, regionStiffness: ONES, regionDensity: ONES, ...this.built, ...options };
    const numbers = [o.structure, o.timeStep, o.stiffness, o.density, o.alpha, o.beta, o.restBelow, ...o.regionStiffness, ...o.regionDensity];
    const double = o.double ? 1 : 0;
    this.exchange(numbers.length).set(numbers);
    const at = this.lent.body.hold(this.must(this.wasm.bind_len(double)));
    this.structure = this.must(this.wasm.bind(double, at));
    this.options = o;
    if (this.has.parametric) {
      o.values = this.parameters.map(({ nominal }) => nominal);
      if (options.values) this.put(this.changed(options.values));
    }
    this.recordLength = this.wasm.record_len();
    this.tabulate();
  }

  /** Value that a parameter of the file stands at. */
  value({ key, region, index }) {
    if (this.has.parametric && index !== undefined) return this.options.values[index];
    const option = this.options[key];
    return region === null ? option : option[region];
  }

  /** Sets parameters of the file, `[index, value]` each, where the body is; `load` puts the loads back. */
  setParameters(settings, load) {
    this.put(settings);
    this.clear();
    load();
  }

  /** Sets parameters; loads are stale afterwards. */
  put(settings) {
    this.exchange(2 * settings.length).set(settings.flat());
    this.must(this.wasm.set_parameters(settings.length));
    for (const [index, value] of settings) Object.assign(this.options, this.option(this.parameters.find((known) => known.index === index), value));
  }

  /** `[index, value]` of the parameters of a parametric file that other values than theirs are asked of. */
  changed(values) {
    return values.map((value, index) => [index, value]).filter(([index, value]) => value !== this.options.values[index]);
  }

  /** The option that puts a parameter to `value`. */
  option({ key, region, index }, value) {
    if (this.has.parametric && index !== undefined) {
      // Factors of the whole body are in the file at these values; an option would count them twice.
      const whole = ["alpha", "beta", "timeStep"].includes(key) ? { [key]: value } : {};
      return { ...whole, values: this.options.values.map((x, place) => (place === index ? value : x)) };
    }
    return { [key]: region === null ? value : this.options[key].map((x, q) => (q === region ? value : x)) };
  }

  /** Binds other options and carries displacement and velocity over; `load` puts the loads back before the body goes on. */
  rebind(options, load) {
    const { values, ...others } = options;
    if (values) {
      this.setParameters(this.changed(values), load);
      if (Object.entries(others).every(([key, value]) => value === this.options[key])) return;
    }
    const before = this.options;
    const state = this.coordinates();
    let refusal = null;
    try {
      this.bind({ ...before, ...others });
    } catch (error) {
      refusal = error;
      this.bind(before);
    }
    load();
    this.setCoordinates(state);
    if (refusal) throw refusal;
  }

  clear() {
    this.wasm.clear();
  }

  /** Hands a place `{ nodes, weights, radius }` over; the number of its nodes. */
  place({ nodes, weights, radius = 0 }) {
    const numbers = this.exchange(2 * MAX_NODES + 1);
    const count = Math.min(nodes.length, MAX_NODES);
    for (let i = 0; i < count; i++) [numbers[i], numbers[MAX_NODES + i]] = [nodes[i], weights[i]];
    numbers[2 * MAX_NODES] = radius;
    return nodes.length;
  }

  /** A held force [N] at a place of the loadable surface. */
  push(place, force) {
    this.must(this.wasm.push(this.place(place), ...force));
  }

  pushPattern(index, amplitude) {
    this.must(this.wasm.push_pattern(index, amplitude));
  }

  /** Records the displacement of a place along `direction` beside the probes. */
  watch(place, direction) {
    this.must(this.wasm.watch(this.place(place), ...direction));
  }

  /** Takes `steps` steps without looking; "moving" or "at rest". */
  march(steps) {
    return this.must(this.wasm.march(steps, 0, 0)) === 2 ? "at rest" : "moving";
  }

  /** Takes `steps` steps; rows of (probes, watched component, scalars of the whole body as in `totals`), good until the next call. */
  record(steps) {
    const length = steps * this.recordLength;
    const at = this.lent.records.hold(Math.max(8 * length, 8));
    const status = this.must(this.wasm.march(steps, at, steps)) === 2 ? "at rest" : "moving";
    return { status, rows: new Float64Array(this.wasm.memory.buffer, at, length) };
  }

  /** Displacement [m] or velocity [m/s] of the surface nodes, three each, in the body's precision; good until the next call. */
  surface(velocity = false) {
    const at = this.must(this.wasm.surface(velocity ? 1 : 0));
    const length = 3 * this.counts.surfaceNodes;
    return new (this.options.double ? Float64Array : Float32Array)(this.wasm.memory.buffer, at, length);
  }

  /** Von Mises' equivalent stress [Pa] of the surface nodes: the first of three numbers each, zero where the file has none; good until the next call. */
  equivalentStress() {
    const at = this.must(this.wasm.equivalent_stress());
    return new Float64Array(this.wasm.memory.buffer, at, 3 * this.counts.surfaceNodes);
  }

  /** Displacement or velocity of a place. */
  point(place, velocity = false) {
    this.must(this.wasm.point(this.place(place), velocity ? 1 : 0));
    return Array.from(this.exchange(3));
  }

  /** A quantity, as its row in `quantities` says, or its velocity; good until the next call. */
  read({ number, length }, index = 0, velocity = false) {
    const at = this.lent.numbers.hold(Math.max(8 * length, 8));
    this.must(this.wasm.read(number, index, velocity ? 1 : 0, at, length));
    return new Float64Array(this.wasm.memory.buffer, at, length);
  }

  /** The loadable point nearest to a place [m]; throws `Refused` if nothing is loadable, or it is further away than the body is large. */
  locate(place) {
    this.must(this.wasm.locate(...place));
    const [count, ...n] = this.exchange(5 + 2 * MAX_NODES);
    const [at, end] = [2 * count, 2 * count + 3];
    return { nodes: n.slice(0, count), weights: n.slice(count, at), position: n.slice(at, end), distance: n[end] };
  }

  /** Kinetic and elastic energy [J]: the first scalar of the whole body. */
  energy() {
    return this.read(this.totals[0])[0];
  }

  /** The state as tagged bytes: a copy. */
  save() {
    const length = this.must(this.wasm.saved_len());
    const at = this.lent.numbers.hold(length);
    const written = this.must(this.wasm.save(at, length));
    return new Uint8Array(this.wasm.memory.buffer.slice(at, at + written));
  }

  /** Takes back what `save` gave; whether it was carried over from other parameters or the other precision. */
  restore(bytes) {
    const at = this.lent.numbers.hold(Math.max(bytes.length, 1));
    new Uint8Array(this.wasm.memory.buffer, at, bytes.length).set(bytes);
    return this.must(this.wasm.restore(at, bytes.length)) === 2;
  }

  /** ζ [m kg^½], then ζ̇ [m kg^½/s]: a copy. */
  coordinates() {
    const length = 2 * this.counts.modes;
    const at = this.lent.numbers.hold(8 * length);
    this.must(this.wasm.coordinates(at, length));
    return new Float64Array(this.wasm.memory.buffer.slice(at, at + 8 * length));
  }

  /** Sets ζ and ζ̇; the acceleration follows from them and the loads. */
  setCoordinates(values) {
    const at = this.lent.numbers.hold(8 * values.length);
    new Float64Array(this.wasm.memory.buffer, at, values.length).set(values);
    this.must(this.wasm.set_coordinates(at, values.length));
  }

  rest() {
    this.wasm.rest();
  }

  /** Lays a sphere down that cannot enter the body, `{ radius [m], friction, speed [m/s], most [N], centre, target [m] }`; throws `Refused` where steps are not exact. */
  holdTool({ radius, friction, speed, most = Infinity, centre, target }) {
    this.must(this.wasm.hold_tool(radius, friction, speed, most, ...centre));
    this.wasm.move_tool(...(target ?? centre));
  }

  /** Where the sphere is to go; nothing without a sphere. */
  moveTool(target) {
    this.wasm.move_tool(...target);
  }

  liftTool() {
    this.wasm.lift_tool();
  }

  /** What the sphere did in the last step: centre, deepest place inside of it [m], whether all forces were found, and each push; null without one. */
  tool() {
    if (!this.wasm.tool()) return null;
    const [x, y, z, deepest, solved, count, ...numbers] = this.exchange(54);
    const touches = Array.from({ length: count }, (_, k) => ({ place: numbers.slice(6 * k, 6 * k + 3), force: numbers.slice(6 * k + 3, 6 * k + 6) }));
    return { centre: [x, y, z], deepest, solved: solved === 1, touches };
  }
}
