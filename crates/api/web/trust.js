// Integrity of transponders: as text, as a mark that needs no colour, on the map, and with the operator's verdict.

import { post } from "./api.js";
import { element } from "./dom.js";
import * as format from "./format.js";
import { idOf, nameOf } from "./names.js";
import { palette } from "./palette.js";

/**
 * States: severity, mark in the table, and meaning.
 * @type {Record<string, [number, string, string] | undefined>}
 */
const STATES = {
  failed: [4, "✕", "failed: its position is not to be used"],
  suspect: [3, "?", "suspect: its position may be false"],
  uncooperative: [2, "!", "uncooperative: it flies without a transponder where one would be heard"],
  unverified: [1, "", "unverified: nothing independent speaks for or against it"],
  verified: [0, "✓", "verified: radar agrees"],
};

/** @type {Record<NonNullable<TrackProperties["reasons"]>[number], string>} */
const REASONS = {
  radar: "radar sees the aircraft elsewhere",
  jump: "its position jumped",
  frozen: "its position stands still to the last digit",
  replay: "it repeats earlier reports",
  duplicate: "two transmitters send under its serial number",
  swapped: "it changed places with another transponder",
  velocity: "the velocity that it states is not that of its positions",
  time: "its time stamps are off",
};

/**
 * Evidence that a transponder's position is false, from its integrity index: strong from the usual threshold on.
 * @param {number} index
 */
const evidence = (index) => (index >= 8.5 ? "strong" : index >= Math.log(20) ? "medium" : "low");

const SMALLEST_PX = 14; // minimum radius of a ring, so that the symbol does not hide it
/** @type {Record<string, [number, number] | undefined>} */
const DASHES = { suspect: [6, 4], failed: [12, 3] }; // distinguishable without colour

/** State of a track, including "uncooperative"; "" if integrity is not evaluated. @param {Track} track */
export const stateOf = ({ properties }) => (properties.uncooperative ? "uncooperative" : (properties.integrity ?? ""));
/** @param {Track} track */
export const isFlagged = (track) => (STATES[stateOf(track)]?.[0] ?? 0) >= 2;
/** @param {Track} track */
export const rankOf = (track) => STATES[stateOf(track)]?.[0];
/** @param {Track} track */
export const markOf = (track) => STATES[stateOf(track)]?.[1] ?? "";
/** @param {Track} track */
export const wordsOf = (track) => STATES[stateOf(track)]?.[2] ?? stateOf(track);

/** Properties about the integrity of a transponder. @param {Track} track @returns {Property[]} */
export function trustProperties(track) {
  const { reasons = [], integrity_index, protection_level_m, offset_m, linked = [] } = track.properties;
  /** @param {number | undefined} value */
  const metres = (value) => (Number.isFinite(value) ? format.metres(value) : null);
  return [
    ["Integrity", stateOf(track) && wordsOf(track)],
    ["Because", reasons.map((reason) => REASONS[reason] ?? reason).join("; ")],
    ["Off by", metres(offset_m)],
    ["Disputed with", linked.map(({ id }) => nameOf(id)).join(", ")],
    ["Evidence of a false position", Number.isFinite(integrity_index) ? evidence(integrity_index) : null, `Integrity index ${integrity_index?.toFixed(1)}`],
    ["Detectable offset", Number.isFinite(protection_level_m) ? `${metres(protection_level_m)} or more` : null],
  ];
}

/** Places on the screen by the id of the track. @param {Placed[]} placed @returns {Map<string, Point>} */
export const placesOf = (placed) => new Map(placed.map(([track, px, py]) => [track.id, [px, py]]));

/**
 * A dashed ring about a suspect or failed track, as large as the offset, and a line between disputed tracks.
 * @param {Context} context @param {View} view @param {Placed[]} placed
 */
export function drawTrust(context, view, placed) {
  context.save();
  const joined = new Set();
  const places = placesOf(placed);
  for (const [track, px, py] of placed) {
    const { integrity, offset_m, linked = [] } = track.properties;
    const colour = integrity === "failed" ? palette.critical : palette.warning;
    context.strokeStyle = colour;
    context.lineWidth = 2;
    const dashes = DASHES[integrity ?? ""];
    if (dashes) {
      context.setLineDash(dashes);
      context.beginPath();
      context.arc(px, py, Math.max(SMALLEST_PX, (offset_m ?? 0) * view.scale), 0, 2 * Math.PI);
      context.stroke();
    }
    context.setLineDash([2, 4]);
    for (const { id } of linked) {
      const other = places.get(id);
      if (!other || joined.has(`${id} ${track.id}`)) continue; // one line per pair
      joined.add(`${track.id} ${id}`);
      context.beginPath();
      context.moveTo(px, py);
      context.lineTo(...other);
      context.stroke();
    }
  }
  context.restore();
}

/** @typedef {"trusted" | "distrusted" | "automatic"} Verdict */

/** @type {[Verdict, string][]} */
const VERDICTS = [
  ["trusted", "It can be trusted"],
  ["distrusted", "It is not to be trusted"],
  ["automatic", "Judge it automatically"],
];

/** Operator verdicts on transponders, as received by the page. */
export class Verdicts {
  /** @type {Map<string, Verdict>} */
  said = new Map(); // "trusted" or "distrusted", by serial number and country

  /** Takes the answer of /integrity: transponders missing in it are unknown. @param {IdentityIntegrity[]} identities */
  replace(identities) {
    this.said.clear();
    for (const one of identities) this.note(one);
  }

  /** @param {IdentityIntegrity} one */
  note({ uas_id, verdict }) {
    if (verdict) this.said.set(keyOf(uas_id), verdict);
    else this.said.delete(keyOf(uas_id));
  }

  /**
   * Verdict on a track's transponder, with buttons if `decide` is given; null if there is nothing to show.
   * @param {Track} track @param {((transponder: UasId, verdict: Verdict) => void) | null} decide
   */
  section(track, decide) {
    const { uas_id, integrity } = track.properties;
    if (!uas_id || !integrity) return null;
    const said = this.said.get(keyOf(uas_id));
    const words = said ? `An operator has said: ${said}. ` : "";
    const others = decide ? VERDICTS.filter(([verdict]) => verdict !== (said ?? "automatic")) : [];
    const buttons = others.map(([verdict, text]) => {
      const button = element("button", { type: "button", id: `trust-${verdict}`, class: "decide" }, text);
      button.addEventListener("click", () => decide?.(uas_id, verdict));
      return button;
    });
    if (!words && !buttons.length) return null;
    return element("p", { class: "verdicts" }, words, ...buttons.flatMap((button) => [button, " "]));
  }
}

/** @param {UasId} uas */
const keyOf = (uas) => `${idOf(uas)} ${uas.registration_country ?? ""}`;

/** Records a verdict on a transponder, if the user may. @param {UasId} uas @param {Verdict} verdict */
export function say(uas, verdict) {
  const country = uas.registration_country ?? "none";
  return post(`integrity/${encodeURIComponent(idOf(uas))}`, { country }, { verdict });
}
