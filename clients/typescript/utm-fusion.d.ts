import type { Answers, FeatureOfTrackProperties, Orders, Parameters, Problem, StreamMessage } from "./types.js";

export type * from "./types.js";

/** A track with its place and all that is known of it. */
export type Track = FeatureOfTrackProperties;

/** An event of the stream; its `event` says what its data are. */
export type StreamEvent = StreamMessage;

type Filter = Parameters["/api/v1/stream"];

export interface StreamOptions {
  signal?: AbortSignal;
  /** `id` of an event of before. */
  lastEventId?: string;
}

export interface PictureUpdate {
  /** By id; the same map each time. */
  tracks: Map<string, Track>;
  event: Extract<StreamEvent, { event: "snapshot" | "tracks" | "ended" | "resync" }>;
}

export declare class ApiError extends Error {
  problem: Problem;
}

export declare class Client {
  constructor(url: string, options?: { token?: string });
  get<P extends keyof Answers>(path: P, parameters?: Parameters[P]): Promise<Answers[P]>;
  post<P extends keyof Orders>(path: P, parameters?: Parameters[P], body?: unknown): Promise<Orders[P]>;
  tracks(parameters?: Parameters["/api/v1/tracks"]): AsyncGenerator<Track, void, void>;
  events(parameters?: Filter, options?: StreamOptions): AsyncGenerator<StreamEvent, void, void>;
  pictures(parameters?: Filter, options?: StreamOptions): AsyncGenerator<PictureUpdate, void, void>;
}
