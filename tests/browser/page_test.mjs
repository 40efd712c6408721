// Runs the demo under a hostile name and looks at its page in headless Chromium: no error, no request, every tool.
// usage: node page_test.mjs MESHMSER SOURCE [FOLDER for screenshots]
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { createHash } from "node:crypto";
import { copyFileSync, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { launch, open } from "./chromium.mjs";

const [, , program, source, shots] = process.argv;
const browser = await launch(source);
const folder = mkdtempSync(join(tmpdir(), "meshmser-page-"));
const hostile = "<img src=x onerror=window.hacked=1>.ply";
const title = "</script><script>window.hacked=1</script>";
copyFileSync(join(source, "data/demo/tablet.ply"), join(folder, hostile));
writeFileSync(join(folder, "run.yaml"), `version: 1
units: mm
stages:
  - load: {path: '${hostile}'}
  - orient: {}
  - curvature: {radius: 3 spacing, steps: 3}
  - mesh: {}
  - tree: {scalar: mean_curvature}
  - mser: {nested: outermost, delta: 4}
  - borders: {}
  - export: {pictures: false, points: false}
  - report: {title: '${title}'}
`);
const ran = spawnSync(program, ["run", join(folder, "run.yaml"), "--out", join(folder, "out"), "--cache", join(folder, "cache"), "-q"], { encoding: "utf8" });
assert.equal(ran.status, 0, ran.stderr);

const problems = [];
try {
  const page = await open(browser, join(folder, "out/report.html"), problems);
  const drawn = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => { window.meshmser.view.drawStanding(); requestAnimationFrame(done); })));
  const shot = async (name) => {
    await drawn();
    if (shots) { mkdirSync(shots, { recursive: true }); await page.screenshot({ path: join(shots, name + ".png") }); }
    return createHash("sha256").update(await (await page.$("#stage3d")).screenshot()).digest("hex");
  };
  const text = (selector) => page.$eval(selector, (element) => element.textContent);
  const rows = () => page.$$eval("#table tbody tr", (all) => all.map((row) => Number(row.dataset.row)));
  // A pixel in the middle of a triangle of that label that is not hidden by another.
  const pixelOf = (label) => page.evaluate((wanted) => {
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

  // Names are text.
  assert.equal(await text("#title"), title);
  assert.equal(await page.title(), title);
  assert.ok(readFileSync(join(folder, "out/report.html"), "utf8").includes("\\u003cimg src=x"), "the scan's name is escaped");
  assert.equal(await page.$$eval("img", (all) => all.length), 0);
  assert.equal(await page.evaluate(() => window.hacked), undefined);

  // Figures are those of regions.csv and run.json.
  const run = JSON.parse(readFileSync(join(folder, "out/run.json"), "utf8"));
  const figure = (stage, name) => run.stages.find((s) => s.name === stage).report.find((r) => r.name === name).value;
  const header = await page.evaluate(() => window.meshmser.header);
  assert.equal(header.summary.num_points, figure("load", "num_points"));
  assert.equal(header.summary.spacing, figure("load", "spacing"));
  assert.equal(header.summary.num_triangles, figure("mesh", "num_triangles"));
  assert.equal(header.summary.num_regions, figure("mser", "num_regions"));
  const [names, ...lines] = readFileSync(join(folder, "out/regions.csv"), "utf8").trim().split("\n").map((line) => line.split(","));
  assert.equal(lines.length, header.regions.length);
  assert.ok(lines.length > 10);
  lines.forEach((cells, i) => {
    for (const name of Object.keys(header.regions[i])) {
      if (name === "centroid") continue;
      const cell = cells[names.indexOf(name)], value = header.regions[i][name];
      assert.equal(String(typeof value === "number" ? Number(cell) : cell), String(value), `region ${i + 1}: ${name}`);
    }
  });
  const cards = await text("#verdict");
  assert.ok(cards.includes(`${header.regions.length}regions`), cards);

  // A coarse copy draws the first picture and what moves: each of its triangles stands for one of the mesh.
  const copy = await page.evaluate(() => {
    const { arrays } = window.meshmser;
    return { triangles: arrays.coarse_triangles.length, corners: arrays.coarse_corners.length, last: Math.max(...arrays.coarse_triangles) };
  });
  assert.ok(copy.triangles > 20000 && copy.triangles <= 100000 && copy.corners === 3 * copy.triangles);
  assert.ok(copy.last < header.summary.num_triangles);

  // The first picture shows the surface; a click on it chooses its row, a click on a row marks the surface.
  const first = await shot("labels");
  const place = await pixelOf(3);
  assert.ok(place, "label 3 can be seen");
  await page.mouse.click(...place);
  assert.match(await text("#hint"), /^label 3:/);
  assert.deepEqual(await page.$$eval("tr.chosen", (all) => all.map((row) => Number(row.dataset.row))), [3]);
  assert.notEqual(await shot("picked"), first);
  await page.click('#table tr[data-row="5"]');
  assert.match(await text("#hint"), /^label 5:/);
  await page.keyboard.down("Shift");
  await page.click('#table tr[data-row="2"]');
  await page.keyboard.up("Shift");
  assert.ok((await text("#comparison")).includes("area"));

  // Table: filters, order, hiding.
  await page.type("#filter", "area > 6");
  const large = await rows();
  assert.deepEqual(large, header.labels.filter((l) => l.area > 6).map((l) => l.label));
  assert.ok(large.length > 0 && large.length < header.labels.length);
  await page.$eval("#filter", (input) => { input.value = ""; input.dispatchEvent(new Event("input")); });
  await page.select("#rows", "regions");
  await page.$$eval("#table thead th", (all) => all.find((cell) => cell.textContent === "stability").click());
  const q = (await rows()).map((label) => header.regions[label - 1].stability);
  assert.deepEqual(q, [...q].sort((a, b) => b - a));
  await page.select("#rows", "labels");
  await page.click('#table tr[data-row="1"]');
  await page.click("#isolate");
  const alone = await shot("isolated");
  await page.click("#isolate");
  await page.$$eval("button", (all) => all.find((b) => b.textContent === "show all").click());
  assert.notEqual(await shot("all"), alone);

  // Colours, light, keyboard.
  await page.select("#colouring", "0");
  const scalar = await shot("scalar");
  assert.ok(await page.$("#histogram"));
  const bar = await (await page.$("#histogram")).boundingBox();
  await page.mouse.move(bar.x + 20, bar.y + 10);
  await page.mouse.down();
  await page.mouse.move(bar.x + 90, bar.y + 10, { steps: 3 });
  await page.mouse.up();
  const brushed = await shot("brushed");
  assert.notEqual(brushed, scalar);
  await page.focus("#light");
  for (let i = 0; i < 6; i++) await page.keyboard.press("ArrowLeft");
  assert.match(await page.$eval("#light", (dial) => dial.getAttribute("aria-valuetext")), /^225 degrees/);
  const raked = await shot("raked");
  assert.notEqual(raked, brushed);
  await page.focus("#canvas");
  await page.keyboard.press("ArrowLeft");
  assert.notEqual(await shot("turned"), raked);
  await page.keyboard.press("0");

  // Levels: as many components as the tree has nodes alive there; the chain of a triangle in a region names the region.
  await page.click("#tab-Levels");
  const components = [];
  for (const level of [5, 40]) {
    await page.$eval("#level", (slider, value) => { slider.value = value; slider.dispatchEvent(new Event("input")); }, level);
    components.push(Number(/; ([\d\u2009]+) components/.exec(await text("#leveltext"))[1].replaceAll("\u2009", "")));
  }
  const expected = await page.evaluate(() => {
    const { arrays } = window.meshmser, p = window.meshmser.header.trees[0].polarity;
    const parent = arrays[p + "_parent"], hi = arrays[p + "_hi"];
    return [5, 40].map((k) => parent.reduce((n, up, i) => n + (hi[i] >= k && (up < 0 || hi[up] < k) ? 1 : 0), 0));
  });
  assert.deepEqual(components, expected);
  await shot("levels");
  await page.select("#colouring", "labels");
  const region = header.regions.findIndex((r) => r.polarity === header.trees[0].polarity) + 1;
  const label = header.labels.find((l) => l.region === region).label;
  await page.mouse.click(...(await pixelOf(label)));
  const chain = await text("#chain");
  assert.ok(chain.includes(`region ${region}`), chain);
  assert.equal(await page.$$eval("#charts .uplot", (all) => all.length), 2);
  // Its q, computed here again from the page's tree, is the run's.
  const told = await page.$$eval("#chain tr.chosen", (all) => all.map((row) => [row.children[1].textContent, row.children[2].textContent]));
  assert.ok(told.some(([area, value]) => Math.abs(Number(area) - header.regions[region - 1].area) < 1e-3 * header.regions[region - 1].area &&
    Math.abs(Number(value) - header.regions[region - 1].stability) < 2e-3), JSON.stringify(told));
  await shot("chain");

  // Section.
  await page.click("#tab-Section");
  await page.click("#cut");
  const from = await pixelOf(1), to = await pixelOf(4);
  await page.mouse.click(...from);
  await page.mouse.click(...to);
  assert.match(await text("#sectiontext"), /^Length [\d.]+ mm, heights over [\d.]+ mm/);
  assert.equal(await page.$$eval("#profile .uplot", (all) => all.length), 2);
  await shot("section");

  // Stages.
  await page.click("#tab-Stages");
  const stages = await text("#stages");
  for (const stage of run.stages) assert.ok(stages.includes(stage.name), stage.name);
  assert.deepEqual(await page.$$eval("#stages .changed", (all) => all.map((e) => e.textContent)),
    run.stages.flatMap((s) => s.changed.map((name) => `${s.parameters[name]} (not the default)`)));
  await page.click("#theme");
  await shot("stages");

  // A picture as PNG, of the view's size.
  const session = await page.createCDPSession();
  await session.send("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: folder });
  await page.click("#png");
  for (let i = 0; i < 600 && !existsSync(join(folder, "view.png")); i++) await new Promise((done) => setTimeout(done, 100));
  const png = readFileSync(join(folder, "view.png"));
  assert.equal(png.subarray(1, 4).toString(), "PNG");
  assert.equal(png.readUInt32BE(16), await page.$eval("#canvas", (canvas) => canvas.width));

  // Two runs: one parameter differs; a run lies on itself wholly.
  const other = spawnSync(program, ["report", join(folder, "run.yaml"), "--set", "mser.delta=7", "--out", join(folder, "other"), "--cache", join(folder, "cache"), "-q"], { encoding: "utf8" });
  assert.equal(other.status, 0, other.stderr);
  await page.click("#tab-Compare");
  const compare = async (path) => {
    await (await page.$("#other")).uploadFile(path);
    await page.waitForFunction(() => document.querySelectorAll("#compared table").length >= 2, { timeout: 120000 });
    return page.$$eval("#compared table", (all) => all.map((table) => [...table.tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.textContent))));
  };
  const self = await compare(join(folder, "out/report.html"));
  assert.equal(self.length, 2); // figures, labels: no parameter differs
  assert.equal(self[1].length, header.labels.length);
  for (const [here, there, share] of self[1]) assert.ok(here === there && Number.parseInt(share) >= 99, `${here} ${there} ${share}`);
  const tables = await compare(join(folder, "other/report.html"));
  assert.deepEqual(tables[1], [["mser.delta", "4", "7"]]);
  await shot("compare");
  await page.click("#tab-Regions");

  // Drawings: the glyph's border to scale, level and hole pieces apart; the tablet's front is seen along its normal.
  await page.click("#tab-Regions");
  await page.select("#rows", "labels");
  await page.focus("#canvas");
  await page.keyboard.press("0");
  // A small label that faces the eye, not the tablet's side.
  const facing = await page.evaluate(() => {
    const { view, arrays, header } = window.meshmser, { normals, ownVertex } = view.mesh;
    const eye = view.camera.getWorldDirection(view.target.clone()), sums = header.labels.map(() => 0);
    for (let t = 0; t < arrays.labels.length; t++) {
      const v = 4 * ownVertex[t];
      if (arrays.labels[t]) sums[arrays.labels[t] - 1] -= (normals[v] * eye.x + normals[v + 1] * eye.y + normals[v + 2] * eye.z) / 32767;
    }
    return header.labels.findIndex((row, i) => row.area < 100 && sums[i] > 0.8 * row.triangles) + 1;
  });
  assert.ok(facing > 0);
  await page.click(`#table tr[data-row="${facing}"]`);
  const fetched = async (button, name) => {
    await page.click(button);
    for (let i = 0; i < 600 && !existsSync(join(folder, name)); i++) await new Promise((done) => setTimeout(done, 100));
    return readFileSync(join(folder, name), "utf8");
  };
  const svg = await fetched("#svg", "borders.svg"), dxf = await fetched("#dxf", "borders.dxf");
  assert.deepEqual([...new Set([...svg.matchAll(/data-number="(\d+)"/g)].map((m) => m[1]))], [String(facing)]);
  assert.ok(!svg.includes("NaN") && !dxf.includes("NaN"));
  const areaOf = (d) => {
    const points = d.split(/[MLZ]/).filter(Boolean).map((p) => p.split(" ").map(Number));
    return points.reduce((sum, [x, y], i) => { const [u, v] = points[(i + 1) % points.length]; return sum + (x * v - u * y) / 2; }, 0);
  };
  const enclosed = Math.abs([...svg.matchAll(/ d="([^"]*)"/g)].reduce((sum, m) => sum + areaOf(m[1]), 0));
  const area = header.labels[facing - 1].area; // of the surface; its projection is smaller, by its roughness
  assert.ok(enclosed > 0.6 * area && enclosed < area, `${enclosed} of ${area}`);
  assert.equal([...dxf.matchAll(/POLYLINE/g)].length, [...svg.matchAll(/<path/g)].length);

  assert.deepEqual(problems, []);
  console.log("the page works");
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
