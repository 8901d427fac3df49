// Whether a transponder can be trusted: in words, as a mark that needs no colour, on the map, and what an operator says of it.

import { post } from "./api.js";
import { element } from "./dom.js";
import * as format from "./format.js";
import { idOf } from "./names.js";
import { palette } from "./palette.js";

/** Of each state: how bad it is, its mark in the table, and what it means. */
const STATES = {
  failed: [4, "✕", "failed: its position is not to be used"],
  suspect: [3, "?", "suspect: its position may be false"],
  uncooperative: [2, "!", "uncooperative: it flies without a transponder where one would be heard"],
  unverified: [1, "", "unverified: nothing independent speaks for or against it"],
  verified: [0, "✓", "verified: radar agrees"],
};

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

const SMALLEST_PX = 14; // a ring that the symbol does not hide
const DASHES = { suspect: [6, 4], failed: [12, 3] }; // told apart without colour, too

/** The state of a track, "uncooperative" included; "" where nothing is judged. */
export const stateOf = ({ properties }) => (properties.uncooperative ? "uncooperative" : (properties.integrity ?? ""));
export const isFlagged = (track) => STATES[stateOf(track)]?.[0] >= 2;
export const rankOf = (track) => STATES[stateOf(track)]?.[0];
export const markOf = (track) => STATES[stateOf(track)]?.[1] ?? "";
export const wordsOf = (track) => STATES[stateOf(track)]?.[2] ?? stateOf(track);

/** Heading and text of what is known; null where the service does not say. */
export function trustProperties(track) {
  const { reasons = [], integrity_index, protection_level_m, offset_m, linked = [] } = track.properties;
  const metres = (value) => (Number.isFinite(value) ? format.metres(value) : null);
  return [
    ["Integrity", stateOf(track) && wordsOf(track)],
    ["Because", reasons.map((reason) => REASONS[reason] ?? reason).join("; ")],
    ["Off by", metres(offset_m)],
    ["Disputed with", linked.map(({ id }) => id).join(", ")],
    ["Index of a lie", Number.isFinite(integrity_index) ? integrity_index.toFixed(1) : null],
    ["A lie would show beyond", metres(protection_level_m)],
  ];
}

/** A dashed ring as large as the offset around what is suspect or failed, and a line between those that dispute a place. */
export function drawTrust(context, view, placed) {
  context.save();
  const joined = new Set();
  const places = new Map(placed.map(([track, px, py]) => [track.id, [px, py]]));
  for (const [track, px, py] of placed) {
    const { integrity, offset_m, linked = [] } = track.properties;
    const colour = integrity === "failed" ? palette.critical : palette.warning;
    context.strokeStyle = colour;
    context.lineWidth = 2;
    if (DASHES[integrity]) {
      context.setLineDash(DASHES[integrity]);
      context.beginPath();
      context.arc(px, py, Math.max(SMALLEST_PX, (offset_m ?? 0) * view.scale), 0, 2 * Math.PI);
      context.stroke();
    }
    context.setLineDash([2, 4]);
    for (const { id } of linked) {
      const other = places.get(id);
      if (!other || joined.has(`${id} ${track.id}`)) continue; // one line for both
      joined.add(`${track.id} ${id}`);
      context.beginPath();
      context.moveTo(px, py);
      context.lineTo(...other);
      context.stroke();
    }
  }
  context.restore();
}

const VERDICTS = [
  ["trusted", "It can be trusted"],
  ["distrusted", "It is not to be trusted"],
  ["automatic", "Judge it automatically"],
];

/** What operators say of transponders, as far as the page has heard of it. */
export class Verdicts {
  said = new Map(); // "trusted" or "distrusted" by serial number and country

  /** The answer of /integrity: what it does not name is unknown. */
  replace(identities) {
    this.said.clear();
    for (const one of identities) this.note(one);
  }

  note({ uas_id, verdict }) {
    if (verdict) this.said.set(keyOf(uas_id), verdict);
    else this.said.delete(keyOf(uas_id));
  }

  /** What is said of a track's transponder, with buttons where `decide` is given; null where there is nothing to say. */
  section(track, decide) {
    const { uas_id, integrity } = track.properties;
    if (!uas_id || !integrity) return null;
    const said = this.said.get(keyOf(uas_id));
    const words = said ? `An operator has said: ${said}. ` : "";
    const buttons = VERDICTS.filter(([verdict]) => decide && verdict !== (said ?? "automatic")).map(([verdict, text]) => {
      const button = element("button", { type: "button", id: `trust-${verdict}`, class: "decide" }, text);
      button.addEventListener("click", () => decide(uas_id, verdict));
      return button;
    });
    if (!words && !buttons.length) return null;
    return element("p", { class: "verdicts" }, words, ...buttons.flatMap((button) => [button, " "]));
  }
}

const keyOf = (uas) => `${idOf(uas)} ${uas.registration_country ?? ""}`;

/** Says something of a transponder, for whoever may. */
export function say(uas, verdict) {
  const country = uas.registration_country ?? "none";
  return post(`integrity/${encodeURIComponent(idOf(uas))}`, { country }, { verdict });
}
