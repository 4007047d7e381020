// Where a picture is taken from: what camera.py does, in the page.

const LENS = Math.tan((12.5 * Math.PI) / 180); // half of the field of view, 25 degrees
const POLE = (3 * Math.PI) / 180; // how close an orbit comes to looking straight down

const minus = (a, b) => a.map((x, i) => x - b[i]);
const plus = (a, b, factor = 1) => a.map((x, i) => x + factor * b[i]);
const times = (a, factor) => a.map((x) => factor * x);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const unit = (a) => times(a, 1 / Math.hypot(...a));
const clamp = (x, low, high) => Math.max(low, Math.min(high, x));

class Camera {
  constructor(position, target, up) {
    Object.assign(this, { position, target, up });
  }

  /** One of nine numbers, as Python sends it. */
  static of(numbers) {
    return new Camera(numbers.slice(0, 3), numbers.slice(3, 6), numbers.slice(6, 9));
  }

  get numbers() {
    return [...this.position, ...this.target, ...this.up];
  }

  get distance() {
    return Math.hypot(...minus(this.position, this.target));
  }

  /** To the right, upwards and backwards. */
  get axes() {
    const back = unit(minus(this.position, this.target));
    const right = unit(cross(this.up, back));
    return [right, cross(back, right), back];
  }

  /** Walk around the target, as on a turntable whose axis stays upright. */
  orbit(yaw, pitch, axis) {
    const { distance } = this;
    let back = unit(minus(this.position, this.target));
    const polar = clamp(Math.acos(clamp(dot(back, axis), -1, 1)) - pitch, POLE, Math.PI - POLE);
    const across = cross(axis, back);
    // Straight above or below, the picture's own right is as good as any.
    const right = Math.hypot(...across) < 1e-9 ? this.axes[0] : unit(across);
    const front = plus(times(unit(cross(right, axis)), Math.cos(yaw)), right, Math.sin(yaw));
    back = plus(times(axis, Math.cos(polar)), front, Math.sin(polar));
    const up = unit(plus(axis, back, -dot(axis, back)));
    return new Camera(plus(this.target, back, distance), this.target, up);
  }

  /** Slide sideways and upwards, by parts of the picture's height. */
  pan(x, y) {
    const [right, up] = this.axes;
    const height = 2 * this.distance * LENS;
    const step = plus(times(right, height * x), up, height * y);
    return new Camera(plus(this.position, step), plus(this.target, step), this.up);
  }

  /** Go to some times the distance from the target. */
  zoom(factor) {
    const offset = minus(this.position, this.target);
    return new Camera(plus(this.target, offset, factor), this.target, this.up);
  }

  /** See as much of what another camera sees now as this one saw of what it saw before. */
  follow(before, after) {
    const size = after.distance / before.distance;
    const moved = (point) => plus(after.target, minus(point, before.target), size);
    return new Camera(moved(this.position), moved(this.target), this.up);
  }

  /** From the page's units to the camera's, as WebGL takes a matrix: column by column. */
  get matrix() {
    const { axes } = this;
    const columns = [0, 1, 2].map((i) => [...axes.map((axis) => axis[i]), 0]);
    return [...columns.flat(), ...axes.map((axis) => -dot(axis, this.position)), 1];
  }
}
