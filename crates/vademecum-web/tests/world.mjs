// node world.mjs MODULE.wasm CUBE.vdm OUT: marches a small world in the module, with all that a page does to it, and writes every number as
// little-endian f64. tests/world.rs does the same with the stage compiled for this machine.
import { readFileSync, writeFileSync } from "node:fs";
import { Stage, staged } from "../../../packages/vademecum-eval/stage.js";

const [wasm, file, out] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(readFileSync(wasm), {});
const box = (lengths) => ({
  nodes: Array.from({ length: 8 }, (_, i) => lengths.map((x, k) => ((i >> k) & 1 ? x : 0))),
  triangles: [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]],
});
const body = (start) => ({ file: 0, nodes: [], triangles: [], mass: null, start, stops: null, shake: [] });
const units = [1, 0, 0, 0, 1, 0, 0, 0, 1];
const scene = {
  step: 1e-3, gravity: [0, 0, -9.81], reach: null, tolerance: null, sweeps: 300, contacts: 128,
  members: [
    body([0, 0, 0.001, 1, 0, 0, 0, 0.3, 0, 0, 0, 0, 0]),
    body([0.01, 0.005, 0.05, 0.6, 0.8, 0, 0, 0, 0, -0.5, 1, 2, 3]),
    { file: null, ...box([0.4, 0.4, 0.1]), mass: null, start: [-0.2, -0.2, -0.1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0], stops: [[0, 0, 0, 0], [0.2, 0, 0, 0.01], [0.3, 0, 0, 0]], shake: [0.002, 0, 0, 20, 0.1] },
    { file: null, ...box([0.02, 0.02, 0.02]), mass: [0.05, 0.01, 0.01, 0.01, 4e-6, 4e-6, 4e-6, ...units], start: [0.1, 0, 0.1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0], stops: null, shake: [] },
  ],
  pairs: [[0, 1, 0.4, 0.5, 0], [0, 2, 0.5, 0, 1], [1, 2, 0.3, 0.7, 1], [0, 3, 0.2, 1, 2]],
  joints: [
    { kind: 0, members: [0, 3], numbers: [0, -1, 0, ...Stage.side({ port: 0 }), ...Stage.side({ at: [-0.06, 0.02, -0.079] })] },
    { kind: 3, members: [1, 2], numbers: [1e-3, 0.4, 0.25, ...Stage.side({ port: 0 }), ...Stage.side({ at: [0.2, 0.2, 0.35] })] },
  ],
};
const stage = staged(instance.exports, scene, [readFileSync(file)]);
const numbers = [];
const look = () => {
  const { time, contacts, pressed, leftOut, sweeps, converged, deepest, givenAway, jointsBroken, energy, potential } = stage.report();
  numbers.push(time, contacts, pressed, leftOut, sweeps, converged ? 1 : 0, deepest, givenAway, jointsBroken, energy, potential);
  for (const { position, rotation } of stage.poses()) numbers.push(...position, ...rotation);
  for (const { members, place, force, pressure } of stage.touches()) numbers.push(...members, ...place, ...force, pressure);
  for (const { force, broken } of stage.jointStates()) numbers.push(...force, broken ? 1 : 0);
  for (const { place, target, force } of stage.pulls()) numbers.push(...place, ...target, ...force);
  for (const { member, impulse, place } of stage.strikes()) numbers.push(member, ...impulse, ...place.nodes, ...place.weights);
};
const march = (rounds) => {
  for (let round = 0; round < rounds; round++) {
    stage.step(10);
    look();
  }
};
look();
march(20);
stage.pull(1, 0, { nodes: [0, 1, 2], weights: [0.2, 0.3, 0.5] }, { target: [0, 0, 0.1], stiffness: 40, damping: 0.5 });
stage.pull(2, 3, [0.02, 0.01, 0], { target: [0.1, 0.1, 0.1], stiffness: 20, damping: 0.2 });
march(10);
stage.movePull(1, [0.05, 0, 0.12]);
march(10);
stage.release(1);
stage.breakJoint(0);
stage.throw(1, [0, 0, 1], [5, 0, 0]);
stage.setGravity([0, 0, -3]);
march(5);
const saved = stage.save();
march(5);
stage.restore(saved);
march(5);
for (const velocity of [false, true]) {
  const { nodes, field } = stage.surfaces(velocity);
  numbers.push(...nodes, ...field);
}
stage.reset();
stage.release(2);
stage.setGravity([0, 0, -9.81]);
look();
march(5);
writeFileSync(out, Buffer.from(Float64Array.from(numbers).buffer));
