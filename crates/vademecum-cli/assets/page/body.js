// The surface of a body: what is drawn, what can be pressed, and a force that bends it visibly.
import { SECTION } from "vademecum/evaluator";
import { firstMet, skinOf } from "vademecum/skin";
import { add, cross, dot, norm, scaled, sub, unit } from "vademecum/vectors";

/** Neighbouring triangles closer than this are shaded as one smooth surface. */
const SMOOTH = Math.cos((35 * Math.PI) / 180);

export class Body {
  constructor(evaluator) {
    const { surfaceNodes, loadTriangles } = evaluator.counts;
    const rest = evaluator.section(SECTION.coordinates);
    const triangles = evaluator.section(SECTION.triangles);
    const basis = evaluator.section(SECTION.surfaceBasis);
    if (!rest || !triangles || !basis) throw new Error("the surface of this file is compressed or missing");
    this.rest = Float64Array.from(rest.subarray(0, 3 * surfaceNodes));
    this.triangles = triangles;
    this.loadTriangles = loadTriangles;
    this.box = boundingBox(this.rest);
    this.size = norm(sub(this.box.high, this.box.low));
    this.displaced = new Float64Array(this.rest.length);
    this.held = heldNodes(basis, surfaceNodes, evaluator.counts.modes);
    this.evaluator = evaluator;
    this.hasQuadrangles = Boolean(evaluator.section(SECTION.quadrangles));
    this.skin = skinOf(evaluator, this);
    this.edges = uniqueEdges(this.skin.triangles);
    Object.assign(this, splitAtCreases(this.skin));
    this.bound = boundOfPushes(evaluator, this);
    /** The largest of Young's moduli [Pa]; 0 of a file without stress. */
    this.young = Math.max(0, ...(evaluator.section(SECTION.elasticConstants) ?? []).filter((_, i) => i % 2 === 0));
    this.flexible = flexiblePoint(this, evaluator, basis);
  }

  node(i, positions = this.rest) {
    return [positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]];
  }

  corners(triangle, positions = this.rest) {
    return [0, 1, 2].map((k) => this.node(this.triangles[3 * triangle + k], positions));
  }

  /** Outward unit normal of a triangle at rest. */
  normal(triangle) {
    const [a, b, c] = this.corners(triangle);
    return unit(cross(sub(b, a), sub(c, a)));
  }

  /** Direction of the part that can be pushed: its outward normals times their areas [m²]; zero of a surface that can be pushed all around. */
  get facing() {
    let sum = [0, 0, 0];
    if (3 * this.loadTriangles === this.triangles.length) return sum;
    for (let t = 0; t < this.loadTriangles; t++) {
      const [a, b, c] = this.corners(t);
      sum = add(sum, scaled(cross(sub(b, a), sub(c, a)), 0.5));
    }
    return sum;
  }

  /** Positions drawn: rest plus magnified displacement; and the box they lie in. */
  displace(displacement, magnification) {
    for (let i = 0; i < this.rest.length; i++) this.displaced[i] = this.rest[i] + magnification * displacement[i];
    this.skin.at(this.displaced, this.skin.displaced);
    this.drawn = boundingBox(this.skin.displaced);
  }

  /** Where a point `{ nodes, weights }` is drawn: where it was seen on an embedded surface, else on the mesh. */
  place(point, positions = this.displaced) {
    if (point.seen && positions === this.displaced) return weighted(point.seen, this.skin.displaced);
    return weighted(point, positions);
  }

  /** What a ray meets first, as `{ normal, loadable, point }`; null if it passes by. A point of an embedded surface is pushed at the nearest place of the mesh, one of a quadrangle shared over its nodes. */
  pick(ray) {
    const { triangles, displaced, rest, loadable, embedded } = this.skin;
    const best = firstMet(triangles, displaced, ray);
    if (!best) return null;
    const vertices = [0, 1, 2].map((k) => triangles[3 * best.triangle + k]);
    const [a, b, c] = vertices.map((vertex) => this.node(vertex, rest));
    const normal = unit(cross(sub(b, a), sub(c, a)));
    const seen = { nodes: vertices, weights: best.weights };
    const pushed = loadable(best.triangle);
    if (!embedded && !(pushed && this.hasQuadrangles)) return { normal, loadable: pushed, point: seen };
    if (!pushed) return { normal, loadable: false, point: null };
    const { nodes, weights } = this.evaluator.locate(weighted(seen, rest));
    return { normal, loadable: true, point: { nodes, weights, seen } };
  }
}

/** Weighted sum of places `{ nodes, weights }` in a list of positions. */
function weighted({ nodes, weights }, positions) {
  const at = (k) => Array.from(nodes, (node, i) => weights[i] * positions[3 * node + k]).reduce((sum, x) => sum + x, 0);
  return [at(0), at(1), at(2)];
}

/**
 * What the modes leave out of a push at each loadable node in its worst direction, as a share of the push's static answer: `{ low, high,
 * rigorous, field }`, the field as places 0 to 1 between the ends on a logarithmic scale, three numbers a node. Null if the file does not keep it.
 */
