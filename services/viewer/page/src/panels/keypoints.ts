import type { Features } from '@gen/corbslam/v1/items_pb';
import { type Sights, sightsText } from '../model/sights';
import { count } from '../model/texts';
import { h } from './dom';

const PX = 1 / 64;

/**
 * What the camera saw: keypoints by size (octave), by whether their depth is known (colour) and by
 * whether they see a landmark (filled); where that was not told, those with depth are filled.
 */
export function keypointsFigure(features: Features, sights: Sights | undefined): HTMLElement {
  const all = features.xPx64.length;
  const label = sights ? sightsText(sights) : `${count(all)} keypoints of the picture`;
  const canvas = h('canvas', { class: 'keypoints', role: 'img', 'aria-label': label });
  const known = features.disparityPx128.filter((disparity) => disparity > 0).length;
  requestAnimationFrame(() => draw(canvas, features, sights?.seeing));
  const [filled, hollow] = sights ? ['', ''] : ['● ', '○ '];
  const caption = h('figcaption', {},
    sights && h('div', {}, `● ${sightsText(sights)}, ○ ${count(all - sights.seeing.size)} see none`),
    h('span', { class: 'depth-known' }, `${filled}${count(known)} with depth`), ' ',
    h('span', { class: 'depth-unknown' }, `${hollow}${count(all - known)} without`),
    '; larger: seen at a coarser scale');
  return h('figure', {}, canvas, caption);
}

function draw(canvas: HTMLCanvasElement, features: Features, seeing: ReadonlySet<number> | undefined): void {
  const ratio = Math.min(devicePixelRatio, 2);
  const box = boundsOf(features);
  const width = canvas.clientWidth || 260;
  const scale = width / box.width;
  canvas.width = width * ratio;
  canvas.height = Math.max(40, Math.min(box.height * scale, 260)) * ratio;
  const context = canvas.getContext('2d')!;
  context.scale(ratio, ratio);
  const style = getComputedStyle(canvas);
  const [known, unknown] = [style.getPropertyValue('--known'), style.getPropertyValue('--unknown')];
  for (let i = 0; i < features.xPx64.length; i++) {
    const x = (features.xPx64[i] * PX - box.x) * scale;
    const y = (features.yPx64[i] * PX - box.y) * scale;
    const hasDepth = (features.disparityPx128[i] ?? 0) > 0;
    context.beginPath();
    context.arc(x, y, (seeing ? 1.1 : 0.8) * 1.2 ** (features.octaves[i] ?? 0), 0, 2 * Math.PI);
    context.strokeStyle = context.fillStyle = hasDepth ? known : unknown;
    if (seeing ? seeing.has(i) : hasDepth) context.fill();
    else context.stroke();
  }
}

/** The picture's size is not told: all keypoints and a little room. */
function boundsOf({ xPx64, yPx64 }: Features): { x: number; y: number; width: number; height: number } {
  const low = [Infinity, Infinity];
  const high = [-Infinity, -Infinity];
  for (let i = 0; i < xPx64.length; i++) {
    low[0] = Math.min(low[0], xPx64[i] * PX);
    high[0] = Math.max(high[0], xPx64[i] * PX);
    low[1] = Math.min(low[1], yPx64[i] * PX);
    high[1] = Math.max(high[1], yPx64[i] * PX);
  }
  if (xPx64.length === 0) return { x: 0, y: 0, width: 640, height: 480 };
  return { x: low[0] - 16, y: low[1] - 16, width: high[0] - low[0] + 32, height: high[1] - low[1] + 32 };
}
