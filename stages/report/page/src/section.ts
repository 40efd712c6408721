// A cut through the mesh: two clicks, the plane through both along the line of sight; the profile nearest to the eye.
import * as THREE from "three";
import type { App } from "./app";
import { drawChart } from "./chart";
import { download, make } from "./dom";
import { show, unitForPeople } from "./data";

export type Profile = { along: number[]; height: (number | null)[]; value: (number | null)[]; line: Float32Array };

/** Heights toward the eye at equal steps from a to b, null where there is no surface. */
export function cut(app: App, a: THREE.Vector3, b: THREE.Vector3, eye: THREE.Vector3, samples = 600): Profile | null {
  const mesh = app.view.mesh!;
  const along = b.clone().sub(a).addScaledVector(eye, -b.clone().sub(a).dot(eye));
  const length = along.length();
  if (!(length > 0)) return null;
  along.divideScalar(length);
  const across = new THREE.Vector3().crossVectors(eye, along);
  const count = mesh.positions.length / 3;
  const side = new Float32Array(count), s = new Float32Array(count), h = new Float32Array(count);
  for (let v = 0; v < count; v++) {
    const x = mesh.positions[3 * v] - a.x, y = mesh.positions[3 * v + 1] - a.y, z = mesh.positions[3 * v + 2] - a.z;
    side[v] = x * across.x + y * across.y + z * across.z;
    s[v] = x * along.x + y * along.y + z * along.z;
    h[v] = x * eye.x + y * eye.y + z * eye.z;
  }
  const number = Number(app.colouring), scalar = app.header.scalars?.[number] ?? app.header.scalars?.[0];
  const values = scalar ? app.view.valuesOf(scalar, app.header.scalars![number] ? number : 0) : null;
  const heights: (number | null)[] = Array(samples + 1).fill(null), shown: (number | null)[] = Array(samples + 1).fill(null);
  for (let t = 0; t < mesh.index.length; t += 3) {
    const ends: [number, number, number][] = [];
    for (let k = 0; k < 3; k++) {
      const i = mesh.index[t + k], j = mesh.index[t + ((k + 1) % 3)];
      if (side[i] < 0 === side[j] < 0) continue;
      const f = side[i] / (side[i] - side[j]);
      const v = values ? values[mesh.sourceVertex[i]] * (1 - f) + values[mesh.sourceVertex[j]] * f : NaN;
      ends.push([s[i] + f * (s[j] - s[i]), h[i] + f * (h[j] - h[i]), v]);
    }
    if (ends.length !== 2) continue;
    const [from, to] = ends[0][0] < ends[1][0] ? ends : [ends[1], ends[0]];
    const first = Math.max(0, Math.ceil((from[0] / length) * samples)), last = Math.min(samples, Math.floor((to[0] / length) * samples));
    for (let i = first; i <= last; i++) {
      const f = to[0] > from[0] ? ((i / samples) * length - from[0]) / (to[0] - from[0]) : 0;
      const height = from[1] + f * (to[1] - from[1]);
      if (heights[i] !== null && heights[i]! >= height) continue;
      heights[i] = height;
      const value = from[2] + f * (to[2] - from[2]);
      shown[i] = Number.isFinite(value) ? value : null;
    }
  }
  const ends: number[] = [];
  const place = (i: number) => a.clone().addScaledVector(along, (i / samples) * length).addScaledVector(eye, heights[i]!).toArray();
  for (let i = 0; i < samples; i++) if (heights[i] !== null && heights[i + 1] !== null) ends.push(...place(i), ...place(i + 1));
  return { along: heights.map((_, i) => (i / samples) * length), height: heights, value: shown, line: new Float32Array(ends) };
}

export function makeSection(app: App): HTMLElement {
  const units = app.header.units;
  let active = false, first: THREE.Vector3 | null = null, profile: Profile | null = null;
  const button = make("button", { id: "cut", "aria-pressed": "false", click: () => { active = !active; first = null; button.setAttribute("aria-pressed", String(active)); app.hint(active ? "Click the first point of the cut." : ""); } }, "cut: click two points");
  const told = make("p", { role: "status", id: "sectiontext" }), charts = make("div", { id: "profile" });
  const save = make("button", { id: "sectioncsv", click: () => {
    if (profile) download("profile.csv", "along,height,value\n" + profile.along.map((x, i) => `${x},${profile!.height[i] ?? ""},${profile!.value[i] ?? ""}`).join("\n") + "\n", "text/csv");
  } }, "CSV");
  const element = make("div", {}, make("div", { class: "tools" }, button, save),
    make("p", { class: "soft" }, "The plane goes through both points along the line of sight; the profile is that of the surface nearest to you, heights toward you from the first point." + (app.header.cell ? " It is cut from the simplified display mesh." : "")), told, charts);
  app.listeners.clicked.push((hit) => {
    if (!active || !hit) return false;
    if (!first) { first = hit.point; app.hint("Click the second point."); return true; }
    const eye = new THREE.Vector3(0, 0, 1).applyQuaternion(app.view.turn);
    profile = cut(app, first, hit.point, eye);
    first = null;
    active = false;
    button.setAttribute("aria-pressed", "false");
    app.hint("");
    draw();
    return true;
  });
  function draw() {
    charts.replaceChildren();
    if (!profile) { told.textContent = "Both points lie on one line of sight: turn the view."; return; }
    app.view.setExtra([{ ends: profile.line, colour: 0xd55e00, width: 4 }]);
    const heights = profile.height.filter((h) => h !== null) as number[];
    const range = Math.max(...heights) - Math.min(...heights);
    told.textContent = `Length ${show(profile.along.at(-1))} ${units}, heights over ${show(range)} ${units}.`;
    const x = { label: `along (${units})`, values: profile.along };
    drawChart(charts, x, `height (${units})`, [{ label: "height", values: profile.height, light: "#0b5cad", dark: "#7ab8ff" }]);
    const scalar = app.header.scalars?.[Number(app.colouring)] ?? app.header.scalars?.[0];
    if (scalar) drawChart(charts, x, unitForPeople(scalar.unit, units), [{ label: scalar.name, values: profile.value, light: "#b35900", dark: "#ffb454" }]);
  }
  return element;
}
