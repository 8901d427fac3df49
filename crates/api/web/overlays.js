// The user's own GeoJSON files, selected or dropped. They are drawn on this page and sent nowhere.

import { byId, element, setText } from "./dom.js";
import { Shapes } from "./shapes.js";

const LARGEST_FILE = 20e6; // octets; larger files block the browser

/** Shapes of a file; throws with a message for the user. @param {File} file @param {Frame | undefined} frame */
async function shapesOf(file, frame) {
  if (!frame) throw new Error("The map has no origin yet: neither a radar nor a track is known");
  if (file.size > LARGEST_FILE) throw new Error(`${file.name}: larger than 20 MB`);
  let value;
  try {
    value = JSON.parse(await file.text());
  } catch {
    throw new Error(`${file.name}: not JSON`);
  }
  let shapes;
  try {
    shapes = new Shapes(file.name, value, frame);
  } catch {
    throw new Error(`${file.name}: not GeoJSON, or a coordinate in it is not a number`);
  }
  if (!shapes.places.length) throw new Error(`${file.name}: no GeoJSON geometry in it`);
  return shapes;
}

/** @param {Map2d} map */
export function listenForOverlays(map) {
  /** @param {File[]} files */
  async function add(files) {
    for (const file of files) {
      try {
        map.overlays.push(await shapesOf(file, map.picture?.frame));
        setText(byId("overlay-error"), "");
      } catch (error) {
        setText(byId("overlay-error"), error.message);
        byId("layers").showPopover();
      }
    }
    show();
  }

  function show() {
    const items = map.overlays.map((overlay) => {
      const remove = element("button", { type: "button", "aria-label": `Remove ${overlay.name}` }, "Remove");
      remove.addEventListener("click", () => {
        map.overlays = map.overlays.filter((other) => other !== overlay);
        show();
      });
      return element("li", {}, overlay.name, remove);
    });
    byId("overlay-list").replaceChildren(...items);
    map.invalidate();
  }

  const input = byId("overlay-file", HTMLInputElement);
  input.addEventListener("change", async () => {
    await add([...(input.files ?? [])]);
    input.value = ""; // allows the same file to be selected again
  });
  addEventListener("dragover", (event) => {
    event.preventDefault();
    byId("drop-hint").hidden = false;
  });
  addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) byId("drop-hint").hidden = true;
  });
  addEventListener("drop", (event) => {
    event.preventDefault(); // otherwise the browser would open the file instead of the map
    byId("drop-hint").hidden = true;
    add([...(event.dataTransfer?.files ?? [])]);
  });
}
