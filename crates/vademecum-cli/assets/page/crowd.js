// The surfaces of all bodies of a world as one that is drawn: the nodes of one member after those of another, where they are in space.
import { boundingBox, splitAtCreases, uniqueEdges } from "vademecum/body";
import { SECTION } from "vademecum/evaluator";
import { firstMet } from "vademecum/skin";
import { norm, sub } from "vademecum/vectors";

export class Crowd {
  constructor(stage, scene) {
    this.stage = stage;
    this.rest = Float64Array.from(stage.surfaces().nodes);
    const corners = [], owners = [], kinds = [];
    scene.members.forEach(({ file, triangles }, member) => {
      const own = file === null ? Uint32Array.from(triangles.flat()) : stage.section(file, SECTION.triangles);
      if (!own) throw new Error(`the surface of ${scene.members[member].name} is compressed or missing`);
      const { first } = stage.members[member];
      for (let t = 0; t < own.length; t += 3) {
        corners.push(first + own[t], first + own[t + 1], first + own[t + 2]);
        owners.push(member);
        // What is rigid has a plain colour; what cannot be touched is striped.
        kinds.push(file === null ? -1 : t / 3 < stage.files[file].loadTriangles ? 1 : 0);
      }
    });
    this.triangles = Uint32Array.from(corners);
    this.owners = Uint32Array.from(owners);
    this.kinds = kinds;
    /** Members that are looked at: those that move or bend. */
    this.seen = scene.members.flatMap(({ file }, member) => (file !== null || stage.mass(member) > 0 ? [member] : []));
    this.displaced = Float64Array.from(this.rest);
    this.box = this.around(this.rest);
    this.size = norm(sub(this.box.high, this.box.low));
    const skin = { embedded: false, rest: this.rest, displaced: this.displaced, triangles: this.triangles };
    this.skin = { ...skin, loadable: (t) => kinds[t], at: (numbers) => numbers, nodesOf: (vertex) => [vertex] };
    this.edges = uniqueEdges(this.triangles);
    Object.assign(this, splitAtCreases(this.skin));
    this.held = [];
    this.moved = new Float64Array(this.rest.length);
    /** Places on the ramp by the number of the member, three numbers a node. */
    this.parts = new Float64Array(this.rest.length);
    const count = Math.max(1, this.seen.length - 1);
    this.seen.forEach((member, place) => {
      const { first, nodes } = stage.members[member];
      for (let node = first; node < first + nodes; node++) this.parts[3 * node] = 0.08 + (0.84 * place) / count;
    });
  }

  /** The box around the members that are looked at. */
  around(nodes) {
    const own = this.seen.map((member) => this.stage.members[member]);
    const points = own.flatMap(({ first, nodes: count }) => {
      const { low, high } = boundingBox(nodes.subarray(3 * first, 3 * (first + count)));
      return [...low, ...high];
    });
    return boundingBox(points);
  }

  /** Takes the places of the nodes; their displacement from where they were at the start. */
  place(nodes) {
    for (let i = 0; i < nodes.length; i++) {
      this.displaced[i] = nodes[i];
      this.moved[i] = nodes[i] - this.rest[i];
    }
    this.drawn = this.around(this.displaced);
    return this.moved;
  }

  /** What a ray meets first: member, whether it can be pulled, the place `{ nodes, weights }` on it, and where that is; null if it passes by. */
  pick(ray) {
    const best = firstMet(this.triangles, this.displaced, ray);
    if (!best) return null;
    const member = this.owners[best.triangle];
    const nodes = Array.from(this.triangles.subarray(3 * best.triangle, 3 * best.triangle + 3));
    const at = [0, 1, 2].map((k) => nodes.reduce((sum, node, i) => sum + best.weights[i] * this.displaced[3 * node + k], 0));
    const { first } = this.stage.members[member];
    return { member, kind: this.kinds[best.triangle], place: { nodes: nodes.map((node) => node - first), weights: best.weights }, at };
  }
}
