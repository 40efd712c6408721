import "./globals";
import { type App, coloursOfRows, rowOfTriangle } from "./app";
import { makeCompare } from "./compare";
import { drawLegend, makeControls, makePrints } from "./controls";
import { readArrays, readHeader, readOther, readRun, show, takeBlocks } from "./data";
import { byId, make } from "./dom";
import { segmentsOf } from "./geometry";
import { makeLevels } from "./levels";
import { makeSection } from "./section";
import { makeStages, makeVerdict } from "./stages";
import { makeTable } from "./table";
import { View } from "./view";

function setTheme(dark: boolean) {
  document.documentElement.classList.toggle("dark", dark);
}

async function start() {
  setTheme(matchMedia("(prefers-color-scheme: dark)").matches);
  byId("theme").addEventListener("click", () => setTheme(!document.documentElement.classList.contains("dark")));
  const header = readHeader(), run = readRun();
  if (!header) { byId("hint").textContent = "This page holds no data."; return; }
  const scans = (header.summary.scans ?? []) as string[];
  const title = header.title || scans.slice(0, 3).join(", ") + (scans.length > 3 ? ` and ${scans.length - 3} more` : "") || "meshmser";
  document.title = byId("title").textContent = title;
  byId("subtitle").textContent = run ? `${run.config} · ${run.written}` : "";
  const blocks = takeBlocks(), other = readOther();
  const arrays = await readArrays(header, blocks);
  const view = new View(byId("canvas") as HTMLCanvasElement, header, arrays);
  const app: App = {
    header, run, arrays, view, rowKind: "regions", chosen: [], hidden: new Set(), colouring: "", levelPaint: null,
    listeners: { chosen: [], clicked: [], tab: [], coloured: [], rows: [] },
    repaint() {
      const rows = rowOfTriangle(app), colours = coloursOfRows(app), chosen = new Set(app.chosen);
      const levels = app.colouring === "levels" ? app.levelPaint : null;
      view.setPaint((t, out, at) => {
        const row = rows ? rows[t] : 0;
        const c = levels ? levels(t) ?? colours[0] : colours[row];
        out[at] = c[0]; out[at + 1] = c[1]; out[at + 2] = c[2];
        out[at + 3] = app.hidden.has(row) ? 0 : chosen.has(row) && app.colouring !== "levels" ? 128 : 255;
      });
    },
    choose(numbers, byPick) {
      app.chosen = numbers;
      app.repaint();
      const name = app.rowKind === "labels" ? "label_borders" : "region_borders";
      view.setExtra(numbers.map((n) => ({ ends: segmentsOf(arrays, name, header, view.centre, false, n), colour: 0xd55e00, width: 4 })));
      const row = app.rowKind === "regions" ? header.regions?.[numbers[0] - 1] : header.labels?.[numbers[0] - 1];
      app.hint(row ? `${app.rowKind === "regions" ? "region" : "label"} ${numbers[0]}: ${show(row.area)} ${header.units}²` : "");
      for (const listener of app.listeners.chosen) listener(byPick);
    },
    setColouring(name) {
      app.colouring = name;
      const select = document.getElementById("colouring") as HTMLSelectElement | null;
      if (select) select.value = name;
      const number = Number(name), scalar = name === "" ? undefined : header.scalars?.[number];
      if (scalar) view.showScalar(scalar, number);
      else if (name === "shape") view.showPlain();
      else {
        if (name === "labels" || name === "regions") app.setRows(name);
        view.showPaint();
      }
      app.repaint();
      drawLegend(app);
      for (const listener of app.listeners.coloured) listener();
    },
    setRows(kind) {
      if (app.rowKind === kind) return;
      app.rowKind = kind;
      app.hidden.clear();
      app.choose([], false);
      if (app.colouring === "labels" || app.colouring === "regions") app.setColouring(kind);
      for (const listener of app.listeners.rows) listener();
    },
    hint: (text) => { byId("hint").textContent = text; },
  };
  app.hint("");
  makeControls(app);
  makeVerdict(app);
  makeTabs(app, other && { ...other, arrays: await readArrays(other.header, blocks) });
  app.setColouring(arrays.labels ? "labels" : header.scalars?.length ? "0" : "shape");
  view.onClick = (hit) => {
    for (const listener of app.listeners.clicked) if (listener(hit)) return;
    const row = hit && rowOfTriangle(app)?.[hit.triangle];
    app.choose(row ? [row] : [], true);
    if (hit && !row && arrays.labels) app.hint("background: in no region");
  };
  const notes: string[] = [];
  if (header.cell) notes.push(`Drawn simplified: ${show(view.mesh!.numTriangles)} of ${show(header.summary.num_triangles)} triangles, vertices within ${show(header.cell)} ${header.units} joined. Every figure is of the full mesh.`);
  if ((header.every_point ?? 1) > 1) notes.push(`Of the points one in ${header.every_point} is drawn.`);
  if (header.left_out?.length) notes.push(`To keep the page small it lacks: ${header.left_out.join(", ")}.`);
  byId("note").textContent = notes.join(" ");
  if (view.problem) app.hint(`This browser draws no 3D (${view.problem}); the tables work.`);
  window.addEventListener("beforeprint", () => makePrints(app));
  document.documentElement.dataset.ready = "yes";
  window.meshmser = app;
}

function makeTabs(app: App, other: Parameters<typeof makeCompare>[1]) {
  const panels: [string, () => HTMLElement][] = [["Stages", () => makeStages(app)]];
  if (app.arrays.labels) panels.push(["Compare", () => makeCompare(app, other)]);
  if (app.view.mesh) {
    panels.unshift(["Section", () => makeSection(app)]);
    if (app.header.trees?.length) panels.unshift(["Levels", () => makeLevels(app)]);
    if (app.arrays.labels) panels.unshift(["Regions", () => makeTable(app)]);
  }
  const made = panels.map(([name, build]) => ({ name, element: build(), button: make("button", { role: "tab", id: "tab-" + name, "aria-controls": "panels", click: () => open(name), keydown: step }, name) }));
  function step(event: KeyboardEvent) { // arrows go from tab to tab
    const move = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!move) return;
    event.preventDefault();
    const at = made.findIndex((tab) => tab.button === event.currentTarget), next = made[(at + move + made.length) % made.length];
    open(next.name);
    next.button.focus();
  }
  const open = (name: string) => {
    for (const tab of made) {
      tab.button.setAttribute("aria-selected", String(tab.name === name));
      tab.button.tabIndex = tab.name === name ? 0 : -1;
    }
    byId("panels").setAttribute("aria-labelledby", "tab-" + name);
    byId("panels").replaceChildren(made.find((tab) => tab.name === name)!.element);
    for (const listener of app.listeners.tab) listener(name);
  };
  byId("tabs").append(...made.map((tab) => tab.button));
  open(other ? "Compare" : made[0].name);
}

document.addEventListener("DOMContentLoaded", () => void start());
