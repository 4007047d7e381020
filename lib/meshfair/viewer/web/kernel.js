// What a view in the page says to Python, whichever of them draws. Behind stage.js.

const RETRY = 3000; // ms until what was not answered is said again
const PATIENCE = 4000; // ms until an answer is missed
const TOUCHES = ["pointerdown", "keydown", "change"];
const GONE =
  "Python does not answer. If the kernel was restarted, run this cell again; if it is busy, wait.";

/** Gathers the camera's changes; at most one message to Python is unanswered. */
class Moves {
  constructor(model, by) {
    Object.assign(this, { model, by });
    this.clear();
    this.unanswered = -Infinity; // when the last move was sent, until it is answered
  }

  clear() {
    this.gathered = { kind: "move", by: this.by, yaw: 0, pitch: 0, pan: [0, 0], zoom: 1 };
    this.empty = true;
  }

  add({ yaw = 0, pitch = 0, pan = [0, 0], zoom = 1 }) {
    this.gathered.yaw += yaw;
    this.gathered.pitch += pitch;
    this.gathered.pan[0] += pan[0];
    this.gathered.pan[1] += pan[1];
    this.gathered.zoom *= zoom;
    this.empty = false;
    this.send();
  }

  send() {
    // An answer that never comes, because the kernel was restarted, must not block for ever.
    if (this.empty || performance.now() - this.unanswered < 2000) return;
    this.unanswered = performance.now();
    this.model.send(this.gathered);
    this.clear();
  }

  answered() {
    this.unanswered = -Infinity;
    this.send();
  }
}

/** Notices that Python answers nothing any more: its kernel was restarted, has gone, or is busy. */
class Pulse {
  constructor(model, el, tell) {
    this.model = model;
    this.tell = tell;
    this.timer = 0;
    this.silent = false;
    // Whatever is done to the view, or to the sliders of the explorer that it is part of.
    this.touched = (event) => {
      const whole = el.closest(".meshfair-explorer") ?? el;
      if (whole.contains(event.target)) this.ask();
    };
    for (const kind of TOUCHES) document.addEventListener(kind, this.touched, true);
  }

  ask() {
    if (this.timer) return;
    this.timer = setTimeout(() => {
      this.timer = 0;
      this.silent = true;
      this.tell(GONE);
    }, PATIENCE);
    try {
      this.model.send({ kind: "ping" });
    } catch {
      // Without a kernel nothing can be sent; the timer tells.
    }
  }

  answered() {
    clearTimeout(this.timer);
    this.timer = 0;
    if (this.silent) this.tell("");
    this.silent = false;
  }

  stop() {
    clearTimeout(this.timer);
    for (const kind of TOUCHES) document.removeEventListener(kind, this.touched, true);
  }
}

/** Says how large the panels are: when that changes, and until something has come back. */
class Layout {
  constructor(model, stage, more) {
    Object.assign(this, { model, stage, more, known: "" });
    // Nothing answers while the kernel starts, or is busy with a long cell.
    this.asking = setInterval(() => {
      this.known = "";
      this.tell();
    }, RETRY);
    this.size = new ResizeObserver(() => this.tell());
    this.size.observe(stage);
  }

  tell() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return; // not on the page, or on a hidden tab
    const message = { kind: "layout", width, height, ...this.more() };
    const text = JSON.stringify(message);
    if (text === this.known) return;
    this.known = text;
    this.model.send(message);
  }

  answered() {
    clearInterval(this.asking);
  }

  stop() {
    clearInterval(this.asking);
    this.size.disconnect();
  }
}
