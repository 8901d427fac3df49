// Current tracks, their trails and, if the service gives no speed, the speed derived from recent positions.

import { list } from "./api.js";
import { matches } from "./filter.js";
import { bearing } from "./geo.js";
import { idOf, nameTracks } from "./names.js";
import { onChange, TRAILS_S } from "./settings.js";

const TRAIL_STEP_MS = 1000; // one trail point per second is enough, and needs a quarter of the memory
const TRAIL_POINTS = Math.max(...TRAILS_S) + 4;
const RECENT_MS = 5000; // over a shorter time the radar's noise would look like speed
const RECENT_POINTS = 24;
const FORGET_MS = 60000; // a track that the service neither updates nor ends must disappear

const SAME_AIRCRAFT_M = 500; // distance of a 10 s gap at 50 m/s

/** @param {Track} track @param {Point} place */
const apart = (track, [x, y]) => Math.hypot(track.x - x, track.y - y);

/** Ring buffer of times and places; the oldest are overwritten. */
class Ring {
  next = 0;
  length = 0;
  last = -Infinity; // time of the latest place

  /** @param {number} size */
  constructor(size) {
    this.size = size;
    this.values = new Float64Array(size * 3);
  }

  clear() {
    this.next = 0;
    this.length = 0;
    this.last = -Infinity;
  }

  /** @param {number} time @param {number} x @param {number} y */
  push(time, x, y) {
    this.values.set([time, x, y], this.next * 3);
    this.next = (this.next + 1) % this.size;
    this.length = Math.min(this.length + 1, this.size);
    this.last = time;
  }

  /** @param {Ring} other */
  copy(other) {
    this.values.set(other.values);
    [this.next, this.length, this.last] = [other.next, other.length, other.last];
  }

  /** Moves each place to `to(x, y)`. @param {Move} to */
  move(to) {
    for (let i = 0; i < this.length; i++) {
      const at = this.at(i);
      this.values.set(to(this.values[at + 1], this.values[at + 2]), at + 1);
    }
  }

  /** Index in `values` of the i-th place, oldest first. @param {number} i */
  at(i) {
    return ((this.next - this.length + i + this.size) % this.size) * 3;
  }
}

export class Track {
  time = NaN;
  x = NaN; // metres east and north
  y = NaN;
  range = NaN; // distance from the radar, in metres
  bearing = NaN;
  speed = NaN; // metres per second
  course = NaN;
  derived = false; // speed and course are derived from recent positions

  /** @param {TrackData} properties */
  constructor(properties) {
    this.id = properties.id;
    this.properties = properties;
    this.source = properties.source;
    this.trail = new Ring(TRAIL_POINTS);
    this.recent = new Ring(RECENT_POINTS);
    this.place = 0; // previous position of its label
  }

  /** @param {TrackData} properties @param {Frame} frame */
  update(properties, frame) {
    this.properties = properties;
    this.source = properties.source;
    this.time = Date.parse(properties.time);
    this.locate(frame);
    if (this.time < this.recent.last) {
      this.trail.clear();
      this.recent.clear();
    }
    this.remember(properties.trail, frame);
    if (this.time > this.recent.last) this.recent.push(this.time, this.x, this.y);
    if (this.time >= this.trail.last + TRAIL_STEP_MS) this.trail.push(this.time, this.x, this.y);
    this.derived = !Number.isFinite(properties.speed);
    if (this.derived) this.deriveVelocity();
    else [this.speed, this.course] = [properties.speed ?? NaN, properties.track ?? NaN];
  }

  /** @param {Frame} frame */
  locate(frame) {
    [this.x, this.y] = frame.toLocal(this.properties.lat, this.properties.lng);
    // Without a radar the origin is arbitrary, so distances from it are meaningless.
    [this.range, this.bearing] = frame.isRadar ? [Math.hypot(this.x, this.y), bearing(this.x, this.y)] : [NaN, NaN];
  }

  /** Adds past positions from the service, where they are unknown. @param {TrackData["trail"]} trail @param {Frame} frame */
  remember(trail, frame) {
    trail?.times.forEach((text, i) => {
      const [time, [lng, lat]] = [Date.parse(text), trail.coordinates[i]];
      const [x, y] = frame.toLocal(lat, lng);
      for (const ring of [this.trail, this.recent]) if (time > ring.last) ring.push(time, x, y);
    });
  }

  /** Slope of a line fitted to the positions of the last seconds by least squares; NaN with less than about 1 s of them. */
  deriveVelocity() {
    [this.speed, this.course] = [NaN, NaN];
    const { values } = this.recent;
    let [n, st, sx, sy, stt, stx, sty] = [0, 0, 0, 0, 0, 0, 0];
    for (let i = 0; i < this.recent.length; i++) {
      const at = this.recent.at(i);
      const t = (values[at] - this.time) / 1000;
      if (t < -RECENT_MS / 1000) continue;
      const [x, y] = [values[at + 1] - this.x, values[at + 2] - this.y];
      n += 1;
      st += t;
      sx += x;
      sy += y;
      stt += t * t;
      stx += t * x;
      sty += t * y;
    }
    const spread = n * stt - st * st;
    if (n < 4 || spread < n * n * 0.08) return;
    const [east, north] = [(n * stx - st * sx) / spread, (n * sty - st * sy) / spread];
    this.speed = Math.hypot(east, north);
    if (this.speed >= 1) this.course = bearing(east, north); // a hovering drone has no course
  }

