// Regions or labels as a table, linked with the view.
import { type App, coloursOfRows, rowOfTriangle, type RowKind } from "./app";
import { download, make } from "./dom";
import { type Row, show, unitForPeople } from "./data";

const kMostRows = 2000;
const valueOf = (cell: unknown) => (cell === "inf" ? Infinity : cell === "-inf" ? -Infinity : cell === "" ? NaN : Number(cell));

export function makeTable(app: App): HTMLElement {
  const { header } = app, units = header.units;
  let sortKey = "label", ascending = true, filter = "";
  const scalarUnit = unitForPeople(String(header.summary.scalar_unit ?? ""), units);
  const unitOf: Record<string, string> = {
    area: units + "²", border_length: units, hole_length: units, value: scalarUnit, persistence: scalarUnit,
    contrast: scalarUnit, scalar_mean: scalarUnit, scalar_min: scalarUnit, scalar_max: scalarUnit, scalar_deviation: scalarUnit,
  };
  const body = make("tbody"), head = make("thead"), count = make("span", { class: "soft", role: "status" });
  const table = make("table", { id: "table" }, head, body);
  const kind = make("select", { "aria-label": "Rows", id: "rows", change: () => app.setRows(kind.value as RowKind) }, make("option", { value: "regions" }, "regions"), make("option", { value: "labels" }, "labels"));
  const chooser = make("div", { class: "chooser" });
  const columnBox = make("details", { id: "columns" }, make("summary", {}, "columns"), chooser);
  const search = make("input", { type: "search", id: "filter", placeholder: "area > 4, upper", "aria-label": "Filter rows",
    input: () => { filter = search.value; fill(); } });
  const element = make("div", {},
    make("div", { class: "tools" }, kind, search,
      make("button", { id: "hide", click: () => { for (const r of app.chosen) app.hidden.has(r) ? app.hidden.delete(r) : app.hidden.add(r); app.repaint(); fill(); } }, "hide / show"),
      make("button", { id: "isolate", click: () => { app.hidden = new Set(app.chosen.length ? rows().map((r) => r.label as number).filter((r) => !app.chosen.includes(r)) : []); if (app.chosen.length) app.hidden.add(0); app.repaint(); fill(); } }, "isolate"),
      make("button", { click: () => { app.hidden.clear(); app.repaint(); fill(); } }, "show all"),
      make("button", { id: "csv", click: () => download(app.rowKind + ".csv", csv(), "text/csv") }, "CSV")),
    columnBox, count, make("div", { id: "comparison" }), make("div", { class: "wide", tabindex: 0, role: "region", "aria-label": "Rows" }, table));

  const rows = () => ((app.rowKind === "labels" ? header.labels : header.regions) ?? []) as Row[];
  const first = ["label", "polarity", "area", "stability", "persistence", "contrast", "border_length", "hole_length"];
  const columns = () => {
    const names = Object.keys(rows()[0] ?? {});
    return app.rowKind === "labels" ? names : [...first.filter((n) => names.includes(n)), ...names.filter((n) => !first.includes(n))];
  };
  // Of many columns the first are shown until others are asked for; the CSV holds all.
  const kept: Record<RowKind, Set<string> | null> = { labels: null, regions: null };
  const visible = () => {
    const chosen = kept[app.rowKind] ??= new Set(columns().slice(0, first.length));
    return columns().filter((name) => chosen.has(name));
  };
  function fillChooser() {
    visible();
    chooser.replaceChildren(...columns().map((name) => {
      const box = make("input", { type: "checkbox", "data-column": name, change: () => { const set = kept[app.rowKind]!; box.checked ? set.add(name) : set.delete(name); fill(); } });
      box.checked = kept[app.rowKind]!.has(name);
      return make("label", {}, box, name.replaceAll("_", " "));
    }));
  }
  const shown = () => {
    const parts = filter.toLowerCase().split(",").map((part) => part.trim()).filter(Boolean);
    return rows().filter((row) => parts.every((part) => {
      const condition = /^(\w+)\s*(<=|>=|<|>|=)\s*(-?[\d.e+-]+|inf)$/.exec(part);
      if (condition && condition[1] in row) {
        const value = valueOf(row[condition[1]]), limit = valueOf(condition[3]);
        return { "<": value < limit, ">": value > limit, "<=": value <= limit, ">=": value >= limit, "=": value === limit }[condition[2]];
      }
      return part.split(/\s+/).every((word) => /^\d+$/.test(word) ? String(row.label) === word : Object.values(row).some((v) => String(v).toLowerCase().includes(word)));
    })).sort((a, b) => {
      const x = valueOf(a[sortKey]), y = valueOf(b[sortKey]);
      if (Number.isNaN(x) !== Number.isNaN(y)) return Number.isNaN(x) ? 1 : -1; // words and what is unknown stand last
      const order = Number.isNaN(x) ? String(a[sortKey]).localeCompare(String(b[sortKey])) : x < y ? -1 : x > y ? 1 : 0;
      return ascending ? order : -order;
    });
  };
  const csv = () => [columns().join(","), ...shown().map((row) => columns().map((c) => String(row[c] ?? "")).join(","))].join("\n") + "\n";
  const press = (row: number, second: boolean) => {
    app.choose(second && app.chosen.length === 1 && app.chosen[0] !== row ? [app.chosen[0], row] : [row], false);
    if (!second) centre(row);
  };
  const centre = (row: number) => {
    const of = rowOfTriangle(app), mesh = app.view.mesh;
    if (!of || !mesh) return;
    const low = [1e30, 1e30, 1e30], high = [-1e30, -1e30, -1e30];
    for (let t = 0; t < of.length; t++)
      if (of[t] === row)
        for (let k = 0; k < 3; k++) {
          const value = mesh.positions[3 * mesh.ownVertex[t] + k];
          low[k] = Math.min(low[k], value); high[k] = Math.max(high[k], value);
        }
    if (low[0] > high[0]) return;
    app.view.centreOn((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2, 3 * Math.hypot(...[0, 1, 2].map((k) => high[k] - low[k])));
  };

  function fill() {
    const names = visible(), colours = coloursOfRows(app), list = shown();
    head.replaceChildren(make("tr", {}, ...names.map((name) => make("th", {
      scope: "col", tabindex: 0, "aria-sort": name === sortKey ? (ascending ? "ascending" : "descending") : "none",
      title: name + (unitOf[name] ? ` in ${unitOf[name]}` : ""),
      click: () => sortBy(name), keydown: (event: KeyboardEvent) => { if (event.key === "Enter") sortBy(name); },
    }, name.replaceAll("_", " ") + (name === sortKey ? (ascending ? " ▲" : " ▼") : "")))));
    count.textContent = `${list.length} of ${rows().length} ${app.rowKind}` + (list.length > kMostRows ? `, the first ${kMostRows} listed` : "") + (rows().length ? "; with Shift a second one to compare" : "");
    body.replaceChildren(...list.slice(0, kMostRows).map((row) => {
      const number = row.label as number, swatch = make("span", { class: "swatch" });
      const c = colours[number];
      if (c) swatch.style.background = `rgb(${c})`;
      const line = make("tr", { tabindex: 0, "data-row": number,
        click: (event: MouseEvent) => press(number, event.shiftKey),
        keydown: (event: KeyboardEvent) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); press(number, event.shiftKey); } } },
        ...names.map((name, i) => make("td", {}, i === 0 ? swatch : null, show(row[name]))));
      if (app.hidden.has(number)) line.classList.add("hidden-row");
      return line;
    }));
    mark(false);
  }
  function sortBy(name: string) { ascending = name === sortKey ? !ascending : name === "label"; sortKey = name; fill(); }
  function mark(scroll: boolean) {
    for (const line of body.children) {
      const chosen = app.chosen.includes(Number((line as HTMLElement).dataset.row));
      line.classList.toggle("chosen", chosen);
      if (chosen) line.setAttribute("aria-current", "true"); else line.removeAttribute("aria-current");
      if (chosen && scroll) line.scrollIntoView({ block: "nearest" });
    }
    const place = element.querySelector("#comparison")!;
    place.replaceChildren();
    if (app.chosen.length !== 2) return;
    const [a, b] = app.chosen.map((n) => rows().find((row) => row.label === n)!);
    place.append(make("table", {}, make("tbody", {}, ...columns().map((name) => make("tr", {}, make("th", { class: "text", scope: "row" }, name.replaceAll("_", " ")),
      make("td", {}, show(a[name])), make("td", {}, show(b[name])),
      make("td", { class: "soft" }, typeof a[name] === "number" && typeof b[name] === "number" && name !== "label" ? show((b[name] as number) - (a[name] as number)) : ""))))));
  }
  app.listeners.chosen.push(mark);
  app.listeners.rows.push(() => { kind.value = app.rowKind; sortKey = "label"; ascending = true; fillChooser(); fill(); });
  kind.value = app.rowKind;
  fillChooser();
  fill();
  return element;
}
