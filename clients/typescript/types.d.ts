// Made of /openapi.json and /api/v1/asyncapi.json by tests/readers/generate.rs; UPDATE=1 makes it anew.

/** What there is to ask for. */
export type About = {
  /** The coarsest zoom. */
  min_zoom: number;
  /** The finest zoom. */
  max_zoom: number;
  /** Whom the map is owed to. */
  attribution: string;
};

/** A track as readsb describes an aircraft. Only an aircraft that is heard by ADS-B has an ICAO address. Barometric heights are not known and left out. */
export type Aircraft = {
  /** ICAO address, six digits; of a track without one `~` and a hash of its id. */
  hex: string;
  /** `tisb_trackfile`: radar alone. */
  type: "adsb_icao" | "tisb_trackfile" | "other";
  lat: number;
  lon: number;
  seen: number;
  seen_pos: number;
  mlat: Array<unknown>;
  tisb: Array<unknown>;
  /** Emitter category of ADS-B, by which displays choose an icon: the one that the aircraft states, else B6 (unmanned) of a drone. Absent where neither is known. */
  category?: "A1" | "A2" | "A3" | "A4" | "A5" | "A6" | "A7" | "B1" | "B2" | "B3" | "B4" | "B6" | "B7" | "C1" | "C2" | "C3" | "C4" | "C5";
  /** ICAO type designator of a drone. tar1090 draws B6 alone as an aeroplane; for UHEL it takes the icon with rotors. */
  t?: "UHEL";
  /** Description of the type, shown beside `t`. */
  desc?: "Drone";
  /** Serial number of the transponder, else the track's id. */
  flight: string;
  /** Above the ellipsoid, feet. */
  alt_geom?: number;
  /** Ground speed, knots. */
  gs?: number;
  nac_p?: number;
  nac_v?: number;
  track?: number;
  /** Feet per minute. */
  geom_rate?: number;
  gva?: number;
};

/** What an aircraft says of itself by ADS-B. */
export type AircraftJson = {
  /** ICAO aircraft address, six hexadecimal digits. */
  icao24: string;
  callsign?: string;
  /** As in I021/020. */
  emitter_category?: number;
};

/** What is wrong, or was. */
export type Alert = {
  id: string;
  kind: "sensor" | "area" | "area-predicted" | "service" | "registration" | "integrity" | "jamming" | "silent" | "uncooperative" | "conflict" | "emergency";
  severity: "warning" | "critical";
  /** A time, RFC 3339, UTC. */
  since: string;
  /** In words. */
  text: string;
  /** Id of the sensor. */
  sensor?: string;
  /** Id of the track. */
  track?: string;
  /** Id of the conflict. */
  conflict?: string;
  /** Part of the service. */
  part?: string;
  /** Serial number of the transponder. */
  identity?: string;
  /** Id of its track. */
  track_id?: string;
  /** Id of the track that radar sees where it is not. */
  twin_id?: string;
  /** A state by its name. */
  state?: "unverified" | "verified" | "suspect" | "failed";
  /** What speaks against it; empty where only an operator does. */
  reasons?: Array<"radar" | "jump" | "frozen" | "replay" | "duplicate" | "swapped" | "velocity" | "time">;
  /** How far its positions are off, metres. */
  offset_m?: number;
  /** Ids of the tracks of both aircraft. */
  tracks?: Array<string>;
  /** Name of the volume that one may enter, or has entered. */
  volume?: string;
  /** Serial numbers of those that fell silent together. */
  identities?: Array<string>;
  /** Where they were heard last, with 100 m around it. */
  hull?: Hull;
  /** It has ended because a transponder was heard after all, or because it is the twin of one that lies. */
  resolved?: boolean;
  /** The area that the track is in, or about to enter. */
  area?: {
    name: string;
    /** Its authority's. */
    identifier?: string;
    type?: "prohibited" | "authorisation" | "conditional" | "u-space" | "no-restriction";
  };
  /** The area begins or ends at a height, and nobody knows that of the track. */
  height_unknown?: boolean;
  /** When the track enters if it flies on as it does, seconds; 0: it is inside by now. Left out while it would pass it by, and enter at a course one standard deviation beside its own. */
  time_to_entry_s?: number;
  /** The same at the earliest of its course and those one standard deviation beside it. */
  earliest_s?: number;
  /** Who has seen it; left out while nobody has, and again once it has become worse. */
  acknowledged?: {
    /** Who: the name of the token, or what was given. */
    by: string;
    /** A time, RFC 3339, UTC. */
    at: string;
    note?: string;
  };
  /** Nobody is to be bothered with it for a while. */
  shelved?: {
    /** Who says so: the name of the token, or what was given. */
    by: string;
    /** A time, RFC 3339, UTC. */
    at: string;
    /** A time, RFC 3339, UTC. */
    until: string;
    note?: string;
  };
  /** Left out while it lasts. */
  until?: string;
};

/** For how long nobody is to be bothered. */
export type AlertShelf = {
  /** For how long; at most 8 hours. */
  minutes: number;
  /** Who says so, where the service asks for no token: else it is the token's name. */
  by?: string | null;
  /** What is to be remembered with it. */
  note?: string | null;
};

/** Who has seen an alert. */
export type AlertWord = {
  /** Who says so, where the service asks for no token: else it is the token's name. */
  by?: string | null;
  /** What is to be remembered with it. */
  note?: string | null;
};

/** What is wrong, and what was. */
export type Alerts = {
  /** A time, RFC 3339, UTC. */
  time: string;
  /** Those that last, the worst first. */
  alerts: Array<Alert>;
  /** Those that ended, the latest first: the last 100, or as many as `limit`. The last 5000 are remembered while the service runs. */
  ended: Array<Alert>;
  /** Further ones that ended match and are left off. */
  more?: boolean;
};

export type Altitude = {
  /** Metres above the WGS-84 ellipsoid. */
  value: number;
  reference: "W84";
  units: "M";
};

