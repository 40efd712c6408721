// What the program put into the page.
declare const WORKER_TEXT: string;

export type Block = { name: string; coding: string; count: number; stride: number; offset: number; size: number };
export type Figure = number | "nan" | "inf" | "-inf";
export type Scalar = {
  name: string; stage: string; unit: string; noise: Figure; from: number; to: number; low: number; high: number;
  colours: [number, number, number][];
};
export type Row = Record<string, unknown>;
export type TreeHead = { polarity: string; num_nodes: number; least_area: number; num_levels: number; levels?: Figure[]; node_of_region: number[]; fates?: string[] };
export type Column = { least: Figure; greatest: Figure; mean: Figure; not_finite: number; histogram: number[] };
export type Output = { stage: string; output: string; fields: { name: string; count: number; columns: Column[] }[] };
export type Header = {
  title: string; units: string; origin: number[]; low: number[]; step: number; every_point?: number; cell?: number;
  summary: Record<string, any>; scalars?: Scalar[]; label_colours?: [number, number, number][];
  labels?: Row[]; regions?: Row[]; filters?: { filter: string; seen: number; removed: number }[];
  trees?: TreeHead[]; outputs?: Output[]; left_out?: string[]; blocks: Block[];
} & Record<string, unknown>;
export type RunStage = {
  name: string; stage: string; outcome: string; reason?: string; parameters: Record<string, string>;
  changed?: string[]; wall_seconds: number; cpu_seconds: number; peak_bytes: number;
  report: { name: string; value: Figure | string; unit?: string }[]; warnings: string[]; files: string[];
};
export type Run = { meshmser: string; written: string; config: string; stages: RunStage[] };
// By name; each block's coding says which kind of array it is.
export type Arrays = Record<string, any>;

function json<T>(id: string): T | null {
  const element = document.getElementById(id);
  return element?.textContent ? (JSON.parse(element.textContent) as T) : null;
}

export const readHeader = () => json<Header>("header");
export const readRun = () => json<Run>("run");
/** The second run of a page that shows two, with what both are called. */
export function readOther(): { header: Header; run: Run | null; names: string[] } | null {
  const header = json<Header>("other-header");
  return header && { header, run: json<Run>("other-run"), names: json<string[]>("names") ?? ["", ""] };
}

/** The arrays by name; decoded in a worker made of text, since a page from disk may not load another file. */
export function readArrays(header: Header, text: string): Promise<Arrays> {
  return new Promise((resolve, reject) => {
    const worker = new Worker(URL.createObjectURL(new Blob([WORKER_TEXT], { type: "text/javascript" })));
    worker.onmessage = (message) => { resolve(message.data as Arrays); worker.terminate(); };
    worker.onerror = (error) => reject(new Error(error.message));
    worker.postMessage({ text, blocks: header.blocks });
  });
}

/** The packed arrays of this page; taken out of it, since the text is large and not needed again. */
export function takeBlocks(): string {
  const element = document.getElementById("blocks");
  element?.remove();
  return element?.textContent ?? "";
}

/** The parts of another page: its data elements are found as text, and none of it becomes part of this page. */
export function partsOfPage(html: string): { header: Header; run: Run | null; blocks: string } | null {
  const part = (id: string) => {
    const mark = ` id="${id}">`, from = html.lastIndexOf(`<script type="${id === "blocks" ? "text/plain" : "application/json"}"${mark}`);
    if (from < 0) return null;
    const begin = html.indexOf(">", from) + 1;
    return html.slice(begin, html.indexOf("</script>", begin));
  };
  const header = part("header"), blocks = part("blocks"), run = part("run");
  return header && blocks !== null ? { header: JSON.parse(header) as Header, run: run ? (JSON.parse(run) as Run) : null, blocks } : null;
}

/** `1/unit` with millimetres is `1/mm`. */
export function unitForPeople(unit: string, units: string): string {
  return units === "unit" ? unit : unit.replace("unit", units);
}

/** A parameter's value, where it is a number of units of the coordinates, with their name. */
export const parameterForPeople = (value: string, units: string) => (/^[-+\d.e]+ unit2?$/.test(value) ? unitForPeople(value, units) : value);

export function show(value: unknown): string {
  if (typeof value !== "number") return value === "inf" ? "∞" : value === "-inf" ? "−∞" : String(value ?? "");
  if (Number.isInteger(value)) return value.toLocaleString("en-GB").replaceAll(",", "\u2009");
  return String(Number(value.toPrecision(4))).replace("-", "−");
}
