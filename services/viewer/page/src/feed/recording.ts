// A mission inside the page: what a run left behind, which report.html shows without a server.
import { create, fromBinary } from '@bufbuild/protobuf';
import { type Overlap, OverlapSchema, OverlapVerdict } from '@gen/corbslam/v1/overlap_pb';
import type { TrajectoryPose } from '@gen/corbslam/v1/resources_pb';
import { type MissionPulse, MissionPulseSchema, ViewerMessageSchema } from '@gen/corbslam/v1/viewer_pb';
import type { MapChange } from '../model/map_change';
import { decodeMapChange } from './map_change';
import { Rest, RestError } from './rest';
import type { MissionStream, StreamListener } from './stream';

const NO_POINTS = 'Points are left out: with them the map is too long for a report.';

/** What the program wrote into the page. */
export interface Recording {
  mission: string;
  /** Messages of WatchMap or ReplayMap, oldest first: all of them together are the map as it was in the end. */
  map: Uint8Array[];
  /** Map points are in them. */
  hasPoints: boolean;
  /** They tell more than one moment. */
  hasPast: boolean;
  pulse: MissionPulse;
  /** Accepted and refused ones. */
  overlaps: Overlap[];
  /** Where cameras really were, in the global frame: x, y and z of one pose after the other, a list each path. */
  truth: number[][];
}

/** Reads what services/tool/report/html/viewer_frame.cc writes; undefined: the page is one of a server. */
export function parseRecording(text: string | undefined | null): Recording | undefined {
  if (!text) return undefined;
  const { mission, map, hasPoints, hasPast, pulse, overlaps, truth } = JSON.parse(text) as {
    mission: string; map: string[]; hasPoints: boolean; hasPast: boolean; pulse: string; overlaps: string[]; truth: number[][];
  };
  return {
    mission, truth, hasPoints, hasPast, map: map.map(bytesOf), pulse: fromBinary(MissionPulseSchema, bytesOf(pulse)),
    overlaps: overlaps.map((one) => fromBinary(OverlapSchema, bytesOf(one))),
  };
}

function bytesOf(base64: string): Uint8Array {
  return Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
}

/** Answers from a recording, as far as that goes. */
export class RecordedRest extends Rest {
  constructor(override readonly recording: Recording) {
    super(undefined);
  }

  override openStream(_mission: string, listener: StreamListener): MissionStream {
    return new RecordedStream(this.recording, listener);
  }

  override overlaps(_mission: string, acceptedOnly: boolean): Promise<Overlap[]> {
    return Promise.resolve(this.recording.overlaps.filter(({ verdict }) => !acceptedOnly || verdict === OverlapVerdict.ACCEPTED));
  }

  override trajectory(): Promise<TrajectoryPose[]> {
    return Promise.resolve([]);
  }

  override async history(_mission: string, _points: boolean, each: (change: MapChange) => void): Promise<void> {
    for (const bytes of this.recording.map) each(decodeMapChange(bytes));
  }

  protected override get(): Promise<Response> {
    return Promise.reject(new RestError(404, 'A report holds the map, but not this: map_viewer shows it while a map store has the mission.'));
  }
}

/** Tells the recorded map at once. */
class RecordedStream implements MissionStream {
  receivedBytes = 0;
  isBehind = true;
  private readonly timer = setTimeout(() => this.tell(), 0);

  constructor(private readonly recording: Recording, private readonly listener: StreamListener) {}

  close(): void {
    clearTimeout(this.timer);
  }

  private tell(): void {
    const { listener, recording: { map, hasPoints, pulse } } = this;
    listener.onState({ name: 'recorded', note: hasPoints ? '' : NO_POINTS });
    listener.onMessage(create(ViewerMessageSchema, { part: { case: 'pulse', value: pulse } }));
    for (const bytes of map) {
      this.receivedBytes += bytes.length;
      listener.onMap(decodeMapChange(bytes));
    }
    // Once all of it was drawn: merges that lie in the past are not to be seen as news.
    requestAnimationFrame(() => requestAnimationFrame(() => void (this.isBehind = false)));
  }
}
