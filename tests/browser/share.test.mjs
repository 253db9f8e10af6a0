// What leaves the page: a picture, a clip, a link.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { EXACT, moveSlider, open, state, TIP, WORK } from "./browser.mjs";

/** The file that a press on a button hands out. */
async function saved(page, press) {
  const [download] = await Promise.all([page.waitForEvent("download"), press()]);
  const path = `${WORK}/${download.suggestedFilename()}`;
  await download.saveAs(path);
  return path;
}

test("a picture is a PNG of the body as it is seen", async () => {
  const { page, heard, context } = await open(EXACT);
  const path = await saved(page, () => page.locator("#picture").click());
  assert.match(path, /\.png$/);
  const file = readFileSync(path);
  const size = await page.evaluate(() => [document.getElementById("view").clientWidth, document.getElementById("view").clientHeight].map((pixels) => 4 * pixels));
  assert.deepEqual([file.readUInt32BE(16), file.readUInt32BE(20)], size);
  // The body is in it: the middle of the beam has its colour, a corner that of the background.
  const colors = await page.evaluate(async (data) => {
    const image = await createImageBitmap(await (await window.vademecum.recorder.picture()));
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const [x, y] = window.vademecum.pixel([0.5, 0.08, 0.1]).map((place) => 4 * place);
    const at = (x, y) => Array.from(context.getImageData(x, y, 1, 1).data);
    return [at(Math.round(x), Math.round(y)), at(5, Math.round(image.height / 2))];
  });
  const apart = Math.hypot(...colors[0].map((x, i) => x - colors[1][i]));
  assert.ok(apart > 60, JSON.stringify(colors));
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("a clip plays what was seen while it was recorded", async () => {
  const { page, heard, context } = await open(EXACT);
  await page.evaluate((point) => window.vademecum.press(point, [0, 0, -500]), TIP);
  await page.locator("#clip").click();
  assert.equal(await page.locator("#clip").getAttribute("aria-pressed"), "true");
  await page.waitForTimeout(1500);
  const path = await saved(page, () => page.locator("#clip").click());
  assert.match(path, /\.webm$/);
  const file = readFileSync(path);
  // Each WebM file begins with this mark (EBML).
  assert.equal(file.readUInt32BE(0), 0x1a45dfa3);
  const [width, height] = await page.evaluate(() => [document.getElementById("view").width, document.getElementById("view").height]);
  const [x, y] = await page.evaluate((point) => window.vademecum.pixel(point), [0.3, 0.08, 0.1]);
  const cinema = await context.newPage();
  // The body moves: frames differ, and where it is held it is not the background.
  const seen = await cinema.evaluate(async ([data, x, y]) => {
    const video = Object.assign(document.createElement("video"), { src: `data:video/webm;base64,${data}`, muted: true });
    const canvas = document.createElement("canvas");
    const frames = [];
    video.requestVideoFrameCallback(function look() {
      [canvas.width, canvas.height] = [video.videoWidth, video.videoHeight];
      const context = canvas.getContext("2d");
      context.drawImage(video, 0, 0);
      const pixels = context.getImageData(0, 0, canvas.width, canvas.height).data;
      const at = (x, y) => Array.from(pixels.slice(4 * (y * canvas.width + x), 4 * (y * canvas.width + x) + 3));
      frames.push({ sum: pixels.reduce((sum, value) => sum + value, 0), body: at(Math.round(x), Math.round(y)), corner: at(5, canvas.height >> 1) });
      video.requestVideoFrameCallback(look);
    });
    await video.play();
    await new Promise((done) => video.addEventListener("ended", done));
    return { width: video.videoWidth, height: video.videoHeight, frames };
  }, [file.toString("base64"), x, y]);
  assert.deepEqual([seen.width, seen.height], [width, height]);
  assert.ok(new Set(seen.frames.map(({ sum }) => sum)).size > 3, `${seen.frames.length} frames`);
  const { body, corner } = seen.frames.at(-1);
  assert.ok(Math.hypot(...body.map((x, i) => x - corner[i])) > 60, `${body}, ${corner}`);
  assert.equal(await page.locator("#clip").getAttribute("aria-pressed"), "false");
  assert.deepEqual(heard.errors, []);
  await context.close();
});

test("a link leads back to camera, magnification and parameters, and one that does not fit is left out", async () => {
  const { page, context } = await open(EXACT);
  await page.evaluate(() => {
    window.vademecum.camera.stand(1);
    window.vademecum.camera.orbit(30, 10);
    window.vademecum.camera.closer(1.5);
  });
  await moveSlider(page, "#magnification", 1.5);
  await moveSlider(page, "#parameter-stiffness", Math.log10(3));
  await page.locator("#color").selectOption("u2");
  await page.locator("#ghost").check();
  await page.locator("#link").click();
  await page.waitForFunction(() => /^The address of this page now leads back/.test(document.getElementById("hint").textContent));
  const address = page.url();
  const seen = (on) => on.evaluate(() => ({ ...window.vademecum.camera.pose, magnification: window.vademecum.controls.magnification, component: window.vademecum.controls.component }));
  const before = await seen(page);
  await context.close();

  const other = await open(address);
  const after = await seen(other.page);
  for (const name of ["up", "yaw", "pitch", "zoom", "magnification", "component"]) assert.ok(Math.abs(after[name] - before[name]) < 1e-5 * Math.max(1, Math.abs(before[name])), name);
  assert.ok(Math.abs((await state(other.page)).options.stiffness / 3 - 1) < 1e-5);
  assert.ok(await other.page.locator("#ghost").isChecked());
  assert.deepEqual(other.heard.errors, []);
  await other.context.close();

  const wrong = await open(`${EXACT}#view=7,a,0,0,0,0,0&magnification=x&color=nothing&parameter-stiffness=1e9&unknown=1`);
  const { options } = await state(wrong.page);
  // A slider takes the end of its range.
  assert.ok(Math.abs(options.stiffness - 10) < 1e-9, `${options.stiffness}`);
  const pose = await seen(wrong.page);
  assert.equal(pose.up, 2);
  assert.ok(Number.isFinite(pose.yaw));
  assert.deepEqual(wrong.heard.errors, []);
  await wrong.context.close();
});
