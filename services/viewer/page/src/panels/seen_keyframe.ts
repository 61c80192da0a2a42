import type { Features } from '@gen/corbslam/v1/items_pb';
import type { Picture, PictureOrWhy } from '../feed/pictures';
import { fit, placeIn } from '../model/picture';
import { type Sights, sightsText } from '../model/sights';
import { count } from '../model/texts';
import { h } from './dom';
import { type Draw, enlargeable } from './enlarged';
import { keypointsFigure } from './keypoints';

const PX = 1 / 64;

/** A keyframe's picture with its keypoints; until it is there, and where there is none, the keypoints alone. */
export function seenKeyframe(features: Features, sights: Sights | undefined, asked: Promise<PictureOrWhy>): HTMLElement {
  const note = h('p', { class: 'quiet' }, 'Asking for the picture …');
  const place = h('div', {}, keypointsFigure(features, sights), note);
  void asked.then((answer) => {
    if ('why' in answer) note.textContent = answer.why;
    else place.replaceChildren(pictureFigure(answer.picture, features, sights));
  });
  return place;
}

function pictureFigure(picture: Picture, features: Features, sights: Sights | undefined): HTMLElement {
  let showsKeypoints = true;
  const all = features.xPx64.length;
  const label = `What the camera saw${sights ? `; ${sightsText(sights)}` : ''}`;
  const draw: Draw = (context, space, isLarge) => {
    const size = fit(picture.full, space);
    context.drawImage(picture.image, 0, 0, size.width, size.height);
    if (showsKeypoints) drawKeypoints(context, picture, features, sights?.seeing, size, isLarge);
    return size;
  };
  const { button, redraw } = enlargeable(label, draw);
  const toggle = h('label', {}, h('input', {
    type: 'checkbox', checked: true,
    change: (event) => {
      showsKeypoints = (event.target as HTMLInputElement).checked;
      redraw();
    },
  }), ` ${count(all)} keypoints`);
  const caption = h('figcaption', {}, toggle,
    sights && h('div', {}, `● ${sightsText(sights)}, ○ ${count(all - sights.seeing.size)} see none`));
  return h('figure', { class: 'seen-figure' }, button, caption);
}

function drawKeypoints(context: CanvasRenderingContext2D, { full }: Picture, features: Features,
  seeing: ReadonlySet<number> | undefined, size: { width: number; height: number }, isLarge: boolean): void {
  const style = getComputedStyle(document.documentElement);
  const [sees, seesNone] = [style.getPropertyValue('--seeing'), style.getPropertyValue('--seeing-none')];
  const box = { x: 0, y: 0, ...size };
  const radius = isLarge ? 2.4 : 1.2;
  context.lineWidth = isLarge ? 1 : 0.5;
  for (let i = 0; i < features.xPx64.length; i++) {
    const { x, y } = placeIn(box, full, { x: features.xPx64[i] * PX, y: features.yPx64[i] * PX });
    const isFilled = seeing?.has(i) ?? false;
    context.strokeStyle = context.fillStyle = isFilled ? sees : seesNone;
    context.beginPath();
    context.arc(x, y, radius * (isLarge ? 1.1 ** (features.octaves[i] ?? 0) : 1), 0, 2 * Math.PI);
    if (isFilled) context.fill();
    else context.stroke();
  }
}
