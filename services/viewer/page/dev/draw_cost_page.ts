// Runs in a browser's page: the picture of a map without the page around it, drawn when dev/draw_cost.ts asks.
import { toBinary } from '@bufbuild/protobuf';
import { WatchMapResponseSchema } from '@gen/corbslam/v1/map_store_service_pb';
import { decodeMapChange } from '../src/feed/map_change';
import { MapModel } from '../src/model/map_model';
import { Painter } from '../src/scene/painting';
import { Stage } from '../src/scene/stage';
import { parseState } from '../src/view_state';
import { SimulatedMission } from './simulated_mission';

const [WIDTH, HEIGHT] = [480, 270];
const model = new MapModel();
const mission = new SimulatedMission('lab', 3, 5);
mission.begin(334);
for (const message of mission.picture()) model.apply([decodeMapChange(toBinary(WatchMapResponseSchema, message))]);

function place(name: 'canvas' | 'div'): HTMLElement {
  const element = document.createElement(name);
  element.style.cssText = `position: absolute; left: 0; top: 0; width: ${WIDTH}px; height: ${HEIGHT}px; visibility: hidden`;
  document.body.append(element);
  return element;
}

/** Makes a picture with or without antialiasing, and with so many pixels to a pixel of the page. */
function make(antialias: boolean, ratio: number): void {
  document.body.replaceChildren();
  const canvas = place('canvas') as HTMLCanvasElement;
  const real = canvas.getContext.bind(canvas) as (kind: string, wanted?: object) => WebGL2RenderingContext;
  // The first one to be asked for decides.
  canvas.getContext = ((kind: string, wanted?: object) =>
    real(kind, { ...wanted, antialias, failIfMajorPerformanceCaveat: false })) as typeof canvas.getContext;
  Object.defineProperty(window, 'devicePixelRatio', { value: ratio, configurable: true });
  const stage = new Stage(canvas, place('div'), document.createElement('div'));
  const painter = new Painter('dark');
  stage.sync(model, [], false);
  stage.paint(parseState('#mission=lab'), painter);
  stage.globalPort.fit(stage.map.extent(() => true, true));
  Object.assign(window, { draw: (shown: string) => draw(stage, painter, real('webgl2'), shown) });
}

/** Draws all of the map with some parts shown, and waits until it is drawn. */
function draw(stage: Stage, painter: Painter, gl: WebGL2RenderingContext, shown: string): void {
  const state = parseState(`#mission=lab&show=${shown}`);
  stage.paint(state, painter);
  stage.invalidate();
  (stage as unknown as { lastMotionMs: number }).lastMotionMs = -Infinity;
  if (!stage.frame(state)) throw new Error('nothing was drawn');
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
}

Object.assign(window, { make });
