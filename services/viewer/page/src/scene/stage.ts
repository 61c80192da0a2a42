import { Color, Scene, Sphere, Vector2, Vector3, WebGLRenderer } from 'three';
import type { Overlap } from '@gen/corbslam/v1/overlap_pb';
import type { KeyframeId } from '../model/ids';
import type { IslandChange, MapModel } from '../model/map_model';
import { type SceneColours, sceneColours } from '../model/palette';
import type { Landmark } from '../model/sights';
import { isAccepted } from '../model/texts';
import type { ViewState } from '../view_state';
import { contextOf } from './context';
import { Detail, type Share } from './detail';
import { Grid } from './grid';
import { LocalLayer } from './local_layer';
import { MapView } from './map_view';
import { Marker } from './marker';
import { SharedUniforms } from './materials';
import { MeasureView } from './measure_view';
import { OverlapsView } from './overlaps_view';
import { type Painter, paintMap } from './painting';
import { RunsView } from './runs_view';
import { SightsView } from './sights_view';
import { TruthView } from './truth_view';
import { Viewport } from './viewport';

const STILL_AFTER_MS = 200;
/** A complete frame that takes longer waits for a rest of some such frames. */
const SLOW_COMPLETE_MS = 120;
const RESTS = 4;
const SMALLEST_FRUSTUM_PX = 7;

/** Figures of the last frame. */
export interface FrameFigures {
  drawCalls: number;
  drawnPoints: number;
  drawnKeyframes: number;
  uploadBytes: number;
  fps: number;
  /** What the page's own script took for it; drawing goes on elsewhere. */
  scriptMs: number;
}

/** Draws the layers into their viewports, when something changed. */
export class Stage {
  readonly uniforms = new SharedUniforms();
  readonly map = new MapView(this.uniforms);
  readonly local = new LocalLayer(this.uniforms);
  readonly truth = new TruthView(this.map.root, this.uniforms);
  readonly runs = new RunsView(this.map.root, this.uniforms);
  readonly overlapsView: OverlapsView;
  readonly sights: SightsView;
  readonly measureView: MeasureView;
  readonly globalPort: Viewport;
  readonly localPort: Viewport;
  readonly figures: FrameFigures = { drawCalls: 0, drawnPoints: 0, drawnKeyframes: 0, uploadBytes: 0, fps: 0, scriptMs: 0 };
  /** Bytes for the GPU so far. */
  uploadedBytes = 0;
  overlaps: Overlap[] = [];
  /** Set while the past is shown: overlaps that were taken in later are left out. */
  pastRevision: bigint | undefined;
  chosenOverlap: Overlap | undefined;
  chosenKeyframe: KeyframeId | undefined;
  /** What the chosen keyframe sees. */
  chosenLandmarks: readonly Landmark[] = [];
  private readonly renderer: WebGLRenderer;
  private readonly globalScene = new Scene();
  private readonly localScene = new Scene();
  private readonly grid = new Grid();
  private readonly localGrid = new Grid();
  private readonly marker = new Marker();
  private readonly detail = new Detail();
  /** Of what the overlaps were drawn last. */
  private shownOverlaps: unknown[] = [];
  /** The least size of a point on the screen. */
  private pointPx = 1.5;
  private points = 0;
  private keyframes = 0;
  private wanted = true;
  private isComplete = false;
  /** What the last complete frame took, up to the next one's begin. */
  private completeMs = 0;
  /** What the tick before this one drew. */
  private drew: 'nothing' | 'part' | 'all' = 'nothing';
  private lastMotionMs = 0;
  private lastFrameMs = 0;