export type AreaProperties = {
  kind: "mask" | "coverage" | "alert";
  name: string;
  /** Whose coverage it is. */
  sensor?: string;
  /** What its authority calls it. */
  identifier?: string;
  /** What holds in a UAS zone. */
  type?: "prohibited" | "authorisation" | "conditional" | "u-space" | "no-restriction";
  /** What of a UAS zone is in force under which conditions, in its authority's words. */
  conditions?: string;
  /** Lowest height, metres above mean sea level; left out from the ground up. */
  floor_m?: number;
  /** Highest height, metres above mean sea level; left out without a limit. */
  ceiling_m?: number;
  /** Whether it is in force now. */
  active: boolean;
  /** When that changes; left out where it does not. */
  changes_at?: string;
  /** When it is in force, in short. */
  hours: string;
  /** How bad it is to be inside; left out where it raises no alert. */
  severity?: "warning" | "critical";
  /** What its file is. */
  format: "geojson" | "ed-318" | "ed-269";
};

/** A cell. */
export type CellState = {
  /** Its name. */
  cell: string;
  /** The node that owns it; absent: nobody does. */
  owner?: string;
  /** The node that takes over when the owner falls silent; absent: nobody would. */
  standby?: string;
  /** The number of the owner's lease; greater than of whoever owned the cell before. */
  lease: number;
  /** Slots that the standby is behind. */
  behind: number;
  /** What is left out because its owner cannot keep up: a step of docs/SCALING.md, 0 for nothing. */
  step: number;
  /** The same in words. */
  left_out: string;
  /** Whether the picture is without it: nobody has published it for longer than a take-over takes. */
  is_missing: boolean;
  /** Whether the picture is without it because its owner has another configuration. */
  is_foreign: boolean;
  /** Where it is, longitude and latitude of its corners in degrees; empty: it is the whole site. */
  corners: Array<Array<number>>;
};

/** How far apart the clocks of two gateways are, by when both heard the same datagrams. */
export type ClockDifference = {
  /** One of them. */
  gateway: string;
  /** The other one. */
  other: string;
  /** The median of how much later the one stamps than the other one, seconds. */
  difference_s: number;
  /** Datagrams that were compared. */
  datagrams: number;
  /** They have been more than 20 ms apart, and not less than 15 ms since. */
  apart: boolean;
};

/** Who says how good a clock is. */
export type ClockSource = "chrony" | "kernel" | "systemd";

/** What a clock is worth. */
export type ClockStanding = "good" | "warning" | "degraded" | "unbounded" | "unsynchronised" | "unknown";

/** Why the stream ends. */
export type Closed = {
  reason: string;
};

/** A GeoJSON feature collection. */
export type CollectionOfFeatureOfAreaProperties = {
  /** A GeoJSON object with features. */
  type: "FeatureCollection";
  features: Array<FeatureOfAreaProperties>;
};

/** A GeoJSON feature collection. */
export type CollectionOfFeatureOfCoverageProperties = {
  /** A GeoJSON object with features. */
  type: "FeatureCollection";
  features: Array<FeatureOfCoverageProperties>;
};

/** A candidate that was not associated: for a radar track a transponder, for a transponder a radar track. */
export type Competitor = {
  /** Its configured id. */
  sensor: string;
  track_number?: number;
  uas_id?: TransponderId;
  /** Natural logarithm of the likelihood ratio of one aircraft to two. */
  log_likelihood_ratio: number;
  /** An operator has decided that it is another. */
  decorrelated?: boolean;
};

/** Two aircraft that may come near each other, and one of the volumes. */
export type Conflict = {
  /** The same for a pair as long as any level holds; left out where none does. */
  id?: string;
  /** Of the evaluation. */
  time: string;
  /** When both were there last, where one is missing now: the figures are of then. */
  seen?: string;
  /** Track id of one. */
  a: string;
  /** Track id of the other. */
  b: string;
  /** Name of the volume. */
  volume: string;
  level: "none" | "advisory" | "warning" | "violation";
  /** Since when the level holds. */
  since?: string;
  /** Time to the closest point of approach, seconds; 0 where they fly apart. */
  t_cpa_s: number;
  /** Distance over ground then, metres. */
  d_cpa_h_m: number;
  /** Difference of the heights then, metres; left out where one is not known. */
  d_cpa_v_m?: number;
  /** Distance over ground now, metres. */
  d_now_h_m: number;
  /** Difference of the heights now, metres; left out where one is not known. */
  d_now_v_m?: number;
  /** Of being within the volume at the closest point of approach. */
  probability: number;
  /** Whether the heights of both are known; where they are not, they count as the same. */
  vertical_known: boolean;
  miss: MissJson;
  cpa: CpaJson;
  /** The worse state of their transponders. */
  integrity?: "unverified" | "verified" | "suspect" | "failed";
};

/** Who will come near whom. */
export type Conflicts = {
  /** Of the positions; where nothing is computed, now. */
  time: string;
  /** Where it is false an empty list does not mean that there are none. */
  computed: boolean;
  /** Why they are not computed. */
  reason?: string;
  volumes: Array<Volume>;
  /** Aircraft that took part. */
  aircraft: number;
  /** Aircraft of which too little is known to take part. */
  left_out: number;
  /** The worst first, then the soonest. */
  conflicts: Array<Conflict>;
};

/** A sender that is refused under the SAC/SIC of a sensor. */
export type Contested = {
  /** Address and port of the sender that counts; with port 0 the host that `source` names. */
  counts: string;
  /** Address and port of the sender that is refused. */
  refused: string;
  /** `other_sender`: the one that counts was heard first. `foreign_source`: it is not a host that the sensor's inputs name as `source`. */
  reason: "other_sender" | "foreign_source";
  /** Serial numbers of the transponders that both report. */
  transponders: Array<string>;
};

/** A sensor's part in a track and, of a fused track's radar, why it was associated. */
export type Contributor = {
  kind: "radar" | "transponder" | "camera";
  /** Its configured id. */
  sensor: string;
  track_number: number;
  /** Of its measurement; of a camera, of the latest bearing that is used. */
  time?: string;
  /** Its share in the position, where that is fixed. */
  weight?: number;
  /** Whether the radar measured a height. */
  height_measured?: boolean;
  /** Between radar and transponder, metres. */
  distance_m?: number;
  /** Reference: gate, metres. */
  threshold_m?: number;
  /** Reference: share of the slots in which the distance was within the gate. */
  ratio?: number;
  /** Reference: slots within the gate. */
  within?: number;
  /** Reference: slots with both. */
  co_present?: number;
  /** Operational: an operator has decided that they are one. */
  manual?: boolean;
  /** Operational: natural logarithm of the likelihood ratio of one aircraft to two. */
  log_likelihood_ratio?: number;
  /** Operational: thresholds of that logarithm. */
  threshold?: Threshold;
  /** Operational, of a single track or with include=competitors: who else could be it, the likeliest first; of a radar track transponders, of a transponder radar tracks. */
  competitors?: Array<Competitor>;
};

