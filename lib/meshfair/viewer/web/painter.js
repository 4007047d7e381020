// Draws triangle meshes by WebGL 2: one context for a whole page. Behind camera.js.

const SHARED = Symbol.for("meshfair painter");
const LINES = [0.1, 0.15, 0.25]; // the colour of edges

// What stands in capitals is defined, or not, for each way to draw: see Painter.program.
const VERTEX = `
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
#ifdef SMOOTH
  turned = mat3(view) * normal;
#endif
#ifdef EDGES
  int k = gl_VertexID % 3;
  corner = vec3(k == 0, k == 1, k == 2);
#endif
  part = value;
  float near = depths.x, far = depths.y;
  gl_Position = vec4(
    seen.xy / lens.xy, -((far + near) * seen.z + 2.0 * far * near) / (far - near), -seen.z);
}`;

// The light is that of polyscope's clay, which its pictures have: what a white and a black ball
// look like from each direction of the normal, as polynomials of degree 2.
const FRAGMENT = `
in vec3 place;
in vec3 turned;
in vec3 corner;
in vec2 part;
uniform sampler2D colours;
uniform vec3 plain; // of what has no value
out vec4 pixel;
void main() {
#ifdef SMOOTH
  vec3 n = normalize(turned);
#else
  vec3 n = normalize(cross(dFdx(place), dFdy(place)));
#endif
  if (dot(n, place) > 0.0) n = -n;
  vec3 base = plain;
#ifdef VALUES
  base = mix(plain, texture(colours, vec2((254.0 * part.x + 0.5) / 255.0, 0.5)).rgb, part.y);
#endif
  float lit = 0.383 + 0.251 * n.z + 0.369 * n.y + 0.032 * n.y * n.z + 0.113 * n.y * n.y - 0.173 * n.x
    - 0.087 * n.x * n.z - 0.047 * n.x * n.y - 0.109 * n.x * n.x;
  float shine = 0.015 + 0.014 * n.z - 0.007 * n.y + 0.061 * n.y * n.z + 0.016 * n.y * n.y
    + 0.016 * n.x - 0.043 * n.x * n.z - 0.007 * n.x * n.y - 0.031 * n.x * n.x;
  vec3 colour = pow(max(base * lit + shine, 0.0), vec3(1.0 / 2.2));
#ifdef EDGES
  vec3 edge = corner / fwidth(corner);
  colour = mix(vec3(${LINES}), colour, smoothstep(0.3, 1.1, min(min(edge.x, edge.y), edge.z)));
#endif
  pixel = vec4(colour, 1.0);
}`;

/** A colour map with 255 entries, from its stops. */
function ramp(stops) {
  const colours = stops.map((hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16)));
  const texels = new Uint8Array(255 * 4).fill(255);
  for (let k = 0; k < 255; k++) {
    const at = (k / 254) * (stops.length - 1);
    const low = Math.min(Math.floor(at), stops.length - 2);
    const share = at - low;
    colours[low].forEach((c, i) => (texels[4 * k + i] = c + share * (colours[low + 1][i] - c)));
  }
  return texels;
}

/** The one WebGL context of a page: browsers have few, and a notebook many meshes. */
class Painter {
  constructor() {
    this.canvas = globalThis.OffscreenCanvas && new OffscreenCanvas(1, 1);
    // Without antialiasing of its own: fine pictures are drawn larger than they are shown.
    this.gl = this.canvas?.getContext("webgl2", { antialias: false, alpha: true });
    if (!this.gl) throw new Error("This browser has no WebGL 2.");
    this.canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    this.canvas.addEventListener("webglcontextrestored", () => this.begin());
    this.age = 0; // how often the context was made: what an older one held is gone
    this.begin();
  }

  /** That of the page: every widget runs this script for itself. */
  static get one() {
    return (globalThis[SHARED] ??= new Painter());
  }

  begin() {
    const { gl } = this;
    gl.enable(gl.DEPTH_TEST);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    this.programs = new Map(); // by what they define
    this.fence = null;
    this.age += 1;
  }

  /** The program for a way to draw, such as ["SMOOTH", "VALUES"]; from here on it is in use. */
  program(defined) {
    const { gl } = this;
    const key = defined.join();
    let made = this.programs.get(key);
    if (!made) {
      const head = ["#version 300 es", "precision highp float;"];
      const text = [...head, ...defined.map((name) => `#define ${name}`)].join("\n");
      const program = gl.createProgram();
      for (const [kind, body] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, text + body);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
      }
      gl.linkProgram(program);
      if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
        throw new Error(`WebGL: ${gl.getProgramInfoLog(program)}`);
      }
      const names = ["view", "lens", "depths", "plain"];
      const at = names.map((name) => [name, gl.getUniformLocation(program, name)]);
      made = { program, at: Object.fromEntries(at) };
      this.programs.set(key, made);
    }
    gl.useProgram(made.program);
    return made.at;
  }

  /** Make room for a picture, and clear it. */
  clear(width, height) {
    const { gl, canvas } = this;
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  /** Whether the last pictures are still being drawn. */
  get busy() {
    const { gl, fence } = this;
    if (!fence || gl.isContextLost()) return false;
    if (gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.UNSIGNALED) return true;
    gl.deleteSync(fence);
    this.fence = null;
    return false;
  }

  /** Be busy until what was asked for so far is drawn. */
  begun() {
    const { gl } = this;
    if (this.fence) gl.deleteSync(this.fence);
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
  }

  /** Wait until all is drawn. */
  finish() {
    const { gl } = this;
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }
}
