// Meshes side by side, each on a canvas of its own. Behind stage.js, camera.js, painter.js
// and picture.js.
//
// What moves is drawn as coarsely as it must be to follow the hand, by the time that good pictures
// took; when it has come to rest, well.

const BUDGET = 12; // ms for a picture of all panels while something moves
const COARSEST = 0.5; // pixels drawn for a pixel of the page, along each side
const REST = 250; // ms without a change until pictures are drawn well
const SIGHT = "200px"; // how far out of sight a panel is drawn

/** Meshes side by side, seen by one camera: all of a view that draws in the page. */
class MeshView {
  constructor(el, count, { click = () => {}, moved = () => {}, reset = () => this.reset() } = {}) {
    Painter.one; // says here that there is no WebGL
    const { panels, button, bar, error } = frameOf(el, count);
    Object.assign(this, { panels, bar, error, moved });
    this.cameras = null; // the first one, by the shape of the panels
    this.camera = null;
    this.up = [0, 0, 1];
    this.planned = 0;
    this.resting = 0;
    this.sight = new IntersectionObserver(
      (entries) => {
        for (const { target, isIntersecting } of entries) {
          const { picture } = panels.find(({ stage }) => stage === target);
          picture.seen = isIntersecting;
        }
        this.plan();
      },
      { rootMargin: SIGHT },
    );
    this.resized = new ResizeObserver(() => {
      if (this.home && !this.touched) this.camera = this.home;
      this.plan();
    });
    for (const [k, panel] of panels.entries()) {
      panel.picture = new MeshCanvas(panel.stage);
      panel.release = control(panel.stage, this, reset, (x, y) => click(k, x, y));
      this.resized.observe(panel.stage);
      this.sight.observe(panel.stage);
    }
    button.addEventListener("click", reset);
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

  /** Look from somewhere: nine numbers, and what stays upright. */
  look(numbers, up) {
    Object.assign(this, { camera: Camera.of(numbers), up });
    this.plan();
  }

  add(move) {
    if (!this.camera) return;
    const { yaw = 0, pitch = 0, pan = [0, 0], zoom = 1 } = move;
    this.touched = true;
    this.camera = this.camera.orbit(yaw, pitch, this.up).pan(...pan).zoom(zoom);
    this.moved(move);
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

  /** Draw in the next animation frame, or in the first one for which the last are ready. */
  plan() {
    this.planned ||= requestAnimationFrame(() => {
      this.planned = 0;
      // A queue of pictures would be shown long after the moves.
      if (Painter.one.busy) this.plan();
      else this.draw();
    });
  }

  /** The pictures that lack something, at some density. */
  lacking(density) {
    return this.panels.map(({ picture }) => picture).filter((p) => p.lacks(this.camera, density));
  }

  draw() {
    this.camera ??= this.home;
    if (!this.camera) return;
    const lacking = this.lacking(0);
    const cost = this.panels.reduce((sum, { picture }) => sum + (picture.cost ?? 0), 0);
    const density = Math.max(COARSEST, finest() * Math.min(1, Math.sqrt(BUDGET / cost)));
    // Too many for one frame come one after the other.
    const pictures = lacking.length > 1 && density < 1 ? [this.first(lacking)] : lacking;
    // Nothing has moved yet where there is no picture.
    for (const picture of pictures) picture.draw(this.camera, picture.cost ? density : finest());
    this.latest = pictures.at(-1);
    if (pictures.length) Painter.one.begun();
    if (pictures.length < lacking.length) this.plan();
    clearTimeout(this.resting);
    if (this.lacking(finest()).length) this.resting = setTimeout(() => this.improve(), REST);
  }

  /** The picture at hand, and between two of it the others in turn. */
  first(pictures) {
    const atHand = pictures.find((picture) => picture.stage === document.activeElement);
    if (atHand && atHand !== this.latest) return atHand;
    return pictures.reduce((one, other) => (other.drawn < one.drawn ? other : one));
  }

  /** Draw one picture after the other well: moves come between. */
  improve() {
    this.planned ||= requestAnimationFrame(() => {
      this.planned = 0;
      const [first, ...others] = this.lacking(finest());
      first?.draw(this.camera, finest());
      if (others.length) this.resting = setTimeout(() => this.improve(), 0);
    });
  }

  release() {
    cancelAnimationFrame(this.planned);
    clearTimeout(this.resting);
    this.resized.disconnect();
    this.sight.disconnect();
    Painter.one.canvas.removeEventListener("webglcontextrestored", this.painted);
    for (const { picture, release } of this.panels) {
      release();
      picture.release();
    }
  }
}
