// Pictures of exported pages, for README and docs.
import { writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";

const { chromium } = createRequire(`${resolve(process.env.WORK)}/`)("playwright-core");
export const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--enable-unsafe-swiftshader"] });
export const DESKTOP = { viewport: { width: 1120, height: 700 } };
export const PHONE = { viewport: { width: 380, height: 760 }, hasTouch: true, isMobile: true, deviceScaleFactor: 1.5 };

/** Opens an exported page, lets `act` happen and writes the picture to a file, as WebP since that is small. */
export async function picture(path, to, options, act) {
  const page = await browser.newPage(options);
  await page.goto(`file://${resolve(path)}`);
  await page.evaluate(() => window.vademecum?.ready);
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
  writeFileSync(to, Buffer.from(webp, "base64"));
  await page.close();
}

/** Pushes with `share` of the page's own force at the place that gives way most. */
export const push = (page, share) => page.evaluate((s) => {
  const { player } = window.vademecum;
  const { point, normal, force } = player.body.flexible;
  return player.press(point, normal.map((x) => -s * force * x));
}, share);

