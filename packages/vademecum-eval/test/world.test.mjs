// Worlds of the package as it is installed from its tarball (INSTALLED is a folder with node_modules), on the cube in WORK.
import assert from "node:assert/strict";
import { createServer } from "node:http";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { extname, join, normalize } from "node:path";
import { after, before, test } from "node:test";
import { cubes, fall } from "./fall.js";

const { INSTALLED, WORK } = process.env;
const here = import.meta.dirname ?? new URL(".", import.meta.url).pathname;
const installed = createRequire(`${INSTALLED}/`);
const { World, Refused } = await import(installed.resolve("vademecum-eval/world"));
const { chromium } = installed("playwright-core");
const cube = readFileSync(`${WORK}/cube.vdm`);
const WEIGHT = 9.81 * 1000 * 0.04 ** 3;
const refused = (call, words) => assert.throws(call, (error) => error instanceof Refused && words.test(error.message), String(words));

let server, browser, address;
before(async () => {
  const kinds = { ".js": "text/javascript", ".wasm": "application/wasm" };
  server = createServer((request, answer) => {
    const path = normalize(new URL(request.url, "http://x").pathname);
    const folder = path.startsWith("/test/") ? join(here, "..") : path.endsWith(".vdm") ? WORK : INSTALLED;
    try {
      const bytes = path === "/" ? "<!doctype html><title>empty</title>" : readFileSync(join(folder, path));
      answer.writeHead(200, { "content-type": kinds[extname(path)] ?? (path === "/" ? "text/html" : "application/octet-stream") }).end(bytes);
    } catch {
      answer.writeHead(404).end();
    }
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  address = `http://127.0.0.1:${server.address().port}`;
  browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox"] });
});
after(async () => {
  await browser?.close();
  server?.close();
});

test("two cubes come to rest on a floor, which carries the weight of both", async () => {
  const { world, below, above, floor } = await cubes(World, cube);
  world.step(2000);
  const { report, touches, poses } = world;
  assert.ok(report.converged && report.deepest < 1e-4, JSON.stringify(report));
  const on = (a, b) => touches.filter(({ members }) => members.includes(a) && members.includes(b))
    .reduce((sum, { members, force }) => sum + (members[0] === a ? 1 : -1) * force[2], 0);
  for (const [force, wanted] of [[on(below, floor), 2 * WEIGHT], [on(above, below), WEIGHT]]) {
    assert.ok(Math.abs(force / wanted - 1) < 0.01, `${force} ${wanted}`);
  }
  assert.ok(Math.abs(poses[above].position[2] - 0.04) < 1e-3 && report.energy < 1e-3 * WEIGHT);
  const { nodes } = world.surfaces();
  const { first, nodes: count, mass } = world.members[above];
  const lowest = Math.min(...Array.from({ length: count }, (_, i) => nodes[3 * (first + i) + 2]));
  assert.ok(Math.abs(lowest - 0.04) < 1e-3 && Math.abs(mass - 0.064) < 1e-9, `${lowest} ${mass}`);
  assert.equal(world.triangles(floor), null);
  assert.ok(Math.max(...world.triangles(below)) < count);
});

test("Node and a page give the same bits", async () => {
  const wanted = await fall(World, cube);
  assert.ok(wanted.split(" ").length > 1000);
  const page = await browser.newPage();
  await page.goto(address);
  const onPage = await page.evaluate(async () => {
    const { World } = await import("/node_modules/vademecum-eval/world.js");
    const { fall } = await import("/test/fall.js");
    return fall(World, await (await fetch("/cube.vdm")).arrayBuffer());
  });
  assert.equal(onPage, wanted);
});

test("a joint by the name of a port holds, breaks above its force, and a body is led and thrown", async () => {
  const world = await World.create({ step: 1e-3, gravity: [0, 0, -9.81] });
  const file = await world.open(cube);
  const [hung, other] = [world.add(file), world.add(file, { position: [0.2, 0, 0] })];
  const hook = world.addRigid({ nodes: [], triangles: [], path: [[0.5, 0, 0, 0], [1, 0, 0, 0.1]] });
  const strong = world.join("ball", { member: hung, port: "pin" }, { member: hook, at: [0.04, 0.02, 0.02] }, { breaksAt: 5 * WEIGHT });
  const weak = world.join("cable", { member: other, port: "pin" }, { member: hook, at: [0.24, 0.02, 0.12] }, { length: 0.15, breaksAt: 0.5 * WEIGHT });
  world.step(400);
  assert.deepEqual(world.joints.map(({ broken }) => broken), [false, true]);
  assert.equal(world.report.jointsBroken, 1);
  assert.ok(world.joints[strong].force[2] > 0 && world.joints[weak].force.every((x) => x === 0));
  world.step(800);
  assert.ok(Math.abs(world.poses[hook].position[2] - 0.1) < 1e-12, "the hook was led");
  const before = world.poses[hung].position;
  world.breakJoint(strong);
  world.setGravity([0, 0, 0]);
  world.throw(hung, [1, 0, 0]);
  world.step(100);
  assert.ok(Math.abs(world.poses[hung].position[0] - before[0] - 0.1) < 1e-9);
  const saved = world.save();
  world.step(50);
  const later = world.save();
  world.restore(saved);
  world.step(50);
  assert.deepEqual(world.save(), later);
  world.reset();
  assert.deepEqual(world.joints.map(({ broken }) => broken), [false, false]);
});

test("refusals in words", async () => {
  const { world, file, above, floor } = await cubes(World, cube);
  refused(() => world.add(7), /file is 7; expected a number that `open` gave/);
  refused(() => world.add(file, { place: [0, 0, 0] }), /no key of a body "place"; there are position/);
  refused(() => world.add(file, { position: [0, 0] }), /position is \[0,0\]; expected 3 finite numbers/);
  refused(() => world.add(file, { path: [[0, 0, 0, 1]] }), /does not move so/);
  refused(() => world.touch(0, 9), /no member 9; the world has/);
  refused(() => world.join("weld", { member: 0, port: "pin" }, { member: floor, at: [0, 0, 0] }), /no joint "weld"; there are ball/);
  refused(() => world.join("ball", { member: 0, port: "pan" }, { member: floor, at: [0, 0, 0] }), /no port "pan"; it has pin/);
  refused(() => world.join("ball", { member: 0, port: "pin" }, { member: floor }), /point of a rigid body is undefined/);
  const late = await cubes(World, cube);
  late.world.step();
  refused(() => late.world.add(late.file), /has begun/);
  refused(() => late.world.pull(1, above, { nodes: [0], weights: [1] }, { target: [0, 0, 0], stiffness: 0 }), /stiffness is 0/);
  refused(() => late.world.pull(1, floor, [0, 0, 0], { target: [0, 0, NaN], stiffness: 1 }), /target/);
  refused(() => late.world.movePull(5, [0, 0, 0]), /no hand 5/);
  refused(() => late.world.throw(late.floor, [0, 0, 1]), /does not move so/);
  refused(() => late.world.restore(new Uint8Array(3)), /state is that of another world/);
  await assert.rejects(World.create({ stp: 1 }), /no option "stp"/);
  await assert.rejects(World.create({}), /step is undefined/);
  await assert.rejects(late.world.open(cube), /has begun/);
  const damaged = Uint8Array.from(cube);
  damaged[damaged.length - 100] ^= 1;
  await assert.rejects((await World.create({ step: 1e-3 })).open(damaged), Refused);
});
