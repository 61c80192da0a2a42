import { fromBinary } from '@bufbuild/protobuf';
import type { MapChange } from '../model/map_change';
import { decodeMapChange } from './map_change';
import { WireReader } from './wire';
import { type ViewerMessage, ViewerMessageSchema } from '@gen/corbslam/v1/viewer_pb';

const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 8000;
/** Of ViewerMessage.map: field 1, length-delimited. A message has one part. */
const MAP_TAG = 10;
const SLICE_MS = 12;
/** A pulse comes each second, or later where the store is slow; a silent link may be dead and not say so. */
const SILENT_MS = 15_000;
const DEAD_MS = 45_000;
const LISTEN_EVERY_MS = 1000;

/** How the connection stands. */
export type StreamState =
  | { name: 'connecting' }
  | { name: 'open' }
  | { name: 'recorded'; note: string }
  | { name: 'away'; retryMs: number }
  | { name: 'refused'; why: 'token' | 'mission' }
  | { name: 'silent'; forMs: number }
  | { name: 'busy'; retryMs: number; reason: string }
  | { name: 'impossible'; reason: string };

/** What the stream tells. */
export interface StreamListener {
  onMap(change: MapChange): void;
  onMessage(message: ViewerMessage): void;
  onState(state: StreamState): void;
}

/** Where it comes from. */
export interface MissionStream {
  readonly receivedBytes: number;
  /** Messages came that are not decoded yet. */
  readonly isBehind: boolean;
  close(): void;
}

/** Beside the page, wherever that is: a proxy may have put the viewer below a path of its own. */
export function streamAddress(page: string, mission: string): string {
  const url = new URL(`stream/missions/${encodeURIComponent(mission)}?points=1`, page);
  url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
  url.hash = '';
  return url.href;
}

/** The WebSocket of one mission: decodes in slices, and connects again with growing pauses. */
export class Stream implements MissionStream {
  receivedBytes = 0;
  private socket: WebSocket | undefined;
  private queue: ArrayBuffer[] = [];
  private waitMs = FIRST_WAIT_MS;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private pumping: ReturnType<typeof setTimeout> | undefined;
  private isPumping = false;
  private heardMs = 0;
  private isSilent = false;
  private readonly listening = setInterval(() => this.listen(), LISTEN_EVERY_MS);
  private isClosed = false;

  constructor(
    private readonly mission: string,
    private readonly token: string | undefined,
    private readonly listener: StreamListener,
  ) {
    this.connect();
  }

  close(): void {
    this.isClosed = true;
    clearTimeout(this.timer);
    clearInterval(this.listening);
    this.socket?.close();
    this.queue = [];
  }

  get isBehind(): boolean {
    return this.queue.length > 0;
  }

  private connect(): void {
    this.listener.onState({ name: 'connecting' });
    const url = streamAddress(document.baseURI, this.mission);
    const protocols = this.token ? ['corbslam', `token.${this.token}`] : ['corbslam'];
    const socket = new WebSocket(url, protocols);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => this.onOpen(socket);
    socket.onmessage = ({ data }) => socket === this.socket && this.receive(data as ArrayBuffer);
    socket.onclose = ({ code, reason }) => this.onClose(socket, code, reason);
    this.socket = socket;
  }

  private onOpen(socket: WebSocket): void {
    if (socket !== this.socket) return;
    this.heardMs = performance.now();
    this.isSilent = false;
    this.listener.onState({ name: 'open' });
  }

  /** Says when nothing comes any more, and gives a connection up that stays silent. */
  private listen(): void {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    const forMs = performance.now() - this.heardMs;
    if (forMs < SILENT_MS) return;
    if (forMs < DEAD_MS) {
      this.isSilent = true;
      return this.listener.onState({ name: 'silent', forMs });
    }
    const dead = this.socket;
    dead.close();
    this.onClose(dead, 0, '');
  }

  private receive(data: ArrayBuffer): void {
    this.waitMs = FIRST_WAIT_MS;
    this.heardMs = performance.now();
    if (this.isSilent) this.listener.onState({ name: 'open' });
    this.isSilent = false;
    this.receivedBytes += data.byteLength;
    this.queue.push(data);
    // Of a page that nobody sees, browsers hold timers back for up to a minute.
    if (!this.isPumping || document.hidden) this.pump();
  }

  /** Decodes for a few milliseconds, then lets the page draw. */
  private pump(): void {
    const end = performance.now() + SLICE_MS;
    while (this.queue.length > 0 && (document.hidden || performance.now() < end)) {
      this.decode(new Uint8Array(this.queue.shift()!));
    }
    this.isPumping = this.queue.length > 0;
    clearTimeout(this.pumping);
    if (this.isPumping) this.pumping = setTimeout(() => this.pump(), 0);
  }

  private decode(bytes: Uint8Array): void {
    if (bytes[0] !== MAP_TAG) return this.listener.onMessage(fromBinary(ViewerMessageSchema, bytes));
    this.listener.onMap(decodeMapChange(new WireReader(bytes, 1).part().content));
  }

  private onClose(socket: WebSocket, code: number, reason: string): void {
    if (this.isClosed || socket !== this.socket) return;
    this.socket = undefined;
    if (code === 4401) return this.listener.onState({ name: 'refused', why: 'token' });
    if (code === 4403) return this.listener.onState({ name: 'refused', why: 'mission' });
    // A mission that is not there yet is waited for: what can't be found never will be.
    if (code === 4404) return this.listener.onState({ name: 'impossible', reason });
    const retryMs = this.waitMs;
    this.waitMs = Math.min(2 * this.waitMs, LONGEST_WAIT_MS);
    this.listener.onState(code === 4429 ? { name: 'busy', retryMs, reason } : { name: 'away', retryMs });
    this.timer = setTimeout(() => this.connect(), retryMs);
  }
}