export type Correlation = {
  /** Id of the radar. */
  sensor: string;
  track_number: number;
  uas_id: TransponderId;
  verdict: "correlated" | "decorrelated";
  /** Of the first slot that it applies to. */
  since: string;
};

/** Decisions of operators that are in force. */
export type Correlations = {
  correlations: Array<Correlation>;
};

export type CoverageProperties = {
  /** Its configured id. */
  sensor: string;
  kind: "radar" | "transponder" | "adsb" | "remote-id" | "camera";
  /** Area: as configured; circle: of the radar's range. */
  shape: "area" | "circle";
  max_range_m?: number;
};

/** Where both are at the closest point of approach: longitude, latitude (degrees), metres above the ellipsoid where known. */
export type CpaJson = {
  a: Array<number>;
  b: Array<number>;
};

/** An ellipse about a position. */
export type Ellipse = {
  /** Longer half axis, metres. */
  major_m: number;
  /** Shorter half axis, metres. */
  minor_m: number;
  /** Direction of the longer one, degrees true, 0 to 180. */
  azimuth_deg: number;
};

/** Tracks that ended. */
export type Ended = {
  /** A time, RFC 3339, UTC. */
  time: string;
  ids: Array<string>;
};

/** Unreadable blocks and records. */
export type Fault = {
  category: number | null;
  reason: string;
  count: number;
};

/** Something with a geometry, that has no id. */
export type FeatureOfAreaProperties = {
  type: "Feature";
  geometry: Geometry;
  properties: AreaProperties;
};

/** Something with a geometry. */
export type FeatureOfCoverageProperties = {
  type: "Feature";
  /** As in the properties. */
  id: string;
  geometry: Geometry | null;
  properties: CoverageProperties;
};

/** Something with a geometry. */
export type FeatureOfPastProperties = {
  type: "Feature";
  /** As in the properties. */
  id: string;
  /** A place. */
  geometry: {
    type: "Point";
    coordinates: Position;
  };
  properties: PastProperties;
};

/** Something with a geometry, that has no id. */
export type FeatureOfReportProperties = {
  type: "Feature";
  /** A place. */
  geometry: {
    type: "Point";
    coordinates: Position;
  };
  properties: ReportProperties;
};

/** Something with a geometry. */
export type FeatureOfSensorProperties = {
  type: "Feature";
  /** As in the properties. */
  id: string;
  /** A place. */
  geometry: {
    type: "Point";
    coordinates: Position;
  };
  properties: SensorProperties;
};

/** Something with a geometry. */
export type FeatureOfTrackProperties = {
  type: "Feature";
  /** As in the properties. */
  id: string;
  /** A place. */
  geometry: {
    type: "Point";
    coordinates: Position;
  };
  properties: TrackProperties;
};

/** Something with a geometry. */
export type FeatureOfTrailProperties = {
  type: "Feature";
  /** As in the properties. */
  id: string;
  geometry: Geometry;
  properties: TrailProperties;
};

/** GetFlightDetailsResponse. */
export type FlightDetails = {
  details: RIDFlightDetails;
};

/** GetFlightsResponse. */
export type Flights = {
  timestamp: RIDTime;
  flights: Array<RIDFlight>;
};

/** A gateway. */
export type GatewayState = {
  /** Its name. */
  node: string;
  /** Its lines. */
  lines: number;
  /** Messages that it wrote into the log. */
  written: number;
  /** Messages that wait for the log. */
  waiting: number;
  /** Datagrams that were dropped because the log was away for too long. */
  dropped: number;
  /** What its clock is worth. */
  clock: ClockStanding;
  /** Its clock is off by no more than this, seconds; absent: nobody knows. */
  clock_bound_s?: number;
  /** Who says so; absent: nobody does. */
  clock_by?: ClockSource;
  /** Its clock has not been synchronised for a minute or longer. */
  unfit: boolean;
  /** It publishes nothing, because of that: other gateways carry all that it hears. */
  silent: boolean;
  /** Datagrams that it did not publish while it was silent. */
  withheld: number;
  /** How far its clock is ahead of reference time, the median of the log's and the gateways' clocks, seconds; negative where it is behind; absent: not known yet. Beyond 1 s what it sends is refused. */
  clock_ahead_s?: number;
};

/** A place, a line, or an area. */
export type Geometry = {
  type: "Point";
  coordinates: Position;
} | {
  type: "LineString";
  coordinates: Array<Position>;
} | {
  type: "MultiLineString";
  coordinates: Array<Array<Position>>;
} | {
  type: "Polygon";
  coordinates: Array<Array<Position>>;
} | {
  type: "MultiPolygon";
  coordinates: Array<Array<Array<Position>>>;
};

/** That it is alive, or ready. */
export type Health = {
  status: "ok" | "ready";
};

/** Each second: that the service lives, and how it is. */
export type Heartbeat = {
  /** Of the latest slot. */
  time?: string;
  /** Of the latest slot. */
  seq: number;
  /** From the opening of the slot to its publication, seconds. */
  latency_s?: number;
  /** While the picture is late: by how much, seconds. */
  late_s?: number;
};

/** GeoJSON, RFC 7946. */
export type Hull = {
  type: "Polygon";
  coordinates: Array<Array<[number, number]>>;
};

/** What is known of a transponder. */
export type IdentityIntegrity = {
  /** Its serial number, as it is named in the path. */
  identity: string;
  uas_id: TransponderId;
  /** Id of its track, where it has one in the latest slot. */
  track_id?: string;
  /** A state by its name. */
  state: "unverified" | "verified" | "suspect" | "failed";
  /** When the state began. */
  since: string;
  /** Natural logarithm of how much likelier a lie is than none, by radar. */
  index: number;
  /** Radius that holds 95 % of the offsets that radar would not have shown by now, metres; left out where nothing bounds it. */
  protection_level_m?: number;
  /** Of a suspect or failed one: how far its positions are off. */
  offset?: IntegrityOffset;
  /** What speaks against it. */
  reasons: Array<"radar" | "jump" | "frozen" | "replay" | "duplicate" | "swapped" | "velocity" | "time">;
  /** Its newest report. */
  heard: string;
  /** It has fallen silent. */
  silent: boolean;
  /** What an operator says of it; left out where nobody has said anything. */
  verdict?: "trusted" | "distrusted";
  /** Of the first slot that the verdict applies to. */
  verdict_since?: string;
  /** Id of the track that radar sees where it is not. */
  twin_id?: string;
  /** The last radar tracks that it was compared with, the latest first. */
  evidence: Array<IntegrityEvidence>;
};

