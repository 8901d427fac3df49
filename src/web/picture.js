// The tracks now, their trails and, where the service gives no speed, what their last positions say of it.

import { list } from "./api.js";
import { matches } from "./filter.js";
import { bearing } from "./geo.js";
import { idOf } from "./names.js";
import { onChange, TRAILS_S } from "./settings.js";

const TRAIL_STEP_MS = 1000; // one trail point a second is enough to see, and a quarter of the memory
const TRAIL_POINTS = TRAILS_S.at(-1) + 4;
const RECENT_MS = 5000; // shorter and the radar's noise is taken for speed
const RECENT_POINTS = 24;
const FORGET_MS = 60000; // a track that the service neither renews nor ends must not stay for ever

const SAME_AIRCRAFT_M = 500; // a gap of 10 s at 50 m/s

const apart = (track, [x, y]) => Math.hypot(track.x - x, track.y - y);

/** Times and places, the oldest overwritten. */
class Ring {
  constructor(size) {
    this.size = size;
    this.values = new Float64Array(size * 3);
    this.clear();
  }

  clear() {
    this.next = 0;
    this.length = 0;
    this.last = -Infinity;
  }

  push(time, x, y) {
    this.values.set([time, x, y], this.next * 3);
    this.next = (this.next + 1) % this.size;
    this.length = Math.min(this.length + 1, this.size);
    this.last = time;
  }

  copy(other) {
    this.values.set(other.values);
    [this.next, this.length, this.last] = [other.next, other.length, other.last];
  }

  /** Each place to where `to(x, y)` has it. */
  move(to) {
    for (let i = 0; i < this.length; i++) {
      const at = this.at(i);
      this.values.set(to(this.values[at + 1], this.values[at + 2]), at + 1);
    }
  }

  /** Where the i-th is in `values`, the oldest first. */
  at(i) {
    return ((this.next - this.length + i + this.size) % this.size) * 3;
  }
}

class Track {
  constructor(id) {
    this.id = id;
    this.trail = new Ring(TRAIL_POINTS);
    this.recent = new Ring(RECENT_POINTS);
    this.place = 0; // where its label was last
  }

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
    else [this.speed, this.course] = [properties.speed, properties.track ?? NaN];
  }

  locate(frame) {
    [this.x, this.y] = frame.toLocal(this.properties.lat, this.properties.lng);
    // Without a radar the origin is any place, and a distance from it says nothing.
    [this.range, this.bearing] = frame.isRadar ? [Math.hypot(this.x, this.y), bearing(this.x, this.y)] : [NaN, NaN];
  }

  /** Where the service says that it was, where that is not known. */
  remember(trail, frame) {
    trail?.times.forEach((text, i) => {
      const [time, [lng, lat]] = [Date.parse(text), trail.coordinates[i]];
      const [x, y] = frame.toLocal(lat, lng);
      for (const ring of [this.trail, this.recent]) if (time > ring.last) ring.push(time, x, y);
    });
  }

  /** The slope of a straight line through the last seconds' positions, least squares; NaN with about 1 s of them. */
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
    if (this.speed >= 1) this.course = bearing(east, north); // a thing that hovers has no course
  }

  get serial() {
    return idOf(this.properties.uas_id) || (this.properties.aircraft?.icao24 ?? "");
  }

  /** Under which it is on the watch list: who an aircraft is stays the same, its tracks may not. */
  get watchId() {
    return this.serial || this.id;
  }

  /** "30069", or the id where the service numbers by id alone. */
  get name() {
    return this.properties.track_number != null ? String(this.properties.track_number) : this.id;
  }

  /** Somebody is on board, or it is a vehicle on the ground: who it is, is known. */
  get isCrewed() {
    return this.properties.aircraft_type === "crewed";
  }

  get isVehicle() {
    return this.properties.aircraft_type === "vehicle";
  }

  /** Radar tracks are birds too; the classifier says how much it believes in a drone. */
  get isDoubtful() {
    return this.source === "radar" && this.properties.uav_probability < 0.5;
  }

  /** Nobody has identified it, and it may well be a drone. */
  get isUnknown() {
    return this.source === "radar" && !this.isDoubtful;
  }

  /** Nothing has been measured since, or nothing before: where it is is where it should be. */
  get isExtrapolated() {
    return this.properties.extrapolated === true;
  }
}

export class Picture {
  tracks = new Map();
  lastOf = new Map(); // the track that an aircraft had last, by serial number
  time = NaN;
  shown = null; // the tracks that the filter lets through, until they are others

  constructor(frame) {
    this.frame = frame;
    onChange(() => (this.shown = null));
  }

  /** The same in another frame: everything stays where it is on the ground. */
  reframe(frame) {
    const before = this.frame;
    this.frame = frame;
    for (const track of new Set([...this.tracks.values(), ...this.lastOf.values()])) {
      for (const ring of [track.trail, track.recent]) ring.move((x, y) => frame.toLocal(...before.toGeodetic(x, y)));
      track.locate(frame);
    }
  }

  /** The whole picture: what it does not name is gone. Trails of what stays are kept, unless time went back. */
  snapshot(collection) {
    const features = list(collection, "features");
    const named = new Set(features.map((feature) => feature.properties.id));
    for (const id of this.tracks.keys()) if (!named.has(id)) this.tracks.delete(id);
    const time = Date.parse(collection.time);
    if (time < this.time) this.forget();
    this.update(collection);
  }

  /** Trails and all: what comes next is of another time. */
  forget() {
    this.tracks.clear();
    this.lastOf.clear();
    this.shown = null;
  }

  update(collection) {
    this.shown = null;
    for (const { properties, geometry } of list(collection, "features")) {
      const [lng, lat] = geometry?.coordinates ?? [];
      const whole = { lat, lng, ...properties };
      if (!Number.isFinite(whole.lat) || !Number.isFinite(whole.lng)) continue;
      let track = this.tracks.get(whole.id);
      if (!track) this.tracks.set(whole.id, (track = this.newTrack(whole)));
      track.update(whole, this.frame);
      if (track.serial) this.lastOf.set(track.serial, track);
    }
    const time = Date.parse(collection.time);
    if (Number.isFinite(time)) this.time = time;
    for (const known of [this.tracks, this.lastOf]) {
      for (const [key, track] of known) if (this.time - track.time > FORGET_MS) known.delete(key);
    }
  }

  /** In the reference profile an aircraft's id changes with its radar track: the trail behind it is still its own. */
  newTrack({ id, uas_id, aircraft, lat, lng }) {
    const track = new Track(id);
    const before = this.lastOf.get(idOf(uas_id) || aircraft?.icao24);
    // Two that say the same serial number are not one aircraft where they are far apart.
    if (before && apart(before, this.frame.toLocal(lat, lng)) < SAME_AIRCRAFT_M) track.trail.copy(before.trail);
    return track;
  }

  /** The track that an aircraft goes on under after one of its tracks has ended; null where there is none. */
  heirOf({ serial, x, y }) {
    if (!serial) return null;
    const near = [...this.tracks.values()]
      .filter((track) => track.serial === serial && apart(track, [x, y]) < SAME_AIRCRAFT_M)
      .sort((a, b) => apart(a, [x, y]) - apart(b, [x, y]));
    return near.find((track) => track.source === "fused") ?? near[0] ?? null;
  }

  end(ids) {
    this.shown = null;
    for (const id of ids) this.tracks.delete(id);
  }

  visible() {
    this.shown ??= [...this.tracks.values()].filter(matches);
    return this.shown;
  }
}
