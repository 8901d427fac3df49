// Types that several files of the page share, for the type check (scripts/web-types). The page does not load this file.

type Api = import("../../../clients/typescript/types").Answers;
type AlertsAnswer = Api["/api/v1/alerts"];
type AreasAnswer = Api["/api/v1/areas"];
type ConflictsAnswer = Api["/api/v1/conflicts"];
type Info = Api["/api/v1/info"];
type Members = Api["/api/v1/cluster"];
type RawAnswer = Api["/api/v1/raw"];
type SensorsAnswer = Api["/api/v1/sensors"];
type StatusAnswer = Api["/api/v1/status"];
type ZonesAnswer = Api["/api/v1/zones"];

type Alert = import("../../../clients/typescript/types").Alert;
type AreaProperties = import("../../../clients/typescript/types").AreaProperties;
type Conflict = import("../../../clients/typescript/types").Conflict;
type Contributor = import("../../../clients/typescript/types").Contributor;
type Correlation = import("../../../clients/typescript/types").Correlation;
type Bias = import("../../../clients/typescript/types").RegistrationValue;
type CameraOrientation = import("../../../clients/typescript/types").CameraOrientation;
type Competitor = import("../../../clients/typescript/types").Competitor;
type TrackFeature = import("../../../clients/typescript/types").FeatureOfTrackProperties;
type GatewayState = import("../../../clients/typescript/types").GatewayState;
type Heartbeat = import("../../../clients/typescript/types").Heartbeat;
type IdentityIntegrity = import("../../../clients/typescript/types").IdentityIntegrity;
type Learnt = import("../../../clients/typescript/types").Learnt;
type LearntTransponderType = import("../../../clients/typescript/types").LearntTransponderType;
type Line = import("../../../clients/typescript/types").Line;
type Orders = import("../../../clients/typescript/types").Orders;
type PastProperties = import("../../../clients/typescript/types").PastProperties;
type Registration = import("../../../clients/typescript/types").Registration;
type SensorProperties = import("../../../clients/typescript/types").SensorProperties;
type StreamMessage = import("../../../clients/typescript/types").StreamMessage;
type TrackProperties = import("../../../clients/typescript/types").TrackProperties;
type UasId = import("../../../clients/typescript/types").UasId;
type UnknownSource = import("../../../clients/typescript/types").UnknownSource;

type ReplayState = NonNullable<Info["replay"]>;
type Severity = "warning" | "critical";
type Source = "fused" | "radar" | "transponder" | "camera";

/** Answer to GET of a path below api/v1/, with or without a query. */
type Answer<Path extends string> = Path extends `${infer Plain}?${string}`
  ? Answer<Plain>
  : Path extends "alerts"
    ? AlertsAnswer
    : `/api/v1/${Path}` extends keyof Api
      ? Api[`/api/v1/${Path}`]
      : Path extends `tracks/${string}`
        ? Api["/api/v1/tracks/{id}"]
        : never;

/** Answer to POST of a path below api/v1/. */
type Posted<Path extends string> = `/api/v1/${Path}` extends keyof Orders
  ? Orders[`/api/v1/${Path}`]
  : Path extends `alerts/${string}/${AlertAction}`
    ? Alert
    : Path extends `integrity/${string}`
      ? Orders["/api/v1/integrity/{identity}"]
      : Path extends `relocations/${string}`
        ? Orders["/api/v1/relocations/{sensor}"]
        : Path extends `zones/${string}`
          ? Orders["/api/v1/zones/{id}"]
          : never;

type AlertAction = "acknowledge" | "shelve" | "unshelve";

/** Properties of a track from the stream, or from the history, which has few of them. */
type TrackData = PastProperties & Partial<Omit<TrackProperties, keyof PastProperties>>;

/** Tracks from the stream or the history. */
interface TrackCollection {
  features: { properties: TrackData }[];
  time?: string;
  at?: "now";
  published_at?: string;
  latency_s?: number;
}

type Colour = import("./palette.js").Colour;
type ActiveZones = import("./activezones.js").ActiveZones;
type Alerts = import("./alerts.js").Alerts;
type Conflicts = import("./conflicts.js").Conflicts;
type DecodedFeature = import("./mvt.js").DecodedFeature;
type DecodedLayer = import("./mvt.js").DecodedLayer;
type FreeSpace = import("./freespace.js").FreeSpace;
type Frame = import("./geo.js").Frame;
type Map2d = import("./map.js").Map2d;
type Picture = import("./picture.js").Picture;
type PictureTiles = import("./picturetiles.js").PictureTiles;
type Raw = import("./raw.js").Raw;
type Read = import("./reads.js").Read;
type Reads = import("./reads.js").Reads;
type Replay = import("./replay.js").Replay;
type Shapes = import("./shapes.js").Shapes;
type Status = import("./status.js").Status;
type Tiles<S extends TileSource> = import("./tiles.js").Tiles<S>;
type Track = import("./picture.js").Track;
type Verdict = import("./trust.js").Verdict;
type VectorTiles = import("./vectortiles.js").VectorTiles;
type View = import("./view.js").View;
type Zones = import("./zones.js").Zones;

