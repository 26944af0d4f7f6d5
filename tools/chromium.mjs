// How the checks of this folder start Chromium and take pictures.

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

/** Saves what a page shows as a PNG file. With 128 colours it has a third of the bytes. */
export async function savePicture(page, path) {
  const input = await page.screenshot();
  const colors = "split[a][b];[a]palettegen=max_colors=128:stats_mode=full[p];[b][p]paletteuse=dither=none";
  execFileSync("ffmpeg", ["-v", "error", "-y", "-f", "png_pipe", "-i", "-", "-vf", colors, "-frames:v", "1", "-update", "1", "-pred", "none", path], { input });
}
