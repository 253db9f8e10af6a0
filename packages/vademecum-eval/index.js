// A body of a vademecum file, by names. The numbers come from the WebAssembly evaluator (evaluator.js); here are names, ranges, the
// loads that are held, and where the module is found. The types and what everything means: index.d.ts.
import { Evaluator, Refused, SECTION } from "./evaluator.js";

export { Refused };

/** The module of this package, compiled once. */
let own;

async function compiled(wasm) {
  if (wasm instanceof WebAssembly.Module) return wasm;
  if (wasm) return WebAssembly.compile(wasm);
  own ??= fetched(new URL("./evaluator.wasm", import.meta.url)).then((bytes) => WebAssembly.compile(bytes));
  return own;
}

async function fetched(url) {
  if (url.protocol === "file:") return (await import("node:fs/promises")).readFile(url);
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url}: ${answer.status} ${answer.statusText}; expected the evaluator's module`);
  return answer.arrayBuffer();
}

/** The place of `name` in a list of names; throws with what there is. */
function find(what, names, name) {
  const index = names.indexOf(name);
  if (index < 0) throw new Refused(`the file has no ${what} "${name}"; it has ${names.length ? names.join(", ") : "none"}`);
  return index;
}

export class Vademecum {
  #evaluator;
  #double;
  #structure;
  #values;
  #loads = [];
  #last;
  #tool = null;