/** Attributes of an element. True is an empty one; false, null and undefined are left out. */
type Attributes = Record<string, string | number | boolean | null | undefined>;
type Context = CanvasRenderingContext2D;
/** East and north in metres, or x and y in pixels. */
type Point = [number, number];
/** Left, top, right, bottom, in pixels. */
type Box = [number, number, number, number];
/** A track with its place on the screen and its importance; lower is more important. */
type Placed = [Track, number, number, number];
/** Symbols that lie on one another: place of the first on the screen, and their number. */
type Crowd = [number, number, number];
/** Maps a place in metres to another frame. */
type Move = (x: number, y: number) => Point;

/** Names of the data that the page requests. */
type ReadName =
  | "tracks" | "info" | "state" | "sensors" | "cluster" | "alerts" | "history" | "conflicts" | "integrity" | "raw" | "page"
  | "coverage" | "areas" | "zones" | TileLayer;

/** The picture that a stream is to have, and the length of its trails. */
interface StreamWish {
  at: "lagged" | "now";
  trailS: number;
}

type EventName = Exclude<StreamMessage["event"], "conflict">;
type EventData<Name extends EventName> = Extract<StreamMessage, { event: Name }>["data"];

/** A function for each event of a stream, and for its beginning and end. */
type StreamHandlers = { [Name in Exclude<EventName, "closed">]: (data: EventData<Name>) => void } & {
  opened(): void;
  /** Seconds until the next attempt, and the cause. */
  failed(wait: number, why: string): void;
};

/** A tool that receives the clicks on the map. */
interface Tool {
  title: string;
  hint: string;
  add(x: number, y: number, track: Track | null): void;
  undo(): void;
  clear(): void;
  words(): string;
  draw(context: Context, view: View): void;
}

/** Effects of the pointer on the map; `hovered` has no arguments when it has left. */
interface Steering {
  moved(isPan: boolean): void;
  clicked(px: number, py: number): void;
  hovered(px?: number, py?: number): void;
}

/** A source of map tiles. */
interface TileSource {
  tilePx: number;
  alpha(): number;
  picture(zoom: number, x: number, y: number): HTMLImageElement | HTMLCanvasElement | null;
}

/** Layers of the map with tiles. */
type TileLayer = "base" | "tiles";

/** Receives whether the latest tiles arrive, and the reason if not. */
type TilesCame = (isGood: boolean, why?: string) => void;

/** Heading and text of a property, with an explanation if there is one; the text is null if it is unknown. */
type Property = [string, string | number | null | undefined, string?];

/** A radar with its place in metres. */
interface Radar {
  id: string;
  x: number;
  y: number;
}

/** A GeoJSON object of any type, from the service or from a file. */
type GeoJson =
  | { type: "FeatureCollection"; features?: GeoJson[] }
  | { type: "Feature"; id?: string | number; geometry?: GeoJson | null; properties?: { [name: string]: unknown } | null }
  | { type: "GeometryCollection"; geometries?: GeoJson[] }
  | { type: "Point"; coordinates: number[] }
  | { type: "MultiPoint" | "LineString"; coordinates: number[][] }
  | { type: "MultiLineString" | "Polygon"; coordinates: number[][][] }
  | { type: "MultiPolygon"; coordinates: number[][][][] };

interface Collection {
  type: "FeatureCollection";
  features: GeoJson[];
}

interface NumberConstructor {
  isFinite(value: unknown): value is number;
}

interface DateConstructor {
  /** NaN without a time. */
  parse(time: string | null | undefined): number;
}

type HeightUnit = "m" | "ft" | "FL" | "m-agl" | "ft-agl";
type SpeedUnit = "m/s" | "kt" | "km/h";
type DistanceUnit = "m" | "nm";
type Layer = keyof typeof import("./settings.js").LAYERS;
type Kind = keyof typeof import("./settings.js").KINDS;

/** Settings of the operator. */
interface Settings {
  /** Latitude and longitude of the middle of the map. */
  centre: Point | null;
  /** Pixels per metre. */
  scale: number | null;
  selected: string | null;
  follow: boolean;
  text: string;
  sources: Set<Source>;
  flagged: boolean;
  /** Metres above mean sea level. */
  low: number | null;
  high: number | null;
  kinds: Set<Kind>;
  integrity: string;
  zone: string;
  watchedOnly: boolean;
  watched: Set<string>;
  sort: { column: string; descending: boolean };
  theme: "auto" | "light" | "dark";
  layers: Record<Layer, boolean>;
  labelBy: "name" | "number" | "serial";
  colourBy: "source" | "height";
  trailS: number;
  units: { height: HeightUnit; speed: SpeedUnit; distance: DistanceUnit };
  /** Height of the ground above mean sea level, entered by the operator. */
  groundM: number | null;
  sound: boolean;
  at: "lagged" | "now";
}
