// The row of switches above the view, the colour bar, the scale bar, pictures as PNG.
import type { App } from "./app";
import { byId, download, make } from "./dom";
import { show, unitForPeople } from "./data";
import { dxfOf, projectedLines, svgOf } from "./plan";
import type { Layer } from "./view";

const arraysHaveBorders = (app: App) => app.arrays.label_borders !== undefined || app.arrays.region_borders !== undefined;

const layerNames: Record<Layer, string> = {
  mesh: "mesh", points: "points", smoothed: "smoothed points", normals: "normals", rims: "hole rims",
  labelBorders: "label borders", regionBorders: "region borders", interpolated: "interpolated lines",
};

export function makeControls(app: App) {
  const { view, header } = app;
  const colouring = make("select", { id: "colouring", "aria-label": "Colour by", change: () => app.setColouring(colouring.value) });
  if (view.mesh) {
    if (app.arrays.labels) colouring.append(make("option", { value: "labels" }, "labels"), make("option", { value: "regions" }, "regions"));
    if (header.trees?.length) colouring.append(make("option", { value: "levels" }, "level set"));
    (header.scalars ?? []).forEach((s, i) => colouring.append(make("option", { value: String(i) }, `${s.name} (${s.stage})`)));
    colouring.append(make("option", { value: "shape" }, "shape"));
    byId("controls").append(make("fieldset", {}, make("legend", {}, "colour by"), colouring));
  }
  const layers = make("fieldset", {}, make("legend", {}, "show"));
  for (const layer of view.layerNames) {
    const box = make("input", { type: "checkbox", id: "layer-" + layer, change: () => view.setLayer(layer, box.checked) });
    box.checked = view.isVisible(layer);
    layers.append(make("label", {}, box, layerNames[layer]));
  }
  const views = make("fieldset", {}, make("legend", {}, "view"));
  for (const name of ["best", "front", "back", "left", "right", "top", "bottom", "iso"])
    views.append(make("button", { click: () => view.goTo(name) }, name));
  const plane = make("select", { id: "plane", "aria-label": "Plane of drawings" }, make("option", { value: "picture" }, "on the picture's plane"), make("option", { value: "best" }, "on the best plane"));
  const draw = (name: string, write: typeof svgOf) => {
    const lines = projectedLines(app, plane.value);
    if (lines.length) download("borders." + name, write(app, lines), name === "svg" ? "image/svg+xml" : "application/dxf");
    else app.hint("Switch borders on: the drawing holds those that are shown.");
  };
  const drawings = make("fieldset", {}, make("legend", {}, "save"), make("button", { id: "png", title: "The picture", click: () => savePicture(app) }, "PNG"));
  if (arraysHaveBorders(app))
    drawings.append(make("button", { id: "svg", title: "Borders shown, to scale", click: () => draw("svg", svgOf) }, "SVG"),
      make("button", { id: "dxf", title: "Borders shown, to scale", click: () => draw("dxf", dxfOf) }, "DXF"), plane);
  byId("controls").append(views, drawings, layers);
  byId("lightbox").append(lightDial(app));
  view.onDraw = () => drawScale(app);
}

/** A dial seen from above: where the light stands; the rim is low light, which shows shallow relief. */
function lightDial(app: App) {
  const spot = make("i");
  const place = () => {
    const [azimuth, elevation] = app.view.lightAngle;
    const r = (1 - elevation / 90) * 50, a = (azimuth * Math.PI) / 180;
    spot.style.left = `${50 + r * Math.cos(a)}%`;
    spot.style.top = `${50 - r * Math.sin(a)}%`;
    dial.setAttribute("aria-valuetext", `${Math.round(azimuth)} degrees, ${Math.round(elevation)} above the picture`);
    dial.setAttribute("aria-valuenow", String(Math.round(azimuth)));
  };
  const set = (azimuth: number, elevation: number) => { app.view.setLight(azimuth, elevation); place(); };
  const point = (event: PointerEvent) => {
    if (!event.buttons) return;
    dial.setPointerCapture(event.pointerId);
    const box = dial.getBoundingClientRect();
    const x = (event.clientX - box.left) / box.width - 0.5, y = 0.5 - (event.clientY - box.top) / box.height;
    set((Math.atan2(y, x) * 180) / Math.PI, 90 * (1 - Math.min(1, 2 * Math.hypot(x, y))));
  };
  const dial = make("div", {
    class: "light", id: "light", role: "slider", tabindex: 0, "aria-label": "Direction of the raking light; arrows move it",
    "aria-valuemin": 0, "aria-valuemax": 360, title: "Direction of the light: drag; near the rim the light rakes",
    pointerdown: point, pointermove: point,
    keydown: (event: KeyboardEvent) => {
      const [azimuth, elevation] = app.view.lightAngle;
      const moves: Record<string, [number, number]> = { ArrowLeft: [15, 0], ArrowRight: [-15, 0], ArrowUp: [0, 5], ArrowDown: [0, -5] };
      const move = moves[event.key];
      if (move) { event.preventDefault(); set(azimuth + move[0], elevation + move[1]); }
    },
  }, spot);
  place();
  return dial;
}

/** The greatest length 1, 2 or 5 times a power of ten below a fifth of the view's width. */
function scaleOf(app: App) {
  const { view } = app, unit = view.height / (view.canvas.clientHeight || 1);
  const most = (view.canvas.clientWidth * unit) / 5, power = 10 ** Math.floor(Math.log10(most));
  const length = power * ([5, 2, 1].find((m) => m * power <= most) ?? 1);
  return { length, pixels: length / unit, text: `${Number(length.toPrecision(2))} ${app.header.units === "unit" ? "" : app.header.units}` };
}

