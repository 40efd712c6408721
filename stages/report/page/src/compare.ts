// Another run beside this one: linked cameras, parameters that differ, how far the labels overlap.
import type { App } from "./app";
import { type Arrays, type Header, parameterForPeople, partsOfPage, readArrays, type Run, show } from "./data";
import { byId, make } from "./dom";
import { segmentsOf } from "./geometry";
import { View } from "./view";

/** Parameters by `stage.parameter`. */
function parametersOf(run: Run | null, units: string) {
  return new Map((run?.stages ?? []).flatMap((s) => Object.entries(s.parameters).map(([name, value]) => [`${s.name}.${name}`, parameterForPeople(value, units)] as const)));
}

type Overlap = { label: number; other: number; share: number; shareThere: number };

/** For each of our labels the one there that most of its area lies on, as share of either's area. */
function overlaps(ours: App, header: Header, arrays: Arrays): Overlap[] {
  const middles = (a: Arrays, h: Header) => {
    const c = a.corners as Int32Array, p = a.positions as Uint16Array, out = new Float64Array(c.length);
    for (let t = 0; t < c.length; t += 3)
      for (let k = 0; k < 3; k++) out[t + k] = h.origin[k] + h.low[k] + ((p[3 * c[t] + k] + p[3 * c[t + 1] + k] + p[3 * c[t + 2] + k]) / 3) * h.step;
    return out;
  };
  const areaOf = (t: number) => {
    const c = ours.arrays.corners as Int32Array, p = ours.arrays.positions as Uint16Array, [i, j, k] = [3 * c[3 * t], 3 * c[3 * t + 1], 3 * c[3 * t + 2]];
    const [ux, uy, uz, vx, vy, vz] = [p[j] - p[i], p[j + 1] - p[i + 1], p[j + 2] - p[i + 2], p[k] - p[i], p[k + 1] - p[i + 1], p[k + 2] - p[i + 2]];
    return (Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx) / 2) * ours.header.step ** 2;
  };
  const here = middles(ours.arrays, ours.header), there = middles(arrays, header);
  const cell = 2 * (ours.header.cell || 0) || 1.5 * ours.header.summary.spacing || (65535 * ours.header.step) / 500;
  const key = (p: Float64Array, t: number, shift = [0, 0, 0]) => [0, 1, 2].map((k) => Math.floor((p[3 * t + k] - here[k]) / cell) + shift[k]).join(" ");
  const grid = new Map<string, number[]>();
  const nearest = (t: number) => {
    let best = -1, least = Infinity;
    for (let i = 0; i < 27; i++)
      for (const u of grid.get(key(here, t, [(i % 3) - 1, (Math.floor(i / 3) % 3) - 1, Math.floor(i / 9) - 1])) ?? []) {
        const d = (there[3 * u] - here[3 * t]) ** 2 + (there[3 * u + 1] - here[3 * t + 1]) ** 2 + (there[3 * u + 2] - here[3 * t + 2]) ** 2;
        if (d < least) { least = d; best = u; }
      }
    return best;
  };
  const same = here.length === there.length && here.every((x, i) => x === there[i]); // the same mesh: triangle for triangle
  if (!same)
    for (let t = 0; t < there.length / 3; t++) {
      const place = key(there, t), list = grid.get(place);
      if (list) list.push(t);
      else grid.set(place, [t]);
    }
  const labels = ours.header.labels ?? [], shared = labels.map(() => new Map<number, number>()), seen = labels.map(() => 0);
  const every = same ? 1 : Math.max(1, Math.floor(here.length / 3 / 60000)); // so many samples tell the shares to a percent
  for (let t = 0; t < here.length / 3; t += every) {
    const label = ours.arrays.labels[t];
    if (!label) continue;
    const there = same ? t : nearest(t), other = there < 0 ? 0 : arrays.labels[there], area = areaOf(t);
    seen[label - 1] += area;
    shared[label - 1].set(other, (shared[label - 1].get(other) ?? 0) + area);
  }
  return labels.map((row, i) => {
    const [other, most] = [...shared[i]].sort((a, b) => b[1] - a[1])[0] ?? [0, 0];
    const share = seen[i] ? most / seen[i] : 0, area = Number(header.labels?.[other - 1]?.area);
    return { label: i + 1, other, share, shareThere: other && area > 0 ? Math.min(1, (share * Number(row.area)) / area) : NaN };
  });
}

