// Made of /openapi.json and /api/v1/asyncapi.json by tests/readers/generate.rs; UPDATE=1 makes it anew.

/** Description of the base map. */
export type About = {
  /** Lowest zoom level. */
  min_zoom: number;
  /** Highest zoom level. */
  max_zoom: number;
  /** Copyright notice of the map. */
  attribution: string;
};

/** A track in the format of a readsb aircraft. Only an aircraft with ADS-B has an ICAO address. Barometric heights are unknown and left out. */
export type Aircraft = {
  /** ICAO address, six digits. For a track without one, `~` and a hash of its id. */
  hex: string;
  /** `tisb_trackfile` means radar only. */
  type: "adsb_icao" | "tisb_trackfile" | "other";
  lat: number;
  lon: number;
  seen: number;
  seen_pos: number;
  mlat: Array<unknown>;
  tisb: Array<unknown>;
  /** Emitter category of ADS-B, by which displays choose an icon: the reported one, else B6 (unmanned) for a drone. Left out if neither is known. */
  category?: "A1" | "A2" | "A3" | "A4" | "A5" | "A6" | "A7" | "B1" | "B2" | "B3" | "B4" | "B6" | "B7" | "C1" | "C2" | "C3" | "C4" | "C5";
  /** ICAO type designator of a drone. tar1090 draws B6 alone as an aeroplane; for UHEL it uses the rotorcraft icon. */
  t?: "UHEL";
  /** Description of the type, shown beside `t`. */
  desc?: "Drone";
  /** Serial number of the transponder, else the id of the track. */
  flight: string;
  /** Height above the ellipsoid, in feet. */
  alt_geom?: number;
  /** Ground speed, in knots. */
  gs?: number;
  nac_p?: number;
  nac_v?: number;
  track?: number;
  /** Vertical rate, in feet per minute. */
  geom_rate?: number;
  gva?: number;
};

/** Properties that an aircraft reports by ADS-B. */
export type AircraftJson = {
  /** ICAO aircraft address, six hexadecimal digits. */
  icao24: string;
  /** Callsign, or flight identification. */
  callsign?: string;
  /** Emitter category, as in I021/020. */
  emitter_category?: number;
};

/** An alert, active or ended. */
export type Alert = {
  id: string;
  kind: "sensor" | "area" | "area-predicted" | "service" | "registration" | "integrity" | "jamming" | "silent" | "height" | "uncooperative" | "conflict" | "emergency";
  severity: "warning" | "critical";
  /** A UTC time, RFC 3339. */
  since: string;
  /** Highest severity so far, if it is not the present one. */
  worst?: "warning" | "critical";
  /** Text of the alert. It names aircraft as the map does. */
  text: string;
  /** Id of the sensor. */
  sensor?: string;
  /** Id of the track. */
  track?: string;
  /** Id of the conflict. */
  conflict?: string;
  /** Affected part of the service. */
  part?: string;
  /** Serial number of the transponder. */
  identity?: string;
  /** Id of the transponder's track. */
  track_id?: string;
  /** Id of the track that radar sees elsewhere, most likely the real aircraft. */
  twin_id?: string;
  /** Name of an integrity state. */
  state?: "unverified" | "verified" | "suspect" | "failed";
  /** Reasons against the transponder; empty if only an operator distrusts it. */
  reasons?: Array<"radar" | "jump" | "frozen" | "replay" | "duplicate" | "swapped" | "velocity" | "time">;
  /** Error of its reported position, in metres. */
  offset_m?: number;
  /** How far its heights are above those of radars, metres. */
  height_offset_m?: number;
  /** Ids of the tracks of all aircraft that are in conflict with one another; the pair of the highest level first. */
  tracks?: Array<string>;
  /** Name of the protection volume that is, or is about to be, infringed. */
  volume?: string;
  /** Closest approach of the situation so far. */
  closest?: {
    /** A UTC time, RFC 3339. */
    at: string;
    /** Distance over ground, metres. */
    horizontal_m: number;
    /** Difference of the heights, metres; absent if unknown. */
    vertical_m?: number;
  };
  /** Whether a protection volume is entered now. */
  entered?: boolean;
  /** Serial numbers of the transponders that fell silent together. */
  identities?: Array<string>;
  /** Area of their last positions, with a margin of 100 m. */
  hull?: Hull;
  /** Ended because a transponder was received after all, or because the drone is the twin of a suspect transponder. */
  resolved?: boolean;
  /** The area that the track is inside, or about to enter. */
  area?: {
    name: string;
    /** Identifier given by the authority. */
    identifier?: string;
    type?: "prohibited" | "authorisation" | "conditional" | "u-space" | "no-restriction";
  };
  /** The area is limited in height, and the track's height is unknown. */
  height_unknown?: boolean;
  /** Time until the track enters on its present course, in seconds; 0 if it is predicted to be inside now. Absent if the present course misses the area, and only a course one standard deviation beside it enters. */
  time_to_entry_s?: number;
  /** Earliest time to entry, in seconds: on the present course or one standard deviation beside it. */
  earliest_s?: number;
  /** Acknowledgement by an operator. Absent until acknowledged; removed when the severity increases. */
  acknowledged?: {
    /** Operator: the name of the API token, or the name given in the request. */
    by: string;
    /** A UTC time, RFC 3339. */
    at: string;
    note?: string;
  };
  /** Shelving by an operator: notifications are suppressed until it expires or is removed. */
  shelved?: {
    /** Operator: the name of the API token, or the name given in the request. */
    by: string;
    /** A UTC time, RFC 3339. */
    at: string;
    /** A UTC time, RFC 3339. */
    until: string;
    note?: string;
  };
  /** End of the alert; absent while it is active. */
  until?: string;
  /** The alert has ended, was critical, and waits for an acknowledgement. */
  latched?: boolean;
};

/** Shelving: suppresses notifications of an alert for some time. */
export type AlertShelf = {
  /** Duration, in minutes; at most 480 (8 hours). */
  minutes: number;
  /** Name of the operator. Only without authentication; otherwise the name of the token is used. */
  by?: string | null;
  /** Note stored with the action. */
  note?: string | null;
};

/** Acknowledgement of an alert, or end of its shelving. */
export type AlertWord = {
  /** Name of the operator. Only without authentication; otherwise the name of the token is used. */
  by?: string | null;
  /** Note stored with the action. */
  note?: string | null;
};

/** Active and ended alerts. */
export type Alerts = {
  /** A UTC time, RFC 3339. */
  time: string;
  /** Active alerts, most severe first. */
  alerts: Array<Alert>;
  /** Ended alerts that were critical and that no operator has acknowledged, latest first; at most 200. They are among the ended ones too. */
  latched: Array<Alert>;
  /** Ended alerts, latest first: the last 100, or at most `limit`. The service keeps the last 5000 while it runs. */
  ended: Array<Alert>;
  /** Whether further matching ended alerts were left out. */
  more?: boolean;
};

/** A further transponder of the aircraft, linked by evidence: the same motion for most of a minute. */
export type Also = {
  /** Identity that the transponder reports. */
  uas_id?: UasId;
  /** Identity of an aircraft with ADS-B. */
  aircraft?: AircraftJson;
  /** Configured id of the sensor that received it last. */
  sensor: string;
  /** Track number of the transponder. */
  track_number: number;
  /** Time of its latest report. */
  time?: string;
};

