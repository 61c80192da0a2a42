import { Color, GLSL3, RawShaderMaterial, Vector2 } from 'three';
import { KEYFRAMES_VERTEX, LINE_FRAGMENT, LINE_VERTEX, POINTS_VERTEX, SHADE_FRAGMENT, SIGHTS_FRAGMENT, SIGHTS_VERTEX } from './glsl';

/** Values that all materials of a scene share by reference. */
export class SharedUniforms {
  readonly rampLow = { value: new Color() };
  readonly rampMiddle = { value: new Color() };
  readonly rampHigh = { value: new Color() };
  readonly heights = { value: new Vector2(0, 1) };
  readonly pointAges = { value: 1 };
  readonly keyframeAges = { value: 1 };
  readonly ramp = { value: 0 };
  readonly sizePx = { value: 1.5 };
  readonly nearPx = { value: 20 };
  /** Of a point that stands out. */
  readonly markPx = { value: 8 };
  /** Frusta do not look smaller than this, in units at distance 1, up to three times their size. */
  readonly smallest = { value: 0.01 };
  readonly screen = { value: new Vector2(1, 1) };

  private common(ages: { value: number }) {
    const { rampLow, rampMiddle, rampHigh, heights, ramp } = this;
    return { colour: { value: new Color() }, opacity: { value: 1 }, rampLow, rampMiddle, rampHigh, heights, ramp, ages };
  }

  points(): RawShaderMaterial {
    return shader(POINTS_VERTEX, SHADE_FRAGMENT, {
      ...this.common(this.pointAges), sizePx: this.sizePx, nearPx: this.nearPx,
    });
  }

  /** Points that stand out, over everything. */
  sights(): RawShaderMaterial {
    const { markPx } = this;
    const material = shader(SIGHTS_VERTEX, SIGHTS_FRAGMENT, { colour: { value: new Color() }, rim: { value: new Color() }, markPx });
    material.depthTest = false;
    material.depthWrite = false;
    material.transparent = true;
    return material;
  }

  keyframes(): RawShaderMaterial {
    return shader(KEYFRAMES_VERTEX, SHADE_FRAGMENT, {
      ...this.common(this.keyframeAges), size: { value: 1 }, smallest: this.smallest,
    });
  }

  lines(): RawShaderMaterial {
    const material = shader(LINE_VERTEX, LINE_FRAGMENT, {
      colour: { value: new Color() }, opacity: { value: 1 }, widthPx: { value: 2 }, dashPx: { value: 0 },
      screen: this.screen,
    });
    material.transparent = true;
    material.depthWrite = false;
    return material;
  }
}

/** Colours go to the screen as they are written: no tone mapping, no colour space. */
export function setColour(material: RawShaderMaterial, colour: string): void {
  plainColour(material.uniforms.colour.value as Color, colour);
}

export function plainColour(target: Color, colour: string): void {
  const n = Number.parseInt(colour.slice(1), 16);
  target.r = (n >> 16) / 255;
  target.g = ((n >> 8) & 255) / 255;
  target.b = (n & 255) / 255;
}

function shader(vertexShader: string, fragmentShader: string, uniforms: RawShaderMaterial['uniforms']): RawShaderMaterial {
  return new RawShaderMaterial({ glslVersion: GLSL3, vertexShader, fragmentShader, uniforms });
}
