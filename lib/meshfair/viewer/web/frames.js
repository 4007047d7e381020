// Shows the frames that Python sends, and sends back what the pointer does. Behind stage.js and
// kernel.js.
//
// To Python:  layout  panel size, pixel ratio and background; asks for all panels
//             move    the camera's change since the last move, while none is unanswered
//             reset   back to the first camera
//             shown   the frame is on the screen: the next may come
//             rest    nothing moves any more: good frames, please
// To here:    frame   pictures of some panels, their titles and the colour bar
//             error   a line to show

const REST = 250; // ms without a new frame until good frames are asked for

/** The colour on which the notebook draws, each channel from 0 to 1. */
function background(node) {
  const channels = getComputedStyle(node).backgroundColor.match(/[\d.]+/g) ?? [255, 255, 255];
  return channels.slice(0, 3).map((channel) => channel / 255);
}

function pause(milliseconds) {
  return new Promise((resolve) => setTimeout(resolve, milliseconds));
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
    layout.answered();
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

  const layout = new Layout(model, panels[0].stage, () => ({
    ratio: Math.min(window.devicePixelRatio, 2),
    background: background(panels[0].stage),
  }));
  // Both JupyterLab and VS Code set their theme as an attribute of the body.
  const theme = new MutationObserver(() => setTimeout(() => layout.tell(), 100));
  theme.observe(document.body, { attributes: true });

  return () => {
    clearTimeout(resting);
    pulse.stop();
    layout.stop();
    theme.disconnect();
    model.off("msg:custom", receive);
    for (const { picture, release } of panels) {
      release();
      if (picture.src) URL.revokeObjectURL(picture.src);
    }
  };
}

export default { render };
