import type { MissionPage } from './mission_page';
import { parseKeyframeName } from './model/ids';
import { type ViewState, keepInAddress } from './view_state';

const SETTLED_MS = 300;
/** An overlap of a link may be one that was refused: those are asked for after so many looks. */
const LOOKS_FOR_ACCEPTED = 8;
const MOST_LOOKS = 60;

type Kept = Pick<ViewState, 'camera' | 'chosen' | 'at'>;

/** Keeps in the address what is looked at, so that a link opens the same; and opens what a link says. */
export class KeptView {
  /** What the address wants and is not shown yet. */
  private wanted: Kept | undefined;
  private looks = 0;
  private isCameraChosen = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly page: MissionPage) {
    const { controls, element } = page.stage.globalPort;
    controls.addEventListener('end', () => this.onCamera());
    element.addEventListener('keydown', ({ key }) => void (/^Arrow/.test(key) && this.onCamera()));
  }

  /** What an address says is to be shown. */
  want({ camera, chosen, at }: ViewState): void {
    this.wanted = { camera, chosen, at };
    this.looks = 0;
  }

  /** A link says from where to look. */
  get hasCamera(): boolean {
    return (this.wanted?.camera.length ?? 0) > 0;
  }

  /** Shows what is wanted, as far as it is there by now. */
  show(): void {
    const { wanted, page } = this;
    if (!wanted || !page.live.hasPicture || page.model.keyframeCount < 1) return;
    if (wanted.camera.length > 0) this.look(wanted.camera);
    wanted.camera = [];
    if (wanted.at) page.past.goToMoment(wanted.at);
    wanted.at = '';
    if (wanted.chosen && !this.choose(wanted.chosen) && this.looks++ < MOST_LOOKS) return;
    this.wanted = undefined;
  }

  /** All is shown: nobody chose where to look from. */
  forgetCamera(): void {
    this.isCameraChosen = false;
    this.keep();
  }

  /** Something else is looked at; the address says so once that has settled. */
  keep(): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.write(), SETTLED_MS);
  }

  stop(): void {
    clearTimeout(this.timer);
  }

  private look(camera: number[]): void {
    this.page.lookFrom(camera);
    this.isCameraChosen = true;
  }

  /** Returns whether it is there. */
  private choose(name: string): boolean {
    const { page } = this;
    const keyframe = parseKeyframeName(name);
    if (keyframe) {
      void page.selection.keyframe(keyframe);
      return true;
    }
    const number = BigInt(name.slice(name.lastIndexOf('/') + 1));
    const overlap = page.fetched.overlaps.find((one) => one.number === number);
    if (overlap) page.selection.overlap(overlap);
    else if (this.looks === LOOKS_FOR_ACCEPTED && !page.state.refused) page.change({ refused: true });
    return overlap !== undefined;
  }

  private onCamera(): void {
    if (this.page.state.follow) return;
    this.isCameraChosen = true;
    this.keep();
  }

  private write(): void {
    if (this.wanted) return;
    const { page } = this;
    const camera = this.isCameraChosen ? page.stage.globalPort.pose : [];
    page.state = { ...page.state, camera, chosen: page.selection.name, at: page.past.moment };
    keepInAddress(page.state);
  }
}
