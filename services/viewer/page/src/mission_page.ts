import { Vector3 } from 'three';
import type { MissionEvent } from '@gen/corbslam/v1/events_pb';
import type { Overlap } from '@gen/corbslam/v1/overlap_pb';
import { Connection } from './connection';
import { Drifts } from './drifts';
import type { Rest } from './feed/rest';
import { Fetched } from './fetched';
import { TrueTrajectory } from './true_trajectory';
import { FrameLayout } from './frame_layout';
import { installHook } from './hook';
import { handleKey } from './keyboard';
import { KeptView } from './kept_view';
import { KeepInSight } from './keep_in_sight';
import { Live } from './live';
import { Measure } from './measure';
import { type KeyframeId, lastSegment, parseKeyframeName } from './model/ids';
import { driftText } from './model/drift';
import type { Landmark } from './model/sights';
import { RobotSeries } from './model/robot_series';
import { type Found, search } from './model/search';
import { mapText, timeOfDay } from './model/texts';
import { MapNames } from './model/map_names';
import type { IslandChange, MapModel } from './model/map_model';
import { DetailsPanel } from './panels/details';
import { FindBox } from './panels/find';
import { EventsPanel } from './panels/events';
import { helpDialog } from './panels/help';
import { Legend, isUntold } from './panels/legend';
import { NumbersPanel } from './panels/numbers';
import { OverlapsPanel, overlapsNote } from './panels/overlaps';
import { RobotPlots } from './panels/plots';
import { RobotsPanel } from './panels/robots';
import { ScaleBar } from './panels/scale_bar';
import { h, setText } from './panels/dom';
import { Toolbar } from './panels/toolbar';
import { Past } from './past';
import { RobotsNow } from './robots_now';
import { Painter } from './scene/painting';
import { Stage } from './scene/stage';
import { SceneLabels } from './scene_labels';
import { Selection } from './selection';
import { applyTheme, onSystemTheme } from './theme';
import { onGraphicsTrouble, requestTrouble } from './trouble';
import { type ViewState, keepInAddress } from './view_state';

const PANELS_EVERY_MS = 250;
const RECENT_NS = 5_000_000_000n;

/** The page of one mission: wires the feed, the picture and the panels together. */
export class MissionPage {
  readonly mission: string;
  readonly live: Live;
  readonly stage: Stage;
  readonly past: Past;
  readonly fetched: Fetched;
  private readonly truth: TrueTrajectory;
  readonly selection: Selection;
  readonly painter: Painter;
  private readonly layout: FrameLayout;
  private readonly toolbar: Toolbar;
  private readonly connection: Connection;
  private readonly robots: RobotsPanel;
  private readonly drifts: Drifts;
  private readonly numbers = new NumbersPanel();
  readonly names = new MapNames();
  private readonly events = new EventsPanel(this.names, (event) => this.past.goToEvent(event));
  private readonly series = new RobotSeries();
  private readonly plots = new RobotPlots();
  private readonly clock = h('span', { class: 'clock', title: 'The time by the viewer’s clock' });
  private readonly find: FindBox;
  private readonly measure: Measure;
  private readonly kept: KeptView;
  private readonly robotsNow: RobotsNow;
  private readonly legend = new Legend();
  private readonly overlapsPanel: OverlapsPanel;
  private readonly scale = new ScaleBar();
  private readonly labels: SceneLabels;
  private readonly help: HTMLDialogElement;
  private readonly changes: IslandChange[] = [];
  private readonly abort = new AbortController();
  private mapChanged = false;
  private wantsFit = true;
  private readonly inSight: KeepInSight;
  private panelsMs = 0;
  /** When the map was first seen, and when all of it, in milliseconds since the page was asked for. */
  readonly seenMs: { first?: number; whole?: number } = {};
  /** Told of each frame that was drawn. */
  onFrame: (() => void) | undefined;
  private isClosed = false;

