import type { MissionEvent } from '@gen/corbslam/v1/events_pb';
import type { MissionPulse, ViewerMessage } from '@gen/corbslam/v1/viewer_pb';
import type { Rest } from './feed/rest';
import type { MissionStream, StreamState } from './feed/stream';
import type { MapChange } from './model/map_change';
import { type IslandChange, MapModel } from './model/map_model';

/** A long change is held back until it is whole, up to so many keyframes and points. */
const MOST_HELD_FLOATS = 3_000_000;

/** What a live mission tells the page. */
export interface LiveListener {
  onMap(changes: IslandChange[]): void;
  onPulse(pulse: MissionPulse): void;
  onEvent(event: MissionEvent): void;
  onConnection(state: StreamState): void;
}

/** The live map of one mission. */
export class Live {
  readonly model = new MapModel();
  readonly stream: MissionStream;
  pulse: MissionPulse | undefined;
  isConnected = false;
  hasPicture = false;
  expectedKeyframes = 0;
  private held: MapChange[] = [];
  private heldFloats = 0;
  private isPicture = false;

  constructor(mission: string, rest: Rest, private readonly listener: LiveListener) {
    this.stream = rest.openStream(mission, {
      onMap: (change) => this.onMap(change),
      onMessage: (message) => this.onMessage(message),
      onState: (state) => {
        this.isConnected = state.name === 'open';
        listener.onConnection(state);
      },
    });
  }

  private onMessage({ part }: ViewerMessage): void {
    if (part.case === 'event') this.listener.onEvent(part.value);
    else if (part.case === 'pulse') this.listener.onPulse((this.pulse = part.value));
    else if (part.case === 'reset') this.onReset(Number(part.value.keyframes));
  }

  private onReset(keyframes: number): void {
    this.model.reset();
    this.held = [];
    this.heldFloats = 0;
    this.isPicture = true;
    this.expectedKeyframes = keyframes;
  }

  /**
   * The first picture grows as it comes. A later change is applied as a whole, so that a merge is
   * never seen half done.
   */
  private onMap(change: MapChange): void {
    const { message, points } = change;
    this.held.push(change);
    for (const columns of points) this.heldFloats += columns?.positions.length ?? 0;
    const grows = this.isPicture && !this.hasPicture;
    if (message.continues && !grows && this.heldFloats < MOST_HELD_FLOATS) return;
    const changes = this.model.apply(this.held.splice(0));
    this.heldFloats = 0;
    if (!message.continues) {
      this.isPicture = false;
      this.hasPicture = true;
    }
    this.listener.onMap(changes);
  }
}
