// Debian's Chromium, driven through the page's packages; the test is skipped, and says why, where either is missing.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, mkdtempSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
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

/** Runs the program, which must succeed; what it prints. */
export function call(program, ...words) {
  const ran = spawnSync(program, words, { encoding: "utf8", maxBuffer: 1 << 28 });
  assert.equal(ran.status, 0, ran.stderr);
  return ran.stdout;
}

/** The demo tablet under the name `scan` and a configuration for it, in a new folder. */
export function demoFolder(source, scan, report = "{}", exported = "{pictures: false, points: false}") {
  const folder = mkdtempSync(join(tmpdir(), "meshmser-page-"));
  copyFileSync(join(source, "data/demo/tablet.ply"), join(folder, scan));
  writeFileSync(join(folder, "run.yaml"), `version: 1
units: mm
stages:
  - load: {path: '${scan}'}
  - orient: {}
  - curvature: {radius: 3 spacing, steps: 3}
  - mesh: {}
  - tree: {scalar: mean_curvature}
  - mser: {nested: outermost, delta: 4}
  - borders: {}
  - export: ${exported}
  - report: ${report}
`);
  return folder;
}

/** The whole standing picture, drawn. */
export const drawn = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => { window.meshmser.view.drawStanding(); requestAnimationFrame(done); })));

/** Keeps a screenshot where a folder for them was given. */
export async function keepShot(page, shots, name) {
  if (!shots) return;
  mkdirSync(shots, { recursive: true });
  await page.screenshot({ path: join(shots, name + ".png") });
}

/** A pixel of the window in the middle of a triangle of that label that is not hidden by another. */
export const pixelOf = (page, label) => page.evaluate((wanted) => {
  const { view, arrays } = window.meshmser, box = view.canvas.getBoundingClientRect();
  view.drawStanding();
  for (let t = 0; t < arrays.labels.length; t++) {
    if (arrays.labels[t] !== wanted) continue;
    const corners = [0, 1, 2].map((k) => view.positionOf(view.mesh.index[3 * t + k]));
    const p = corners[0].add(corners[1]).add(corners[2]).divideScalar(3).project(view.camera);
    const x = Math.floor(((p.x + 1) / 2) * box.width), y = Math.floor(((1 - p.y) / 2) * box.height);
    const hit = view.pick(x, y);
    if (hit && arrays.labels[hit.triangle] === wanted) return [box.left + x + 0.5, box.top + y + 0.5];
  }
  return null;
}, label);

/** A page from disk, ready; `problems` takes its errors, warnings and requests, of which there may be none. `before` runs in it first. */
export async function open(browser, path, problems, size = { width: 1400, height: 950 }, before = () => {}) {
  const page = await browser.newPage();
  await page.evaluateOnNewDocument(before);
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
