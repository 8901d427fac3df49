// First visit: a card that explains the map in three lines, with the legend open. It is shown until it is dismissed.

import { byId } from "./dom.js";

const SEEN = "utm-fusion-seen";
const WIDE = "(min-width: 861px) and (min-height: 481px)"; // on smaller screens the legend would cover the map

export function welcome() {
  if (localStorage.getItem(SEEN)) return;
  byId("welcome").hidden = false;
  if (matchMedia(WIDE).matches) byId("legend", HTMLDetailsElement).open = true;
  byId("welcome-close").addEventListener("click", () => {
    localStorage.setItem(SEEN, "1");
    byId("welcome").hidden = true;
    byId("legend", HTMLDetailsElement).open = false;
    byId("canvas").focus({ preventScroll: true });
  });
}

/** Says in the card whether the site has a base map. @param {boolean} isThere */
export function noteBaseMap(isThere) {
  byId("welcome-base").hidden = isThere;
}
