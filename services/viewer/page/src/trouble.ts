import { RestError } from './feed/rest';
import { plainText } from './model/plain_text';

/** What a request that failed means: the token is to be asked for again, or words for people; empty: nothing. */
export function requestTrouble(error: unknown): { refused?: string; failed: string } {
  if (error === undefined) return { failed: '' };
  if (!(error instanceof RestError)) return { failed: error instanceof Error ? error.message : String(error) };
  if (error.status === 401) return { refused: `The token is not taken any more: ${error.message}`, failed: '' };
  if (error.status === 403) return { refused: plainText(error.message), failed: '' };
  // A mission that went is said by the stream.
  return { failed: error.status === 404 ? '' : plainText(error.message) };
}

/** Says on the page when the browser takes the graphics card away, and when it gives it back. */
export function onGraphicsTrouble(canvas: HTMLCanvasElement, say: (trouble: string) => void, signal: AbortSignal): void {
  canvas.addEventListener('webglcontextlost', () => {
    say('The graphics card was taken away from this page. The picture stands still until it comes back; if it does not, load the page again.');
  }, { signal });
  canvas.addEventListener('webglcontextrestored', () => say(''), { signal });
}