export type Altitude = {
  /** Height above the WGS-84 ellipsoid, in metres. */
  value: number;
  reference: "W84";
  units: "M";
};

export type AreaProperties = {
  kind: "mask" | "coverage" | "alert";
  name: string;
  /** Id of the sensor whose coverage this is. */
  sensor?: string;
  /** Identifier given by the authority. */
  identifier?: string;
  /** Type of a UAS zone. */
  type?: "prohibited" | "authorisation" | "conditional" | "u-space" | "no-restriction";
  /** Conditions of a UAS zone, in the words of its authority. */
  conditions?: string;
  /** Lower limit, in metres above mean sea level; left out if it is the ground. */
  floor_m?: number;
  /** Upper limit, in metres above mean sea level; left out if there is none. */
  ceiling_m?: number;
  /** Whether the area is in force now. */
  active: boolean;
  /** Time of the next change of `active`; left out if it does not change. */
  changes_at?: string;
  /** Short text of the times when the area is in force. */
  hours: string;
  /** Severity of an alert for a track inside; left out if the area raises no alert. */
  severity?: "warning" | "critical";
  /** Name of the operator who activated the area; left out if the configuration names it. */
  activated_by?: string;
  /** Format of the area's file. */
  format: "geojson" | "ed-318" | "ed-269";
};

export type CameraCues = {
  /** Id of the camera. */
  sensor: string;
  /** Whether the orientation of the camera is known. If so, `stated_azimuth_deg` and `stated_elevation_deg` allow for it. */
  oriented: boolean;
  /** Targets, the most urgent first, then the nearest. */
  targets: Array<Cue>;
};

/** Orientation of a camera, learnt from aircraft with transponders. Bearings are corrected by it. */
export type CameraOrientation = {
  bearing_deg: RegistrationValue;
  tilt_east_deg: RegistrationValue;
  tilt_north_deg: RegistrationValue;
  /** Number of looks learnt from. */
  looks: number;
  /** Root mean square of what is left of an angle after the correction, of the latest looks. */
  residual_deg?: number;
  /** Latest time at which the camera was found to have been turned. Its orientation was then learnt again. */
  turned?: string;
};

/** A cell. */
export type CellState = {
  /** Name of the cell. */
  cell: string;
  /** Node that owns the cell; absent if no node does. */
  owner?: string;
  /** Node that takes over when the owner falls silent; absent if there is none. */
  standby?: string;
  /** Number of the owner's lease; greater than that of any earlier owner. */
  lease: number;
  /** Number of slots by which the standby is behind. */
  behind: number;
  /** Level of load shedding of an overloaded owner, as in docs/SCALING.md; 0 if nothing is left out. */
  step: number;
  /** Text for the level of load shedding. */
  left_out: string;
  /** Whether the cell is missing from the picture: no node has published it for longer than a takeover takes. */
  is_missing: boolean;
  /** Whether the cell is missing from the picture because its owner has a different configuration. */
  is_foreign: boolean;
  /** Corners of the cell: longitude and latitude, in degrees; empty if the cell is the whole site. */
  corners: Array<Array<number>>;
};

/** Difference between the clocks of two gateways, from the times at which both received the same datagrams. */
export type ClockDifference = {
  /** Name of the first gateway. */
  gateway: string;
  /** Name of the second gateway. */
  other: string;
  /** Median of the first gateway's time stamps minus the second's, in seconds. */
  difference_s: number;
  /** Number of datagrams compared. */
  datagrams: number;
  /** Whether the clocks have been more than 20 ms apart, and not less than 15 ms since. */
  apart: boolean;
};

/** Source of a clock's quality. */
export type ClockSource = "chrony" | "kernel" | "systemd";

/** Quality of a clock. */
export type ClockStanding = "good" | "warning" | "degraded" | "unbounded" | "unsynchronised" | "unknown";

/** Reason why the stream ends. */
export type Closed = {
  reason: string;
};

/** A collection of features. */
export type Collection = {
  id: "tracks" | "areas";
  title: string;
  description: string;
  extent: Extent;
  itemType: "feature";
  crs: Array<string>;
  links: Array<Link2>;
};

/** A GeoJSON feature collection. */
export type CollectionOfFeatureOfAreaProperties = {
  /** Type of a GeoJSON object with features. */
  type: "FeatureCollection";
  features: Array<FeatureOfAreaProperties>;
};

/** A GeoJSON feature collection. */
export type CollectionOfFeatureOfCoverageProperties = {
  /** Type of a GeoJSON object with features. */
  type: "FeatureCollection";
  features: Array<FeatureOfCoverageProperties>;
};

/** A GeoJSON feature collection. */
export type CollectionOfFeatureOfZoneLimits = {
  /** Type of a GeoJSON object with features. */
  type: "FeatureCollection";
  features: Array<FeatureOfZoneLimits>;
};

/** `/ogc/collections`. */
export type Collections = {
  links: Array<Link2>;
  collections: Array<Collection>;
};

/** A candidate that was not associated: a transponder for a radar track, or a radar track for a transponder. */
export type Competitor = {
  /** Configured id of the sensor. */
  sensor: string;
  /** Track number of the radar. */
  track_number?: number;
  /** Identity of the transponder. */
  uas_id?: TransponderId;
  /** Natural logarithm of the likelihood ratio of one aircraft to two. */
  log_likelihood_ratio: number;
  /** Whether an operator has decided that it is another aircraft. */
  decorrelated?: boolean;
};

/** Two aircraft that may come near each other, evaluated for one volume. */
export type Conflict = {
  /** Id of the conflict: constant for the pair as long as a level holds; absent if none does. */
  id?: string;
  /** Time of the evaluation. */
  time: string;
  /** Last time at which both aircraft were present, if one is missing now. All figures are of that time. */
  seen?: string;
  /** Track id of aircraft a. */
  a: string;
  /** Track id of aircraft b. */
  b: string;
  /** Name of the volume. */
  volume: string;
  level: "none" | "advisory" | "warning" | "violation";
  /** Time since which the level holds. */
  since?: string;
  /** Time to the closest point of approach, seconds; 0 if the aircraft fly apart. */
  t_cpa_s: number;
  /** Horizontal distance at the closest point of approach, metres. */
  d_cpa_h_m: number;
  /** Vertical distance at the closest point of approach, metres; absent if the height of one aircraft is unknown. */
  d_cpa_v_m?: number;
  /** Present horizontal distance, metres. */
  d_now_h_m: number;
  /** Present vertical distance, metres; absent if the height of one aircraft is unknown. */
  d_now_v_m?: number;
  /** Time to the expected entry of the volume, seconds; 0 if it is violated now. If the expected paths miss the volume: time to the point where they come nearest to it. */
  t_entry_s: number;
  /** Time to the expected exit from the volume, seconds, at most the horizon; absent if the expected paths miss the volume. */
  t_exit_s?: number;
  /** Probability of being inside the volume at any time within the horizon. */
  probability: number;
  /** Whether the heights of both aircraft are known. If not, they are assumed to be equal or, if `vertical_coarse`, to differ as far as they are bounded, and the level is at most an advisory. */
  vertical_known: boolean;
  /** Whether the height of one aircraft is only a coarse bound. */
  vertical_coarse?: boolean;
  /** Whether the volume is entered at the time of the figures. */
  entered?: boolean;
  miss: MissJson;
  cpa: CpaJson;
  /** State of the less trustworthy of the two transponders. */
  integrity?: "unverified" | "verified" | "suspect" | "failed";
};

