// Border lines as drawings to scale, projected on a plane: SVG and DXF.
import * as THREE from "three";
import type { App } from "./app";
import { positionsOf } from "./geometry";

export type Line = { owner: number; hole: boolean; closed: boolean; points: [number, number][] };

/** The eigenvector of least eigenvalue of a symmetric 3 x 3 matrix, by cyclic Jacobi rotations. */
function leastEigenvector(m: number[][]): THREE.Vector3 {
  const a = m.map((row) => [...row]), v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < 30; sweep++)
    for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) {
      if (a[p][q] === 0) continue;
      const theta = (a[q][q] - a[p][p]) / (2 * a[p][q]), t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1)), c = 1 / Math.hypot(t, 1), s = t * c;
      for (let k = 0; k < 3; k++) [a[k][p], a[k][q]] = [c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]];
      for (let k = 0; k < 3; k++) [a[p][k], a[q][k]] = [c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]];
      for (let k = 0; k < 3; k++) [v[k][p], v[k][q]] = [c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]];
    }
  const least = [0, 1, 2].reduce((best, k) => (a[k][k] < a[best][best] ? k : best), 0);
  return new THREE.Vector3(v[0][least], v[1][least], v[2][least]).normalize();
}

/** Right and up of the plane: that of the picture, or the one that fits the points best, seen from the side of the eye. */
function axesOf(app: App, plane: string, points: THREE.Vector3[]): [THREE.Vector3, THREE.Vector3] {
  const { view } = app;
  const right = new THREE.Vector3(1, 0, 0).applyQuaternion(view.turn), up = new THREE.Vector3(0, 1, 0).applyQuaternion(view.turn);
  if (plane !== "best" || points.length < 3) return [right, up];
  const mean = points.reduce((sum, p) => sum.add(p), new THREE.Vector3()).divideScalar(points.length);
  const spread = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
  for (const p of points) {
    const d = p.clone().sub(mean).toArray();
    for (let i = 0; i < 3; i++) for (let j = 0; j < 3; j++) spread[i][j] += d[i] * d[j];
  }
  const normal = leastEigenvector(spread), eye = new THREE.Vector3(0, 0, 1).applyQuaternion(view.turn);
  if (normal.dot(eye) < 0) normal.negate();
  const upward = Math.abs(normal.dot(up)) < 0.99 ? up : right; // what is up in the picture is up in the drawing
  const y = upward.clone().addScaledVector(normal, -upward.dot(normal)).normalize();
  return [new THREE.Vector3().crossVectors(y, normal), y];
}

/**
 * Runs of one kind along each loop of the borders shown; only of the chosen rows where some are chosen. `plane`: that of
 * the `picture`, or the `best` fitting one.
 */
export function projectedLines(app: App, plane = "picture"): Line[] {
  const { view, arrays, header } = app;
  const lines: (Omit<Line, "points"> & { places: THREE.Vector3[] })[] = [];
  const sets: ["labelBorders" | "regionBorders" | "interpolated", string, string][] = [
    ["labelBorders", "label_borders", "labels"], ["regionBorders", "region_borders", "regions"], ["interpolated", "interpolated", "regions"]];
  for (const [layer, name, kind] of sets) {
    if (!view.isVisible(layer)) continue;
    const chosen = kind === app.rowKind ? app.chosen : [];
    const points = positionsOf(arrays[name], header, view.centre);
    const first = arrays[name + "_first"], owners = arrays[name + "_owner"], holes = arrays[name + "_hole"];
    const at = (i: number) => new THREE.Vector3().fromArray(points, 3 * i);
    for (let l = 0; l + 1 < first.length; l++) {
      if (chosen.length && !chosen.includes(owners[l])) continue;
      const begin = first[l], count = first[l + 1] - begin, place = (i: number) => begin + (i % count);
      let start = 0; // where a run begins; the whole loop is one run where it is of one kind
      while (start < count && holes[place(start)] === holes[place(start + count - 1)]) start++;
      const closed = start === count;
      if (closed) start = 0;
      for (let i = 0; i < count;) {
        const hole = holes[place(start + i)], line = { owner: owners[l] as number, hole: hole === 1, closed, places: [] as THREE.Vector3[] };
        while (i < count && holes[place(start + i)] === hole) line.places.push(at(place(start + i++)));
        if (!closed) line.places.push(at(place(start + i)));
        lines.push(line);
      }
    }
  }
  const [right, up] = axesOf(app, plane, lines.flatMap((line) => line.places));
  return lines.map(({ places, ...line }) => ({ ...line, points: places.map((p): [number, number] => [p.dot(right), p.dot(up)]) }));
}

const number = (value: number) => String(Number(value.toPrecision(7)));
/** Millimetres of a unit of the coordinates; 1 where it has no name that is known. */
const millimetres: Record<string, number> = { mm: 1, cm: 10, m: 1000, in: 25.4, um: 0.001, "µm": 0.001, ft: 304.8 };

export function svgOf(app: App, lines: Line[]): string {
  const scale = millimetres[app.header.units] ?? 1;
  const all = lines.flatMap((line) => line.points).map(([x, y]) => [x * scale, -y * scale]);
  const low = [0, 1].map((k) => all.reduce((m, p) => Math.min(m, p[k]), Infinity) - 2), high = [0, 1].map((k) => all.reduce((m, p) => Math.max(m, p[k]), -Infinity) + 2);
  const width = number(high[0] - low[0]), height = number(high[1] - low[1]);
  const paths = lines.map((line) => `<path class="${line.hole ? "hole" : "level"}" data-number="${line.owner}" d="M${line.points.map(([x, y]) => `${number(x * scale - low[0])} ${number(-y * scale - low[1])}`).join("L")}${line.closed ? "Z" : ""}"/>`);
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}mm" height="${height}mm" viewBox="0 0 ${width} ${height}">
<style>path{fill:none;stroke:#101014;stroke-width:.2;stroke-linejoin:round}.hole{stroke:#7a28dc;stroke-dasharray:.8 .4}</style>
${paths.join("\n")}
</svg>
`;
}

/** Release 12, which every reader knows; a layer for each number and kind, in units of the coordinates. */
export function dxfOf(app: App, lines: Line[]): string {
  const codes: Record<string, number> = { in: 1, ft: 2, mm: 4, cm: 5, m: 6 };
  const out: (string | number)[] = [0, "SECTION", 2, "HEADER", 9, "$ACADVER", 1, "AC1009", 9, "$INSUNITS", 70, codes[app.header.units] ?? 0, 0, "ENDSEC", 0, "SECTION", 2, "ENTITIES"];
  for (const line of lines) {
    const layer = `${line.hole ? "HOLE" : "LEVEL"}_${line.owner}`;
    out.push(0, "POLYLINE", 8, layer, 66, 1, 10, 0, 20, 0, 30, 0, 70, line.closed ? 1 : 0);
    for (const [x, y] of line.points) out.push(0, "VERTEX", 8, layer, 10, number(x), 20, number(y), 30, 0);
    out.push(0, "SEQEND", 8, layer);
  }
  out.push(0, "ENDSEC", 0, "EOF");
  return out.join("\n") + "\n";
}
