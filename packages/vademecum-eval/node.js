// The package in Node, where its module and files lie on the disk.
import { readFile } from "node:fs/promises";
import { readFilesBy } from "./module.js";

readFilesBy(readFile);

export * from "./index.js";
