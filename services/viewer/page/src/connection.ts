import type { MissionPulse } from '@gen/corbslam/v1/viewer_pb';
import type { StreamState } from './feed/stream';
import { plainText } from './model/plain_text';
import { missionTrouble } from './model/texts';

const REFUSALS = { token: 'The token was refused.', mission: 'This token does not open this mission.' };
const ASKS_FOR_TOKEN = 'This viewer shows missions to those who have a token for them.';

/** Where it is shown how the connections stand. */
export interface ConnectionSign {
  showConnection(isLive: boolean, words: string): void;
  showBanner(words: string): void;
}

/** Says how the connections stand: this page's to the viewer, and the viewer's to the store. */
export class Connection {
  private state: StreamState = { name: 'connecting' };
  private pulse: MissionPulse | undefined;
  private wasOpen = false;
  private failed = '';
  private isPast = false;
  private trouble = '';

  constructor(
    private readonly sign: ConnectionSign,
    private readonly hadToken: boolean,
    private readonly onRefused: (reason: string) => void,
    /** Whether there is a picture. */
    private readonly hasPicture: () => boolean,
  ) {}

  /** What the page shows of robots and fusion is how they are now. */
  get isLive(): boolean {
    return (this.state.name === 'open' || this.isRecorded) && this.pulse !== undefined && this.pulse.storeAnswers;
  }

  /** What is shown is what a run left behind. */
  private get isRecorded(): boolean {
    return this.state.name === 'recorded';
  }

  onState(state: StreamState): void {
    if (state.name === 'refused') return this.onRefused(this.hadToken ? REFUSALS[state.why] : ASKS_FOR_TOKEN);
    // What the viewer said before a connection broke is not how things are.
    if (state.name !== 'open') this.pulse = undefined;
    this.state = state;
    this.wasOpen ||= state.name === 'open';
    this.show();
  }

  onPulse(pulse: MissionPulse): void {
    this.pulse = pulse;
    this.show();
  }

  /** What else was asked for could not be had, and is shown as it was; empty: it could. */
  onRequests(failed: string): void {
    this.failed = failed;
    this.show();
  }

  /** The past is shown, or no longer. */
  onPast(isPast: boolean): void {
    if (isPast === this.isPast) return;
    this.isPast = isPast;
    this.show();
  }

  /** This page itself can't show what there is; empty: it can. */
  onTrouble(trouble: string): void {
    this.trouble = trouble;
    this.show();
  }

  private show(): void {
    const isWaiting = this.state.name === 'connecting' || (this.state.name === 'open' && !this.pulse);
    const words = this.isPast ? 'the past' : this.isRecorded ? 'recorded' : this.isLive ? 'live' : isWaiting && !this.wasOpen ? 'connecting' : 'not live';
    this.sign.showConnection(this.isLive && words === 'live', words);
    this.sign.showBanner(this.words());
  }

  private words(): string {
    const { state, pulse } = this;
    const stays = this.hasPicture() ? ' The picture is as it was.' : '';
    switch (state.name) {
      case 'recorded': return this.trouble || state.note;
      case 'away': return `The viewer does not answer; it is asked again in ${seconds(state.retryMs)}.${stays}`;
      case 'connecting': return this.wasOpen ? `Connecting again …${stays}` : '';
      case 'silent': return `Nothing has come from the viewer for ${seconds(state.forMs)}.${stays}`;
      case 'busy': return `${sentence(state.reason || 'The viewer shows as many missions as it may')} It is asked again in ${seconds(state.retryMs)}.${stays}`;
      case 'impossible': return `There can be no such mission: ${sentence(state.reason || 'the viewer knows no such name')}`;
    }
    if (pulse?.missionMissing) return `There is no such mission now. The page waits for it.${stays}`;
    if (pulse && !pulse.storeAnswers) return `The map store does not answer${reason(pulse.storeError)}.${stays}`;
    if (this.trouble) return this.trouble;
    if (this.failed) return `Overlaps and paths of every frame are as they were: ${sentence(this.failed)}`;
    return missionTrouble(pulse?.mission);
  }
}

function reason(error: string): string {
  return error ? `: ${plainText(error).replace(/\.$/, '')}` : '';
}

function sentence(words: string): string {
  return `${words.charAt(0).toUpperCase()}${words.slice(1).replace(/\.$/, '')}.`;
}

function seconds(ms: number): string {
  return ms < 1000 ? 'half a second' : `${Math.round(ms / 1000)} s`;
}