  static async open(bytes, { wasm, precision = "single", parameters = {} } = {}) {
    if (precision !== "single" && precision !== "double") {
      throw new Refused(`precision is "${precision}"; expected "single" or "double"`);
    }
    const { exports } = await WebAssembly.instantiate(await compiled(wasm), {});
    const file = bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes);
    return new Vademecum(new Evaluator(exports, file), precision === "double", parameters);
  }

  /** Use `Vademecum.open`. */
  constructor(evaluator, double, parameters) {
    this.#evaluator = evaluator;
    this.#double = double;
    // The block structure alone can change the scale of a region, and a scene keeps its structure.
    const regions = evaluator.parameters.some((known) => known.region !== null);
    this.#structure = regions && evaluator.has.block ? 2 : 0;
    this.#values = new Map(evaluator.parameters.map((known) => [known.name, this.#built(known)]));
    this.#check(parameters);
    Object.entries(parameters).forEach(([name, value]) => this.#values.set(name, value));
    evaluator.bind(this.#options());
    this.#last = new Float64Array(evaluator.recordLength);
    this.counts = Object.freeze({ ...evaluator.counts });
    this.probeNames = Object.freeze(evaluator.probeNames);
    this.patternNames = Object.freeze(evaluator.patternNames);
    const described = ({ name, unit, lower, upper, nominal, log }) => Object.freeze({ name, unit, lower, upper, nominal, log });
    this.parameters = Object.freeze(evaluator.parameters.map(described));
    this.precision = double ? "double" : "single";
    this.problem = evaluator.problem;
    this.units = evaluator.units;
    this.scheme = evaluator.scheme;
  }

  /** Value of a parameter that nobody has set: scales are 1, the others as they were built. */
  #built({ key }) {
    return this.#evaluator.built[key] ?? 1;
  }

  #known(name) {
    const all = this.#evaluator.parameters;
    return all[find("parameter", all.map((known) => known.name), name)];
  }

  #check(values) {
    for (const [name, value] of Object.entries(values)) {
      const { lower, upper } = this.#known(name);
      if (!(value >= lower && value <= upper)) {
        throw new Refused(`the parameter "${name}" = ${value} is outside of its range, ${lower} to ${upper}`);
      }
    }
  }

  /** What the evaluator is bound to. */
  #options() {
    const options = { double: this.#double, structure: this.#structure };
    const scales = { regionStiffness: Array(8).fill(1), regionDensity: Array(8).fill(1) };
    for (const known of this.#evaluator.parameters) {
      const value = this.#values.get(known.name);
      if (known.region === null) options[known.key] = value;
      else scales[known.key][known.region] = value;
    }
    return { ...options, ...scales };
  }

  get timeStep() {
    return this.#evaluator.options.timeStep;
  }

  get(name) {
    this.#known(name);
    return this.#values.get(name);
  }

  set(values) {
    this.#check(values);
    const before = new Map(this.#values);
    // A new session has no sphere: it is laid down again where it is.
    const held = this.#tool && { ...this.#tool, centre: this.sphere.centre };
    Object.entries(values).forEach(([name, value]) => this.#values.set(name, value));
    try {
      this.#evaluator.rebind(this.#options(), () => this.#loads.forEach((load) => load()));
    } catch (error) {
      this.#values = before;
      throw error;
    } finally {
      if (held) this.press(held);
    }
  }

  locate(place) {
    return this.#evaluator.locate(place);
  }

  push(place, force) {
    this.#hold(() => this.#evaluator.addContact(place, force));
  }

  load(pattern, amplitude = 1) {
    const index = find("load pattern", this.patternNames, pattern);
    this.#hold(() => this.#evaluator.addPattern(index, amplitude));
  }

  #hold(load) {
    load();
    this.#loads.push(load);
  }

  release() {
    this.#loads = [];
    this.#evaluator.clearLoads();
  }

  step(steps = 1) {
    if (!Number.isSafeInteger(steps) || steps < 1 || steps > 2 ** 32 - 1) {
      throw new Refused(`${steps} steps; expected a whole number from 1 to 4294967295`);
    }
    if (steps > 1) this.#evaluator.march(steps - 1);
    const { status, rows } = this.#evaluator.record(1);
    this.#last.set(rows);
    return status === "at rest" ? "at-rest" : "moving";
  }

  get probes() {
    return this.#last.slice(0, this.probeNames.length);
  }

  probe(name) {
    return this.#last[find("probe", this.probeNames, name)];
  }

  get energy() {
    return this.#evaluator.energy();
  }

  displacement(place) {
    return this.#evaluator.point(place);
  }

  velocity(place) {
    return this.#evaluator.point(place, true);
  }

  surface(field = "displacement") {
    if (field !== "displacement" && field !== "velocity") {
      throw new Refused(`the field is "${field}"; expected "displacement" or "velocity"`);
    }
    return this.#evaluator.surface(field === "velocity");
  }

  equivalentStress() {
    return this.#evaluator.equivalentStress();
  }

  get positions() {
    return Float32Array.from(this.#section("coordinates").subarray(0, 3 * this.counts.surfaceNodes));
  }

  get triangles() {
    return this.#section("triangles");
  }

  #section(name) {
    const numbers = this.#evaluator.section(SECTION[name]);
    if (!numbers) throw new Refused(`the file has no ${name}, or they are compressed: use the file before \`strip\` or \`pack\``);
    return numbers;
  }

  save() {
    return this.#evaluator.coordinates();
  }

  restore(state) {
    if (state.length !== 2 * this.counts.modes) {
      throw new Refused(`a state of ${state.length} numbers; this body has ${2 * this.counts.modes}`);
    }
    this.#evaluator.setCoordinates(state);
  }

  rest() {
    this.#evaluator.rest();
    this.#last.fill(0);
  }

  press({ radius, friction = 0, speed, most = Infinity, centre, target = centre }) {
    this.#evaluator.holdTool({ radius, friction, speed, most, centre, target });
    this.#tool = { radius, friction, speed, most, centre, target };
  }

  moveSphere(target) {
    if (!this.#tool) throw new Refused("there is no sphere; `press` lays one down");
    this.#evaluator.moveTool(target);
    this.#tool.target = target;
  }

  liftSphere() {
    this.#tool = null;
    this.#evaluator.liftTool();
  }

  get sphere() {
    return this.#evaluator.tool();
  }
}