/** Version, site and the settings that a reader of the picture should know. */
export type Info = {
  name: "utm-fusion";
  version: string;
  site: Site;
  /** Geoid above ellipsoid at the site, metres. */
  geoid_separation: number;
  profile: "operational" | "reference";
  slot_s: number;
  /** From the opening of a slot until it is due, seconds. */
  latency_s: number;
  /** Whether there is a picture at=now as well. */
  now: boolean;
  /** Whether the picture is made by several machines (`/api/v1/cluster`). */
  cluster: boolean;
  /** A time, RFC 3339, UTC. */
  started: string;
  mode: "live" | "replay";
  auth: "none" | "tokens";
  /** Whether the token in use has the scope `control`. */
  control: boolean;
  settings: Settings;
  /** Where the page gets its map from. */
  tiles?: Tiles;
  /** The base map, from `/api/v1/basemap`. */
  basemap?: About;
  /** How far back the history goes at most, hours; absent where none is kept. */
  history_hours?: number;
  replay?: Replay;
};

/** What is known of the transponders that were heard in the last hour. */
export type Integrity = {
  /** Of the slot that it is known at. */
  time?: string;
  /** Whether it is judged at all: not in the reference profile, nor with `[integrity] action = "off"`. */
  computed: boolean;
  identities: Array<IdentityIntegrity>;
};

export type IntegrityEvidence = {
  /** Id of the radar. */
  sensor: string;
  track_number: number;
  /** Near: it was where the transponder says; far: it flies alike elsewhere. */
  kind: "near" | "far";
  /** The first second that counted. */
  from: string;
  /** How many seconds counted. */
  seconds: number;
  /** What it added to the index. */
  gain: number;
};

/** An offset over ground. */
export type IntegrityOffset = {
  east_m: number;
  north_m: number;
  /** East and north, m². */
  covariance_m2: Array<Array<number>>;
};

/** What an operator says. */
export type IntegrityVerdict = {
  /** It is what it says; it is not; or as the evidence has it. */
  verdict: "trusted" | "distrusted" | "automatic";
};

export type LatLngPoint = {
  lat: number;
  lng: number;
};

/** A radar's errors as they have shown themselves; operational profile only, where they are learnt. */
export type Learnt = {
  /** In a line. */
  summary: string;
  range_m: LearntErrors;
  azimuth_deg: LearntErrors;
  height_m: LearntErrors;
  velocity: LearntVelocity;
};

/** How late the times of reports are. */
export type LearntDelay = {
  value: number;
  /** Standard deviation. */
  deviation: number;
  /** As much of it as is evident: what reports are moved by. */
  applied: number;
};

/** The errors of one axis, in its unit. */
export type LearntErrors = {
  /** Bias and noise together over those of the data sheet. */
  of_data_sheet: LearntNumber;
  /** One standard deviation of the bias, turns included as often as they are flown. */
  bias: LearntNumber;
  /** Its correlation time. */
  correlation_s: LearntNumber;
  /** How many times as large it is in turns. */
  turn_factor: LearntNumber;
  /** One standard deviation of the white noise. */
  noise: LearntNumber;
  /** Independent samples of the bias that this rests upon; older ones count in part. */
  samples: number;
};

export type LearntNumber = {
  value: number;
  /** Standard deviation. */
  deviation: number;
};

/** What transponders of one make and model that this receiver hears have in common; operational profile only. */
export type LearntTransponderType = {
  /** I129/020, where it is sent. */
  manufacturer?: string;
  /** I129/030, where it is sent. */
  model?: string;
  /** In a line. */
  summary: string;
  /** Reports that the white noise rests upon. */
  reports: number;
  /** One standard deviation of the white noise, each axis over ground. */
  horizontal_m: LearntNumber;
  /** One standard deviation of the white noise in height. */
  vertical_m: LearntNumber;
  delay_s: LearntDelay;
};

/** Whether a radar's velocities (I048/200) are of use. */
export type LearntVelocity = {
  verdict: "unknown" | "used" | "ignored";
  /** How far they are off, each axis, once that is known. */
  error_m_s?: LearntNumber;
};

/** Datagrams of a multicast group or an address. */
export type Line = {
  name: string;
  joined: boolean;
  received: number;
  duplicates: number;
  foreign: number;
  queue_full: number;
  kernel_dropped: number;
  /** A time, RFC 3339, UTC. */
  last_received?: string;
  /** Of a connection: what was not translated, by reason. */
  untranslated?: Record<string, number>;
};

/** Another track that has to do with it. */
export type Link = {
  /** Its id. */
  id: string;
  /** Disputed: only one of both is where the aircraft is. */
  relation: "disputed";
};

/** The members of a cluster, as of a second ago at most. */
export type Members = {
  /** The region. */
  region: string;
  /** Its cells. */
  cells: Array<CellState>;
  /** Its nodes. */
  nodes: Array<NodeState>;
  /** Its gateways. */
  gateways: Array<GatewayState>;
  /** How far apart the clocks of each two gateways are that hear the same. */
  clocks: Array<ClockDifference>;
  /** Gateways that ought to be heard of, and have said nothing for 3 s. */
  missing_gateways: Array<string>;
  /** Members whose configuration is another one than this process's: which, and in what. */
  different: Array<string>;
  /** Slots that were shown here. */
  shown: number;
  /** Slots that came again after they, or later ones, had been shown. */
  doubled: number;
  /** Slots that nobody published. */
  missing: number;
  /** Aircraft of a slot that were left out because another cell published them, too. */
  twice: number;
  /** Slots of a cell that came when the region's picture of that slot had been shown without them. */
  too_late: number;
};

/** How b passes a, and how well that is known. */
export type MissJson = {
  /** Over ground, across the relative velocity, metres. */
  across_m: number;
  /** Metres, up. */
  vertical_m?: number;
  /** Covariance of both: across, then vertical, which is 0 where a height is not known. */
  covariance_m2: Array<Array<number>>;
};

