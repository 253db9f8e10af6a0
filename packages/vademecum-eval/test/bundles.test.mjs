// The package as bundlers pack it for a page and a worker (INSTALLED holds them and the package): the bits are those of Node.
import assert from "node:assert/strict";
import { copyFileSync, cpSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { extname, join } from "node:path";
import { after, before, test } from "node:test";
import { march } from "./march.js";

const { INSTALLED, WORK } = process.env;
const here = import.meta.dirname ?? new URL(".", import.meta.url).pathname;
const installed = createRequire(`${INSTALLED}/`);
const load = (name) => import(installed.resolve(name));
const { Body } = await load("vademecum-eval");
const { chromium } = installed("playwright-core");
const [root, wasm] = [join(INSTALLED, "bundle"), join(INSTALLED, "node_modules/vademecum-eval/evaluator.wasm")];
const entries = ["page", "worker"].map((name) => join(root, `${name}.js`));
const kinds = { ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm" };
const page = '<!doctype html><title>a bundle</title><script type="module" src="./page.js"></script>';

let browser, wanted;
before(async () => {
  rmSync(root, { recursive: true, force: true });
  mkdirSync(join(root, "public"), { recursive: true });
  copyFileSync(join(here, "march.js"), join(root, "march.js"));
  copyFileSync(join(WORK, "beam.vdm"), join(root, "public/beam.vdm"));
  writeFileSync(join(root, "index.html"), page);
  const head = 'import { Body } from "vademecum-eval";\nimport { march } from "./march.js";\n';
  writeFileSync(entries[1], `${head}self.onmessage = async ({ data }) => self.postMessage(await march(Body, data));\n`);
  writeFileSync(entries[0], `${head}async function both() {
  const bytes = await (await fetch("/beam.vdm")).arrayBuffer();
  const onPage = await march(Body, bytes);
  const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  const inWorker = new Promise((done, failed) => Object.assign(worker, { onmessage: ({ data }) => done(data), onerror: failed }));
  worker.postMessage(bytes);
  return [onPage, await inWorker];
}
globalThis.answer = both().catch((error) => String(error));
`);
  wanted = await march(Body, readFileSync(join(WORK, "beam.vdm")));
  browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox"] });
});
after(() => browser?.close());

/** What the page at an address answers. */
async function answer(address) {
  const tab = await browser.newPage();
  await tab.goto(address);
  await tab.waitForFunction(() => globalThis.answer, null, { timeout: 60000 });
  return tab.evaluate(() => globalThis.answer);
}

/** What the page of a folder answers; instead of what is not there it is served the page itself, as by many development servers. */
async function served(folder) {
  const server = createServer((request, reply) => {
    const path = request.url === "/" ? "/index.html" : request.url;
    try {
      const bytes = readFileSync(join(path.endsWith(".vdm") ? WORK : folder, path));
      reply.writeHead(200, { "content-type": kinds[extname(path)] ?? "application/octet-stream" }).end(bytes);
    } catch {
      reply.writeHead(200, { "content-type": "text/html" }).end(page);
    }
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  try {
    return await answer(`http://127.0.0.1:${server.address().port}/`);
  } finally {
    server.close();
  }
}

/** Page and worker answered with the bits of Node. */
function isRight(said) {
  assert.ok(said instanceof Array && said[0] === wanted && said[1] === wanted, said instanceof Array ? "other bits" : said);
}

/** A folder for what a bundler writes; with the module beside it, where the bundler leaves that to its user. */
function output(name, isCopied) {
  const folder = join(WORK, "bundles", name);
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  writeFileSync(join(folder, "index.html"), page);
  if (isCopied) cpSync(wasm, join(folder, "evaluator.wasm"));
  return folder;
}

test("esbuild", async () => {
  const folder = output("esbuild", false);
  const { build } = await load("esbuild");
  await build({ entryPoints: entries, outdir: folder, bundle: true, format: "esm", platform: "browser", logLevel: "error" });
  assert.match(await served(folder), /evaluator.wasm: this is no WebAssembly module \(it begins with 3c 21 64 6f\).*with Vite write optimizeDeps/);
  cpSync(wasm, join(folder, "evaluator.wasm"));
  isRight(await served(folder));
});

test("rollup", async () => {
  const folder = output("rollup", true);
  const [{ rollup }, { nodeResolve }] = [await load("rollup"), await load("@rollup/plugin-node-resolve")];
  const bundle = await rollup({ input: entries, plugins: [nodeResolve({ browser: true })] });
  await bundle.write({ dir: folder, format: "es", chunkFileNames: "[name].js" });
  isRight(await served(folder));
});

test("webpack", async () => {
  const folder = output("webpack", false);
  const webpack = (await load("webpack")).default;
  const options = { mode: "production", target: "web", context: root, entry: { page: entries[0] }, output: { path: folder, filename: "[name].js" } };
  const stats = await new Promise((done, failed) => webpack(options, (error, found) => (error ? failed(error) : done(found))));
  assert.ok(!stats.hasErrors(), stats.toString("errors-only"));
  isRight(await served(folder));
});

test("Vite, built and from its development server", async () => {
  const folder = output("vite", false);
  const vite = await import(join(INSTALLED, "node_modules/vite/dist/node/index.js"));
  const options = { root, configFile: false, logLevel: "error", base: "./" };
  await vite.build({ ...options, build: { outDir: folder, emptyOutDir: true } });
  isRight(await served(folder));
  for (const [name, optimizeDeps] of [["plain", { exclude: ["vademecum-eval"] }], ["optimized", {}]]) {
    const cacheDir = join(WORK, "bundles", name);
    const server = await vite.createServer({ ...options, base: "/", optimizeDeps, cacheDir, server: { host: "127.0.0.1", port: 0 } });
    await server.listen();
    try {
      isRight(await answer(server.resolvedUrls.local[0]));
    } finally {
      await server.close();
    }
  }
});