/** Predicted conflicts between aircraft. */
export type Conflicts = {
  /** Time of the positions. Present time if conflicts are not computed. */
  time: string;
  /** Whether conflicts are computed. If false, an empty list does not mean that there are no conflicts. */
  computed: boolean;
  /** Reason why conflicts are not computed. */
  reason?: string;
  volumes: Array<Volume>;
  /** Number of aircraft that were compared. */
  aircraft: number;
  /** Number of aircraft that were left out because too little is known about them. */
  left_out: number;
  /** Conflicts, highest level first, then those of known heights, then by time to the entry of the volume. */
  conflicts: Array<Conflict>;
};

/** Classes of requirements that the service conforms to. */
export type ConformanceClasses = {
  conformsTo: Array<string>;
};

/** A sender that is refused because another one uses the SAC/SIC of a sensor. */
export type Contested = {
  /** Address and port of the accepted sender. Port 0 stands for the host named by `source`. */
  counts: string;
  /** Address and port of the refused sender. */
  refused: string;
  /** `other_sender`: the accepted sender was received first. `foreign_source`: the refused one is not a host that the sensor's inputs name as `source`. */
  reason: "other_sender" | "foreign_source";
  /** Serial numbers of the transponders that both senders report. */
  transponders: Array<string>;
};

/** A sensor that contributes to a track. For the radar of a fused track, also the evidence of the association. */
export type Contributor = {
  /** Kind of the sensor. */
  kind: "radar" | "transponder" | "camera";
  /** Configured id of the sensor. */
  sensor: string;
  /** Track number at the sensor; of a transponder its published number. */
  track_number: number;
  /** Time of its measurement; for a camera, of the latest bearing used. */
  time?: string;
  /** Weight in the position, if it is fixed. */
  weight?: number;
  /** Whether the radar measured a height. */
  height_measured?: boolean;
  /** Distance between radar and transponder, in metres. */
  distance_m?: number;
  /** Reference profile: association distance, in metres. */
  threshold_m?: number;
  /** Reference profile: share of the common slots with a distance within the association distance. */
  ratio?: number;
  /** Reference profile: number of slots within the association distance. */
  within?: number;
  /** Reference profile: number of common slots. */
  co_present?: number;
  /** Operational profile: whether an operator has decided that both are one aircraft. */
  manual?: boolean;
  /** Operational profile: natural logarithm of the likelihood ratio of one aircraft to two. */
  log_likelihood_ratio?: number;
  /** Operational profile: thresholds of `log_likelihood_ratio`. */
  threshold?: Threshold;
  /** Operational profile, for a single track or with `include=competitors`: alternative associations, likeliest first. They are transponders for a radar track, radar tracks for a transponder. */
  competitors?: Array<Competitor>;
};

export type Correlation = {
  /** Id of the radar. */
  sensor: string;
  track_number: number;
  uas_id: TransponderId;
  verdict: "correlated" | "decorrelated";
  /** Time of the first slot to which the decision applies. */
  since: string;
};

/** Operator decisions in force. */
export type Correlations = {
  correlations: Array<Correlation>;
};

export type CoverageProperties = {
  /** Configured id of the sensor. */
  sensor: string;
  kind: "radar" | "transponder" | "adsb" | "remote-id" | "camera";
  /** `area`: configured polygon. `circle`: range of the radar. */
  shape: "area" | "circle";
  max_range_m?: number;
};

/** Positions at the closest point of approach: longitude, latitude (degrees) and, if known, height above the ellipsoid (metres). */
export type CpaJson = {
  a: Array<number>;
  b: Array<number>;
};

/** Direction of an aircraft from a camera. Azimuths are clockwise from north. */
export type Cue = {
  /** Id of the track. */
  track: string;
  /** Name of the track on the map. */
  name: string;
  reason: "violation" | "warning" | "uncooperative" | "untrusted" | "unidentified";
  azimuth_deg: number;
  /** Elevation above the horizontal; absent if no height is known. */
  elevation_deg?: number;
  /** Standard deviation of the azimuth. */
  azimuth_deviation_deg?: number;
  /** Standard deviation of the elevation. */
  elevation_deviation_deg?: number;
  /** Azimuth in the camera's own axes, as it states bearings. */
  stated_azimuth_deg: number;
  /** Elevation in the camera's own axes; absent if no height is known. */
  stated_elevation_deg?: number;
  distance_m: number;
};

/** Aircraft that cameras should look at, with their directions. */
export type Cueing = {
  /** Time of the positions. Present time if there is no picture. */
  time: string;
  /** Configured cameras. */
  cameras: Array<CameraCues>;
};

/** An ellipse about a position. */
export type Ellipse = {
  /** Semi-major axis, in metres. */
  major_m: number;
  /** Semi-minor axis, in metres. */
  minor_m: number;
  /** Direction of the major axis, in degrees true, 0 to 180. */
  azimuth_deg: number;
};

/** Tracks that ended. */
export type Ended = {
  /** A UTC time, RFC 3339. */
  time: string;
  ids: Array<string>;
};

/** Where features of a collection may be. */
export type Extent = {
  spatial: SpatialExtent;
};

/** Unreadable blocks and records. */
export type Fault = {
  category: number | null;
  reason: string;
  count: number;
};

/** A GeoJSON feature without an id. */
export type FeatureOfAreaProperties = {
  type: "Feature";
  geometry: Geometry;
  properties: AreaProperties;
};

/** A GeoJSON feature with an id. */
export type FeatureOfCoverageProperties = {
  type: "Feature";
  /** Same id as in the properties. */
  id: string;
  geometry: Geometry | null;
  properties: CoverageProperties;
};

/** A GeoJSON feature with an id. */
export type FeatureOfPastProperties = {
  type: "Feature";
  /** Same id as in the properties. */
  id: string;
  /** A point. */
  geometry: {
    type: "Point";
    coordinates: Position;
  };
  properties: PastProperties;
};

/** A GeoJSON feature without an id. */
export type FeatureOfReportProperties = {
  type: "Feature";
  /** A point. */
  geometry: {
    type: "Point";
    coordinates: Position;
  };
  properties: ReportProperties;
};

/** A GeoJSON feature with an id. */
export type FeatureOfSensorProperties = {
  type: "Feature";
  /** Same id as in the properties. */
  id: string;
  /** A point. */
  geometry: {
    type: "Point";
    coordinates: Position;
  };
  properties: SensorProperties;
};

/** A GeoJSON feature with an id. */
export type FeatureOfTrackProperties = {
  type: "Feature";
  /** Same id as in the properties. */
  id: string;
  /** A point. */
  geometry: {
    type: "Point";
    coordinates: Position;
  };
  properties: TrackProperties;
};

/** A GeoJSON feature with an id. */
export type FeatureOfTrailProperties = {
  type: "Feature";
  /** Same id as in the properties. */
  id: string;
  geometry: Geometry;
  properties: TrailProperties;
};

