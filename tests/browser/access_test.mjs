// The page for every hand and eye: rules of accessibility, keyboard, touch, print; its colours are those of the pictures.
// usage: node access_test.mjs MESHMSER SOURCE [FOLDER for screenshots]
import assert from "node:assert/strict";
import { mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { call, demoFolder, drawn, keepShot, launch, open, packageOf, pixelOf } from "./chromium.mjs";

const [, , program, source, shots] = process.argv;
const browser = await launch(source);
const axe = readFileSync(packageOf(source, "axe-core"), "utf8");
const folder = demoFolder(source, "tablet.ply", "{}", "{points: false, tree: false}");
const problems = [];
try {
  call(program, "run", join(folder, "run.yaml"), "--out", join(folder, "out"), "--cache", join(folder, "cache"), "-q");
  const path = join(folder, "out/report.html");
  const page = await open(browser, path, problems);

  // Names, roles and contrast in every panel, light and dark.
  await page.evaluate(axe);
  const check = async (where) => {
    const found = await page.evaluate(() => window.axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"] }));
    assert.deepEqual(found.violations.map((v) => `${where}: ${v.id}: ${v.nodes.map((n) => n.target.join(" ")).slice(0, 4).join(", ")}`), []);
  };
  await page.select("#colouring", "0");
  for (const dark of [false, true]) {
    if ((await page.evaluate(() => document.documentElement.classList.contains("dark"))) !== dark) await page.click("#theme");
    for (const tab of ["Regions", "Levels", "Section", "Stages", "Compare"]) {
      await page.click("#tab-" + tab);
      if (tab === "Stages") await page.$$eval("#stages details", (all) => all.forEach((d) => (d.open = true)));
      await check(`${tab}, ${dark ? "dark" : "light"}`);
    }
  }
  await page.click("#theme");
  await page.select("#colouring", "labels");

  // By keyboard alone: the tabs by arrows, a row by Enter.
  await page.focus("#tab-Regions");
  await page.keyboard.press("Enter");
  await page.keyboard.press("ArrowRight");
  assert.equal(await page.evaluate(() => document.activeElement.id), "tab-Levels");
  assert.ok(await page.$("#level"));
  await page.keyboard.press("ArrowLeft");
  await page.focus('#table tr[data-row="3"]');
  await page.keyboard.press("Enter");
  assert.match(await page.$eval("#hint", (hint) => hint.textContent), /^label 3:/);
  await page.focus("#canvas");
  const turn = () => page.evaluate(() => window.meshmser.view.turn.toArray().join(" "));
  const before = await turn();
  await page.keyboard.press("ArrowUp");
  assert.notEqual(await turn(), before);
  await page.keyboard.press("0");

  // Its colours are those of regions.png and curvature.png: light changes brightness only, so compare what share of the
  // coloured pixels bears each hue.
  const hues = (image) => page.evaluate(async (data) => {
    const picture = new Image();
    if (data) { picture.src = data; await picture.decode(); }
    const { view } = window.meshmser;
    view.drawStanding();
    const from = data ? picture : view.canvas, canvas = document.createElement("canvas");
    canvas.width = from.width; canvas.height = from.height;
    const context = canvas.getContext("2d");
    context.drawImage(from, 0, 0);
    const pixels = context.getImageData(0, 0, canvas.width, canvas.height).data, counts = new Map();
    let sum = 0;
    for (let i = 0; i < pixels.length; i += 4) {
      const [r, g, b, a] = pixels.subarray(i, i + 4), most = Math.max(r, g, b), least = Math.min(r, g, b);
      if (a < 255 || most < 90 || most - least < 0.12 * most) continue; // lines, grey, ground
      const hue = [r, g, b].map((c) => Math.round((8 * (c - least)) / (most - least)) + "").join(" ") + " " + Math.round((4 * least) / most);
      counts.set(hue, (counts.get(hue) ?? 0) + 1);
      sum++;
    }
    return [...counts].map(([hue, count]) => [hue, count / sum]);
  }, image);
  const common = (a, b) => { const of = new Map(b); return a.reduce((sum, [hue, share]) => sum + Math.min(share, of.get(hue) ?? 0), 0); };
  const png = (name) => "data:image/png;base64," + readFileSync(join(folder, "out", name)).toString("base64");
  await page.evaluate(() => window.meshmser.choose([], false));
  const curvature = (await page.evaluate(() => window.meshmser.header.scalars.map((s) => s.name + " " + s.stage))).indexOf("mean_curvature curvature");
  const ofLabels = await hues(null), labels = common(ofLabels, await hues(png("regions.png")));
  await page.select("#colouring", String(curvature));
  const ofScalar = await hues(null), scalar = common(ofScalar, await hues(png("curvature.png"))), unlike = common(ofLabels, ofScalar);
  console.log(`shares of common hues: labels ${labels.toFixed(2)}, curvature ${scalar.toFixed(2)}, one with the other ${unlike.toFixed(2)}`);
  assert.ok(labels > 0.85 && scalar > 0.85 && unlike < 0.6);
  await page.select("#colouring", "labels");

  // Printed: the figures and four fixed views, on white.
  const pdf = Buffer.from(await page.pdf({ format: "A4", printBackground: false }));
  assert.equal(await page.$$eval("#print img", (all) => all.filter((i) => i.naturalWidth > 300).length), 4);
  assert.equal(pdf.subarray(0, 5).toString(), "%PDF-");
  if (shots) { mkdirSync(shots, { recursive: true }); writeFileSync(join(shots, "printed.pdf"), pdf); }

  // By touch, on a tablet: one finger turns, two zoom and move, a tap picks.
  const tablet = await open(browser, path, problems, { width: 820, height: 1180, hasTouch: true, isMobile: true, deviceScaleFactor: 1 });
  const session = await tablet.createCDPSession();
  const touch = (type, ...points) => session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const view = () => tablet.evaluate(() => { const v = window.meshmser.view; return { turn: v.turn.toArray().join(" "), height: v.height, target: v.target.toArray().join(" ") }; });
  const box = await (await tablet.$("#canvas")).boundingBox(), [cx, cy] = [box.x + box.width / 2, box.y + box.height / 2];
  const still = await view();
  await touch("touchStart", [cx, cy]);
  for (let i = 1; i <= 5; i++) await touch("touchMove", [cx + 12 * i, cy + 6 * i]);
  await touch("touchEnd");
  const turned = await view();
  assert.notEqual(turned.turn, still.turn);
  assert.equal(turned.height, still.height);
  await touch("touchStart", [cx - 40, cy], [cx + 40, cy]);
  for (let i = 1; i <= 5; i++) await touch("touchMove", [cx - 40 - 10 * i, cy + 5 * i], [cx + 40 + 10 * i, cy + 5 * i]);
  await touch("touchEnd");
  const zoomed = await view();
  assert.equal(zoomed.turn, turned.turn);
  assert.ok(Math.abs(zoomed.height / turned.height - 80 / 180) < 0.02, `${zoomed.height} ${turned.height}`);
  assert.notEqual(zoomed.target, turned.target);
  assert.equal(await tablet.$$eval("tr.chosen", (all) => all.length), 0); // none of this was a tap
  await tablet.evaluate(() => window.meshmser.view.goTo("best"));
  const [x, y] = await pixelOf(tablet, 4);
  await touch("touchStart", [x, y]);
  await touch("touchEnd");
  await tablet.waitForFunction(() => /^label 4:/.test(document.getElementById("hint").textContent));
  await drawn(tablet);
  await keepShot(tablet, shots, "touch");
  // Nothing hangs over the edge of a tablet held upright.
  assert.ok(await tablet.evaluate(() => document.documentElement.scrollWidth <= innerWidth));

  // Without 3D the tables work.
  const plain = await open(browser, path, [], undefined, () => {
    const get = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...rest) { return kind.startsWith("webgl") ? null : get.call(this, kind, ...rest); };
  });
  assert.match(await plain.$eval("#hint", (hint) => hint.textContent), /draws no 3D/);
  assert.equal(await plain.$$eval("#table tbody tr", (all) => all.length), await plain.evaluate(() => window.meshmser.header.labels.length));
  await plain.click('#table tr[data-row="2"]');
  await plain.click("#tab-Stages");
  assert.ok(await plain.$("#stages details"));

  assert.deepEqual(problems, []);
  console.log("every hand and eye");
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
