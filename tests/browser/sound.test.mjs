// A struck body rings in the ear: what the audio worklet gives, rendered without a loudspeaker.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { test } from "node:test";
import { EXPORTED, open, VADEMECUM, WORK } from "./browser.mjs";

const RATE = 48000;
const BAR = `file://${WORK}/bar.html`;
const modes = () => JSON.parse(execFileSync(VADEMECUM, ["--quiet", "modes", "tests/browser/bar.toml", "--json"])).frequencies_hz;

/** Samples of a strike at the place that gives way most; `options` are bound before. */
const strike = (page, seconds, options = {}) => page.evaluate(async ([seconds, options, rate]) => {
  const v = window.vademecum;
  v.set(options);
  const { point, normal, force } = v.player.body.flexible;
  return Array.from(await v.sound.render(seconds, [{ point, force: normal.map((x) => -force * x) }], rate));
}, [seconds, options, RATE]);

/** Size of the part of `samples` at `hertz`, seen through a window that leaves little beside it. */
function part(samples, hertz) {
  let [re, im] = [0, 0];
  samples.forEach((x, i) => {
    const seen = x * Math.sin((Math.PI * (i + 0.5)) / samples.length) ** 2;
    re += seen * Math.cos((2 * Math.PI * hertz * i) / RATE);
    im += seen * Math.sin((2 * Math.PI * hertz * i) / RATE);
  });
  return Math.hypot(re, im) / samples.length;
}

/** The lowest place [Hz] from 20 Hz to `last` where the spectrum has a peak above a twentieth of its largest, to 0.05 Hz. */
function firstPeak(samples, last) {
  const at = (hertz) => part(samples, hertz);
  const coarse = Array.from({ length: Math.floor(last - 20) }, (_, i) => at(20 + i));
  const largest = Math.max(...coarse);
  const first = coarse.findIndex((x, i) => i > 0 && x > largest / 20 && x >= coarse[i - 1] && x >= (coarse[i + 1] ?? 0));
  const fine = Array.from({ length: 61 }, (_, i) => 20 + first - 1.5 + 0.05 * i);
  return fine.reduce((best, hertz) => (at(hertz) > at(best) ? hertz : best));
}

