// Draws the meshes that Python sends, and sends back what the pointer does. Behind kernel.js and
// what draws meshes (scripts.py).
//
// To Python:  layout  panel size, and whether this page has no meshes yet
//             move    the camera's change since the last move, while none is unanswered
//             reset   back to the first camera
//             shown   what came is on the screen: the next may come
// To here:    show    what is new of some panels, the colour bar, and the camera if it is
//             moved   the camera to which a page has moved it
//             error   a line to show

const ARRAYS = { V: Float32Array, F: Uint32Array, parts: Uint8Array };

/** What is in a buffer that came from Python, which may begin anywhere in memory. */
function arrayOf(kind, { buffer, byteOffset, byteLength }) {
  return new ARRAYS[kind](buffer.slice(byteOffset, byteOffset + byteLength));
}

function render({ model, el }) {
  const page = crypto.getRandomValues(new Uint32Array(1))[0];
  const moves = new Moves(model, page);
  const meshes = [];
  let view;
  try {
    view = new MeshView(el, model.get("count"), {
      click: (panel, x, y) => model.send({ kind: "click", panel, x, y }),
      moved: (move) => moves.add(move),
      reset: () => model.send({ kind: "reset" }),
    });
  } catch (failure) {
    element("span", "error drawn", el).textContent = failure.message;
    return undefined;
  }
  const pulse = new Pulse(model, el, (text) => (view.error.textContent = text));
  const fresh = () => ({ fresh: !meshes.length });
  const layout = new Layout(model, view.panels[0].stage, fresh);

  const show = (message, buffers) => {
    if (!meshes.length && !message.whole) return; // meant for other pages
    layout.answered();
    view.panels[0].stage.classList.add("drawn"); // the still in the notebook goes: see saved.py
    view.bar.show(message.bar);
    for (const { panel, title, look, arrays } of message.panels) {
      const found = Object.entries(arrays).map(([kind, k]) => [
        kind,
        k === null ? null : arrayOf(kind, buffers[k]),
      ]);
      meshes[panel] = { ...meshes[panel], ...look, ...Object.fromEntries(found), units: 1 };
      view.show(panel, meshes[panel], title);
    }
    if (message.camera) view.look(message.camera, message.up);
  };
  const receive = (message, buffers) => {
    pulse.answered();
    if (message.kind === "moved") {
      if (message.by === page) moves.answered();
      else view.look(message.camera, message.up);
    } else if (message.kind === "show") {
      view.error.textContent = "";
      show(message, buffers);
      // When it is on the screen; or at once where nothing is drawn, as on a hidden tab.
      const said = () => model.send({ kind: "shown" });
      if (document.hidden) said();
      else requestAnimationFrame(said);
    }
  };
  model.on("msg:custom", receive);
  return () => {
    pulse.stop();
    layout.stop();
    model.off("msg:custom", receive);
    view.release();
  };
}

export default { render };
