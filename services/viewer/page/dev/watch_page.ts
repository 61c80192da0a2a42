// What a page does, counted inside it: calls to WebGL by what they draw, bytes for the GPU, and the time of its script.
import type { Page } from 'playwright-core';

/** Of one span: how often each thing was drawn and with how many vertices, bytes, and each script's milliseconds. */
export interface Watched {
  draws: Record<string, { calls: number; vertices: number }>;
  glCalls: number;
  uploadedBytes: number;
  /** From a message of the stream until it is part of the model. */
  messageMs: number[];
  /** Callbacks that the browser makes before each picture, of those that drew. */
  frameMs: number[];
}

/** Runs inside the page before all else; it knows nothing of this file. */
function install(): void {
  const empty = () => ({ draws: {}, glCalls: 0, uploadedBytes: 0, messageMs: [], frameMs: [] }) as Watched;
  let watched = empty();
  const gl = WebGL2RenderingContext.prototype as unknown as Record<string, (...args: never[]) => unknown>;
  const wrap = (name: string, before: (...args: never[]) => void) => {
    const real = gl[name];
    gl[name] = function (this: unknown, ...args: never[]) {
      before(...args);
      return real.apply(this, args);
    };
  };
  for (const [name, { value }] of Object.entries(Object.getOwnPropertyDescriptors(WebGL2RenderingContext.prototype))) {
    if (typeof value === 'function') wrap(name, () => void watched.glCalls++);
  }
  // The map's lines and triangles are indexed; the grid's lines are not.
  const count = (mode: number, vertices: number, isIndexed: boolean) => {
    const what = mode === 0 ? 'points' : mode === 1 ? (isIndexed ? 'keyframes' : 'grid') : 'lines';
    const draw = (watched.draws[what] ??= { calls: 0, vertices: 0 });
    draw.calls++;
    draw.vertices += vertices;
  };
  wrap('drawArrays', (mode: number, _first: number, vertices: number) => count(mode, vertices, false));
  wrap('drawElements', (mode: number, vertices: number) => count(mode, vertices, true));
  wrap('bufferData', (_target: number, data: ArrayBufferView | number) => void (watched.uploadedBytes += typeof data === 'number' ? 0 : data.byteLength));
  wrap('bufferSubData', (_target: number, _at: number, data: Float32Array, _from?: number, length?: number) =>
    void (watched.uploadedBytes += (length ?? data.length) * data.BYTES_PER_ELEMENT));

  const timed = <T extends unknown[]>(callback: (...args: T) => void, note: (ms: number) => void) => (...args: T) => {
    const begun = performance.now();
    callback(...args);
    note(performance.now() - begun);
  };
  const request = window.requestAnimationFrame;
  window.requestAnimationFrame = (callback) => request.call(window, (now) => {
    const before = watched.glCalls;
    timed(callback, (ms) => void (watched.glCalls > before && watched.frameMs.push(ms)))(now);
  });
  const message = Object.getOwnPropertyDescriptor(WebSocket.prototype, 'onmessage')!;
  Object.defineProperty(WebSocket.prototype, 'onmessage', {
    ...message,
    set(listener: (event: MessageEvent) => void) {
      message.set!.call(this, timed(listener, (ms) => void watched.messageMs.push(ms)));
    },
  });
  Object.assign(window, { takeWatched: () => [watched, (watched = empty())][0] });
}

export async function watchPage(page: Page): Promise<void> {
  await page.addInitScript(install);
}

/** What was counted since it was asked before. */
export function takeWatched(page: Page): Promise<Watched> {
  return page.evaluate('window.takeWatched()') as Promise<Watched>;
}
