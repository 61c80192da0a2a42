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

/** How the connection stands. */
export type StreamState =
  | { name: 'connecting' }
  | { name: 'open' }
  | { name: 'away'; retryMs: number }
  | { name: 'refused'; why: 'token' | 'mission' }
  | { name: 'missing'; retryMs: number };

/** What the stream tells. */
export interface StreamListener {
  onMap(change: MapChange): void;
  onMessage(message: ViewerMessage): void;
  onState(state: StreamState): void;
}

/** The WebSocket of one mission: decodes in slices, and connects again with growing pauses. */
export class Stream {
  receivedBytes = 0;
  private socket: WebSocket | undefined;
  private queue: ArrayBuffer[] = [];
  private waitMs = FIRST_WAIT_MS;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private isPumping = false;
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
    this.socket?.close();
    this.queue = [];
  }

  /** Messages came that are not decoded yet. */
  get isBehind(): boolean {
    return this.queue.length > 0;
  }

  private connect(): void {
    this.listener.onState({ name: 'connecting' });
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    const url = `${scheme}://${location.host}/stream/missions/${encodeURIComponent(this.mission)}?points=1`;
    const protocols = this.token ? ['corbslam', `token.${this.token}`] : ['corbslam'];
    const socket = new WebSocket(url, protocols);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => this.listener.onState({ name: 'open' });
    socket.onmessage = ({ data }) => this.receive(data as ArrayBuffer);
    socket.onclose = ({ code }) => this.onClose(socket, code);
    this.socket = socket;
  }

  private receive(data: ArrayBuffer): void {
    this.waitMs = FIRST_WAIT_MS;
    this.receivedBytes += data.byteLength;
    this.queue.push(data);
    if (!this.isPumping) this.pump();
  }

  /** Decodes for a few milliseconds, then lets the page draw. */
  private pump(): void {
    const end = performance.now() + SLICE_MS;
    while (this.queue.length > 0 && performance.now() < end) {
      this.decode(new Uint8Array(this.queue.shift()!));
    }
    this.isPumping = this.queue.length > 0;
    if (this.isPumping) setTimeout(() => this.pump(), 0);
  }

  private decode(bytes: Uint8Array): void {
    if (bytes[0] !== MAP_TAG) return this.listener.onMessage(fromBinary(ViewerMessageSchema, bytes));
    this.listener.onMap(decodeMapChange(new WireReader(bytes, 1).part().content));
  }

  private onClose(socket: WebSocket, code: number): void {
    if (this.isClosed || socket !== this.socket) return;
    if (code === 4401) return this.listener.onState({ name: 'refused', why: 'token' });
    if (code === 4403) return this.listener.onState({ name: 'refused', why: 'mission' });
    const retryMs = this.waitMs;
    this.waitMs = Math.min(2 * this.waitMs, LONGEST_WAIT_MS);
    this.listener.onState({ name: code === 4404 ? 'missing' : 'away', retryMs });
    this.timer = setTimeout(() => this.connect(), retryMs);
  }
}
