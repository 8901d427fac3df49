// Print: the map in light colours at paper size, with the shown tracks below, and a note on hidden ones.

import { byId, element, setText } from "./dom.js";
import { filterWords } from "./filter.js";
import * as format from "./format.js";
import { shortName } from "./names.js";
import { applyTheme } from "./palette.js";
import { settings } from "./settings.js";
import { height, heightWords, plainHeight, plainSpeed } from "./units.js";

const HEADS = () => ["Track", "Serial", "Source", `Height, ${heightWords()}`, settings.units.speed, "Course", "Position"];

/** @param {Map2d} map @param {() => string} title */
export function listenForPrint(map, title) {
  addEventListener("beforeprint", () => {
    applyTheme("light");
    map.repaintNow();
    setText(byId("print-head"), [title(), settings.at === "now" ? "predicted" : "", filterWords(height)].filter(Boolean).join("; "));
    byId("print-table").replaceChildren(...(map.picture ? table(map.picture) : []));
  });
  addEventListener("afterprint", () => {
    applyTheme();
    map.repaintNow();
    byId("print-table").replaceChildren();
  });
}

/** @param {Picture} picture */
function table(picture) {
  /** @param {"th" | "td"} tag @param {string[]} texts */
  const row = (tag, texts) => element("tr", {}, ...texts.map((text) => element(tag, tag === "th" ? { scope: "col" } : {}, text)));
  const rows = picture.visible().map((track) => {
    const { alt_msl, lat, lng } = track.properties;
    return row("td", [shortName(track), track.serial, track.source, plainHeight(alt_msl), plainSpeed(track.speed), format.direction(track.course), format.position(lat, lng)]);
  });
  return [element("thead", {}, row("th", HEADS())), element("tbody", {}, ...rows)];
}
