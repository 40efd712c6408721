// The tree of level sets: components at a level, the chain of nodes above a triangle.
import type { App } from "./app";
import { drawChart } from "./chart";
import { make } from "./dom";
import { parameterForPeople, show, type TreeHead, unitForPeople } from "./data";
import type { Hit } from "./view";

export type Tree = {
  fate?: Uint8Array; filter?: Uint8Array; rival?: Int32Array; head: TreeHead; parent: Int32Array; hi: Int32Array; area: Float32Array; own: Float64Array; size: Int32Array; nodeOfTriangle: Int32Array };

export function readTrees(app: App): Tree[] {
  return (app.header.trees ?? []).map((head) => {
    const p = head.polarity, parent = app.arrays[p + "_parent"], area = app.arrays[p + "_area"];
    const own = Float64Array.from(area), size = new Int32Array(parent.length).fill(1);
    for (let n = 0; n < parent.length; n++) // children stand before their parents
      if (parent[n] >= 0) { own[parent[n]] -= area[n]; size[parent[n]] += size[n]; }
    return { fate: app.arrays[p + "_fate"], filter: app.arrays[p + "_filter"], rival: app.arrays[p + "_rival"], head, parent, hi: app.arrays[p + "_hi"], area, own, size, nodeOfTriangle: app.arrays[p + "_node"] };
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

/** A node with q = (Up - Down) / A at its middle level. */
export function linkOf(tree: Tree, n: number, delta: number): Link {
  const parent = tree.parent[n], lo = parent < 0 ? 1 : tree.hi[parent] + 1, hi = tree.hi[n], middle = Math.floor((lo + hi) / 2);
  let up = n;
  while (tree.parent[up] >= 0 && tree.hi[tree.parent[up]] >= middle - delta) up = tree.parent[up];
  let down = 0;
  for (let i = n - tree.size[n] + 1; i <= n; i++) if (tree.hi[i] >= middle + delta) down += tree.own[i];
  return { node: n, lo, hi, area: tree.area[n], q: Math.max(0, (tree.area[up] - down) / tree.area[n]) };
}

/** The nodes that hold a node, from itself to its root. */
export function chainOf(tree: Tree, node: number, delta: number): Link[] {
  const chain: Link[] = [];
  for (let n = node; n >= 0; n = tree.parent[n]) chain.push(linkOf(tree, n, delta));
  return chain;
}

/** What decided that a node is a region or none: as the program wrote it down, in words. */
export function fateOf(app: App, tree: Tree, link: Link, delta: number): string {
  const kind = tree.fate ? tree.head.fates?.[tree.fate[link.node]] : undefined;
  if (!kind) return link.lo === 1 ? "a root: it has no level border" : "";
  const units = app.header.units, parameters = app.run?.stages.find((s) => s.stage === "mser")?.parameters ?? {};
  const of = tree.rival![link.node];
  const rival = (() => {
    if (of === -1) return "another node";
    const node = of < 0 ? -2 - of : of, { lo, hi, area, q } = linkOf(tree, node, delta);
    const levels = lo === hi ? `level ${lo}` : `levels ${lo}–${hi}`;
    return of < 0 ? `a smaller node within that of ${levels}` : `the node of ${levels} (${show(area)} ${units}², q ${show(q)})`;
  })();
  const filter = app.header.filters?.[tree.filter![link.node] - 1]?.filter ?? "a filter";
  const asked = (name: string) => (parameters[name] === undefined ? name : `${name} ${parameterForPeople(parameters[name], units)}`);
  const words: Record<string, string> = {
    root: "a root: it has no level border",
    less_stable: `not selected: ${rival} beside it is more stable`,
    smaller_of_plateau: `not selected: ${rival} is larger, of the same q`,
    no_maximum: `not selected: no maximum in it is significant (${asked("min_persistence")}, ${asked("min_area")})`,
    several_maxima: "not selected: it holds several significant maxima",
    single_maximum: "not selected: there is no other significant maximum to be told from",
    smaller_of_maximum: `not selected: ${rival} is larger, with the same significant maximum`,
    not_on_branch: `not selected: ${rival}, on the way to the same maximum, is more stable`,
    short_line: `not selected: its line is shorter than ${asked("min_length")}`,
    other_level: `not selected: it does not belong to ${asked("level")}`,
    false_alarm: `not selected: chance alone gives such lines (${asked("max_false_alarms")})`,
    less_meaningful: `not selected: ${rival}, in the same chain, has fewer false alarms`,
    filtered: `removed by ${asked(filter)}` + (of === -1 ? "" : `: kept was ${rival}`),
  };
  return words[kind] ?? kind.replaceAll("_", " ");
}

const palette: [number, number, number][] = [
  [0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [213, 94, 0], [240, 228, 66], [120, 94, 240],
];

const treeNames: Record<string, string> = {
  upper: "upper: S at least h", lower: "lower: S at most h", shapes: "shapes: high and low, holes filled",
};

export function makeLevels(app: App): HTMLElement {
  const trees = readTrees(app), units = app.header.units;
  if (!trees.length) return make("p", {}, "No tree was made.");
  const scalarUnit = unitForPeople(String(app.header.summary.scalar_unit ?? ""), units);
  let tree = trees[0], level = 1, last: Hit | null = null;
  const polarity = make("select", { id: "polarity", "aria-label": "Tree", change: () => { tree = trees[Number(polarity.value)]; setRange(); redraw(); if (last) chart(last); } },
    ...trees.map((t, i) => make("option", { value: i }, treeNames[t.head.polarity] ?? t.head.polarity)));
  const slider = make("input", { type: "range", id: "level", min: 1, "aria-label": "Level", input: () => { level = Number(slider.value); app.setColouring("levels"); redraw(); } });
  const given = app.run?.stages.find((s) => s.stage === "mser")?.parameters.delta;
  const delta = make("input", { type: "number", min: 1, max: 1000, value: Number.parseInt(given ?? "") || 3, id: "delta", "aria-label": "delta in levels", input: () => { if (last) chart(last); } });
  const told = make("p", { role: "status", id: "leveltext" }), charts = make("div", { id: "charts" }), chain = make("div", { id: "chain" });
  const folded = make("p", { class: "soft" });
  const element = make("div", {}, make("div", { class: "tools" }, polarity, make("label", {}, "delta ", delta)), slider, told, folded, charts, chain);

  function setRange() {
    const { num_levels, levels } = tree.head;
    slider.max = String(num_levels);
    // Many lines lie about few places: the first shows all shapes.
    level = levels ? Math.min(Math.max(1, Math.round(num_levels * 0.7)), num_levels) : Math.min(2, num_levels);
    slider.value = String(level);
    folded.textContent = tree.head.least_area > 0 ? `${show(tree.parent.length)} of ${show(tree.head.num_nodes)} nodes are in this page; those below ${show(tree.head.least_area)} ${units}² are counted to their parents.` : "";
  }
  function redraw() {
    const of = componentsAt(tree, level);
    let components = 0, area = 0;
    for (let n = 0; n < of.length; n++) if (of[n] === n) { components++; area += tree.area[n]; }
    const { levels, num_levels, polarity } = tree.head;
    const meaning = levels ? `${polarity === "upper" ? "S ≥" : "S ≤"} ${show(levels[level - 1])} ${scalarUnit}` : `within ${level - 1} level lines or more`;
    told.textContent = `Level ${level} of ${num_levels}: ${meaning}; ${show(components)} components, ${show(area)} ${units}². Click the surface for the chain of nodes there.`;
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
    const span = Math.max(1, Number(delta.value) || 1);
    const lines = links.map((link, i) => {
      const region = regionOf.get(link.node);
      const fate = region ? `region ${region}` : fateOf(app, tree, link, span);
      const open = () => { app.setRows("regions"); app.choose([region!], false); };
      const line = make("tr", region ? { tabindex: 0, click: open, keydown: (event: KeyboardEvent) => { if (event.key === "Enter") open(); } } : {},
        make("td", {}, link.lo === link.hi ? String(link.lo) : `${link.lo}–${link.hi}`), make("td", {}, show(link.area)), make("td", {}, show(link.q)), make("td", { class: "text" }, fate));
      if (region) line.classList.add("chosen");
      return { line, telling: i < 3 || i === links.length - 1 || !fate.includes("beside it") };
    });
    const body = make("tbody"), all = make("button", { id: "allnodes", click: () => { body.replaceChildren(...lines.map((l) => l.line)); all.remove(); } }, `all ${links.length}`);
    const telling = lines.length > 40 ? lines.filter((l) => l.telling) : lines;
    body.append(...telling.map((l) => l.line));
    chain.append(make("p", { class: "soft" }, `${links.length} nodes hold this triangle, from the smallest to the root${telling.length < lines.length ? "; those that more was decided about than that a neighbour is more stable: " : "."}`, telling.length < lines.length && all),
      make("table", {}, make("thead", {}, make("tr", {}, ...["levels", `area ${units}²`, "q"].map((h) => make("th", { scope: "col" }, h)), make("th", { class: "text", scope: "col" }, "fate"))), body));
  }
  app.listeners.clicked.push((hit) => { if (hit) { last = hit; if (element.isConnected) chart(hit); } return false; });
  app.listeners.tab.push((name) => { if (name === "Levels" && last) chart(last); });
  setRange();
  redraw();
  return element;
}
