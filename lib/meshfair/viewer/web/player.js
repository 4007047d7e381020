// What makes a page on file move: meshes, and the states that an explorer's controls go to.
//
// Behind what draws meshes (scripts.py) and the plots of curves.js and cotangents.js.
// What is packed is a header of JSON (recording.py, packing.py) and arrays of whole numbers:
//   arrays    [kind of numbers, entries, stride, similar arrays, their factors] of each
//   things    texts, curves, cameras: whatever states name by its number
//   states    at (positions of the controls), panels, bar, cameras, plots, note, below
//   controls  label, tooltip, kind (range, menu, box), texts of its positions, whether a box is
//             checked in them, whether it is the main one, which plays
//   live      a line at the end

const NEAR = "300px"; // how far below what is seen things are made ready
const PLAY = 200; // ms between two states while they play

/** The bytes in some text, made larger again. */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** All arrays: what is stored, and what was expected: the entries before, or a sum of others. */
function arraysOf(facts, bytes) {
  const kinds = { i2: Int16Array, u1: Uint8Array, u2: Uint16Array, u4: Uint32Array };
  const made = [];
  let from = 0;
  for (const [kind, length, stride, bases, factors] of facts) {
    const entries = new kinds[kind](length);
    const width = entries.BYTES_PER_ELEMENT;
    for (let k = 0; k < length; k++) {
      let folded = 0;
      for (let byte = 0; byte < width; byte++) folded |= bytes[from + byte * length + k] << (8 * byte);
      let expected = k < stride ? 0 : entries[k - stride];
      if (bases.length) {
        expected = 0.5;
        for (let i = 0; i < bases.length; i++) expected += factors[i] * made[bases[i]][k];
        expected = Math.floor(expected);
      }
      entries[k] = expected + ((folded >>> 1) ^ -(folded & 1));
    }
    from += width * length;
    made.push(entries);
  }
  return made;
}

/** What a plot of curves.js takes for its widget's model. */
class Traits {
  constructor(values, picked = () => {}) {
    this.values = { marker: null, threshold: null, x_range: null, y_range: null, ...values };
    this.listeners = new Set();
    this.picked = picked;
  }

  get(name) {
    return this.values[name];
  }

  set(name, value) {
    if (name === "picked") this.picked(value);
    else this.put({ [name]: value });
  }

  put(values) {
    Object.assign(this.values, values);
    for (const listener of this.listeners) listener();
  }

  on(event, listener) {
    this.listeners.add(listener);
  }

  off(event, listener) {
    this.listeners.delete(listener);
  }

  save_changes() {}
}

/** The cotangent weight of an edge, as CotangentExplorer computes it in Python. */
class Edge extends Traits {
  put(values) {
    super.put({ ...values, ...Edge.weighed({ ...this.values, ...values }.points) });
  }

  static weighed([i, j, a, b]) {
    const cotangents = [[i, j, a], [j, i, b]].map(([p, q, apex]) => {
      const [u, v] = [minus(p, apex), minus(q, apex)];
      return (u[0] * v[0] + u[1] * v[1]) / Math.abs(u[0] * v[1] - u[1] * v[0]);
    });
    const angles = cotangents.map((x) => (Math.atan2(1, x) * 180) / Math.PI);
    return { cotangents, angles, weight: (cotangents[0] + cotangents[1]) / 2 };
  }
}

/** A view, with the controls and the plots of an explorer where it is one. */
class Player {
  constructor(el, header, bytes) {
    this.el = el;
    this.header = header;
    this.arrays = arraysOf(header.arrays, bytes);
    const { states, controls = [] } = header;
    const thing = (number) => header.things[number];
    this.thing = thing;
    this.view = new MeshView(element("div", "", el), states[0].panels.length);
    this.controls = controls.map((control, k) => ({ ...control, k }));
    this.main = this.controls.find(({ main }) => main);
    if (controls.length) this.furnish();
    this.plots = thing(states[0].plots ?? -1)?.map((traits, k) => {
      const model = new Traits({}, (x) => this.pick(k, x));
      model.put(this.curves(traits));
      renderCurves({ model, el: element("div", "", this.place.plots) });
      return model;
    }) ?? [];
    this.show(states[0]);
  }

  at(state) {
    return this.controls.length ? this.thing(state.at) : [];
  }

  curves(traits) {
    const numbers = (curve) => ({ ...curve, x: this.thing(curve.x), y: this.thing(curve.y) });
    return { ...traits, series: traits.series.map(numbers) };
  }

  furnish() {
    const { el } = this;
    el.classList.add("meshfair-explorer-page");
    if (this.view.panels.length === 1) el.classList.add("one-panel");
    const parts = ["along", "controls", "plots", "note", "below", "live"];
    this.place = Object.fromEntries(parts.map((name) => [name, element("div", name, el)]));
    this.place.note.setAttribute("role", "status");
    this.place.live.textContent = this.header.live;
    if (this.main) {
      const play = element("button", "play", this.place.along);
      play.type = "button";
      play.textContent = "\u25b6";
      play.setAttribute("aria-label", `Play ${this.main.label}`);
      play.addEventListener("click", () => this.play(play));
    }
    for (const control of this.controls) {
      this.furnishOne(control, control.main ? this.place.along : this.place.controls);
    }
    const back = element("button", "back", this.place.along);
    back.type = "button";
    back.textContent = "as at first";
    back.addEventListener("click", () => this.show(this.header.states[0]));
  }

