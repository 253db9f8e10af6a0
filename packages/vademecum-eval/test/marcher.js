// A worker that marches.
import { Body } from "/node_modules/vademecum-eval/index.js";
import { march } from "./march.js";

self.onmessage = async ({ data }) => self.postMessage(await march(Body, data));
