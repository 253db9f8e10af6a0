// node pictures.mjs FOLDER: the two pictures of the README, from the pages of the demo and of the liver:
//   vademecum demo -o out && vademecum view out/demo.vdm --export out/beam.html
//   vademecum build fixtures/problems/liver.toml -o out/liver.vdm && vademecum view out/liver.vdm --export out/liver.html
//   WORK=target/browser node tests/browser/pictures.mjs out        (tests/browser/check installs what it needs)
// They were reduced to 256 colours afterwards (Pillow, quantize) to stay small.
import { createRequire } from "node:module";
import { resolve } from "node:path";

const folder = resolve(process.argv[2]);
const { chromium } = createRequire(`${resolve(process.env.WORK)}/`)("playwright-core");
const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--enable-unsafe-swiftshader"] });

async function picture(name, colorScheme, background, act) {
  const page = await browser.newPage({ viewport: { width: 1120, height: 700 }, colorScheme });
  await page.goto(`file://${folder}/${name}.html`);
  await page.evaluate(() => window.vademecum.ready);
  // A plain background: gradients do not survive few colours.
  await page.addStyleTag({ content: `#stage { background: ${background} !important }` });
  await act(page);
  await page.screenshot({ path: `${folder}/view-${name}.png` });
  await page.close();
}

await picture("beam", "light", "#eef2f7", async (page) => {
  const press = (force) => page.evaluate((f) => window.vademecum.press([0.96, 0.04, 0.1], [0, 0, -f]), force);
  await page.evaluate(() => window.vademecum.set({ alpha: 12 }));
  await page.waitForTimeout(300);
  const first = await press(1000);
  await page.waitForTimeout(1000);
  await page.evaluate((id) => window.vademecum.release(id), first);
  await page.waitForTimeout(900);
  await press(2000);
  await page.waitForTimeout(2300);
});

await picture("liver", "dark", "#1a212d", async (page) => {
  const press = (share) => page.evaluate((s) => {
    const { point, normal, force } = window.vademecum.player.body.flexible;
    return window.vademecum.player.press(point, normal.map((x) => -s * force * x));
  }, share);
  await page.locator("#ghost").check();
  const first = await press(1);
  await page.waitForTimeout(1500);
  await page.evaluate((id) => window.vademecum.release(id), first);
  await page.waitForTimeout(3000);
  await press(0.8);
  await page.waitForTimeout(900);
});
await browser.close();
