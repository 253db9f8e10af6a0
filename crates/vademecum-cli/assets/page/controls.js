// Buttons, sliders and figures: reads what the user set, shows what the march measured.
import { gradient } from "vademecum/colors";
import { short } from "vademecum/chart";
import { element, find, range } from "vademecum/elements";
import { SECTION } from "vademecum/evaluator";
import { round125 } from "vademecum/body";
import { Parameters } from "vademecum/parameters";

const FIELDS = { u: ["displacement", "m"], v: ["velocity", "m/s"], s: ["von Mises stress", "Pa"], b: ["error bound for a push here, worst direction", ""] };

/** A share in percent. */
const percent = (x) => `${Number((100 * x).toPrecision(2))} %`;

/** What the file says about the error of a push that a user may apply. */
function bounds(evaluator) {
  const known = evaluator.section(SECTION.staticBound);
  if (!known) return "no bound: contacts have no residual flexibility";
  const [rigorous, worst, median, p95] = known;
  return `${rigorous === 1 ? "bound" : "estimate"}: median ${percent(median)}, 95th percentile ${percent(p95)}, worst ${percent(worst)}`;
}

export class Controls {
  constructor(player, renderer, camera) {
    Object.assign(this, { player, renderer, camera, peak: 0, refusal: "" });
    this.evaluator = player.evaluator;
    this.buttons();
    this.parameters = new Parameters(player, (refusal) => {
      this.refusal = refusal;
      this.tools();
    });
    this.tools();
    this.patterns();
    this.file();
    for (const id of ["force", "speed", "magnification", "color", "tool", "radius", "depth", "friction"]) find(id).addEventListener("input", () => this.read());
    this.start();
    this.read();
  }

  /** Speed and shown time such that the first mode can be followed by eye. */
  start() {
    const first = this.firstFrequency();
    if (first > 8) find("speed").value = String(Math.log10(Math.max(1e-5, round125(4 / first))));
    find("magnification").value = String(Math.log10(this.usual()));
    const spans = [...find("span").options].map((option) => Number(option.value));
    find("span").value = String(spans.find((span) => span >= 12 / first) ?? 10);
  }

  /** The lowest frequency of the file [Hz]. */
  firstFrequency() {
    if (this.first === undefined) {
      const table = this.evaluator.section(16);
      this.first = table ? Math.min(...table.filter((x, i) => i % 6 === 0 && x > 0)) : 1;
    }
    return this.first;
  }

  /** Displacements [m] up to this are a body at rest. */
  get nothing() {
    return 1e-9 * this.player.body.size;
  }

  /** The same of what colours the body. */
  get colourless() {
    if (this.stress) return 1e-9 * this.player.body.young;
    return this.nothing * (this.velocity ? this.firstFrequency() : 1);
  }

