// An alert in the list: its text, operator actions so far, and buttons for further ones.

import { element, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";
import { nameOf } from "./names.js";
import { change } from "./settings.js";

const SHELVES = [[15, "15 min"], [60, "1 h"], [240, "4 h"]]; // minutes
const LONGEST_MIN = 480; // the service's limit
const NOTE = 500; // characters; the service's limit

const time = (text) => format.utc(Date.parse(text));
const withNote = (words, note) => (note ? `${words}: ${note}` : words);

/** Ids of the tracks of an alert. */
export const tracksOf = ({ track, track_id, tracks }) => tracks ?? [track ?? track_id].filter(Boolean);

/** "acknowledged by desk at 12:03:20: seen"; empty without operator actions. */
export function whoOf({ acknowledged, shelved }) {
  const words = [];
  if (acknowledged) words.push(withNote(`acknowledged by ${acknowledged.by} at ${time(acknowledged.at)}`, acknowledged.note));
  if (shelved) words.push(withNote(`shelved until ${time(shelved.until)} by ${shelved.by} at ${time(shelved.at)}`, shelved.note));
  return words.join("; ");
}

/** Names of the aircraft of an alert. The service's text has their ids and whole serial numbers. */
export const whomOf = (alert) => tracksOf(alert).map(nameOf).join(" – ");

/** Severity, names and text, as in the list and in the history. */
export function headOf(alert) {
  const whom = whomOf(alert);
  return [element("span", { class: "severity" }, alert.severity), whom ? element("strong", {}, ` ${whom}: `) : " ", alert.text ?? alert.kind];
}

export class AlertItem {
  node = element("li");
  head = element("p");
  when = element("small");
  who = element("small", { class: "who" });
  acts = element("p", { class: "acts" });
  shown = ""; // data from which the head and the track buttons were made

  /** `act(alert, what, body)` performs an action; `next` returns the element that gets the focus afterwards. */
  constructor(act) {
    this.act = act;
    this.acknowledge = this.button("Acknowledge", () => this.do("acknowledge", {}));
    this.unshelve = this.button("Unshelve", () => this.do("unshelve", {}));
    this.more = this.button("Shelve, note…", () => this.unfold(this.form.hidden));
    this.tracks = element("span");
    this.acts.append(this.acknowledge, this.unshelve, this.more, this.tracks);
    this.form = this.makeForm();
    this.unfold(false);
    this.node.append(this.head, this.when, this.who, this.acts, this.form);
  }

  button(words, act) {
    const made = element("button", { type: "button" }, words);
    made.addEventListener("click", act);
    return made;
  }

  /** Form for a note and the duration of shelving. */
  makeForm() {
    this.note = element("input", { type: "text", maxlength: NOTE, autocomplete: "off" });
    this.minutes = element("input", { type: "number", min: 1, max: LONGEST_MIN, step: 1, required: true, value: 30 });
    const own = element("form", { class: "own" }, element("label", {}, "Other ", this.minutes, " min"), " ", element("button", {}, "Shelve"));
    own.addEventListener("submit", (event) => {
      event.preventDefault();
      this.shelve(Number(this.minutes.value));
    });
    this.noted = this.button("Acknowledge with the note", () => this.do("acknowledge", this.words()));
    const shelves = SHELVES.map(([minutes, words]) => this.button(words, () => this.shelve(minutes)));
    for (const [at, made] of shelves.entries()) setAttribute(made, "aria-label", `Shelve for ${SHELVES[at][1]}`);
    return element("div", { class: "alert-form" },
      element("p", {}, element("label", {}, "Note ", this.note)),
      element("p", {}, this.noted),
      element("p", {}, "Shelve for ", ...shelves, own));
  }

  words() {
    const note = this.note.value.trim();
    return note ? { note } : {};
  }

  shelve(minutes) {
    this.do("shelve", { minutes, ...this.words() });
  }

  unfold(isOpen) {
    this.form.hidden = !isOpen;
    setAttribute(this.more, "aria-expanded", String(isOpen));
    if (isOpen) this.note.focus({ preventScroll: true });
  }

  async do(what, body) {
    const isHere = this.node.contains(document.activeElement);
    if (!(await this.act(this.alert, what, body))) return;
    this.note.value = "";
    this.unfold(false);
    if (isHere) this.more.focus({ preventScroll: true }); // the button itself may have been removed
  }

  /** `isBarred`: the buttons only explain why they are disabled. */
  update(alert, isBarred) {
    this.alert = alert;
    const { severity, kind, text, since, acknowledged, shelved } = alert;
    setAttribute(this.node, "data-severity", severity);
    setAttribute(this.node, "data-seen", String(Boolean(acknowledged)));
    const ids = tracksOf(alert);
    const shown = JSON.stringify([severity, text, ids.map(nameOf)]);
    if (shown !== this.shown) {
      this.shown = shown;
      this.head.replaceChildren(...headOf(alert));
      this.tracks.replaceChildren(...ids.map((id) => this.button(`Select ${nameOf(id)}`, () => change({ selected: id }))));
    }
    setText(this.when, `${kind.replaceAll("-", " ")} · since ${format.date(Date.parse(since))} ${time(since)} UTC`);
    setText(this.who, whoOf(alert));
    this.acknowledge.hidden = this.noted.hidden = Boolean(acknowledged);
    this.unshelve.hidden = !shelved;
    for (const made of [this.acknowledge, this.unshelve, this.more]) setAttribute(made, "aria-disabled", String(isBarred));
  }
}