  constructor(readonly canvas: HTMLCanvasElement, globalElement: HTMLElement, localElement: HTMLElement) {
    this.renderer = new WebGLRenderer({ canvas, context: contextOf(canvas) });
    this.renderer.autoClear = false;
    this.renderer.info.autoReset = false;
    const moved = () => this.invalidate(true);
    this.globalPort = new Viewport(globalElement, moved);
    this.localPort = new Viewport(localElement, moved);
    this.overlapsView = new OverlapsView(this.globalScene, this.uniforms);
    this.measureView = new MeasureView(this.globalScene, this.uniforms);
    this.sights = new SightsView(this.globalScene, this.uniforms);
    this.globalScene.add(this.map.root, this.grid.object, this.marker.object);
    this.localScene.add(this.local.root, this.localGrid.object);
    new ResizeObserver(() => this.invalidate()).observe(canvas);
  }

  /** Of the ramp of heights: its ends, in the map's unit above the first camera. */
  get heights(): [number, number] {
    const { x, y } = this.uniforms.heights.value;
    return [x, y];
  }

  /** Has the picture drawn anew; `isMotion`: in a hurry, because more follows. */
  invalidate(isMotion = false): void {
    this.wanted = true;
    if (isMotion) this.lastMotionMs = performance.now();
  }

  /** Follows the model; `isHurried`: more is about to come, so that not every point is worth its time. */
  sync(model: MapModel, changes: IslandChange[], isHurried: boolean): void {
    this.points = model.pointCount;
    this.keyframes = model.keyframeCount;
    this.figures.uploadBytes = this.map.sync(model, changes, performance.now());
    this.uploadedBytes += this.figures.uploadBytes;
    this.grid.cover(this.map.bounds(() => true));
    this.truth.place(this.map.plots.get(model.globalIsland ?? ''));
    this.runs.place(this.map);
    this.invalidate(isHurried || this.completeMs > SLOW_COMPLETE_MS);
  }

  updateLocal(...args: Parameters<LocalLayer['update']>): void {
    this.local.update(...args);
    this.localGrid.cover(this.local.bounds());
    this.invalidate();
  }

  paint(state: ViewState, painter: Painter): void {
    const colours: SceneColours = sceneColours(painter.theme);
    this.renderer.setClearColor(new Color(colours.background));
    this.grid.paint(colours.grid);
    this.localGrid.paint(colours.grid);
    this.overlapsView.paint(colours);
    this.marker.paint(colours.selected);
    this.sights.paint(colours);
    this.measureView.paint(colours);
    this.pointPx = state.size;
    this.truth.paint(colours.truth, state.paths);
    this.runs.paint((agent) => painter.markColour(agent, state), (agent) => state.paths && !state.hidden.has(agent));
    paintMap(this.map, this.uniforms, state, painter, colours);
    this.local.paint((agent) => painter.robotColour(agent), (agent) => !state.hidden.has(agent));
    this.invalidate();
  }

  /** Draws a frame if one is needed. Returns whether it did. */
  frame(state: ViewState): boolean {
    const now = performance.now();
    const moves = this.map.advance(now);
    if (moves) this.invalidate(true);
    this.noteTime(now);
    const isMotion = now - this.lastMotionMs < Math.max(STILL_AFTER_MS, Math.min(RESTS * this.completeMs, 5000));
    if (!this.wanted && this.isComplete) return false;
    if (!this.wanted && isMotion) return false;
    this.wanted = false;
    this.isComplete = !isMotion;
    this.drew = isMotion ? 'part' : 'all';
    this.updateOverlaps(state);
    this.render(this.detail.share(isMotion, this.points, this.keyframes));
    this.figures.scriptMs = performance.now() - now;
    this.measure(now);
    return true;
  }

  /** A frame took as long as the browser did to ask for the next one: drawing goes on after the script. */
  private noteTime(now: number): void {
    const ms = now - this.lastFrameMs;
    if (this.drew === 'all') this.completeMs = ms;
    if (this.drew === 'part') this.detail.took(ms);
    this.drew = 'nothing';
  }

  dispose(): void {
    this.globalPort.controls.dispose();
    this.localPort.controls.dispose();
    this.renderer.dispose();
  }

