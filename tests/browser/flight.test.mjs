// A free body on the page: it is thrown, tumbles, rings and comes back.
import assert from "node:assert/strict";
import { test } from "node:test";
import { EXPORTED, FREE, open } from "./browser.mjs";

test("a free body is thrown: it rises and falls, keeps its angular momentum, swings, and lands where it was", async () => {
  const { page, heard, context } = await open(FREE);
  assert.equal(await page.locator("#throw").isVisible(), true);
  // The patterns of the angular velocity are not offered as loads.
  assert.equal(await page.locator("#patterns input").count(), 1);
  const flown = await page.evaluate(() => {
    const v = window.vademecum;
    const { player } = v;
    v.pause();
    v.rest();
    const corner = [0.3, 0.03, 0.02];
    const before = v.drawn(corner);
    document.getElementById("throw").click();
    const { flight } = player;
    const [gravity, velocity, turning] = [flight.gravity, flight.velocity, flight.turning].map((x) => [...x]);
    const up = v.camera.up;
    // Before it comes back, however slow the page is set.
    const steps = Math.round((-0.8 * velocity[up]) / gravity[up] / player.timeStep);
    v.step(steps);
    const seconds = steps * player.timeStep;
    const expected = velocity[up] * seconds + (gravity[up] * seconds ** 2) / 2;
    const turned = Math.hypot(...flight.turning.map((x, i) => x - turning[i])) / Math.hypot(...turning);
    const length = Math.hypot(...flight.attitude);
    const middle = { rise: flight.moved[up] / expected - 1, turned, length, energy: v.state().energy, attitude: [...flight.attitude] };
    // One frame, drawn where the body is.
    player.flight.flying && v.controls.pause(false);
    return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => {
      v.pause();
      const there = v.drawn(corner);
      while (flight.flying) v.step(160);
      done({ ...middle, before, there, landed: flight.moved, energyAfter: v.state().energy, errors: v.state().refusal });
    })));
  });
  assert.ok(Math.abs(flown.rise) < 1e-9, `${flown.rise}`);
  assert.ok(flown.turned < 1e-12 && Math.abs(flown.length - 1) < 1e-12, `${flown.turned} ${flown.length}`);
  assert.ok(Math.abs(flown.attitude[0]) < 0.999, "it turns");
  assert.ok(flown.energy > 0 && flown.energyAfter > 0, "it swings");
  assert.ok(Math.hypot(...flown.there.map((x, i) => x - flown.before[i])) > 0.05, "it is drawn where it flies");
  assert.deepEqual(flown.landed, [0, 0, 0]);
  assert.equal(flown.errors, "");
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("a push in the air moves the whole body by its impulse", async () => {
  const { page, context } = await open(FREE);
  const pushed = await page.evaluate(() => {
    const v = window.vademecum;
    v.pause();
    v.rest();
    const { flight } = v.player;
    flight.throw([0, 0, 0], [0, 0, 0], [0, 0, 0]);
    v.press([0.3, 0.015, 0.02], [0, 0, -0.01]);
    v.step(160);
    const mass = 1000 * 0.3 * 0.03 * 0.02;
    return { speed: flight.velocity[2] / ((-0.01 * 160 * v.player.timeStep) / mass) - 1, spin: flight.spin };
  });
  assert.ok(Math.abs(pushed.speed) < 1e-3, `${pushed.speed}`);
  // Down at the far end: it turns about y.
  assert.ok(pushed.spin[1] > 0 && Math.abs(pushed.spin[0]) < 1e-3 * pushed.spin[1], `${pushed.spin}`);
  await context.close();
});

test("a body that is held cannot be thrown", async () => {
  const { page, context } = await open(EXPORTED);
  assert.equal(await page.locator("#throw").isVisible(), false);
  await context.close();
});