/** A node. */
export type NodeState = {
  /** Its name. */
  node: string;
  /** The machine that it runs on. */
  machine: string;
  /** What it is: for one cell at least, where there are several. */
  part: "owner" | "standby" | "none" | "drained";
  /** Cells that it owns. */
  owns: Array<string>;
  /** Cells beside whose owner it stands. */
  stands_by: Array<string>;
  /** How often it became the owner. */
  takeovers: number;
  /** How often it was refused because somebody else owned the cell. */
  fenced: number;
  /** How often its state was not the owner's. */
  diverged: number;
  /** Slots that it published. */
  published: number;
  /** Checkpoints that it wrote. */
  checkpoints: number;
  /** How far its clock is ahead of reference time, the median of the log's and the gateways' clocks, seconds; negative where it is behind; absent: not known yet. */
  clock_ahead_s?: number;
};

export type OperatorLocation = {
  position: LatLngPoint;
  altitude?: Altitude;
  altitude_type: "Takeoff" | "Dynamic" | "Fixed";
};

/** Place of an operator. */
export type OperatorPlace = {
  /** WGS-84, degrees. */
  lat: number;
  /** WGS-84, degrees. */
  lng: number;
  /** Metres above the ellipsoid. */
  alt?: number;
  /** The place of take-off, measured, or fixed. */
  type: "Takeoff" | "Dynamic" | "Fixed";
};

export type PastPosition = {
  lat: number;
  lng: number;
  alt: number;
};

/** A track as the history has it. */
export type PastProperties = {
  id: string;
  source: "fused" | "radar" | "transponder";
  track_number: number;
  /** A time, RFC 3339, UTC. */
  time: string;
  lat: number;
  lng: number;
  /** Metres above mean sea level, where a height was measured. */
  alt_msl?: number;
};

export type Picture = {
  /** Seconds since 1970. */
  now: number;
  /** Datagrams received. */
  messages: number;
  aircraft: Array<Aircraft>;
};

/** Longitude and latitude, degrees, and the ellipsoidal height, metres, where it is known. */
export type Position = Array<number>;

/** RFC 9457. */
export type Problem = {
  type: "about:blank";
  title: string;
  status: number;
  detail: string;
  /** The parameter that is at fault. */
  parameter?: string;
  /** Several things at once, where a detail is not enough. */
  reasons?: Array<string>;
  /** When it is worth trying again, seconds. */
  retry_after_s?: number;
};

export type Quantiles = {
  p50: number;
  p95: number;
  p99: number;
};

export type RIDAircraftPosition = {
  lat: number;
  lng: number;
  /** Metres above the ellipsoid; -1000: unknown. */
  alt: number;
  accuracy_h: "HA1m" | "HA3m" | "HA10m" | "HA30m" | "HA005NM" | "HA01NM" | "HA03NM" | "HA05NM" | "HA1NM" | "HA2NM" | "HA4NM" | "HA10NM" | "HA10NMPlus" | "HAUnknown";
  accuracy_v: "VA1m" | "VA3m" | "VA10m" | "VA25m" | "VA45m" | "VA150m" | "VA150mPlus" | "VAUnknown";
  extrapolated: boolean;
};

export type RIDAircraftState = {
  timestamp: RIDTime;
  timestamp_accuracy: number;
  operational_status: "Undeclared" | "Ground" | "Airborne" | "Emergency" | "RemoteIDSystemFailure";
  position: RIDAircraftPosition;
  /** Degrees true; 361: unknown. */
  track: number;
  /** Metres per second; 255: unknown. */
  speed: number;
  speed_accuracy: "SA03mps" | "SA1mps" | "SA3mps" | "SA10mps" | "SA10mpsPlus" | "SAUnknown";
  /** Metres per second; 63: unknown. */
  vertical_speed: number;
  /** Above take-off or ground, as the drone declares it. */
  height?: RIDHeight;
};

export type RIDFlight = {
  id: string;
  aircraft_type: "NotDeclared" | "Aeroplane" | "Helicopter" | "Gyroplane" | "HybridLift" | "Ornithopter" | "Glider" | "Kite" | "FreeBalloon" | "CaptiveBalloon" | "Airship" | "FreeFallOrParachute" | "Rocket" | "TetheredPoweredAircraft" | "GroundObstacle" | "Other";
  simulated: boolean;
  current_state: RIDAircraftState;
  /** Only where `recent_positions_duration` asks for them. */
  recent_positions?: Array<RIDRecentAircraftPosition>;
};

export type RIDFlightDetails = {
  id: string;
  /** One of them. */
  uas_id: {
    serial_number: string;
  } | {
    registration_id: string;
  } | {
    utm_id: string;
  } | {
    specific_session_id: string;
  };
  operator_id?: string;
  operator_location?: OperatorLocation;
};

/** A height relative to a place. */
export type RIDHeight = {
  /** Metres. */
  distance: number;
  reference: "TakeoffLocation" | "GroundLevel";
};

export type RIDRecentAircraftPosition = {
  time: RIDTime;
  position: PastPosition;
};

export type RIDTime = {
  value: string;
  format: "RFC3339";
};

/** GeoJSON, RFC 7946. */
export type Raw = {
  /** A GeoJSON object with features. */
  type: "FeatureCollection";
  /** Number of the last report, for the next request's `after`. */
  last: number;
  features: Array<FeatureOfReportProperties>;
};

export type Receiver = {
  version: string;
  /** Milliseconds between two pictures. */
  refresh: number;
  /** 0: no history is served. */
  history: number;
  /** Of the first radar, degrees. */
  lat?: number;
  lon?: number;
};

/** Where a track was: times and places, the oldest first. */
export type RecentTrail = {
  times: Array<string>;
  coordinates: Array<Position>;
};

/** Records without a report. */
export type Refused = {
  sensor: string | null;
  reason: string;
  count: number;
};

/** Misalignment of a radar, estimated from its tracks; operational profile only, and without values where it is off. */
export type Registration = {
  mode: "apply" | "propose" | "off";
  /** Whether plots are corrected by any of it. */
  applied: boolean;
  /** Radar tracks that it rests upon; older ones count in part. */
  tracks?: number;
  /** 1: tracks differ as the configured errors predict; above 4: doubtful. */
  residual?: number;
  bearing_deg?: RegistrationValue;
  tilt_east_deg?: RegistrationValue;
  tilt_north_deg?: RegistrationValue;
  range_m?: RegistrationValue;
  height_m?: RegistrationValue;
  time_s?: RegistrationValue;
  /** What to look at where it is doubtful. */
  hint?: string;
  /** What to look at after a step, until it is an hour old. */
  alarm?: string;
  step?: RegistrationStep;
};

