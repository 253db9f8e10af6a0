// node pictures.mjs FOLDER: the pictures of the page in README and docs, from the pages of the demo, of the bar of these tests and of the liver:
//   vademecum demo -o out && vademecum view out/demo.vdm --export out/beam.html
//   vademecum build tests/browser/bar.toml -o out/bar.vdm && vademecum view out/bar.vdm --export out/bar.html
//   vademecum build fixtures/problems/liver.toml -o out/liver.vdm && vademecum view out/liver.vdm --export out/liver.html
//   WORK=target/browser node tests/browser/pictures.mjs out        (tests/browser/check installs what it needs)
// They were reduced to 256 colours afterwards (ImageMagick: convert IN -dither None -colors 256 PNG8:OUT) to stay small.
import { createRequire } from "node:module";
import { resolve } from "node:path";

const folder = resolve(process.argv[2]);
const { chromium } = createRequire(`${resolve(process.env.WORK)}/`)("playwright-core");
const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--enable-unsafe-swiftshader"] });
const DESKTOP = { viewport: { width: 1120, height: 700 } };
const PHONE = { viewport: { width: 380, height: 760 }, hasTouch: true, isMobile: true, deviceScaleFactor: 1.5 };

/** Opens a page, plain behind the body (gradients do not survive few colours), lets `act` happen and takes the picture. */
async function picture(body, name, options, background, act) {
  const page = await browser.newPage(options);
  await page.goto(`file://${folder}/${body}.html`);
  await page.evaluate(() => window.vademecum.ready);
  await page.addStyleTag({ content: `#stage { background: ${background} !important }` });
  await act(page);
  await page.screenshot({ path: `${folder}/${name}.png` });
  await page.close();
}

/** Pushes with `share` of the page's own force at the place that gives way most. */
const push = (page, share) => page.evaluate((s) => {
  const { player } = window.vademecum;
  const { point, normal, force } = player.body.flexible;
  return player.press(point, normal.map((x) => -s * force * x));
}, share);

// The pluck, some seconds after it was let go.
await picture("beam", "view-beam", { ...DESKTOP, colorScheme: "light" }, "#eef2f7", async (page) => {
  await page.evaluate(() => window.vademecum.set({ alpha: 4 }));
  await page.waitForFunction(() => window.vademecum.greeting.id === null);
  await page.waitForTimeout(2500);
  await push(page, 1.5);
  await page.waitForTimeout(700);
});

await picture("liver", "view-liver", { ...DESKTOP, colorScheme: "dark" }, "#1a212d", async (page) => {
  await page.locator("#ghost").check();
  await page.waitForFunction(() => window.vademecum.greeting.id === null);
  await page.waitForTimeout(2500);
  await push(page, 0.8);
  await page.waitForTimeout(900);
});

// Mid-motion, by the page's own button.
await picture("liver", "view-phone", { ...PHONE, colorScheme: "dark" }, "#1a212d", async (page) => {
  await page.waitForFunction(() => window.vademecum.greeting.id === null);
  await page.waitForTimeout(1500);
});

await picture("bar", "view-sound", { ...DESKTOP, colorScheme: "light" }, "#eef2f7", async (page) => {
  await page.locator("#sound").click();
  await page.waitForFunction(() => /^Sound/.test(document.getElementById("hint").textContent));
  await push(page, 1);
  await page.waitForTimeout(600);
});
await browser.close();
