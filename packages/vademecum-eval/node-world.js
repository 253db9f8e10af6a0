// Worlds in Node, where the module and files lie on the disk.
import { readFile } from "node:fs/promises";
import { readFilesBy } from "./module.js";

readFilesBy(readFile);

export * from "./world.js";