/** The latest step since the start: the radar may have been moved. */
export type RegistrationStep = {
  /** When it was detected. */
  time: string;
  /** Without the latest tracks. */
  before: RegistrationValues;
  /** With them alone. */
  after: RegistrationValues;
};

/** A bias: measured minus true. */
export type RegistrationValue = {
  /** 0 where a tilt is not observable. */
  value: number;
  /** Standard deviation. */
  deviation: number;
  /** Whether the tracks determine it well enough to be of use; only then is it applied. */
  observable: boolean;
};

export type RegistrationValues = {
  bearing_deg: RegistrationValue;
  tilt_east_deg: RegistrationValue;
  tilt_north_deg: RegistrationValue;
  range_m: RegistrationValue;
  height_m: RegistrationValue;
  time_s: RegistrationValue;
};

/** What a drone declares by Remote ID beside identity and position. */
export type RemoteIdDeclaration = {
  ua_type?: "NotDeclared" | "Aeroplane" | "Helicopter" | "Gyroplane" | "HybridLift" | "Ornithopter" | "Glider" | "Kite" | "FreeBalloon" | "CaptiveBalloon" | "Airship" | "FreeFallOrParachute" | "Rocket" | "TetheredPoweredAircraft" | "GroundObstacle" | "Other";
  operational_status?: "Undeclared" | "Ground" | "Airborne" | "Emergency" | "RemoteIDSystemFailure";
  height?: RIDHeight;
  /** The operator's registration. */
  operator_id?: string;
  operator_location?: OperatorPlace;
};

/** A broadcast of Remote ID that a gateway received. Other members are ignored. */
export type RemoteIdLine = {
  /** Time of reception; without it, the time at which the line arrives. */
  time?: number | string | null;
  /** Address of the transmitter, or another name of it; at most 64 octets. */
  transmitter: string;
  /** Strength of the signal, dBm. */
  rssi?: number | null;
  /** Id of the sensor that received it. */
  receiver?: string | null;
  /** The message or the pack, hexadecimal. */
  message: string;
};

/** What came of the lines. */
export type RemoteIdPosted = {
  /** Lines, blank ones apart. */
  lines: number;
  /** Lines that were handed to the engine. What it does not use of them is counted with the sensor. */
  taken: number;
  /** Lines that were not, by reason; the others beside them stand. */
  refused: Record<string, number>;
};

/** How a replay is. */
export type Replay = {
  playing: boolean;
  /** How many times faster than it happened. */
  speed: number;
  ended: boolean;
  /** Of the slot shown last. */
  time?: string;
  /** Of the recording. */
  start?: string;
  /** Of the recording; left out until it is known. */
  end?: string;
};

/** A report of a radar or a transponder. */
export type ReportProperties = {
  /** Its configured id. */
  sensor: string;
  /** A time, RFC 3339, UTC. */
  time: string;
} & ({
  kind: "radar";
  track_number: number;
  /** That it is a drone, according to the radar. */
  uav_probability?: number;
} | {
  kind: "transponder";
  serial_number: string;
});

/** Why everything begins anew. */
export type Resync = {
  reason: string;
};

/** What is unknown is left out. */
export type SensorProperties = {
  /** As configured. */
  id: string;
  kind: "radar" | "transponder" | "adsb" | "remote-id" | "camera";
  sac?: number;
  sic?: number;
  state?: "operational" | "degraded" | "outage";
  /** Why it is not operational. */
  reasons?: Array<string>;
  /** Reports per second, over the last 10 s. */
  rate_hz?: number;
  accepted?: number;
  /** Records without a report, by reason. */
  refused?: Record<string, number>;
  lines?: Array<Line>;
  /** Of its last record of any kind. */
  last_seen?: string;
  /** From the times of its reports to their reception, seconds: the least of the last ones. */
  clock_offset_s?: number;
  contested?: Array<Contested>;
  registration?: Registration;
  learnt?: Learnt;
  transponder_types?: Array<LearntTransponderType>;
};

/** GeoJSON, RFC 7946. */
export type Sensors = {
  /** A GeoJSON object with features. */
  type: "FeatureCollection";
  unknown: Array<UnknownSource>;
  features: Array<FeatureOfSensorProperties>;
  /** Of the sensors' states. */
  time?: string;
};

/** Health with reasons, latency, counters. */
export type ServiceStatus = {
  /** A time, RFC 3339, UTC. */
  time: string;
  state: "ok" | "degraded";
  /** Whether the picture can be used. */
  ready: boolean;
  /** Why it is not ok. */
  reasons: Array<string>;
  /** A time, RFC 3339, UTC. */
  started: string;
  uptime_s: number;
  /** Number of the latest slot. */
  seq: number;
  /** Open streams. */
  streams: number;
  /** How much later than configured the picture is, seconds. */
  late_s?: number;
  /** Files of the state directory that cannot be written: a restart would lose what they hold. */
  state_failing: Array<string>;
  /** From the opening of a slot to its publication, seconds. */
  latency_s?: Quantiles;
  /** From when a slot was due to its publication, seconds. */
  lateness_s?: Quantiles;
  failed_sends?: number;
  tally?: Tally;
};

/** As configured in `[fusion]`. */
export type Settings = {
  motion: "imm" | "singer";
  window_s: number;
  max_future_s: number;
  max_gap_s: number;
  /** Rows of slant range and association distance, metres. */
  threshold_m: Array<[number, number]>;
  ratio_min: number;
  min_samples: number;
  weight_radar: number;
  weight_transponder: number;
  radar_only_min_s: number;
  suppress_s: number;
};

export type Site = {
  name: string;
  sac: number;
  sic: number;
};

/** Blocks of categories that are not used. */
export type Skipped = {
  category: number;
  count: number;
};

/** The picture at a past time: GeoJSON, RFC 7946. */
export type Snapshot = {
  /** A GeoJSON object with features. */
  type: "FeatureCollection";
  /** A time, RFC 3339, UTC. */
  time: string;
  /** Its configured name. */
  site: string;
  numberMatched: number;
  numberReturned: number;
  features: Array<FeatureOfPastProperties>;
};

