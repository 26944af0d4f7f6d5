// Finds and compiles a module of the package.

import { MocapError, bytesOf } from "./error.js";

/** Where the module is: beside the script that asks for it, by its own expression, which bundlers find. */
function beside(expression, name) {
  let address;
  try {
    address = expression();
  } catch {
    const message = `a script that is no module does not know where ${name} is`;
    throw new MocapError({ code: "invalid-value", message, help: `give load() the address of ${name}` });
  }
  // While one develops, Vite 5 to 7 have a copy of this script in a folder of their own, and not of the module. What Next.js
  // gives has no host, so that it is left as it is.
  const inVite = /\/\.vite\/.*$/;
  return inVite.test(address.href) ? new URL(address.href.replace(inVite, `/mocap-wasm/${name}`)) : address;
}

/** The start of every module of WebAssembly. */
const MAGIC = [0, 0x61, 0x73, 0x6d];

/** Refuses what is no module, a page that a server sends in place of a file. */
function checked(bytes, source, type) {
  if (MAGIC.every((byte, index) => bytes[index] === byte)) return bytes;
  const found = /html/.test(type) || bytes[0] === 0x3c ? "a page of HTML" : `something else${type ? ` (${type})` : ""}`;
  throw new MocapError({
    code: "invalid-value",
    message: `${source} should be the WebAssembly of mocap-wasm, and is ${found}`,
    help: 'copy mocap.wasm from the package to where your site has it, and give load() its address; in Vite, `optimizeDeps: { exclude: ["mocap-wasm"] }`',
  });
}

async function fetched(source) {
  const response = await fetch(source);
  if (!response.ok) {
    const help = "copy mocap.wasm from the package there, or give load() its address";
    throw new MocapError({ code: "io", message: `${source}: ${response.status} ${response.statusText}`, help });
  }
  const type = response.headers.get("content-type") ?? "";
  // A host that does not know the type of `.wasm` cannot stream it.
  if (type === "application/wasm") return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(checked(new Uint8Array(await response.arrayBuffer()), source, type));
}

/** `expression` is the address of the module of this name in the package. */
export async function compile(source, expression, name) {
  if (source instanceof WebAssembly.Module) return source;
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return WebAssembly.compile(checked(bytesOf(source), "what load() was given", ""));
  const address = source ?? beside(expression, name);
  // Asked for at run time, for a bundler that sees an import of Node's would look for it.
  const files = String(address).startsWith("file:") && globalThis.process?.getBuiltinModule?.("node:fs/promises");
  if (files) return WebAssembly.compile(checked(await files.readFile(new URL(address)), address, ""));
  return fetched(address);
}
