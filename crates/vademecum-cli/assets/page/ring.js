// The sound of a struck body: its modes that can be heard, stepped by the evaluator itself at the sample rate of the ear. Steps are exact, so a
// step of 1/48000 s has no time error and the pitch is that of the modes. Runs in an audio worklet; knows no page.

/** What is heard [Hz]. */
export const HEARD = [20, 20000];
/** The hammer is soft for what lies this many times above the lowest tone. */
const SOFT = 4;
/** Loudness of the strike that `loud` describes; 1 is what a speaker can give. */
const LOUD = 0.5;
/** So many blocks below this loudness are silence. */
const QUIET = { below: 1e-6, blocks: 400 };

/** Frequencies [Hz] of all modes with these options. */
export function frequencies(evaluator, section, { stiffness = 1, density = 1 }) {
  const table = evaluator.section(section.modeTable);
  const lambda = evaluator.section(section.eigenvalues) ?? (table && table.filter((_, i) => i % 6 === 1));
  return Array.from(lambda ?? [], (x) => Math.sqrt((stiffness * x) / density) / (2 * Math.PI));
}

/** Whether a tone can be heard, at this sample rate too. */
export const isHeard = (hertz, rate = Infinity) => hertz >= HEARD[0] && hertz <= Math.min(HEARD[1], 0.45 * rate);

export class Ring {
  /** `hertz`: frequencies of the modes; `loud`: the strike `{ point, force }` that is as loud as it should get; or `speed` [m/s] that is. */
  constructor(evaluator, rate, tuning) {
    Object.assign(this, { evaluator, rate, column: evaluator.counts.probes });
    this.tune(tuning);
  }

  /** Other parameters: what rings goes on ringing, at other pitches. */
  tune({ options, hertz, loud, speed }) {
    const { evaluator } = this;
    const state = evaluator.options && evaluator.coordinates();
    evaluator.bind({ ...options, double: true, structure: 4, timeStep: 1 / this.rate, restBelow: 0 });
    const lowest = Math.min(...hertz.filter((f) => isHeard(f, this.rate)));
    this.weights = hertz.map((f) => (isHeard(f, this.rate) ? 1 / (1 + (f / (SOFT * lowest)) ** 2) : 0));
    // As fast as the place goes right after the strike, it goes at no time later.
    this.gain = 1;
    this.silence();
    this.strike(loud);
    const fastest = speed ?? dot(evaluator.point(loud.point, true), this.along);
    this.gain = fastest > 0 ? (LOUD * this.rate) / fastest : 0;
    this.silence();
    if (!state) return;
    evaluator.setCoordinates(state);
    this.listen(this.place, this.along);
    this.quiet = 0;
  }

  silence() {
    this.evaluator.clear();
    this.evaluator.setCoordinates(new Float64Array(2 * this.evaluator.counts.modes));
    this.quiet = QUIET.blocks;
  }

  /** The place that is heard, and the direction in which it moves the air. */
  listen(place, along) {
    Object.assign(this, { place, along });
    this.evaluator.watch(place, along);
    this.last = dot(this.evaluator.point(place), along);
  }

  /** A strike with `force` [N] for one step at `point`, which is heard from now on. It adds to what rings already. */
  strike({ point, force }) {
    const { evaluator, weights } = this;
    const size = Math.hypot(...force);
    if (size === 0) return;
    const state = evaluator.coordinates();
    evaluator.setCoordinates(new Float64Array(state.length));
    evaluator.push(point, force);
    evaluator.march(1);
    const struck = evaluator.coordinates();
    evaluator.clear();
    evaluator.setCoordinates(state.map((x, i) => x + weights[i % weights.length] * struck[i]));
    this.listen(point, force.map((x) => x / size));
    this.quiet = 0;
  }

  /** Fills `out` with the next samples: the velocity of the place that is heard. */
  render(out) {
    if (this.quiet >= QUIET.blocks) {
      out.fill(0);
      return;
    }
    const { rows } = this.evaluator.record(out.length);
    const width = this.evaluator.recordLength;
    let loudest = 0;
    for (let i = 0; i < out.length; i++) {
      const now = rows[i * width + this.column];
      out[i] = this.gain * (now - this.last);
      this.last = now;
      loudest = Math.max(loudest, Math.abs(out[i]));
    }
    this.quiet = loudest < QUIET.below ? this.quiet + 1 : 0;
  }
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
