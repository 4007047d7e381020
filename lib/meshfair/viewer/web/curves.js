// Curves or points with axes, a legend, and a marker at one x; a click picks an x.

const MARGIN = { left: 46, right: 14, top: 8, bottom: 34 };
// Those of meshfair.plotting for all that is no weights: told apart on light and on dark paper.
const COLORS = ["#AF58BA", "#A68A00", "#808080", "#8C6D5A"];
const SVG = "http://www.w3.org/2000/svg";

function draw(name, attributes, parent, text) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

/** A curve's mark around a point: what stands at the best of it, and in the legend. */
function mark(kind, x, y, size, attributes, parent) {
  if (kind === "s") {
    draw("rect", { x: x - size, y: y - size, width: 2 * size, height: 2 * size, ...attributes }, parent);
  } else if (kind === "^") {
    const [w, h] = [1.2 * size, 1.1 * size];
    const points = `${x},${y - 1.3 * size} ${x - w},${y + h} ${x + w},${y + h}`;
    draw("polygon", { points, ...attributes }, parent);
  } else {
    draw("circle", { cx: x, cy: y, r: size, ...attributes }, parent);
  }
}

/** Round numbers from low to high, about `count` of them. */
function ticks(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return Array.from({ length: last - first + 1 }, (_, k) => {
    const value = (first + k) * step;
    return { value, label: Math.abs(value) < 1e5 ? value.toFixed(digits) : value.toExponential(0) };
  });
}

/** The two ends of some numbers, with a little air. */
function extent(numbers, air) {
  let [low, high] = [Infinity, -Infinity];
  for (const x of numbers) {
    if (x < low) low = x;
    if (x > high) high = x;
  }
  if (low > high) return [0, 1];
  const pad = high > low ? air * (high - low) : 0.5;
  return [low - pad, high + pad];
}

/** Linear interpolation of a curve at x; undefined outside of it. */
function at(curve, x) {
  const k = curve.x.findIndex((value) => value >= x - 1e-9);
  if (k < 0) return undefined;
  if (k === 0) return Math.abs(curve.x[0] - x) < 1e-6 ? curve.y[0] : undefined;
  const share = (x - curve.x[k - 1]) / (curve.x[k] - curve.x[k - 1]);
  return curve.y[k - 1] + share * (curve.y[k] - curve.y[k - 1]);
}

/** A function that does its work anew only when what it is given is not what it was given last. */
function whenChanged(work) {
  let [last, made] = ["", undefined];
  return (given) => {
    const text = JSON.stringify(given);
    if (text !== last) [last, made] = [text, work(given)];
    return made;
  };
}

