// How long pages take from being opened to their first picture and to the whole one, in headless Chromium, which draws in
// software: the least of several openings, in seconds. No test: times are the machine's.
// usage: node first_picture.mjs SOURCE REPORT.html ...
import { statSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { launch } from "./chromium.mjs";

const [, , source, ...paths] = process.argv;
for (const path of paths) {
  const times = [];
  let triangles = 0;
  for (let i = 0; i < 5; i++) {
    const browser = await launch(source), page = await browser.newPage();
    await page.setViewport({ width: 1400, height: 950 });
    await page.goto(pathToFileURL(path).href);
    await page.waitForFunction(() => document.documentElement.dataset.ready === "yes", { timeout: 120000 });
    times.push(await page.evaluate(() => {
      const { view } = window.meshmser, first = performance.getEntriesByName("first picture")[0].startTime;
      const start = performance.now();
      view.drawStanding();
      return [first, performance.now() - start].map((t) => t / 1000);
    }));
    triangles = await page.evaluate(() => window.meshmser.view.mesh.numTriangles);
    await browser.close();
  }
  const least = [0, 1].map((k) => Math.min(...times.map((t) => t[k])).toFixed(2));
  console.log(`${path}: ${triangles} triangles, ${(statSync(path).size / 1e6).toFixed(1)} MB; first picture ${least[0]} s, a standing one ${least[1]} s; all: ${times.map((t) => t[0].toFixed(2)).join(" ")}`);
}