/** A GeoJSON feature without an id. */
export type FeatureOfZoneLimits = {
  type: "Feature";
  geometry: Geometry;
  properties: ZoneLimits;
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
  /** Name of the gateway. */
  node: string;
  /** Number of its input lines. */
  lines: number;
  /** Messages that it wrote into the log. */
  written: number;
  /** Messages waiting for the log. */
  waiting: number;
  /** Datagrams dropped because the log was unavailable for too long. */
  dropped: number;
  /** Quality of its clock. */
  clock: ClockStanding;
  /** Maximum error of its clock, in seconds; absent if unknown. */
  clock_bound_s?: number;
  /** Source of the clock's quality; absent if there is none. */
  clock_by?: ClockSource;
  /** Whether its clock has been unsynchronised for a minute or longer. */
  unfit: boolean;
  /** Whether it publishes nothing because its clock is unsynchronised; other gateways receive the same data. */
  silent: boolean;
  /** Datagrams not published while it was silent. */
  withheld: number;
  /** Offset of the gateway's clock from reference time (the median of the clocks of the log and the gateways), in seconds; positive if ahead; absent if unknown. Beyond 1 s its messages are refused. */
  clock_ahead_s?: number;
};

/** A point, a line, or an area. */
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

/** Liveness or readiness of the service. */
export type Health = {
  status: "ok" | "ready";
};

/** Sent every second with the state of the service. */
export type Heartbeat = {
  /** Time of the latest slot. */
  time?: string;
  /** Sequence number of the latest slot. */
  seq: number;
  /** Time from the start of the slot to its publication, in seconds. */
  latency_s?: number;
  /** Delay of the picture, in seconds; present only while it is late. */
  late_s?: number;
};

/** GeoJSON polygon (RFC 7946). */
export type Hull = {
  type: "Polygon";
  coordinates: Array<Array<[number, number]>>;
};

/** Integrity of a transponder. */
export type IdentityIntegrity = {
  /** Serial number, as used in the path. */
  identity: string;
  uas_id: TransponderId;
  /** Id of its track, if it has one in the latest slot. */
  track_id?: string;
  /** Name of an integrity state. */
  state: "unverified" | "verified" | "suspect" | "failed";
  /** Time since which the state applies. */
  since: string;
  /** Natural logarithm of the likelihood ratio of a false to a true report, by radar. */
  index: number;
  /** Protection level, in metres: radius that contains 95 % of the position offsets that radar would not have revealed so far. Left out if there is no bound. */
  protection_level_m?: number;
  /** Estimated offset of its positions; only for a suspect or failed transponder. */
  offset?: IntegrityOffset;
  /** Evidence against the transponder. */
  reasons: Array<"radar" | "jump" | "frozen" | "replay" | "duplicate" | "swapped" | "velocity" | "time">;
  /** Time of its newest report. */
  heard: string;
  /** Whether the transponder has fallen silent. */
  silent: boolean;
  /** Operator verdict; left out if there is none. */
  verdict?: "trusted" | "distrusted";
  /** Time of the first slot to which the verdict applies. */
  verdict_since?: string;
  /** Id of the track that radar sees at another position than the reported one. */
  twin_id?: string;
  /** Radar tracks with which the transponder was compared, latest first. */
  evidence: Array<IntegrityEvidence>;
};

/** Version, site, and settings that clients of the picture need. */
export type Info = {
  name: "utm-fusion";
  version: string;
  site: Site;
  /** Height of the geoid above the ellipsoid at the site, in metres. */
  geoid_separation: number;
  profile: "operational" | "reference";
  slot_s: number;
  /** Time from the start of a slot to its due time, in seconds. */
  latency_s: number;
  /** Whether the picture `at=now` is available. */
  now: boolean;
  /** Whether a cluster makes the picture (`/api/v1/cluster`). */
  cluster: boolean;
  /** A UTC time, RFC 3339. */
  started: string;
  mode: "live" | "replay";
  auth: "none" | "tokens";
  /** Whether the token in use has the scope `control`. */
  control: boolean;
  settings: Settings;
  /** Server of raster map tiles for the page. */
  tiles?: Tiles;
  /** Base map, served by `/api/v1/basemap`. */
  basemap?: About;
  /** Maximum length of the history, in hours; left out if no history is kept. */
  history_hours?: number;
  replay?: Replay;
};

/** Integrity of the transponders heard in the last hour. */
export type Integrity = {
  /** Time of the slot to which the states apply. */
  time?: string;
  /** Whether integrity is evaluated. It is not in the reference profile, nor with `[integrity] action = "off"`. */
  computed: boolean;
  identities: Array<IdentityIntegrity>;
};

export type IntegrityEvidence = {
  /** Id of the radar. */
  sensor: string;
  track_number: number;
  /** `near`: the radar track was at the reported position. `far`: it flies the same way elsewhere. */
  kind: "near" | "far";
  /** First second that counted. */
  from: string;
  /** Number of seconds that counted. */
  seconds: number;
  /** Contribution to the index. */
  gain: number;
};

/** Horizontal offset. */
export type IntegrityOffset = {
  east_m: number;
  north_m: number;
  /** Covariance of east and north, in m². */
  covariance_m2: Array<Array<number>>;
};

/** Operator verdict on a transponder. */
export type IntegrityVerdict = {
  /** Whether the transponder is to be trusted, not to be trusted, or to be judged by the evidence. */
  verdict: "trusted" | "distrusted" | "automatic";
};

/** Features of a collection, RFC 7946 with the members of OGC 17-069r4. */
export type ItemsOfFeatureOfAreaProperties = {
  /** Type of a GeoJSON object with features. */
  type: "FeatureCollection";
  /** Time of the picture, or of the answer if there is none. */
  timeStamp: string;
  numberMatched: number;
  numberReturned: number;
  links: Array<Link2>;
  features: Array<FeatureOfAreaProperties>;
};

/** Features of a collection, RFC 7946 with the members of OGC 17-069r4. */
export type ItemsOfFeatureOfTrackProperties = {
  /** Type of a GeoJSON object with features. */
  type: "FeatureCollection";
  /** Time of the picture, or of the answer if there is none. */
  timeStamp: string;
  numberMatched: number;
  numberReturned: number;
  links: Array<Link2>;
  features: Array<FeatureOfTrackProperties>;
};

/** `/ogc`. */
export type LandingPage = {
  title: string;
  description: string;
  links: Array<Link2>;
};

export type LatLngPoint = {
  lat: number;
  lng: number;
};

/** Errors of a radar as learnt by the operational profile. */
export type Learnt = {
  /** One-line summary. */
  summary: string;
  range_m: LearntErrors;
  azimuth_deg: LearntErrors;
  height_m: LearntErrors;
  velocity: LearntVelocity;
};

/** Delay of the times of reports, in seconds. */
export type LearntDelay = {
  value: number;
  /** Standard deviation, in seconds. */
  deviation: number;
  /** Part of the delay that is certain, by which reports are corrected, in seconds. */
  applied: number;
};

