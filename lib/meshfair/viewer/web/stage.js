// What every view has in the page: panels with captions, pointer and keys, the colour bar.

const STILL = 3; // pixels up to which a press that moves is a click
const SCROLL = 400; // ms within which a wheel goes on scrolling the page
const HINT = "drag or arrow keys: turn · shift-drag: move · wheel or + -: zoom · R: reset";

function element(name, className, parent) {
  const node = document.createElement(name);
  node.className = className;
  parent?.append(node);
  return node;
}

function distance(one, other) {
  return Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY);
}

class Bar {
  constructor(parent) {
    this.node = element("span", "bar", parent);
    this.label = element("span", "label", this.node);
    this.low = element("span", "low", this.node);
    this.colours = element("i", "", this.node);
    this.high = element("span", "high", this.node);
    this.show(null);
  }

  show(bar) {
    this.node.hidden = !bar;
    if (!bar) return;
    this.low.textContent = bar.low;
    this.high.textContent = bar.high;
    this.label.textContent = bar.label;
    this.colours.style.background = `linear-gradient(to right, ${bar.stops.join(",")})`;
  }
}

/** Turns pointer, wheel and keys on one panel into moves. */
function control(stage, moves, reset, click) {
  let last = null;
  let pressed = null; // where, until the pointer has been dragged away from there
  let scrolled = -Infinity; // when the wheel last moved the page

  stage.addEventListener("pointerdown", (event) => {
    stage.setPointerCapture(event.pointerId);
    stage.focus({ preventScroll: true });
    last = event;
    pressed = event.button === 0 && !event.shiftKey ? event : null;
    event.preventDefault();
  });
  stage.addEventListener("pointermove", (event) => {
    if (!last || event.pointerId !== last.pointerId) return;
    if (pressed && distance(event, pressed) <= STILL) return; // still a click
    pressed = null;
    const x = (event.clientX - last.clientX) / stage.clientHeight;
    const y = (event.clientY - last.clientY) / stage.clientHeight;
    last = event;
    const sliding = event.shiftKey || event.buttons & 6;
    // One height of the panel is half a turn.
    moves.add(sliding ? { pan: [-x, y] } : { yaw: -x * Math.PI, pitch: y * Math.PI });
  });
  stage.addEventListener("pointerup", (event) => {
    if (!pressed) return;
    pressed = null;
    const box = stage.getBoundingClientRect();
    const x = (2 * (event.clientX - box.left)) / box.width - 1;
    click(x, 1 - (2 * (event.clientY - box.top)) / box.height);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    stage.addEventListener(end, () => (last = null));
  }
  stage.addEventListener("contextmenu", (event) => event.preventDefault());

  // A wheel that scrolls the page past the view goes on scrolling: it zooms when it begins here.
  const elsewhere = (event) => {
    if (!stage.contains(event.target)) scrolled = event.timeStamp;
  };
  window.addEventListener("wheel", elsewhere, { capture: true, passive: true });
  stage.addEventListener(
    "wheel",
    (event) => {
      if (event.timeStamp - scrolled < SCROLL) {
        scrolled = event.timeStamp;
        return;
      }
      event.preventDefault();
      const pixels = event.deltaY * (event.deltaMode === 1 ? 20 : 1);
      moves.add({ zoom: Math.exp(Math.max(-0.5, Math.min(0.5, pixels / 500))) });
    },
    { passive: false },
  );

  const step = Math.PI / 24;
  const keys = {
    ArrowLeft: { yaw: step },
    ArrowRight: { yaw: -step },
    ArrowUp: { pitch: -step },
    ArrowDown: { pitch: step },
    "+": { zoom: 0.9 },
    "-": { zoom: 1 / 0.9 },
  };
  stage.addEventListener("keydown", (event) => {
    if (event.key in keys) moves.add(keys[event.key]);
    else if (event.key.toLowerCase() === "r") reset();
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  return () => window.removeEventListener("wheel", elsewhere, { capture: true });
}

/** The elements of a view: panels in a row, and below them a button, a hint, and the colour bar. */
function frameOf(el, count) {
  el.classList.add("meshfair-view");
  const row = element("div", "panels", el);
  const panels = Array.from({ length: count }, () => {
    const figure = element("figure", "", row);
    const caption = element("figcaption", "", figure);
    const stage = element("div", "stage", figure);
    stage.tabIndex = 0;
    stage.setAttribute("role", "img");
    stage.dataset.lmSuppressShortcuts = "true"; // JupyterLab keeps its hands off these keys
    return { caption, stage };
  });
  const foot = element("div", "foot", el);
  const button = element("button", "", foot);
  button.type = "button";
  button.textContent = "Reset view";
  element("span", "hint", foot).textContent = HINT;
  return { panels, button, bar: new Bar(foot), error: element("span", "error", foot) };
}

/** Say what a panel shows, to those who see it and to those who do not. */
function entitle({ caption, stage }, title) {
  caption.textContent = title;
  stage.setAttribute("aria-label", `Mesh: ${title}`);
}