  constructor(public state: ViewState, readonly rest: Rest, private readonly onRefused: (reason: string) => void) {
    this.mission = state.mission;
    this.painter = new Painter(applyTheme(state.theme));
    const change = (part: Partial<ViewState>) => this.change(part);
    this.toolbar = new Toolbar({
      change, fit: () => this.fit(), history: () => this.past.toggle(), help: () => this.toggleHelp(),
      measure: () => this.measure.toggle(),
    }, rest);
    this.help = helpDialog(rest);
    this.layout = new FrameLayout(this.mission, this.toolbar.root, rest.isServed);
    document.body.replaceChildren(this.layout.root, this.help);
    this.stage = new Stage(this.layout.canvas, this.layout.globalPort, this.layout.localPort);
    this.inSight = new KeepInSight(this.stage);
    this.robotsNow = new RobotsNow(this.stage.map, (robot) => this.fetched.lastLocalised(robot));
    this.labels = new SceneLabels(this.stage, this.painter, this.names, (robot) => this.robotsNow.of(robot));
    this.measure = new Measure(this.stage, () => this.toolbar.noteMeasure(this.measure.isOn));
    this.find = new FindBox((text) => this.search(text), (found) => this.goTo(found));
    this.fetched = new Fetched(rest, this.mission, this.stage, () => this.model, () => this.repaint(),
      (error) => this.onRequests(error));
    this.truth = new TrueTrajectory(rest, this.mission, this.stage, () => this.model, () => this.repaint());
    const details = new DetailsPanel(() => this.selection.clear());
    this.selection = new Selection(this, details, () => this.layout.showTab('details'));
    this.past = new Past(rest, this.mission, (changes) => this.onMap(changes), () => this.live.model.pointCount,
      (isPast) => this.connection.onPast(isPast), () => this.events.said);
    this.drifts = new Drifts(rest, this.mission, () => this.live.model, (error) => this.onRequests(error));
    this.robots = new RobotsPanel({
      toggle: (robot) => this.toggleRobot(robot), select: (robot) => change({ robot }),
      colour: (robot) => this.painter.legendColour(robot, this.state, this.model.islandsOf(robot)),
      drift: (robot) => (rest.isServed ? driftText(this.drifts.of(robot)) : ''),
      hasLocalised: (robot) => this.fetched.lastLocalised(robot) !== undefined,
    }, this.names);
    this.overlapsPanel = new OverlapsPanel((overlap) => this.selection.overlap(overlap));
    this.numbers.root.append(this.plots.root);
    this.layout.left.append(this.find.root, this.robots.root, this.numbers.root);
    this.layout.right.append(details.root, this.overlapsPanel.root, ...(rest.isServed ? [this.events.root] : []));
    this.layout.below.append(this.past.timeline.root, this.measure.root,
      h('div', { class: 'measures' }, this.scale.root, this.legend.root, this.clock));
    this.connection = new Connection(this.layout, !!rest.token, (reason) => this.onRefused(reason), () => ((this.live as Live | undefined)?.model.keyframeCount ?? 0) > 0);
    this.live = this.openLive();
    this.kept = new KeptView(this);
    this.listen();
    this.followLink(state);
    document.title = `${this.mission} · CORB-SLAM`;
    installHook(this);
    requestAnimationFrame(this.tick);
  }

  /** The map that is shown: the live one, or the past's. */
  get model(): MapModel {
    return this.past.model ?? this.live.model;
  }

  /** Shows what an address says. */
  followLink(state: ViewState): void {
    this.adopt(state);
    this.kept.want(state);
  }

  /** Looks from where a link says. */
  lookFrom(camera: number[]): void {
    this.wantsFit = false;
    this.inSight.hold();
    this.stage.globalPort.pose = camera;
    this.stage.invalidate(true);
  }

  /** Something else is looked at. */
  keepView(): void {
    this.kept.keep();
  }

  adopt(state: ViewState): void {
    this.state = state;
    this.painter.theme = applyTheme(state.theme);
    this.toolbar.update(state);
    this.layout.root.dataset.layer = state.layer;
    if (this.stage.globalPort.isTop !== state.top) {
      this.stage.globalPort.setTop(state.top);
      this.stage.localPort.setTop(state.top);
    }
    this.fetched.follow(state);
    this.truth.show(state.paths);
    this.repaint();
    this.panelsMs = 0;
  }

  change(part: Partial<ViewState>): void {
    const layerChanged = part.layer !== undefined && part.layer !== this.state.layer;
    const next = { ...this.state, ...part };
    if (next.follow && !next.robot) next.robot = this.painter.robots[0] ?? '';
    keepInAddress(next);
    this.adopt(next);
    if (layerChanged) setTimeout(() => this.inSight.fit(this.state), 50);
  }

  /** Who wants to see all does not follow one any more. */
  fit(): void {
    if (this.state.follow) this.change({ follow: false });
    this.kept.forgetCamera();
    this.inSight.fit(this.state);
  }

  overlapChosen(overlap: Overlap | undefined, keyframe: KeyframeId | undefined): void {
    this.stage.chosenOverlap = overlap;
    this.stage.chosenKeyframe = keyframe;
    this.sightsChosen([]);
    this.panelsMs = 0;
  }

