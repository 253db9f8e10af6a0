// The package as it is installed from its tarball (INSTALLED is a folder with node_modules), on the bodies in WORK.
import assert from "node:assert/strict";
import { createServer } from "node:http";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { extname, join, normalize } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { march } from "./march.js";

const { INSTALLED, WORK } = process.env;
const here = import.meta.dirname ?? new URL(".", import.meta.url).pathname;
const installed = createRequire(`${INSTALLED}/`);
const { Body, Refused } = await import(installed.resolve("vademecum-eval"));
const { chromium } = installed("playwright-core");
const [beam, exact, live, regions] = ["beam", "exact", "live", "regions"].map((name) => readFileSync(`${WORK}/${name}.vdm`));
const refused = (call, words) => assert.throws(call, (error) => error instanceof Refused && words.test(error.message), String(words));

let server, browser, address;
before(async () => {
  const kinds = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };
  server = createServer((request, answer) => {
    const path = normalize(new URL(request.url, "http://x").pathname);
    const folder = path.startsWith("/test/") ? join(here, "..") : path.endsWith(".vdm") ? WORK : INSTALLED;
    try {
      const bytes = path === "/" ? "<!doctype html><title>empty</title>" : readFileSync(join(folder, path));
      answer.writeHead(200, { "content-type": kinds[extname(path)] ?? (path === "/" ? "text/html" : "application/octet-stream") }).end(bytes);
    } catch {
      answer.writeHead(404).end();
    }
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  address = `http://127.0.0.1:${server.address().port}`;
  browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--enable-unsafe-swiftshader"] });
});
after(async () => {
  await browser?.close();
  server?.close();
});

test("a body moves as `vademecum run` moves it", async () => {
  const [head, ...rows] = readFileSync(`${WORK}/run/probes.csv`, "utf8").trim().split("\n").map((line) => line.split(","));
  const body = await Body.open(exact, { precision: "double" });
  assert.deepEqual([...body.probeNames], ["tip"]);
  body.push(body.locate([0.97, 0.08, 0.1]), [0, 3, -20]);
  let largest = 0;
  for (const row of rows.slice(1, 100)) {
    assert.equal(body.step(), "moving");
    const [wanted, energy] = ["tip [m]", "energy_J"].map((name) => Number(row[head.indexOf(name)]));
    // The table has ten digits.
    const digit = (x) => 10 ** (Math.floor(Math.log10(Math.abs(x))) - 9);
    assert.ok(Math.abs(body.probe("tip") - wanted) <= digit(wanted), `${body.probe("tip")} ${wanted}`);
    assert.ok(Math.abs(body.energy - energy) <= digit(energy), `${body.energy} ${energy}`);
    largest = Math.max(largest, Math.abs(wanted));
  }
  assert.ok(largest > 1e-5);
});

test("Node, a page and a worker give the same bits", async () => {
  const page = await browser.newPage();
  await page.goto(address);
  for (const [name, bytes] of [["beam", beam], ["exact", exact]]) {
    const wanted = await march(Body, bytes);
    assert.ok(wanted.split(" ").length > 1000);
    const [onPage, inWorker] = await page.evaluate(async (name) => {
      const { Body } = await import("/node_modules/vademecum-eval/index.js");
      const { march } = await import("/test/march.js");
      const bytes = await (await fetch(`/${name}.vdm`)).arrayBuffer();
      const worker = new Worker("/test/marcher.js", { type: "module" });
      const answer = new Promise((done, failed) => Object.assign(worker, { onmessage: ({ data }) => done(data), onerror: failed }));
      worker.postMessage(bytes);
      return [await march(Body, bytes), await answer];
    }, name);
    assert.equal(onPage, wanted, `${name} on a page`);
    assert.equal(inWorker, wanted, `${name} in a worker`);
  }
});

test("parameters by name, within their ranges, under the loads that are held", async () => {
  const body = await Body.open(live, { parameters: { stiffness: 1.5 } });
  assert.deepEqual(body.parameters.map(({ name, lower, upper }) => [name, lower, upper]), [["stiffness", 0.5, 2], ["beta", 0, 1e-3]]);
  const value = (name) => body.parameters.find((parameter) => parameter.name === name).value;
  assert.equal(value("stiffness"), 1.5);
  const place = body.locate([1, 0.08, 0.1]);
  body.push(place, [0, 0, -20]);
  body.step(3000);
  const stiff = body.point(place)[2];
  body.setParameters({ stiffness: 0.5, beta: 5e-4 });
  assert.ok(Math.abs(body.point(place)[2] - stiff) < 1e-3 * Math.abs(stiff) || body.point(place)[2] < stiff);
  body.step(6000);
  const ratio = body.point(place)[2] / stiff;
  assert.ok(Math.abs(ratio - 3) < 0.01, `three times as soft: ${ratio}`);
  for (const [values, words] of [[{ stiffness: 2.1 }, /"stiffness" = 2.1 is outside of its range, 0.5 to 2/], [{ stiffness: NaN }, /outside/],
    [{ beta: 1e-4, stiff: 1 }, /no parameter "stiff"; it has stiffness, beta/]]) {
    refused(() => body.setParameters(values), words);
    assert.deepEqual([value("stiffness"), value("beta")], [0.5, 5e-4]);
  }
  await assert.rejects(Body.open(live, { parameters: { stiffness: 9 } }), Refused);
});

test("live regions are set by name while the body moves", async () => {
  const body = await Body.open(regions, { parameters: { "stiffness of the tip": 2 } });
  body.pushPattern("pull");
  body.step(20);
  body.setParameters({ "stiffness of the tip": 3, beta: 1e-5 });
  const values = () => Object.fromEntries(body.parameters.map(({ name, value }) => [name, value]));
  const set = { "stiffness of the root": 1, "stiffness of the tip": 3, "density of the tip": 1, beta: 1e-5 };
  assert.deepEqual(values(), set);
  refused(() => body.setParameters({ "stiffness of the root": 1.5, "stiffness of the tip": 5 }), /outside of its range, 0.25 to 4/);
  assert.deepEqual(values(), set);
  body.step(100_000);
  const other = await Body.open(regions, { parameters: set });
  other.pushPattern("pull");
  other.step(100_000);
  const [found, expected] = [body, other].map((one) => one.probe("x"));
  assert.ok(Math.abs(found / expected - 1) < 1e-5 && found !== 0, `${found}, ${expected}`);
});

test("stiffness, density and damping of the whole body are options", async () => {
  const unscaled = await Body.open(exact);
  const pushed = async (options, steps) => {
    const body = await Body.open(exact, { precision: "double", ...options });
    const place = body.locate([1, 0.08, 0.1]);
    body.push(place, [0, 0, -20]);
    body.step(steps);
    return [body.point(place)[2], body.point(place, "velocity")[2]];
  };
  const [soft] = await pushed({ alpha: 50 }, 30000);
  const [stiff] = await pushed({ alpha: 50, stiffness: 2 }, 30000);
  assert.ok(Math.abs(soft / stiff - 2) < 1e-6, `${soft} ${stiff}`);
  const [, light] = await pushed({}, 1);
  const [, heavy] = await pushed({ density: 4 }, 1);
  assert.ok(light / heavy > 1.5, "a heavier body is slower");
  const [, damped] = await pushed({ beta: 1e-2 }, 1);
  assert.ok(Math.abs(damped) < Math.abs(light), "a damped body, too");
  // Of a live parameter of that name the range holds.
  assert.equal((await Body.open(live, { stiffness: 1.5 })).parameters[0].value, 1.5);
  for (const [source, options, words] of [[live, { stiffness: 9 }, /range, 0.5 to 2/], [exact, { stiffness: -1 }, /stiffness|scale/], [exact, { beta: "x" }, /beta is "x"/],
    [exact, { stifness: 2 }, /no option "stifness"; there are wasm/]]) {
    await assert.rejects(Body.open(source, options), (error) => error instanceof Refused && words.test(error.message), String(words));
  }
  refused(() => unscaled.setParameters({ stiffness: 2 }), /no live parameter "stiffness"; that of the whole body is an option of Body.open/);
});

test("a file is opened from a URL and from an answer of fetch", async () => {
  const energy = async (source) => {
    const body = await Body.open(source);
    body.push(body.locate([1, 0.08, 0.1]), [0, 0, -20]);
    body.step(10);
    return body.energy;
  };
  const wanted = await energy(exact);
  for (const source of [pathToFileURL(`${WORK}/exact.vdm`), new URL(`${address}/exact.vdm`), fetch(`${address}/exact.vdm`)]) {
    assert.equal(await energy(source), wanted);
  }
  await assert.rejects(Body.open(fetch(`${address}/nowhere.vdm`)), /nowhere.vdm: the server answers 404/);
  await assert.rejects(Body.open(pathToFileURL(`${WORK}/nowhere.vdm`)), /nowhere.vdm/);
});

test("views, states, spheres and refusals", async () => {
  const body = await Body.open(exact);
  assert.equal(body.positions.length, 3 * body.counts.surfaceNodes);
  assert.equal(body.triangles.length, 3 * body.counts.triangles);
  assert.equal(body.step(), "at-rest");
  const place = body.locate([1, 0.08, 0.1]);
  body.push(place, [0, 0, -20]);
  body.step(50);
  const [one, again] = [body.surface(), body.surface()];
  assert.ok(one instanceof Float32Array && one.buffer === again.buffer && one.byteOffset === again.byteOffset, "no copy");
  assert.ok(one.some((x) => x !== 0));
  const [saved, energy] = [body.save(), body.energy];
  body.step(100);
  assert.equal(body.restore(saved), "as-saved");
  assert.deepEqual(body.save(), saved);
  assert.equal(body.energy, energy);
  const parts = body.quantities.filter(({ name }) => /_energy$/.test(name)).map(({ name }) => body.read(name)[0]);
  assert.ok(Math.abs(parts.reduce((sum, part) => sum + part, 0) / energy - 1) < 1e-5, `${parts} ${energy}`);
  const middle = { nodes: place.nodes.concat(place.nodes), weights: place.weights.concat(place.weights).map((weight) => weight / 2) };
  body.point(middle).forEach((x, i) => assert.ok(Math.abs(x - body.point(place)[i]) <= 1e-6 * Math.abs(x), "a place of six nodes"));
  const other = await Body.open(exact, { precision: "double" });
  assert.equal(other.restore(saved), "carried");
  assert.ok(Math.abs(other.energy / energy - 1) < 1e-5);
  refused(() => body.restore(saved.slice(1)), /no saved state of this version/);
  refused(() => body.restore(saved.slice(0, -8)), /bytes for a saved state of/);
  refused(() => body.restore([1, 2]), /expected the Uint8Array that `save` gave/);
  refused(() => body.step(0), /whole number/);
  refused(() => body.probe("top"), /no probe "top"; it has tip/);
  refused(() => body.pushPattern("gravitation"), /no load pattern "gravitation"; it has/);
  refused(() => body.setParameters("stiffness", 2), /parameters are "stiffness"; expected an object/);
  refused(() => body.locate([100, 0, 0]), /9.900e1 away from the loadable surface/);
  refused(() => body.locate("x"), /point is "x"; expected three numbers/);
  refused(() => body.locate([1, 2]), /point is \[1,2\]; expected three numbers/);
  refused(() => body.push([1, 2, 3], [0, 0, 1]), /place is \[1,2,3\]; expected nodes and as many weights/);
  refused(() => body.push(place, 3), /force is 3; expected three numbers/);
  refused(() => body.push({ ...place, radius: 0.01 }, [0, 0, 1]), /radius/);
  refused(() => body.push({ nodes: [1], weights: [0.5] }, [0, 0, 1]), /sum/);
  refused(() => body.read("heat"), /no quantity "heat"; it has probe, node/);
  refused(() => body.read("energy", 1), /no energy 1; the body has 1/);
  refused(() => body.read("energy", 0, "velocity"), /velocity/);
  refused(() => body.push({ nodes: [99999, 0, 0], weights: [1, 0, 0] }, [1, 0, 0]), /node 99999 is not loadable/);
  refused(() => body.push(place, [NaN, 0, 0]), /not finite/);
  refused(() => body.surface("speed"), /expected "displacement" or "velocity"/);
  refused(() => body.moveSphere([0, 0, 0]), /no sphere/);
  body.clear();
  body.rest();
  assert.equal(body.energy, 0);
  const [x, y, z] = place.position;
  body.press({ radius: 0.05, speed: 1, centre: [x - 0.1, y, z + 0.06], target: [x - 0.1, y, z + 0.045] });
  body.step(200);
  const { touches, deepest, solved, centre } = body.sphere;
  assert.ok(touches.length > 0 && solved && Math.abs(deepest) < 1e-6, JSON.stringify(body.sphere));
  assert.ok(Math.abs(centre[2] - (z + 0.045)) < 1e-12);
  body.liftSphere();
  assert.equal(body.sphere, null);
  // Several bodies know nothing of each other.
  const fresh = await Body.open(exact);
  assert.equal(fresh.energy, 0);
  const damaged = Uint8Array.from(exact);
  damaged[damaged.length - 100] ^= 1;
  await assert.rejects(Body.open(damaged), Refused);
  await assert.rejects(Body.open(new Uint8Array(0)), Refused);
  await assert.rejects(Body.open("body.vdm"), /given as "body.vdm"; expected its bytes/);
  await assert.rejects(Body.open(exact, { precision: "half" }), /"single" or "double"/);
});

for (const file of ["beam", "slow"]) test(`the example with three.js shows a body that is pressed: ${file}`, async () => {
  const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (message) => message.type() === "error" && !/favicon/.test(message.location().url) && errors.push(message.text()));
  await page.goto(`${address}/node_modules/vademecum-eval/examples/three.html?file=/${file}.vdm`);
  await page.waitForFunction(() => window.example, null, { timeout: 30000 });
  assert.equal(await page.evaluate(() => window.example.energy), 0);
  // What is blue is the body: how much of the picture, and where its middle is.
  const picture = await page.screenshot({ path: `${WORK}/three-${file}.png` });
  const blue = await page.evaluate(async (encoded) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${encoded}`)).blob());
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    canvas.drawImage(bitmap, 0, 0);
    const { data } = canvas.getImageData(0, 0, bitmap.width, bitmap.height);
    let [count, x, y] = [0, 0, 0];
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 2] > data[i] + 20) [count, x, y] = [count + 1, x + (i / 4) % bitmap.width, y + Math.floor(i / 4 / bitmap.width)];
    }
    return { share: count / (data.length / 4), x: x / count, y: y / count };
  }, picture.toString("base64"));
  assert.ok(blue.share > 0.02 && blue.share < 0.5, JSON.stringify(blue));
  await page.mouse.move(blue.x, blue.y);
  await page.mouse.down();
  await page.waitForFunction(() => window.example.energy > 0, null, { timeout: 30000 });
  await page.mouse.up();
  assert.deepEqual(errors, []);
});

test("the example worker answers", async () => {
  const page = await browser.newPage();
  await page.goto(address);
  const answer = await page.evaluate(async () => {
    const bytes = await (await fetch("/beam.vdm")).arrayBuffer();
    const worker = new Worker("/node_modules/vademecum-eval/examples/worker.js", { type: "module" });
    const told = new Promise((done, failed) => Object.assign(worker, { onmessage: ({ data }) => done(data), onerror: failed }));
    worker.postMessage({ bytes, push: { at: [1, 0.08, 0.1], force: [0, 0, -20] }, steps: 20 });
    const { moved, surface } = await told;
    return { moved, length: surface.length };
  });
  assert.ok(answer.moved[2] < 0 && answer.length > 0);
});