test("the first peak of a struck bar's sound is its first audible mode, and follows the stiffness", async () => {
  const { page, heard, context } = await open(BAR);
  const first = modes().find((hertz) => hertz >= 20);
  const samples = await strike(page, 1);
  assert.equal(samples.length, RATE);
  const loudest = samples.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
  assert.ok(loudest > 0.3 && loudest <= 0.51, `${loudest}`);
  const found = firstPeak(samples, 600);
  console.log(`      first mode ${first} Hz, first peak ${found.toFixed(2)} Hz, loudest sample ${loudest.toFixed(3)}`);
  assert.ok(Math.abs(found - first) < 1, `${found} Hz, expected ${first}`);
  const stiff = firstPeak(await strike(page, 1, { stiffness: 4 }), 1000);
  assert.ok(Math.abs(stiff - 2 * first) < 1, `${stiff} Hz, expected ${2 * first}`);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("the tutorial's fork, struck at a prong, sounds its modes, 440 Hz among them", async () => {
  const fork = JSON.parse(execFileSync(VADEMECUM, ["--quiet", "modes", `${WORK}/fork.toml`, "--count", "4", "--json"])).frequencies_hz;
  const { page, heard, context } = await open(`file://${WORK}/fork.html`);
  // The place that gives way most is the end of a prong.
  const samples = await strike(page, 2);
  const first = firstPeak(samples, 600);
  const places = Array.from({ length: 81 }, (_, i) => 438 + 0.05 * i);
  const pitch = places.reduce((best, hertz) => (part(samples, hertz) > part(samples, best) ? hertz : best));
  console.log(`      first mode ${fork[0]} Hz, first peak ${first.toFixed(2)} Hz; pitch ${pitch.toFixed(2)} Hz, ${fork[2]} Hz by modes`);
  assert.ok(Math.abs(first - fork[0]) < 1, `${first} Hz, expected ${fork[0]}`);
  assert.ok(Math.abs(pitch - fork[2]) < 1 && Math.abs(pitch - 440) < 1, `${pitch} Hz, expected ${fork[2]}`);
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("the sound dies away as the file's damping says", async () => {
  const { page, context } = await open(BAR);
  const [frequency] = modes();
  const [alpha, beta] = [2, 1e-7];
  const samples = await strike(page, 1.5);
  const piece = (start) => part(samples.slice(start * RATE, (start + 0.5) * RATE), frequency);
  const rate = (alpha + beta * (2 * Math.PI * frequency) ** 2) / 2;
  const lost = Math.log(piece(0) / piece(1));
  assert.ok(Math.abs(lost / rate - 1) < 0.01, `${lost} in a second, expected ${rate}`);
  // Nothing decays in a body without damping.
  const kept = await strike(page, 1.5, { alpha: 0, beta: 0 });
  const ratio = part(kept.slice(RATE), frequency) / part(kept.slice(0, RATE / 2), frequency);
  assert.ok(Math.abs(ratio - 1) < 0.01, `${ratio}`);
  await context.close();
});

test("the switch rings what is struck, and a body that no ear hears says so", async () => {
  const { page, heard, context } = await open(BAR);
  await page.locator("#sound").click();
  await page.waitForFunction(() => /^Sound: 12 tones from 212 Hz \(G♯3 \+ 35 cents\)\./.test(document.getElementById("hint").textContent));
  assert.equal(await page.locator("#sound").getAttribute("aria-pressed"), "true");
  // What a press on the body sends to the loudspeaker.
  const loudest = () => page.evaluate(async () => {
    const { sound } = window.vademecum;
    const ear = (window.ear ??= sound.context.createAnalyser());
    sound.node.connect(ear);
    const samples = new Float32Array(ear.fftSize);
    ear.getFloatTimeDomainData(samples);
    return Math.max(...samples.map(Math.abs));
  });
  const until = async (met) => {
    for (let i = 0; i < 100 && !met(await loudest()); i++) await page.waitForTimeout(100);
    assert.ok(met(await loudest()));
  };
  await until((x) => x === 0);
  await page.locator("#view").focus();
  await page.keyboard.down("Enter");
  await until((x) => x > 0.05 && x < 0.51);
  await page.keyboard.up("Enter");
  // A clip takes it along.
  assert.deepEqual(await page.evaluate(() => window.vademecum.sound.tracks().map(({ kind }) => kind)), ["audio"]);
  await page.locator("#rest").click();
  await until((x) => x === 0);
  await page.evaluate(() => window.vademecum.set({ stiffness: 1e-6 }));
  assert.match(await page.locator("#hint").textContent(), /^No sound: the modes of this body lie between 212 mHz and 12.2 Hz, an ear hears 20 Hz to 20 kHz\.$/);
  await page.locator("#reset").click();
  await page.locator("#sound").click();
  await page.waitForFunction(() => document.getElementById("sound").getAttribute("aria-pressed") === "false");
  await page.evaluate(() => window.vademecum.set({ stiffness: 1e-6 }));
  await page.locator("#sound").click();
  assert.match(await page.locator("#hint").textContent(), /^No sound: /);
  assert.equal(await page.locator("#sound").getAttribute("aria-pressed"), "false");
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("a file that is marched by a scheme sounds by exact steps", async () => {
  const { page, context } = await open(EXPORTED);
  const { tones } = await page.evaluate(() => ({ tones: window.vademecum.sound.tones }));
  const samples = await strike(page, 1);
  // The strike from above excites the mode that bends downwards: the first of this beam.
  const found = firstPeak(samples, 60);
  assert.ok(Math.abs(found - tones[0]) < 1, `${found}, expected ${tones[0]}`);
  await context.close();
});
