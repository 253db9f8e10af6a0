// node pictures.mjs FOLDER TO: a picture of each page of the gallery, pushed where it gives way most. Run by docs/gallery/make.
import { browser, picture, push } from "../../tests/browser/picture.mjs";

const [folder, to] = process.argv.slice(2);
for (const [body, share, dark] of [["fork", 0.6, false], ["glass", 1.5, true], ["organ", 0.3, false], ["bracket", 1, false], ["bolted", 1, false], ["bridge", 1, true]]) {
  const options = { viewport: { width: 1120, height: 780 }, colorScheme: dark ? "dark" : "light", reducedMotion: "reduce" };
  await picture(`${folder}/${body}.html`, `${to}/gallery-${body}.webp`, options, async (page) => {
    // The bracket shows its stress.
    if (body === "bracket") await page.locator("#color").selectOption("s");
    await push(page, share);
    await page.waitForTimeout(900);
  });
}
// Worlds at an instant: without a loudspeaker and a hand they go by themselves.
for (const [world, seconds, dark] of [["tower", 4.16, false], ["chain", 0.52, false], ["gripper", 1.4, false], ["xylophone", 1.22, true], ["pile", 0.2, false]]) {
  const options = { viewport: { width: 1120, height: 780 }, colorScheme: dark ? "dark" : "light", reducedMotion: "reduce" };
  await picture(`${folder}/${world}.html`, `${to}/gallery-${world}.webp`, options, async (page) => {
    await page.evaluate((seconds) => {
      const { pause, reset, step, scene } = window.vademecum;
      pause();
      reset();
      for (let due = Math.round(seconds / scene.step); due > 0; due -= 10) step(Math.min(due, 10));
      document.getElementById("hint").textContent = "";
    }, seconds);
    // Of a hundred cubes the arrows would hide what they push.
    if (world === "pile") await page.locator("#forces-shown").uncheck();
    await page.waitForTimeout(900);
  });
}
await browser.close();
