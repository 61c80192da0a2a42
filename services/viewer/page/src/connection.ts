import type { MissionPulse } from '@gen/corbslam/v1/viewer_pb';
import type { StreamState } from './feed/stream';
import type { FrameLayout } from './frame_layout';

const REFUSALS = { token: 'The token was refused.', mission: 'This token does not open this mission.' };
const ASKS_FOR_TOKEN = 'This viewer shows missions to those who have a token for them.';

/** Says how the connections stand: this page's to the viewer, and the viewer's to the store. */
export class Connection {
  private state: StreamState = { name: 'connecting' };
  private pulse: MissionPulse | undefined;
  private wasOpen = false;

  constructor(
    private readonly layout: FrameLayout,
    private readonly hadToken: boolean,
    private readonly onRefused: (reason: string) => void,
  ) {}

  onState(state: StreamState): void {
    if (state.name === 'refused') return this.onRefused(this.hadToken ? REFUSALS[state.why] : ASKS_FOR_TOKEN);
    this.state = state;
    this.wasOpen ||= state.name === 'open';
    this.show();
  }

  onPulse(pulse: MissionPulse): void {
    this.pulse = pulse;
    this.show();
  }

  private show(): void {
    const isLive = this.state.name === 'open' && this.pulse?.storeAnswers !== false;
    this.layout.connection.className = `chip ${isLive ? 'online' : 'offline'}`;
    this.layout.connection.textContent = isLive ? 'live' : 'not live';
    this.layout.showBanner(this.words());
  }

  private words(): string {
    const { state, pulse } = this;
    const stays = this.wasOpen ? ' The picture is as it was.' : '';
    if (state.name === 'away') return `The viewer is away; it is asked again in ${seconds(state.retryMs)}.${stays}`;
    if (state.name === 'connecting' && this.wasOpen) return `Connecting again …${stays}`;
    if (state.name === 'missing') return 'There is no such mission yet. The page waits for it.';
    if (pulse && !pulse.storeAnswers) return `The map store does not answer${reason(pulse.storeError)}.${stays}`;
    return '';
  }
}

function reason(error: string): string {
  return error ? `: ${error.replace(/\.$/, '')}` : '';
}

function seconds(ms: number): string {
  return ms < 1000 ? 'half a second' : `${Math.round(ms / 1000)} s`;
}
