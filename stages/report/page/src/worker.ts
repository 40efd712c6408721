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
  (self as unknown as Worker).postMessage(arrays, [...buffers] as ArrayBuffer[]);
};
