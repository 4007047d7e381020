// Draws triangle meshes by WebGL 2: one context for a whole page, one canvas for each panel.
// Behind stage.js and camera.js.

const LINES = [0.1, 0.15, 0.25]; // the colour of edges

const VERTEX = `#version 300 es
precision highp float;
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 value;
layout(location = 2) in vec3 normal;
uniform mat4 view;
uniform vec3 lens; // half width and half height of the picture at distance 1, and the units
uniform vec2 depths;
out vec3 place;
out vec3 turned;
out vec3 corner;
out vec2 part;
void main() {
  vec4 seen = view * vec4(lens.z * position, 1.0);
  place = seen.xyz;
  turned = mat3(view) * normal;
  int k = gl_VertexID % 3;
  corner = vec3(k == 0, k == 1, k == 2);
  part = value;
  float near = depths.x, far = depths.y;
  gl_Position = vec4(
    seen.xy / lens.xy, -((far + near) * seen.z + 2.0 * far * near) / (far - near), -seen.z);
}`;

// The light is that of polyscope's clay, which its pictures have: what a white and a black ball
// look like from each direction of the normal, as polynomials of degree 2.
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 place;
in vec3 turned;
in vec3 corner;
in vec2 part;
uniform sampler2D colours;
uniform vec3 plain; // of what has no value
uniform bvec3 look; // smooth, edges, values
out vec4 pixel;
void main() {
  vec3 n = look.x ? turned : cross(dFdx(place), dFdy(place));
  n = normalize(n);
  if (dot(n, place) > 0.0) n = -n;
  vec3 base = plain;
  if (look.z) base = mix(plain, texture(colours, vec2((254.0 * part.x + 0.5) / 255.0, 0.5)).rgb, part.y);
  float lit = 0.383 + 0.251 * n.z + 0.369 * n.y + 0.032 * n.y * n.z + 0.113 * n.y * n.y - 0.173 * n.x
    - 0.087 * n.x * n.z - 0.047 * n.x * n.y - 0.109 * n.x * n.x;
  float shine = 0.015 + 0.014 * n.z - 0.007 * n.y + 0.061 * n.y * n.z + 0.016 * n.y * n.y
    + 0.016 * n.x - 0.043 * n.x * n.z - 0.007 * n.x * n.y - 0.031 * n.x * n.x;
  vec3 colour = pow(max(base * lit + shine, 0.0), vec3(1.0 / 2.2));
  if (look.y) {
    vec3 edge = corner / fwidth(corner);
    colour = mix(vec3(${LINES}), colour, smoothstep(0.3, 1.1, min(min(edge.x, edge.y), edge.z)));
  }
  pixel = vec4(colour, 1.0);
}`;

function channels(hex) {
  return [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
}

/** A colour map with 255 entries, from its stops. */
function ramp(stops) {
  const colours = stops.map(channels);
  const texels = new Uint8Array(255 * 4).fill(255);
  for (let k = 0; k < 255; k++) {
    const at = (k / 254) * (stops.length - 1);
    const low = Math.min(Math.floor(at), stops.length - 2);
    const share = at - low;
    colours[low].forEach((c, i) => (texels[4 * k + i] = c + share * (colours[low + 1][i] - c)));
  }
  return texels;
}

/** The entries of each face's three corners, one after the other. */
function spread(entries, F, width, made) {
  for (let k = 0, to = 0; k < F.length; k++) {
    for (let i = 0, from = width * F[k]; i < width; i++) made[to++] = entries[from++];
  }
  return made;
}

/** Unit normals of the vertices, as signed bytes. */
function vertexNormals(V, F) {
  const sums = new Float64Array(V.length);
  const at = (k) => V.subarray(3 * k, 3 * k + 3);
  for (let k = 0; k < F.length; k += 3) {
    const a = at(F[k]);
    const [u, w] = [at(F[k + 1]), at(F[k + 2])].map((b) => [b[0] - a[0], b[1] - a[1], b[2] - a[2]]);
    const n = cross(u, w); // as long as twice the area: large faces count more
    for (const corner of [F[k], F[k + 1], F[k + 2]]) n.forEach((x, i) => (sums[3 * corner + i] += x));
  }
  const made = new Int8Array(V.length);
  for (let k = 0; k < V.length; k += 3) {
    const length = Math.hypot(sums[k], sums[k + 1], sums[k + 2]) || 1;
    for (let i = 0; i < 3; i++) made[k + i] = (127 * sums[k + i]) / length;
  }
  return made;
}

/** The one WebGL context of a page: browsers have few, and a notebook many meshes. */
class Painter {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.canvas.width = this.canvas.height = 1;
    this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    this.canvas.addEventListener("webglcontextrestored", () => this.begin());
    const options = { antialias: true, alpha: true, preserveDrawingBuffer: false };
    this.gl = this.canvas.getContext("webgl2", options);
    if (!this.gl) throw new Error("This browser has no WebGL 2.");
    this.age = 0; // how often the context was made: what an older one held is gone
    this.begin();
  }

  static get one() {
    Painter.made ??= new Painter();
    return Painter.made;
  }

  begin() {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      throw new Error(`WebGL: ${gl.getProgramInfoLog(program)}`);
    }
    gl.useProgram(program);
    gl.enable(gl.DEPTH_TEST);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const names = ["view", "lens", "depths", "plain", "look"];
    this.at = Object.fromEntries(names.map((name) => [name, gl.getUniformLocation(program, name)]));
    this.age += 1;
  }
}

/** One panel's mesh, and the canvas that shows it. */
class MeshCanvas {
  constructor(stage) {
    this.stage = stage;
    this.canvas = element("canvas", "", stage);
    this.mesh = null;
    this.age = 0;
    this.stage.dataset.frame = 0;
  }

  /**
   * Show a mesh from the next drawing on.
   *
   * V has three entries a vertex, of which `units` makes the page's; F three a face. `parts` are
   * places on the scale from 0 to 254, 255 for none, of vertices or of faces.
   */
  show(mesh) {
    const old = this.mesh;
    this.mesh = mesh;
    this.stale = {
      positions: this.stale?.positions || !old || old.V !== mesh.V || old.F !== mesh.F,
      values: this.stale?.values || !old || old.parts !== mesh.parts || old.F !== mesh.F,
      colours: this.stale?.colours || !old || String(old.stops) !== String(mesh.stops),
    };
    const look = ({ smooth, edges, color, units }) => String([smooth, edges, color, units]);
    this.changed ||= Object.values(this.stale).some(Boolean) || look(old) !== look(mesh);
  }

  fill(name, location, width, kind, normalised, entries) {
    const { gl } = Painter.one;
    this[name] ??= gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this[name]);
    gl.bufferData(gl.ARRAY_BUFFER, entries, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, width, kind, normalised, 0, 0);
  }

  upload() {
    const { gl, age } = Painter.one;
    if (this.age !== age) {
      this.places = this.values = this.normals = this.colours = null;
      this.vertices = gl.createVertexArray();
      this.stale = { positions: true, values: true, colours: true };
      this.age = age;
    }
    gl.bindVertexArray(this.vertices);
    if (!this.stale) return;
    const { V, F, parts, smooth, stops } = this.mesh;
    if (this.stale.positions) {
      const whole = V instanceof Int16Array;
      // Four shorts a corner: WebGL wants each on a border of four bytes.
      const kind = whole ? gl.SHORT : gl.FLOAT;
      const made = whole ? new Int16Array(4 * F.length) : new Float32Array(4 * F.length);
      let size = 0;
      for (let k = 0; k < F.length; k++) {
        for (let i = 0; i < 3; i++) {
          const x = V[3 * F[k] + i];
          made[4 * k + i] = x;
          if (x > size) size = x;
          else if (-x > size) size = -x;
        }
      }
      this.size = Math.sqrt(3) * size; // no corner is farther from the origin
      this.fill("places", 0, 4, kind, false, made);
      if (smooth) {
        const normals = spread(vertexNormals(V, F), F, 3, new Int8Array(3 * F.length));
        this.fill("normals", 2, 3, gl.BYTE, true, normals);
      }
    }
    if (!parts) gl.disableVertexAttribArray(1); // what is left there may be of fewer corners
    else if (this.stale.values) {
      const onFaces = 3 * parts.length === F.length && 3 * parts.length !== V.length;
      const made = new Uint8Array(2 * F.length);
      for (let k = 0; k < F.length; k++) {
        const part = parts[onFaces ? (k / 3) | 0 : F[k]];
        made[2 * k] = part === 255 ? 0 : Math.round((part * 255) / 254);
        made[2 * k + 1] = part === 255 ? 0 : 255;
      }
      this.fill("values", 1, 2, gl.UNSIGNED_BYTE, true, made);
    }
    if (this.stale.colours && stops) {
      this.colours ??= gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, this.colours);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 255, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, ramp(stops));
      for (const [name, value] of [
        [gl.TEXTURE_MIN_FILTER, gl.LINEAR],
        [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
        [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE],
        [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
      ]) {
        gl.texParameteri(gl.TEXTURE_2D, name, value);
      }
    }
    this.stale = null;
  }

  draw(camera) {
    const { canvas, stage, mesh } = this;
    const painter = Painter.one;
    const { gl, at } = painter;
    const ratio = Math.min(window.devicePixelRatio, 2);
    const width = Math.round(stage.clientWidth * ratio);
    const height = Math.round(stage.clientHeight * ratio);
    if (!mesh || !width || !height || gl.isContextLost()) return;
    const sized = canvas.width === width && canvas.height === height;
    if (sized && !this.changed && this.camera === camera && this.age === painter.age) return;
    this.changed = false;
    this.camera = camera;
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    if (painter.canvas.width < width) painter.canvas.width = width;
    if (painter.canvas.height < height) painter.canvas.height = height;
    this.upload();
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const size = this.size * mesh.units;
    const away = Math.hypot(...camera.position);
    const far = away + size;
    gl.uniformMatrix4fv(at.view, false, camera.matrix);
    gl.uniform3f(at.lens, (LENS * width) / height, LENS, mesh.units);
    gl.uniform2f(at.depths, Math.max(away - size, far / 1000), far);
    gl.uniform3fv(at.plain, mesh.color);
    gl.uniform3i(at.look, mesh.smooth, mesh.edges, Boolean(mesh.parts && mesh.stops));
    gl.bindTexture(gl.TEXTURE_2D, this.colours ?? null);
    gl.drawArrays(gl.TRIANGLES, 0, mesh.F.length);
    const picture = canvas.getContext("2d");
    picture.clearRect(0, 0, width, height);
    const top = painter.canvas.height - height;
    picture.drawImage(painter.canvas, 0, top, width, height, 0, 0, width, height);
    stage.dataset.frame = Number(stage.dataset.frame) + 1;
  }

  release() {
    const { gl, age } = Painter.one;
    if (this.age !== age) return;
    for (const buffer of [this.places, this.values, this.normals]) gl.deleteBuffer(buffer ?? null);
    gl.deleteTexture(this.colours ?? null);
    gl.deleteVertexArray(this.vertices);
  }
}

/** Meshes side by side, seen by one camera: all of a view that draws in the page. */
class MeshView {
  constructor(el, count, { click = () => {}, moved = () => {}, reset = () => this.reset() } = {}) {
    Painter.one; // says here that there is no WebGL
    const { panels, button, bar } = frameOf(el, count);
    Object.assign(this, { panels, bar, moved });
    this.cameras = null; // the first one, by the shape of the panels
    this.camera = null;
    this.up = [0, 0, 1];
    this.planned = 0;
    for (const [k, panel] of panels.entries()) {
      panel.picture = new MeshCanvas(panel.stage);
      panel.release = control(panel.stage, this, reset, (x, y) => click(k, x, y));
    }
    button.addEventListener("click", reset);
    this.resized = new ResizeObserver(() => {
      if (this.home && !this.touched) this.camera = this.home;
      this.plan();
    });
    for (const { stage } of panels) this.resized.observe(stage);
    this.painted = () => this.plan();
    Painter.one.canvas.addEventListener("webglcontextrestored", this.painted);
  }

  /** The camera that fits the panels' shape, of those that there are. */
  get home() {
    const { stage } = this.panels[0];
    const shape = stage.clientWidth / stage.clientHeight;
    if (!this.cameras || !shape) return null;
    const wide = this.cameras.filter(([aspect]) => aspect <= shape).pop() ?? this.cameras[0];
    const camera = Camera.of(wide[1]);
    return camera.zoom(Math.max(1, wide[0] / shape));
  }

  /** Look at something else: nobody's turn of the meshes is undone by that. */
  aim(cameras, up) {
    const before = this.home;
    Object.assign(this, { cameras, up });
    const after = this.home;
    if (this.touched && before && after) this.camera = this.camera.follow(before, after);
    else this.camera = after;
    this.plan();
  }

  add({ yaw = 0, pitch = 0, pan = [0, 0], zoom = 1 }) {
    if (!this.camera) return;
    this.touched = true;
    this.camera = this.camera.orbit(yaw, pitch, this.up).pan(...pan).zoom(zoom);
    this.moved(this.camera);
    this.plan();
  }

  reset() {
    this.touched = false;
    this.camera = this.home;
    this.plan();
  }

  /** Show some panels' meshes and titles. */
  show(panel, mesh, title) {
    this.panels[panel].picture.show(mesh);
    entitle(this.panels[panel], title);
    this.plan();
  }

  plan() {
    this.planned ||= requestAnimationFrame(() => {
      this.planned = 0;
      this.camera ??= this.home;
      if (!this.camera) return;
      for (const { picture } of this.panels) picture.draw(this.camera);
    });
  }

  release() {
    cancelAnimationFrame(this.planned);
    this.resized.disconnect();
    Painter.one.canvas.removeEventListener("webglcontextrestored", this.painted);
    for (const { picture, release } of this.panels) {
      release();
      picture.release();
    }
  }
}
