// A body of a vademecum file, by names. The numbers come from the WebAssembly evaluator (evaluator.js); here are names, refusals, and
// the loads that are held. The types and what everything means: index.d.ts.
import { Evaluator, Refused, SECTION } from "./evaluator.js";
import { bytesOf, compiled } from "./module.js";

export { Refused };

/** Options that scale the whole body, or set its Rayleigh damping. */
const WHOLE = ["stiffness", "density", "alpha", "beta"];

/** Options of `Body.open`. */
const OPTIONS = ["wasm", "precision", "parameters", ...WHOLE];

/** The place of `name` in a list of names; throws with what there is. */
function find(what, names, name) {
  const index = names.indexOf(name);
  if (index < 0) throw new Refused(`the file has no ${what} "${name}"; it has ${names.length ? names.join(", ") : "none"}`);
  return index;
}

/** A value as a message shows it. */
function shown(value) {
  if (typeof value === "string") return `"${value}"`;
  const isPlain = Array.isArray(value) || value?.constructor === Object;
  return isPlain ? JSON.stringify(value) : ArrayBuffer.isView(value) ? `${value.constructor.name} [${value}]` : String(value);
}

/** Three numbers; throws with what was given. Whether they are finite is checked where they are used. */
function vector(what, given) {
  const isList = Array.isArray(given) || ArrayBuffer.isView(given);
  if (!isList || given.length !== 3 || !Array.from(given).every((x) => typeof x === "number")) {
    throw new Refused(`${what} is ${shown(given)}; expected three numbers, such as [0, 0, 1]`);
  }
  return given;
}

/** A place, as `locate` gives it. */
function placed(given) {
  const { nodes, weights, radius = 0 } = given ?? {};
  const isSound = nodes && weights && nodes.length === weights.length && Array.from(nodes).every((node) => Number.isInteger(node) && node >= 0);
  if (!isSound || !Array.from(weights).every((x) => typeof x === "number") || typeof radius !== "number") {
    throw new Refused(`the place is ${shown(given)}; expected nodes and as many weights, as \`locate\` gives them`);
  }
  return given;
}

/** Whether a field is the velocity. */
function isVelocity(field) {
  if (field === "displacement" || field === "velocity") return field === "velocity";
  throw new Refused(`the field is ${shown(field)}; expected "displacement" or "velocity"`);
}

/** The bytes of a file, wherever they are; throws for what is none. */
async function opened(given) {
  const bytes = await bytesOf(given);
  if (bytes) return bytes;
  const how = "expected its bytes (ArrayBuffer or Uint8Array), a URL, or an answer of fetch: `Body.open(fetch(path))`, or `readFileSync(path)` in Node";
  throw new Refused(`the file is given as ${shown(given)}; ${how}`);
}

export class Body {
  #evaluator;
  #rows;
  #loads = [];
  #tool = false;

  static async open(source, options = {}) {
    const { wasm, precision = "single", parameters = {} } = options;
    const slip = Object.keys(options).find((name) => !OPTIONS.includes(name));
    if (slip !== undefined) throw new Refused(`there is no option "${slip}"; there are ${OPTIONS.join(", ")}`);
    if (precision !== "single" && precision !== "double") {
      throw new Refused(`precision is ${shown(precision)}; expected "single" or "double"`);
    }
    const wrong = WHOLE.find((name) => options[name] !== undefined && typeof options[name] !== "number");
    if (wrong) throw new Refused(`${wrong} is ${shown(options[wrong])}; expected a number`);
    const file = await opened(source);
    const { exports } = await WebAssembly.instantiate(await compiled(wasm), {});
    const evaluator = new Evaluator(exports, file);
    // Where the file has a live parameter of that name, it is meant, with its range.
    const whole = WHOLE.filter((name) => options[name] !== undefined).map((name) => [name, options[name]]);
    const isLive = ([name]) => evaluator.parameters.some((known) => known.name === name);
    const body = new Body(evaluator, precision, Object.fromEntries(whole.filter((pair) => !isLive(pair))));
    body.setParameters({ ...Object.fromEntries(whole.filter(isLive)), ...parameters });
    return body;
  }

  /** Use `Body.open`. */
  constructor(evaluator, precision, whole) {
    this.#evaluator = evaluator;
    // The block structure alone can change the scale of a region, and a body keeps its structure.
    const regions = evaluator.parameters.some((known) => known.region !== null);
    evaluator.bind({ double: precision === "double", structure: regions && evaluator.has.block ? 2 : 0, ...whole });
    this.#rows = new Map(evaluator.quantities.map((row) => [row.name, row]));
    this.precision = precision;
    const { counts, probeNames, patternNames, supportNames, problem, units, scheme } = evaluator;
    const row = ({ name, unit, velocityUnit, text, count, length }) => Object.freeze({ name, unit, velocityUnit, text, count, length });
    this.quantities = Object.freeze(evaluator.quantities.map(row));
    Object.assign(this, { counts: Object.freeze({ ...counts }), problem, units, scheme });
    for (const [name, names] of Object.entries({ probeNames, patternNames, supportNames })) this[name] = Object.freeze(names);
  }

  get timeStep() {
    return this.#evaluator.options.timeStep;
  }

  get parameters() {
    const described = ({ name, unit, lower, upper, nominal, log }) => ({ name, unit, lower, upper, nominal, log });
    return this.#evaluator.parameters.map((known) => ({ ...described(known), value: this.#evaluator.value(known) }));
  }

