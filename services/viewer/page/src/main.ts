import { RecordedRest, parseRecording } from './feed/recording';
import { Rest, RestError } from './feed/rest';
import { StartScreen } from './panels/start';
import { MissionPage } from './mission_page';
import { plainText } from './model/plain_text';
import { keepToken, takeToken } from './token';
import { parseState } from './view_state';
import { applyTheme } from './theme';

const LOOK_AGAIN_MS = 3000;
const recording = parseRecording(document.getElementById('recording')?.textContent);
const rest = recording ? new RecordedRest(recording) : new Rest(takeToken());
const start = new StartScreen(openMission, (token) => {
  keepToken(token);
  rest.token = token || undefined;
  void route();
}, rest.isServed);
let page: MissionPage | undefined;
let timer: ReturnType<typeof setTimeout> | undefined;

function openMission(mission: string): void {
  location.hash = new URLSearchParams({ mission }).toString();
}

/** Shows what the address says: a mission, or the list of them. */
async function route(): Promise<void> {
  clearTimeout(timer);
  rest.token = takeToken();
  const address = parseState(location.hash);
  const state = recording ? { ...address, mission: recording.mission } : address;
  if (page && page.mission === state.mission) return page.followLink(state);
  page?.close();
  page = undefined;
  applyTheme(state.theme);
  if (!state.mission) return showMissions();
  try {
    page = new MissionPage(state, rest, (reason) => leave(() => start.askToken(reason)));
  } catch (error) {
    leave(() => start.cannotDraw(error instanceof Error ? error.message : String(error)));
  }
}

/** From a mission to the start screen. */
function leave(show: () => void): void {
  page?.close();
  page = undefined;
  document.body.replaceChildren(start.root);
  show();
}

async function showMissions(): Promise<void> {
  document.title = 'CORB-SLAM map viewer';
  if (!start.root.isConnected) document.body.replaceChildren(start.root);
  try {
    start.missions(await rest.missions());
  } catch (error) {
    if (error instanceof RestError && error.status === 401) return start.askToken(plainText(error.message));
    start.fail(plainText(error instanceof Error ? error.message : String(error)));
  }
  timer = setTimeout(() => void (page === undefined && showMissions()), LOOK_AGAIN_MS);
}

addEventListener('hashchange', () => void route());
void route();