  get serial() {
    return idOf(this.properties.uas_id) || (this.properties.aircraft?.icao24 ?? "");
  }

  /** Key of the watch list: the identity of the aircraft is constant, its tracks may change. */
  get watchId() {
    return this.serial || this.id;
  }

  /** Track number, "30069", or the id if the service has ids only. */
  get name() {
    return this.properties.track_number != null ? String(this.properties.track_number) : this.id;
  }

  /** Crewed aircraft or ground vehicle, of known identity. */
  get isCrewed() {
    return this.properties.aircraft_type === "crewed";
  }

  get isVehicle() {
    return this.properties.aircraft_type === "vehicle";
  }

  /** Radar tracks may be birds; the classifier gives the probability of a drone. */
  get isDoubtful() {
    return this.source === "radar" && (this.properties.uav_probability ?? 1) < 0.5;
  }

  /** Unidentified, and possibly a drone. */
  get isUnknown() {
    return (this.source === "radar" && !this.isDoubtful) || this.source === "camera";
  }

  /** Not measured since or before: the position is extrapolated. */
  get isExtrapolated() {
    return this.properties.extrapolated === true;
  }
}

export class Picture {
  /** @type {Map<string, Track>} */
  tracks = new Map();
  /** @type {Map<string, Track>} */
  lastOf = new Map(); // last track of each aircraft, by serial number
  time = NaN;
  /** @type {Track[] | null} */
  shown = null; // tracks selected by the filter, until they change

  /** @param {Frame} frame */
  constructor(frame) {
    this.frame = frame;
    onChange(() => (this.shown = null));
  }

  /** Changes the frame; everything keeps its position on the ground. @param {Frame} frame */
  reframe(frame) {
    const before = this.frame;
    this.frame = frame;
    for (const track of new Set([...this.tracks.values(), ...this.lastOf.values()])) {
      for (const ring of [track.trail, track.recent]) ring.move((x, y) => frame.toLocal(...before.toGeodetic(x, y)));
      track.locate(frame);
    }
  }

  /**
   * Takes the whole picture: tracks missing in it are removed. Trails of the others are kept, unless time went back.
   * @param {TrackCollection} collection
   */
  snapshot(collection) {
    const features = list(collection, "features");
    const named = new Set(features.map((feature) => feature.properties.id));
    for (const id of this.tracks.keys()) if (!named.has(id)) this.tracks.delete(id);
    const time = Date.parse(collection.time);
    if (time < this.time) this.forget();
    this.update(collection);
  }

  /** Removes all tracks and trails, because the next picture is of another time. */
  forget() {
    this.tracks.clear();
    this.lastOf.clear();
    this.shown = null;
  }

  /** @param {TrackCollection} collection */
  update(collection) {
    this.shown = null;
    for (const { properties } of list(collection, "features")) {
      if (!Number.isFinite(properties.lat) || !Number.isFinite(properties.lng)) continue;
      let track = this.tracks.get(properties.id);
      if (!track) this.tracks.set(properties.id, (track = this.newTrack(properties)));
      track.update(properties, this.frame);
      if (track.serial) this.lastOf.set(track.serial, track);
    }
    const time = Date.parse(collection.time);
    if (Number.isFinite(time)) this.time = time;
    for (const known of [this.tracks, this.lastOf]) {
      for (const [key, track] of known) if (this.time - track.time > FORGET_MS) known.delete(key);
    }
    nameTracks([...this.tracks.values()], new Set(this.lastOf.keys()));
  }

  /**
   * In the reference profile an aircraft's id changes with its radar track; the new track keeps the trail.
   * @param {TrackData} properties
   */
  newTrack(properties) {
    const { uas_id, aircraft, lat, lng } = properties;
    const track = new Track(properties);
    const before = this.lastOf.get(idOf(uas_id) || (aircraft?.icao24 ?? ""));
    // Two distant tracks with the same serial number are different aircraft.
    if (before && apart(before, this.frame.toLocal(lat, lng)) < SAME_AIRCRAFT_M) track.trail.copy(before.trail);
    return track;
  }

  /** Track under which an aircraft continues after one of its tracks has ended; null if there is none. @param {Track} track */
  heirOf({ serial, x, y }) {
    if (!serial) return null;
    const near = [...this.tracks.values()]
      .filter((track) => track.serial === serial && apart(track, [x, y]) < SAME_AIRCRAFT_M)
      .sort((a, b) => apart(a, [x, y]) - apart(b, [x, y]));
    return near.find((track) => track.source === "fused") ?? near[0] ?? null;
  }

  /** @param {string[]} ids */
  end(ids) {
    this.shown = null;
    for (const id of ids) this.tracks.delete(id);
  }

  visible() {
    this.shown ??= [...this.tracks.values()].filter(matches);
    return this.shown;
  }
}
