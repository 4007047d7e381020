// One panel's mesh on its canvas. Behind stage.js, camera.js and painter.js.

/** How many pixels a good picture has for one of the page, along each side. */
const finest = () => Math.max(2, 1.5 * Math.min(window.devicePixelRatio, 2));

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

/** Four entries a vertex of three: WebGL likes each on a border of four bytes. */
function padded(V) {
  const made = new V.constructor((V.length / 3) * 4);
  for (let k = 0, to = 0; k < V.length; to++) for (let i = 0; i < 3; i++) made[to++] = V[k++];
  return made;
}

/** The largest size of some numbers. */
function largest(numbers) {
  let size = 0;
  for (const x of numbers) size = Math.max(size, x, -x);
  return size;
}

/** Places on the scale as WebGL takes them, from 0 to 1, and whether there is one. */
function valuePairs(parts) {
  const made = new Uint8Array(2 * parts.length);
  for (const [k, part] of parts.entries()) {
    made[2 * k] = part === 255 ? 0 : Math.round((part * 255) / 254);
    made[2 * k + 1] = part === 255 ? 0 : 255;
  }
  return made;
}

const same = (one, other, ...names) => names.every((name) => String(one[name]) === String(other[name]));

/** One panel's mesh, and the canvas that shows it. */
class MeshCanvas {
  constructor(stage) {
    this.stage = stage;
    this.mesh = null;
    this.buffers = {};
    this.age = 0;
    this.stale = { faces: true, positions: true, values: true, colours: true };
    this.density = 0; // pixels drawn for one of the page, in what is shown now
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
    // Not before there is something to draw: a saved notebook shows its still until then.
    this.canvas ??= element("canvas", "", this.stage);
    const { V, F, parts, edges } = mesh;
    mesh.onFaces = Boolean(parts && 3 * parts.length === F.length && 3 * parts.length !== V.length);
    // Corners that share a vertex are told apart where each face has a value or lines of its own.
    mesh.apart = mesh.onFaces || edges;
    const faces = !old || old.F !== F || old.apart !== mesh.apart;
    const { stale } = this;
    stale.faces ||= faces;
    stale.positions ||= faces || old.V !== V || old.smooth !== mesh.smooth;
    stale.values ||= faces || old.parts !== parts;
    stale.colours ||= faces || !same(old, mesh, "stops");
    this.mesh = mesh;
    this.changed ||= Object.values(stale).some(Boolean) || !same(old, mesh, "color", "units", "edges");
  }

