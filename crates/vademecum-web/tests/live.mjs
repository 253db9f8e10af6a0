// node live.mjs MODULE.wasm FILE.vdm OUT: sets live regions while the body moves, in both precisions, and writes every number as
// little-endian f64. tests/bits.rs does the same with the evaluator compiled for this machine.
import { readFileSync, writeFileSync } from "node:fs";
import { Evaluator, Refused } from "../../vademecum-cli/assets/page/evaluator.js";

const [wasm, file, out] = process.argv.slice(2);
const evaluator = await Evaluator.open(readFileSync(wasm), readFileSync(file));
const numbers = [];
const pull = () => evaluator.pushPattern(0, 1);
for (const double of [false, true]) {
  evaluator.bind({ double });
  pull();
  numbers.push(...evaluator.record(5).rows);
  evaluator.setParameters([[1, 3], [3, 1e-5]], pull);
  numbers.push(...evaluator.record(5).rows, ...evaluator.parameters.map((known) => evaluator.value(known)));
  try {
    evaluator.setParameters([[0, 1.5], [1, 9]], pull);
    throw new Error("a value out of its range is set");
  } catch (error) {
    if (!(error instanceof Refused) || evaluator.options.values[0] !== 1) throw error;
  }
  numbers.push(...evaluator.record(5).rows, ...evaluator.surface());
}
// Other options are bound at the same parameters, and the motion goes on.
const before = evaluator.point({ nodes: [0], weights: [1] });
evaluator.rebind({ double: false }, pull);
const after = evaluator.point({ nodes: [0], weights: [1] });
if (evaluator.options.values[1] !== 3 || before.some((x, i) => Math.abs(x - after[i]) > 1e-5 * Math.abs(x))) throw new Error("the motion is another");
writeFileSync(out, new Float64Array(numbers));
