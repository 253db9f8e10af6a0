// node pictures.mjs FOLDER: the pictures of the page in README and docs, from the pages of the demo, of the bar of these tests and of the liver:
//   vademecum demo -o out && vademecum view out/demo.vdm --export out/beam.html
//   vademecum build tests/browser/bar.toml -o out/bar.vdm && vademecum view out/bar.vdm --export out/bar.html
//   vademecum build fixtures/problems/liver.toml -o out/liver.vdm && vademecum view out/liver.vdm --export out/liver.html
//   WORK=target/browser node tests/browser/pictures.mjs out        (tests/browser/check installs what it needs)
import { writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";

const folder = resolve(process.argv[2]);
const { chromium } = createRequire(`${resolve(process.env.WORK)}/`)("playwright-core");
const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--enable-unsafe-swiftshader"] });
const DESKTOP = { viewport: { width: 1120, height: 700 } };
const PHONE = { viewport: { width: 380, height: 760 }, hasTouch: true, isMobile: true, deviceScaleFactor: 1.5 };

/** Opens a page, lets `act` happen and takes the picture, as WebP since that is small. */
async function picture(body, name, options, act) {
  const page = await browser.newPage(options);
  await page.goto(`file://${folder}/${body}.html`);
  await page.evaluate(() => window.vademecum.ready);
  await act(page);
  const png = (await page.screenshot()).toString("base64");
  const webp = await page.evaluate(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.width, image.height];
    canvas.getContext("2d").drawImage(image, 0, 0);
    return canvas.toDataURL("image/webp", 0.9).split(",")[1];
  }, png);
  writeFileSync(`${folder}/${name}.webp`, Buffer.from(webp, "base64"));
  await page.close();
}

/** Pushes with `share` of the page's own force at the place that gives way most. */
const push = (page, share) => page.evaluate((s) => {
  const { player } = window.vademecum;
  const { point, normal, force } = player.body.flexible;
  return player.press(point, normal.map((x) => -s * force * x));
}, share);

// The pluck, some seconds after it was let go.
await picture("beam", "view-beam", { ...DESKTOP, colorScheme: "light" }, async (page) => {
  await page.evaluate(() => window.vademecum.set({ alpha: 4 }));
  await page.waitForFunction(() => window.vademecum.greeting.id === null);
  await page.waitForTimeout(2500);
  await push(page, 1.5);
  await page.waitForTimeout(700);
});

await picture("liver", "view-liver", { ...DESKTOP, colorScheme: "dark" }, async (page) => {
  await page.locator("#ghost").check();
  await page.waitForFunction(() => window.vademecum.greeting.id === null);
  await page.waitForTimeout(2500);
  await push(page, 0.8);
  await page.waitForTimeout(900);
});

// Mid-motion.
await picture("liver", "view-phone", { ...PHONE, colorScheme: "dark" }, async (page) => {
  await page.waitForFunction(() => window.vademecum.greeting.id === null);
  await page.waitForTimeout(1500);
});

await picture("bar", "view-sound", { ...DESKTOP, colorScheme: "light" }, async (page) => {
  await page.locator("#sound").click();
  await page.waitForFunction(() => /^Sound/.test(document.getElementById("hint").textContent));
  await push(page, 1);
  await page.waitForTimeout(600);
});
await browser.close();
