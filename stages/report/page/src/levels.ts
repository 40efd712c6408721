// The tree of level sets: components at a level, the chain of nodes above a triangle.
import type { App } from "./app";
import { drawChart } from "./chart";
import { make } from "./dom";
import { show, type TreeHead, unitForPeople } from "./data";
import type { Hit } from "./view";

export type Tree = { head: TreeHead; parent: Int32Array; hi: Int32Array; area: Float32Array; own: Float64Array; size: Int32Array; nodeOfTriangle: Int32Array };

export function readTrees(app: App): Tree[] {
  return (app.header.trees ?? []).map((head) => {
    const p = head.polarity, parent = app.arrays[p + "_parent"], area = app.arrays[p + "_area"];
    const own = Float64Array.from(area), size = new Int32Array(parent.length).fill(1);
    for (let n = 0; n < parent.length; n++) // children stand before their parents
      if (parent[n] >= 0) { own[parent[n]] -= area[n]; size[parent[n]] += size[n]; }
    return { head, parent, hi: app.arrays[p + "_hi"], area, own, size, nodeOfTriangle: app.arrays[p + "_node"] };
  });
}

/** Of each node the component at level k that it lies in; -1: below the level. */
export function componentsAt(tree: Tree, k: number): Int32Array {
  const of = new Int32Array(tree.parent.length);
  for (let n = of.length - 1; n >= 0; n--) {
    const parent = tree.parent[n];
    of[n] = tree.hi[n] < k ? -1 : parent >= 0 && tree.hi[parent] >= k ? of[parent] : n;
  }
  return of;
}

export type Link = { node: number; lo: number; hi: number; area: number; q: number };

/** The nodes that hold a node, from itself to its root, each with q = (Up - Down) / A at its middle level. */
export function chainOf(tree: Tree, node: number, delta: number): Link[] {
  const chain: Link[] = [];
  for (let n = node; n >= 0; n = tree.parent[n]) {
    const parent = tree.parent[n], lo = parent < 0 ? 1 : tree.hi[parent] + 1, hi = tree.hi[n], middle = Math.floor((lo + hi) / 2);
    let up = n;
    while (tree.parent[up] >= 0 && tree.hi[tree.parent[up]] >= middle - delta) up = tree.parent[up];
    let down = 0;
    for (let i = n - tree.size[n] + 1; i <= n; i++) if (tree.hi[i] >= middle + delta) down += tree.own[i];
    chain.push({ node: n, lo, hi, area: tree.area[n], q: Math.max(0, (tree.area[up] - down) / tree.area[n]) });
  }
  return chain;
}

