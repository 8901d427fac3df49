// Numbers and times as text. Unknown values are a dash.

const DASH = "–";
export const THIN = "\u2009";

/** @param {number | undefined} value @param {number} [digits] */
export const metres = (value, digits = 0) =>
  Number.isFinite(value) ? `${grouped(value, digits)}${THIN}m` : DASH;
/** @param {number | undefined} value */
export const direction = (value) =>
  Number.isFinite(value) ? `${String(Math.round(value) % 360).padStart(3, "0")}°` : DASH;
/** @param {number | undefined} value */
export const percent = (value) => (Number.isFinite(value) ? `${Math.round(value * 100)}${THIN}%` : DASH);
/** @param {number | undefined} value @param {number} [digits] */
export const seconds = (value, digits = 1) => (Number.isFinite(value) ? `${value.toFixed(digits)}${THIN}s` : DASH);

/** Four digits stay together; longer numbers are grouped by thin spaces. @param {number} value @param {number} [digits] */
export function grouped(value, digits = 0) {
  const [whole, rest] = Math.abs(value).toFixed(digits).split(".");
  const groups = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, THIN) : whole;
  const isNegative = value < 0 && /[1-9]/.test(groups + (rest ?? "")); // a value that rounds to zero has no sign
  return `${isNegative ? "−" : ""}${groups}${rest ? `.${rest}` : ""}`;
}

/** Time of day hh:mm:ss in UTC, from milliseconds since 1970. @param {number | null} ms @param {number} [fraction] */
export const utc = (ms, fraction = 0) =>
  Number.isFinite(ms) ? new Date(ms).toISOString().slice(11, fraction ? 20 + fraction : 19) : DASH;
/** @param {number | null} ms */
export const date = (ms) => (Number.isFinite(ms) ? new Date(ms).toISOString().slice(0, 10) : DASH);

/** "03:15:20 UTC", with the date if it is not that of `now`. @param {number | null} ms @param {number} now */
export const moment = (ms, now) => `${date(ms) === date(now) ? "" : `${date(ms)} `}${utc(ms)} UTC`;

/** h:mm:ss from seconds, for the position in a recording. @param {number} value */
export function clock(value) {
  if (!Number.isFinite(value)) return DASH;
  const whole = Math.max(0, Math.floor(value));
  /** @param {number} number */
  const two = (number) => String(number % 60).padStart(2, "0");
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60))}:${two(whole)}`;
}

/** Heading from a key: "queue_full" becomes "Queue full". @param {string} name */
export function heading(name) {
  const words = name.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** Text of any value of an answer: "sac 25, sic 200, own no". @param {unknown} value @returns {string} */
export function words(value) {
  if (value == null) return DASH;
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (typeof value === "string" && /^\d{4}-\d\d-\d\dT/.test(value)) return `${date(Date.parse(value))} ${utc(Date.parse(value))} UTC`;
  if (Array.isArray(value)) return value.map(words).join("; ") || "none";
  if (typeof value !== "object") return String(value);
  return Object.entries(value).map(([name, inner]) => `${name.replaceAll("_", " ")} ${words(inner)}`).join(", ") || "none";
}

/** Position as 52.51416° N 0.57552° W. @param {number} lat @param {number} lng */
export const position = (lat, lng) =>
  `${Math.abs(lat).toFixed(5)}°${THIN}${lat < 0 ? "S" : "N"} ${Math.abs(lng).toFixed(5)}°${THIN}${lng < 0 ? "W" : "E"}`;

/** Duration: "3 min 20 s". @param {number | undefined} value */
export function duration(value) {
  if (!Number.isFinite(value)) return DASH;
  const whole = Math.max(0, Math.round(value));
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return h ? `${h}${THIN}h ${m}${THIN}min` : m ? `${m}${THIN}min ${s}${THIN}s` : `${s}${THIN}s`;
}
