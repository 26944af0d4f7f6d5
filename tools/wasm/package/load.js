// Finds and compiles a module of the package.

import { MocapError, bytesOf } from "./error.js";

/** The address of the module, beside the script. `expression` contains the literal address that bundlers recognize. */
function beside(expression, name) {
  let address;
  try {
    address = expression();
  } catch {
    const message = `a script that is not a module cannot find ${name}`;
    throw new MocapError({ code: "invalid-value", message, help: `give load() the address of ${name}` });
  }
  // In development, Vite 5 to 7 serve a copy of this script from their own folder, but not a copy of the module. Addresses from
  // Next.js have no host, and stay unchanged.
  const inVite = /\/\.vite\/.*$/;
  return inVite.test(address.href) ? new URL(address.href.replace(inVite, `/mocap-wasm/${name}`)) : address;
}

/** The first bytes of every WebAssembly module. */
const MAGIC = [0, 0x61, 0x73, 0x6d];

/** Rejects bytes that are not a module, such as an error page of a server. */
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
  // Streaming needs the right media type, which some servers do not send.
  if (type === "application/wasm") return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(checked(new Uint8Array(await response.arrayBuffer()), source, type));
}

/** `expression` is the address of the module of this name in the package. */
export async function compile(source, expression, name) {
  if (source instanceof WebAssembly.Module) return source;
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return WebAssembly.compile(checked(bytesOf(source), "what load() was given", ""));
  const address = source ?? beside(expression, name);
  // Request the Node module at run time, because bundlers would try to resolve an import.
  const files = String(address).startsWith("file:") && globalThis.process?.getBuiltinModule?.("node:fs/promises");
  if (files) return WebAssembly.compile(checked(await files.readFile(new URL(address)), address, ""));
  return fetched(address);
}
