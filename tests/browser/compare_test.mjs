// Two runs of the demo on one page, as `meshmser report A B` makes it and as the page's file picker does.
// usage: node compare_test.mjs MESHMSER SOURCE [FOLDER for screenshots]
import assert from "node:assert/strict";
import { readFileSync, rmSync, statSync } from "node:fs";
import { join } from "node:path";
import { call, demoFolder, drawn, keepShot, launch, open, pixelOf } from "./chromium.mjs";

const [, , program, source, shots] = process.argv;
const browser = await launch(source);
const folder = demoFolder(source, "tablet.ply"), config = join(folder, "run.yaml"), out = (name) => join(folder, name);
const problems = [];
try {
  call(program, "run", config, "--out", out("a"), "--cache", out("cache"), "-q");
  call(program, "report", config, "--set", "mser.delta=7", "--out", out("b"), "--cache", out("cache"), "-q");
  const written = call(program, "report", out("a"), out("b"), "--out", out("both"), "-q").trim();
  assert.equal(written, join(out("both"), "comparison.html"));
  // The mesh of both is stored once.
  assert.ok(statSync(written).size < 1.3 * statSync(join(out("a"), "report.html")).size);

  const page = await open(browser, written, problems);
  const tables = () => page.evaluate(() => Object.fromEntries([...document.querySelectorAll("#compared table")].map((table) =>
    [table.id, [...table.tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.textContent))])));
  const runs = ["a", "b"].map((name) => JSON.parse(readFileSync(join(out(name), "run.json"), "utf8")));
  const figure = (run, stage, name) => run.stages.find((s) => s.name === stage).report.find((r) => r.name === name).value;
  const told = await tables();
  assert.deepEqual(told.differing, [["mser.delta", "4", "7"]]);
  const regions = told.figures.find(([name]) => name === "num regions");
  assert.deepEqual(regions.slice(1).map(Number), runs.map((run) => figure(run, "mser", "num_regions")));
  assert.equal(told.overlaps.length, figure(runs[0], "mser", "num_labels"));
  // Of this mesh, which is the same in both, shares are exact: compared with a count over the triangles.
  const expected = await page.evaluate(() => {
    const { arrays, header } = window.meshmser, other = window.meshmser.other;
    return header.labels.map((row) => {
      let most = 0;
      const counts = new Map();
      for (let t = 0; t < arrays.labels.length; t++) if (arrays.labels[t] === row.label) counts.set(other.arrays.labels[t], (counts.get(other.arrays.labels[t]) ?? 0) + 1);
      for (const count of counts.values()) most = Math.max(most, count);
      return most / row.triangles;
    });
  });
  told.overlaps.forEach((row, i) => assert.ok(Math.abs(Number.parseInt(row[2]) / 100 - expected[i]) < 0.03, `${row} ${expected[i]}`));

  // Both views move together, and a chosen row is marked in both.
  const state = () => page.evaluate(() => [window.meshmser.view, window.meshmser.other.view].map((v) => [...v.turn.toArray(), v.height, ...v.target.toArray(), ...v.lightAngle].map((x) => x.toFixed(9)).join(" ")));
  const [ours, theirs] = await state();
  assert.equal(ours, theirs);
  for (const canvas of ["#canvas", "#othercanvas"]) {
    await page.focus(canvas);
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("+");
    const [a, b] = await state();
    assert.equal(a, b);
    assert.notEqual(a, ours);
  }
  await page.focus("#light");
  await page.keyboard.press("ArrowLeft");
  assert.equal(...(await state()));
  await page.click("#overlaps tbody tr");
  assert.deepEqual(await page.evaluate(() => window.meshmser.chosen), [1]);
  await page.focus("#canvas");
  await page.keyboard.press("0");
  await drawn(page);
  await keepShot(page, shots, "comparison");
  assert.ok(await pixelOf(page, 1));

  // The picker: a run lies on itself wholly; another run takes its place.
  const single = await open(browser, join(out("a"), "report.html"), problems);
  await single.click("#tab-Compare");
  const pick = async (path) => {
    await single.$eval("#compared", (element) => element.replaceChildren());
    await (await single.$("#other")).uploadFile(path);
    await single.waitForSelector("#overlaps");
    return single.$$eval("#overlaps tbody tr", (all) => all.map((row) => [...row.cells].map((cell) => cell.textContent)));
  };
  for (const [here, there, share, back] of await pick(join(out("a"), "report.html"))) assert.ok(here === there && share === "100 %" && back === "100 %", `${here} ${there} ${share} ${back}`);
  assert.ok(await single.$("#nodiffering"));
  assert.deepEqual(await pick(join(out("b"), "report.html")), told.overlaps);
  assert.equal((await single.$$("#othercanvas")).length, 1);

  assert.deepEqual(problems, []);
  console.log("two runs beside each other");
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
