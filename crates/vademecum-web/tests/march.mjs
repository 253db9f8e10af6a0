// node march.mjs MODULE.wasm FILE.vdm OUT: marches the file in all precisions and structures with fixed contacts and writes
// every number as little-endian f64. tests/bits.rs does the same with the evaluator compiled for this machine.
import { readFileSync, writeFileSync } from "node:fs";
import { Evaluator } from "../../vademecum-cli/assets/page/evaluator.js";

const [wasm, file, out] = process.argv.slice(2);
const evaluator = await Evaluator.open(readFileSync(wasm), readFileSync(file));
const numbers = [];
const named = (name) => evaluator.quantities.find((quantity) => quantity.name === name);
const contact = { nodes: [1, 4, 3], weights: [0.25, 0.5, 0.25] };
for (const double of [false, true]) {
  for (const structure of [1, 2, 4]) {
    evaluator.bind({ double, structure });
    evaluator.watch(contact, [0.6, 0, 0.8]);
    evaluator.push(contact, [1.0, -2.0, 0.7]);
    evaluator.pushPattern(0, -0.3);
    numbers.push(...evaluator.record(100).rows);
    const saved = evaluator.save();
    numbers.push(...saved);
    evaluator.clear();
    evaluator.march(5000);
    numbers.push(...evaluator.record(3).rows, ...evaluator.surface(false));
    numbers.push(...evaluator.surface(true), ...evaluator.coordinates());
    evaluator.restore(saved);
    for (const total of evaluator.totals) numbers.push(...evaluator.read(total));
    numbers.push(...evaluator.read(named("whole"), 0, true), ...evaluator.read(named("node"), 7));
  }
}
evaluator.bind({ double: true, structure: 1, timeStep: 0.003, stiffness: 2.5, density: 0.7, alpha: 0.9, beta: 1e-5 });
evaluator.push(contact, [1.0, -2.0, 0.7]);
numbers.push(...evaluator.record(100).rows, ...evaluator.locate([0.3, 0.2, 0.9]).position);
for (const double of [false, true]) {
  evaluator.bind({ double, structure: 4, alpha: 0 });
  evaluator.pushPattern(0, -0.3);
  const [x, y, z] = evaluator.locate([0.3, 0.2, 0.9]).position;
  evaluator.holdTool({ radius: 0.2, friction: 0.3, speed: 2, centre: [x, y, z + 0.21], target: [x + 0.1, y, z + 0.15] });
  for (let step = 0; step < 40; step++) {
    evaluator.march(1);
    const { centre, deepest, touches } = evaluator.tool();
    numbers.push(...centre, deepest, ...touches.flatMap(({ place, force }) => [...place, ...force]), evaluator.energy());
  }
  evaluator.liftTool();
  numbers.push(...evaluator.record(3).rows);
}
writeFileSync(out, Buffer.from(Float64Array.from(numbers).buffer));