/** Errors along one axis, in the unit of the axis. */
export type LearntErrors = {
  /** Ratio of the total error (bias and noise) to that of the data sheet. */
  of_data_sheet: LearntNumber;
  /** Standard deviation of the bias, averaged over straight flight and turns as flown. */
  bias: LearntNumber;
  /** Correlation time of the bias, in seconds. */
  correlation_s: LearntNumber;
  /** Ratio of the bias in turns to the bias in straight flight. */
  turn_factor: LearntNumber;
  /** Standard deviation of the white noise. */
  noise: LearntNumber;
  /** Effective number of independent samples of the bias; older samples have less weight. */
  samples: number;
};

export type LearntNumber = {
  value: number;
  /** Standard deviation. */
  deviation: number;
};

/** Errors common to transponders of one make and model at this receiver; operational profile only. */
export type LearntTransponderType = {
  /** I129/020, if it is sent. */
  manufacturer?: string;
  /** I129/030, if it is sent. */
  model?: string;
  /** One-line summary. */
  summary: string;
  /** Number of reports from which the white noise is estimated. */
  reports: number;
  /** Standard deviation of the white noise per horizontal axis, in metres. */
  horizontal_m: LearntNumber;
  /** Standard deviation of the white noise of the height, in metres. */
  vertical_m: LearntNumber;
  delay_s: LearntDelay;
};

/** Quality of a radar's velocities (I048/200). */
export type LearntVelocity = {
  verdict: "unknown" | "used" | "ignored";
  /** Velocity error per axis, in metres per second, once it is known. */
  error_m_s?: LearntNumber;
};

/** Counters of a UDP input: a multicast group or an address. */
export type Line = {
  name: string;
  joined: boolean;
  received: number;
  duplicates: number;
  foreign: number;
  queue_full: number;
  kernel_dropped: number;
  /** A UTC time, RFC 3339. */
  last_received?: string;
  /** Number of messages that a connection could not translate, by reason. */
  untranslated?: Record<string, number>;
};

/** A related track. */
export type Link = {
  /** Id of the track. */
  id: string;
  /** `disputed`: only one of the two tracks is the aircraft. */
  relation: "disputed";
};

/** A link. */
export type Link2 = {
  href: string;
  rel: "self" | "service-desc" | "service-doc" | "conformance" | "data" | "items" | "collection" | "next";
  type: "application/json" | "application/geo+json" | "text/html" | "application/vnd.oai.openapi+json;version=3.1";
};

/** Members of the cluster, at most a second old. */
export type Members = {
  /** Name of the region. */
  region: string;
  /** Cells of the region. */
  cells: Array<CellState>;
  /** Nodes of the region. */
  nodes: Array<NodeState>;
  /** Gateways of the region. */
  gateways: Array<GatewayState>;
  /** Clock differences between each two gateways that receive the same datagrams. */
  clocks: Array<ClockDifference>;
  /** Names of expected gateways without a report for 3 s. */
  missing_gateways: Array<string>;
  /** Members whose configuration differs from this process's, each with the differences. */
  different: Array<string>;
  /** Slots shown by this process. */
  shown: number;
  /** Slots received again after they, or later ones, had been shown. */
  doubled: number;
  /** Slots that no node published. */
  missing: number;
  /** Aircraft left out of a slot because another cell published them too. */
  twice: number;
  /** Slots of a cell received after the region's picture of that slot had been shown without them. */
  too_late: number;
};

/** Relative position of b to a at the closest point of approach, with its uncertainty. */
export type MissJson = {
  /** Horizontal component across the relative velocity, metres. */
  across_m: number;
  /** Vertical component, upwards, metres. */
  vertical_m?: number;
  /** Covariance of the two components: across, vertical; the vertical variance is 0 if a height is unknown. */
  covariance_m2: Array<Array<number>>;
};

/** A node. */
export type NodeState = {
  /** Name of the node. */
  node: string;
  /** Machine that the node runs on. */
  machine: string;
  /** Role of the node, in at least one of its cells. */
  part: "owner" | "standby" | "none" | "drained";
  /** Cells that the node owns. */
  owns: Array<string>;
  /** Cells for which the node is the standby. */
  stands_by: Array<string>;
  /** Number of times the node became the owner of a cell. */
  takeovers: number;
  /** Number of times its output was refused because another node owned the cell. */
  fenced: number;
  /** Number of times its state differed from the owner's. */
  diverged: number;
  /** Slots that the node published. */
  published: number;
  /** Checkpoints that the node wrote. */
  checkpoints: number;
  /** Offset of the node's clock from reference time (the median of the clocks of the log and the gateways), in seconds; positive if ahead; absent if unknown. */
  clock_ahead_s?: number;
};

export type OperatorLocation = {
  position: LatLngPoint;
  altitude?: Altitude;
  altitude_type: "Takeoff" | "Dynamic" | "Fixed";
};

/** Position of an operator. */
export type OperatorPlace = {
  /** WGS-84 latitude, in degrees. */
  lat: number;
  /** WGS-84 longitude, in degrees. */
  lng: number;
  /** Height above the ellipsoid, in metres. */
  alt?: number;
  /** Source of the position: take-off point, live position, or fixed. */
  type: "Takeoff" | "Dynamic" | "Fixed";
};

export type PastPosition = {
  lat: number;
  lng: number;
  alt: number;
};

/** Properties of a track from the history. */
export type PastProperties = {
  id: string;
  source: "fused" | "radar" | "transponder" | "camera";
  track_number: number;
  /** A UTC time, RFC 3339. */
  time: string;
  lat: number;
  lng: number;
  /** Height above mean sea level, in metres, if it was measured. */
  alt_msl?: number;
};

export type Picture = {
  /** Time, in seconds since 1970. */
  now: number;
  /** Number of datagrams received. */
  messages: number;
  aircraft: Array<Aircraft>;
};

/** Longitude and latitude in degrees, and the ellipsoidal height in metres if known. */
export type Position = Array<number>;

/** RFC 9457. */
export type Problem = {
  type: "about:blank";
  title: string;
  status: number;
  detail: string;
  /** Parameter that is invalid. */
  parameter?: string;
  /** Several reasons, if a detail is not enough. */
  reasons?: Array<string>;
  /** Time after which to try again, in seconds. */
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
  /** Height above the ellipsoid, in metres; -1000 means unknown. */
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
  /** Track angle, in degrees true; 361 means unknown. */
  track: number;
  /** Ground speed, in metres per second; 255 means unknown. */
  speed: number;
  speed_accuracy: "SA03mps" | "SA1mps" | "SA3mps" | "SA10mps" | "SA10mpsPlus" | "SAUnknown";
  /** Vertical speed, in metres per second; 63 means unknown. */
  vertical_speed: number;
  /** Height above take-off or ground, as declared by the drone. */
  height?: RIDHeight;
};

export type RIDFlight = {
  id: string;
  aircraft_type: "NotDeclared" | "Aeroplane" | "Helicopter" | "Gyroplane" | "HybridLift" | "Ornithopter" | "Glider" | "Kite" | "FreeBalloon" | "CaptiveBalloon" | "Airship" | "FreeFallOrParachute" | "Rocket" | "TetheredPoweredAircraft" | "GroundObstacle" | "Other";
  simulated: boolean;
  current_state: RIDAircraftState;
  /** Present if `recent_positions_duration` asks for them. */
  recent_positions?: Array<RIDRecentAircraftPosition>;
};

