// Controls of the filter: the field and buttons above the table, the panel, and the note on the map.

import { byId, element, find, setAttribute, setText } from "./dom.js";
import { filterWords, zoneNames } from "./filter.js";
import { change, clearFilter, INTEGRITIES, isFiltering, KIND_NAMES, KINDS, settings, SOURCES, toggled } from "./settings.js";
import { height, heightWords, metresOf, plainHeight } from "./units.js";

export class FilterPanel {
  /** @type {[Source, HTMLElement][]} */
  sources = SOURCES.map((source) => [source, find(byId("sources"), `[data-source=${source}]`)]);
  /** @type {Map<Kind, HTMLInputElement>} */
  kinds = new Map();

  constructor() {
    byId("filter").addEventListener("submit", (event) => event.preventDefault());
    const input = byId("filter-input", HTMLInputElement);
    input.addEventListener("input", () => change({ text: input.value.trim() }));
    for (const [source, button] of this.sources) {
      button.addEventListener("click", () => change({ sources: toggled(settings.sources, source) }));
    }
    byId("flagged").addEventListener("click", () => change({ flagged: !settings.flagged }));
    for (const id of ["filter-clear", "filter-clear-all"]) byId(id).addEventListener("click", clearFilter);
    for (const [id, name] of [["height-low", "low"], ["height-high", "high"]]) {
      const limit = byId(id, HTMLInputElement);
      limit.addEventListener("change", () => change({ [name]: metresOf(limit.value) }));
    }
    for (const kind of KIND_NAMES) {
      const box = element("input", { type: "checkbox", name: kind });
      box.addEventListener("change", () => change({ kinds: toggled(settings.kinds, kind) }));
      this.kinds.set(kind, box);
      byId("kinds").append(element("label", {}, box, KINDS[kind]));
    }
    byId("by-integrity").append(element("option", { value: "" }, "any"), ...INTEGRITIES.map((name) => element("option", {}, name)));
    const [byIntegrity, byZone] = [byId("by-integrity", HTMLSelectElement), byId("by-zone", HTMLSelectElement)];
    byIntegrity.addEventListener("change", () => change({ integrity: byIntegrity.value }));
    byZone.addEventListener("change", () => change({ zone: byZone.value }));
    const watchedOnly = byId("watched-only", HTMLInputElement);
    watchedOnly.addEventListener("change", () => change({ watchedOnly: watchedOnly.checked }));
  }

  show() {
    const { text, sources, flagged, kinds, integrity, zone, watchedOnly, low, high } = settings;
    if (byId("filter-input", HTMLInputElement).value !== text) byId("filter-input", HTMLInputElement).value = text;
    for (const [source, button] of this.sources) setAttribute(button, "aria-pressed", String(sources.has(source)));
    setAttribute(byId("flagged"), "aria-pressed", String(flagged));
    setAttribute(byId("filter-button"), "data-active", String(isFiltering()));
    for (const [kind, box] of this.kinds) box.checked = kinds.has(kind);
    byId("by-integrity", HTMLSelectElement).value = integrity;
    byId("watched-only", HTMLInputElement).checked = watchedOnly;
    setText(byId("height-unit"), heightWords());
    for (const [id, value] of /** @type {[string, number | null][]} */ ([["height-low", low], ["height-high", high]])) {
      byId(id, HTMLInputElement).value = value === null ? "" : plainHeight(value).replace("−", "-").replaceAll("\u2009", "");
    }
    this.showZones();
    byId("by-zone", HTMLSelectElement).value = zone;
  }

  /** The zones of the service, and the selected one even if it is unknown. */
  showZones() {
    const names = ["", ...new Set([...zoneNames(), ...(settings.zone ? [settings.zone] : [])])];
    const list = byId("by-zone", HTMLSelectElement);
    if (names.join("\n") === [...list.options].map(({ value }) => value).join("\n")) return;
    list.replaceChildren(...names.map((name) => element("option", { value: name }, name || "anywhere")));
    list.value = settings.zone;
  }

  /**
   * Note on the map that a filter is active: number shown, total ("?" if unknown), and the filter.
   * @param {number} shown @param {number | string} total
   */
  note(shown, total) {
    byId("filtered").hidden = !isFiltering();
    if (isFiltering()) setText(byId("filtered-text"), `${shown} of ${total} tracks shown: ${filterWords(height)}`);
  }
}
