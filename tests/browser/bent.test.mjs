// Large displacements on the page: a strip bends by more than a right angle.
import assert from "node:assert/strict";
import { test } from "node:test";
import { BENT, open } from "./browser.mjs";

test("a strip bends by more than a right angle, stays finite and is not called linear", async () => {
  const { page, heard, context } = await open(BENT);
  const bent = await page.evaluate(() => {
    const v = window.vademecum;
    v.pause();
    v.rest();
    const [tip, before] = [[1.0, 0.08, 0.06], [0.9, 0.08, 0.06]];
    const slope = () => {
      const [a, b] = [before, tip].map((point) => v.at(point).map((u, i) => point[i] + u));
      return (180 / Math.PI) * Math.atan2(b[2] - a[2], b[0] - a[0]);
    };
    const start = slope();
    // Upwards first, then back over the support.
    v.press(tip, [0, 0, 20]);
    let largest = 0;
    for (let k = 0; k < 200; k++) {
      if (k === 20) v.press(tip, [-20, 0, 0]);
      v.step(1);
      largest = Math.max(largest, slope());
    }
    const { structure, energy, refusal } = v.state();
    v.controls.warn(v.controls.largest);
    const { magnification } = v.controls;
    return { start, largest, magnification, structure, energy, refusal, status: document.getElementById("status").textContent };
  });
  assert.deepEqual([bent.structure, bent.magnification], [5, 1]);
  assert.ok(Math.abs(bent.start) < 1e-6, `${bent.start}`);
  assert.ok(bent.largest > 90 && bent.largest < 360, `${bent.largest} degrees`);
  assert.ok(Number.isFinite(bent.energy) && bent.energy > 0);
  assert.equal(bent.refusal, "");
  assert.ok(!/linear/.test(bent.status), bent.status);
  assert.match(await page.locator("#modes").textContent(), /16, large displacements/);
  assert.deepEqual(heard.errors, []);
  await context.close();
});
