// node pictures.mjs FOLDER: the pictures of the page in README and docs, from the pages of the demo, of the bar of these tests and of the liver:
//   vademecum demo -o out && vademecum view out/demo.vdm --export out/beam.html
//   vademecum build tests/browser/bar.toml -o out/bar.vdm && vademecum view out/bar.vdm --export out/bar.html
//   vademecum build fixtures/problems/liver.toml -o out/liver.vdm && vademecum view out/liver.vdm --export out/liver.html
//   vademecum report out/demo.vdm --problem out/problem.toml --scenario out/scenario.toml -o out/report.html
//   WORK=target/browser node tests/browser/pictures.mjs out        (tests/browser/check installs what it needs)
import { browser, DESKTOP, PHONE, picture as shot, push } from "./picture.mjs";

const folder = process.argv[2];
const picture = (body, name, options, act) => shot(`${folder}/${body}.html`, `${folder}/${name}.webp`, options, act);

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
await picture("report", "report", { viewport: { width: 960, height: 1350 }, colorScheme: "light" }, async (page) => {
  await page.evaluate(() => {
    for (const part of document.querySelectorAll("section")) part.hidden = !/The body|Against/.test(part.textContent);
  });
});
await browser.close();