function boundOfPushes(evaluator, { rest, triangles, loadTriangles, skin }) {
  const [map, summary] = [evaluator.section(SECTION.boundMap), evaluator.section(SECTION.staticBound)];
  if (!map || !summary) return null;
  const values = map.filter((_, i) => i % 7 === 6);
  const above = values.filter((x) => x > 0);
  if (above.length === 0) return null;
  let [low, high] = [above.reduce((a, b) => Math.min(a, b)), above.reduce((a, b) => Math.max(a, b))];
  if (high < 1.01 * low) [low, high] = [low / 2, high];
  const field = new Float64Array(rest.length);
  values.forEach((x, node) => (field[3 * node] = Math.log(Math.max(x, low) / low) / Math.log(high / low)));
  // A node that nothing moves says nothing; it looks like the nodes beside it.
  for (let c = 0; c < 3 * loadTriangles; c += 3) {
    const nodes = triangles.subarray(c, c + 3);
    const known = Math.max(...Array.from(nodes, (node) => (values[node] > 0 ? field[3 * node] : 0)));
    for (const node of nodes) if (!(values[node] > 0)) field[3 * node] = Math.max(field[3 * node], known);
  }
  // Nodes inside the body, which an embedded surface follows, have no push.
  for (let vertex = 0; skin.embedded && vertex < skin.rest.length / 3; vertex++) {
    const nodes = Array.from(skin.nodesOf(vertex));
    const known = Math.max(...nodes.map((node) => field[3 * node]));
    for (const node of nodes) if (!(values[node] > 0)) field[3 * node] = Math.max(field[3 * node], known);
  }
  return { low, high, rigorous: summary[0] === 1, field };
}

export function boundingBox(points) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i += 3) {
    for (let k = 0; k < 3; k++) {
      const x = points[i + k];
      if (x < low[k]) low[k] = x;
      if (x > high[k]) high[k] = x;
    }
  }
  return { low, high };
}

/** Nodes no mode moves: the supports. */
function heldNodes(basis, nodes, modes) {
  const held = [];
  for (let node = 0; node < nodes; node++) {
    const row = basis.subarray(3 * modes * node, 3 * modes * (node + 1));
    if (row.every((x) => x === 0)) held.push(node);
  }
  return held;
}

/** Pairs of nodes, each once. */
export function uniqueEdges(triangles) {
  const seen = new Set(), edges = [];
  for (let t = 0; t < triangles.length; t += 3) {
    for (let k = 0; k < 3; k++) {
      const [a, b] = [triangles[t + k], triangles[t + ((k + 1) % 3)]].sort((x, y) => x - y);
      const key = a * 4294967296 + b;
      if (!seen.has(key)) edges.push(a, b);
      seen.add(key);
    }
  }
  return Uint32Array.from(edges);
}

/** One corner for each vertex of the drawn surface and smooth patch: `vertexNode`, `vertexLoadable`, and triangles over corners (`vertexCorners`). */
export function splitAtCreases({ rest, triangles, loadable: canBePushed }) {
  const vertexNode = [], vertexLoadable = [], normals = [];
  const patches = new Map();
  const vertexCorners = new Uint32Array(triangles.length);
  const at = (i) => [rest[3 * i], rest[3 * i + 1], rest[3 * i + 2]];
  for (let c = 0; c < triangles.length; c += 3) {
    const [a, b, d] = [at(triangles[c]), at(triangles[c + 1]), at(triangles[c + 2])];
    const normal = unit(cross(sub(b, a), sub(d, a)));
    const loadable = Number(canBePushed(c / 3));
    for (let k = 0; k < 3; k++) {
      const node = triangles[c + k];
      const known = patches.get(node) ?? [];
      patches.set(node, known);
      let vertex = known.find((v) => vertexLoadable[v] === loadable && dot(normals[v], normal) > SMOOTH);
      if (vertex === undefined) {
        vertex = vertexNode.length;
        known.push(vertex);
        vertexNode.push(node);
        vertexLoadable.push(loadable);
        normals.push(normal);
      }
      vertexCorners[c + k] = vertex;
    }
  }
  return { vertexNode: Uint32Array.from(vertexNode), vertexLoadable: Float32Array.from(vertexLoadable), vertexCorners };
}

/** What a push drawn as this share of the body's size shows; the place that gives way most shows no more than `MOST`. */
const SHOWN = 0.07, MOST = 0.15;

/** The loadable node that gives way most along its normal, a round force that moves it by at most 4 % of the body's size, how far [m] that is, and
 * the round magnification that shows this force at most places: static compliance `Σ_k (B_k·n)²/λ_k`. */
function flexiblePoint(body, evaluator, basis) {
  const { modes, loadNodes } = evaluator.counts;
  const table = evaluator.section(SECTION.modeTable);
  const lambda = evaluator.section(SECTION.eigenvalues) ?? (table && table.filter((_, i) => i % 6 === 1));
  const normals = Array.from({ length: loadNodes }, () => [0, 0, 0]);
  for (let t = 0; t < body.loadTriangles; t++) {
    const normal = body.normal(t);
    for (let k = 0; k < 3; k++) {
      const node = body.triangles[3 * t + k];
      normals[node] = add(normals[node], normal);
    }
  }
  let best = { node: 0, compliance: 0, normal: [0, 0, 1] };
  const compliances = [];
  for (let node = 0; lambda && node < loadNodes; node++) {
    const normal = unit(normals[node]);
    let compliance = 0;
    for (let k = 0; k < modes; k++) {
      const along = [0, 1, 2].reduce((sum, c) => sum + basis[(3 * node + c) * modes + k] * normal[c], 0);
      compliance += (along * along) / lambda[k];
    }
    if (compliance > 0) compliances.push(compliance);
    if (compliance > best.compliance) best = { node, compliance, normal };
  }
  const force = best.compliance > 0 ? round125((0.04 * body.size) / best.compliance) : 1;
  const share = (compliance) => (force * compliance) / body.size;
  const median = compliances.sort((a, b) => a - b)[compliances.length >> 1];
  const magnification = median ? Math.max(1, round125(Math.min(SHOWN / share(median), MOST / share(best.compliance)))) : 1;
  const point = { nodes: [best.node, best.node, best.node], weights: [1, 0, 0] };
  return { point, normal: best.normal, force, magnification, moves: force * best.compliance };
}

/** The nearest of 1, 2, 5 times a power of ten below `x`. */
export function round125(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  const lead = x / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}