/** An event of the stream */
export type StreamMessage = {
  event: "snapshot";
  id: string;
  data: Tracks;
} | {
  event: "tracks";
  id: string;
  data: Tracks;
} | {
  event: "ended";
  id: string;
  data: Ended;
} | {
  event: "sensor";
  id: string;
  data: SensorProperties;
} | {
  event: "integrity";
  id: string;
  data: IdentityIntegrity;
} | {
  event: "alert";
  id: string;
  data: Alert;
} | {
  event: "conflict";
  id: string;
  data: Conflict;
} | {
  event: "heartbeat";
  id: string;
  data: Heartbeat;
} | {
  event: "resync";
  id: string;
  data: Resync;
} | {
  event: "closed";
  id: string;
  data: Closed;
};

/** Counts since the start. */
export type Tally = {
  /** Datagrams. */
  received: number;
  octets: number;
  duplicates: number;
  /** Reports, by sensor, in the order of the configuration. */
  accepted: Record<string, number>;
  /** Service messages, by sensor. */
  service: Record<string, number>;
  faults: Array<Fault>;
  refused: Array<Refused>;
  skipped: Array<Skipped>;
  several_records: number;
  unknown_sources: number;
  restarts: number;
  clock_behind: number;
  dropped: number;
};

/** Where an association begins and ends: logarithms of likelihood ratios. */
export type Threshold = {
  /** A pair is associated above it. */
  join: number;
  /** And separated below it. */
  part: number;
};

/** A ticket for one stream. */
export type Ticket = {
  /** Given to `/api/v1/stream` as its parameter `ticket`. */
  ticket: string;
  expires_in_s: number;
};

export type Tiles = {
  url: string;
  attribution: string;
};

/** A track. What is unknown is left out; in the reference profile that includes motion and accuracy. */
export type TrackProperties = {
  /** Operational: one per aircraft, U-…; reference: F-…, R-…, T-…, which change with its sources. */
  id: string;
  source: "fused" | "radar" | "transponder";
  track_number: number;
  /** Coasting: nothing has been measured since; the position is extrapolated. */
  state: "active" | "coasting";
  /** Of the position. */
  time: string;
  /** WGS-84, degrees. */
  lat: number;
  /** WGS-84, degrees. */
  lng: number;
  /** Metres above the ellipsoid, where a height was measured. */
  alt?: number;
  /** Metres above mean sea level, where a height was measured. */
  alt_msl?: number;
  /** Geoid above ellipsoid, metres. */
  geoid_separation: number;
  /** Over ground, metres per second. */
  speed?: number;
  /** Direction over ground, degrees true; left out where it could be any. */
  track?: number;
  /** Metres per second, up. */
  vertical_speed?: number;
  /** Radius that holds 95 % of the horizontal error, as the filter estimates it, metres. */
  accuracy_h_m?: number;
  /** Bound of 95 % of the vertical error, metres. */
  accuracy_v_m?: number;
  /** Class of `accuracy_h_m` in ASTM F3411. */
  accuracy_h?: "HA1m" | "HA3m" | "HA10m" | "HA30m" | "HA005NM" | "HA01NM" | "HA03NM" | "HA05NM" | "HA1NM" | "HA2NM" | "HA4NM" | "HA10NM" | "HA10NMPlus";
  /** Class of `accuracy_v_m` in ASTM F3411. */
  accuracy_v?: "VA1m" | "VA3m" | "VA10m" | "VA25m" | "VA45m" | "VA150m" | "VA150mPlus";
  /** Of a predicted position (at=now): holds 95 % of the horizontal error. */
  accuracy_ellipse?: Ellipse;
  /** Operational: the position lies between two measurements; reference: there is a transponder. */
  interpolated: boolean;
  /** The position lies after the last measurement or before the first. */
  extrapolated: boolean;
  /** Probability that it is a drone, according to the radar. */
  uav_probability?: number;
  /** What it is taken for. */
  aircraft_type: "drone" | "crewed" | "vehicle" | "other" | "unknown";
  uas_id?: UasId;
  aircraft?: AircraftJson;
  /** What a drone declares by Remote ID. */
  remote_id?: RemoteIdDeclaration;
  /** Operational: whether its transponder can be trusted; docs/INTEGRITY.md. */
  integrity?: "unverified" | "verified" | "suspect" | "failed";
  /** Natural logarithm of how much likelier a lie of its transponder is than none, by radar. */
  integrity_index?: number;
  /** Radius that holds 95 % of the offsets that radar would not have shown by now, metres; left out where nothing bounds it. */
  protection_level_m?: number;
  /** Of a suspect or failed one, how far it is from where radar sees it, metres. */
  offset_m?: number;
  /** What speaks against its transponder. */
  reasons?: Array<"radar" | "jump" | "frozen" | "replay" | "duplicate" | "swapped" | "velocity" | "time">;
  /** Tracks that claim to be the same aircraft elsewhere. */
  linked?: Array<Link>;
  /** It flies without a transponder where one is to be heard. */
  uncooperative?: boolean;
  /** Centre of the first slot with it. */
  first_seen: string;
  /** The latest one up to `time`, of any sensor; left out before the first. */
  last_measurement?: string;
  contributors: Array<Contributor>;
  /** From its time to its publication. */
  age_s: number;
  /** With trail_s. */
  trail?: RecentTrail;
};

/** GeoJSON, RFC 7946. */
export type Tracks = {
  /** A GeoJSON object with features. */
  type: "FeatureCollection";
  /** `now`: the picture of the deadline itself, predicted; left out where it is the slot's own. */
  at?: "now";
  /** Of the tracks: the centre of the slot. */
  time?: string;
  /** When the slot was published. */
  published_at?: string;
  /** From the opening of the slot to its publication, seconds. */
  latency_s?: number;
  seq: number;
  /** Its configured name. */
  site: string;
  numberMatched: number;
  numberReturned: number;
  /** Where `limit` has left some out: what `after` takes for the next page. */
  next?: string;
  /** Written one by one, behind all others. */
  features: Array<FeatureOfTrackProperties>;
};

