// Table of all keys, which the help shows too.

import { byId, element } from "./dom.js";

export class Keyboard {
  /** `keys`: for each entry the keys, the help text, and the action. */
  constructor(keys) {
    this.keys = keys;
    for (const [names, words] of keys) {
      const kinds = names.filter((name) => name !== "=" && name !== "_").map((name) => element("kbd", {}, SHOWN[name] ?? name));
      byId("key-list").append(element("dt", {}, ...kinds), element("dd", {}, words));
    }
    addEventListener("keydown", (event) => this.pressed(event));
  }

  pressed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const isTyping = event.target.closest("input:not([type=checkbox]), select, textarea, dialog");
    if (isTyping && event.key !== "Escape") return;
    const isOnButton = event.target.closest("button, a, summary, [type=checkbox]") && [" ", "Enter"].includes(event.key);
    if (isOnButton) return;
    const [, , act] = this.keys.find(([names]) => names.includes(event.key)) ?? [];
    if (!act) return;
    if (event.key !== "Escape") event.preventDefault();
    act(event);
  }
}

const SHOWN = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", Escape: "Esc", "-": "−", " ": "Space" };
