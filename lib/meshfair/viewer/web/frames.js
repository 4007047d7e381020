// Shows the frames that Python sends, and sends back what the pointer does. Behind stage.js.
//
// To Python:  layout  panel size, pixel ratio and background; asks for all panels
//             move    the camera's change since the last move, while none is unanswered
//             reset   back to the first camera
//             shown   the frame is on the screen: the next may come
//             rest    nothing moves any more: good frames, please
// To here:    frame   pictures of some panels, their titles and the colour bar
//             error   a line to show

const RETRY = 3000; // ms until a first frame that did not come is asked for again
const REST = 250; // ms without a new frame until good frames are asked for
const PATIENCE = 4000; // ms until an answer is missed
const TOUCHES = ["pointerdown", "keydown", "change"];
const GONE =
  "Python does not answer. If the kernel was restarted, run this cell again; if it is busy, wait.";

/** The colour on which the notebook draws, each channel from 0 to 1. */
function background(node) {
  const channels = getComputedStyle(node).backgroundColor.match(/[\d.]+/g) ?? [255, 255, 255];
  return channels.slice(0, 3).map((channel) => channel / 255);
}

function pause(milliseconds) {
  return new Promise((resolve) => setTimeout(resolve, milliseconds));
}

/** Gathers the camera's changes; at most one message to Python is unanswered. */
class Moves {
  constructor(model) {
    this.model = model;
    this.clear();
    this.unanswered = -Infinity; // when the last move was sent, until it is answered
  }

  clear() {
    this.gathered = { kind: "move", yaw: 0, pitch: 0, pan: [0, 0], zoom: 1 };
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

function render({ model, el }) {
  const moves = new Moves(model);
  const reset = () => model.send({ kind: "reset" });

  const { panels, button, bar, error } = frameOf(el, model.get("count"));
  for (const [panel, shown] of panels.entries()) {
    shown.picture = element("img", "", shown.stage);
    shown.picture.draggable = false;
    shown.picture.alt = "";
    const click = (x, y) => model.send({ kind: "click", panel, x, y });
    shown.release = control(shown.stage, moves, reset, click);
  }
  button.addEventListener("click", reset);

  const pulse = new Pulse(model, el, (text) => {
    error.textContent = text;
    el.classList.toggle("silent", text !== "");
  });

  let resting = 0;
  const show = async (message, buffers) => {
    error.textContent = "";
    bar.show(message.bar);
    await Promise.all(
      message.panels.map(async (k, i) => {
        const { stage, picture } = panels[k];
        const old = picture.src;
        picture.src = URL.createObjectURL(new Blob([buffers[i]], { type: "image/jpeg" }));
        // A picture that is out of sight, or replaced by a newer one, may never be decoded.
        await Promise.race([picture.decode().catch(() => {}), pause(200)]);
        if (old) URL.revokeObjectURL(old);
        entitle(panels[k], message.titles[i]);
        stage.classList.add("drawn"); // the still in the notebook goes: see saved.py
        stage.dataset.frame = message.number;
        stage.dataset.draft = message.draft;
      }),
    );
  };
  const receive = async (message, buffers) => {
    if (message.kind === "error") {
      error.textContent = message.text;
      panels[0].stage.classList.add("drawn");
      moves.answered();
      return;
    }
    pulse.answered();
    if (message.kind !== "frame") return;
    clearInterval(asking);
    try {
      await show(message, buffers);
    } catch (failure) {
      error.textContent = String(failure);
    } finally {
      // Whatever became of this frame: without an answer the next would not be sent.
      model.send({ kind: "shown" });
      moves.answered();
    }
    // Good frames of other panels may come meanwhile: they do not put the rest off.
    if (message.draft) {
      clearTimeout(resting);
      resting = setTimeout(() => model.send({ kind: "rest" }), REST);
    }
  };
  model.on("msg:custom", receive);

  let known = "";
  const layout = () => {
    const { stage } = panels[0];
    const [width, height] = [stage.clientWidth, stage.clientHeight];
    if (!width || !height) return; // not on the page, or on a hidden tab
    const ratio = Math.min(window.devicePixelRatio, 2);
    const message = { kind: "layout", width, height, ratio, background: background(stage) };
    if (JSON.stringify(message) === known) return;
    known = JSON.stringify(message);
    model.send(message);
  };
  // Nothing answers while the kernel starts, or is busy with a long cell.
  const asking = setInterval(() => {
    known = "";
    layout();
  }, RETRY);
  const size = new ResizeObserver(layout);
  size.observe(panels[0].stage);
  // Both JupyterLab and VS Code set their theme as an attribute of the body.
  const theme = new MutationObserver(() => setTimeout(layout, 100));
  theme.observe(document.body, { attributes: true });

  return () => {
    clearInterval(asking);
    clearTimeout(resting);
    pulse.stop();
    size.disconnect();
    theme.disconnect();
    model.off("msg:custom", receive);
    for (const { picture, release } of panels) {
      release();
      if (picture.src) URL.revokeObjectURL(picture.src);
    }
  };
}

export default { render };