  /** Highlights landmarks that the chosen keyframe sees. */
  sightsChosen(landmarks: readonly Landmark[]): void {
    this.stage.chosenLandmarks = landmarks;
    this.stage.invalidate();
  }

  close(): void {
    this.isClosed = true;
    this.live.stream.close();
    this.past.close();
    this.fetched.stop();
    this.truth.stop();
    this.drifts.stop();
    this.kept.stop();
    this.abort.abort();
    this.stage.dispose();
  }

  private openLive(): Live {
    return new Live(this.mission, this.rest, {
      onMap: (changes) => void (this.past.model === undefined && this.onMap(changes)),
      onPulse: (pulse) => {
        this.names.learn(pulse);
        this.connection.onPulse(pulse);
        this.series.note(pulse);
      },
      onEvent: (event) => this.onEvent(event),
      onConnection: (state) => this.connection.onState(state),
    });
  }

  private onMap(changes: IslandChange[]): void {
    if (this.past.model || this.state.at) this.keepView();
    this.changes.push(...changes);
    this.mapChanged = true;
  }

  private onEvent(event: MissionEvent): void {
    // By the viewer's clock: that of a person's computer may be wrong.
    const nowNs = this.live.pulse?.timeNs ?? BigInt(Date.now()) * 1_000_000n;
    this.events.add(event, nowNs - event.timeNs < RECENT_NS);
    if (event.event.case === 'agentLeft') this.robots.noteLeft(lastSegment(event.event.value.agent), event.timeNs);
    if (/^(overlap|islands|loop|global)/.test(event.event.case ?? '')) this.fetched.want();
  }

  private readonly tick = (): void => {
    if (this.isClosed) return;
    if (this.mapChanged) this.takeMap();
    const { state, stage } = this;
    if (state.follow) this.labels.follow(state.robot);
    if (stage.frame(state)) {
      this.labels.update(this.model, state);
      const port = state.layer === 'local' ? stage.localPort : stage.globalPort;
      this.scale.update(port.pixelsPerUnit(port.distance()));
      this.noteFrame();
    }
    if (performance.now() - this.panelsMs > PANELS_EVERY_MS) this.updatePanels();
    requestAnimationFrame(this.tick);
  };

  private noteFrame(): void {
    this.onFrame?.();
    const isWhole = this.live.hasPicture && !this.mapChanged;
    if (this.live.model.keyframeCount === 0 || this.seenMs.whole !== undefined) return;
    // A frame is on the screen once the next one is asked for.
    requestAnimationFrame((now) => {
      this.seenMs.first ??= now;
      if (isWhole) this.seenMs.whole ??= now;
    });
  }

  private takeMap(): void {
    this.mapChanged = false;
    this.inSight.onMap();
    if (this.changes.length > 0 || this.past.model) this.measure.forget();
    this.painter.addRobots(this.model.agents());
    this.painter.islands = [...this.model.localMaps.keys()];
    this.stage.pastRevision = this.past.model?.revision;
    this.stage.sync(this.model, this.changes.splice(0), !this.live.hasPicture || this.live.stream.isBehind);
    this.repaint();
    if (this.wantsFit && !this.kept.hasCamera && this.model.keyframeCount > 1) this.inSight.fit(this.state);
    if (this.live.hasPicture && this.model.keyframeCount > 1) this.wantsFit = false;
    this.fetched.onMap(this.model);
    this.truth.onMap(this.model);
  }

  private onRequests(error: unknown): void {
    const { refused, failed } = requestTrouble(error);
    if (refused) this.onRefused(refused);
    else this.connection.onRequests(failed);
  }

  private repaint(): void {
    this.stage.paint(this.state, this.painter);
  }

