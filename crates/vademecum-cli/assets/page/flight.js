// A free body in the air. The page is the host that turns it: the module gets the centrifugal forces and answers with the elastic motion.
import { SECTION } from "vademecum/evaluator";
import { add, cross, dot, norm, scaled, sub } from "vademecum/vectors";

/** Steps under the same centrifugal forces; the body turns little meanwhile. */
export const TOGETHER = 16;
/** On the screen a throw lasts so long [s] and makes so many turns; the body rises by so many of its sizes. */
const SECONDS = 1.2, TURNS = 1.5, SIZES = 1;
/** Largest angular velocity, as a share of the lowest natural one: beyond, forces of Coriolis would show. */
const SLOW = 0.2;
/** Pairs of components of the angular velocity, in the order of the patterns. */
const PAIRS = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];

/** The product of two quaternions, the real part first. */
const times = ([a, ...v], [b, ...w]) => [a * b - dot(v, w), ...add(add(scaled(w, a), scaled(v, b)), cross(v, w))];

export class Flight {
  /** The rigid motion of the body of a file; null if it is held, or has not all that is wanted. */
  static of(evaluator, body) {
    const numbers = evaluator.section(SECTION.rigidBody);
    return numbers ? new Flight(evaluator, body, numbers) : null;
  }

  constructor(evaluator, body, [mass, x, y, z, xx, xy, xz, yy, yz, zz, first, ...wrenches]) {
    Object.assign(this, { evaluator, body, mass, centre: [x, y, z], first, wrenches });
    const [a, b, c] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    this.inertia = [a, b, c];
    const volume = dot(a, cross(b, c));
    this.inverse = [cross(b, c), cross(c, a), cross(a, b)].map((row) => scaled(row, 1 / volume));
    this.land();
  }

  /** Back to where the file has the body. */
  land() {
    Object.assign(this, { flying: false, moved: [0, 0, 0], attitude: [1, 0, 0, 0], velocity: [0, 0, 0], turning: [0, 0, 0], gravity: [0, 0, 0] });
  }

  /** Throws the body: velocity of its centre, angular velocity in the body, gravity. */
  throw(velocity, spin, gravity) {
    this.land();
    const turning = this.inertia.map((row) => this.evaluator.options.density * dot(row, spin));
    Object.assign(this, { flying: true, velocity, turning, gravity });
  }

  /** A throw along the axis that is up, as one sees it at `speed` times real time. */
  toss(up, speed, firstFrequency) {
    const seconds = SECONDS * speed;
    const gravity = (8 * SIZES * this.body.size) / seconds ** 2;
    const along = (axis, size) => [0, 1, 2].map((k) => (k === axis ? size : 0));
    const spin = Math.min((2 * Math.PI * TURNS) / seconds, SLOW * 2 * Math.PI * firstFrequency);
    const turn = add(along((up + 2) % 3, spin), add(along(up, 0.2 * spin), along((up + 1) % 3, 0.05 * spin)));
    this.throw(along(up, (gravity * seconds) / 2), turn, along(up, -gravity));
  }

  toSpace(d, [w, ...v] = this.attitude) {
    const twice = scaled(cross(v, d), 2);
    return add(add(d, scaled(twice, w)), cross(v, twice));
  }

  toBody(d) {
    const [w, x, y, z] = this.attitude;
    return this.toSpace(d, [w, -x, -y, -z]);
  }

  /** Angular velocity in the body. */
  get spin() {
    const turning = scaled(this.toBody(this.turning), 1 / this.evaluator.options.density);
    return this.inverse.map((row) => dot(row, turning));
  }

  turn(spin, time) {
    const angle = norm(spin) * time;
    if (angle === 0) return;
    const axis = scaled(spin, (Math.sin(angle / 2) * time) / angle);
    const turned = times(this.attitude, [Math.cos(angle / 2), ...axis]);
    const length = Math.hypot(...turned);
    this.attitude = turned.map((part) => part / length);
  }

  /** Flies for a time without forces: the angular momentum stays in space, the attitude follows it to second order. */
  drift(time) {
    this.moved = add(this.moved, scaled(this.velocity, time));
    const before = this.attitude;
    this.turn(this.spin, time / 2);
    const { spin } = this;
    this.attitude = before;
    this.turn(spin, time);
  }

  /** Amplitudes of the six patterns of the angular velocity. */
  get amplitudes() {
    const { spin } = this;
    return PAIRS.map(([i, j]) => this.evaluator.options.density * spin[i] * spin[j]);
  }

  /** What contacts and patterns push, in the body: force and moment. */
  push(contacts, amplitudes) {
    let [force, moment] = [[0, 0, 0], [0, 0, 0]];
    for (const contact of contacts) {
      force = add(force, contact.force);
      moment = add(moment, cross(sub(this.body.place(contact.point, this.body.rest), this.centre), contact.force));
    }
    amplitudes.slice(0, this.first).forEach((amplitude, index) => {
      const wrench = this.wrenches.slice(6 * index, 6 * index + 6);
      force = add(force, scaled(wrench.slice(0, 3), amplitude));
      moment = add(moment, scaled(wrench.slice(3), amplitude));
    });
    return [force, moment];
  }

  /** Takes the impulse of `[force, moment]` in the body over a time; call it halfway. */
  kick([force, moment], time) {
    const mass = this.evaluator.options.density * this.mass;
    const faster = add(scaled(this.toSpace(force), 1 / mass), this.gravity);
    this.velocity = add(this.velocity, scaled(faster, time));
    this.turning = add(this.turning, scaled(this.toSpace(moment), time));
  }

  /** Whether a tossed body has come back to the hand. */
  get back() {
    return dot(this.gravity, this.gravity) > 0 && dot(this.moved, this.gravity) > 0 && dot(this.velocity, this.gravity) > 0;
  }

  /** The displacement that draws the body, magnified, where it is in space. */
  carried(displacement, magnification) {
    if (!this.flying) return displacement;
    const { rest } = this.body;
    const out = new Float64Array(displacement.length);
    for (let i = 0; i < out.length; i += 3) {
      const at = [rest[i], rest[i + 1], rest[i + 2]];
      const moved = scaled([displacement[i], displacement[i + 1], displacement[i + 2]], magnification);
      const place = add(add(this.toSpace(add(sub(at, this.centre), moved)), this.centre), this.moved);
      for (let c = 0; c < 3; c++) out[i + c] = (place[c] - at[c]) / magnification;
    }
    return out;
  }
}
