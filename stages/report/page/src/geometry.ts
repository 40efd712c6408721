// The drawn mesh: quantised positions to floats, one corner of each triangle carries what belongs to the triangle.
import type { Arrays, Header } from "./data";

export type Mesh = {
  positions: Float32Array; // 3 a vertex, relative to `centre`
  normals: Int16Array; // 4 a vertex, in 1/32767
  index: Uint32Array; // the last corner of a triangle is its own: WebGL takes flat values from there
  ownVertex: Uint32Array; // of each triangle
  triangleOfVertex: Int32Array; // -1: no triangle's own
  sourceVertex: Uint32Array; // display vertex of each drawn vertex
  numTriangles: number;
};

/** Steps of 16 bits to coordinates relative to a centre near the middle of the box. */
export function positionsOf(steps: Uint16Array, header: Header, centre: number[]): Float32Array {
  const positions = new Float32Array(steps.length);
  const shift = [0, 1, 2].map((k) => header.low[k] - centre[k]);
  for (let i = 0; i < steps.length; i += 3)
    for (let k = 0; k < 3; k++) positions[i + k] = steps[i + k] * header.step + shift[k];
  return positions;
}

/** Each triangle claims a corner that no other has, or a copy of one. */
export function buildMesh(corners: Int32Array, shared: Float32Array): Mesh {
  const numShared = shared.length / 3, numTriangles = corners.length / 3;
  const triangleOf = new Int32Array(numShared + numTriangles).fill(-1);
  const source = new Uint32Array(numShared + numTriangles);
  for (let v = 0; v < numShared; v++) source[v] = v;
  const index = new Uint32Array(corners.length), ownVertex = new Uint32Array(numTriangles);
  let count = numShared;
  for (let t = 0; t < numTriangles; t++) {
    const a = corners[3 * t], b = corners[3 * t + 1], c = corners[3 * t + 2];
    let own = c, first = a, second = b;
    if (triangleOf[c] >= 0) {
      if (triangleOf[b] < 0) { own = b; first = c; second = a; }
      else if (triangleOf[a] < 0) { own = a; first = b; second = c; }
      else { own = count++; source[own] = c; }
    }
    triangleOf[own] = t;
    ownVertex[t] = own;
    index[3 * t] = first; index[3 * t + 1] = second; index[3 * t + 2] = own;
  }
  const sum = new Float32Array(shared.length);
  for (let t = 0; t < corners.length; t += 3) {
    const a = 3 * corners[t], b = 3 * corners[t + 1], c = 3 * corners[t + 2];
    const ux = shared[b] - shared[a], uy = shared[b + 1] - shared[a + 1], uz = shared[b + 2] - shared[a + 2];
    const vx = shared[c] - shared[a], vy = shared[c + 1] - shared[a + 1], vz = shared[c + 2] - shared[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const v of [a, b, c]) { sum[v] += nx; sum[v + 1] += ny; sum[v + 2] += nz; }
  }
  const positions = new Float32Array(3 * count), normals = new Int16Array(4 * count);
  for (let v = 0; v < count; v++) {
    const s = 3 * source[v];
    const length = Math.hypot(sum[s], sum[s + 1], sum[s + 2]) || 1;
    for (let k = 0; k < 3; k++) {
      positions[3 * v + k] = shared[s + k];
      normals[4 * v + k] = Math.round((sum[s + k] / length) * 32767);
    }
  }
  return { positions, normals, index, ownVertex, numTriangles, triangleOfVertex: triangleOf.subarray(0, count),
    sourceVertex: source.subarray(0, count) };
}

/** Closed curves as pairs of ends, those of one kind; `owner` 0: of all. */
export function segmentsOf(arrays: Arrays, name: string, header: Header, centre: number[], hole: boolean, owner = 0) {
  const steps = arrays[name];
  if (!steps) return new Float32Array(0);
  const points = positionsOf(steps, header, centre), first = arrays[name + "_first"];
  const owners = arrays[name + "_owner"], holes = arrays[name + "_hole"];
  const ends: number[] = [];
  for (let l = 0; l + 1 < first.length; l++) {
    if (owner && owners[l] !== owner) continue;
    for (let i = first[l]; i < first[l + 1]; i++) {
      if ((holes[i] === 1) !== hole) continue;
      const next = i + 1 < first[l + 1] ? i + 1 : first[l];
      for (let k = 0; k < 3; k++) ends.push(points[3 * i + k]);
      for (let k = 0; k < 3; k++) ends.push(points[3 * next + k]);
    }
  }
  return new Float32Array(ends);
}
