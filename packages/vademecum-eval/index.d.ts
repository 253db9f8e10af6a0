/** Three components: metres, metres per second or newtons, in the unit of the file. */
export type Vector = readonly [number, number, number] | number[];

/** Why something was refused, in words. Nothing has changed. */
export class Refused extends Error {}

/** A place of the loadable surface. */
export interface Place {
  /** Nodes of its triangle. */
  nodes: number[];
  /** Their shares, which sum to 1. */
  weights: number[];
  /** Where it is at rest. */
  position: number[];
  /** How far that is from the place asked for. */
  distance: number;
}

/** A live parameter of a file. */
export interface Parameter {
  readonly name: string;
  /** Empty for a factor. */
  readonly unit: string;
  /** Smallest and largest value; both are allowed. */
  readonly lower: number;
  readonly upper: number;
  /** The value the file was built around. */
  readonly nominal: number;
  /** Whether its range is best walked in the logarithm. */
  readonly log: boolean;
}

/** How many there are of everything. */
export interface Counts {
  readonly nodes: number;
  readonly surfaceNodes: number;
  readonly loadNodes: number;
  readonly triangles: number;
  readonly loadTriangles: number;
  readonly modes: number;
  readonly patterns: number;
  readonly probes: number;
  readonly terms: number;
}

/** A rigid sphere that cannot enter the body. */
export interface Sphere {
  /** Its radius. */
  radius: number;
  /** Coulomb's coefficient; 0 without it. */
  friction?: number;
  /** How fast it follows its target at most, per second. */
  speed: number;
  /** With how much force it follows at most; without it, as much as it takes. */
  most?: number;
  /** Where it is. */
  centre: Vector;
  /** Where it goes; without it, it stays. */
  target?: Vector;
}

/** What a sphere did in the last step. */
export interface Pressed {
  centre: number[];
  /** The deepest place of the body inside of the sphere; below zero for a gap. */
  deepest: number;
  /** Whether all forces were found to the last gap. */
  solved: boolean;
  /** Where the body is pushed, and with which force. */
  touches: { place: number[]; force: number[] }[];
}

/** How a file is opened. */
export interface Options {
  /** The evaluator's module or its bytes; without it, the one of this package. */
  wasm?: WebAssembly.Module | BufferSource;
  /** In which numbers the body is stepped; `"single"` without it. */
  precision?: "single" | "double";
  /** Live parameters by name; without it, the body as it was built. */
  parameters?: Record<string, number>;
}

/**
 * A body of a vademecum file that is pushed and stepped. It lives in a WebAssembly module of its own, so several bodies know nothing
 * of each other, and it works the same on a page, in a worker and in Node. A refused call throws {@link Refused} and changes nothing.
 */
export class Vademecum {
  private constructor();

  /**
   * Opens a file whose sections are raw, as `vademecum build` writes them. Every section is compared with its checksum.
   * The body is at rest and unloaded.
   */
  static open(bytes: ArrayBuffer | Uint8Array, options?: Options): Promise<Vademecum>;

  readonly counts: Counts;
  readonly precision: "single" | "double";
  /** Names of the probes and of the load patterns, in the order of the file. */
  readonly probeNames: readonly string[];
  readonly patternNames: readonly string[];
  readonly parameters: readonly Parameter[];
  /** The problem file's text, the units of all numbers, the time scheme. */
  readonly problem: string;
  readonly units: string;
  readonly scheme: string;
  /** One step, in seconds. */
  readonly timeStep: number;

  /** Value of a live parameter. */
  get(name: string): number;
  /** Sets live parameters, all of them or none. The body goes on from where it is, under the same loads. */
  set(values: Record<string, number>): void;

  /** The loadable place nearest to a place of the body at rest; null if nothing is loadable. */
  locate(place: Vector): Place | null;
  /** Holds a force at a place of the loadable surface until {@link release}. */
  push(place: Pick<Place, "nodes" | "weights">, force: Vector): void;
  /** Holds a load pattern of the file until {@link release}. */
  load(pattern: string, amplitude?: number): void;
  /** Takes all forces and patterns away; a sphere stays. */
  release(): void;

  /** Takes so many steps, one without it. A body at rest costs nothing. */
  step(steps?: number): "moving" | "at-rest";

  /** Displacement of each probe along its direction after the last step, zeros before the first: a copy. */
  readonly probes: Float64Array;
  /** Displacement of one probe after the last step. */
  probe(name: string): number;
  /** Kinetic plus elastic energy, in joules. */
  readonly energy: number;
  /** Displacement of a place. */
  displacement(place: Pick<Place, "nodes" | "weights">): number[];
  /** Velocity of a place. */
  velocity(place: Pick<Place, "nodes" | "weights">): number[];

  /**
   * Displacement (or velocity) of the surface, three numbers for each of its nodes: a view of the module's memory without a copy,
   * `Float32Array` in single precision and `Float64Array` in double. It is good until the next call of this body.
   */
  surface(field?: "displacement" | "velocity"): Float32Array | Float64Array;
  /**
   * Von Mises' equivalent stress of the surface in pascals: the first of three numbers for each of its nodes, zero where the file has
   * none; a view as of `surface`, good until the next call of this body.
   */
  equivalentStress(): Float32Array | Float64Array;
  /** Where the nodes of the surface are at rest, three numbers each: a copy. */
  readonly positions: Float32Array;
  /** Corners of the triangles of the surface, outward, three numbers each: a copy. */
  readonly triangles: Uint32Array;

  /** Reduced displacement and velocity: a copy. */
  save(): Float64Array;
  /** Takes back what {@link save} gave; the acceleration follows from it and from the loads. */
  restore(state: ArrayLike<number>): void;
  /** Puts the body at rest; loads stay. */
  rest(): void;

  /** Lays a sphere down that presses from the next step on; only for files with exact steps. */
  press(sphere: Sphere): void;
  /** Where the sphere is to go. */
  moveSphere(target: Vector): void;
  /** Takes the sphere away. */
  liftSphere(): void;
  /** What the sphere did in the last step; null without one. */
  readonly sphere: Pressed | null;
}
