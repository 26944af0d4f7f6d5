// Starts Chromium and takes pictures, for the checks of this folder.

import { execFileSync } from "node:child_process";

/**
 * Options for Playwright: the processor draws instead of a graphics card, and Chromium makes no network requests of its
 * own.
 */
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

/** Saves a picture of a page as a PNG file. 128 colours reduce the file to a third. */
export async function savePicture(page, path) {
  const input = await page.screenshot();
  const colors = "split[a][b];[a]palettegen=max_colors=128:stats_mode=full[p];[b][p]paletteuse=dither=none";
  execFileSync("ffmpeg", ["-v", "error", "-y", "-f", "png_pipe", "-i", "-", "-vf", colors, "-frames:v", "1", "-update", "1", "-pred", "none", path], { input });
}