export type TrailProperties = {
  id: string;
  /** Of each place. */
  times: Array<string>;
  /** Of each place. */
  sources: Array<"fused" | "radar" | "transponder">;
  /** Of each place, metres above mean sea level; null where no height was measured. */
  alt_msl: Array<number | null>;
};

/** What tells a transponder from all others. */
export type TransponderId = {
  serial_number: string;
  /** ISO 3166-1 alpha-2. */
  registration_country?: string;
};

/** Identity of a drone as it reports it, by one of the kinds of ASTM F3411. */
export type UasId = {
  serial_number?: string;
  /** Given by an authority. */
  registration_id?: string;
  /** Given by a traffic management service for a flight: a UUID. */
  utm_id?: string;
  /** Of a session: 20 octets, hexadecimal; the first octet says of which kind. */
  specific_session_id?: string;
  manufacturer?: string;
  model?: string;
  /** ISO 3166-1 alpha-2. */
  registration_country?: string;
};

/** A source that is no configured sensor. */
export type UnknownSource = {
  category: number;
  sac: number;
  sic: number;
  /** The service's own output comes back. */
  own: boolean;
  records: number;
  /** A time, RFC 3339, UTC. */
  last_seen: string;
};

/** A volume that aircraft keep around themselves. */
export type Volume = {
  name: string;
  /** Radius, metres. */
  horizontal_m: number;
  /** Half of its height, metres. */
  vertical_m: number;
  /** Modified tau up to which it counts as entered, seconds; 0: it does not. */
  tau_s: number;
};

/** What is answered to GET, by path. */
export interface Answers {
  "/api/v1/tracks": Tracks;
  "/api/v1/tracks/{id}": FeatureOfTrackProperties;
  "/api/v1/tracks/{id}/trail": FeatureOfTrailProperties;
  "/api/v1/snapshot": Snapshot;
  "/api/v1/correlations": Correlations;
  "/api/v1/integrity": Integrity;
  "/api/v1/raw": Raw;
  "/api/v1/sensors": Sensors;
  "/api/v1/status": ServiceStatus;
  "/api/v1/cluster": Members;
  "/api/v1/info": Info;
  "/api/v1/coverage": CollectionOfFeatureOfCoverageProperties;
  "/api/v1/areas": CollectionOfFeatureOfAreaProperties;
  "/api/v1/alerts": Alerts;
  "/api/v1/conflicts": Conflicts;
  "/data/aircraft.json": Picture;
  "/data/receiver.json": Receiver;
  "/uss/flights": Flights;
  "/uss/flights/{id}/details": FlightDetails;
  "/healthz": Health;
  "/readyz": Health;
  "/openapi.json": Record<string, unknown>;
  "/api/v1/asyncapi.json": Record<string, unknown>;
}

/** What is answered to POST, by path. */
export interface Orders {
  "/api/v1/correlations": Correlations;
  "/api/v1/integrity/{identity}": Integrity;
  "/api/v1/remote-id": RemoteIdPosted;
  "/api/v1/replay/play": Replay;
  "/api/v1/replay/pause": Replay;
  "/api/v1/replay/seek": Replay;
  "/api/v1/replay/speed": Replay;
  "/api/v1/stream-tickets": Ticket;
  "/api/v1/alerts/{id}/acknowledge": Alert;
  "/api/v1/alerts/{id}/shelve": Alert;
  "/api/v1/alerts/{id}/unshelve": Alert;
}

/** What a path takes, in it and behind the ?. */
export interface Parameters {
  "/api/v1/tracks": { bbox?: string; source?: string | string[]; class?: string | string[]; integrity?: string | string[]; sensor?: string | string[]; alt_min?: number; alt_max?: number; ids?: string | string[]; max_accuracy_m?: number; limit?: number; trail_s?: number; include?: string; at?: "lagged" | "now"; after?: string };
  "/api/v1/tracks/{id}": { id: string };
  "/api/v1/tracks/{id}/trail": { id: string; since?: string; until?: string; format?: "geojson" | "gpx" | "kml" | "csv" };
  "/api/v1/snapshot": { time: string };
  "/api/v1/correlations": { sensor?: string; track?: number; uas?: string; country?: string; verdict?: "correlated" | "decorrelated" | "automatic" };
  "/api/v1/integrity": {};
  "/api/v1/integrity/{identity}": { identity: string; country?: string };
  "/api/v1/remote-id": {};
  "/api/v1/replay/play": {};
  "/api/v1/replay/pause": {};
  "/api/v1/replay/seek": { time: string };
  "/api/v1/replay/speed": { speed: number };
  "/api/v1/stream": { bbox?: string; source?: string | string[]; class?: string | string[]; integrity?: string | string[]; sensor?: string | string[]; alt_min?: number; alt_max?: number; ids?: string | string[]; max_accuracy_m?: number; limit?: number; trail_s?: number; include?: string; at?: "lagged" | "now"; interval_ms?: number; ticket?: string };
  "/api/v1/stream/ws": { bbox?: string; source?: string | string[]; class?: string | string[]; integrity?: string | string[]; sensor?: string | string[]; alt_min?: number; alt_max?: number; ids?: string | string[]; max_accuracy_m?: number; limit?: number; trail_s?: number; include?: string; at?: "lagged" | "now"; interval_ms?: number; ticket?: string; last_event_id?: string };
  "/api/v1/stream-tickets": {};
  "/api/v1/raw": { after?: number };
  "/api/v1/sensors": {};
  "/api/v1/basemap": { z: number; x: number; y: number };
  "/api/v1/status": {};
  "/api/v1/cluster": {};
  "/api/v1/info": {};
  "/api/v1/coverage": {};
  "/api/v1/areas": {};
  "/api/v1/alerts": { since?: string; until?: string; kind?: string | string[]; limit?: number };
  "/api/v1/alerts/{id}/acknowledge": { id: string };
  "/api/v1/alerts/{id}/shelve": { id: string };
  "/api/v1/alerts/{id}/unshelve": { id: string };
  "/api/v1/conflicts": { level?: "none" | "advisory" | "warning" | "violation"; id?: string };
  "/data/aircraft.json": {};
  "/data/receiver.json": {};
  "/uss/flights": { view: string; recent_positions_duration?: number };
  "/uss/flights/{id}/details": { id: string };
  "/healthz": {};
  "/readyz": {};
  "/metrics": {};
  "/openapi.json": {};
  "/api/v1/asyncapi.json": {};
  "/api/docs": {};
  "/": {};
}
