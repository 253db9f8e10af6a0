// The march: time, loads, parameters. Steps follow the clock, drawing does not hold them.

import { Flight, TOGETHER } from "vademecum/flight";

/** Steps are recorded in rounds of this many. */
const ROUND = 512;
/** Records kept. */
const CAPACITY = 1 << 16;
/** Most wall time [ms] the march may take of a frame; what does not fit is given up and shows in the real-time factor. */
const BUDGET = 12;
/** Frames of at most this many steps show the motion between steps. */
const SEEN = 8;

/** Time, probes, watched component and scalars of the whole body of the last steps. */
export class History {
  constructor(names) {
    this.names = names;
    this.time = new Float64Array(CAPACITY);
    this.columns = names.map(() => new Float64Array(CAPACITY));
    this.count = 0;
  }

  push(start, timeStep, rows) {
    const width = this.names.length;
    for (let row = 0; row < rows.length / width; row++) {
      const place = this.count++ % CAPACITY;
      this.time[place] = start + (row + 1) * timeStep;
      for (let c = 0; c < width; c++) this.columns[c][place] = rows[row * width + c];
    }
  }

  /** Places of the records kept, oldest first: `[first, last)` taken modulo the capacity. */
  get first() {
    return Math.max(0, this.count - CAPACITY);
  }

  at(column, record) {
    return column[record % CAPACITY];
  }

  clear() {
    this.count = 0;
  }
}

export class Player {
  constructor(evaluator, body, options) {
    this.evaluator = evaluator;
    this.body = body;
    this.contacts = new Map();
    this.tool = null;
    /** The rigid motion of a free body; null of one that is held. */
    this.flight = Flight.of(evaluator, body);
    this.amplitudes = evaluator.patternNames.map(() => 0);
    this.nextContact = 1;
    /** Who wants to hear of new contacts, of rest and of other parameters. */
    this.heard = { press() {}, rest() {}, set() {} };
    this.paused = false;
    this.speed = 1;
    this.time = 0;
    this.owed = 0;
    this.stepped = 0;
    this.lived = 0;
    /** Surface before the last step, while single steps can be seen. */
    this.before = null;
    this.history = new History([...evaluator.probeNames, "watched", ...evaluator.totals.map(({ name }) => name)]);
    evaluator.bind(options);
    this.bound();
    this.measure();
  }

  get timeStep() {
    return this.evaluator.options.timeStep;
  }

  /** After each bind: what the module forgot. */
  bound() {
    const { point, normal } = this.body.flexible;
    this.evaluator.watch(point, normal);
    this.atRest = true;
    this.layDown();
  }

  /** Whether a sphere can press the body as it is bound. */
  get takesTool() {
    return this.evaluator.structure === 4 && this.body.loadTriangles > 0;
  }

  /** A sphere that presses from the next step on: `{ radius, friction, speed, centre, target, point }`; `point` is the place it is over. */
  hold(tool) {
    this.evaluator.holdTool(tool);
    this.tool = tool;
  }

  moveTool(target, point) {
    if (!this.tool) return;
    Object.assign(this.tool, { target, point: point ?? this.tool.point });
    this.evaluator.moveTool(target);
  }

  lift() {
    this.tool = null;
    this.evaluator.liftTool();
  }

  /** Puts the sphere back where it was into a new session, if that can have one. */
  layDown() {
    if (this.tool && this.takesTool) this.evaluator.holdTool(this.tool);
    else this.tool = null;
  }

  /** Puts all loads on. A body at rest starts with the acceleration that goes with them, as `vademecum run` does. */
  load() {
    this.evaluator.clearLoads();
    for (const { point, force } of this.contacts.values()) this.evaluator.addContact(point, force);
    this.amplitudes.forEach((amplitude, index) => {
      if (amplitude !== 0) this.evaluator.addPattern(index, amplitude);
    });
    if (this.atRest && (this.contacts.size > 0 || this.amplitudes.some((amplitude) => amplitude !== 0))) {
      this.evaluator.setCoordinates(new Float64Array(2 * this.evaluator.counts.modes));
      this.atRest = false;
    }
  }

  /** Up in the air with a free body; what it swings it goes on to. */
  toss(up, firstFrequency) {
    this.lift();
    this.flight.toss(up, this.speed, firstFrequency);
  }

  /** Half of a round in the air, and the forces of its middle for the module. */
  fly(seconds) {
    this.flight.drift(seconds / 2);
    this.load();
    this.flight.amplitudes.forEach((amplitude, pair) => this.evaluator.addPattern(this.flight.first + pair, amplitude));
    this.flight.kick(this.flight.push(this.contacts.values(), this.amplitudes), seconds);
  }