  /** Turning moves no overlap: thousands of names are not read again for each frame of it. */
  private updateOverlaps({ overlaps, refused }: ViewState): void {
    const size = Math.max(12 / this.globalPort.pixelsPerUnit(this.globalPort.distance()), 1e-3);
    this.marker.update(this.map, this.chosenKeyframe, size);
    this.sights.update(this.map, this.chosenKeyframe, this.chosenLandmarks);
    const past = this.pastRevision;
    const inputs = [this.overlaps, this.map.version, past, overlaps, refused, this.chosenOverlap];
    if (inputs.every((input, i) => input === this.shownOverlaps[i])) return;
    this.shownOverlaps = inputs;
    const known = past === undefined ? this.overlaps
      : this.overlaps.filter(({ revision }) => revision > 0n && revision <= past);
    const shown = known.filter((overlap) => (isAccepted(overlap) ? overlaps : refused));
    this.overlapsView.update(shown, this.map, this.chosenOverlap);
  }

  private render(share: Share): void {
    this.resize(share.pixels);
    this.renderer.info.reset();
    this.renderer.setScissorTest(false);
    this.renderer.clear();
    if (this.globalPort.resize()) {
      this.setDetail(share);
      this.draw(this.globalPort, this.globalScene);
    }
    if (this.localPort.resize()) this.draw(this.localPort, this.localScene);
    this.figures.drawCalls = this.renderer.info.render.calls;
  }

  /** Sets the canvas's size, where it is another one: setting it makes the browser empty the canvas. */
  private resize(pixels: number): void {
    const { clientWidth, clientHeight } = this.canvas;
    const ratio = pixels * Math.min(devicePixelRatio, 2);
    const size = this.renderer.getSize(new Vector2());
    if (ratio !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(ratio);
    if (size.x !== clientWidth || size.y !== clientHeight) this.renderer.setSize(clientWidth, clientHeight, false);
  }

  private draw(port: Viewport, scene: Scene): void {
    const [all, own] = [this.canvas.getBoundingClientRect(), port.element.getBoundingClientRect()];
    const bottom = all.bottom - own.bottom;
    this.renderer.setViewport(own.left - all.left, bottom, own.width, own.height);
    this.renderer.setScissor(own.left - all.left, bottom, own.width, own.height);
    this.renderer.setScissorTest(true);
    this.uniforms.screen.value.set(own.width, own.height);
    this.renderer.render(scene, port.camera);
  }

  private setDetail(share: Share): void {
    const port = this.globalPort;
    const ratio = this.renderer.getPixelRatio();
    this.uniforms.sizePx.value = this.pointPx * ratio;
    this.uniforms.markPx.value = 8 * ratio;
    this.uniforms.nearPx.value = port.pixelsPerUnit(1) * 0.04 * ratio;
    this.uniforms.smallest.value = SMALLEST_FRUSTUM_PX / port.pixelsPerUnit(1);
    this.map.root.updateMatrixWorld();
    const at = new Vector3();
    let [points, keyframes] = [0, 0];
    for (const view of this.map.views.values()) {
      if (!view.group.visible) continue;
      const perUnit = ({ center, radius }: Sphere) => {
        const away = at.copy(center).applyMatrix4(view.group.matrixWorld).distanceTo(port.camera.position) - radius;
        return away <= 0 ? Infinity : port.pixelsPerUnit(away) * ratio;
      };
      for (const block of view.blocks) points += block.setDetail(share.points, perUnit);
      keyframes += view.keyframes.setDetail(share.keyframes, perUnit);
      this.uploadedBytes += view.keyframes.path.setDetail(share.keyframes < 1, perUnit);
    }
    this.figures.drawnPoints = points;
    this.figures.drawnKeyframes = keyframes;
  }

  private measure(now: number): void {
    const ms = now - this.lastFrameMs;
    this.lastFrameMs = now;
    if (ms > 0 && ms < 3000) this.figures.fps = 0.9 * this.figures.fps + 100 / ms;
  }
}
