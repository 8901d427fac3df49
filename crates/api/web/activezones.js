// Zones that operators have activated: their list in the panel of the zone tool, and the requests to activate and revoke them.

import { hasToken, list, post } from "./api.js";
import { byId, element, setText } from "./dom.js";
import * as format from "./format.js";

const SURE_MS = 5000; // time for a second click on "Revoke"

export class ActiveZones {
  /** @type {ZonesAnswer["zones"] | null} */
  zones = null; // null: not known yet
  isAvailable = false; // not in a replay
  mayControl = false;

  /**
   * `renew()` requests the zones again; `changed()` is called when others are active than before.
   * @param {() => void} renew @param {() => void} changed
   */
  constructor(renew, changed) {
    this.renew = renew;
    this.changed = changed;
  }

  /** Takes the answer of /zones. @param {ZonesAnswer} answer */
  take(answer) {
    const before = this.zones;
    const zones = list(answer, "zones");
    if (JSON.stringify(before) === JSON.stringify(zones) && this.isAvailable === answer.available) return;
    this.isAvailable = answer.available === true;
    this.zones = zones;
    this.show();
    if (before) this.changed();
  }

  /** @param {boolean} mayControl */
  setControl(mayControl) {
    if (mayControl === this.mayControl) return;
    this.mayControl = mayControl;
    this.show();
  }

  show() {
    const mayChange = this.mayControl && this.isAvailable;
    byId("zone-activate").hidden = byId("zone-offer").hidden = !mayChange;
    byId("zone-file").hidden = mayChange;
    byId("zone-active").hidden = !this.zones?.length;
    const items = (this.zones ?? []).map(({ name, activated_by, activated_at }) =>
      element("li", {}, `${name}: activated by ${activated_by}, ${format.words(activated_at)}`, mayChange ? this.revokeButton(name) : null));
    byId("zone-list").replaceChildren(...items);
  }

  /** A zone that is revoked is lost, so the button asks for a second click. @param {string} name */
  revokeButton(name) {
    const button = element("button", { type: "button" });
    let isSure = false;
    /** @param {boolean} isAsked */
    const ask = (isAsked) => {
      isSure = isAsked;
      setText(button, isAsked ? "Really revoke?" : "Revoke");
      button.setAttribute("aria-label", isAsked ? `Really revoke? ${name}` : `Revoke ${name}`);
    };
    ask(false);
    button.addEventListener("click", () => {
      if (isSure) return this.send(`zones/${encodeURIComponent(name)}/revoke`, null);
      ask(true);
      setTimeout(() => ask(false), SURE_MS);
    });
    return button;
  }

  /** @param {string} name */
  has(name) {
    return this.zones?.some((zone) => zone.name === name) ?? false;
  }

  /** Returns whether the zone is active. @param {string} name @param {object} geojson */
  activate(name, geojson) {
    return this.send(`zones/${encodeURIComponent(name)}`, geojson);
  }

  /** Returns whether the service has carried it out. @param {`zones/${string}`} path @param {object | null} body */
  async send(path, body) {
    const by = hasToken() ? "" : byId("alert-by", HTMLInputElement).value.trim(); // the name that goes with decisions about alerts
    try {
      await post(path, by ? { by } : {}, body);
    } catch (error) {
      setText(byId("zone-fault"), error.message);
      return false;
    }
    setText(byId("zone-fault"), "");
    this.renew();
    return true;
  }
}
