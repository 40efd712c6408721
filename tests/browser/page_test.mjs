// Runs the demo under a hostile name and looks at its page in headless Chromium: no error, no request, every tool.
// usage: node page_test.mjs MESHMSER SOURCE [FOLDER for screenshots]
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { readFileSync, rmSync } from "node:fs";
import { join } from "node:path";
import { call, demoFolder, drawn, keepShot, launch, open, pixelOf } from "./chromium.mjs";

const [, , program, source, shots] = process.argv;
const browser = await launch(source);
const hostile = "<img src=x onerror=window.hacked=1>.ply";
const title = "</script><script>window.hacked=1</script>";
const folder = demoFolder(source, hostile, `{title: '${title}'}`), config = join(folder, "run.yaml"), cache = join(folder, "cache");
call(program, "run", config, "--out", join(folder, "out"), "--cache", cache, "-q");

const problems = [];
try {
  const page = await open(browser, join(folder, "out/report.html"), problems);
  const shot = async (name) => {
    await drawn(page);
    await keepShot(page, shots, name);
    return createHash("sha256").update(await (await page.$("#stage3d")).screenshot()).digest("hex");
  };
  const text = (selector) => page.$eval(selector, (element) => element.textContent);
  const rows = () => page.$$eval("#table tbody tr", (all) => all.map((row) => Number(row.dataset.row)));
  const session = await page.createCDPSession();
  await session.send("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: folder, eventsEnabled: true });
  // The file lies there, empty, before it is written: the end of the download counts, not its name.
  const fetched = async (button, name, encoding = "utf8") => {
    const ended = new Promise((done, failed) => {
      const late = setTimeout(() => settle("late"), 60000);
      const settle = (state) => {
        clearTimeout(late);
        session.off("Browser.downloadProgress", follow);
        if (state === "completed") done();
        else failed(new Error(`download of ${name}: ${state}`));
      };
      const follow = ({ state }) => { if (state !== "inProgress") settle(state); };
      session.on("Browser.downloadProgress", follow);
    });
    await page.click(button);
    await ended;
    const content = readFileSync(join(folder, name), encoding);
    rmSync(join(folder, name));
    return content;
  };

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
  assert.deepEqual(Object.keys(header.regions[0]).sort(), [...names].sort());
  lines.forEach((cells, i) => {
    for (const name of names) {
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
  const place = await pixelOf(page, 3);
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
  const heads = () => page.$$eval("#table thead th", (all) => all.map((cell) => cell.textContent.replace(/ [▲▼]$/, "").replaceAll(" ", "_")));
  assert.equal((await heads()).length, 8);
  const box = await page.$('#columns input[data-column="scalar_mean"]');
  await page.click("#columns summary");
  await drawn(page);
  assert.ok(await box.evaluate((input) => input.isConnected), "opening the list does not make it anew under the mouse");
  await box.click();
  assert.deepEqual((await heads()).slice(-1), ["scalar_mean"]);
  await page.type("#filter", "upper, stability <= 0.3");
  assert.deepEqual(await rows(), header.regions.filter((r) => r.polarity === "upper" && Number(r.stability) <= 0.3).map((r) => r.label));
  await page.$eval("#filter", (input) => { input.value = ""; input.dispatchEvent(new Event("input")); });
  await page.$$eval("#table thead th", (all) => all.find((cell) => cell.textContent === "stability").click());
  const csv = await fetched("#csv", "regions.csv");
  assert.deepEqual(csv.split("\n")[0].split(",").sort(), [...names].sort());
  assert.equal(csv.trim().split("\n").length, lines.length + 1);
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
  await page.mouse.click(...(await pixelOf(page, label)));
  const chain = await text("#chain");
  assert.ok(chain.includes(`region ${region}`), chain);
  assert.equal(await page.$$eval("#charts .uplot", (all) => all.length), 2);
  // Its q, computed here again from the page's tree, is the run's.
  const told = await page.$$eval("#chain tr.chosen", (all) => all.map((row) => [row.children[1].textContent, row.children[2].textContent]));
  assert.ok(told.some(([area, value]) => Math.abs(Number(area) - header.regions[region - 1].area) < 1e-3 * header.regions[region - 1].area &&
    Math.abs(Number(value) - header.regions[region - 1].stability) < 2e-3), JSON.stringify(told));
  // What became of each node is what `meshmser why` says of the same triangle.
  const place4 = await pixelOf(page, label);
  await page.mouse.click(...place4);
  const triangle = await page.evaluate(([x, y]) => {
    const { view } = window.meshmser, box = view.canvas.getBoundingClientRect();
    return view.pick(x - box.left, y - box.top).triangle;
  }, place4);
  assert.equal(header.cell, 0); // so that the page's triangles are the mesh's
  const why = call(program, "why", config, "--triangle", String(triangle)).split(/\n(?=upper tree|lower tree)/).find((part) => part.startsWith(header.trees[0].polarity));
  const short = (fate) => /^(region \d+|removed by \w+|not selected|a root)/i.exec(fate)?.[0].toLowerCase();
  const asked = why.split("\n").slice(2).map((line) => /(REGION \d+|removed by|not selected|a root).*$/.exec(line)?.[0]).filter(Boolean).map(short);
  if (await page.$("#allnodes")) await page.click("#allnodes");
  const shown = (await page.$$eval("#chain tbody tr", (all) => all.map((row) => row.children[3].textContent))).map(short);
  assert.deepEqual(shown, asked);
  assert.ok(new Set(asked).size > 2, JSON.stringify([...new Set(asked)])); // the path tells more than one fate
  await shot("chain");

  // Section.
  await page.click("#tab-Section");
  await page.click("#cut");
  const from = await pixelOf(page, 1), to = await pixelOf(page, 4);
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
  const meshRow = await page.$$eval("#stages details", (all) => all.map((e) => e.textContent).find((t) => t.startsWith("output: mesh")));
  assert.ok(meshRow?.includes("positions x"), "the mesh's statistics");
  assert.ok((await page.$$eval("#stages svg.bars", (all) => all.length)) > 20);
  await page.click("#theme");
  await shot("stages");

  // A picture as PNG, of the view's size.
  const png = await fetched("#png", "view.png", null);
  assert.equal(png.subarray(1, 4).toString(), "PNG");
  assert.equal(png.readUInt32BE(16), await page.$eval("#canvas", (canvas) => canvas.width));

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
  // The best plane does not depend on the view: turned, the drawing encloses as much.
  await page.select("#plane", "best");
  const fitting = async () => Math.abs([...(await fetched("#svg", "borders.svg")).matchAll(/ d="([^"]*)"/g)].reduce((sum, m) => sum + areaOf(m[1]), 0));
  const flat = await fitting();
  assert.ok(Math.abs(flat - enclosed) < 0.1 * enclosed, `${flat} ${enclosed}`);
  await page.focus("#canvas");
  for (let i = 0; i < 6; i++) await page.keyboard.press("ArrowRight");
  assert.ok(Math.abs((await fitting()) - flat) < 1e-3 * flat);
  // And the file that export writes holds the same runs.
  const exported = readFileSync(join(folder, "out/label_borders.svg"), "utf8");
  assert.equal([...exported.matchAll(new RegExp(`data-number="${facing}"`, "g"))].length, [...svg.matchAll(/<path/g)].length);

  assert.deepEqual(problems, []);
  console.log("the page works");
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
