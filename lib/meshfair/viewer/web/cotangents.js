// An edge and the two triangles at it; what is dragged goes to Python, which computes the weight.

const SVG = "http://www.w3.org/2000/svg";
const BOX = { x: -2.6, y: -0.6, width: 5.2, height: 3.2 };
const FLAT = 0.03; // the least area of a triangle: a corner is not dragged over the edge
const NAMES = ["v\u1d62", "v\u2c7c", "α", "β"];
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

function node(name, attributes, parent, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  parent?.append(made);
  return made;
}

const area = ([i, j, k]) => ((j[0] - i[0]) * (k[1] - i[1]) - (j[1] - i[1]) * (k[0] - i[0])) / 2;
const keepsSides = ([i, j, a, b]) => area([i, j, a]) > FLAT && area([j, i, b]) > FLAT;
const number = (x) => (Math.abs(x) < 0.005 ? "0.00" : x.toFixed(2)).replace("-", "\u2212");

/** A sector at a corner between its two neighbours. */
function sector(at, p, q, radius) {
  const towards = (r) => {
    const d = [r[0] - at[0], r[1] - at[1]];
    const length = Math.hypot(...d);
    return [at[0] + (radius * d[0]) / length, at[1] + (radius * d[1]) / length];
  };
  const [a, b] = [towards(p), towards(q)];
  const turn = (a[0] - at[0]) * (b[1] - at[1]) - (a[1] - at[1]) * (b[0] - at[0]);
  return `M${at} L${a} A${radius},${radius} 0 0 ${turn > 0 ? 1 : 0} ${b} Z`;
}

function render({ model, el }) {
  el.classList.add("meshfair-cotangents");
  const svg = node("svg", { viewBox: `${BOX.x} ${-BOX.y - BOX.height} ${BOX.width} ${BOX.height}` }, el);
  // Upwards is up: the picture is a mirror image of SVG's own axes.
  const plane = node("g", { transform: "scale(1,-1)" }, svg);
  const faces = [0, 1].map((k) => node("path", { class: `face f${k}` }, plane));
  const sectors = [0, 1].map((k) => node("path", { class: `angle f${k}` }, plane));
  const edge = node("line", { class: "edge" }, plane);
  const labels = [0, 1, 2, 3].map(() => node("text", { "text-anchor": "middle" }, svg));
  const handles = [0, 1, 2, 3].map((k) =>
    node("circle", { r: 0.09, tabindex: 0, role: "slider", class: `handle h${k}` }, plane),
  );
  const said = document.createElement("div");
  said.className = "said";
  el.append(said);

  const paint = () => {
    const points = model.get("points");
    const [i, j, a, b] = points;
    const [angles, cotangents, weight] = ["angles", "cotangents", "weight"].map((name) => model.get(name));
    [a, b].forEach((apex, k) => {
      faces[k].setAttribute("d", `M${i} L${j} L${apex} Z`);
      sectors[k].setAttribute("d", sector(apex, i, j, 0.32));
    });
    const thick = 0.03 + 0.08 * Math.min(2, Math.abs(weight ?? 0));
    const ends = { x1: i[0], y1: i[1], x2: j[0], y2: j[1], "stroke-width": thick };
    for (const [key, value] of Object.entries(ends)) edge.setAttribute(key, value);
    edge.classList.toggle("negative", weight < 0);
    points.forEach(([x, y], k) => {
      handles[k].setAttribute("cx", x);
      handles[k].setAttribute("cy", y);
      const name = k < 2 ? NAMES[k] : `${NAMES[k]} = ${angles[k - 2].toFixed(0)}°`;
      handles[k].setAttribute("aria-label", name);
      labels[k].textContent = name;
      // Below and above the edge's ends, and on the outer side of the corners.
      const away = [[0, 0.34], [0, -0.18], [-0.1, -0.2], [0.1, -0.2]][k];
      labels[k].setAttribute("x", Math.max(BOX.x + 0.45, Math.min(-BOX.x - 0.45, x + away[0])));
      labels[k].setAttribute("y", -y + away[1]);
    });
    const sum = angles[0] + angles[1];
    said.replaceChildren();
    const line = (text, className = "") => {
      const made = document.createElement("p");
      made.className = className;
      made.textContent = text;
      said.append(made);
    };
    if (weight === null) {
      line("One triangle has no area: its angle has no cotangent.");
      return;
    }
    line(`cot α = ${number(cotangents[0])}`, "f0");
    line(`cot β = ${number(cotangents[1])}`, "f1");
    line(`w\u1d62\u2c7c = ½ (cot α + cot β) = ${number(weight)}`, weight < 0 ? "weight negative" : "weight");
    const than = sum > 180 ? "more than 180°, so the weight is negative" : "not more than 180°";
    line(`α + β = ${sum.toFixed(0)}°: ${than}`);
  };

  const place = (k, [x, y]) => {
    const points = model.get("points").map((point) => [...point]);
    const inside = (value, low, size) => Math.max(low + 0.15, Math.min(low + size - 0.15, value));
    points[k] = [inside(x, BOX.x, BOX.width), inside(y, BOX.y, BOX.height)];
    if (!keepsSides(points)) return;
    model.set("points", points);
    model.save_changes();
    paint();
  };
  handles.forEach((handle, k) => {
    handle.addEventListener("pointerdown", (event) => {
      handle.setPointerCapture(event.pointerId);
      event.preventDefault();
      handle.focus();
    });
    handle.addEventListener("pointermove", (event) => {
      if (!handle.hasPointerCapture(event.pointerId)) return;
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(
        plane.getScreenCTM().inverse(),
      );
      place(k, [at.x, at.y]);
    });
    handle.addEventListener("keydown", (event) => {
      const step = KEYS[event.key];
      if (!step) return;
      const [x, y] = model.get("points")[k];
      place(k, [x + 0.1 * step[0], y + 0.1 * step[1]]);
      event.preventDefault();
      event.stopPropagation();
    });
  });
  el.dataset.lmSuppressShortcuts = "true"; // JupyterLab keeps its hands off these keys
  model.on("change", paint);
  paint();
  return () => model.off("change", paint);
}

export default { render };
