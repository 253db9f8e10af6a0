// What is drawn of a body: the surface of its mesh, or the surface that is embedded in it.
import { SECTION } from "vademecum/evaluator";

/**
 * The drawn surface: `triangles` over its vertices, `rest` and `displaced` positions, `loadable` for each triangle, and `at`, which spreads numbers at
 * the nodes, three each, over the vertices. Without an embedded surface the vertices are the nodes.
 */
export function skinOf(evaluator, { rest, displaced, triangles, loadTriangles }) {
  const nodes = evaluator.section(SECTION.embeddedNodes);
  const weights = evaluator.section(SECTION.embeddedWeights);
  const own = evaluator.section(SECTION.embeddedTriangles);
  if (!nodes || !weights || !own) {
    return { embedded: false, rest, displaced, triangles, loadable: (t) => t < loadTriangles, at: (numbers) => numbers, nodesOf: (vertex) => [vertex] };
  }
  const count = nodes.length / 4;
  const at = (numbers, out) => {
    for (let v = 0; v < count; v++) {
      const [a, b, c, d] = [3 * nodes[4 * v], 3 * nodes[4 * v + 1], 3 * nodes[4 * v + 2], 3 * nodes[4 * v + 3]];
      const wa = weights[4 * v], wb = weights[4 * v + 1], wc = weights[4 * v + 2], wd = weights[4 * v + 3];
      for (let k = 0; k < 3; k++) out[3 * v + k] = wa * numbers[a + k] + wb * numbers[b + k] + wc * numbers[c + k] + wd * numbers[d + k];
    }
    return out;
  };
  const nodesOf = (vertex) => nodes.subarray(4 * vertex, 4 * vertex + 4);
  // A vertex over a loadable triangle follows its three corners.
  const { loadNodes } = evaluator.counts;
  const over = Uint8Array.from({ length: count }, (_, v) => (nodesOf(v).filter((node) => node < loadNodes).length >= 3 ? 1 : 0));
  const loadable = (t) => over[own[3 * t]] + over[own[3 * t + 1]] + over[own[3 * t + 2]] === 3;
  const atRest = at(rest, new Float64Array(3 * count));
  return { embedded: true, rest: atRest, displaced: Float64Array.from(atRest), triangles: own, loadable, at, nodesOf };
}

/** The first triangle of a surface that a ray meets, as `{ triangle, weights }`; null if it passes by. Plain numbers: fine surfaces are asked at each move. */
export function firstMet(triangles, x, { from: [fx, fy, fz], along: [lx, ly, lz] }) {
  let best = null;
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t], b = 3 * triangles[t + 1], c = 3 * triangles[t + 2];
    const bx = x[b] - x[a], by = x[b + 1] - x[a + 1], bz = x[b + 2] - x[a + 2];
    const cx = x[c] - x[a], cy = x[c + 1] - x[a + 1], cz = x[c + 2] - x[a + 2];
    const px = ly * cz - lz * cy, py = lz * cx - lx * cz, pz = lx * cy - ly * cx;
    const determinant = bx * px + by * py + bz * pz;
    if (determinant === 0) continue;
    const ax = fx - x[a], ay = fy - x[a + 1], az = fz - x[a + 2];
    const v = (ax * px + ay * py + az * pz) / determinant;
    if (v < 0 || v > 1) continue;
    const qx = ay * bz - az * by, qy = az * bx - ax * bz, qz = ax * by - ay * bx;
    const w = (lx * qx + ly * qy + lz * qz) / determinant;
    const distance = (cx * qx + cy * qy + cz * qz) / determinant;
    if (w < 0 || v + w > 1 || distance <= 0 || (best && distance >= best.distance)) continue;
    best = { triangle: t / 3, distance, weights: [1 - v - w, v, w] };
  }
  return best;
}
