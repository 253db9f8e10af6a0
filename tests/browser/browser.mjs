// The browser that the tests of the page share, and what they do with a page.
import { createRequire } from "node:module";
import { after, before } from "node:test";

export const { WORK, VADEMECUM } = process.env;
const { chromium } = createRequire(`${WORK}/`)("playwright-core");
export const EXPORTED = `file://${WORK}/beam.html`;
// The same beam with exact steps and its residual.
export const EXACT = `file://${WORK}/exact.html`;
// A bar that nothing holds.
export const FREE = `file://${WORK}/free.html`;
export const BENT = `file://${WORK}/bent.html`;
export const TIP = [0.97, 0.08, 0.1];

export let browser;
before(async () => {
  browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--enable-unsafe-swiftshader"] });
});
after(() => browser.close());

/** Opens a page without network, the body at rest (no greeting); `heard` collects errors and requests. */
export async function open(address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, offline: address.startsWith("file:"), reducedMotion: "reduce", ...options });
  const page = await context.newPage();
  const heard = { errors: [], requests: [] };
  page.on("console", (message) => message.type() === "error" && heard.errors.push(message.text()));
  page.on("pageerror", (error) => heard.errors.push(error.message));
  page.on("request", (request) => request.url().startsWith("data:") || heard.requests.push(request.url()));
  await page.goto(address);
  await page.evaluate(() => window.vademecum.ready);
  return { page, heard, context };
}

export const state = (page) => page.evaluate(() => window.vademecum.state());
export const moveSlider = (page, id, value) => page.locator(id).evaluate((input, x) => {
  input.value = String(x);
  input.dispatchEvent(new Event("input", { bubbles: true }));
}, value);

/** Where a loadable point is on the screen. */
export async function pixel(page, point) {
  const [box, at] = [await page.locator("#view").boundingBox(), await page.evaluate((p) => window.vademecum.pixel(p), point)];
  return { x: box.x + at[0], y: box.y + at[1] };
}
