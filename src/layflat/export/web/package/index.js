import { description } from "./machine.js";
import { instantiate } from "./runtime.js";

export { restore, save } from "./structs.js";

/**
 * Loads the machine. `source`: its module, compiled, as bytes or as a response; default: the file beside this one.
 */
export async function load(source = readModule()) {
  return instantiate(description, await source);
}

async function readModule() {
  const url = new URL(`./${description.name}.wasm`, import.meta.url);
  if (url.protocol !== "file:") return fetch(url);
  const { readFile } = await import("node:fs/promises");
  return readFile(url);
}
