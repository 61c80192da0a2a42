import type { MissionPage } from './mission_page';
import { keyframeName, parseKeyframeName } from './model/ids';

/** Figures for tests in a browser, as `window.corbslam`; nothing of the page depends on them. */
export function installHook(page: MissionPage): void {
  const { live, stage, past, selection } = page;
  const watched: { atMs: number; drawCalls: number; drawnPoints: number; drawnKeyframes: number; scriptMs: number }[] = [];
  const hook = {
    get connected() { return live.isConnected; },
    get mission() { return page.mission; },
    get islands() { return page.model.islands().size; },
    get keyframes() { return page.model.keyframeCount; },
    get points() { return page.model.pointCount; },
    get robots() { return [...page.painter.robots]; },
    get overlaps() { return page.fetched.overlaps.length; },
    get revision() { return Number(live.model.revision); },
    get shownRevision() { return Number(page.model.revision); },
    get historyRevisions() { return past.history?.steps.length ?? 0; },
    get drawCalls() { return stage.figures.drawCalls; },
    get drawnPoints() { return stage.figures.drawnPoints; },
    get uploadBytes() { return stage.figures.uploadBytes; },
    get uploadedBytes() { return stage.uploadedBytes; },
    /** How the global layer is looked at: angles in degrees, distance in the map's unit. */
    get camera() {
      const { controls } = stage.globalPort;
      const degrees = (angle: number) => (angle * 180) / Math.PI;
      return { azimuth: degrees(controls.getAzimuthalAngle()), polar: degrees(controls.getPolarAngle()), distance: stage.globalPort.distance() };
    },
    get seenMs() { return page.seenMs; },
    /** Begins to keep the figures of frames; returns those since it was called before. */
    watchFrames() {
      page.onFrame = () => {
        const { drawCalls, drawnPoints, drawnKeyframes, scriptMs } = stage.figures;
        watched.push({ atMs: performance.now(), drawCalls, drawnPoints, drawnKeyframes, scriptMs });
      };
      return watched.splice(0);
    },
    get watchedFrames() { return watched.length; },
    /** Draws all of the map once more; done when it was handed over. */
    redraw() {
      stage.invalidate();
      return new Promise<void>((done) => { requestAnimationFrame(() => requestAnimationFrame(() => done())); });
    },
    get fps() { return stage.figures.fps; },
    get receivedBytes() { return live.stream.receivedBytes + page.rest.receivedBytes; },
    get moving() { return stage.map.isMoving; },
    figures() {
      const { drawCalls, drawnPoints } = stage.figures;
      const { keyframes, points, receivedBytes, uploadedBytes } = hook;
      return { keyframes, points, receivedBytes, uploadedBytes, drawCalls, drawnPoints };
    },
    keyframeNames(): string[] {
      return [...page.model.localMaps.values()].flatMap(({ id, keyframes }) =>
        [...keyframes.records.keys()].map((index) => keyframeName({ localMap: id, index })));
    },
    select(name: string): boolean {
      const id = parseKeyframeName(name);
      if (id) void selection.keyframe(id);
      return !!id;
    },
    selectOverlap(number: number): boolean {
      const overlap = page.fetched.overlaps.find((one) => Number(one.number) === number);
      if (overlap) selection.overlap(overlap);
      return !!overlap;
    },
  };
  Object.assign(window, { corbslam: hook });
}