/** Takes the run that the page was made with, or that of a chosen file. */
export function makeCompare(app: App, given: { header: Header; run: Run | null; arrays: Arrays; names: string[] } | null): HTMLElement {
  const told = make("div", { id: "compared" }), status = make("p", { role: "status" });
  const file = make("input", { type: "file", accept: ".html", id: "other", "aria-label": "The page of another run", change: () => void open() });
  const element = make("div", {}, make("p", {}, "Another run of the same object, by its report.html: "), file, status, told);
  let stopped = () => {};
  async function open() {
    const chosen = file.files?.[0];
    if (!chosen) return;
    stopped();
    told.replaceChildren();
    status.textContent = "Reading …";
    try {
      const parts = partsOfPage(await chosen.text());
      if (!parts) { status.textContent = "This file is no page of a run."; return; }
      showOther(["this page", chosen.name], parts.header, parts.run, await readArrays(parts.header, parts.blocks));
    } catch (error) {
      status.textContent = `This page cannot be read: ${(error as Error).message}`;
    }
  }

  /** The other run's view right of this one's; both move together, with the same light, colours and borders. */
  function addView(names: string[], header: Header, arrays: Arrays, table: Overlap[]) {
    const canvas = make("canvas", { id: "othercanvas", tabindex: 0, role: "application", "aria-label": "3D view of the other run; moves as the first one does" });
    const place = make("div", { id: "other3d" }, canvas, make("div", { class: "runname" }, names[1]));
    byId("runname").textContent = names[0];
    byId("views").append(place);
    const there = new View(canvas, header, arrays);
    app.other = { header, arrays, view: there };
    const paint = () => {
      const rows = arrays[app.rowKind] as Int32Array | undefined, colours = header.label_colours ?? [[200, 200, 196]];
      const marked = app.rowKind === "labels" ? new Set(app.chosen.map((label) => table[label - 1]?.other)) : new Set<number>();
      const labelOf = new Map((header.labels ?? []).map((row) => [row.region as number, row.label as number]));
      there.setPaint((t, out, at) => {
        const row = rows ? rows[t] : 0, label = app.rowKind === "labels" ? row : labelOf.get(row) ?? 1 + (row % Math.max(1, colours.length - 1));
        const c = row ? colours[label] ?? colours[0] : colours[0];
        out[at] = c[0]; out[at + 1] = c[1]; out[at + 2] = c[2]; out[at + 3] = row && marked.has(row) ? 128 : 255;
      });
      there.setExtra([...marked].filter((label) => label).map((label) => ({ ends: segmentsOf(arrays, "label_borders", header, there.centre, false, label), colour: 0xd55e00, width: 4 })));
    };
    const colour = () => {
      const scalar = app.header.scalars?.[Number(app.colouring)], at = (header.scalars ?? []).findIndex((s) => s.name === scalar?.name && s.stage === scalar?.stage);
      if (app.colouring !== "" && scalar && at >= 0) there.showScalar({ ...header.scalars![at], low: scalar.low, high: scalar.high, colours: scalar.colours }, at);
      else if (app.colouring === "shape" || (app.colouring !== "" && scalar)) there.showPlain();
      else there.showPaint();
      paint();
    };
    const shift = [0, 1, 2].map((k) => app.header.origin[k] + app.view.centre[k] - header.origin[k] - there.centre[k]);
    const follow = (from: View, to: View, sign: number) => {
      to.turn.copy(from.turn); to.height = from.height;
      to.target.set(from.target.x + sign * shift[0], from.target.y + sign * shift[1], from.target.z + sign * shift[2]);
      to.drawCoarseFirst();
      to.draw();
    };
    app.view.onMove = () => follow(app.view, there, 1);
    there.onMove = () => follow(there, app.view, -1);
    app.view.onLook = () => { there.lightAngle = [...app.view.lightAngle]; for (const layer of there.layerNames) there.setLayer(layer, app.view.isVisible(layer)); };
    app.listeners.coloured.push(colour);
    app.listeners.chosen.push(paint);
    stopped = () => {
      app.view.onMove = app.view.onLook = () => {};
      app.listeners.coloured = app.listeners.coloured.filter((l) => l !== colour);
      app.listeners.chosen = app.listeners.chosen.filter((l) => l !== paint);
      there.renderer?.dispose();
      place.remove();
      app.other = undefined;
      byId("runname").textContent = "";
    };
    colour();
    app.view.onLook();
    app.view.goTo("best");
  }

  function showOther(names: string[], header: Header, run: Run | null, arrays: Arrays) {
    status.textContent = `Left ${names[0]}, right ${names[1]}; both views move together.`;
    const table = arrays.labels && app.arrays.labels ? overlaps(app, header, arrays) : [];
    if (arrays.corners) addView(names, header, arrays, table);
    const ours = parametersOf(app.run, app.header.units), theirs = parametersOf(run, header.units);
    const differing = [...new Set([...ours.keys(), ...theirs.keys()])].filter((p) => ours.get(p) !== theirs.get(p));
    const tableOf = (id: string, head: string[], rows: (string | undefined)[][], marked: (row: number) => boolean = () => false, press?: (row: number) => void) =>
      make("table", { id }, make("thead", {}, make("tr", {}, ...head.map((h) => make("th", { class: "text", scope: "col" }, h)))),
        make("tbody", {}, ...rows.map((row, i) => make("tr", press ? { tabindex: 0, click: () => press(i), keydown: (event: KeyboardEvent) => { if (event.key === "Enter") press(i); } } : {},
          ...row.map((cell) => make("td", { class: marked(i) ? "text changed" : "text" }, cell ?? "–"))))));
    const figures = ["num_points", "spacing", "num_triangles", "num_regions", "num_labels"].map((c) => [c.replaceAll("_", " "), show(app.header.summary[c]), show(header.summary[c])]);
    told.append(make("h2", {}, "Figures"), tableOf("figures", ["", ...names], figures, (i) => figures[i][1] !== figures[i][2]),
      make("h2", {}, "Parameters that differ"), differing.length ? tableOf("differing", ["", ...names], differing.map((p) => [p, ours.get(p), theirs.get(p)]), () => true) : make("p", { id: "nodiffering" }, "None."));
    if (!table.length) return;
    const percent = (share: number) => (Number.isNaN(share) ? "–" : `${(100 * share).toFixed(0)} %`);
    told.append(make("h2", {}, "Overlaps"), make("p", { class: "soft" }, "Each label of the left run, the one of the right run that most of it lies on, and the common area as a share of either. A row marks both."),
      tableOf("overlaps", ["left", "right", "of left", "of right"], table.map((o) => [String(o.label), o.other ? String(o.other) : "background", percent(o.share), percent(o.shareThere)]), () => false,
        (i) => { app.setRows("labels"); app.choose([table[i].label], false); }));
  }
  if (given) showOther(given.names, given.header, given.run, given.arrays);
  return element;
}
