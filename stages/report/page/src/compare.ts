// Another run beside this one: linked cameras, parameters that differ, how far the labels overlap.
import type { App } from "./app";
import { type Arrays, type Header, partsOfPage, readArrays, type Run, show } from "./data";
import { make } from "./dom";
import { View } from "./view";

/** Parameters by `stage.parameter`. */
function parametersOf(run: Run | null) {
  return new Map((run?.stages ?? []).flatMap((s) => Object.entries(s.parameters).map(([name, value]) => [`${s.name}.${name}`, value] as const)));
}

/** For each of our labels the label there with the most triangles whose middle lies nearest, and the share of ours. */
function overlaps(ours: App, header: Header, arrays: Arrays): { label: number; other: number; share: number }[] {
  const middles = (a: Arrays, h: Header) => {
    const c = a.corners as Int32Array, p = a.positions as Uint16Array, out = new Float64Array(c.length);
    for (let t = 0; t < c.length; t += 3)
      for (let k = 0; k < 3; k++) out[t + k] = h.origin[k] + h.low[k] + ((p[3 * c[t] + k] + p[3 * c[t + 1] + k] + p[3 * c[t + 2] + k]) / 3) * h.step;
    return out;
  };
  const here = middles(ours.arrays, ours.header), there = middles(arrays, header);
  const cell = 2 * (ours.header.cell || 0) || 1.5 * ours.header.summary.spacing || (65535 * ours.header.step) / 500;
  const key = (p: Float64Array, t: number, shift = [0, 0, 0]) => [0, 1, 2].map((k) => Math.floor((p[3 * t + k] - here[k]) / cell) + shift[k]).join(" ");
  const grid = new Map<string, number[]>();
  for (let t = 0; t < there.length / 3; t++) {
    const place = key(there, t), list = grid.get(place);
    if (list) list.push(t);
    else grid.set(place, [t]);
  }
  const counts = (ours.header.labels ?? []).map(() => new Map<number, number>()), totals = counts.map(() => 0);
  const every = Math.max(1, Math.floor(here.length / 3 / 60000)); // so many samples tell the shares to a percent
  for (let t = 0; t < here.length / 3; t += every) {
    const label = ours.arrays.labels[t];
    if (!label) continue;
    let best = -1, least = Infinity;
    for (let i = 0; i < 27; i++)
      for (const u of grid.get(key(here, t, [(i % 3) - 1, (Math.floor(i / 3) % 3) - 1, Math.floor(i / 9) - 1])) ?? []) {
        const d = (there[3 * u] - here[3 * t]) ** 2 + (there[3 * u + 1] - here[3 * t + 1]) ** 2 + (there[3 * u + 2] - here[3 * t + 2]) ** 2;
        if (d < least) { least = d; best = u; }
      }
    totals[label - 1]++;
    const other = best < 0 ? 0 : arrays.labels[best];
    counts[label - 1].set(other, (counts[label - 1].get(other) ?? 0) + 1);
  }
  return counts.map((count, i) => {
    const [other, most] = [...count].sort((a, b) => b[1] - a[1])[0] ?? [0, 0];
    return { label: i + 1, other, share: totals[i] ? most / totals[i] : 0 };
  });
}

export function makeCompare(app: App): HTMLElement {
  const told = make("div", { id: "compared" }), status = make("p", { role: "status" });
  const file = make("input", { type: "file", accept: ".html", id: "other", "aria-label": "The page of another run", change: () => void open() });
  const element = make("div", {}, make("p", {}, "Choose the report.html of another run of the same object: "), file, status, told);
  async function open() {
    const chosen = file.files?.[0];
    if (!chosen) return;
    told.replaceChildren();
    status.textContent = "Reading …";
    try {
      const parts = partsOfPage(await chosen.text());
      if (!parts) { status.textContent = "This file is no page of a run."; return; }
      showOther(chosen.name, parts.header, parts.run, await readArrays(parts.header, parts.blocks));
    } catch (error) {
      status.textContent = `This page cannot be read: ${(error as Error).message}`;
    }
  }
  function showOther(name: string, header: Header, run: Run | null, arrays: Arrays) {
    status.textContent = `Here on the left, ${name} below; both views move together.`;
    const place = make("div", { style: "position:relative;height:300px;border:1px solid var(--line);background:var(--scene)" });
    const canvas = make("canvas", { id: "othercanvas", style: "position:absolute;inset:0;width:100%;height:100%;touch-action:none", tabindex: 0, "aria-label": "3D view of the other run" });
    place.append(canvas);
    told.append(place);
    if (arrays.corners) {
      const view = new View(canvas, header, arrays);
      const colours = header.label_colours;
      if (arrays.labels && colours)
        view.setPaint((t, out, at) => { const c = colours[arrays.labels[t]]; out[at] = c[0]; out[at + 1] = c[1]; out[at + 2] = c[2]; out[at + 3] = 255; });
      view.showPaint();
      const shift = [0, 1, 2].map((k) => app.header.origin[k] + app.view.centre[k] - header.origin[k] - view.centre[k]);
      const follow = (from: View, to: View, sign: number) => {
        to.turn.copy(from.turn); to.height = from.height;
        to.target.set(from.target.x + sign * shift[0], from.target.y + sign * shift[1], from.target.z + sign * shift[2]);
        to.draw();
      };
      app.view.onMove = () => follow(app.view, view, 1);
      view.onMove = () => follow(view, app.view, -1);
      app.view.onMove();
    }
    const ours = parametersOf(app.run), theirs = parametersOf(run);
    const differing = [...new Set([...ours.keys(), ...theirs.keys()])].filter((p) => ours.get(p) !== theirs.get(p));
    const table = (head: string[], rows: (string | undefined)[][]) => make("table", {}, make("thead", {}, make("tr", {}, ...head.map((h) => make("th", { class: "text", scope: "col" }, h)))),
      make("tbody", {}, ...rows.map((row) => make("tr", {}, ...row.map((cell) => make("td", { class: "text" }, cell ?? "–"))))));
    const counts = ["num_points", "spacing", "num_triangles", "num_regions", "num_labels"];
    told.append(make("h2", {}, "Figures"), table(["", "here", "there"], counts.map((c) => [c.replaceAll("_", " "), show(app.header.summary[c]), show(header.summary[c])])),
      make("h2", {}, "Parameters that differ"), differing.length ? table(["", "here", "there"], differing.map((p) => [p, ours.get(p), theirs.get(p)])) : make("p", {}, "None."));
    if (arrays.labels && app.arrays.labels)
      told.append(make("h2", {}, "Labels: where most of each lies there"),
        table(["label here", "label there", "share"], overlaps(app, header, arrays).map((o) => [String(o.label), o.other ? String(o.other) : "background", `${(100 * o.share).toFixed(0)} %`])));
  }
  return element;
}
