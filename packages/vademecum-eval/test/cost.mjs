// Time of calls of this package: node cost.mjs FILE.vdm. Of many rounds the fastest counts, which other work has disturbed least.
import { readFileSync } from "node:fs";
import { Body } from "../index.js";

const bytes = readFileSync(process.argv[2]);
const wasm = readFileSync(new URL("../../../crates/vademecum-cli/assets/evaluator.wasm", import.meta.url));
const timed = (repeat, act) => Math.min(...Array.from({ length: 200 }, () => {
  const start = performance.now();
  for (let i = 0; i < repeat; i++) act();
  return 1e6 * (performance.now() - start) / repeat;
}));
console.log("| precision | step, 1 at a time [ns] | step, 100 at a time [ns] | surface [ns] | push and clear [ns] |");
console.log("|---|---|---|---|---|");
for (const precision of ["single", "double"]) {
  const body = await Body.open(bytes, { precision, wasm });
  const { positions } = body;
  const place = body.locate(Array.from(positions.subarray(0, 3)));
  body.push(place, [0, 0, -1]);
  const one = timed(1000, () => body.step());
  const many = timed(50, () => body.step(100)) / 100;
  const surface = timed(20, () => body.surface());
  const push = timed(500, () => {
    body.clear();
    body.push(place, [0, 0, -1]);
  });
  console.log(`| ${precision} | ${[one, many, surface, push].map((x) => Math.round(x)).join(" | ")} |`);
}
