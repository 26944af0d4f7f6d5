// Chromium without a screen, and pages in it that may neither talk to the console nor ask for anything.

import { chromium } from "playwright-core";
import { launchOptions } from "../chromium.mjs";

/** A browser that draws WebGL in software and talks to nobody on its own account. */
export function launch() {
  return chromium.launch(launchOptions());
}

/** Opens a page. `trouble` collects every console message, every error and every request but the one for the page. */
export async function open(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 760 }, ...options });
  const page = await context.newPage();
  const trouble = [];
  page.on("console", (message) => trouble.push(`console: ${message.text()}`));
  page.on("pageerror", (error) => trouble.push(`error: ${error.message}`));
  page.on("request", (request) => {
    const url = request.url();
    if (url.split("#")[0] !== address.split("#")[0] && !/^(data|blob):/.test(url)) trouble.push(`request: ${url}`);
  });
  await page.goto(address);
  await settled(page);
  return { page, trouble, close: () => context.close() };
}

/** Waits until what has changed is drawn. */
export function settled(page) {
  return page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}
