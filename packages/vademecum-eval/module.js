// Where the package's WebAssembly module and the bytes of files come from. Names no module of Node, so that bundlers can pack it for
// pages; node.js, the package's entry in Node, adds the reading of files.
import { Refused } from "./evaluator.js";

/** The modules of this package, each compiled once, by their addresses. */
const own = new Map();

/** Reads a file of the disk by its URL; only where node.js has set it. */
let readFile;

export function readFilesBy(reader) {
  readFile = reader;
}

/** The compiled evaluator: the module that is given, or that of this package. */
export const compiled = (wasm) => compiledAt(wasm, () => new URL("./evaluator.wasm", import.meta.url), "Body.open(file, { wasm })");

/** A compiled module: the one that is given, or that of this package at `address`; `call` takes its bytes, too. */
export async function compiledAt(wasm, address, call) {
  if (wasm instanceof WebAssembly.Module) return wasm;
  if (wasm) return WebAssembly.compile(wasm);
  const url = address();
  if (!own.has(url.href)) own.set(url.href, fetched(url, call).catch((error) => {
    own.delete(url.href);
    throw error;
  }));
  return own.get(url.href);
}

async function fetched(url, call) {
  const bytes = await bytesAt(url);
  const begins = Array.from(bytes.subarray(0, 4), (byte) => byte.toString(16).padStart(2, "0")).join(" ");
  if (begins !== "00 61 73 6d") {
    throw new Refused(
      `${url}: this is no WebAssembly module (it begins with ${begins || "nothing"}), so a server or a bundler answers with something else; ` +
      'with Vite write optimizeDeps: { exclude: ["vademecum-eval"] } into its configuration; elsewhere copy ' +
      `${url.pathname.split("/").at(-1)} of this package there, or give its bytes: ${call}`,
    );
  }
  return WebAssembly.compile(bytes);
}

/** The bytes at a URL. */
async function bytesAt(url) {
  if (url.protocol !== "file:") return bytesIn(await fetch(url), url);
  if (readFile) return readFile(url);
  throw new Refused(`${url}: a page reads no files of the disk; in Node import this package by its name, "vademecum-eval"`);
}

/** The bytes of an answer of `fetch`. */
async function bytesIn(answer, url = answer.url) {
  if (!answer.ok) throw new Refused(`${url}: the server answers ${answer.status} ${answer.statusText}; check the address`);
  return new Uint8Array(await answer.arrayBuffer());
}

/** The bytes of a file: given, behind a URL, or in an answer of `fetch`; undefined for what is none of these. */
export async function bytesOf(given) {
  const file = await given;
  if (file instanceof Uint8Array) return file;
  if (file instanceof ArrayBuffer) return new Uint8Array(file);
  if (file instanceof URL) return bytesAt(file);
  return typeof file?.arrayBuffer === "function" && "ok" in file ? bytesIn(file) : undefined;
}