const palette: [number, number, number][] = [
  [0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [213, 94, 0], [240, 228, 66], [120, 94, 240],
];

export function makeLevels(app: App): HTMLElement {
  const trees = readTrees(app), units = app.header.units;
  if (!trees.length) return make("p", {}, "No tree was made.");
  const scalarUnit = unitForPeople(String(app.header.summary.scalar_unit ?? ""), units);
  let tree = trees[0], level = 1, last: Hit | null = null;
  const polarity = make("select", { id: "polarity", "aria-label": "Tree", change: () => { tree = trees[Number(polarity.value)]; setRange(); redraw(); if (last) chart(last); } },
    ...trees.map((t, i) => make("option", { value: i }, t.head.polarity === "upper" ? "upper: S at least h" : "lower: S at most h")));
  const slider = make("input", { type: "range", id: "level", min: 1, "aria-label": "Level", input: () => { level = Number(slider.value); app.setColouring("levels"); redraw(); } });
  const given = app.run?.stages.find((s) => s.stage === "mser")?.parameters.delta;
  const delta = make("input", { type: "number", min: 1, max: 1000, value: Number.parseInt(given ?? "") || 3, id: "delta", "aria-label": "delta in levels", input: () => { if (last) chart(last); } });
  const told = make("p", { role: "status", id: "leveltext" }), charts = make("div", { id: "charts" }), chain = make("div", { id: "chain" });
  const folded = make("p", { class: "soft" });
  const element = make("div", {}, make("div", { class: "tools" }, polarity, make("label", {}, "delta ", delta)), slider, told, folded, charts, chain);

  function setRange() {
    slider.max = String(tree.head.levels.length);
    level = Math.min(Math.max(1, Math.round(tree.head.levels.length * 0.7)), tree.head.levels.length);
    slider.value = String(level);
    folded.textContent = tree.head.least_area > 0 ? `${show(tree.parent.length)} of ${show(tree.head.num_nodes)} nodes are in this page; those below ${show(tree.head.least_area)} ${units}² are counted to their parents.` : "";
  }
  function redraw() {
    const of = componentsAt(tree, level);
    let components = 0, area = 0;
    for (let n = 0; n < of.length; n++) if (of[n] === n) { components++; area += tree.area[n]; }
    told.textContent = `Level ${level} of ${tree.head.levels.length}: ${tree.head.polarity === "upper" ? "S ≥" : "S ≤"} ${show(tree.head.levels[level - 1])} ${scalarUnit}; ${show(components)} components, ${show(area)} ${units}². Click the surface for the chain of nodes there.`;
    const nodes = tree.nodeOfTriangle;
    app.levelPaint = (t) => {
      const component = nodes[t] < 0 ? -1 : of[nodes[t]];
      return component < 0 ? null : palette[Math.imul(component, 2654435761) >>> 29];
    };
    if (app.colouring === "levels") app.repaint();
  }
  function chart(hit: Hit) {
    last = hit;
    charts.replaceChildren();
    chain.replaceChildren();
    const node = tree.nodeOfTriangle[hit.triangle];
    if (node < 0) { chain.append(make("p", {}, "This triangle is in no node: it was excluded, or lies below the first level.")); return; }
    const links = chainOf(tree, node, Math.max(1, Number(delta.value) || 1));
    const regionOf = new Map<number, number>();
    tree.head.node_of_region.forEach((n, i) => { if (n >= 0 && !regionOf.has(n)) regionOf.set(n, i + 1); });
    const levels: number[] = [], areas: number[] = [], qs: (number | null)[] = [], chosen: (number | null)[] = [];
    for (const link of [...links].reverse())
      for (let k = link.lo; k <= link.hi; k++) {
        levels.push(k); areas.push(link.area); qs.push(Number.isFinite(link.q) ? link.q : null);
        chosen.push(regionOf.has(link.node) ? link.q : null);
      }
    const x = { label: "level", values: levels };
    drawChart(charts, x, `area (${units}²)`, [{ label: "area", values: areas, light: "#0b5cad", dark: "#7ab8ff", stepped: true }], true);
    drawChart(charts, x, "q", [{ label: "q", values: qs, light: "#b35900", dark: "#ffb454", stepped: true },
      { label: "selected", values: chosen, light: "#0a7d5a", dark: "#7ad97a", dots: true }]);
    const body = links.map((link, i) => {
      const region = regionOf.get(link.node);
      const before = links[i - 1]?.q ?? Infinity, after = links[i + 1]?.q ?? Infinity;
      const least = link.q <= before && link.q <= after;
      const fate = region ? `region ${region}` : least && i + 1 < links.length ? "least q among its neighbours here; a branch beside it or a filter removed it" : i + 1 === links.length ? "root" : "";
      const line = make("tr", region ? { tabindex: 0, click: () => { app.rowKind = "regions"; app.choose([region], false); } } : {},
        make("td", {}, `${link.lo}–${link.hi}`), make("td", {}, show(link.area)), make("td", {}, show(link.q)), make("td", { class: "text" }, fate));
      if (region) line.classList.add("chosen");
      return [link, line, region || least] as const;
    });
    const told = body.filter(([, , important], i) => important || i < 3 || i === body.length - 1);
    chain.append(make("p", { class: "soft" }, `${links.length} nodes hold this triangle; the telling ones:`),
      make("table", {}, make("thead", {}, make("tr", {}, make("th", {}, "levels"), make("th", {}, `area ${units}²`), make("th", {}, "q"), make("th", { class: "text" }, "fate"))),
        make("tbody", {}, ...told.map(([, line]) => line))));
  }
  app.listeners.clicked.push((hit) => { if (hit) { last = hit; if (element.isConnected) chart(hit); } return false; });
  app.listeners.tab.push((name) => { if (name === "Levels" && last) chart(last); });
  setRange();
  redraw();
  return element;
}
