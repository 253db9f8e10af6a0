/** Three components: metres, metres per second or newtons, in the unit of the file. */
export type Vector = readonly [number, number, number] | number[] | Float32Array | Float64Array;

/** What is read: the value (of a displacement) or how fast it changes. */
export type Field = "displacement" | "velocity";

/** Why something was refused, in words. Nothing has changed. */
export class Refused extends Error {}

/** A place of the body: a short list of nodes with weights. */
export interface Place {
  /** Its nodes, up to 16. */
  nodes: number[];
  /** As many weights, which sum to 1. */
  weights: number[];
  /** Its radius; 0 without it, and only 0 is taken by this version. */
  radius?: number;
}

/** A place of the loadable surface. */
export interface SurfacePoint extends Place {
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
  /** The value it stands at. */
  readonly value: number;
}

/** A quantity that can be read. */
export interface Quantity {
  readonly name: string;
  readonly unit: string;
  /** Unit of its velocity; empty where it has none. */
  readonly velocityUnit: string;
  /** A line about it. */
  readonly text: string;
  /** How many the body has: probes, nodes, points of stress, supports; 0 where the file has none. */
  readonly count: number;
  /** Numbers of each. */
  readonly length: number;
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

/** A `URL`. Written out, like the next, so that these types want no library of a browser or of Node. */
export interface Url {
  readonly href: string;
}

/** An answer of `fetch`. */
export interface Answer {
  readonly ok: boolean;
  readonly url: string;
  arrayBuffer(): Promise<ArrayBuffer>;
}

/** The bytes of a file, or where they are. Node reads URLs of files, too. */
export type Source = ArrayBuffer | Uint8Array | Url | Answer;

/** How a file is opened. */
export interface Options {
  /** The evaluator's module (`WebAssembly.Module`) or its bytes; without it, the one of this package. */
  wasm?: object;
  /** In which numbers the body is stepped; `"single"` without it. */
  precision?: "single" | "double";
  /** Live parameters by name; without it, the body as it was built. */
  parameters?: Record<string, number>;
  /** Scale of the stiffness of the whole body; 1 without it. A live parameter of the file of that name is set instead. */
  stiffness?: number;
  /** Scale of its density, alike. */
  density?: number;
  /** Rayleigh damping of its mass, per second; that of the file without it. */
  alpha?: number;
  /** Rayleigh damping of its stiffness, in seconds, alike. */
  beta?: number;
}

/**
 * A body of a vademecum file that is pushed and stepped. It lives in a WebAssembly module of its own, so several bodies know nothing
 * of each other, and it works the same on a page, in a worker and in Node. A refused call throws {@link Refused} and changes nothing.
 */
export class Body {
  private constructor();

  /**
   * Opens a file whose sections are raw, as `vademecum build` writes them: `Body.open(fetch("body.vdm"))`. Every section is compared
   * with its checksum. The body is at rest and unloaded.
   */
  static open(source: Source | Promise<Source>, options?: Options): Promise<Body>;

  readonly counts: Counts;
  readonly precision: "single" | "double";
  /** Names of the probes, load patterns and supports, in the order of the file. */
  readonly probeNames: readonly string[];
  readonly patternNames: readonly string[];
  readonly supportNames: readonly string[];
  /** Everything {@link read} reads, as the evaluator's table has it. */
  readonly quantities: readonly Quantity[];
  /** The problem file's text, the units of all numbers, the time scheme. */
  readonly problem: string;
  readonly units: string;
  readonly scheme: string;
  /** One step, in seconds. */
  readonly timeStep: number;

  /** The live parameters as they stand: a copy. */
  readonly parameters: readonly Parameter[];
  /** Sets live parameters by name, all of them or none. The body goes on from where it is, under the same loads. */
  setParameters(values: Record<string, number>): void;

  /** The loadable place nearest to a point of the body at rest; refused if nothing is loadable, or it is further away than the body is large. */
  locate(point: Vector): SurfacePoint;
  /** Holds a force at a place of the loadable surface until {@link clear}. */
  push(place: Place, force: Vector): void;
  /** Holds a load pattern of the file until {@link clear}. */
  pushPattern(name: string, amplitude?: number): void;
  /** Takes all forces and patterns away; a sphere stays. */
  clear(): void;

  /** Takes so many steps, one without it. A body at rest costs nothing. */
  step(steps?: number): "moving" | "at-rest";

  /**
   * Reads a quantity of {@link quantities}: a copy. `index` is its number, counted from 0; a probe or a support also has a name, and
   * the quantity `point` is read at a place.
   */
  read(quantity: string, index?: number | string | Place, field?: Field): Float64Array;
  /** A probe, by name. */
  probe(name: string, field?: Field): number;
  /** A node, in file order. */
  node(index: number, field?: Field): number[];
  /** A place. */
  point(place: Place, field?: Field): number[];
  /**
   * The surface, three numbers for each of its nodes: a view of the module's memory without a copy, `Float32Array` in single precision
   * and `Float64Array` in double. It is good until the next call of this body.
   */
  surface(field?: Field): Float32Array | Float64Array;
  /** The whole body, three numbers for each of its nodes: a view, good until the next call of this body. */
  whole(field?: Field): Float64Array;
  /** Stress at a point of {@link stressPoints} in pascals: xx, yy, zz, xy, yz, zx. */
  stress(index: number): number[];
  /** Strain there, in the same order; shear strains are those of the tensor. */
  strain(index: number): number[];
  /** Von Mises' equivalent stress there. */
  vonMises(index: number): number;
  /** Force and moment that a support exerts on the body, the moment about the point of the support. */
  reaction(name: string | number): { force: number[]; moment: number[] };
  /** Kinetic plus elastic energy, in joules. */
  readonly energy: number;
  /**
   * Von Mises' equivalent stress of the surface in pascals: the first of three numbers for each of its nodes, zero where the file has
   * none; a view, good until the next call of this body.
   */
  equivalentStress(): Float64Array;
  /** Where the nodes of the surface are at rest, three numbers each: a copy. */
  readonly positions: Float32Array;
  /** Corners of the triangles of the surface, outward, three numbers each: a copy. */
  readonly triangles: Uint32Array;
  /**
   * The surface that is drawn in place of that of the mesh, a copy; null where the file has none. Each vertex follows four nodes of the surface:
   * it lies at the sum of their positions, and moves by the sum of their displacements, with these weights.
   */
  readonly embedded: { nodes: Uint32Array; weights: Float32Array; triangles: Uint32Array } | null;
  /** Node and region of each point of stress, two numbers each: a copy. */
  readonly stressPoints: Uint32Array;

  /** The state as tagged bytes, without the loads: a copy. They hold in C, Python and Rust, too. */
  save(): Uint8Array;
  /**
   * Takes back what {@link save} of a body of the same file and structure gave. `"carried"`: it was saved at other parameters or in
   * the other precision; displacement and velocity are what they were.
   */
  restore(state: Uint8Array): "as-saved" | "carried";
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
