// The page in Chromium. Times and frames are not asserted (software drawing on a busy machine), states and step rates are.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { once } from "node:events";
import { readFileSync, writeFileSync } from "node:fs";
import { test } from "node:test";
import { browser, EXACT, EXPORTED, moveSlider, open, pixel, state, TIP, VADEMECUM, WORK } from "./browser.mjs";

/** Frequency [Hz] of a series: upward crossings of zero, placed between steps. */
function frequency({ time, values }) {
  const crossings = [];
  for (let i = 1; i < values.length; i++) {
    if (values[i - 1] < 0 && values[i] >= 0) {
      crossings.push(time[i - 1] + ((time[i] - time[i - 1]) * -values[i - 1]) / (values[i] - values[i - 1]));
    }
  }
  return (crossings.length - 1) / (crossings.at(-1) - crossings[0]);
}

/** Presses at the tip, lets the push settle into motion, releases, and takes the tip's series over 4000 steps. */
const ring = (page) => page.evaluate((point) => {
  const v = window.vademecum;
  v.pause();
  v.rest();
  const id = v.press(point, [0, 0, -20]);
  v.step(20);
  v.release(id);
  const start = v.series().time.length;
  v.step(4000);
  const { time, columns } = v.series();
  return { time: time.slice(start), values: columns.tip.slice(start) };
}, TIP);

// Bathe's scheme stretches a period by Ω²/24 (docs/explanation). Crossings over N periods are off by at most one period's share
// that the other modes can shift: 0.05 each end if they carry less than a third of the amplitude.
const stretched = (hertz, timeStep) => hertz / (1 + (2 * Math.PI * hertz * timeStep) ** 2 / 24);
const CROSSING = 2 * 0.05;

test("the exported page runs from disk, without network and without a word on the console", async () => {
  const { page, heard, context } = await open(EXPORTED);
  await page.waitForTimeout(300);
  assert.deepEqual(heard.errors, []);
  assert.deepEqual(heard.requests, [EXPORTED]);
  assert.equal(await page.locator("#status").textContent(), "");
  await context.close();
});

for (const [address, run] of [[EXPORTED, "run"], [EXACT, "run-exact"]]) test(`${run}: a push bends the beam down by what \`vademecum run\` says`, async () => {
  const { page, context } = await open(address);
  const lines = readFileSync(`${WORK}/${run}/probes.csv`, "utf8").trim().split("\n").map((line) => line.split(","));
  const place = lines[0].indexOf("tip [m]");
  const expected = lines.slice(2).map((line) => Number(line[place]));
  for (const [double, tolerance] of [[true, 1e-8], [false, 1e-5]]) {
    const found = await page.evaluate(([point, double, n]) => {
      const v = window.vademecum;
      v.pause();
      v.set({ double });
      v.rest();
      v.press(point, [0, 3, -20]);
      v.step(n);
      return v.series().columns.tip;
    }, [TIP, double, expected.length]);
    assert.equal(found.length, expected.length);
    const largest = Math.max(...expected.map(Math.abs));
    assert.ok(Math.min(...expected) < -1e-4, "the push is downwards and visible");
    // The table is printed with ten digits; binary32 rounds each of 200 steps.
    const apart = Math.max(...found.map((x, i) => Math.abs(x - expected[i]))) / largest;
    assert.ok(apart <= tolerance, `${double ? 64 : 32} bit: ${apart}`);
  }
  await context.close();
});

