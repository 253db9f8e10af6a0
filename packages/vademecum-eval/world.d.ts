import type { Place, Source, Vector } from "./index.js";
export { Refused } from "./index.js";

/** Options of a world. */
export interface WorldOptions {
  /** Step of all bodies, in seconds. */
  step: number;
  /** Acceleration of gravity on bodies that move freely; none without it. */
  gravity?: Vector;
  /** Distance up to which nodes and triangles are paired; a fiftieth of the smallest member without it. */
  reach?: number;
  /** Largest change of a displacement in the last sweep of a step; 1e-9 of the smallest member without it. */
  tolerance?: number;
  /** Most sweeps of a step, 200 without it. */
  sweeps?: number;
  /** Contacts for which there is room, 256 without it. Of more the deepest are kept. */
  contacts?: number;
  /** Bytes or a compiled module in place of `world.wasm` of this package. */
  wasm?: ArrayBuffer | Uint8Array | object;
}

/** Where a member is at the start, and how it moves. */
export interface Placement {
  /** Place of the origin of its coordinates. */
  position?: Vector;
  /** A unit quaternion, real part first. */
  rotation?: Vector | readonly [number, number, number, number];
  /** Velocity of the centre of mass, of a member that moves freely. */
  velocity?: Vector;
  /** Angular velocity in space. */
  spin?: Vector;
  /** Stops of a member that is held or has no mass: time and displacement, in ascending time. It is at rest at each. */
  path?: readonly (readonly number[])[];
  /** A shake of such a member: `amplitude · min(1, t/ramp) · sin(2π frequency t)`. */
  shake?: { amplitude: Vector; frequency: number; ramp?: number };
}

/** A rigid body: a surface of triangles that turn counterclockwise seen from outside. */
export interface Rigid extends Placement {
  nodes: ArrayLike<number> | readonly Vector[];
  triangles: ArrayLike<number> | readonly (readonly number[])[];
  /** Mass, centre, principal moments and their axes, of one that moves; without it the body stands or is led. */
  body?: { mass: number; centre: Vector; moments: Vector; axes?: readonly Vector[] };
}

/** A side of a joint: a port of a body of a file that is a frame, or a point of a rigid body. */
export type Side = { member: number; port: string } | { member: number; at: Vector; axes?: readonly Vector[] };

/** What a step did. */
export interface Report {
  /** In seconds. */
  time: number;
  /** Pairs of nodes and surfaces that were near each other, those that carry a force, and those for which there was no room. */
  contacts: number;
  pressed: number;
  leftOut: number;
  sweeps: number;
  /** Whether the solution is within its tolerance. */
  converged: boolean;
  /** Deepest overlap at the end of the step. */
  deepest: number;
  /** Energy that contacts took from the members in the step. */
  givenAway: number;
  /** Joints that are broken. */
  jointsBroken: number;
  /** Kinetic plus elastic energy, and the potential of gravity. */
  energy: number;
  potential: number;
}

/** Bodies that touch with friction and are joined, in one module. Members, pairs and joints are added before the first step. */
export class World {
  private constructor();
  static create(options: WorldOptions): Promise<World>;

  /** Opens a file; its number. */
  open(source: Source | Promise<Source>): Promise<number>;
  /** Adds a body of a file, once or many times; the number of the member. Without supports in its file it moves freely. */
  add(file: number, placement?: Placement): number;
  addRigid(rigid: Rigid): number;
  /** Members that may touch; `nodes` are those that are held off the surface of the other. */
  touch(first: number, second: number, options?: { friction?: number; restitution?: number; nodes?: "both" | "first" | "second" }): void;
  /** A joint that turns by any angle; its number. A cable has a length, and a stiffness if it stretches; one with `breaksAt` breaks above that force. */
  join(kind: "ball" | "hinge" | "slider" | "cable", first: Side, second: Side, options?: { stiffness?: number; breaksAt?: number; length?: number }): number;

  /** Takes so many steps, one without it. */
  step(steps?: number): Report;
  /** What the last step did. */
  readonly report: Report;
  /** First node among those of `surfaces`, number of nodes, file (null of a rigid body) and mass (0 of one that does not move freely) of each. */
  readonly members: { first: number; nodes: number; file: number | null; mass: number }[];
  /**
   * Nodes of all surfaces in space, and their displacement in the body or velocity in space, three numbers each: views, good until the next
   * call of this world.
   */
  surfaces(field?: "displacement" | "velocity"): { nodes: Float32Array; field: Float32Array };
  /** Corners of the triangles of a body of a file: a copy; null of a rigid one. */
  triangles(member: number): Uint32Array | null;
  /** Place of the origin and quaternion of each member. */
  readonly poses: { position: number[]; rotation: number[] }[];
  /** Contacts of the last step that carry a force, which is that on the first of the members. */
  readonly touches: { members: [number, number]; place: number[]; force: number[]; pressure: number }[];
  /** Force on the first member of each joint, and whether it is broken. */
  readonly joints: { force: number[]; broken: boolean }[];

  /** Lays a hand (a number of yours) on a place of a body of a file, or a point of a rigid one: a spring and a damper to the target. */
  pull(hand: number, member: number, grip: Place | readonly number[], spring: { target: Vector; stiffness: number; damping?: number }): void;
  movePull(hand: number, target: Vector): void;
  release(hand: number): void;
  readonly pulls: { hand: number; member: number; place: ArrayLike<number>; target: ArrayLike<number>; force: ArrayLike<number> }[];
  /** Gives a member that moves freely another velocity where it is. */
  throw(member: number, velocity: Vector, spin?: Vector): void;
  breakJoint(joint: number): void;
  setGravity(gravity: Vector): void;

  /** The state of all: a copy. */
  save(): Uint8Array;
  /** Takes back what {@link save} of the same world gave, bit by bit. */
  restore(state: Uint8Array): void;
  /** Starts over; gravity and hands stay. */
  reset(): void;
}
