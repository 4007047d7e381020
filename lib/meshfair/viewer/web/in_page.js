// Draws in the page what Python sends: the view without EGL. Behind stage.js, camera.js, meshes.js.
//
// To Python:  ready   the page can draw: all panels, please
//             layout  the panels' shape
//             camera  where the reader has turned the camera to, once it has come to rest
//             reset   back to the first camera
//             click   on a panel
// To here:    panels  meshes of some panels with titles and the colour bar: positions, faces, and
//                     places on the scale as buffers; the camera, where Python has moved it

const REST = 100; // ms without a move until Python is told where the camera is

function render({ model, el }) {
  const send = (kind, facts = {}) => model.send({ kind, ...facts });
  let view;
  try {
    view = new MeshView(el, model.get("count"), {
      reset: () => send("reset"),
      click: (panel, x, y) => send("click", { panel, x, y }),
      moved: (camera) => {
        clearTimeout(resting);
        resting = setTimeout(() => send("camera", { camera: camera.numbers }), REST);
      },
    });
  } catch (error) {
    element("p", "error", el).textContent = `The meshes cannot be drawn here: ${error.message}`;
    return undefined;
  }
  let resting = 0;
  const receive = (message, buffers) => {
    if (message.kind !== "panels") return;
    message.panels.forEach(({ panel, look, title }, i) => {
      const bytes = buffers.slice(3 * i, 3 * i + 3).map((b) => b.buffer.slice(b.byteOffset, b.byteOffset + b.byteLength));
      const parts = bytes[2].byteLength ? new Uint8Array(bytes[2]) : null;
      const mesh = { V: new Float32Array(bytes[0]), F: new Uint32Array(bytes[1]), parts };
      view.show(panel, { ...look, ...mesh }, title);
    });
    view.bar.show(message.bar);
    view.up = message.up;
    if (message.camera) view.camera = Camera.of(message.camera);
    view.plan();
  };
  model.on("msg:custom", receive);
  const { stage } = view.panels[0];
  const layout = () => {
    if (stage.clientWidth && stage.clientHeight) {
      send("layout", { width: stage.clientWidth, height: stage.clientHeight });
    }
  };
  const size = new ResizeObserver(layout);
  size.observe(stage);
  send("ready");
  return () => {
    clearTimeout(resting);
    size.disconnect();
    model.off("msg:custom", receive);
    view.release();
  };
}

export default { render };