  buttons() {
    const { player, renderer } = this;
    const on = (id, act) => find(id).addEventListener("click", act);
    on("pause", () => this.pause(!player.paused));
    on("step", () => {
      this.pause(true);
      player.step(1);
    });
    on("rest", () => this.rest());
    find("throw").hidden = !player.flight;
    on("throw", () => player.toss(this.camera.up, this.firstFrequency()));
    on("true-scale", () => this.magnify(this.magnification === 1 ? this.usual() : 1));
    on("theme", () => this.theme(!document.documentElement.classList.contains("dark")));
    on("help", () => (find("keys").open ? find("keys").close() : find("keys").showModal()));
    find("keys").addEventListener("click", () => find("keys").close());
    for (const id of ["wire", "ghost", "supports", "ground"]) {
      find(id).checked = renderer[id];
      find(id).addEventListener("change", (event) => (renderer[id] = event.target.checked));
    }
    find("held").hidden = player.body.loadTriangles === player.body.triangles.length / 3;
    // Some browsers show hidden options.
    for (const [value, known] of [["b", player.body.bound], ["s", player.body.young]]) {
      const option = find("color").querySelector(`[value="${value}"]`);
      if (known) option.hidden = false;
      else option.remove();
    }
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => this.theme(dark.matches));
    this.theme(dark.matches);
  }

  theme(dark) {
    document.documentElement.classList.toggle("dark", dark);
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(`--${name}`).trim();
    this.dark = dark;
    this.style = { soft: color("soft"), line: color("line"), panel: color("panel"), stage: color("stage-plain"), ink: color("ink"), arrow: color("arrow"), series: [0, 1, 2, 3].map((k) => color(`series${k}`)) };
  }

  pause(paused) {
    this.player.paused = paused;
    find("pause").setAttribute("aria-pressed", String(paused));
    find("pause").textContent = paused ? "Go on" : "Pause";
  }

  /** The body at rest; scales and plots begin anew. */
  rest() {
    this.refusal = "";
    this.peak = 0;
    this.player.rest();
  }

  /** The magnification a body begins with: large displacements are drawn as they are. */
  usual() {
    return this.evaluator.structure === 5 ? 1 : this.player.body.flexible.magnification;
  }

  magnify(factor) {
    find("magnification").value = String(Math.log10(factor));
    this.read();
  }

  /** Binds other parameters; a refusal is said and changes nothing. */
  set(parameters) {
    this.parameters.set(parameters);
  }

  /** Which tools the bound session takes, and why not. */
  tools() {
    const { player, evaluator } = this;
    const [choice, note] = [find("tool"), find("tool-note")];
    const takes = player.takesTool;
    choice.querySelector('[value="sphere"]').disabled = !takes;
    if (!takes) choice.value = "force";
    note.hidden = takes || player.body.loadTriangles === 0;
    note.textContent = evaluator.structure === 5 ? "The sphere presses on bodies of small displacements only."
      : evaluator.exact ? "The sphere needs the exact step structure (Live parameters, below)."
      : `The sphere needs a file with exact steps. This one moves by the stages of “${evaluator.scheme}”: build it with scheme = { name = "exact" }.`;
    this.chosen();
  }

  /** The settings of the chosen tool. */
  chosen() {
    const sphere = find("tool").value === "sphere";
    find("sphere").hidden = !sphere;
    find("finger").hidden = sphere;
    const { size } = this.player.body;
    const radius = size * 10 ** Number(find("radius").value);
    // Never as deep as the centre, so that the sphere stays on its side of the body.
    const depth = 0.8 * radius * Number(find("depth").value);
    const friction = Number(find("friction").value);
    this.sphere = sphere ? { radius, depth, friction } : null;
    // A twentieth of the body in a period of the first mode: slow for it, whatever it is made of.
    this.toolSpeed = 0.05 * size * this.firstFrequency();
    find("radius-out").textContent = short(radius, "m");
    find("depth-out").textContent = short(depth, "m");
    find("friction-out").textContent = String(friction);
  }

  /** A slider per load pattern. */
  patterns() {
    // Those of the angular velocity of a free body are not set by hand.
    const own = this.player.flight?.first ?? Infinity;
    this.evaluator.patternNames.slice(0, own).forEach((name, index) => {
      const input = range(find("patterns"), `pattern-${index}`, `Load: ${name}`, -2, 2, 0);
      const say = () => (input.previousElementSibling.textContent = `× ${Number(input.value).toFixed(2)}`);
      input.addEventListener("input", () => {
        this.player.setPattern(index, Number(input.value));
        say();
      });
      say();
    });
  }

  file() {
    const e = this.evaluator;
    const of = e.structure === 2 ? e.certificate.block : e.certificate.diagonal;
    const rows = {
      program: e.program, nodes: `${e.counts.nodes} (${3 * e.counts.nodes} components), ${e.counts.surfaceNodes} on the surface`,
      loadable: `${e.counts.loadNodes} nodes, ${e.counts.loadTriangles} of ${e.counts.triangles} triangles`,
      modes: e.counts.modes, scheme: `${e.scheme}, Δt ${short(e.built.timeStep, "s")}`,
      structures: [e.has.diagonal && (e.exact ? "exact" : "diagonal"), e.has.block && `block (${e.counts.terms} terms)`].filter(Boolean).join(", "),
      "error of any push": bounds(e), "error in test runs": `${percent(of.error)} of the motion (measured, no bound)`, units: e.units,
      "first mode": `${Number(this.firstFrequency().toPrecision(4))} Hz`,
    };
    for (const [name, value] of Object.entries(rows)) {
      find("file").append(element("dt", name), element("dd", String(value)));
    }
  }

  /** Takes the simple settings over. */
  read() {
    this.chosen();
    this.force = this.player.body.flexible.force * 10 ** Number(find("force").value);
    this.player.speed = 10 ** Number(find("speed").value);
    this.magnification = 10 ** Number(find("magnification").value);
    const [kind, component] = find("color").value;
    const bound = kind === "b" ? this.player.body.bound : null;
    // −1: the size of the field; −2: places on the ramp, on the loadable surface only.
    Object.assign(this, { velocity: kind === "v", stress: kind === "s", bound, component: bound ? -2 : component === undefined ? -1 : Number(component) });
    find("force-out").textContent = short(this.force, "N");
    const speed = this.player.speed;
    find("speed-out").textContent = `${Number(speed.toPrecision(2))} × ${Math.abs(speed - 1) < 0.02 ? "real time" : speed < 1 ? "slow motion" : "fast"}`;
    const drawn = Number(this.magnification.toPrecision(2));
    find("magnification-out").textContent = `× ${drawn}`;
    find("true-scale").textContent = drawn === 1 ? "true scale" : `motion drawn × ${drawn}`;
    const [name] = FIELDS[kind];
    const bounded = bound?.rigorous ? name : name.replace("bound", "estimate");
    find("quantity").textContent = bound ? `${bounded} (log scale)` : component === undefined ? name : `${name} ${"xyz"[component]}`;
    find("ramp").style.background = gradient(component !== undefined);
    this.unit = FIELDS[kind][1];
    this.peak = 0;
  }

  /** The colour range: follows a growing field at once and a dying one slowly. */
  scale(field, seconds) {
    if (this.bound) {
      find("low").textContent = percent(this.bound.low);
      find("high").textContent = percent(this.bound.high);
      return 1;
    }
    let largest = 0;
    for (let i = 0; i < field.length; i += 3) {
      const value = this.component < 0 ? Math.hypot(field[i], field[i + 1], field[i + 2]) : Math.abs(field[i + this.component]);
      if (value > largest) largest = value;
    }
    this.largest = largest;
    this.peak = Math.max(largest, this.peak * Math.exp(-seconds / 4));
    const still = this.peak <= this.colourless;
    find("low").textContent = still ? "at rest" : this.component < 0 ? "0" : short(-this.peak, this.unit);
    find("high").textContent = still ? "" : short(this.peak, this.unit);
    return still ? Infinity : this.peak;
  }

  /** The line under the body, a few times a second. */
  pace({ rate, factor, frame, frames }) {
    const { player, evaluator } = this;
    find("step-time").textContent = short(player.secondsPerStep, "s");
    find("step-rate").textContent = rate >= 1e4 ? `${Math.round(rate / 1000)} k` : String(Number(rate.toPrecision(rate < 10 ? 2 : 4)));
    find("factor").textContent = player.paused ? "paused" : `× ${factor.toPrecision(2)}`;
    find("frame").textContent = `${(1000 * frame).toFixed(1)} ms, ${Math.round(frames)}/s`;
    find("modes").textContent = `${evaluator.counts.modes}, ${{ 1: "diagonal", 4: "exact", 5: "large displacements" }[evaluator.structure] ?? `block, ${evaluator.counts.terms} terms`}, ${evaluator.options.double ? 64 : 32} bit`;
    const touches = player.tool ? evaluator.tool().touches : [];
    const total = [0, 1, 2].map((i) => touches.reduce((sum, { force }) => sum + force[i], 0));
    find("tool-force").textContent = touches.length === 0 ? "none" : `${short(Math.hypot(...total), "N")} (${touches.length} contact${touches.length === 1 ? "" : "s"})`;
    find("time").textContent = player.time < 1 ? short(player.time, "s") : `${player.time.toFixed(2)} s`;
  }

  /** What the user must know now; `moved` is the largest displacement on the surface [m]. */
  warn(moved) {
    const share = moved / this.player.body.size;
    const linear = this.player.evaluator.structure !== 5;
    const large = linear && share > 0.15 ? `Displacement is ${Math.round(100 * share)} % of the body: the model is linear and no longer describes it.` : "";
    const late = this.player.late ? "Behind: this machine cannot take that many steps per second beside drawing." : "";
    const text = this.refusal || large || late;
    if (find("status").textContent !== text) find("status").textContent = text;
  }
}
