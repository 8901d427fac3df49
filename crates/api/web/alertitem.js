// A situation in the list: its text, advice, operator actions so far, and buttons for further ones.

import { adviceOf } from "./advice.js";
import { element, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";

/** @type {[number, string][]} */
const SHELVES = [[15, "15 min"], [60, "1 h"], [240, "4 h"]]; // minutes
const LONGEST_MIN = 480; // the service's limit
const NOTE = 500; // characters; the service's limit

/** @param {string} text */
const time = (text) => format.utc(Date.parse(text));
/** @param {string} words @param {string | undefined} note */
const withNote = (words, note) => (note ? `${words}: ${note}` : words);

/** Ids of the tracks of an alert. @param {Alert} alert */
export function tracksOf({ track, track_id, tracks }) {
  const one = track ?? track_id;
  return tracks ?? (one ? [one] : []);
}

/** "acknowledged by desk at 12:03:20: seen"; empty without operator actions. @param {Alert} alert */
export function whoOf({ acknowledged, shelved }) {
  const words = [];
  if (acknowledged) words.push(withNote(`acknowledged by ${acknowledged.by} at ${time(acknowledged.at)}`, acknowledged.note));
  if (shelved) words.push(withNote(`shelved until ${time(shelved.until)} by ${shelved.by} at ${time(shelved.at)}`, shelved.note));
  return words.join("; ");
}

/** Severity and text, as in the list, the toast and the history. @param {Alert} alert */
export const headOf = (alert) => [element("span", { class: "severity" }, severityOf(alert)), " ", alert.text ?? alert.kind];

/** Severity that counts: of an ended alert the highest that it had. @param {Alert} alert */
export const severityOf = ({ severity, worst, latched }) => (latched ? (worst ?? severity) : severity);

export class AlertItem {
  node = element("li");
  head = element("p");
  when = element("small");
  who = element("small", { class: "who" });
  acts = element("p", { class: "acts" });
  note = element("input", { type: "text", maxlength: NOTE, autocomplete: "off" });
  minutes = element("input", { type: "number", min: 1, max: LONGEST_MIN, step: 1, required: true, value: 30 });
  /** @type {HTMLButtonElement | null} */
  centre = null; // shows the aircraft, if there are any
  shown = ""; // data from which the head was made

  /**
   * `act(alert, what, body)` performs an action; `go(ids)` shows these tracks on the map.
   * @param {Alert} alert @param {(alert: Alert, what: AlertAction, body: object) => Promise<boolean>} act
   * @param {(ids: string[]) => void} go
   */
  constructor(alert, act, go) {
    this.alert = alert;
    this.act = act;
    this.go = go;
    this.acknowledge = this.button("Acknowledge", () => this.do("acknowledge", {}));
    this.unshelve = this.button("Unshelve", () => this.do("unshelve", {}));
    this.more = this.button("Shelve, note…", () => this.unfold(Boolean(this.form.hidden)));
    this.acts.append(this.acknowledge, this.unshelve, this.more);
    this.noted = this.button("Acknowledge with the note", () => this.do("acknowledge", this.words()));
    this.form = this.makeForm();
    this.unfold(false);
    this.node.append(this.head, this.when, this.who, this.acts, this.form);
  }

  /**
   * The text; as a button that shows the aircraft if there are any. The button keeps the focus when the text changes.
   * @param {Alert} alert @param {boolean} hasTracks
   */
  showHead(alert, hasTracks) {
    this.centre ??= hasTracks ? this.button("", () => this.go(tracksOf(this.alert))) : null;
    if (this.centre) {
      setAttribute(this.centre, "class", "situation");
      setAttribute(this.centre, "title", "Show on the map");
      this.centre.replaceChildren(...headOf(alert));
      if (!this.centre.parentNode) this.head.replaceChildren(this.centre);
    } else {
      this.head.replaceChildren(...headOf(alert));
    }
  }

  /** @param {string} words @param {() => void} act */
  button(words, act) {
    const made = element("button", { type: "button" }, words);
    made.addEventListener("click", act);
    return made;
  }

  /** Form for a note and the duration of shelving. */
  makeForm() {
    const own = element("form", { class: "own" }, element("label", {}, "Other ", this.minutes, " min"), " ", element("button", {}, "Shelve"));
    own.addEventListener("submit", (event) => {
      event.preventDefault();
      this.shelve(Number(this.minutes.value));
    });
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

  /** @param {number} minutes */
  shelve(minutes) {
    this.do("shelve", { minutes, ...this.words() });
  }

  /** @param {boolean} isOpen */
  unfold(isOpen) {
    this.form.hidden = !isOpen;
    setAttribute(this.more, "aria-expanded", String(isOpen));
    if (isOpen) this.note.focus({ preventScroll: true });
  }

  /** @param {AlertAction} what @param {object} body */
  async do(what, body) {
    const isHere = this.node.contains(document.activeElement);
    if (!(await this.act(this.alert, what, body))) return;
    this.note.value = "";
    this.unfold(false);
    if (isHere) this.more.focus({ preventScroll: true }); // the button itself may have been removed
  }

  /** `isBarred`: the buttons only explain why they are disabled. @param {Alert} alert @param {boolean} isBarred */
  update(alert, isBarred) {
    this.alert = alert;
    const { text, since, until, acknowledged, shelved } = alert;
    const severity = severityOf(alert);
    setAttribute(this.node, "data-severity", severity);
    setAttribute(this.node, "data-seen", String(Boolean(acknowledged)));
    setAttribute(this.node, "data-over", String(Boolean(until)));
    const hasTracks = tracksOf(alert).length > 0;
    const shown = JSON.stringify([severity, text, hasTracks]);
    if (shown !== this.shown) {
      this.shown = shown;
      this.showHead(alert, hasTracks);
    }
    const when = until ? `${time(since)} to ${time(until)} UTC` : `since ${time(since)} UTC`;
    setText(this.when, [when, until ? "" : adviceOf(alert)].filter(Boolean).join(" · "));
    setAttribute(this.when, "title", `${alert.kind.replaceAll("-", " ")}, ${format.date(Date.parse(since))}`);
    setText(this.who, whoOf(alert));
    this.acknowledge.hidden = this.noted.hidden = Boolean(acknowledged);
    this.unshelve.hidden = !shelved;
    this.more.hidden = Boolean(until);
    for (const made of [this.acknowledge, this.unshelve, this.more]) setAttribute(made, "aria-disabled", String(isBarred));
  }
}
