// Export of the shown data: tracks and trails as GeoJSON, KML or CSV, the map as an image. Nothing is sent anywhere.

import { element } from "./dom.js";
import { settings } from "./settings.js";

/** @type {Record<"geojson" | "kml" | "csv", [string, (picture: Picture) => string]>} */
const FORMATS = {
  geojson: ["application/geo+json", geojson],
  kml: ["application/vnd.google-earth.kml+xml", kml],
  csv: ["text/csv;charset=utf-8", csv],
};

/** @param {string} name @param {string} type @param {string} text */
export const saveText = (name, type, text) => save(name, new Blob([text], { type }));

/** @param {string} name @param {Blob} blob */
function save(name, blob) {
  const url = URL.createObjectURL(blob);
  element("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000); // after the browser has started to read it
}

/** @param {Picture} picture @param {string} ending */
const fileName = (picture, ending) => `tracks-${new Date(picture.time).toISOString().slice(0, 19).replaceAll(":", "")}Z.${ending}`;

/** Exports the tracks selected by the filter. @param {Picture} picture @param {keyof typeof FORMATS} format */
export function exportTracks(picture, format) {
  const [type, write] = FORMATS[format];
  saveText(fileName(picture, format), type, write(picture));
}

/** @param {Picture} picture @param {HTMLCanvasElement} canvas */
export function exportPicture(picture, canvas) {
  canvas.toBlob((blob) => blob && save(fileName(picture, "png"), blob), "image/png");
}

/** Trail of a track, [[lng, lat], ...], oldest first, of the length shown. @param {Track} track @param {Picture} picture */
function trailOf({ trail }, { frame, time }) {
  /** @type {Point[]} */
  const places = [];
  for (let i = 0; i < trail.length; i++) {
    const at = trail.at(i);
    if (time - trail.values[at] > settings.trailS * 1000) continue;
    const [lat, lng] = frame.toGeodetic(trail.values[at + 1], trail.values[at + 2]);
    places.push([Number(lng.toFixed(7)), Number(lat.toFixed(7))]);
  }
  return places;
}

/** Parts of a trail, cut at the antimeridian (RFC 7946, section 3.1.9). @param {Point[]} trail */
function cutTrail(trail) {
  /** @type {Point[]} */
  let line = [];
  const lines = [line];
  trail.forEach(([lng, lat], i) => {
    const apart = i ? lng - trail[i - 1][0] : 0;
    if (Math.abs(apart) > 180) {
      const [fromLng, fromLat] = trail[i - 1];
      const edge = apart < 0 ? 180 : -180;
      const crossing = fromLat + ((edge - fromLng) / (apart + 2 * edge)) * (lat - fromLat);
      line.push([edge, crossing]);
      lines.push((line = [[-edge, crossing]]));
    }
    line.push([lng, lat]);
  });
  return lines;
}

/** @param {Picture} picture @returns {[Track, Point[]][]} */
const withTrails = (picture) => picture.visible().map((track) => [track, settings.layers.trails ? trailOf(track, picture) : []]);

/** @param {Picture} picture */
function geojson(picture) {
  const features = withTrails(picture).flatMap(([track, trail]) => {
    const { trail: _, ...properties } = track.properties;
    const { id, lng, lat, alt } = properties;
    const here = { type: "Feature", id, geometry: { type: "Point", coordinates: alt == null ? [lng, lat] : [lng, lat, alt] }, properties };
    const lines = cutTrail(trail);
    const geometry = lines.length > 1 ? { type: "MultiLineString", coordinates: lines } : { type: "LineString", coordinates: trail };
    const line = { type: "Feature", geometry, properties: { trail_of: id } };
    return trail.length > 1 ? [here, line] : [here];
  });
  return JSON.stringify({ type: "FeatureCollection", time: new Date(picture.time).toISOString(), features });
}

/** @param {unknown} text */
const xml = (text) => String(text).replace(/[<>&"']/g, (character) => `&#${character.charCodeAt(0)};`);

/** KML heights are above mean sea level. Tracks without a height, and all trails, are on the ground. @param {Picture} picture */
function kml(picture) {
  const places = withTrails(picture).map(([track, trail]) => {
    const { lng, lat, alt_msl, source, time } = track.properties;
    const point = Number.isFinite(alt_msl)
      ? `<altitudeMode>absolute</altitudeMode><coordinates>${lng},${lat},${alt_msl}</coordinates>`
      : `<coordinates>${lng},${lat}</coordinates>`;
    const line = trail.length > 1 ? `<LineString><tessellate>1</tessellate><coordinates>${trail.map((place) => place.join(",")).join(" ")}</coordinates></LineString>` : "";
    return `<Placemark><name>${xml(track.serial || track.name)}</name><description>${xml(source)}</description><TimeStamp><when>${xml(time)}</when></TimeStamp><MultiGeometry><Point>${point}</Point>${line}</MultiGeometry></Placemark>`;
  });
  return `<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="http://www.opengis.net/kml/2.2"><Document>\n${places.join("\n")}\n</Document></kml>\n`;
}

/** @type {(keyof TrackData)[]} */
const COLUMNS = ["id", "source", "track_number", "time", "lat", "lng", "alt_msl", "speed", "track", "vertical_speed", "accuracy_h_m", "accuracy_v_m", "uav_probability", "integrity"];

/** Transponders may send any text, so cells that a spreadsheet would take for formulas are made text. @param {unknown} value */
function cell(value) {
  if (value == null) return "";
  if (typeof value !== "string") return String(value);
  const text = /^[=+\-@\t\r]/.test(value) ? `'${value}` : value;
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** @param {Picture} picture */
function csv(picture) {
  const lines = picture.visible().map(({ properties, serial }) => [...COLUMNS.map((name) => properties[name]), serial].map(cell).join(","));
  return [[...COLUMNS, "serial_number"].join(","), ...lines, ""].join("\r\n");
}