  /** The other half. */
  flown(seconds) {
    this.flight.drift(seconds / 2);
    if (!this.flight.back) return;
    this.flight.land();
    this.load();
  }

  /** A new contact, held until `release`; its number. */
  press(point, force) {
    const id = this.nextContact++;
    this.contacts.set(id, { point, force });
    this.load();
    this.heard.press(point, force);
    return id;
  }

  move(id, point, force) {
    if (!this.contacts.has(id)) return;
    this.contacts.set(id, { point, force });
    this.load();
  }

  release(id) {
    if (this.contacts.delete(id)) this.load();
  }

  setPattern(index, amplitude) {
    this.amplitudes[index] = amplitude;
    this.load();
  }

  /** Other parameters; displacement and velocity stay. Throws what the evaluator refuses, with everything as it was. */
  set(parameters) {
    this.before = null;
    const kind = () => `${this.evaluator.structure} ${this.evaluator.options.double}`;
    const before = kind();
    this.evaluator.rebind(parameters, () => {
      this.bound();
      this.atRest = false;
      this.load();
    });
    if (kind() !== before) this.measure();
    this.heard.set();
  }

  /** Displacement and velocity zero, time and records anew, loads kept. */
  rest() {
    this.evaluator.rest();
    this.flight?.land();
    this.atRest = true;
    this.before = null;
    Object.assign(this, { time: 0, owed: 0 });
    this.history.clear();
    this.load();
    this.heard.rest();
  }

  /** Takes `n` steps now. */
  step(n) {
    for (let done = 0; done < n; ) {
      const flying = this.flight?.flying === true;
      const round = Math.min(flying ? TOGETHER : ROUND, n - done);
      if (flying) this.fly(round * this.timeStep);
      const { status, rows } = this.evaluator.record(round);
      this.history.push(this.time, this.timeStep, rows);
      this.time += round * this.timeStep;
      this.atRest = status === "at rest";
      if (flying) this.flown(round * this.timeStep);
      done += round;
    }
    if (this.tool) this.tool.centre = this.evaluator.tool().centre;
    this.stepped += n;
    this.lived += n * this.timeStep;
    this.before = null;
  }

  /** Takes `due` steps of a frame and keeps what the drawing between the last two needs. */
  follow(due) {
    if (due > SEEN) return this.step(due);
    if (due > 1) this.step(due - 1);
    const before = this.evaluator.surface(false).slice();
    this.step(1);
    this.before = before;
  }

  /** Displacement to draw: where single steps show, between the last two, as far as the clock has come; else after the last. */
  displacement() {
    const now = this.evaluator.surface(false);
    if (this.before?.length !== now.length) return now.slice();
    const share = Math.min(1, this.owed / this.timeStep);
    return now.map((x, i) => this.before[i] + share * (x - this.before[i]));
  }

  /** Time [s] of motion that steps and clock have come to since the page opened. */
  get reached() {
    return this.lived + this.owed;
  }

  /** Lets `seconds` of wall time pass. */
  advance(seconds) {
    if (this.paused) return;
    this.owed += seconds * this.speed;
    const end = performance.now() + BUDGET;
    while (this.owed >= this.timeStep) {
      const due = Math.min(ROUND, Math.floor(this.owed / this.timeStep));
      this.follow(due);
      this.owed -= due * this.timeStep;
      if (performance.now() > end) {
        this.owed = 0;
        this.late = true;
        return;
      }
    }
    this.late = false;
  }

  /** Wall time of a step [s], the best of rounds of a few milliseconds (the first ones run while the browser still compiles);
   * the state is put back. */
  measure() {
    const state = this.evaluator.coordinates();
    this.evaluator.liftTool();
    // A body at rest without loads would not be stepped at all.
    if (this.body.loadTriangles > 0) this.evaluator.addContact(this.body.flexible.point, [1e-6, 0, 0]);
    else this.evaluator.setCoordinates(new Float64Array(state.length).fill(1e-6));
    const end = performance.now() + 150;
    this.secondsPerStep = Infinity;
    for (let steps = 1000; performance.now() < end; ) {
      const start = performance.now();
      this.evaluator.march(steps);
      const seconds = (performance.now() - start) / 1000;
      if (seconds < 3e-3) steps *= 2;
      else this.secondsPerStep = Math.min(this.secondsPerStep, seconds / steps);
    }
    this.load();
    this.evaluator.setCoordinates(state);
    this.layDown();
  }
}