for (const [address, scheme] of [[EXPORTED, "Bathe"], [EXACT, "exact"]]) test(`${scheme}: released, it rings at the first frequency; a slider at four times the stiffness doubles it`, async () => {
  const { page, context } = await open(address);
  const { modes, options, structure } = await state(page);
  assert.equal(structure, scheme === "exact" ? 4 : 1);
  const period = (hertz, timeStep) => scheme === "exact" ? hertz : stretched(hertz, timeStep);
  const first = Math.min(...modes);
  const series = await ring(page);
  const found = frequency(series);
  const periods = found * (series.time.at(-1) - series.time[0]);
  const expected = period(first, options.timeStep);
  assert.ok(Math.abs(found / expected - 1) < CROSSING / periods, `${found} Hz, expected ${expected}`);

  await moveSlider(page, "#parameter-stiffness", Math.log10(4));
  assert.equal(Number((await state(page)).options.stiffness.toPrecision(12)), 4);
  const stiff = frequency(await ring(page));
  const doubled = period(2 * first, options.timeStep);
  assert.ok(Math.abs(stiff / doubled - 1) < CROSSING / (2 * periods), `${stiff} Hz, expected ${doubled}`);

  await moveSlider(page, "#parameter-stiffness", 0);
  await moveSlider(page, "#parameter-density", Math.log10(4));
  const heavy = frequency(await ring(page));
  const halved = period(first / 2, options.timeStep);
  assert.ok(Math.abs(heavy / halved - 1) < CROSSING / (periods / 2), `${heavy} Hz, expected ${halved}`);
  await context.close();
});

test("a parameter changed in motion keeps displacement and velocity; one the structure cannot take is refused", async () => {
  const { page, context } = await open(EXPORTED);
  const [before, after, refused] = await page.evaluate((point) => {
    const v = window.vademecum;
    v.pause();
    v.press(point, [0, 0, -20]);
    v.step(17);
    const before = Array.from(v.evaluator.coordinates());
    v.set({ timeStep: 2.5e-4, alpha: 3 });
    const after = Array.from(v.evaluator.coordinates());
    v.set({ structure: 2, timeStep: 1e-3, alpha: 0 });
    v.set({ stiffness: 2 });
    return [before, after, v.state()];
  }, TIP);
  const largest = Math.max(...before.map(Math.abs));
  before.forEach((x, i) => assert.ok(Math.abs(x - after[i]) <= 4 * Number.EPSILON * largest));
  assert.match(refused.refusal, /^Refused: /);
  assert.equal(refused.options.stiffness, 1);
  assert.equal(refused.structure, 2);
  await page.waitForFunction(() => document.getElementById("status").textContent.startsWith("Refused: "));
  await context.close();
});