  setParameters(values) {
    if (values === null || typeof values !== "object" || Array.isArray(values)) {
      throw new Refused(`the parameters are ${shown(values)}; expected an object of names and values, such as { stiffness: 2 }`);
    }
    const known = this.#evaluator.parameters;
    const option = Object.keys(values).find((name) => WHOLE.includes(name) && !known.some((parameter) => parameter.name === name));
    if (option) throw new Refused(`the file has no live parameter "${option}"; that of the whole body is an option of Body.open`);
    const settings = Object.entries(values).map(([name, value]) => {
      const place = find("parameter", known.map((parameter) => parameter.name), name);
      const { index, lower, upper } = known[place];
      if (typeof value !== "number" || !(value >= lower && value <= upper)) {
        throw new Refused(`the parameter "${name}" = ${shown(value)} is outside of its range, ${lower} to ${upper}`);
      }
      return [index, value];
    });
    if (settings.length > 0) this.#evaluator.setParameters(settings, () => this.#loads.forEach((load) => load()));
  }

  locate(point) {
    return this.#evaluator.locate(vector("the point", point));
  }

  push(place, force) {
    const [held, along] = [placed(place), vector("the force", force)];
    this.#hold(() => this.#evaluator.push(held, along));
  }

  pushPattern(name, amplitude = 1) {
    const index = find("load pattern", this.patternNames, name);
    if (typeof amplitude !== "number") throw new Refused(`the amplitude is ${shown(amplitude)}; expected a number`);
    this.#hold(() => this.#evaluator.pushPattern(index, amplitude));
  }

  #hold(load) {
    load();
    this.#loads.push(load);
  }

  clear() {
    this.#loads = [];
    this.#evaluator.clear();
  }

  step(steps = 1) {
    if (!Number.isSafeInteger(steps) || steps < 1 || steps > 2 ** 32 - 1) {
      throw new Refused(`${shown(steps)} steps; expected a whole number from 1 to 4294967295`);
    }
    return this.#evaluator.march(steps) === "at rest" ? "at-rest" : "moving";
  }

  read(quantity, index = 0, field = "displacement") {
    return this.#read(quantity, index, field).slice();
  }

  /** A view of the module's memory. */
  #read(quantity, index, field) {
    const velocity = isVelocity(field);
    const row = this.#rows.get(quantity) ?? find("quantity", [...this.#rows.keys()], quantity);
    if (quantity === "point") return Float64Array.from(this.point(index, field));
    return this.#evaluator.read(row, this.#index(row, index), velocity);
  }

  /** A number, or the number of a probe or support by its name. */
  #index({ name, count }, index) {
    if (typeof index === "string" && name === "probe") return find("probe", this.probeNames, index);
    if (typeof index === "string" && name.startsWith("reaction")) return find("support", this.supportNames, index);
    if (Number.isInteger(index) && index >= 0 && index < count) return index;
    throw new Refused(`there is no ${name} ${shown(index)}; the body has ${count}, counted from 0`);
  }

  probe(name, field = "displacement") {
    return this.#read("probe", name, field)[0];
  }

  node(index, field = "displacement") {
    return Array.from(this.#read("node", index, field));
  }

  point(place, field = "displacement") {
    return this.#evaluator.point(placed(place), isVelocity(field));
  }

  whole(field = "displacement") {
    return this.#read("whole", 0, field);
  }

  stress(index) {
    return Array.from(this.#read("stress", index, "displacement"));
  }

  strain(index) {
    return Array.from(this.#read("strain", index, "displacement"));
  }

  vonMises(index) {
    return this.#read("von_mises", index, "displacement")[0];
  }

  reaction(name) {
    const [force, moment] = ["reaction_force", "reaction_moment"].map((part) => Array.from(this.#read(part, name, "displacement")));
    return { force, moment };
  }

  get energy() {
    return this.#evaluator.energy();
  }

  surface(field = "displacement") {
    return this.#evaluator.surface(isVelocity(field));
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

  get embedded() {
    if (!this.#evaluator.section(SECTION.embeddedTriangles)) return null;
    const [nodes, weights, triangles] = ["embeddedNodes", "embeddedWeights", "embeddedTriangles"].map((name) => this.#section(name));
    return { nodes, weights: Float32Array.from(weights), triangles };
  }

  get stressPoints() {
    return this.#section("stressPoints");
  }

  #section(name) {
    const numbers = this.#evaluator.section(SECTION[name]);
    if (!numbers) throw new Refused(`the file has no ${name}, or they are compressed: use the file before \`strip\` or \`pack\``);
    return numbers;
  }

  save() {
    return this.#evaluator.save();
  }

  restore(state) {
    if (!(state instanceof Uint8Array)) throw new Refused(`the state is ${shown(state)}; expected the Uint8Array that \`save\` gave`);
    return this.#evaluator.restore(state) ? "carried" : "as-saved";
  }

  rest() {
    this.#evaluator.rest();
  }

  press({ radius, friction = 0, speed, most = Infinity, centre, target = centre }) {
    vector("the centre", centre);
    vector("the target", target);
    this.#evaluator.holdTool({ radius, friction, speed, most, centre, target });
    this.#tool = true;
  }

  moveSphere(target) {
    if (!this.#tool) throw new Refused("there is no sphere; `press` lays one down");
    this.#evaluator.moveTool(vector("the target", target));
  }

  liftSphere() {
    this.#tool = false;
    this.#evaluator.liftTool();
  }

  get sphere() {
    return this.#evaluator.tool();
  }
}