  furnishOne(control, parent) {
    const label = element("label", control.kind, parent);
    label.title = control.tooltip;
    if (control.kind !== "box") element("span", "name", label).textContent = control.label;
    const input = element(control.kind === "menu" ? "select" : "input", "", label);
    if (control.kind === "menu") {
      control.texts.forEach((text, k) => {
        const option = element("option", "", input);
        option.value = k;
        option.textContent = text;
      });
    } else if (control.kind === "box") {
      input.type = "checkbox";
      element("span", "name", label).textContent = control.label;
    } else {
      Object.assign(input, { type: "range", min: 0, max: control.texts.length - 1, step: 1 });
      control.said = element("output", "", label);
    }
    input.disabled = control.texts.length < 2;
    control.input = input;
    const { checked } = control;
    const position = () => (checked ? checked.indexOf(input.checked) : Number(input.value));
    const moved = () => {
      this.stop();
      this.move(control, position());
    };
    input.addEventListener("input", moved);
    input.addEventListener("keydown", (event) => event.stopPropagation());
  }

  /** Go to the state with a control at a position which differs least in the others. */
  move(control, position) {
    const now = this.at(this.state);
    const main = this.main?.k;
    const cheapest = (weights) => {
      let [best, least] = [null, Infinity];
      for (const state of this.header.states) {
        const cost = this.at(state).reduce((sum, place, k) => {
          const apart = Math.abs(place - (k === control.k ? position : now[k]));
          return sum + (apart && weights(k) + apart);
        }, 0);
        if (cost < least) [best, least] = [state, cost];
      }
      return best;
    };
    const exact = (k) => (k === control.k ? 1e9 : k === main ? 0 : 1e4);
    // What moves within all the others goes to the nearest state that leaves them where they are.
    let state = control.k === main ? cheapest((k) => (k === main ? 0 : 1e4)) : cheapest(exact);
    if (state === this.state) state = cheapest(exact);
    this.show(state);
  }

  /** Go to the state whose marker in a plot is nearest to an x, with at most one control moved. */
  pick(plot, x) {
    this.stop();
    const now = this.at(this.state);
    let [best, least] = [null, Infinity];
    for (const state of this.header.states) {
      const moved = this.at(state).filter((place, k) => place !== now[k]).length;
      const { marker } = this.thing(state.plots)[plot];
      if (marker === null || moved > 1 || Math.abs(marker - x) >= least) continue;
      [best, least] = [state, Math.abs(marker - x)];
    }
    if (best) this.show(best);
  }

  play(button) {
    if (this.playing) {
      this.stop();
      return;
    }
    const { k, input } = this.main;
    button.textContent = "\u23f8";
    this.button = button;
    const same = (state) => this.at(state).every((p, i) => i === k || p === this.at(this.state)[i]);
    this.playing = setInterval(() => {
      const row = this.header.states.filter(same).sort((a, b) => this.at(a)[k] - this.at(b)[k]);
      const next = row[(row.indexOf(this.state) + 1) % row.length];
      this.show(next);
      if (!input.isConnected) this.stop();
    }, PLAY);
  }

  stop() {
    clearInterval(this.playing);
    this.playing = 0;
    if (this.button) this.button.textContent = "\u25b6";
  }

  show(state) {
    this.state = state;
    const { view, thing } = this;
    state.panels.forEach(([V, F, values, look, title], k) => {
      const parts = values < 0 ? null : this.arrays[values];
      view.show(k, { ...thing(look), V: this.arrays[V], F: this.arrays[F], parts }, thing(title));
    });
    view.bar.show(thing(state.bar));
    if (this.aimed !== state.cameras) view.aim(thing(state.cameras), this.header.up);
    this.aimed = state.cameras;
    if (!this.controls.length) return;
    this.at(state).forEach((place, k) => {
      const { input, said, kind, texts, checked } = this.controls[k];
      if (kind === "box") input.checked = checked[place];
      else input.value = place;
      if (said) said.textContent = texts[place];
      if (said) input.setAttribute("aria-valuetext", texts[place]);
    });
    thing(state.plots).forEach((traits, k) => this.plots[k]?.put(this.curves(traits)));
    this.place.note.textContent = thing(state.note);
    this.place.below.innerHTML = thing(state.below); // a table of our own making
  }
}

async function mount(root) {
  const el = document.createElement("div");
  try {
    const bytes = await unpacked(root.querySelector("script.packed").textContent);
    const length = new DataView(bytes.buffer).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
    const still = root.querySelector(".still");
    root.append(el);
    if (header.points) {
      const model = new Edge({});
      model.put({ points: header.points });
      renderCotangents({ model, el });
    } else {
      root.player = new Player(el, header, bytes.subarray(4 + length));
    }
    still.remove();
    root.dataset.ready = "true";
  } catch (error) {
    el.remove(); // the still stays
    const said = element("p", "error", root);
    said.textContent = `The meshes do not move here: ${error.message}`;
    root.dataset.failed = "true";
  }
}

function mountAll() {
  const seen = new IntersectionObserver(
    (entries) => {
      for (const { target, isIntersecting } of entries) {
        if (!isIntersecting) continue;
        seen.unobserve(target);
        mount(target);
      }
    },
    { rootMargin: NEAR },
  );
  for (const root of document.querySelectorAll(".meshfair-player")) seen.observe(root);
}

if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", mountAll);
else mountAll();
