// What a visitor sees first: the pluck, the scale, which way is up, what cannot be pushed, motion between steps, rest.
import assert from "node:assert/strict";
import { test } from "node:test";
import { EXACT, EXPORTED, moveSlider, open, pixel, state, TIP, WORK } from "./browser.mjs";

const text = (page, id) => page.locator(id).textContent();

test("the page opens with a pluck that is let go, and the motion drawn is a visible share of the body", async () => {
  const { page, heard, context } = await open(EXPORTED, { reducedMotion: "no-preference" });
  await page.waitForFunction(() => window.vademecum.greeting.id === null);
  const { contacts, energy } = await state(page);
  assert.equal(contacts, 0);
  assert.ok(energy > 0);
  assert.match(await text(page, "#hint"), /^Press on the body to push it/);
  // The held push of the slider, at the place that gives way most, as it is drawn after it has come to rest.
  const share = await page.evaluate(() => {
    const v = window.vademecum;
    const { size, flexible } = v.player.body;
    v.pause();
    v.rest();
    v.set({ alpha: 300 });
    v.player.press(flexible.point, flexible.normal.map((x) => -flexible.force * x));
    v.step(5000);
    return (v.controls.magnification * Math.hypot(...v.evaluator.point(flexible.point))) / size;
  });
  assert.ok(share > 0.05 && share < 0.16, `${share}`);
  const { magnification } = await page.evaluate(() => window.vademecum.player.body.flexible);
  assert.equal(await text(page, "#true-scale"), `motion drawn × ${magnification}`);
  await page.locator("#true-scale").click();
  assert.equal(await text(page, "#true-scale"), "true scale");
  assert.equal(await page.evaluate(() => window.vademecum.controls.magnification), 1);
  await page.locator("#true-scale").click();
  assert.ok(Math.abs((await page.evaluate(() => window.vademecum.controls.magnification)) / magnification - 1) < 1e-9);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("who asks for less motion meets the body at rest, and the figures say so", async () => {
  const { page, context } = await open(EXPORTED);
  await page.waitForTimeout(300);
  const { energy, contacts } = await state(page);
  assert.deepEqual([energy, contacts], [0, 0]);
  assert.deepEqual([await text(page, "#low"), await text(page, "#high")], ["at rest", ""]);
  await context.close();
});

test("gravity of the file is down; buttons choose another axis and look along each; every change can be undone", async () => {
  const { page, context } = await open(EXPORTED);
  const pose = () => page.evaluate(() => window.vademecum.camera.pose);
  const pixelOf = (point) => page.evaluate((p) => window.vademecum.camera.pixel(p), point);
  const settled = () => page.waitForTimeout(150);
  const first = await pose();
  assert.equal(first.up, 2);
  // A point that lies higher along the axis that is up is drawn higher.
  for (const [name, axis] of [["x", 0], ["y", 1], ["z", 2]]) {
    await page.locator(`#up-${name}`).click();
    await settled();
    const [low, high] = [await pixelOf([0.5, 0.08, 0.05]), await pixelOf([0.5, 0.08, 0.05].map((x, i) => x + (i === axis ? 0.05 : 0)))];
    assert.ok(high[1] < low[1] - 2, `${name}: ${low}, ${high}`);
    assert.equal(await page.locator(`#up-${name}`).getAttribute("aria-pressed"), "true");
  }
  for (const [name, axis] of [["x", 0], ["y", 1], ["z", 2]]) {
    await page.locator(`#from-${name}`).click();
    await settled();
    const back = await page.evaluate(() => Array.from(window.vademecum.camera.view.back));
    back.forEach((x, i) => assert.ok(Math.abs(x - (i === axis ? 1 : 0)) < 1e-9, `${name}: ${back}`));
    await page.locator(`#from-${name}`).click();
    await settled();
    const other = await page.evaluate(() => Array.from(window.vademecum.camera.view.back));
    assert.ok(Math.abs(other[axis] + 1) < 1e-9, `${name}: ${other}`);
  }
  await page.locator("#view").focus();
  await page.keyboard.press("+");
  await page.locator("#home").click();
  await page.evaluate(() => Array.from({ length: 20 }, () => document.getElementById("undo").click()));
  assert.deepEqual(await pose(), first);
  await context.close();
});

test("without gravity a body stands on its supports, and a slender one lies", async () => {
  const { page, context } = await open(EXACT);
  const ways = await page.evaluate(async () => {
    const { upward } = await import("vademecum/views");
    /** A box of these sides with its corners as nodes, held at the lower end of an axis. */
    const box = (sides, axis) => {
      const rest = Array.from({ length: 8 }, (_, c) => sides.map((side, i) => ((c >> i) & 1 ? side : 0))).flat();
      const held = [0, 1, 2, 3, 4, 5, 6, 7].filter((c) => axis !== null && !((c >> axis) & 1));
      return { box: { low: [0, 0, 0], high: sides }, rest, held };
    };
    return [
      upward(box([1, 2, 2], 1), ""), upward(box([1, 2, 2], 2), ""), upward(box([1, 2, 2], null), ""), upward(box([1, 9, 2], 1), ""),
      upward(box([1, 2, 2], 2), "[[load.pattern]]\nacceleration = [0, -9.81, 0.0] # m/s²\n"), upward(box([1, 2, 2], 1), "acceleration = [0, 0, 0]\n"),
    ];
  });
  assert.deepEqual(ways, [1, 2, 2, 2, 1, 1]);
  await context.close();
});

test("the first view shows the side that can be pushed", async () => {
  const { page, context } = await open(EXACT);
  const found = await page.evaluate(async () => {
    const { Camera } = await import("vademecum/camera");
    const box = { low: [0, 0, 0], high: [1, 2, 3] };
    const seen = (up, facing) => {
      const { back } = new Camera(box, up, facing).frame();
      return back.reduce((sum, x, i) => sum + x * facing[i], 0);
    };
    const sides = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
    const usual = new Camera(box, 2).pose, above = new Camera(box, 2, [-0.4, 0, 1]).pose;
    const { player, camera } = window.vademecum;
    return { least: Math.min(...[0, 1, 2].flatMap((up) => sides.map((side) => seen(up, side)))), usual, above, facing: player.body.facing, pose: camera.pose };
  });
  assert.ok(found.least > 0.3, `${found.least}`);
  assert.ok(found.usual.pitch > 0 && found.above.pitch > 0);
  // The top of this beam can be pushed, and nothing else: any view from above will do.
  const [x, y, z] = found.facing;
  assert.ok(Math.abs(x) < 1e-9 && Math.abs(y) < 1e-9 && z > 0.01, `${found.facing}`);
  assert.equal(found.pose.yaw, found.usual.yaw);
  await context.close();
});

test("a body that is pushed far stays in the frame, and the words stay readable over it", async () => {
  const { page, context } = await open(EXACT);
  await page.evaluate((point) => {
    const v = window.vademecum;
    v.controls.magnify(10);
    v.set({ alpha: 300 });
    v.press(point, [0, 0, 2e4]);
  }, TIP);
  await page.waitForFunction(() => document.getElementById("status").textContent.startsWith("Displacement is "));
  await page.waitForTimeout(1500);
  const inside = await page.evaluate(() => {
    const { camera, player } = window.vademecum;
    const { displaced } = player.body;
    return Array.from({ length: displaced.length / 3 }, (_, i) => camera.pixel(displaced.slice(3 * i, 3 * i + 3)))
      .every((at) => at && at[0] >= 0 && at[1] >= 0 && at[0] <= camera.width && at[1] <= camera.height);
  });
  assert.ok(inside);
  const opacity = await page.locator("#status").evaluate((words) => Number(/[\d.]+(?=\)$)/.exec(getComputedStyle(words).backgroundColor)[0]));
  assert.ok(opacity >= 0.8, `${opacity}`);
  await page.screenshot({ path: `${WORK}/far.png` });
  await context.close();
});

test("a press where nothing can be pushed says so, and that part is marked", async () => {
  const { page, context } = await open(EXPORTED);
  assert.ok(await page.locator("#held").isVisible());
  const { x, y } = await pixel(page, TIP);
  // The beam's side, below its loadable top: seen from −y.
  await page.locator("#from-y").click();
  await page.locator("#from-y").click();
  await page.waitForTimeout(150);
  const side = await page.evaluate(() => window.vademecum.camera.pixel([0.5, 0, 0.05]));
  const box = await page.locator("#view").boundingBox();
  await page.mouse.move(box.x + side[0], box.y + side[1]);
  await page.mouse.down();
  assert.equal((await state(page)).contacts, 0);
  assert.match(await text(page, "#hint"), /^This part was not made pushable/);
  await page.mouse.up();
  await page.locator("#home").click();
  await page.waitForTimeout(150);
  await page.mouse.move(x, y);
  await page.mouse.down();
  assert.equal((await state(page)).contacts, 1);
  assert.ok(!/not made pushable/.test(await text(page, "#hint")));
  await page.mouse.up();
  await context.close();
});

test("motion is drawn between steps, and speed is kept where a step takes longer than a frame", async () => {
  const { page, context } = await open(EXACT);
  await page.evaluate((point) => {
    window.vademecum.set({ timeStep: 1e-2 });
    window.vademecum.press(point, [0, 0, -20]);
  }, TIP);
  // A step each two seconds.
  await moveSlider(page, "#speed", Math.log10(0.005));
  await page.waitForFunction(() => window.vademecum.player.before !== null);
  const seen = await page.evaluate(async (point) => {
    const v = window.vademecum;
    const seen = [];
    for (let i = 0; i < 20; i++) {
      await new Promise(requestAnimationFrame);
      seen.push([v.state().steps, v.drawn(point)[2]]);
    }
    return seen;
  }, TIP);
  // The frames between two steps, wherever most of them fell.
  const rows = [...new Set(seen.map(([steps]) => steps))].map((count) => seen.filter(([steps]) => steps === count).map(([, z]) => z));
  const within = rows.sort((a, b) => b.length - a.length)[0];
  assert.ok(within.length > 3 && new Set(within).size > 3, JSON.stringify(seen));
  const turns = within.slice(2).map((z, i) => (z - within[i + 1]) * (within[i + 1] - within[i]));
  assert.ok(turns.every((x) => x >= 0), "straight on between two steps");
  await page.waitForFunction(() => Math.abs(window.vademecum.state().pace?.factor / 0.005 - 1) < 0.2);
  assert.ok((await state(page)).pace.rate > 0);
  await context.close();
});

test("the time step says what it does: exact steps have no time error, those of a scheme leave their certificate", async () => {
  const exact = await open(EXACT);
  assert.match(await text(exact.page, "#step-note"), /^Exact time integration: Δt only sets how often loads can change \(now 1000 times per second\)/);
  await exact.context.close();
  const { page, context } = await open(EXPORTED);
  assert.match(await text(page, "#step-note"), /“bathe” have an error that grows with Δt\. The certificate was made for 1 ms.*”\.$/);
  await page.evaluate(() => window.vademecum.set({ timeStep: 4e-3 }));
  assert.match(await text(page, "#step-note"), /^250 steps .*At this Δt it does not hold\.$/);
  await page.evaluate(() => window.vademecum.set({ structure: 4 }));
  assert.match(await text(page, "#step-note"), /^Exact time integration.*made for 1 ms by “bathe”\.$/);
  await context.close();
});

test("the certificate of a live time step is read as its range", async () => {
  const { page, context } = await open(`file://${WORK}/step.html`);
  assert.match(await text(page, "#step-note"), /The certificate was made for 500 µs to 2 ms by “bathe”\.$/);
  await page.evaluate(() => window.vademecum.set({ timeStep: 0.7e-3 }));
  assert.match(await text(page, "#step-note"), /^1430 steps .*500 µs to 2 ms by “bathe”\.$/);
  await context.close();
});

test("the keys are listed on a question mark, the ground can be taken away, and a push leaves a trail", async () => {
  const { page, heard, context } = await open(EXACT);
  await page.keyboard.press("?");
  assert.ok(await page.locator("#keys").isVisible());
  await page.keyboard.press("Escape");
  assert.ok(!(await page.locator("#keys").isVisible()));
  // Pixels of the lower part of the picture, where only the ground is.
  const drawn = () => page.evaluate(async () => {
    const image = await createImageBitmap(await (await window.vademecum.recorder.picture()));
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, Math.round(0.75 * image.height), image.width, Math.round(0.12 * image.height));
    return new Set(Array.from({ length: data.length / 4 }, (_, i) => `${data.slice(4 * i, 4 * i + 3)}`)).size;
  });
  const ground = await drawn();
  await page.locator("#ground").uncheck();
  const bare = await drawn();
  assert.ok(bare < ground, `${bare} colours, with the ground ${ground}`);
  await page.evaluate((point) => window.vademecum.press(point, [0, 0, -20]), TIP);
  await page.waitForFunction(() => window.vademecum.trail.way.length > 5);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("rest clears scales and plots, and units without a name take no prefix", async () => {
  const { page, context } = await open(EXPORTED);
  await page.evaluate((point) => {
    window.vademecum.press(point, [0, 0, -2e5]);
    window.vademecum.step(300);
  }, TIP);
  await page.waitForFunction(() => /m$/.test(document.getElementById("high").textContent));
  await page.evaluate(() => window.vademecum.player.contacts.clear());
  await page.locator("#pause").click();
  await page.locator("#rest").click();
  await page.waitForFunction(() => document.getElementById("low").textContent === "at rest");
  const { series, time } = await page.evaluate(() => ({ series: window.vademecum.series().time.length, time: window.vademecum.state().time }));
  assert.deepEqual([series, time], [0, 0]);
  await page.evaluate(() => window.vademecum.set({ alpha: 0.457 }));
  assert.equal(await page.locator('label[for="parameter-alpha"] output').textContent(), "0.457 1/s");
  await context.close();
});
