import type { Overlap } from '@gen/corbslam/v1/overlap_pb';
import type { Keyframe } from '@gen/corbslam/v1/resources_pb';
import type { MissionPage } from './mission_page';
import { Pictures } from './feed/pictures';
import { type KeyframeId, keyframeName, parseKeyframeName } from './model/ids';
import { plainText } from './model/plain_text';
import { type Sights, highlightText, sightsOf, splitLandmarks } from './model/sights';
import { type DetailsPanel, keyframeDetails } from './panels/details';
import { h, setText } from './panels/dom';
import { overlapDetails } from './panels/overlaps';
import { seenOverlap } from './panels/seen_overlap';
import { pickKeyframe, pickOverlap } from './scene/picking';

/** What the user chose: a keyframe, an overlap, or nothing. */
export class Selection {
  private chosen = '';
  private sights: Sights | undefined;
  private readonly highlight = h('p', { class: 'note' });

  constructor(private readonly page: MissionPage, private readonly details: DetailsPanel, private readonly onShow: () => void) {}

  private get pictures(): Pictures {
    return new Pictures(this.page.rest, this.page.mission);
  }

  /** As a link names it; empty: nothing. */
  get name(): string {
    return this.chosen;
  }

  get isEmpty(): boolean {
    return this.chosen === '';
  }

  /** Chooses what lies under the pointer; keyframes go before lines. */
  pick({ clientX, clientY }: MouseEvent): void {
    const { stage, state } = this.page;
    const port = stage.globalPort;
    const box = port.element.getBoundingClientRect();
    const [x, y] = [clientX - box.left, clientY - box.top];
    const keyframe = pickKeyframe(stage.map, port, x, y, ({ agent }) => !state.hidden.has(agent));
    const overlap = pickOverlap(stage.overlapsView.shown, port, x, y);
    if (keyframe) void this.keyframe(keyframe);
    else if (overlap) this.overlap(overlap);
    else this.clear();
  }

  async keyframe(id: KeyframeId): Promise<void> {
    const name = keyframeName(id);
    this.chosen = name;
    this.sights = undefined;
    this.page.overlapChosen(undefined, id);
    this.page.keepView();
    this.details.show([h('p', { class: 'quiet' }, 'Asking the map store …')]);
    this.onShow();
    try {
      const keyframe = await this.page.rest.keyframe(this.page.mission, id);
      if (this.chosen === name) this.show(keyframe);
    } catch (error) {
      if (this.chosen === name) this.details.show([h('p', { role: 'alert' }, plainText(error instanceof Error ? error.message : String(error)))]);
    }
  }

  /** Says how many of the landmarks are in the map, which may have changed. */
  refresh(): void {
    if (!this.sights) return;
    const { missing } = splitLandmarks(this.sights.landmarks, (id) => this.page.model.localMap(id)?.points);
    setText(this.highlight, highlightText(this.sights, missing, this.page.past.model !== undefined));
  }

  private show(keyframe: Keyframe): void {
    this.sights = sightsOf(keyframe);
    this.page.sightsChosen(this.sights?.landmarks ?? []);
    setText(this.highlight, 'Which landmarks it sees the store does not tell.');
    this.refresh();
    const id = parseKeyframeName(keyframe.name);
    const picture = id ? this.pictures.of(id) : Promise.resolve({ why: '' });
    this.details.show(keyframeDetails(keyframe, this.page.names, this.sights, this.highlight, picture));
  }

  overlap(overlap: Overlap): void {
    this.sights = undefined;
    this.chosen = `overlaps/${overlap.number}`;
    this.page.overlapChosen(overlap, undefined);
    this.page.keepView();
    const [query, candidate] = [parseKeyframeName(overlap.query), parseKeyframeName(overlap.candidate)];
    const seen = query && candidate ? [seenOverlap(this.pictures.ofOverlap(overlap.number, query, candidate))] : [];
    const [title, ...rest] = overlapDetails(overlap, (name) => this.page.names.keyframe(name));
    this.details.show([title, ...seen, ...rest]);
    this.onShow();
  }

  clear(): void {
    this.chosen = '';
    this.sights = undefined;
    this.page.overlapChosen(undefined, undefined);
    this.page.keepView();
    this.details.hide();
  }
}