test("the file's own parameters are sliders with the file's range", async () => {
  const { page, heard, context } = await open(`file://${WORK}/regions.html`);
  const { options } = await state(page);
  const built = frequency(await ring(page));
  await moveSlider(page, "#parameter-regionStiffness-1", Math.log10(2));
  const outer = frequency(await ring(page));
  await moveSlider(page, "#parameter-regionStiffness-0", Math.log10(2));
  const series = await ring(page);
  const both = frequency(series);
  // All regions at twice the stiffness are the body at twice the stiffness; one region alone lies between (Rayleigh).
  const periods = both * (series.time.at(-1) - series.time[0]);
  const expected = stretched(Math.SQRT2 * built, options.timeStep) / stretched(1, built * options.timeStep);
  assert.ok(Math.abs(both / expected - 1) < (2 * CROSSING) / periods, `${both} Hz, expected ${expected}`);
  assert.ok(built * 1.001 < outer && outer < both / 1.001, `${built} < ${outer} < ${both}`);
  const refused = await page.evaluate(() => {
    window.vademecum.set({ regionStiffness: [2.5, 2.5, 1, 1, 1, 1, 1, 1] });
    return window.vademecum.state();
  });
  assert.match(refused.refusal, /^Refused: /);
  assert.equal(Number(refused.options.regionStiffness[0].toPrecision(12)), 2);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("live regions are sliders while the body moves, and a random body draws all of them", async () => {
  const { page, heard, context } = await open(`file://${WORK}/live.html`);
  const built = frequency(await ring(page));
  for (const region of [0, 1]) await moveSlider(page, `#parameter-regionStiffness-${region}`, Math.log10(2));
  const series = await ring(page);
  const both = frequency(series);
  const periods = both * (series.time.at(-1) - series.time[0]);
  assert.ok(Math.abs(both / (Math.SQRT2 * built) - 1) < (2 * CROSSING) / periods, `${both} Hz, ${Math.SQRT2} of ${built}`);
  const { options, modes } = await state(page);
  await page.evaluate(() => document.getElementById("random").click());
  const drawn = await state(page);
  assert.equal(drawn.refusal, "");
  assert.ok(drawn.options.values.every((value, i) => value >= 0.5 && value <= 2 && value !== options.values[i]), String(drawn.options.values));
  assert.notDeepEqual(drawn.modes, modes);
  const refused = await page.evaluate(() => {
    window.vademecum.set({ values: [2.5, 1] });
    return window.vademecum.state();
  });
  assert.match(refused.refusal, /^Refused: /);
  assert.deepEqual(refused.options.values, drawn.options.values);
  await page.evaluate(() => window.vademecum.step(100));
  await page.evaluate(() => document.getElementById("reset").click());
  assert.deepEqual((await state(page)).options.values, [1, 1]);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("a mouse press pushes down where it points and the release lets it ring", async () => {
  const { page, heard, context } = await open(EXPORTED);
  const { x, y } = await pixel(page, TIP);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.waitForFunction(() => window.vademecum.at([1, 0.08, 0.1])[2] < -1e-3);
  assert.equal((await state(page)).contacts, 1);
  await page.screenshot({ path: `${WORK}/press.png` });
  await page.mouse.up();
  await page.waitForFunction(() => window.vademecum.state().contacts === 0);
  const { energy, time } = await state(page);
  assert.ok(energy > 0);
  await page.waitForFunction((t) => window.vademecum.state().time > t, time);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

/** The forces [N] of all contacts. */
const forces = (page) => page.evaluate(() => [...window.vademecum.player.contacts.values()].map(({ force }) => Array.from(force)));
const length = (v) => Math.hypot(...v);
const near = (found, expected, size) => found.forEach((x, i) => assert.ok(Math.abs(x - expected[i]) <= 1e-9 * size, `${found}, expected ${expected}`));

test("a press pushes into the surface, along an axis or where it is dragged, with the size that is set", async () => {
  const { page, heard, context } = await open(EXPORTED);
  await page.evaluate(() => window.vademecum.pause());
  const { x, y } = await pixel(page, TIP);
  const press = async (direction, [dx, dy]) => {
    await page.locator("#direction").selectOption(direction);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + dx, y + dy);
    const [force, ...others] = await forces(page);
    assert.equal(others.length, 0);
    await page.mouse.up();
    assert.deepEqual(await forces(page), []);
    return force;
  };
  const into = await press("normal", [0, 0]);
  const size = length(into);
  assert.ok(size > 0);
  near(into, [0, 0, -size], size);
  near(await press("+y", [0, 0]), [0, size, 0], size);
  near(await press("-x", [0, 0]), [-size, 0, 0], size);
  // A drag pulls in the plane of the screen: twice as far is twice as much, upwards is upwards, and across it is at a right angle.
  const [right, farther, up] = [await press("drag", [40, 0]), await press("drag", [80, 0]), await press("drag", [0, -40])];
  near(farther, right.map((component) => 2 * component), length(farther));
  assert.ok(up[2] > 0.5 * length(up) && Math.abs(length(up) / length(right) - 1) < 1e-9);
  assert.ok(Math.abs(right.reduce((sum, component, i) => sum + component * up[i], 0)) < 1e-9 * length(up) ** 2);
  await moveSlider(page, "#force", 0.5);
  near(await press("normal", [0, 0]), [0, 0, -Math.sqrt(10) * size], size);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("a sphere that is pressed in and dragged stays outside of the body, and the body keeps no more than it was given", async () => {
  const { page, heard, context } = await open(EXACT);
  const [pressed, left] = await page.evaluate(() => {
    const v = window.vademecum;
    v.pause();
    v.set({ alpha: 0, beta: 0 });
    const [radius, top] = [0.04, 0.1];
    const over = (x, height) => [x, 0.08, top + radius + height];
    v.hold({ radius, friction: 0.3, speed: 0.05, centre: over(0.6, 1e-3) });
    const pressed = [];
    for (const [target, steps] of [[over(0.6, -4e-3), 150], [over(0.8, -4e-3), 4100]]) {
      v.moveTool(target);
      for (let i = 0; i < steps; i++) {
        v.step(1);
        const { deepest, solved, touches } = v.tool();
        pressed.push({ deepest: deepest / radius, solved, force: touches.map(({ force }) => force) });
      }
    }
    // Other parameters: the sphere stays where it is.
    const before = v.tool().centre;
    v.set({ stiffness: 1.5 });
    v.set({ stiffness: 1 });
    v.step(1);
    if (Math.hypot(...v.tool().centre.map((x, i) => x - before[i])) > 1e-12) throw new Error("the sphere moved");
    v.lift();
    v.step(1);
    const left = [v.evaluator.energy()];
    for (let i = 0; i < 500; i++) {
      v.step(1);
      left.push(v.evaluator.energy());
    }
    return [pressed, left];
  });
  const deepest = Math.max(...pressed.map((step) => step.deepest));
  const hardest = Math.max(...pressed.flatMap(({ force }) => force.map(([, , z]) => -z)));
  const rubbed = Math.max(...pressed.flatMap(({ force }) => force.map(([x, y]) => Math.hypot(x, y))));
  console.log(`      deepest ${deepest} of the radius, hardest ${hardest} N, across ${rubbed} N`);
  assert.ok(pressed.every(({ solved }) => solved));
  assert.ok(deepest <= 1e-6 && deepest > -1e-6, `${deepest}`);
  assert.ok(hardest > 1 && rubbed > 0.1, `${hardest}, ${rubbed}`);
  // An undamped body keeps its energy to the rounding of each step.
  assert.ok(left[0] > 0 && left.every((energy) => energy <= left[0] * (1 + 2000 * Number.EPSILON)), `${left[0]}, then ${Math.max(...left)}`);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("with the sphere chosen, a mouse press holds it on the body, a drag takes it along, and the release takes it away", async () => {
  const { page, heard, context } = await open(EXACT);
  await page.locator("#tool").selectOption("sphere");
  assert.match(await page.locator("#radius-out").textContent(), /^[\d.]+ [mµ]?m$/);
  const { x, y } = await pixel(page, [0.7, 0.08, 0.1]);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.waitForFunction(() => window.vademecum.tool()?.touches.length > 0);
  assert.equal((await state(page)).contacts, 0);
  await page.waitForFunction(() => /[µmkM]?N \(\d contacts?\)/.test(document.getElementById("tool-force").textContent));
  await page.screenshot({ path: `${WORK}/sphere.png` });
  const before = await page.evaluate(() => window.vademecum.tool().centre);
  const to = await pixel(page, [0.9, 0.08, 0.1]);
  await page.mouse.move(to.x, to.y, { steps: 5 });
  await page.waitForFunction((from) => window.vademecum.tool().centre[0] > from + 0.05, before[0]);
  await page.screenshot({ path: `${WORK}/sphere-dragged.png` });
  await page.mouse.up();
  assert.equal(await page.evaluate(() => window.vademecum.tool()), null);
  await page.locator("#view").focus();
  await page.keyboard.down("Enter");
  assert.notEqual(await page.evaluate(() => window.vademecum.tool()), null);
  await page.keyboard.up("Enter");
  assert.equal(await page.evaluate(() => window.vademecum.tool()), null);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("a file that moves by stages has no sphere, and the page says why", async () => {
  const { page, heard, context } = await open(EXPORTED);
  assert.ok(await page.locator('#tool option[value="sphere"]').isDisabled());
  assert.match(await page.locator("#tool-note").textContent(), /needs a file with exact steps.*bathe/);
  assert.ok(await page.locator("#tool-note").isVisible());
  const refused = await page.evaluate(() => {
    try {
      window.vademecum.hold({ radius: 0.04, friction: 0, speed: 1, centre: [0.6, 0.08, 0.2] });
      return "";
    } catch (error) {
      return error.message;
    }
  });
  assert.match(refused, /needs exact steps/);
  await context.close();
  const exact = await open(EXACT);
  assert.ok(!(await exact.page.locator("#tool-note").isVisible()));
  assert.deepEqual([...heard.errors, ...exact.heard.errors], []);
  await exact.context.close();
});

test("sliders say their value and unit; speed, magnification, colour, edges and view do what they say", async () => {
  const { page, heard, context } = await open(EXPORTED);
  const said = (id) => page.locator(`${id}-out`).textContent();
  const output = (id) => page.locator(`label[for="${id}"] output`).textContent();
  assert.match(await said("#force"), /^[\d.]+ [mk]?N$/);
  assert.match(await output("parameter-timeStep"), /^1 ms$/);
  assert.match(await output("parameter-alpha"), /^[\d.]+ 1\/s$/);
  assert.match(await output("parameter-beta"), /^[\d.]+ [nµm]?s$/);
  await moveSlider(page, "#magnification", 1);
  assert.equal(await said("#magnification"), "× 10");
  assert.equal(await page.locator("#low").textContent(), "at rest");
  await page.evaluate((point) => window.vademecum.press(point, [0, 0, -20]), TIP);
  for (const [color, quantity, unit] of [["v2", "velocity z", "m/s"], ["u", "displacement", "m"]]) {
    await page.locator("#color").selectOption(color);
    assert.equal(await page.locator("#quantity").textContent(), quantity);
    await page.waitForFunction((u) => document.getElementById("high").textContent.endsWith(u), unit);
  }
  await page.locator("#wire").check();
  assert.ok(await page.evaluate(() => document.getElementById("wire").checked));

  // Slow motion at a tenth: the march keeps it however slowly frames come, but for the frames cut off at a quarter of a second.
  await moveSlider(page, "#speed", -1);
  assert.match(await said("#speed"), /^0\.1 × slow motion$/);
  await page.waitForFunction(() => Math.abs(window.vademecum.state().pace?.factor / 0.1 - 1) < 0.2);

  await page.evaluate(() => window.vademecum.rest());
  await page.waitForFunction((p) => window.vademecum.at(p)[2] === 0, TIP);
  const away = (at) => page.waitForFunction(([p, [x, y], moved]) => {
    const [u, v] = window.vademecum.pixel(p);
    return moved === Math.hypot(u - x, v - y) > 0.5;
  }, [TIP, at.place, at.moved]);
  const place = await page.evaluate((p) => window.vademecum.pixel(p), TIP);
  await page.locator("#view").focus();
  await page.keyboard.press("ArrowLeft");
  await away({ place, moved: true });
  await page.locator("#home").click();
  await away({ place, moved: false });
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("two fingers are two contacts, and the page fits a narrow screen", async () => {
  const { page, heard, context } = await open(EXPORTED, { viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true, colorScheme: "dark" });
  const touch = await context.newCDPSession(page);
  const points = [await pixel(page, TIP), await pixel(page, [0.5, 0.08, 0.1])];
  await touch.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: points.map(({ x, y }, id) => ({ x, y, id })) });
  await page.waitForFunction(() => window.vademecum.state().contacts === 2);
  await page.screenshot({ path: `${WORK}/phone.png` });
  await touch.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  await page.waitForFunction(() => window.vademecum.state().contacts === 0);
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 360);
  await page.screenshot({ path: `${WORK}/phone-full.png`, fullPage: true });
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("everything is reached by keyboard", async () => {
  const { page, context } = await open(EXPORTED);
  for (let i = 0; i < 12 && !(await page.evaluate(() => document.activeElement.id === "view")); i++) await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement.id), "view");
  await page.keyboard.press("Space");
  assert.equal((await state(page)).paused, true);
  const { steps } = await state(page);
  await page.keyboard.press(".");
  assert.equal((await state(page)).steps, steps + 1);
  await page.keyboard.down("Enter");
  assert.equal((await state(page)).contacts, 1);
  await page.keyboard.up("Enter");
  assert.equal((await state(page)).contacts, 0);
  const unlabelled = await page.evaluate(() => [...document.querySelectorAll("input, select, button")].filter((control) => !control.labels?.length && !control.ariaLabel && !control.textContent.trim()).length);
  assert.equal(unlabelled, 0);
  await context.close();
});

test("it steps more than a thousand times a second beside drawing", async () => {
  const { page, context } = await open(EXPORTED);
  await moveSlider(page, "#speed", 1);
  await page.evaluate((point) => window.vademecum.press(point, [0, 0, -20]), TIP);
  await page.waitForFunction(() => window.vademecum.state().pace?.rate >= 1000);
  const { secondsPerStep, pace } = await state(page);
  assert.ok(secondsPerStep < 1e-3);
  console.log(`      step ${secondsPerStep} s; ${Math.round(pace.rate)} steps/s at ${pace.frames.toFixed(1)} frames/s of ${(1000 * pace.frame).toFixed(2)} ms`);
  await context.close();
});

// The figures of a report on a fixed file with a scenario, and of one on a file with live parameters and the JSON of its build.
const SHAPES = (count) => Array.from({ length: count }, (_, k) => `shape-${k + 1}`);
const REPORTS = {
  report: ["mesh", "singular-values", "modes", ...SHAPES(6), "free-run", "file", "probe-tip", "energy"],
  "exact-report": ["mesh", ...SHAPES(6), "bound", "free-run", "file", "probe-tip", "energy"],
  "regions-report": ["mesh", "singular-values", "modes", ...SHAPES(6), "free-run", "enrichment", "axis-theta", "axis-contrast",
    "radius-inner-stiffness", "radius-outer-stiffness", "file", "build"],
};
for (const [report, names] of Object.entries(REPORTS)) {
  test(`${report}: one quiet page with its figures also as files`, async () => {
    const context = await browser.newContext({ viewport: { width: 360, height: 740 }, offline: true });
    const page = await context.newPage();
    const heard = { errors: [], requests: [] };
    page.on("console", (message) => heard.errors.push(message.text()));
    page.on("request", (request) => request.url().startsWith("data:") || heard.requests.push(request.url()));
    await page.goto(`file://${WORK}/${report}.html`);
    assert.deepEqual(heard, { errors: [], requests: [`file://${WORK}/${report}.html`] });
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 360);
    const inside = await page.locator("figure svg").evaluateAll((figures) => figures.map((figure) => figure.getBoundingClientRect().height > 50));
    assert.deepEqual(inside, names.map(() => true));
    await page.screenshot({ path: `${WORK}/${report}.png`, fullPage: true });
    for (const name of names) {
      await page.goto(`file://${WORK}/${report}-figures/${name}.svg`);
      assert.ok((await page.evaluate(() => document.querySelectorAll("text").length)) > 0, name);
    }
    await context.close();
  });
}

test("the report of exact steps says so, and its figures are of the exact motion", async () => {
  const context = await browser.newContext({ offline: true });
  const page = await context.newPage();
  await page.goto(`file://${WORK}/exact-report.html`);
  const text = await page.locator("body").innerText();
  assert.match(text, /total error\s+[\d.e-]+ %/);
  assert.match(text, /none: its steps are exact/);
  assert.ok(!/NaN/.test(text), text.match(/.*NaN.*/)?.[0]);
  for (const [report, name, other] of [["exact-report", "exact motion", "full order"], ["report", "full order", "exact motion"]]) {
    await page.goto(`file://${WORK}/${report}-figures/probe-tip.svg`);
    const words = (await page.locator("text").allTextContents()).map((word) => word.trim());
    assert.ok(words.includes(name) && !words.includes(other), `${report}: ${words}`);
  }
  // The ends of the scale are the file's least and worst bound.
  const { certificate: { bound } } = JSON.parse(execFileSync(VADEMECUM, ["info", `${WORK}/exact.vdm`, "--json"], { maxBuffer: 1 << 26 }));
  await page.goto(`file://${WORK}/exact-report-figures/bound.svg`);
  const ends = (await page.locator("text").allTextContents()).filter((word) => word.endsWith(" %")).map(parseFloat);
  assert.equal(ends.length, 3);
  assert.ok(Math.abs(ends[2] / (100 * bound.worst) - 1) < 0.05 && ends[0] < ends[1] && ends[1] < ends[2], `${ends}, ${bound.worst}`);
  await context.close();
});

test("the surface is coloured by von Mises' stress, that of `vademecum run`", async () => {
  const scenario = `${WORK}/stress.toml`;
  writeFileSync(scenario, `${readFileSync("tests/browser/push.toml", "utf8")}\n[output]\nstress_every = 40\n`);
  execFileSync(VADEMECUM, ["--quiet", "run", `${WORK}/exact.vdm`, "--scenario", scenario, "-o", `${WORK}/run-stress`]);
  const lines = readFileSync(`${WORK}/run-stress/stress.csv`, "utf8").trim().split("\n").slice(1).map((line) => line.split(",").map(Number));
  const expected = Math.max(...lines.filter(([time]) => Math.abs(time - 0.04) < 1e-9).map((line) => line.at(-1)));
  const { page, heard, context } = await open(EXACT);
  const found = await page.evaluate((point) => {
    const v = window.vademecum;
    v.pause();
    v.rest();
    v.press(point, [0, 3, -20]);
    v.step(40);
    const field = v.player.evaluator.equivalentStress();
    return Math.max(...field.filter((_, i) => i % 3 === 0));
  }, TIP);
  assert.ok(expected > 1e4 && Math.abs(found / expected - 1) < 1e-8, `${found}, ${expected}`);
  await page.locator("#color").selectOption("s");
  assert.equal(await page.locator("#quantity").textContent(), "von Mises stress");
  await page.waitForFunction(() => document.getElementById("high").textContent.endsWith("Pa"));
  assert.deepEqual(heard.errors, []);
  await context.close();
  // A file without stress does not offer it.
  const other = await open(EXPORTED);
  assert.equal(await other.page.locator('#color [value="s"]').count(), 0);
  await other.context.close();
});

test("the surface is coloured by the bound the file keeps, with a legend in percent", async () => {
  const { page, heard, context } = await open(EXACT);
  const { certificate: { bound } } = JSON.parse(execFileSync(VADEMECUM, ["info", `${WORK}/exact.vdm`, "--json"], { maxBuffer: 1 << 26 }));
  await page.locator("#color").selectOption("b");
  assert.match(await page.locator("#quantity").textContent(), /^error bound for a push here, worst direction \(log scale\)/);
  await page.waitForFunction(() => document.getElementById("high").textContent.endsWith(" %"));
  const high = parseFloat(await page.locator("#high").textContent());
  assert.ok(Math.abs(high / (100 * bound.worst) - 1) < 0.05, `${high}, ${bound.worst}`);
  // One colour where pushes are worst, another where they are best: the field runs over the whole ramp.
  const ends = await page.evaluate(() => {
    const { field } = window.vademecum.player.body.bound;
    const places = Array.from({ length: field.length / 3 }, (_, node) => field[3 * node]);
    return [Math.min(...places), Math.max(...places)];
  });
  assert.ok(ends[0] === 0 && Math.abs(ends[1] - 1) < 1e-9, `${ends}`);
  await page.locator("#color").selectOption("u");
  await page.evaluate((point) => window.vademecum.press(point, [0, 0, -20]), TIP);
  await page.waitForFunction(() => document.getElementById("high").textContent.endsWith("m"));
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("the report draws what `info` prints: an error for every enrichment, a dot for every setting", async () => {
  const context = await browser.newContext({ offline: true });
  const page = await context.newPage();
  const info = JSON.parse(execFileSync(VADEMECUM, ["info", `${WORK}/regions.vdm`, "--json"], { maxBuffer: 1 << 26 }));
  await page.goto(`file://${WORK}/regions-report-figures/radius-inner-stiffness.svg`);
  assert.equal(await page.locator("circle").count(), info.radius_samples.length);
  await page.goto(`file://${WORK}/regions-report-figures/enrichment.svg`);
  const corners = await page.locator("polyline").evaluateAll((lines) => lines.map((line) => line.points.numberOfItems));
  assert.ok(corners.includes(info.enrichment_history.length), `${corners}`);
  await context.close();
});

test("a force beyond the numbers is refused with a sentence, and the march goes on", async () => {
  const { page, heard, context } = await open(EXPORTED);
  const words = await page.evaluate((point) => {
    const v = window.vademecum;
    v.set({ double: false });
    v.press(point, [0, 0, -1]);
    v.step(1);
    try {
      // Finite here, infinite in binary32.
      v.press(point, [0, 0, -1e40]);
      return "";
    } catch (error) {
      return error.message;
    }
  }, TIP);
  assert.match(words, /not finite, or above the largest/);
  const { time } = await state(page);
  await page.waitForFunction((t) => window.vademecum.state().time > t, time);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("the served page asks for nothing but itself and the file, and Ctrl-C ends it", async () => {
  const server = spawn(VADEMECUM, ["view", `${WORK}/beam.vdm`, "--no-open"], { stdio: ["ignore", "pipe", "inherit"] });
  try {
    const [line] = await once(server.stdout, "data");
    const address = String(line).split(" ")[0];
    const { page, heard, context } = await open(address);
    await page.waitForTimeout(200);
    assert.deepEqual(heard.requests, [address, `${address}body.vdm`]);
    assert.deepEqual(heard.errors, []);
    await context.close();
    server.kill("SIGINT");
    const [code] = await once(server, "exit");
    assert.equal(code, 0);
  } finally {
    server.kill("SIGKILL");
  }
});

test("a mode is shown as it swings while the march stands still, and a push ends the picture", async () => {
  const { page, heard, context } = await open(EXACT);
  const { modes, steps } = await state(page);
  const labels = await page.locator("#mode option").allTextContents();
  assert.equal(labels.length, modes.length + 1);
  modes.forEach((hertz, k) => assert.equal(labels[k + 1], `mode ${k + 1}: ${Number(hertz.toPrecision(4))} Hz`));
  await page.locator("#mode").selectOption("1");
  await page.waitForFunction(() => document.getElementById("quantity").textContent.startsWith("mode 2, "));
  const before = await state(page);
  await page.waitForFunction((phase) => window.vademecum.shown.phase !== phase, await page.evaluate(() => window.vademecum.shown.phase));
  // The shape is what the evaluator shows for a unit coordinate, and a quarter of a swing draws it in full.
  const { apart, drawn, still, size } = await page.evaluate(() => {
    const v = window.vademecum;
    v.pause();
    const swing = (phase) => {
      v.shown.phase = phase;
      return v.shown.frame(0).displacement;
    };
    const [whole, still] = [swing(0.25), swing(0)].map((field) => Array.from(field));
    const unit = new Float64Array(2 * v.evaluator.counts.modes);
    unit[1] = 1;
    v.evaluator.setCoordinates(unit);
    const field = Array.from(v.evaluator.surface());
    v.evaluator.setCoordinates(unit.fill(0));
    const size = v.player.body.size;
    const longest = (u) => Math.max(...Array.from({ length: u.length / 3 }, (_, i) => Math.hypot(u[3 * i], u[3 * i + 1], u[3 * i + 2])));
    const factor = longest(whole) / longest(field);
    return { apart: Math.max(...whole.map((x, i) => Math.abs(x - factor * field[i]))) / longest(whole), drawn: longest(whole), still: longest(still), size };
  });
  assert.ok(apart < 1e-6, `${apart}`);
  assert.ok(Math.abs(drawn / (0.07 * size) - 1) < 1e-9 && still === 0, `${drawn} of ${size}`);
  assert.equal((await state(page)).steps, before.steps);
  assert.ok(before.steps >= steps);
  await page.evaluate((point) => {
    window.vademecum.pause(false);
    window.vademecum.press(point, [0, 0, -20]);
  }, TIP);
  await page.waitForFunction(() => document.getElementById("mode").value === "-1" && document.getElementById("quantity").textContent === "displacement");
  await page.waitForFunction((steps) => window.vademecum.state().steps > steps, before.steps);
  assert.deepEqual(heard.errors, []);
  await context.close();
});
