import { type DescMessage, type MessageShape, fromBinary, fromJson } from '@bufbuild/protobuf';
import { GetTrajectoryResponseSchema, ListMissionsResponseSchema, ListOverlapsResponseSchema } from '@gen/corbslam/v1/map_store_service_pb';
import type { Overlap } from '@gen/corbslam/v1/overlap_pb';
import { type Keyframe, KeyframeSchema, type Mission, type TrajectoryPose } from '@gen/corbslam/v1/resources_pb';
import { type KeyframeId, keyframeName } from '../model/ids';
import type { MapChange } from '../model/map_change';
import { decodeMapChange } from './map_change';
import { LengthPrefixed } from './length_prefixed';
import type { Recording } from './recording';
import { type MissionStream, Stream, type StreamListener } from './stream';

/** Beside the page, wherever that is: a proxy may have put the viewer below a path of its own. */
const MISSIONS = 'api/missions';

/** Further overlaps are not asked for. */
export const MOST_OVERLAPS = 20_000;

/** The server refused, with a reason for people. */
export class RestError extends Error {
  constructor(readonly status: number, message: string) {
    super(message);
  }
}

/** What there is to show beside the map. */
export interface Offer {
  /** A server can be asked for what is not part of the map, and has other missions, too. */
  readonly isServed: boolean;
  /** The map's past can be played. */
  readonly hasPast: boolean;
}

/** The viewer's request and answer interface. */
export class Rest implements Offer {
  receivedBytes = 0;
  /** What is shown instead of a server's missions. */
  readonly recording: Recording | undefined = undefined;

  constructor(public token: string | undefined) {}

  get isServed(): boolean {
    return !this.recording;
  }

  get hasPast(): boolean {
    return this.recording?.hasPast ?? true;
  }

  /** What a mission tells by itself. */
  openStream(mission: string, listener: StreamListener): MissionStream {
    return new Stream(mission, this.token, listener);
  }

  async missions(): Promise<Mission[]> {
    const missions: Mission[] = [];
    let pageToken = '';
    do {
      const query = pageToken ? `?pageToken=${encodeURIComponent(pageToken)}` : '';
      const page = await this.json(`${MISSIONS}${query}`, ListMissionsResponseSchema);
      missions.push(...page.missions);
      pageToken = page.nextPageToken;
    } while (pageToken);
    return missions;
  }

  async overlaps(mission: string, acceptedOnly: boolean): Promise<Overlap[]> {
    const overlaps: Overlap[] = [];
    let pageToken = '';
    do {
      const query = `acceptedOnly=${acceptedOnly}&pageSize=1000&pageToken=${encodeURIComponent(pageToken)}`;
      const page = await this.json(`${root(mission)}/overlaps?${query}`, ListOverlapsResponseSchema);
      overlaps.push(...page.overlaps);
      pageToken = page.nextPageToken;
    } while (pageToken && overlaps.length < MOST_OVERLAPS);
    return overlaps;
  }

  keyframe(mission: string, id: KeyframeId): Promise<Keyframe> {
    return this.json(`${root(mission)}/${keyframeName(id)}?view=full`, KeyframeSchema);
  }

  /** What its camera saw, and how many pixels of its keypoints' places one of the picture is. */
  async picture(mission: string, id: KeyframeId): Promise<{ blob: Blob; scale: number }> {
    const response = await this.get(`${root(mission)}/${keyframeName(id)}/picture`);
    const blob = await response.blob();
    this.receivedBytes += blob.size;
    return { blob, scale: Number(response.headers.get('Picture-Scale')) };
  }

  /** What the mission has under this path. */
  message<S extends DescMessage>(path: string, mission: string, schema: S): Promise<MessageShape<S>> {
    return this.json(`${root(mission)}/${path}`, schema);
  }

  /** Its poses alone. */
  keyframePose(mission: string, id: KeyframeId): Promise<Keyframe> {
    return this.json(`${root(mission)}/${keyframeName(id)}`, KeyframeSchema);
  }

  async trajectory(mission: string, frame: 'global' | 'local'): Promise<TrajectoryPose[]> {
    const poses: TrajectoryPose[] = [];
    await this.messages(`${root(mission)}/trajectory?frame=${frame}`, (bytes) => {
      poses.push(...fromBinary(GetTrajectoryResponseSchema, bytes).poses);
    });
    return poses;
  }

  /** Rows of where the mission's cameras really were; empty: that is not known. */
  async truth(mission: string): Promise<string> {
    const text = await (await this.get(`${root(mission)}/truth`)).text();
    this.receivedBytes += text.length;
    return text;
  }

  history(mission: string, points: boolean, each: (change: MapChange) => void): Promise<void> {
    return this.messages(`${root(mission)}/history?points=${points ? 1 : 0}&max=100`, (bytes) => {
      each(decodeMapChange(bytes));
    });
  }

  private async json<S extends DescMessage>(path: string, schema: S): Promise<MessageShape<S>> {
    const response = await this.get(path);
    const text = await response.text();
    this.receivedBytes += text.length;
    return fromJson(schema, JSON.parse(text), { ignoreUnknownFields: true });
  }

  private async messages(path: string, each: (bytes: Uint8Array) => void): Promise<void> {
    const reader = (await this.get(path)).body!.getReader();
    const cutter = new LengthPrefixed();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) break;
      this.receivedBytes += value.length;
      for (const message of cutter.push(value)) each(message);
    }
    if (cutter.rest > 0) throw new RestError(0, 'The answer broke off.');
  }

  protected async get(path: string): Promise<Response> {
    const headers: HeadersInit = this.token ? { Authorization: `Bearer ${this.token}` } : {};
    const response = await fetch(path, { headers });
    if (!response.ok) throw new RestError(response.status, await reason(response));
    return response;
  }
}

function root(mission: string): string {
  return `${MISSIONS}/${encodeURIComponent(mission)}`;
}

async function reason(response: Response): Promise<string> {
  try {
    const { error } = (await response.json()) as { error?: unknown };
    if (typeof error === 'string' && error) return error;
  } catch {
    // The body was not the JSON that errors come with; the status has to do.
  }
  return `The server answered with status ${response.status}.`;
}
