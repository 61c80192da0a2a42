// Shaders, all GLSL ES 3.00. `place` is x, y, z and the order of arrival.
import { FEW_OBSERVATIONS, MANY_OBSERVATIONS } from '../model/palette';

const HEAD = `precision highp float;
uniform mat4 modelMatrix, modelViewMatrix, projectionMatrix;
uniform vec3 colour, rampLow, rampMiddle, rampHigh;
uniform vec2 heights;
uniform float ages;
uniform int ramp;
out vec3 shade;
vec3 onRamp(float t) {
  t = clamp(t, 0.0, 1.0);
  return t < 0.5 ? mix(rampLow, rampMiddle, 2.0 * t) : mix(rampMiddle, rampHigh, 2.0 * t - 1.0);
}
vec3 shadeOf(vec3 place, float age) {
  if (ramp == 1) return onRamp(((modelMatrix * vec4(place, 1.0)).y - heights.x) / (heights.y - heights.x));
  if (ramp == 2) return onRamp(age / ages);
  return colour;
}
`;

export const POINTS_VERTEX = `${HEAD}
layout(location = 0) in vec4 position;
layout(location = 1) in float observations;
uniform float sizePx, nearPx;
const float few = ${FEW_OBSERVATIONS.toFixed(1)}, many = ${MANY_OBSERVATIONS.toFixed(1)};
void main() {
  vec4 seen = modelViewMatrix * vec4(position.xyz, 1.0);
  gl_Position = projectionMatrix * seen;
  gl_PointSize = clamp(nearPx / max(-seen.z, 0.001), sizePx, 3.0 * sizePx);
  bool isCounted = ramp == 3 && observations > 0.5;
  shade = isCounted ? onRamp(log(observations / few) / log(many / few)) : shadeOf(position.xyz, position.w);
}`;

/** Five vertices of a frustum: the camera's centre and the picture's corners. */
export const KEYFRAMES_VERTEX = `${HEAD}
in vec4 place, turn;
uniform float size, smallest;
const vec3 CORNERS[5] = vec3[5](vec3(0.0), vec3(-0.6, -0.45, 0.7), vec3(0.6, -0.45, 0.7),
  vec3(0.6, 0.45, 0.7), vec3(-0.6, 0.45, 0.7));
void main() {
  vec3 position = CORNERS[gl_VertexID % 5];
  float depth = -(modelViewMatrix * vec4(place.xyz, 1.0)).z;
  vec3 corner = position * clamp(depth * smallest, size, 3.0 * size);
  vec3 turned = corner + 2.0 * cross(turn.xyz, cross(turn.xyz, corner) + turn.w * corner);
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(place.xyz + turned, 1.0));
  shade = shadeOf(place.xyz, place.w);
}`;

export const SHADE_FRAGMENT = `precision highp float;
uniform float opacity;
in vec3 shade;
out vec4 outColour;
void main() { outColour = vec4(shade, opacity); }`;

/** A line as a screen-wide quad; its ends are cut at the near plane first. */
export const LINE_VERTEX = `precision highp float;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform vec2 screen;
uniform float widthPx;
in vec3 start, end;
out vec2 along;
out float side;
const float NEAR = -0.01;
const vec2 CORNERS[4] = vec2[4](vec2(0.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(0.0, 1.0));
void main() {
  vec2 position = CORNERS[gl_VertexID % 4];
  vec3 a = (modelViewMatrix * vec4(start, 1.0)).xyz;
  vec3 b = (modelViewMatrix * vec4(end, 1.0)).xyz;
  if (a.z > NEAR && b.z > NEAR) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  if (a.z > NEAR) a = mix(b, a, (NEAR - b.z) / (a.z - b.z));
  if (b.z > NEAR) b = mix(a, b, (NEAR - a.z) / (b.z - a.z));
  vec4 clipA = projectionMatrix * vec4(a, 1.0);
  vec4 clipB = projectionMatrix * vec4(b, 1.0);
  vec2 way = (clipB.xy / clipB.w - clipA.xy / clipA.w) * screen * 0.5;
  float length2 = max(length(way), 1e-4);
  vec2 across = vec2(-way.y, way.x) / length2;
  vec4 clip = position.x < 0.5 ? clipA : clipB;
  clip.xy += across * position.y * widthPx / screen * clip.w;
  gl_Position = clip;
  along = vec2(position.x * length2 * clip.w, clip.w);
  side = position.y;
}`;

export const LINE_FRAGMENT = `precision highp float;
uniform vec3 colour;
uniform float opacity, dashPx;
in vec2 along;
in float side;
out vec4 outColour;
void main() {
  if (dashPx > 0.0 && mod(along.x / along.y, 2.0 * dashPx) > dashPx) discard;
  outColour = vec4(colour, opacity);
}`;

export const SIGHTS_VERTEX = `precision highp float;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform float markPx;
in vec3 position;
void main() {
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(position, 1.0));
  gl_PointSize = markPx;
}`;

/** A disc with a rim, so that it stands out from points of any colour. */
export const SIGHTS_FRAGMENT = `precision highp float;
uniform vec3 colour, rim;
out vec4 outColour;
void main() {
  float away = 2.0 * length(gl_PointCoord - 0.5);
  if (away > 1.0) discard;
  outColour = vec4(away > 0.7 ? rim : colour, 1.0);
}`;
