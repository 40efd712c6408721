// Off the main thread: text to bytes, bytes to arrays. See stages/report/block_writer.hpp for the codings.
import { unzlibSync } from "fflate";
import type { Block } from "./data";

function bytesOfBase64(text: string): Uint8Array {
  const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const value = new Uint8Array(128);
  for (let i = 0; i < 64; i++) value[digits.charCodeAt(i)] = i;
  let end = text.length;
  while (end > 0 && text[end - 1] === "=") end--;
  const bytes = new Uint8Array(Math.floor((end * 3) / 4));
  let at = 0;
  for (let i = 0; i < end; i += 4) {
    const group =
      (value[text.charCodeAt(i)] << 18) |
      (value[text.charCodeAt(i + 1)] << 12) |
      ((i + 2 < end ? value[text.charCodeAt(i + 2)] : 0) << 6) |
      (i + 3 < end ? value[text.charCodeAt(i + 3)] : 0);
    bytes[at++] = group >> 16;
    if (at < bytes.length) bytes[at++] = group >> 8;
    if (at < bytes.length) bytes[at++] = group;
  }
  return bytes;
}

function decode(block: Block, raw: Uint8Array) {
  const n = block.count, stride = block.stride;
  if (block.coding === "plain8") return raw;
  if (block.coding === "delta16") {
    const values = new Uint16Array(n);
    for (let i = 0; i < n; i++) {
      const z = raw[i] | (raw[n + i] << 8);
      values[i] = (i < stride ? 0 : values[i - stride]) + ((z >>> 1) ^ -(z & 1));
    }
    return values;
  }
  const words = new Uint32Array(n);
  for (let i = 0; i < n; i++) words[i] = raw[i] | (raw[n + i] << 8) | (raw[2 * n + i] << 16) | (raw[3 * n + i] << 24);
  if (block.coding === "float32") return new Float32Array(words.buffer);
  const values = new Int32Array(n);
  if (block.coding === "index") {
    let next = 0;
    for (let i = 0; i < n; i++) {
      values[i] = next - words[i];
      if (words[i] === 0) next++;
    }
  } else {
    for (let i = 0; i < n; i++)
      values[i] = ((i < stride ? 0 : values[i - stride]) + ((words[i] >>> 1) ^ -(words[i] & 1))) | 0;
  }
  return values;
}

/**
 * A coarse copy for motion and for the first picture: vertices in a cell of a grid become the first of them. Each of its
 * triangles stands for one of the drawn mesh and takes its colours.
 */
function coarse(steps: Uint16Array, corners: Int32Array, most: number) {
  let area = 0;
  for (let t = 0; t < corners.length; t += 3) {
    const [a, b, c] = [3 * corners[t], 3 * corners[t + 1], 3 * corners[t + 2]];
    const ux = steps[b] - steps[a], uy = steps[b + 1] - steps[a + 1], uz = steps[b + 2] - steps[a + 2];
    const vx = steps[c] - steps[a], vy = steps[c + 1] - steps[a + 1], vz = steps[c + 2] - steps[a + 2];
    area += Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx) / 2;
  }
  const first = new Int32Array(steps.length / 3);
  for (let cell = Math.max(16, Math.sqrt((2 * area) / most)); ; cell *= 1.3) {
    const places = new Map<number, number>();
    for (let v = 0; v < first.length; v++) {
      const key = (Math.floor(steps[3 * v] / cell) * 4096 + Math.floor(steps[3 * v + 1] / cell)) * 4096 + Math.floor(steps[3 * v + 2] / cell);
      const there = places.get(key);
      if (there === undefined) places.set(key, v);
      first[v] = there ?? v;
    }
    const kept: number[] = [];
    for (let t = 0; t < corners.length / 3 && kept.length <= most; t++) {
      const a = first[corners[3 * t]], b = first[corners[3 * t + 1]], c = first[corners[3 * t + 2]];
      if (a !== b && b !== c && a !== c) kept.push(t);
    }
    if (kept.length > most) continue;
    const number = new Map<number, number>(), coarseCorners = new Int32Array(3 * kept.length);
    kept.forEach((t, i) => {
      for (let k = 0; k < 3; k++) {
        const v = first[corners[3 * t + k]];
        if (!number.has(v)) number.set(v, number.size);
        coarseCorners[3 * i + k] = number.get(v)!;
      }
    });
    return { coarse_vertices: Int32Array.from(number.keys()), coarse_corners: coarseCorners, coarse_triangles: Int32Array.from(kept) };
  }
}

self.onmessage = (message: MessageEvent<{ text: string; blocks: Block[] }>) => {
  const bytes = bytesOfBase64(message.data.text);
  const arrays: Record<string, unknown> = {};
  const buffers = new Set<ArrayBufferLike>();
  for (const block of message.data.blocks) {
    const raw = unzlibSync(bytes.subarray(block.offset, block.offset + block.size));
    const values = decode(block, raw);
    arrays[block.name] = values;
    buffers.add(values.buffer);
  }
  const corners = arrays.corners as Int32Array | undefined;
  if (corners && corners.length > 3 * 150000) {
    for (const [name, values] of Object.entries(coarse(arrays.positions as Uint16Array, corners, 100000))) {
      arrays[name] = values;
      buffers.add(values.buffer);
    }
  }
  (self as unknown as Worker).postMessage(arrays, [...buffers] as ArrayBuffer[]);
};