export type RIDFlightDetails = {
  id: string;
  /** One of the kinds of identities. */
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

/** Height relative to a reference. */
export type RIDHeight = {
  /** Height, in metres. */
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

/** Where a radar stands according to its tracks, relative to the position that is used. */
export type RadarPlace = {
  east_m: number;
  north_m: number;
  /** Standard deviation of `east_m`. */
  east_sigma_m: number;
  north_sigma_m: number;
  latitude_deg: number;
  longitude_deg: number;
  /** The configured value that belongs to this position. */
  bearing_correction_deg: number;
  /** Time of the tracks on which it rests, in minutes of one drone. */
  drone_minutes: number;
  /** Whether the tracks contradict the position that is used. Then it can be applied. */
  contradicts: boolean;
};

/** Reports as GeoJSON, RFC 7946. */
export type Raw = {
  /** Type of a GeoJSON object with features. */
  type: "FeatureCollection";
  /** Number of the last report, for `after` in the next request. */
  last: number;
  features: Array<FeatureOfReportProperties>;
};

export type Receiver = {
  version: string;
  /** Interval between two pictures, in milliseconds. */
  refresh: number;
  /** Always 0, because no history is served. */
  history: number;
  /** Latitude of the first radar, in degrees. */
  lat?: number;
  lon?: number;
};

/** Trail of a track: times and places, oldest first. */
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

/** Misalignment of a radar, estimated from its tracks. Operational profile only; without values if the estimation is off. */
export type Registration = {
  mode: "apply" | "propose" | "off";
  /** Whether plots are corrected by any of the values. */
  applied: boolean;
  /** Effective number of radar tracks used; older ones have less weight. */
  tracks?: number;
  /** Minutes of aircraft without a transponder that other radars see as well; bearing and range rest on these, too. */
  shared_minutes?: number;
  /** Residual: 1 if tracks differ as the configured errors predict; above 4 the estimate is doubtful. */
  residual?: number;
  bearing_deg?: RegistrationValue;
  tilt_east_deg?: RegistrationValue;
  tilt_north_deg?: RegistrationValue;
  range_m?: RegistrationValue;
  height_m?: RegistrationValue;
  time_s?: RegistrationValue;
  /** Advice to the operator if the estimate is doubtful. */
  hint?: string;
  /** Advice to the operator after a step; present for an hour. */
  alarm?: string;
  step?: RegistrationStep;
  place?: RadarPlace;
  relocated?: RelocatedRadar;
};

/** Latest step since the start: the radar may have been moved. */
export type RegistrationStep = {
  /** Time of the detection. */
  time: string;
  /** Estimate without the latest tracks. */
  before: RegistrationValues;
  /** Estimate from the latest tracks alone. */
  after: RegistrationValues;
};

/** A bias: measured value minus true value. */
export type RegistrationValue = {
  /** Estimated value; 0 if a tilt is not observable. */
  value: number;
  /** Standard deviation. */
  deviation: number;
  /** Whether the value is known well enough to be used. Only then is it applied. */
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

/** Correction of a radar's configured position that an operator applied. */
export type RelocatedRadar = {
  east_m: number;
  north_m: number;
  /** Angle taken off the azimuths, beside the configured correction. */
  bearing_deg: number;
  latitude_deg: number;
  longitude_deg: number;
};

export type Relocation = {
  /** Id of the radar. */
  sensor: string;
  /** Metres that the radar stands east of its configured position. */
  east_m: number;
  north_m: number;
  /** Angle taken off the azimuths, beside the configured correction. */
  bearing_deg: number;
  /** Time of the first slot with it. */
  since: string;
};

/** Relocations in force. */
export type Relocations = {
  relocations: Array<Relocation>;
};

/** Remote ID declarations of a drone, besides identity and position. */
export type RemoteIdDeclaration = {
  ua_type?: "NotDeclared" | "Aeroplane" | "Helicopter" | "Gyroplane" | "HybridLift" | "Ornithopter" | "Glider" | "Kite" | "FreeBalloon" | "CaptiveBalloon" | "Airship" | "FreeFallOrParachute" | "Rocket" | "TetheredPoweredAircraft" | "GroundObstacle" | "Other";
  operational_status?: "Undeclared" | "Ground" | "Airborne" | "Emergency" | "RemoteIDSystemFailure";
  height?: RIDHeight;
  /** Registration of the operator. */
  operator_id?: string;
  operator_location?: OperatorPlace;
};

/** A broadcast of Remote ID that a gateway received. Other members are ignored. */
export type RemoteIdLine = {
  /** Time of reception; if absent, the time at which the line arrives. */
  time?: number | string | null;
  /** Address of the transmitter, or another name of it; at most 64 octets. */
  transmitter: string;
  /** Signal strength, in dBm. */
  rssi?: number | null;
  /** Id of the receiving sensor. */
  receiver?: string | null;
  /** The message or the pack, in hexadecimal. */
  message: string;
};

/** Result of posted lines. */
export type RemoteIdPosted = {
  /** Number of lines, without blank ones. */
  lines: number;
  /** Number of lines accepted for processing. Lines that the engine cannot use are counted with the sensor. */
  taken: number;
  /** Number of refused lines, by reason. The other lines are accepted. */
  refused: Record<string, number>;
};

/** State of a replay. */
export type Replay = {
  playing: boolean;
  /** Speed, as a multiple of real time. */
  speed: number;
  ended: boolean;
  /** Time of the slot shown last. */
  time?: string;
  /** Start of the recording. */
  start?: string;
  /** End of the recording; left out until it is known. */
  end?: string;
};

/** A report of a radar or a transponder. */
export type ReportProperties = {
  /** Configured id of the sensor. */
  sensor: string;
  /** A UTC time, RFC 3339. */
  time: string;
} & ({
  kind: "radar";
  track_number: number;
  /** Probability that the target is a drone, as stated by the radar. */
  uav_probability?: number;
} | {
  kind: "transponder";
  serial_number: string;
});

/** Reason why the stream starts again with a snapshot. */
export type Resync = {
  reason: string;
};

/** Properties of a sensor. Unknown values are left out. */
export type SensorProperties = {
  /** Configured id. */
  id: string;
  kind: "radar" | "transponder" | "adsb" | "remote-id" | "camera";
  sac?: number;
  sic?: number;
  state?: "operational" | "degraded" | "outage";
  /** Reasons why the sensor is not operational. */
  reasons?: Array<string>;
  /** Reports per second, averaged over the last 10 s. */
  rate_hz?: number;
  accepted?: number;
  /** Number of records without a report, by reason. */
  refused?: Record<string, number>;
  lines?: Array<Line>;
  /** Time of its last record of any kind. */
  last_seen?: string;
  /** Minimum delay of recent reports from their time to their reception, in seconds. */
  clock_offset_s?: number;
  contested?: Array<Contested>;
  registration?: Registration;
  orientation?: CameraOrientation;
  learnt?: Learnt;
  transponder_types?: Array<LearntTransponderType>;
};

/** Sensors as GeoJSON, RFC 7946. */
export type Sensors = {
  /** Type of a GeoJSON object with features. */
  type: "FeatureCollection";
  unknown: Array<UnknownSource>;
  features: Array<FeatureOfSensorProperties>;
  /** Time of the sensors' states. */
  time?: string;
};

/** State with reasons, latency and counters. */
export type ServiceStatus = {
  /** A UTC time, RFC 3339. */
  time: string;
  state: "ok" | "degraded";
  /** Whether the picture can be used. */
  ready: boolean;
  /** Reasons why the state is not ok. */
  reasons: Array<string>;
  /** A UTC time, RFC 3339. */
  started: string;
  uptime_s: number;
  /** Sequence number of the latest slot. */
  seq: number;
  /** Number of open streams. */
  streams: number;
  /** Delay of the picture beyond the configured latency, in seconds. */
  late_s?: number;
  /** Files of the state directory that cannot be written. A restart would lose their contents. */
  state_failing: Array<string>;
  /** Time from the start of a slot to its publication, in seconds. */
  latency_s?: Quantiles;
  /** Time from a slot's due time to its publication, in seconds. */
  lateness_s?: Quantiles;
  failed_sends?: number;
  tally?: Tally;
};

/** Settings of `[fusion]`. */
export type Settings = {
  motion: "imm" | "singer";
  window_s: number;
  max_future_s: number;
  max_gap_s: number;
  /** Rows of slant range and association distance, in metres. */
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
  /** Type of a GeoJSON object with features. */
  type: "FeatureCollection";
  /** A UTC time, RFC 3339. */
  time: string;
  /** Configured name of the site. */
  site: string;
  numberMatched: number;
  numberReturned: number;
  features: Array<FeatureOfPastProperties>;
};

export type SpatialExtent = {
  /** West, south, east and north, degrees. */
  bbox: Array<Array<number>>;
  crs: "http://www.opengis.net/def/crs/OGC/1.3/CRS84";
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

/** Counters since the start. */
export type Tally = {
  /** Number of datagrams received. */
  received: number;
  octets: number;
  duplicates: number;
  /** Number of reports, by sensor, in the order of the configuration. */
  accepted: Record<string, number>;
  /** Number of service messages, by sensor. */
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

/** Thresholds of an association, as logarithms of likelihood ratios. */
export type Threshold = {
  /** A pair is associated above this value. */
  join: number;
  /** A pair is separated below this value. */
  part: number;
};

/** A ticket for one stream. */
export type Ticket = {
  /** Value of the parameter `ticket` of `/api/v1/stream`. */
  ticket: string;
  expires_in_s: number;
};

export type Tiles = {
  url: string;
  attribution: string;
};

/** A track. Unknown values are left out; in the reference profile these include motion and accuracy. */
export type TrackProperties = {
  /** Id of the track. Operational profile: one per aircraft, `U-…`. Reference profile: `F-…`, `R-…`, `T-…`, which change with its sources. */
  id: string;
  /** Short name as on the map, unique among the tracks of a picture: callsign or address, end of the serial number, or `R` and the number of a radar's track. */
  name?: string;
  /** Kinds of sensors whose measurements make the track. */
  source: "fused" | "radar" | "transponder" | "camera";
  /** Published track number, as in CAT129 and CAT062. */
  track_number: number;
  /** `coasting`: not measured since; the position is extrapolated. */
  state: "active" | "coasting";
  /** Time of the position. */
  time: string;
  /** WGS-84 latitude, in degrees. */
  lat: number;
  /** WGS-84 longitude, in degrees. */
  lng: number;
  /** Height above the ellipsoid, in metres, if a height was measured. */
  alt?: number;
  /** Height above mean sea level, in metres, if a height was measured. */
  alt_msl?: number;
  /** Height of the geoid above the ellipsoid, in metres. */
  geoid_separation: number;
  /** Ground speed, in metres per second. */
  speed?: number;
  /** Direction over ground, in degrees true; left out if it is uncertain. */
  track?: number;
  /** Vertical speed, in metres per second, positive up. */
  vertical_speed?: number;
  /** Radius that contains 95 % of the horizontal errors, as estimated by the filter, in metres. */
  accuracy_h_m?: number;
  /** Bound of 95 % of the vertical errors, in metres. */
  accuracy_v_m?: number;
  /** Class of `accuracy_h_m` in ASTM F3411. */
  accuracy_h?: "HA1m" | "HA3m" | "HA10m" | "HA30m" | "HA005NM" | "HA01NM" | "HA03NM" | "HA05NM" | "HA1NM" | "HA2NM" | "HA4NM" | "HA10NM" | "HA10NMPlus";
  /** Class of `accuracy_v_m` in ASTM F3411. */
  accuracy_v?: "VA1m" | "VA3m" | "VA10m" | "VA25m" | "VA45m" | "VA150m" | "VA150mPlus";
  /** Ellipse that contains 95 % of the horizontal errors; only for a predicted position (`at=now`). */
  accuracy_ellipse?: Ellipse;
  /** Operational profile: the position lies between two measurements. Reference profile: there is a transponder. */
  interpolated: boolean;
  /** Whether the position lies after the last measurement or before the first. */
  extrapolated: boolean;
  /** Probability that it is a drone, according to the radar. */
  uav_probability?: number;
  /** Class of the target. */
  aircraft_type: "drone" | "crewed" | "vehicle" | "other" | "unknown";
  /** Identity that the transponder reports. */
  uas_id?: UasId;
  /** Identity of an aircraft with ADS-B. */
  aircraft?: AircraftJson;
  /** Remote ID declarations of a drone. */
  remote_id?: RemoteIdDeclaration;
  /** Operational profile: further identities of the same aircraft, which carries several transponders. */
  also?: Array<Also>;
  /** Operational profile: integrity of its transponder; docs/INTEGRITY.md. */
  integrity?: "unverified" | "verified" | "suspect" | "failed";
  /** Natural logarithm of the likelihood ratio of a false to a true report of its transponder, by radar. */
  integrity_index?: number;
  /** Protection level, in metres: radius that contains 95 % of the position offsets that radar would not have revealed so far. Left out if there is no bound. */
  protection_level_m?: number;
  /** Distance between a suspect or failed transponder's position and that seen by radar, in metres. */
  offset_m?: number;
  /** Evidence against its transponder. */
  reasons?: Array<"radar" | "jump" | "frozen" | "replay" | "duplicate" | "swapped" | "velocity" | "time">;
  /** Tracks that claim to be the same aircraft at another position. */
  linked?: Array<Link>;
  /** Whether it flies without a transponder where a receiver should hear one. */
  uncooperative?: boolean;
  /** Centre of the first slot with the track. */
  first_seen: string;
  /** Time of the latest measurement up to `time`, by any sensor; left out before the first. */
  last_measurement?: string;
  /** Sensor tracks that the track is made of. */
  contributors: Array<Contributor>;
  /** Time from the track's time to its publication, in seconds. */
  age_s: number;
  /** Recent trail; with the parameter `trail_s`. */
  trail?: RecentTrail;
};

/** Tracks as GeoJSON, RFC 7946. */
export type Tracks = {
  /** Type of a GeoJSON object with features. */
  type: "FeatureCollection";
  /** `now` for the predicted picture of the deadline; left out for the picture of the slot. */
  at?: "now";
  /** Time of the tracks: the centre of the slot. */
  time?: string;
  /** Time of publication of the slot. */
  published_at?: string;
  /** Time from the start of the slot to its publication, in seconds. */
  latency_s?: number;
  seq: number;
  /** Configured name of the site. */
  site: string;
  numberMatched: number;
  numberReturned: number;
  /** Value of `after` for the next page, if `limit` has left out some tracks. */
  next?: string;
  /** Tracks, after all other members. */
  features: Array<FeatureOfTrackProperties>;
};

export type TrailProperties = {
  id: string;
  /** Time of each position. */
  times: Array<string>;
  /** Source of each position. */
  sources: Array<"fused" | "radar" | "transponder" | "camera">;
  /** Height of each position above mean sea level, in metres; null if none was measured. */
  alt_msl: Array<number | null>;
};

/** Unique identity of a transponder. */
export type TransponderId = {
  /** Serial number. */
  serial_number: string;
  /** Country of registration, ISO 3166-1 alpha-2. */
  registration_country?: string;
};

/** Identity of a drone as it reports it, in one of the kinds of ASTM F3411. */
export type UasId = {
  /** Serial number. */
  serial_number?: string;
  /** Registration id assigned by an authority. */
  registration_id?: string;
  /** UUID assigned by a traffic management service for a flight. */
  utm_id?: string;
  /** Session id: 20 octets in hexadecimal, the first of which is its kind. */
  specific_session_id?: string;
  /** Manufacturer code. */
  manufacturer?: string;
  /** Model code. */
  model?: string;
  /** Country of registration, ISO 3166-1 alpha-2. */
  registration_country?: string;
};

/** A source that is not a configured sensor. */
export type UnknownSource = {
  category: number;
  sac: number;
  sic: number;
  /** Whether it is the service's own output. */
  own: boolean;
  records: number;
  /** A UTC time, RFC 3339. */
  last_seen: string;
};

/** A volume around each aircraft. */
export type Volume = {
  name: string;
  /** Radius, metres. */
  horizontal_m: number;
  /** Half of the height, metres. */
  vertical_m: number;
  /** Modified tau up to which the volume counts as entered, seconds; 0: not used. */
  tau_s: number;
};

/** A zone that an operator has activated. */
export type Zone = {
  name: string;
  /** Name of the token, or the name that the operator gave. */
  activated_by: string;
  /** Time of the activation. */
  activated_at: string;
  /** Lower limit, in metres above mean sea level; left out if it is the ground. */
  floor_m?: number;
  /** Upper limit, in metres above mean sea level; left out if there is none. */
  ceiling_m?: number;
};

/** Heights of a zone, for the documents; the service reads the GeoJSON as a file of areas. */
export type ZoneLimits = {
  /** Ignored: the path has the name. */
  name?: string | null;
  /** Lower limit, in metres above mean sea level; default: from the ground up. */
  floor_m?: number | null;
  /** Upper limit, in metres above mean sea level; default: no limit. */
  ceiling_m?: number | null;
};

/** Zones that operators have activated. */
export type Zones = {
  /** Whether a zone can be activated here. A replay, a demo, and a picture of other nodes have no zones of operators. */
  available: boolean;
  /** The active zones, by name. */
  zones: Array<Zone>;
};

/** What is answered to GET, by path. */
export interface Answers {
  "/api/v1/tracks": Tracks;
  "/api/v1/tracks/{id}": FeatureOfTrackProperties;
  "/api/v1/tracks/{id}/trail": FeatureOfTrailProperties;
  "/api/v1/snapshot": Snapshot;
  "/api/v1/correlations": Correlations;
  "/api/v1/integrity": Integrity;
  "/api/v1/relocations": Relocations;
  "/api/v1/raw": Raw;
  "/api/v1/sensors": Sensors;
  "/api/v1/status": ServiceStatus;
  "/api/v1/cluster": Members;
  "/api/v1/info": Info;
  "/api/v1/coverage": CollectionOfFeatureOfCoverageProperties;
  "/api/v1/areas": CollectionOfFeatureOfAreaProperties;
  "/api/v1/zones": Zones;
  "/api/v1/alerts": Alerts;
  "/api/v1/conflicts": Conflicts;
  "/api/v1/cueing": Cueing;
  "/data/aircraft.json": Picture;
  "/data/receiver.json": Receiver;
  "/uss/flights": Flights;
  "/uss/flights/{id}/details": FlightDetails;
  "/ogc": LandingPage;
  "/ogc/conformance": ConformanceClasses;
  "/ogc/collections": Collections;
  "/ogc/collections/tracks": Collection;
  "/ogc/collections/areas": Collection;
  "/ogc/collections/tracks/items": ItemsOfFeatureOfTrackProperties;
  "/ogc/collections/tracks/items/{id}": FeatureOfTrackProperties;
  "/ogc/collections/areas/items": ItemsOfFeatureOfAreaProperties;
  "/ogc/collections/areas/items/{id}": FeatureOfAreaProperties;
  "/healthz": Health;
  "/readyz": Health;
  "/openapi.json": Record<string, unknown>;
  "/api/v1/asyncapi.json": Record<string, unknown>;
}

/** What is answered to POST, by path. */
export interface Orders {
  "/api/v1/correlations": Correlations;
  "/api/v1/integrity/{identity}": Integrity;
  "/api/v1/relocations/{sensor}": Relocations;
  "/api/v1/relocations/{sensor}/revoke": Relocations;
  "/api/v1/remote-id": RemoteIdPosted;
  "/api/v1/replay/play": Replay;
  "/api/v1/replay/pause": Replay;
  "/api/v1/replay/seek": Replay;
  "/api/v1/replay/speed": Replay;
  "/api/v1/stream-tickets": Ticket;
  "/api/v1/zones/{id}": Zone;
  "/api/v1/zones/{id}/revoke": Zone;
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
  "/api/v1/relocations": {};
  "/api/v1/relocations/{sensor}": { sensor: string };
  "/api/v1/relocations/{sensor}/revoke": { sensor: string };
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
  "/api/v1/zones": {};
  "/api/v1/zones/{id}": { id: string; by?: string };
  "/api/v1/zones/{id}/revoke": { id: string; by?: string };
  "/api/v1/alerts": { since?: string; until?: string; kind?: string | string[]; limit?: number };
  "/api/v1/alerts/{id}/acknowledge": { id: string };
  "/api/v1/alerts/{id}/shelve": { id: string };
  "/api/v1/alerts/{id}/unshelve": { id: string };
  "/api/v1/conflicts": { level?: "none" | "advisory" | "warning" | "violation"; id?: string };
  "/api/v1/cueing": { sensor?: string; limit?: number };
  "/data/aircraft.json": {};
  "/data/receiver.json": {};
  "/uss/flights": { view: string; recent_positions_duration?: number };
  "/uss/flights/{id}/details": { id: string };
  "/ogc": {};
  "/ogc/conformance": {};
  "/ogc/collections": {};
  "/ogc/collections/tracks": {};
  "/ogc/collections/areas": {};
  "/ogc/collections/tracks/items": { bbox?: string; datetime?: string; limit?: number; after?: string };
  "/ogc/collections/tracks/items/{id}": { id: string };
  "/ogc/collections/areas/items": { bbox?: string; datetime?: string; limit?: number; after?: string };
  "/ogc/collections/areas/items/{id}": { id: string };
  "/healthz": {};
  "/readyz": {};
  "/metrics": {};
  "/openapi.json": {};
  "/api/v1/asyncapi.json": {};
  "/api/docs": {};
  "/": {};
}
