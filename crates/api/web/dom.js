// Helpers for the document. Text is inserted as text nodes only: no data from the network are ever parsed as HTML.

/**
 * The element of the page with that id. Throws if there is none of that kind.
 * @template {HTMLElement} [T=HTMLElement]
 * @param {string} id @param {new () => T} [kind]
 */
export const byId = (id, kind) => ofKind(document.getElementById(id), `#${id}`, kind);

/**
 * @template {HTMLElement} [T=HTMLElement]
 * @param {Element | null} node @param {string} name @param {new () => T} [kind]
 */
function ofKind(node, name, kind) {
  if (!(node instanceof (kind ?? HTMLElement))) throw new Error(`the page has no ${kind?.name ?? "element"} "${name}"`);
  return /** @type {T} */ (node);
}

/**
 * The first element below a node that matches. Throws if there is none of that kind.
 * @template {HTMLElement} [T=HTMLElement]
 * @param {Element} node @param {string} selector @param {new () => T} [kind]
 */
export const find = (node, selector, kind) => ofKind(node.querySelector(selector), selector, kind);

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag @param {Attributes} [attributes] @param {...(Node | string | null | undefined)} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === true) made.setAttribute(name, "");
    else if (value !== false && value != null) made.setAttribute(name, String(value));
  }
  made.append(...children.filter((child) => child != null));
  return made;
}

/** The drawing context of a canvas. @param {HTMLCanvasElement} canvas @param {CanvasRenderingContext2DSettings} [options] */
export function contextOf(canvas, options) {
  const context = canvas.getContext("2d", options);
  if (!context) throw new Error("this browser does not draw on a canvas");
  return context;
}

/** Avoids the cost of a layout for unchanged text. @param {Element} node @param {string} text */
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** @param {Element} node @param {string} name @param {string} value */
export function setAttribute(node, name, value) {
  if (node.getAttribute(name) !== value) node.setAttribute(name, value);
}
