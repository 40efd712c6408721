// The 3D view: draws on demand; camera orthographic, so that lengths can be read anywhere.
import * as THREE from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import type { Arrays, Header, Scalar } from "./data";
import { buildMesh, type Mesh, positionsOf, segmentsOf } from "./geometry";

const kUndefined = -1e30;
const vertexShader = /* glsl */ `
  in vec4 paint; in float value;
  flat out vec4 vPaint; out float vValue; out vec3 vNormal; flat out int vId;
  void main() {
    vPaint = paint; vValue = value; vNormal = normalMatrix * normal; vId = gl_VertexID;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;
const fragmentShader = /* glsl */ `
  precision highp float; precision highp int;
  flat in vec4 vPaint; in float vValue; in vec3 vNormal; flat in int vId;
  uniform int mode; uniform sampler2D colours; uniform vec2 range; uniform vec2 brush; uniform vec3 light;
  out vec4 colour;
  void main() {
    if (vPaint.a < 0.1) discard;
    if (mode == 3) { // which triangle
      int id = vId + 1;
      colour = vec4(id & 255, (id >> 8) & 255, (id >> 16) & 255, (id >> 24) & 255) / 255.0;
      return;
    }
    vec3 c = vec3(0.80, 0.79, 0.77);
    if (mode == 1) c = vPaint.rgb;
    if (mode == 2) {
      if (vValue < -1e29) c = vec3(0.47);
      else if (vValue < brush.x || vValue > brush.y) c = vec3(0.62);
      else c = texture(colours, vec2((clamp((vValue - range.x) / (range.y - range.x), 0.0, 1.0) * 64.0 + 0.5) / 65.0, 0.5)).rgb;
    }
    // Noise folds single triangles over; they are not the back of the surface, of which the smooth normal tells, too.
    bool back = !gl_FrontFacing && vNormal.z < 0.0;
    vec3 n = normalize(back ? -vNormal : vNormal);
    float lit = 0.42 + 0.68 * max(dot(n, light), 0.0);
    if (back) c = mix(c, vec3(0.35, 0.33, 0.40), 0.6);
    if (vPaint.a < 0.7 && mod(gl_FragCoord.x + gl_FragCoord.y, 9.0) < 2.0) c = mix(c, vec3(0.05, 0.05, 0.08), 0.6);
    colour = vec4(c * lit, 1.0);
  }`;

export type Layer = "points" | "smoothed" | "normals" | "mesh" | "rims" | "labelBorders" | "regionBorders" | "interpolated";
export type Hit = { triangle: number; point: THREE.Vector3; shares: [number, number, number] };

type Drawn = {
  mesh: Mesh; object: THREE.Mesh; paint: Uint8Array;
  triangles: Int32Array | null; // which of the mesh's triangle each is; null: the same
  vertices: Int32Array | null; // likewise the display vertices
};

/** Whether the processor draws instead of a graphics card: then smooth edges cost half of the time. */
function drawsInSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl && info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export class View {
  readonly renderer: THREE.WebGLRenderer | null; // null: the browser draws no 3D; what needs no picture works all the same
  readonly problem: string = "";
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 1);
  readonly centre: number[];
  readonly mesh: Mesh | null = null;
  readonly target = new THREE.Vector3();
  readonly turn = new THREE.Quaternion();
  height = 1; // of the view, in coordinate units
  size = 1; // radius of the whole
  lightAngle = [135, 28]; // degrees, as in the exported pictures
  onDraw: () => void = () => {};
  onMove: () => void = () => {};
  onLook: () => void = () => {}; // the light or what is shown has changed
  onClick: (hit: Hit | null) => void = () => {};
  private material: THREE.ShaderMaterial | null = null;
  private surface: THREE.Mesh | null = null;
  private drawn: Drawn[] = []; // the mesh, and its coarse copy where it is large
  private moving = 0; // timer: at its end the standing picture is drawn
  private slow = true; // until a standing picture was drawn quickly
  private layers = new Map<Layer, THREE.Object3D[]>();
  private pending = false;
  private seen = false; // something has been drawn
  private extra: THREE.Object3D[] = [];

  constructor(readonly canvas: HTMLCanvasElement, private header: Header, private arrays: Arrays) {
    try {
      this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !drawsInSoftware(), alpha: true });
      this.renderer.setClearColor(0, 0);
    } catch (error) {
      this.renderer = null;
      this.problem = (error as Error).message;
    }
    const steps = arrays.positions ?? arrays.points;
    const high = [0, 0, 0];
    for (let i = 0; i < steps.length; i++) high[i % 3] = Math.max(high[i % 3], steps[i]);
    this.centre = [0, 1, 2].map((k) => header.low[k] + (high[k] * header.step) / 2);
    this.size = (Math.hypot(...high) * header.step) / 2 || 1;
    if (arrays.corners) {
      const shared = positionsOf(arrays.positions, header, this.centre);
      this.mesh = buildMesh(arrays.corners, shared);
      this.material = this.makeMaterial();
      this.surface = this.addSurface(this.mesh, null, null);
      this.layers.set("mesh", [this.surface]);
      const vertices = arrays.coarse_vertices as Int32Array | undefined;
      if (vertices) {
        const positions = new Float32Array(3 * vertices.length);
        vertices.forEach((v, i) => { for (let k = 0; k < 3; k++) positions[3 * i + k] = shared[3 * v + k]; });
        this.addSurface(buildMesh(arrays.coarse_corners, positions), arrays.coarse_triangles, vertices).visible = false;
      }
    }
    this.addLayers();
    this.goTo("best");
    this.drawCoarseFirst();
    this.listen();
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  get layerNames() { return [...this.layers.keys()]; }
  setLayer(layer: Layer, visible: boolean) {
    for (const object of this.layers.get(layer) ?? []) object.visible = visible;
    this.onLook();
    this.draw();
  }
  isVisible(layer: Layer) { return this.layers.get(layer)?.[0]?.visible ?? false; }

  /** Colours of triangles: 4 bytes each; alpha 255 plain, 128 marked, 0 not drawn. */
  setPaint(paintOf: (triangle: number, out: Uint8Array, at: number) => void) {
    for (const { mesh, object, paint, triangles } of this.drawn) {
      const { ownVertex } = mesh;
      for (let t = 0; t < ownVertex.length; t++) paintOf(triangles ? triangles[t] : t, paint, 4 * ownVertex[t]);
      object.geometry.getAttribute("paint").needsUpdate = true;
    }
    this.draw();
  }
  showPlain() { this.setMode(0); }
  showPaint() { this.setMode(1); }
  private setMode(mode: number) {
    if (this.material) this.material.uniforms.mode.value = mode;
    this.draw();
  }
  showScalar(scalar: Scalar, number: number) {
    if (!this.material) return;
    const all = this.valuesOf(scalar, number);
    for (const { mesh, object, vertices } of this.drawn) {
      const values = object.geometry.getAttribute("value") as THREE.BufferAttribute, array = values.array as Float32Array;
      for (let v = 0; v < array.length; v++) {
        const source = mesh.sourceVertex[v], value = all[vertices ? vertices[source] : source];
        array[v] = Number.isNaN(value) ? kUndefined : value;
      }
      values.needsUpdate = true;
    }
    const texels = new Uint8Array(65 * 4);
    scalar.colours.forEach((c, i) => texels.set([...c, 255], 4 * i));
    const texture = new THREE.DataTexture(texels, 65, 1);
    texture.magFilter = texture.minFilter = THREE.LinearFilter;
    texture.needsUpdate = true;
    const u = this.material.uniforms;
    u.colours.value?.dispose();
    u.colours.value = texture;
    u.range.value.set(scalar.low, scalar.high);
    u.brush.value.set(-1e29, 1e29);
    this.setMode(2);
  }
  setBrush(low: number, high: number) {
    this.material?.uniforms.brush.value.set(low, high);
    this.draw();
  }
  /** At display vertices; NaN where undefined. */
  valuesOf(scalar: Scalar, number: number): Float32Array {
    const steps = this.arrays["scalar" + number] as Uint16Array;
    const values = new Float32Array(steps.length);
    const unit = (scalar.to - scalar.from) / 65534;
    for (let v = 0; v < steps.length; v++) values[v] = steps[v] === 65535 ? NaN : scalar.from + steps[v] * unit;
    return values;
  }

  goTo(name: string) {
    const views: Record<string, [number[], number[]]> = {
      front: [[0, -1, 0], [0, 0, 1]], back: [[0, 1, 0], [0, 0, 1]], left: [[-1, 0, 0], [0, 0, 1]],
      right: [[1, 0, 0], [0, 0, 1]], top: [[0, 0, 1], [0, 1, 0]], bottom: [[0, 0, -1], [0, -1, 0]],
      iso: [[1, -1, 0.8], [0, 0, 1]],
    };
    let [eye, up] = views[name === "best" ? "iso" : name];
    if (name === "best" && this.mesh) {
      const sum = new THREE.Vector3();
      let length = 0;
      const { normals } = this.mesh;
      for (let v = 0; v < normals.length; v += 4) { sum.x += normals[v]; sum.y += normals[v + 1]; sum.z += normals[v + 2]; length += 32767; }
      if (sum.length() > 0.5 * length) {
        eye = sum.normalize().toArray();
        up = Math.abs(eye[1]) < 0.9 ? [0, 1, 0] : [0, 0, 1];
      }
    }
    const matrix = new THREE.Matrix4().lookAt(new THREE.Vector3(...eye), new THREE.Vector3(), new THREE.Vector3(...up));
    this.turn.setFromRotationMatrix(matrix);
    this.target.set(0, 0, 0);
    this.height = this.fittingHeight();
    this.onMove();
    this.draw();
  }
  private fittingHeight() {
    const positions = this.mesh?.positions ?? positionsOf(this.arrays.points, this.header, this.centre);
    const right = new THREE.Vector3(1, 0, 0).applyQuaternion(this.turn), up = new THREE.Vector3(0, 1, 0).applyQuaternion(this.turn);
    let x = 0, y = 0;
    for (let i = 0; i < positions.length; i += 3) {
      x = Math.max(x, Math.abs(positions[i] * right.x + positions[i + 1] * right.y + positions[i + 2] * right.z));
      y = Math.max(y, Math.abs(positions[i] * up.x + positions[i + 1] * up.y + positions[i + 2] * up.z));
    }
    const aspect = (this.canvas.clientWidth || 4) / (this.canvas.clientHeight || 3);
    return 2.16 * Math.max(y, x / aspect) || 1;
  }
  rotate(dx: number, dy: number) {
    this.turn.multiply(new THREE.Quaternion().setFromEuler(new THREE.Euler(-dy, -dx, 0)));
    this.moved();
  }
  pan(dx: number, dy: number) { // pixels
    const unit = this.height / this.canvas.clientHeight;
    this.target.add(new THREE.Vector3(-dx * unit, dy * unit, 0).applyQuaternion(this.turn));
    this.moved();
  }
  zoom(factor: number, x = this.canvas.clientWidth / 2, y = this.canvas.clientHeight / 2) {
    const unit = this.height / this.canvas.clientHeight;
    const shift = new THREE.Vector3((x - this.canvas.clientWidth / 2) * unit, (this.canvas.clientHeight / 2 - y) * unit, 0);
    this.target.add(shift.multiplyScalar(1 - factor).applyQuaternion(this.turn));
    this.height *= factor;
    this.moved();
  }
  centreOn(x: number, y: number, z: number, width: number) {
    this.target.set(x, y, z);
    this.height = Math.min(Math.max(width, this.size / 200), this.size * 2.2);
    this.onMove();
    this.draw();
  }
  private moved() {
    this.onMove();
    if (this.slow) this.drawCoarseFirst();
    this.draw();
  }
  /** Until the view has stood still for a moment the coarse copy is drawn, without lines. */
  drawCoarseFirst() {
    if (this.drawn.length < 2) return;
    clearTimeout(this.moving);
    this.moving = window.setTimeout(() => { this.moving = 0; this.draw(); }, 300);
  }

  setLight(azimuth: number, elevation: number) {
    this.lightAngle = [((azimuth % 360) + 360) % 360, Math.min(90, Math.max(2, elevation))];
    this.onLook();
    this.draw();
  }

  draw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => { this.pending = false; this.drawNow(); });
  }
  drawNow() {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (!width || !height || !this.renderer) return;
    const ratio = Math.min(devicePixelRatio, 2);
    const current = this.renderer.getSize(new THREE.Vector2());
    if (current.x !== width || current.y !== height || this.renderer.getPixelRatio() !== ratio) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
    }
    this.placeCamera(width / height);
    if (this.moving && this.surface?.visible) {
      const [full, coarse] = this.drawn, hidden = this.scene.children.filter((child) => child.visible && child !== full.object);
      for (const child of [full.object, ...hidden]) child.visible = false;
      coarse.object.visible = true;
      this.renderer.render(this.scene, this.camera);
      coarse.object.visible = false;
      for (const child of [full.object, ...hidden]) child.visible = true;
    } else {
      const start = performance.now(), gl = this.renderer.getContext();
      this.renderer.render(this.scene, this.camera);
      if (this.drawn.length > 1) { // reading a pixel waits for the picture
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        this.slow = performance.now() - start > 50;
      }
    }
    if (!this.seen) { // reading a pixel waits for the picture
      const gl = this.renderer.getContext();
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      performance.mark("first picture");
      this.seen = true;
    }
    this.onDraw();
  }
  /** The whole picture at once, for what is saved or read. */
  drawStanding() {
    clearTimeout(this.moving);
    this.moving = 0;
    this.drawNow();
  }
  private placeCamera(aspect: number) {
    const c = this.camera, reach = this.size * 1.1 + this.target.length();
    c.top = this.height / 2; c.bottom = -c.top; c.right = c.top * aspect; c.left = -c.right;
    c.near = 0; c.far = 2 * reach;
    c.quaternion.copy(this.turn);
    c.position.set(0, 0, reach).applyQuaternion(this.turn).add(this.target);
    c.updateProjectionMatrix();
    c.updateMatrixWorld();
    if (this.material) {
      const [azimuth, elevation] = this.lightAngle.map((a) => (a * Math.PI) / 180);
      this.material.uniforms.light.value.set(Math.cos(azimuth) * Math.cos(elevation), Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation));
    }
  }

  /** What lies under a pixel of the canvas. */
  pick(x: number, y: number): Hit | null {
    if (!this.renderer || !this.mesh || !this.material || !this.surface?.visible) return null;
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    this.placeCamera(width / height);
    const spot = new THREE.WebGLRenderTarget(1, 1);
    const mode = this.material.uniforms.mode.value;
    const shown = this.scene.children.filter((child) => child.visible && child !== this.surface);
    for (const child of shown) child.visible = false;
    this.material.uniforms.mode.value = 3;
    this.camera.setViewOffset(width, height, x, y, 1, 1);
    this.renderer.setRenderTarget(spot);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    const id = new Uint8Array(4);
    this.renderer.readRenderTargetPixels(spot, 0, 0, 1, 1, id);
    this.renderer.setRenderTarget(null);
    this.camera.clearViewOffset();
    this.material.uniforms.mode.value = mode;
    for (const child of shown) child.visible = true;
    spot.dispose();
    const vertex = id[0] + 256 * (id[1] + 256 * (id[2] + 256 * id[3])) - 1;
    if (vertex < 0 || vertex >= this.mesh.triangleOfVertex.length) return null;
    const triangle = this.mesh.triangleOfVertex[vertex];
    if (triangle < 0) return null;
    const [a, b, c] = [0, 1, 2].map((k) => this.positionOf(this.mesh!.index[3 * triangle + k]));
    const from = new THREE.Vector3((2 * x) / width - 1, 1 - (2 * y) / height, -1).unproject(this.camera);
    const along = new THREE.Vector3(0, 0, -1).applyQuaternion(this.turn);
    const normal = b.clone().sub(a).cross(c.clone().sub(a));
    const down = normal.dot(along);
    const point = Math.abs(down) > 0 ? from.addScaledVector(along, a.clone().sub(from).dot(normal) / down) : a.clone();
    const shares = new THREE.Vector3();
    THREE.Triangle.getBarycoord(point, a, b, c, shares);
    return { triangle, point, shares: shares.toArray() as [number, number, number] };
  }
  positionOf(vertex: number) {
    return new THREE.Vector3().fromArray(this.mesh!.positions, 3 * vertex);
  }

  /** Lines of the moment: the border of what is chosen, a section. */
  setExtra(lines: { ends: Float32Array; colour: number; width: number }[]) {
    for (const object of this.extra) { this.scene.remove(object); (object as LineSegments2).geometry.dispose(); }
    this.extra = lines.filter((l) => l.ends.length).map((l) => this.lines(l.ends, l.colour, l.width));
    for (const object of this.extra) this.scene.add(object);
    this.draw();
  }

  private makeMaterial() {
    return new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3, vertexShader, fragmentShader, side: THREE.DoubleSide,
      polygonOffset: true, polygonOffsetFactor: 1.5, polygonOffsetUnits: 6,
      uniforms: {
        mode: { value: 0 }, colours: { value: null }, range: { value: new THREE.Vector2(0, 1) },
        brush: { value: new THREE.Vector2(-1e29, 1e29) }, light: { value: new THREE.Vector3(0, 0, 1) },
      },
    });
  }
  private addSurface(mesh: Mesh, triangles: Int32Array | null, vertices: Int32Array | null) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(mesh.positions, 3));
    const packed = new THREE.InterleavedBuffer(mesh.normals, 4);
    geometry.setAttribute("normal", new THREE.InterleavedBufferAttribute(packed, 3, 0, true));
    const paint = new Uint8Array((4 * mesh.positions.length) / 3).fill(255);
    geometry.setAttribute("paint", new THREE.BufferAttribute(paint, 4, true));
    geometry.setAttribute("value", new THREE.BufferAttribute(new Float32Array(mesh.positions.length / 3), 1));
    geometry.setIndex(new THREE.BufferAttribute(mesh.index, 1));
    const object = new THREE.Mesh(geometry, this.material!);
    object.frustumCulled = false;
    this.scene.add(object);
    this.drawn.push({ mesh, object, paint, triangles, vertices });
    return object;
  }
  private lines(ends: Float32Array, colour: number, width: number) {
    const geometry = new LineSegmentsGeometry();
    geometry.setPositions(ends);
    const object = new LineSegments2(geometry, new LineMaterial({ color: colour, linewidth: width }));
    object.frustumCulled = false;
    return object;
  }
  private addLayer(layer: Layer, objects: THREE.Object3D[], visible: boolean) {
    if (!objects.length) return;
    for (const object of objects) { object.visible = visible; this.scene.add(object); }
    this.layers.set(layer, objects);
  }
  private addLayers() {
    const { arrays, header, centre } = this;
    const cloud = (steps: Uint16Array, colour: number) => {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(positionsOf(steps, header, centre), 3));
      const points = new THREE.Points(geometry, new THREE.PointsMaterial({ color: colour, size: 2, sizeAttenuation: false }));
      points.frustumCulled = false;
      return points;
    };
    if (arrays.points) this.addLayer("points", [cloud(arrays.points, 0x2b6cb0)], !this.mesh);
    if (arrays.smoothed) this.addLayer("smoothed", [cloud(arrays.smoothed, 0xc05600)], false);
    if (arrays.normals && arrays.points) {
      const points = positionsOf(arrays.points, header, centre), every = Math.max(1, Math.ceil(points.length / 3 / 20000));
      const ends: number[] = [];
      const length = this.size / 60;
      for (let i = 0; i < points.length; i += 3 * every) {
        for (let k = 0; k < 3; k++) ends.push(points[i + k]);
        for (let k = 0; k < 3; k++) ends.push(points[i + k] + ((arrays.normals[i + k] - 128) / 127) * length);
      }
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(ends), 3));
      const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0x0a7d5a }));
      lines.frustumCulled = false;
      this.addLayer("normals", [lines], false);
    }
    const kinds: [Layer, string, number, number, boolean][] = [
      ["labelBorders", "label_borders", 0x101014, 1.6, true], ["regionBorders", "region_borders", 0x101014, 1.6, false],
      ["interpolated", "interpolated", 0x004c99, 1.6, false],
    ];
    for (const [layer, name, colour, width, visible] of kinds) {
      const level = segmentsOf(arrays, name, header, centre, false), hole = segmentsOf(arrays, name, header, centre, true);
      const objects: THREE.Object3D[] = [];
      if (level.length) objects.push(this.lines(level, colour, width));
      if (hole.length) objects.push(this.lines(hole, 0x7a28dc, 2.6));
      this.addLayer(layer, objects, visible);
    }
    if (arrays.rims?.length) this.addLayer("rims", [this.lines(positionsOf(arrays.rims, header, centre), 0x7a28dc, 1.6)], false);
  }

  private listen() {
    const down = new Map<number, { x: number; y: number }>();
    let travelled = 0, panning = false;
    const at = (event: PointerEvent | WheelEvent) => {
      const box = this.canvas.getBoundingClientRect();
      return { x: event.clientX - box.left, y: event.clientY - box.top };
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      down.set(event.pointerId, at(event));
      if (down.size === 1) { travelled = 0; panning = event.button !== 0 || event.shiftKey; }
      else travelled = 100; // two fingers never click
    });
    this.canvas.addEventListener("pointermove", (event) => {
      const before = down.get(event.pointerId);
      if (!before) return;
      const now = at(event), dx = now.x - before.x, dy = now.y - before.y;
      travelled += Math.abs(dx) + Math.abs(dy);
      if (down.size === 2) {
        const other = [...down].find(([id]) => id !== event.pointerId)![1];
        const old = Math.hypot(before.x - other.x, before.y - other.y), gap = Math.hypot(now.x - other.x, now.y - other.y);
        if (old > 0 && gap > 0) this.zoom(old / gap, (now.x + other.x) / 2, (now.y + other.y) / 2);
        this.pan(dx / 2, dy / 2);
      } else if (travelled > 3) {
        if (panning) this.pan(dx, dy);
        else this.rotate(dx * 0.008, dy * 0.008);
      }
      down.set(event.pointerId, now);
    });
    const up = (event: PointerEvent) => {
      if (!down.delete(event.pointerId)) return;
      if (event.type === "pointerup" && travelled <= 3 && !panning) {
        const { x, y } = at(event);
        this.onClick(this.pick(x, y));
      }
    };
    this.canvas.addEventListener("pointerup", up);
    this.canvas.addEventListener("pointercancel", up);
    this.canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const { x, y } = at(event);
      this.zoom(Math.exp(event.deltaY * (event.deltaMode ? 0.03 : 0.001)), x, y);
    }, { passive: false });
    this.canvas.addEventListener("keydown", (event) => {
      const step = 0.1, names = ["best", "front", "back", "left", "right", "top", "bottom"];
      const keys: Record<string, () => void> = {
        ArrowLeft: () => (event.shiftKey ? this.pan(-30, 0) : this.rotate(-step, 0)),
        ArrowRight: () => (event.shiftKey ? this.pan(30, 0) : this.rotate(step, 0)),
        ArrowUp: () => (event.shiftKey ? this.pan(0, -30) : this.rotate(0, -step)),
        ArrowDown: () => (event.shiftKey ? this.pan(0, 30) : this.rotate(0, step)),
        "+": () => this.zoom(0.8), "-": () => this.zoom(1.25),
        l: () => this.setLight(this.lightAngle[0] + 15, this.lightAngle[1]),
        L: () => this.setLight(this.lightAngle[0] - 15, this.lightAngle[1]),
        Escape: () => this.onClick(null),
      };
      const action = keys[event.key] ?? (names[Number(event.key)] !== undefined && event.key !== " " ? () => this.goTo(names[Number(event.key)]) : null);
      if (!action) return;
      event.preventDefault();
      action();
    });
  }
}
