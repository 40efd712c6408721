// What the parts of the page share.
import type { Arrays, Header, Run } from "./data";
import type { Hit, View } from "./view";

export type RowKind = "labels" | "regions";
export type App = {
  header: Header;
  run: Run | null;
  arrays: Arrays;
  view: View;
  rowKind: RowKind;
  chosen: number[]; // rows chosen, by number, at most two
  hidden: Set<number>; // rows not drawn
  colouring: string; // labels, regions, levels, shape, or a scalar's place in the header
  levelPaint: ((triangle: number) => [number, number, number] | null) | null;
  listeners: { chosen: ((byPick: boolean) => void)[]; clicked: ((hit: Hit | null) => boolean)[]; tab: ((name: string) => void)[]; coloured: (() => void)[]; rows: (() => void)[] };
  repaint: () => void;
  choose: (rows: number[], byPick: boolean) => void;
  setColouring: (name: string) => void;
  setRows: (kind: RowKind) => void;
  hint: (text: string) => void;
  other?: { header: Header; arrays: Arrays; view: View }; // the run beside this one
};

/** Region colours: those of the label that came of it, so that both agree. */
export function coloursOfRows(app: App): [number, number, number][] {
  const labels = app.header.label_colours ?? [[200, 200, 196]];
  if (app.rowKind === "labels") return labels;
  const colours: [number, number, number][] = Array((app.header.regions?.length ?? 0) + 1).fill(null);
  colours[0] = labels[0];
  for (const row of app.header.labels ?? []) colours[row.region as number] ??= labels[row.label as number];
  return colours.map((c, i) => c ?? labels[1 + (i % Math.max(1, labels.length - 1))] ?? labels[0]);
}

export const rowOfTriangle = (app: App) => app.arrays[app.rowKind] as Int32Array | undefined;
