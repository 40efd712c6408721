// Verdict, warnings, and what each stage did.
import type { App } from "./app";
import { byId, make } from "./dom";
import { type Output, parameterForPeople, show, unitForPeople } from "./data";

export function makeVerdict(app: App) {
  const s = app.header.summary, units = app.header.units;
  const card = (value: string, name: string, doubt = false) => byId("verdict").append(make("div", { class: doubt ? "card doubt" : "card" }, make("b", {}, value), make("span", {}, name)));
  const figure = (stage: string, name: string) => app.run?.stages.find((t) => t.stage === stage)?.report.find((r) => r.name === name);
  const advice: string[] = [];
  if (s.num_points !== undefined) card(show(s.num_points), s.num_raw_points === s.num_points ? "points" : `points of ${show(s.num_raw_points)}`);
  if (s.spacing !== undefined) card(`${show(s.spacing)} ${units}`, "spacing");
  const noise = figure("curvature", "noise");
  if (noise) card(`${show(noise.value)} ${noise.unit ?? ""}`, "noise measured");
  if (s.num_oriented !== undefined && s.num_points) {
    const share = (100 * s.num_oriented) / s.num_points;
    card(`${share >= 99.995 ? "100" : share.toFixed(2)} %`, "points oriented", share < 99);
    if (share < 99) advice.push("Some points have no normal: they lie alone. Drop outliers in load, or take more neighbours in orient.");
  }
  if (s.num_guessed_components > 0) {
    card(show(s.num_guessed_components), `of ${show(s.num_components)} pieces face a guessed way`, true);
    if (!app.run) advice.push(`Nothing in the scan says which side of ${show(s.num_guessed_points)} points is outside: see orient's viewpoint and flip options if ridges and grooves look exchanged.`);
  }
  if (s.num_triangles !== undefined) card(show(s.num_triangles), "triangles");
  const holes = figure("mesh", "num_border_loops");
  if (holes) card(show(holes.value), "rims and holes");
  if (s.num_regions !== undefined) {
    card(show(s.num_regions), "regions", s.num_regions === 0);
    card(show(s.num_labels), "labels");
    if (s.num_regions === 0) {
      const worst = [...(app.header.filters ?? [])].sort((a, b) => b.removed - a.removed)[0];
      advice.push(worst?.removed ? `No region is left. Most were removed by ${worst.filter} (${show(worst.removed)} of ${show(worst.seen)}): loosen it.` : "No region was found: look at the scalar and its levels.");
    }
  }
  for (const stage of app.run?.stages ?? []) for (const warning of stage.warnings) advice.push(`${stage.name}: ${warning}`);
  const lines = advice.map((text) => make("p", {}, text)), first = 3;
  byId("warnings").append(...lines.slice(0, first));
  if (lines.length > first) byId("warnings").append(make("details", {}, make("summary", {}, `${lines.length - first} more`), ...lines.slice(first)));
}

/** Bars of equal bins; heights by square root, so that few stay visible beside many. */
function bars(counts: number[], name: string): SVGSVGElement {
  const space = "http://www.w3.org/2000/svg", picture = document.createElementNS(space, "svg"), most = Math.max(1, ...counts);
  picture.setAttribute("viewBox", `0 0 ${counts.length} 10`);
  picture.setAttribute("preserveAspectRatio", "none");
  picture.setAttribute("class", "bars");
  picture.setAttribute("role", "img");
  picture.setAttribute("aria-label", `Histogram of ${name}: ${counts.join(", ")}`);
  counts.forEach((count, i) => {
    const bar = document.createElementNS(space, "rect"), height = 10 * Math.sqrt(count / most);
    for (const [key, value] of Object.entries({ x: i + 0.05, y: 10 - height, width: 0.9, height })) bar.setAttribute(key, String(value));
    picture.append(bar);
  });
  return picture;
}

