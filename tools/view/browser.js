// Runs Chromium without a screen. Pages may neither write to the console nor make requests.

import { chromium } from "playwright-core";
import { launchOptions } from "../chromium.mjs";

/** A browser that draws WebGL in software and makes no network requests of its own. */
export function launch() {
  return chromium.launch(launchOptions());
}

/**
 * Opens a page. `trouble` collects every console message, every error and every request except the request for the
 * page.
 */
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

/** Waits until the page has drawn all changes. */
export function settled(page) {
  return page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}