function render({ model, el }) {
  el.classList.add("meshfair-curves");
  const head = document.createElement("div");
  head.className = "title";
  const plot = document.createElement("div");
  plot.className = "plot";
  el.append(head, plot);
  const svg = draw("svg", { class: "ground" }, plot);
  const above = draw("svg", { class: "above" }, plot);
  let toX = () => 0; // from pixels back to x, for the pointer
  const color = (curve, i) => curve.color || COLORS[i % COLORS.length];

  const paintHead = whenChanged(({ title, series }) => {
    head.replaceChildren();
    const name = document.createElement("b");
    name.textContent = title;
    head.append(name);
    series.forEach((curve, i) => {
      if (series.length === 1 && !curve.legend) return;
      const key = document.createElement("span");
      key.className = "key";
      const sample = draw("svg", { class: "sample", viewBox: "-11 -6 22 12" }, key);
      if (curve.points) {
        draw("circle", { cx: 0, cy: 0, r: 3, fill: color(curve, i) }, sample);
      } else {
        draw("line", { class: "curve", x1: -11, x2: 11, y1: 0, y2: 0, stroke: color(curve, i) }, sample);
      }
      if (curve.best) {
        mark(curve.mark, 0, 0, 4, { class: "best", stroke: color(curve, i) }, sample);
      }
      key.append(series.length > 1 ? curve.name : "");
      if (curve.legend) {
        const said = document.createElement("span");
        said.className = "said";
        said.textContent = `${series.length > 1 ? ": " : ""}${curve.legend}`;
        key.append(said);
      }
      head.append(key);
    });
  });

  /** Axes, curves and points; from numbers to pixels, for the marker. */
  const paintGround = whenChanged((shown) => {
    const { width, height, series, threshold, x_range, y_range, x_label, y_label } = shown;
    const [x0, x1] = x_range ?? extent(series.flatMap((s) => s.x), 0);
    const heights = series.flatMap((s) => s.y);
    const [y0, y1] = y_range ?? extent(threshold === null ? heights : [...heights, threshold], 0.06);
    const right = width - MARGIN.right;
    const bottom = height - MARGIN.bottom;
    const X = (x) => MARGIN.left + ((x - x0) / (x1 - x0 || 1)) * (right - MARGIN.left);
    const Y = (y) => bottom - ((y - y0) / (y1 - y0 || 1)) * (bottom - MARGIN.top);
    toX = (pixel) => x0 + ((pixel - MARGIN.left) / (right - MARGIN.left)) * (x1 - x0);

    svg.replaceChildren();
    for (const { value, label } of ticks(y0, y1, 5)) {
      const y = Y(value);
      draw("line", { class: "grid", x1: MARGIN.left, x2: right, y1: y, y2: y }, svg);
      draw("text", { x: MARGIN.left - 5, y: y + 4, "text-anchor": "end" }, svg, label);
    }
    for (const { value, label } of ticks(x0, x1, Math.max(3, Math.floor(width / 90)))) {
      draw("text", { x: X(value), y: bottom + 14, "text-anchor": "middle" }, svg, label);
    }
    draw("line", { class: "grid", x1: MARGIN.left, x2: right, y1: bottom, y2: bottom }, svg);
    const middle = (MARGIN.left + right) / 2;
    draw("text", { x: middle, y: height - 3, "text-anchor": "middle" }, svg, x_label);
    const turned = `translate(10 ${(bottom + MARGIN.top) / 2}) rotate(-90)`;
    draw("text", { transform: turned, "text-anchor": "middle" }, svg, y_label);

    if (threshold !== null) {
      const y = Y(threshold);
      draw("line", { class: "threshold", x1: MARGIN.left, x2: right, y1: y, y2: y }, svg);
    }
    series.forEach((curve, i) => {
      if (curve.points) {
        const radius = curve.x.length > 60 ? 2 : 4;
        curve.x.forEach((x, k) => {
          const over = threshold !== null && curve.y[k] > threshold + 1e-9;
          const fill = over ? "var(--alarm)" : color(curve, i);
          draw("circle", { cx: X(x), cy: Y(curve.y[k]), r: over ? radius + 1 : radius, fill }, svg);
        });
      } else if (curve.x.length) {
        const path = curve.x.map((x, k) => `${X(x).toFixed(1)},${Y(curve.y[k]).toFixed(1)}`);
        draw("polyline", { class: "curve", points: path.join(" "), stroke: color(curve, i) }, svg);
      }
    });

    series.forEach((curve, i) => {
      if (!curve.best) return;
      const place = [X(curve.best[0]), Y(curve.best[1])];
      mark(curve.mark, ...place, 5, { class: "best", stroke: color(curve, i) }, svg);
    });
    return { X, Y, x0, x1, right, bottom };
  });

  const paintMarker = (marker, series, { X, Y, x0, x1, right, bottom }) => {
    above.replaceChildren();
    if (marker === null || marker < x0 - 1e-9 || marker > x1 + 1e-9) return;
    const x = X(marker);
    draw("line", { class: "marker", x1: x, x2: x, y1: MARGIN.top, y2: bottom }, above);
    series.forEach((curve, i) => {
      const y = at(curve, marker);
      if (y === undefined || curve.points) return;
      draw("circle", { cx: x, cy: Y(y), r: 4, fill: color(curve, i) }, above);
      // With several curves the panels' titles give the values.
      if (series.length > 1) return;
      const text = Math.abs(y) < 1e5 ? y.toFixed(2) : y.toExponential(1);
      const [wide, high] = [7 * text.length + 4, 14];
      const line = curve.x.map((value, k) => [X(value), Y(curve.y[k])]);
      // Where the label covers least of the curve, and lies within the axes.
      const places = [[9, -8], [-9 - wide, -8], [9, 20], [-9 - wide, 20], [9, -26], [-9 - wide, -26]]
        .map(([dx, dy]) => [x + dx, Y(y) + dy])
        .filter(([a, b]) => a >= MARGIN.left && a + wide <= right && b - high >= 0 && b <= bottom);
      const covered = ([a, b]) =>
        line.filter(([p, q]) => p > a - 4 && p < a + wide + 4 && q > b - high && q < b + 4).length;
      places.sort((one, other) => covered(one) - covered(other));
      const [a, b] = places[0] ?? [x + 9, Y(y) - 8];
      draw("text", { class: "value", x: a, y: b }, above, text);
    });
  };

  const paint = () => {
    const [width, height] = [svg.clientWidth, svg.clientHeight];
    if (!width || !height) return;
    const names = ["series", "threshold", "x_range", "y_range", "x_label", "y_label"];
    const shown = Object.fromEntries(names.map((name) => [name, model.get(name)]));
    const { series } = shown;
    paintHead({ title: model.get("title"), series });
    const curves = series.map(({ legend, ...curve }) => curve);
    const axes = paintGround({ ...shown, series: curves, width, height });
    paintMarker(model.get("marker"), series, axes);
  };

  const pick = (event) => {
    if (event.buttons !== 1) return;
    model.set("picked", toX(event.clientX - svg.getBoundingClientRect().left));
    model.save_changes();
  };
  svg.addEventListener("pointerdown", (event) => {
    svg.setPointerCapture(event.pointerId);
    pick(event);
  });
  svg.addEventListener("pointermove", pick);

  // Many traits may change at once: one picture for all of them.
  let planned = 0;
  const plan = () => {
    planned ||= requestAnimationFrame(() => {
      planned = 0;
      paint();
    });
  };
  model.on("change", plan);
  const size = new ResizeObserver(plan);
  size.observe(svg);
  return () => {
    size.disconnect();
    cancelAnimationFrame(planned);
    model.off("change", plan);
  };
}

export default { render };
