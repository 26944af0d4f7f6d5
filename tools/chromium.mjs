// How the checks of this folder start Chromium.

import { execFileSync } from "node:child_process";

/** Options for Playwright: a processor draws in place of a graphics card, and nothing goes over the network unasked. */
export const launchOptions = () => ({
  executablePath: process.env.CHROMIUM ?? execFileSync("sh", ["-c", "command -v chromium"], { encoding: "utf8" }).trim(),
  args: [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
  ],
});
