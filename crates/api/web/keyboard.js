// Table of all keys, which the help shows too.

import { byId, element } from "./dom.js";

/** Keys, the help text, and the action. @typedef {[string[], string, (event: KeyboardEvent) => void]} Key */

export class Keyboard {
  /** `keys`: for each entry the keys, the help text, and the action. @param {Key[]} keys */
  constructor(keys) {
    this.keys = keys;
    for (const [names, words] of keys) {
      const kinds = names.filter((name) => name !== "=" && name !== "_").map((name) => element("kbd", {}, SHOWN[name] ?? name));
      byId("key-list").append(element("dt", {}, ...kinds), element("dd", {}, words));
    }
    addEventListener("keydown", (event) => this.pressed(event));
  }

  /** @param {KeyboardEvent} event */
  pressed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const target = event.target instanceof Element ? event.target : document.body;
    const isTyping = target.closest("input:not([type=checkbox]), select, textarea, dialog");
    if (isTyping && event.key !== "Escape") return;
    const isOnButton = target.closest("button, a, summary, [type=checkbox]") && [" ", "Enter"].includes(event.key);
    if (isOnButton) return;
    const [, , act] = this.keys.find(([names]) => names.includes(event.key)) ?? [];
    if (!act) return;
    if (event.key !== "Escape") event.preventDefault();
    act(event);
  }
}

/** @type {Record<string, string>} */
const SHOWN = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", Escape: "Esc", "-": "−", " ": "Space" };
