// Sliders of what can be changed while the body moves: the file's own parameters, and what the diagonal structure takes in any file.
import { short } from "vademecum/chart";
import { find, range } from "vademecum/elements";

/** What the diagonal structure takes live in any file: name, unit, range (a factor of the value as built where `log`). */
const ALWAYS = [
  { key: "stiffness", name: "Stiffness ×", unit: "", log: true, range: () => [0.1, 10] },
  { key: "density", name: "Density ×", unit: "", log: true, range: () => [0.1, 10] },
  { key: "timeStep", name: "Time step", unit: "s", log: true, range: ({ timeStep }) => [timeStep / 100, timeStep * 10] },
  { key: "alpha", name: "Damping α", unit: "1/s", log: false, range: ({ alpha }) => [0, Math.max(20, 4 * alpha)] },
  { key: "beta", name: "Damping β", unit: "s", log: false, range: ({ beta, timeStep }) => [0, Math.max(timeStep, 4 * beta)] },
];

export class Parameters {
  /** `done` is called with a refusal, or with "", after each change. */
  constructor(player, done) {
    const { evaluator } = player;
    Object.assign(this, { player, evaluator, done, asBuilt: { ...evaluator.options } });
    this.build();
    for (const [value, present] of [["1", evaluator.has.diagonal && !evaluator.exact], ["2", evaluator.has.block], ["4", evaluator.has.diagonal]]) {
      find("structure").querySelector(`[value="${value}"]`).disabled = !present;
    }
    find("precision").addEventListener("change", () => this.set({ double: find("precision").value === "64" }));
    find("structure").addEventListener("change", () => this.set({ structure: Number(find("structure").value) }));
    find("reset").addEventListener("click", () => this.set(this.asBuilt));
    find("random").hidden = !evaluator.has.parametric;
    find("random").addEventListener("click", () => this.randomise());
  }

  /** Sliders of the file's parameters, and of what the diagonal structure takes besides. */
  build() {
    const own = this.evaluator.parameters;
    const others = ALWAYS.filter(({ key }) => this.evaluator.has.diagonal && !own.some((parameter) => parameter.key === key));
    const ranged = others.map((parameter) => {
      const [lower, upper] = parameter.range(this.asBuilt);
      return { ...parameter, region: null, lower, upper };
    });
    this.sliders = [...own, ...ranged].map((parameter) => {
      const { key, region, name, log, lower, upper } = parameter;
      const [walked, back] = log ? [Math.log10, (x) => 10 ** x] : [(x) => x, (x) => x];
      const id = `parameter-${key}${region === null ? "" : `-${region}`}`;
      const input = range(find("parameters"), id, name, walked(lower), walked(upper), walked(this.evaluator.value(parameter)));
      input.addEventListener("input", () => this.set(this.evaluator.option(parameter, Math.min(upper, Math.max(lower, back(Number(input.value)))))));
      return { ...parameter, input, put: (x) => (input.value = String(walked(x))) };
    });
    this.shown();
  }

  /** Sets every live region to a random place of its range. */
  randomise() {
    const values = [...this.evaluator.options.values];
    for (const { index, region, log, lower, upper } of this.evaluator.parameters) {
      if (region === null) continue;
      const between = (low, high) => low + Math.random() * (high - low);
      const drawn = log ? Math.exp(between(Math.log(lower), Math.log(upper))) : between(lower, upper);
      values[index] = Math.min(upper, Math.max(lower, drawn));
    }
    this.set({ values });
  }

  /** What is bound, beside the sliders. */
  shown() {
    for (const { input, put, ...parameter } of this.sliders) {
      const value = this.evaluator.value(parameter);
      put(value);
      input.previousElementSibling.textContent = short(value, parameter.unit);
    }
    find("precision").value = this.evaluator.options.double ? "64" : "32";
    find("structure").value = String(this.evaluator.options.structure);
    find("step-note").textContent = this.note();
  }

  /** What Δt does, and what it does not. */
  note() {
    const { evaluator, asBuilt } = this;
    const { timeStep } = evaluator.options;
    const count = Number((1 / timeStep).toPrecision(3));
    const steps = `${count} step${count === 1 ? "" : "s"} a second of motion. `;
    // A file whose Δt is one of its own parameters is certified over a range of it.
    const own = evaluator.parameters.find(({ key }) => key === "timeStep");
    const [low, high] = own ? [own.lower, own.upper] : [asBuilt.timeStep, asBuilt.timeStep];
    const range = own ? `${short(low, "s")} to ${short(high, "s")}` : short(low, "s");
    const made = `The certificate was made for ${range}${evaluator.exact ? "" : ` by “${evaluator.scheme}”`}.`;
    if (evaluator.structure === 4) {
      const often = `now ${count} time${count === 1 ? "" : "s"} per second`;
      return `Exact time integration: Δt only sets how often loads can change (${often}).${evaluator.exact ? "" : ` ${made}`}`;
    }
    const other = timeStep < low * (1 - 1e-9) || timeStep > high * (1 + 1e-9);
    return `${steps}Steps of “${evaluator.scheme}” have an error that grows with Δt. ${made}${other ? " At this Δt it does not hold." : ""}`;
  }

  /** Binds other parameters; a refusal is said and changes nothing. */
  set(parameters) {
    let refusal = "";
    try {
      this.player.set(parameters);
    } catch (error) {
      refusal = `Refused: ${error.message}`;
    }
    this.shown();
    this.done(refusal);
  }
}
