import type { Keyframe } from '@gen/corbslam/v1/resources_pb';
import type { PictureOrWhy } from '../feed/pictures';
import { lastSegment, parseKeyframeName } from '../model/ids';
import type { MapNames } from '../model/map_names';
import { clockText } from '../model/moment';
import { headingText, placeOf, positionText } from '../model/place_text';
import type { Sights } from '../model/sights';
import { count } from '../model/texts';
import { h, panel, table } from './dom';
import { seenKeyframe } from './seen_keyframe';

/** What was clicked. */
export class DetailsPanel {
  readonly root: HTMLElement;
  private readonly body: HTMLElement;

  constructor(onClose: () => void) {
    ({ root: this.root, body: this.body } = panel('details', 'Selected'));
    this.root.append(h('button', { class: 'close', 'aria-label': 'Close the details', click: onClose }, '✕'));
    this.root.hidden = true;
    this.body.setAttribute('aria-live', 'polite');
  }

  show(nodes: Node[]): void {
    this.root.hidden = false;
    this.body.replaceChildren(...nodes);
  }

  hide(): void {
    this.root.hidden = true;
    this.body.replaceChildren();
  }
}

/** `highlight`: says how many of its landmarks the map shows. `picture`: what its camera saw. */
export function keyframeDetails(keyframe: Keyframe, names: MapNames, sights: Sights | undefined, highlight: HTMLElement,
  picture: Promise<PictureOrWhy>): Node[] {
  const id = parseKeyframeName(keyframe.name);
  const parent = parseKeyframeName(keyframe.parent);
  const features = keyframe.payload?.features;
  const place = placeOf(keyframe.cameraFromIsland);
  const rows: [string, string][] = [
    ['Robot', lastSegment(keyframe.agent)],
    ['Local map', id ? names.of(id.localMap) : keyframe.name],
    ['Island', `that of ${names.of(lastSegment(keyframe.island))}`],
    ...(place ? [['Right, down, ahead', positionText(place)] as [string, string], ['Looks', headingText(place)] as [string, string]] : []),
    ['Robot’s clock', clockText(keyframe.timestampNs)],
    ['Place', keyframe.placed ? 'given by fusion' : 'follows its nearest relative'],
    ['Local adjustment', keyframe.settled ? 'settled' : 'still going on'],
    ['Revision', keyframe.revision > 0n ? count(keyframe.revision) : 'none yet'],
    ['Parent', parent ? `#${parent.index}${parent.localMap === id?.localMap ? '' : ` of ${names.of(parent.localMap)}`}` : 'none'],
    ['Keypoints', count(keyframe.keypoints)],
    ['… that see a landmark', count(keyframe.observedPoints)],
  ];
  const figure = features ? [seenKeyframe(features, sights, picture)] : [];
  return [h('h3', {}, `Keyframe #${id?.index ?? '?'}`), ...figure, highlight, table(rows)];
}