  private updatePanels(): void {
    this.panelsMs = performance.now();
    this.inSight.refit(this.state, this.past.model !== undefined);
    const { live, model, state } = this;
    const known = (live.pulse?.agents ?? []).map(({ name }) => lastSegment(name));
    this.painter.addRobots(known);
    const now = { isLive: this.connection.isLive, isPast: this.past.model !== undefined };
    if (this.robotsNow.take(now.isLive && !now.isPast ? live.pulse : undefined)) this.stage.invalidate();
    this.kept.show();
    this.plots.update(this.series, state.robot, this.painter.robots, (robot) => this.painter.robotColour(robot));
    setText(this.clock, live.pulse && now.isLive ? timeOfDay(live.pulse.timeNs) : '');
    if (this.robots.isShown && this.rest.isServed) this.drifts.want();
    this.robots.update(this.painter.robots, model, live.pulse, state, now);
    this.fetched.wantDriven(live.pulse);
    this.events.rename();
    this.legend.update(state, this.painter.theme, state.robot || (this.painter.robots[0] ?? ''), model, this.stage.heights);
    this.toolbar.noteObservations(!isUntold(model));
    this.selection.refresh();
    const receivedBytes = live.stream.receivedBytes + this.rest.receivedBytes;
    this.numbers.update(model, live.pulse, {
      ...now, receivedBytes, drawnPoints: this.stage.figures.drawnPoints, truth: this.truth.words(),
      ofNow: [...(state.frames ? ['Every frame'] : []), ...(state.layer === 'global' ? [] : ['Local layer'])],
    });
    this.layout.describe(`The map: ${mapText(model)}`);
    this.overlapsPanel.update(this.fetched.overlaps, state.refused, this.stage.chosenOverlap,
      (name) => this.names.keyframe(name), { note: overlapsNote(now.isPast, this.fetched.overlaps.length), version: this.names.version });
  }

  private search(text: string): Found[] {
    return search(text, { robots: this.painter.robots, model: this.model, names: this.names, overlaps: this.fetched.overlaps });
  }

  /** Chooses what was found, and moves the camera to it. */
  private goTo(found: Found): void {
    const at = this.placeOf(found);
    if (found.kind === 'robot') this.change({ robot: found.robot, hidden: new Set([...this.state.hidden].filter((one) => one !== found.robot)) });
    else if (found.kind === 'keyframe') void this.selection.keyframe(found.id);
    else if (found.kind === 'overlap') {
      const overlap = this.fetched.overlaps.find(({ number }) => number === found.number);
      if (overlap) this.selection.overlap(overlap);
    }
    if (!at) return;
    if (this.state.follow && found.kind !== 'robot') this.change({ follow: false });
    this.inSight.hold();
    this.stage.globalPort.approach(at);
    this.stage.invalidate(true);
  }

  private placeOf(found: Found): Vector3 | undefined {
    const { map } = this.stage;
    if (found.kind === 'robot') return this.labels.newest(found.robot);
    if (found.kind === 'keyframe') return map.world(found.id);
    if (found.kind === 'map') return map.bounds(({ id }) => id === found.localMap).getCenter(new Vector3());
    const overlap = this.fetched.overlaps.find(({ number }) => number === found.number);
    const query = overlap && parseKeyframeName(overlap.query);
    return query && map.world(query);
  }

  private toggleRobot(robot: string): void {
    const hidden = new Set(this.state.hidden);
    if (!hidden.delete(robot)) hidden.add(robot);
    this.change({ hidden });
  }

  private toggleHelp(): void {
    if (this.help.open) this.help.close();
    else this.help.showModal();
  }

  private escape(): void {
    if (this.measure.isOn) this.measure.toggle();
    else if (this.selection.isEmpty) this.past.live();
    else this.selection.clear();
  }

  private listen(): void {
    const { signal } = this.abort;
    onSystemTheme(() => this.adopt(this.state));
    addEventListener('keydown', (event) => this.onKey(event), { signal, capture: true });
    onGraphicsTrouble(this.layout.canvas, (trouble) => {
      this.connection.onTrouble(trouble);
      this.repaint();
    }, signal);
    let down = { x: 0, y: 0 };
    const port = this.layout.globalPort;
    port.addEventListener('pointerdown', ({ clientX: x, clientY: y }) => void (down = { x, y }));
    port.addEventListener('click', (event) => {
      if (Math.hypot(event.clientX - down.x, event.clientY - down.y) >= 5) return;
      const box = port.getBoundingClientRect();
      if (this.measure.isOn) this.measure.pick(event.clientX - box.left, event.clientY - box.top, this.state);
      else this.selection.pick(event);
    });
  }

  private onKey(event: KeyboardEvent): void {
    if (this.help.open && event.key !== '?') return;
    const handled = handleKey(event, this.state, {
      change: (part) => this.change(part), fit: () => this.fit(), help: () => this.toggleHelp(),
      play: () => this.past.play(), step: (by) => this.past.step(by),
      selectRobot: (number) => {
        const robot = this.painter.robots[number] ?? '';
        this.change({ robot: robot === this.state.robot ? '' : robot });
      },
      escape: () => this.escape(),
      measure: () => this.measure.toggle(), find: () => this.find.focus(),
    }, this.rest);
    if (!handled) return;
    event.preventDefault();
    event.stopPropagation();
  }
}
