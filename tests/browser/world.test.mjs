// The page of a world: bodies fall, are pulled, thrown and let go, and move as `vademecum run` moves them.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { moveSlider, open, VADEMECUM, WORK } from "./browser.mjs";

const WORLD = `file://${WORK}/world.html`;
const state = (page) => page.evaluate(() => window.vademecum.state());
const height = (page, name) => page.evaluate((name) => window.vademecum.pose(name).position[2], name);
const still = (page) => page.evaluate(() => {
  window.vademecum.pause();
  window.vademecum.reset();
});

/** Where the middle of a cube is on the screen, as it is drawn. */
async function pixel(page, name) {
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const [box, at] = [await page.locator("#view").boundingBox(), await page.evaluate((name) => {
    const { stage, crowd, camera, number } = window.vademecum;
    const { first, nodes } = stage.members[number(name)];
    const middle = [0, 1, 2].map((k) => Array.from({ length: nodes }, (_, i) => crowd.displaced[3 * (first + i) + k]).reduce((a, b) => a + b) / nodes);
    return camera.pixel(middle);
  }, name)];
  return { x: box.x + at[0], y: box.y + at[1] };
}

test("the page moves a world as `vademecum run` does, to the last bit", async () => {
  const { page, heard, context } = await open(WORLD);
  const [head, ...rows] = readFileSync(`${WORK}/world.csv`, "utf8").trim().split("\n").map((line) => line.split(","));
  const column = (name) => rows.map((row) => Number(row[head.indexOf(name)]));
  const found = await page.evaluate((steps) => {
    const v = window.vademecum;
    v.pause();
    v.reset();
    const all = [];
    for (let step = 0; step <= steps; step++) {
      if (step > 0) v.step(1);
      const { energy, potential, touches } = v.state();
      const force = touches.filter(({ members: [a, b] }) => (a === 0 && b === 2) || (a === 2 && b === 0)).reduce((sum, { members, force }) => sum + (members[0] === 0 ? 1 : -1) * force[2], 0);
      all.push([energy + potential, force]);
    }
    return all;
  }, rows.length - 1);
  assert.deepEqual(found.map(([energy]) => energy), column("energy_J"));
  const forces = column("force of floor on falling z [N]");
  assert.deepEqual(found.map(([, force]) => force), forces);
  assert.ok(Math.max(...forces) > 1, "it touches the floor");
  assert.deepEqual(heard.errors, []);
  assert.deepEqual(heard.requests, [WORLD]);
  assert.equal(await page.locator("#status").textContent(), "");
  await context.close();
});

test("a cube is pulled by the pointer, and goes on when it is let go", async () => {
  const { page, heard, context } = await open(WORLD);
  await still(page);
  await moveSlider(page, "#gravity", 0);
  const at = await pixel(page, "falling");
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  await page.mouse.move(at.x, at.y - 60, { steps: 4 });
  const [hand, ...others] = (await state(page)).pulls;
  assert.equal(others.length, 0);
  assert.ok(hand.target[2] > hand.place[2] + 0.01, "the hand is above the place that it holds");
  await page.evaluate(() => window.vademecum.step(800));
  const [held] = (await state(page)).pulls;
  const apart = Math.hypot(...held.target.map((x, k) => x - held.place[k]));
  assert.ok(apart < 3e-3 && held.place[2] > hand.place[2] + 0.01, `${apart} ${held.place} ${hand.place}`);
  await page.waitForFunction(() => /falling is pulled with/.test(document.getElementById("held-force").textContent));
  await page.mouse.up();
  assert.equal((await state(page)).pulls.length, 0);
  // A rigid body is pulled, too; the floor is not, and the view turns.
  for (const [name, hands] of [["weight", 1], ["floor", 0]]) {
    const { x, y } = await pixel(page, name);
    const view = await page.evaluate(() => window.vademecum.camera.yaw);
    await page.mouse.move(name === "floor" ? x - 150 : x, name === "floor" ? y + 40 : y);
    await page.mouse.down();
    await page.mouse.move(x + 30, y, { steps: 2 });
    assert.equal((await state(page)).pulls.length, hands, name);
    assert.equal((await page.evaluate(() => window.vademecum.camera.yaw)) !== view, hands === 0, name);
    await page.mouse.up();
  }
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("pause, step, restart, throw, gravity, and a joint that is broken", async () => {
  const { page, heard, context } = await open(WORLD);
  await page.waitForFunction(() => window.vademecum.state().time > 0.02);
  await page.locator("#pause").click();
  const { time } = await state(page);
  await page.locator("#step").click();
  assert.ok(Math.abs((await state(page)).time - time - 1e-3) < 1e-9);
  await page.locator("#rest").click();
  assert.equal((await state(page)).time, 0);
  const start = await height(page, "falling");
  await page.locator("#throw").click();
  await page.evaluate(() => window.vademecum.step(30));
  assert.ok((await height(page, "falling")) > start + 0.01, "it was thrown");
  await page.locator("#rest").click();
  await moveSlider(page, "#gravity", 0);
  const energy = (await state(page)).potential;
  assert.ok(Math.abs(energy) === 0);
  await page.locator("#joints button").first().click();
  assert.deepEqual((await state(page)).joints.map(({ broken }) => broken), [true]);
  await page.waitForFunction(() => /1 joint is broken/.test(document.getElementById("status").textContent));
  assert.equal(await page.locator("#joints button").first().isDisabled(), true);
  await page.locator("#rest").click();
  assert.deepEqual((await state(page)).joints.map(({ broken }) => broken), [false]);
  for (const kind of ["part", "u", "v"]) await page.locator("#color").selectOption(kind);
  await page.locator("#view").focus();
  await page.keyboard.press("?");
  assert.equal(await page.locator("#keys").isVisible(), true);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("a struck cube sounds as its modes do", async () => {
  const { page, context } = await open(WORLD);
  const loud = await page.evaluate(async () => {
    const { sound } = window.vademecum;
    const [{ hertz }] = sound.ringing;
    const samples = await sound.render(0.5, 0, [0, 0, 0.01], { nodes: [0], weights: [1] });
    return { first: Math.min(...hertz), most: samples.reduce((most, x) => Math.max(most, Math.abs(x)), 0) };
  });
  assert.ok(loud.first > 60 && loud.most > 1e-3, JSON.stringify(loud));
  await context.close();
});

test("a served world comes from this machine, and its files with it", async () => {
  const server = spawn(VADEMECUM, ["view", `${WORK}/world.toml`, "--no-open"]);
  const [line] = await once(server.stdout, "data");
  const address = /http:\S+/.exec(String(line))[0];
  const { page, heard, context } = await open(address);
  await page.waitForFunction(() => window.vademecum.state().time > 0);
  assert.deepEqual(heard.errors, []);
  assert.deepEqual(heard.requests, [address, `${address}part-0.vdm`]);
  await context.close();
  server.kill("SIGINT");
  await once(server, "exit");
});
