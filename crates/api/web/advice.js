// Advice to the operator by kind of alert. The texts of the other kinds include it.

/** @type {Partial<Record<Alert["kind"], string>>} */
const ADVICE = {
  area: "Call its operator: it has to leave.",
  "area-predicted": "Call its operator before it enters.",
  conflict: "Call both operators: they have to separate.",
  emergency: "Clear its way, and call its operator.",
  jamming: "Warn operators there; rely on radar.",
  sensor: "Check the sensor, its line and its power.",
  service: "Call the administrator.",
  silent: "Call its operator; rely on radar.",
  uncooperative: "Find its operator; warn traffic nearby.",
};

/** The advice; "" if the text of the alert has it. @param {Alert} alert */
export const adviceOf = ({ kind }) => ADVICE[kind] ?? "";
