import type { OverlapMatch } from '@gen/corbslam/v1/overlap_pb';
import type { SeenOverlap, Side } from '../feed/pictures';
import { arrange, type Box, boundsOf, placeIn, type Size, some, type Spot } from '../model/picture';
import { isAccepted, many } from '../model/texts';
import { h } from './dom';
import { type Draw, enlargeable } from './enlarged';

const PX = 1 / 64;
const GAP = 6;
// More lines hide what they join.
const MOST_LINES = 40;
const MOST_LARGE = 150;
const LARGE_PX = 600;

/** The pictures of an overlap's two keyframes, with lines between what shows the same. */
export function seenOverlap(asked: Promise<SeenOverlap>): HTMLElement {
  const place = h('div', {}, h('p', { class: 'quiet' }, 'Asking for the pictures …'));
  asked.then((seen) => place.replaceChildren(...figureOf(seen)), (error: unknown) => {
    place.replaceChildren(h('p', { class: 'quiet' }, `No pictures: ${error instanceof Error ? error.message : String(error)}`));
  });
  return place;
}

function figureOf(seen: SeenOverlap): HTMLElement[] {
  const missing = missingText(seen.query, seen.candidate);
  const notes = missing === '' ? [] : [h('p', { class: 'quiet' }, missing)];
  if (!isDrawn(seen.query) && !isDrawn(seen.candidate)) return notes;
  const label = matchesText(seen);
  const { button } = enlargeable(label, drawing(seen));
  return [h('figure', { class: 'seen-figure' }, button, h('figcaption', {}, label)), ...notes];
}

function isDrawn({ shown, features }: Side): boolean {
  return 'picture' in shown || features !== undefined;
}

/** What the lines are. */
export function matchesText({ overlap }: Pick<SeenOverlap, 'overlap'>): string {
  const { length } = overlap.matches;
  const asked = 'asked above or left, candidate below or right';
  if (length === 0) return isAccepted(overlap) ? `No keypoints of the two show the same any more; ${asked}` : `No keypoints of the two look alike; ${asked}`;
  const drawn = length > MOST_LINES ? `, of which some are drawn` : '';
  const pairs = many(length, 'pair of keypoints', 'pairs of keypoints');
  return isAccepted(overlap) ? `${pairs} ${length === 1 ? 'shows' : 'show'} the same${drawn}; ${asked}`
    : `${pairs} ${length === 1 ? 'looks' : 'look'} alike, by themselves${drawn}; ${asked}`;
}

/** Why a picture is missing; empty: none is. */
export function missingText(query: Side, candidate: Side): string {
  const why = ({ shown }: Side) => ('why' in shown ? shown.why : '');
  const [first, second] = [why(query), why(candidate)];
  if (first === second) return first;
  return [first && `Asked: ${first}`, second && `Candidate: ${second}`].filter((text) => text !== '').join(' ');
}

function drawing({ overlap, query, candidate }: SeenOverlap): Draw {
  const [first, second] = [sizeOf(query, overlap.matches, true), sizeOf(candidate, overlap.matches, false)];
  return (context, space, isLarge) => {
    const pair = arrange(first, second, space, GAP);
    drawSide(context, query, first, pair.first);
    drawSide(context, candidate, second, pair.second);
    const lines = some(overlap.matches, isLarge && pair.size.width > LARGE_PX ? MOST_LARGE : MOST_LINES);
    const dashed = !isAccepted(overlap);
    lines.forEach((match, i) => {
      const ends = [placeIn(pair.first, first, ofQuery(match)), placeIn(pair.second, second, ofCandidate(match))];
      drawLine(context, ends[0], ends[1], `hsl(${(360 * i) / lines.length} 90% 55%)`, dashed, isLarge);
    });
    return pair.size;
  };
}

function ofQuery({ queryXPx, queryYPx }: OverlapMatch): Spot {
  return { x: queryXPx, y: queryYPx };
}

function ofCandidate({ candidateXPx, candidateYPx }: OverlapMatch): Spot {
  return { x: candidateXPx, y: candidateYPx };
}

function sizeOf({ shown, features }: Side, matches: readonly OverlapMatch[], isQuery: boolean): Size {
  if ('picture' in shown) return shown.picture.full;
  const spots = matches.map(isQuery ? ofQuery : ofCandidate);
  const keypoints = features ? features.xPx64.map((x, i) => ({ x: x * PX, y: features.yPx64[i] * PX })) : [];
  return boundsOf([...keypoints, ...spots]);
}

function drawSide(context: CanvasRenderingContext2D, { shown, features }: Side, full: Size, box: Box): void {
  if ('picture' in shown) {
    context.drawImage(shown.picture.image, box.x, box.y, box.width, box.height);
    return;
  }
  const style = getComputedStyle(document.documentElement);
  context.strokeStyle = style.getPropertyValue('--line');
  context.lineWidth = 1;
  context.strokeRect(box.x + 0.5, box.y + 0.5, box.width - 1, box.height - 1);
  context.fillStyle = style.getPropertyValue('--quiet');
  for (let i = 0; i < (features?.xPx64.length ?? 0); i++) {
    const { x, y } = placeIn(box, full, { x: features!.xPx64[i] * PX, y: features!.yPx64[i] * PX });
    context.fillRect(x - 0.5, y - 0.5, 1, 1);
  }
}

function drawLine(context: CanvasRenderingContext2D, from: Spot, to: Spot, colour: string, isDashed: boolean, isLarge: boolean): void {
  context.strokeStyle = context.fillStyle = colour;
  context.globalAlpha = 0.8;
  context.lineWidth = isLarge ? 1.2 : 0.8;
  context.setLineDash(isDashed ? [4, 3] : []);
  context.beginPath();
  context.moveTo(from.x, from.y);
  context.lineTo(to.x, to.y);
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
  for (const { x, y } of [from, to]) {
    context.beginPath();
    context.arc(x, y, isLarge ? 2.4 : 1.4, 0, 2 * Math.PI);
    context.fill();
  }
}
