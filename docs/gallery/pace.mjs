// node pace.mjs FOLDER: processor time of a step of each world of the gallery, from its page in FOLDER, in Node beside real time.
import { readFileSync } from "node:fs";
import { staged } from "../../packages/vademecum-eval/stage.js";

console.log("| world | bodies | step [ms] | contacts at most | time of a step [ms] | real time |");
console.log("|---|---|---|---|---|---|");
for (const [world, seconds] of [["tower", 3], ["chain", 2], ["gripper", 2], ["xylophone", 2], ["pile", 1]]) {
  const page = readFileSync(`${process.argv[2]}/${world}.html`, "utf8");
  const bytes = (text) => Uint8Array.from(Buffer.from(text, "base64"));
  const inside = (id) => new RegExp(`<script id="${id}"[^>]*>(.*?)</script>`, "s").exec(page)[1];
  const scene = JSON.parse(inside("plan"));
  const files = [...page.matchAll(/<script data-file[^>]*>([^<]*)<\/script>/g)].map(([, text]) => bytes(text));
  const { instance } = await WebAssembly.instantiate(bytes(inside("wasm")), {});
  const stage = staged(instance.exports, scene, files);
  const steps = Math.round(seconds / scene.step);
  let [contacts, spent] = [0, 0];
  for (let step = 0; step < steps; step++) {
    const start = process.cpuUsage();
    stage.step(1);
    spent += process.cpuUsage(start).user / 1e6;
    contacts = Math.max(contacts, stage.report().contacts);
  }
  const bodies = scene.members.filter(({ file }) => file !== null).length;
  const each = (1e3 * spent) / steps;
  console.log(`| ${world} | ${bodies} | ${1e3 * scene.step} | ${contacts} | ${Number(each.toPrecision(2))} | × ${Number(((1e3 * scene.step) / each).toPrecision(2))} |`);
}
