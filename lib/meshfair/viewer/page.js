// Meshes side by side, drawn by k3d: turning one turns all.

const LEAST = 320; // CSS pixels of a panel's width, below which a row has fewer of them
const HINT = "drag to turn · right-drag to move · wheel to zoom · R to reset";

function element(name, className, parent) {
  const node = document.createElement(name);
  node.className = className;
  parent.append(node);
  return node;
}

function text(id) {
  return document.getElementById(id).textContent;
}

function unpacked(base64) {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
}

/** k3d, which is made for a loader of modules: this hands it over. */
async function library() {
  const packed = new Blob([unpacked(text("k3d"))]).stream();
  const source = await new Response(packed.pipeThrough(new DecompressionStream("deflate"))).text();
  let k3d;
  window.define = (name, needs, make) => (k3d = make());
  window.define.amd = {};
  const script = document.createElement("script");
  script.textContent = source;
  document.head.append(script);
  delete window.define;
  return k3d;
}

function showBar({ label, low, high, stops }, parent) {
  const bar = element("span", "bar", parent);
  element("span", "label", bar).textContent = label;
  element("span", "low", bar).textContent = low;
  element("i", "", bar).style.background = `linear-gradient(to right, ${stops.join(",")})`;
  element("span", "high", bar).textContent = high;
}

/** The camera for square panels, farther away where they are higher than wide. */
function fitted(camera, stage) {
  const away = Math.max(1, stage.clientHeight / stage.clientWidth);
  const [position, target] = [camera.slice(0, 3), camera.slice(3, 6)];
  return [...position.map((x, i) => target[i] + away * (x - target[i])), ...camera.slice(3)];
}

async function show() {
  const { titles, snapshots, camera, bar } = JSON.parse(text("meshes"));
  const main = document.querySelector("main");
  const foot = document.querySelector("footer");
  const button = element("button", "", foot);
  button.textContent = "Reset view";
  element("span", "hint", foot).textContent = HINT;
  if (bar) showBar(bar, foot);

  const stages = titles.map((title) => {
    const figure = element("figure", "", main);
    element("figcaption", "", figure).textContent = title;
    const stage = element("div", "stage", figure);
    stage.tabIndex = 0;
    stage.setAttribute("role", "img");
    stage.setAttribute("aria-label", `Mesh: ${title}`);
    return stage;
  });
  const layout = () => {
    const columns = Math.max(1, Math.min(titles.length, Math.floor(main.clientWidth / LEAST)));
    const rows = Math.ceil(titles.length / columns);
    // As many in each row as there are in the others, as near as can be.
    main.style.gridTemplateColumns = `repeat(${Math.ceil(titles.length / rows)}, 1fr)`;
  };
  layout();

  const { CreateK3DAndLoadBinarySnapshot } = await library();
  const plots = await Promise.all(
    stages.map((stage, i) =>
      CreateK3DAndLoadBinarySnapshot(unpacked(snapshots[i]).buffer, stage),
    ),
  );

  let moving = false; // what one panel tells the others does not come back
  let touched = false;
  const move = (pose, except) => {
    moving = true;
    for (const plot of plots) if (plot !== except) plot.setCamera(pose);
    moving = false;
    for (const plot of plots) if (plot !== except) plot.render();
  };
  for (const plot of plots) {
    plot.on(plot.events.CAMERA_CHANGE, (pose) => {
      if (moving) return;
      touched = true;
      move(pose, plot);
    });
  }
  const reset = () => {
    move(fitted(camera, stages[0]));
    touched = false;
  };
  const resized = () => {
    layout();
    for (const plot of plots) plot.resizeHelper();
    if (!touched) reset();
  };
  new ResizeObserver(resized).observe(main);
  button.addEventListener("click", reset);
  document.addEventListener("keydown", (event) => {
    if (event.key.toLowerCase() === "r" && !event.ctrlKey && !event.metaKey) reset();
  });
  reset();
  window.meshfair = { plots, reset };
  document.body.dataset.ready = "true";
}

show().catch((error) => {
  element("span", "error", document.querySelector("footer")).textContent = String(error);
});