function drawScale(app: App) {
  const scale = scaleOf(app);
  byId("scalebar").style.width = `${scale.pixels}px`;
  byId("scaletext").textContent = scale.text;
}

/** Colour bar with histogram; dragging over it leaves only those values in colour. */
export function drawLegend(app: App) {
  const legend = byId("legend");
  legend.replaceChildren();
  const number = Number(app.colouring), scalar = app.header.scalars?.[number];
  if (!scalar || app.colouring === "") return;
  const width = 220, height = 44, bins = 110;
  const values = app.view.valuesOf(scalar, number), counts = new Array(bins).fill(0);
  for (const value of values)
    if (value >= scalar.low && value <= scalar.high) counts[Math.min(bins - 1, Math.floor(((value - scalar.low) / (scalar.high - scalar.low)) * bins))]++;
  const most = Math.max(1, ...counts);
  const canvas = make("canvas", { class: "histogram", id: "histogram", role: "img", width, height: height + 14, "aria-label": "Histogram and colour bar; drag over it to leave only those values in colour" });
  let from = 0, to = width;
  const draw = () => {
    const context = canvas.getContext("2d")!;
    context.clearRect(0, 0, width, height + 14);
    counts.forEach((count, i) => {
      const x = (i * width) / bins, inside = x >= from - 1 && x <= to;
      context.fillStyle = inside ? getComputedStyle(document.body).color : "#999";
      const h = (Math.sqrt(count / most)) * height;
      context.fillRect(x, height - h, width / bins - 0.5, h);
    });
    for (let x = 0; x < width; x++) {
      const c = scalar.colours[Math.round((x / width) * 64)];
      context.fillStyle = x >= from && x <= to ? `rgb(${c})` : "#9e9e9e";
      context.fillRect(x, height, 1, 14);
    }
  };
  const valueAt = (x: number) => scalar.low + (x / width) * (scalar.high - scalar.low);
  let start = 0;
  const move = (event: PointerEvent) => {
    const x = Math.min(width, Math.max(0, event.offsetX));
    if (event.type === "pointerdown") { canvas.setPointerCapture(event.pointerId); start = x; }
    else if (!event.buttons) return;
    [from, to] = Math.abs(x - start) < 3 ? [0, width] : [Math.min(x, start), Math.max(x, start)];
    app.view.setBrush(from <= 0 ? -1e29 : valueAt(from), to >= width ? 1e29 : valueAt(to));
    draw();
  };
  canvas.addEventListener("pointerdown", move);
  canvas.addEventListener("pointermove", move);
  draw();
  const unit = unitForPeople(scalar.unit, app.header.units);
  legend.append(make("div", {}, scalar.name + (unit ? ` (${unit})` : "")), canvas,
    make("div", { class: "ends" }, make("span", {}, show(scalar.low)), make("span", {}, show(scalar.high))));
}

/** The view with scale bar, legend and heading, on the page's ground. */
export function picture(app: App): HTMLCanvasElement {
  app.view.drawStanding();
  const source = app.view.canvas, ratio = source.width / source.clientWidth;
  const canvas = make("canvas", { width: source.width, height: source.height });
  const context = canvas.getContext("2d")!, style = getComputedStyle(document.body);
  context.fillStyle = getComputedStyle(byId("stage3d")).backgroundColor;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.drawImage(source, 0, 0);
  context.scale(ratio, ratio);
  const scale = scaleOf(app), bottom = source.clientHeight - 14;
  context.strokeStyle = context.fillStyle = style.color;
  context.lineWidth = 2;
  context.font = "14px system-ui, sans-serif";
  context.beginPath();
  context.moveTo(14, bottom - 26); context.lineTo(14, bottom - 20); context.lineTo(14 + scale.pixels, bottom - 20); context.lineTo(14 + scale.pixels, bottom - 26);
  context.stroke();
  context.fillText(scale.text, 14, bottom);
  const bar = document.getElementById("histogram") as HTMLCanvasElement | null;
  const scalar = app.header.scalars?.[Number(app.colouring)];
  if (bar && scalar) {
    const left = source.clientWidth - bar.width - 14;
    const unit = unitForPeople(scalar.unit, app.header.units);
    context.fillText(scalar.name + (unit ? ` (${unit})` : ""), left, 22);
    context.drawImage(bar, left, 28);
    context.fillText(show(scalar.low), left, 28 + bar.height + 16);
    const high = show(scalar.high);
    context.fillText(high, left + bar.width - context.measureText(high).width, 28 + bar.height + 16);
  }
  return canvas;
}

function savePicture(app: App) {
  picture(app).toBlob((blob) => { if (blob) download("view.png", blob); });
}

/** Before printing: fixed views in place of the live one. */
export function makePrints(app: App) {
  const { view } = app, kept = { turn: view.turn.clone(), target: view.target.clone(), height: view.height };
  const section = byId("print");
  section.replaceChildren();
  for (const name of ["best", "front", "right", "top"]) {
    view.goTo(name);
    section.append(make("figure", {}, make("img", { src: picture(app).toDataURL(), alt: name }), make("figcaption", {}, name)));
  }
  view.turn.copy(kept.turn); view.target.copy(kept.target); view.height = kept.height;
  view.draw();
}
