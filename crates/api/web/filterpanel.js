// Controls of the filter: the field and buttons above the table, the panel, and the note on the map.

import { byId, element, setAttribute, setText } from "./dom.js";
import { filterWords, zoneNames } from "./filter.js";
import { change, clearFilter, INTEGRITIES, isFiltering, KINDS, settings, toggled } from "./settings.js";
import { height, heightWords, metresOf, plainHeight } from "./units.js";

export class FilterPanel {
  sources = [...byId("sources").children];

  constructor() {
    byId("filter").addEventListener("submit", (event) => event.preventDefault());
    byId("filter-input").addEventListener("input", (event) => change({ text: event.target.value.trim() }));
    for (const button of this.sources) {
      button.addEventListener("click", () => change({ sources: toggled(settings.sources, button.dataset.source) }));
    }
    byId("flagged").addEventListener("click", () => change({ flagged: !settings.flagged }));
    for (const id of ["filter-clear", "filter-clear-all"]) byId(id).addEventListener("click", clearFilter);
    for (const [id, name] of [["height-low", "low"], ["height-high", "high"]]) {
      byId(id).addEventListener("change", (event) => change({ [name]: metresOf(event.target.value) }));
    }
    for (const [kind, words] of Object.entries(KINDS)) {
      const box = element("input", { type: "checkbox", name: kind });
      box.addEventListener("change", () => change({ kinds: toggled(settings.kinds, kind) }));
      byId("kinds").append(element("label", {}, box, words));
    }
    byId("by-integrity").append(element("option", { value: "" }, "any"), ...INTEGRITIES.map((name) => element("option", {}, name)));
    byId("by-integrity").addEventListener("change", (event) => change({ integrity: event.target.value }));
    byId("by-zone").addEventListener("change", (event) => change({ zone: event.target.value }));
    byId("watched-only").addEventListener("change", (event) => change({ watchedOnly: event.target.checked }));
  }

  show() {
    const { text, sources, flagged, kinds, integrity, zone, watchedOnly, low, high } = settings;
    if (byId("filter-input").value !== text) byId("filter-input").value = text;
    for (const button of this.sources) setAttribute(button, "aria-pressed", String(sources.has(button.dataset.source)));
    setAttribute(byId("flagged"), "aria-pressed", String(flagged));
    setAttribute(byId("filter-button"), "data-active", String(isFiltering()));
    for (const box of byId("kinds").querySelectorAll("input")) box.checked = kinds.has(box.name);
    byId("by-integrity").value = integrity;
    byId("watched-only").checked = watchedOnly;
    setText(byId("height-unit"), heightWords());
    for (const [id, value] of [["height-low", low], ["height-high", high]]) byId(id).value = value === null ? "" : plainHeight(value).replace("−", "-").replaceAll("\u2009", "");
    this.showZones();
    byId("by-zone").value = zone;
  }

  /** The zones of the service, and the selected one even if it is unknown. */
  showZones() {
    const names = ["", ...new Set([...zoneNames(), ...(settings.zone ? [settings.zone] : [])])];
    const list = byId("by-zone");
    if (names.join("\n") === [...list.options].map(({ value }) => value).join("\n")) return;
    list.replaceChildren(...names.map((name) => element("option", { value: name }, name || "anywhere")));
    list.value = settings.zone;
  }

  /** Note on the map that a filter is active: number shown, total ("?" if unknown), and the filter. */
  note(shown, total) {
    byId("filtered").hidden = !isFiltering();
    if (isFiltering()) setText(byId("filtered-text"), `${shown} of ${total} tracks shown: ${filterWords(height)}`);
  }
}