/** What a stage made: each list of numbers with its range, mean and histogram, of the full data. */
function statistics(output: Output): HTMLElement {
  const axes = ["x", "y", "z"];
  const rows = output.fields.flatMap((field) => field.columns.map((c, i) => {
    const name = field.name.replace(/^fields\.0\./, "") + (field.columns.length > 1 ? ` ${axes[i] ?? i}` : "");
    return make("tr", {}, make("th", { class: "text", scope: "row" }, name), make("td", {}, show(field.count)), make("td", {}, show(c.least)), make("td", {}, show(c.mean)),
      make("td", {}, show(c.greatest)), make("td", {}, c.not_finite ? show(c.not_finite) : ""), make("td", {}, c.histogram.length > 1 && bars(c.histogram, name)));
  }));
  return make("details", {}, make("summary", {}, `output: ${output.output}`), make("div", { class: "wide", tabindex: 0, role: "region", "aria-label": `Statistics of ${output.output}` },
    make("table", {}, make("thead", {}, make("tr", {}, ...["", "count", "least", "mean", "greatest", "not finite", "histogram"].map((h) => make("th", { scope: "col" }, h)))), make("tbody", {}, ...rows))));
}

/** The outputs of the page by the stage that most likely made each: the last of its name or kind. */
function outputsOf(app: App): Map<string, Output[]> {
  const made = new Map<string, Output[]>(), stages = app.run?.stages ?? [];
  for (const output of app.header.outputs ?? []) {
    const maker = [...stages].reverse().find((s) => s.name === output.stage || s.stage === output.stage) ?? stages[0];
    const list = made.get(maker?.name ?? "") ?? [];
    list.push(output);
    made.set(maker?.name ?? "", list);
  }
  return made;
}

export function makeStages(app: App): HTMLElement {
  const element = make("div", { id: "stages" });
  const { run, header } = app;
  const outputs = outputsOf(app);
  if (!run) {
    element.append(make("p", {}, "This page was made outside a run: its stages' figures are not known."), ...(outputs.get("") ?? []).map(statistics));
  } else {
    element.append(make("p", { class: "soft" }, `meshmser ${run.meshmser}, ${run.config}, ${run.written}`));
    const rows = run.stages.map((stage) => make("tr", {},
      make("td", { class: "text" }, stage.name),
      make("td", { class: "text" }, stage.outcome + (stage.reason ? `: ${stage.reason}` : "")),
      make("td", {}, stage.wall_seconds.toFixed(2)), make("td", {}, stage.cpu_seconds.toFixed(2)), make("td", {}, (stage.peak_bytes / 2 ** 20).toFixed(0))));
    element.append(make("table", {}, make("thead", {}, make("tr", {}, ...["stage", "outcome", "s", "CPU s", "MiB"].map((t, i) => make("th", { class: i < 2 ? "text" : "", scope: "col" }, t)))), make("tbody", {}, ...rows)));
    for (const stage of run.stages) {
      const figures = make("dl", {}), parameters = make("dl", {});
      for (const item of stage.report) figures.append(make("dt", {}, item.name.replaceAll("_", " ")), make("dd", {}, `${show(item.value)} ${item.unit ? unitForPeople(item.unit, header.units) : ""}`));
      for (const [name, value] of Object.entries(stage.parameters)) {
        const changed = stage.changed?.includes(name) ?? false;
        parameters.append(make("dt", {}, name), make("dd", { class: changed ? "changed" : "" }, parameterForPeople(value, header.units) + (changed ? " (not the default)" : "")));
      }
      element.append(make("details", {}, make("summary", {}, stage.name + (stage.warnings.length ? ` (${stage.warnings.length} warnings)` : "")),
        make("h2", {}, "Figures"), figures, make("h2", {}, "Parameters"), parameters, ...(outputs.get(stage.name) ?? []).map(statistics)));
    }
  }
  const filters = header.filters ?? [];
  if (filters.length) {
    element.append(make("h2", {}, "Filters, in their order"), make("table", {},
      make("thead", {}, make("tr", {}, make("th", { class: "text" }, "filter"), make("th", {}, "seen"), make("th", {}, "removed"))),
      make("tbody", {}, ...filters.map((f) => make("tr", {}, make("td", { class: "text" }, f.filter), make("td", {}, show(f.seen)), make("td", {}, show(f.removed)))))));
  }
  return element;
}
