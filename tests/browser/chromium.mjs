// Debian's Chromium, driven through the page's packages; the test is skipped, and says why, where either is missing.
import { existsSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

/** Exit code 77 is that of a skipped test; a failure where the tests of the page are required. */
export function skip(why) {
  console.log(`skipped: ${why}`);
  process.exit(process.env.MESHMSER_PAGE_TESTS === "required" ? 1 : 77);
}

/** A module of the page's packages. */
export function packageOf(source, name) {
  const modules = join(source, "stages/report/page/node_modules");
  if (!existsSync(join(modules, name))) skip("the page's packages are not installed; npm ci in stages/report/page");
  return createRequire(join(modules, "x.js")).resolve(name);
}

/** Drawing is in software, so that it is the same everywhere; time-outs serve two slow cores. */
export async function launch(source) {
  const executablePath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);
  if (!executablePath) skip("no chromium is installed; apt-get install chromium");
  const puppeteer = (await import(pathToFileURL(packageOf(source, "puppeteer-core")))).default;
  return puppeteer.launch({
    executablePath, headless: true, timeout: 120000, protocolTimeout: 240000, // in a fresh profile, which is removed
    args: ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
      "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  });
}

/** A page from disk, ready; `problems` takes its errors, warnings and requests, of which there may be none. */
export async function open(browser, path, problems, size = { width: 1400, height: 950 }) {
  const page = await browser.newPage();
  page.setDefaultTimeout(120000);
  await page.setViewport(size);
  page.on("console", (message) => {
    // The driver notes each picture read back, as tests do often.
    const note = /GL Driver Message \(OpenGL, Performance,/.test(message.text());
    if (["error", "warn"].includes(message.type()) && !note) problems.push(`console: ${message.text()}`);
  });
  page.on("pageerror", (error) => problems.push(`error: ${error.message}`));
  const url = pathToFileURL(path).href;
  page.on("request", (request) => { if (request.url() !== url && !/^(data|blob):/.test(request.url())) problems.push(`request: ${request.url()}`); });
  await page.goto(url);
  await page.waitForFunction(() => document.documentElement.dataset.ready === "yes");
  return page;
}