  /** Fill a buffer: that of faces, or of an attribute at a location of the program. */
  fill(name, entries, location, width, kind, normalised) {
    const { gl } = Painter.one;
    const target = location === undefined ? gl.ELEMENT_ARRAY_BUFFER : gl.ARRAY_BUFFER;
    const old = this.buffers[name];
    const { buffer, size } = old ?? { buffer: gl.createBuffer(), size: -1 };
    gl.bindBuffer(target, buffer);
    if (size === entries.byteLength) gl.bufferSubData(target, 0, entries);
    else gl.bufferData(target, entries, gl.DYNAMIC_DRAW);
    this.buffers[name] = { buffer, size: entries.byteLength };
    if (location === undefined) return;
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, width, kind, normalised, 0, 0);
  }

  upload() {
    const { gl, age } = Painter.one;
    const { stale } = this;
    if (this.age !== age) {
      this.buffers = {};
      this.colours = null;
      this.vertices = gl.createVertexArray();
      for (const name in stale) stale[name] = true;
      this.age = age;
    }
    gl.bindVertexArray(this.vertices);
    const { V, F, parts, smooth, stops, apart, onFaces } = this.mesh;
    const corners = (entries, width) =>
      apart ? spread(entries, F, width, new entries.constructor(width * F.length)) : entries;
    if (stale.faces && !apart) this.fill("faces", F);
    if (stale.positions) {
      this.size = Math.sqrt(3) * largest(V); // no corner is farther from the origin
      const kind = V instanceof Int16Array ? gl.SHORT : gl.FLOAT;
      this.fill("positions", corners(padded(V), 4), 0, 4, kind, false);
      if (smooth) this.fill("normals", corners(vertexNormals(V, F), 3), 2, 3, gl.BYTE, true);
      else gl.disableVertexAttribArray(2);
    }
    if (!parts) gl.disableVertexAttribArray(1); // what is left there may be of fewer corners
    else if (stale.values) {
      const each = onFaces ? Uint8Array.from(F, (_, k) => parts[(k / 3) | 0]) : corners(parts, 1);
      this.fill("values", valuePairs(each), 1, 2, gl.UNSIGNED_BYTE, true);
    }
    if (stale.colours && stops) {
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
    for (const name in stale) stale[name] = false;
  }

  /** Whether what is shown is not what there is to be seen, or only at a lower density. */
  lacks(camera, density) {
    const { stage, mesh, seen } = this;
    if (!mesh || !seen || Painter.one.gl.isContextLost()) return false;
    const shape = `${stage.clientWidth}/${stage.clientHeight}`;
    if (!stage.clientWidth || !stage.clientHeight) return false;
    const current = !this.changed && this.camera === camera && this.age === Painter.one.age;
    return !current || this.shape !== shape || this.density < density;
  }

  draw(camera, density) {
    const { stage, mesh } = this;
    const painter = Painter.one;
    const width = Math.round(stage.clientWidth * density);
    const height = Math.round(stage.clientHeight * density);
    const well = density === finest();
    const defined = { SMOOTH: mesh.smooth, EDGES: mesh.edges, VALUES: mesh.parts && mesh.stops };
    const way = Object.keys(defined).filter((name) => defined[name]);
    const cold = !painter.programs.has(way.join());
    const at = painter.program(way);
    this.upload();
    const paint = () => {
      painter.clear(width, height);
      this.paint(at, camera, width / height);
    };
    if (well && cold) paint(); // what is made on the way is not on the clock
    if (well) painter.finish();
    const began = performance.now();
    paint();
    if (well) {
      painter.finish();
      this.cost = performance.now() - began;
    }
    this.context ??= this.canvas.getContext("bitmaprenderer");
    this.context.transferFromImageBitmap(painter.canvas.transferToImageBitmap());
    this.changed = false;
    Object.assign(this, { camera, density, shape: `${stage.clientWidth}/${stage.clientHeight}` });
    this.drawn = performance.now();
    stage.dataset.draft = !well;
    stage.dataset.frame = Number(stage.dataset.frame) + 1;
  }

  paint(at, camera, shape) {
    const { mesh } = this;
    const { gl } = Painter.one;
    const size = this.size * mesh.units;
    const away = Math.hypot(...camera.position);
    const far = away + size;
    gl.uniformMatrix4fv(at.view, false, camera.matrix);
    gl.uniform3f(at.lens, LENS * shape, LENS, mesh.units);
    gl.uniform2f(at.depths, Math.max(away - size, far / 1000), far);
    gl.uniform3fv(at.plain, mesh.color);
    gl.bindTexture(gl.TEXTURE_2D, this.colours ?? null);
    const { length } = mesh.F;
    if (mesh.apart) gl.drawArrays(gl.TRIANGLES, 0, length);
    else {
      const kind = mesh.F instanceof Uint16Array ? gl.UNSIGNED_SHORT : gl.UNSIGNED_INT;
      gl.drawElements(gl.TRIANGLES, length, kind, 0);
    }
  }

  release() {
    const { gl, age } = Painter.one;
    if (this.age !== age) return;
    for (const { buffer } of Object.values(this.buffers)) gl.deleteBuffer(buffer);
    gl.deleteTexture(this.colours ?? null);
    gl.deleteVertexArray(this.vertices);
  }
}
