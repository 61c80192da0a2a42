
// What is drawn: buffers of points and lines, each with the CSS variable of its colour.
function decode(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new DataView(bytes.buffer);
}

function floats(text) {
  const view = decode(text);
  const values = new Float32Array(view.byteLength / 4);
  for (let i = 0; i < values.length; ++i) values[i] = view.getFloat32(4 * i, true);
  return values;
}

function readPoints(points) {
  const view = decode(points.data);
  const values = new Float32Array(view.byteLength / 2);
  for (let i = 0; i < values.length; ++i) {
    values[i] = points.low[i % 3] + points.step[i % 3] * view.getUint16(2 * i, true);
  }
  return values;
}

// Frames of lines that open to where the cameras look; each keyframe is a centre and a quaternion.
function frusta(text, size) {
  const poses = floats(text);
  const lines = [];
  const corners = [[-1, -0.75, 1.2], [1, -0.75, 1.2], [1, 0.75, 1.2], [-1, 0.75, 1.2]];
  for (let i = 0; i + 6 < poses.length; i += 7) {
    const centre = [poses[i], poses[i + 1], poses[i + 2]];
    const q = [poses[i + 3], poses[i + 4], poses[i + 5], poses[i + 6]];
    const ends = corners.map((corner) => add(centre, rotate(q, scale(corner, size))));
    ends.forEach((end, k) => lines.push(...centre, ...end, ...end, ...ends[(k + 1) % 4]));
  }
  return new Float32Array(lines);
}

// A path as single strokes; with `dash`, every second stretch of that length is left out. A path
// has gaps where numbers are none.
function strokes(path, dash) {
  const lines = [];
  let travelled = 0;
  for (let i = 3; i < path.length; i += 3) {
    const a = path.subarray(i - 3, i), b = path.subarray(i, i + 3);
    const length = Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    if (!Number.isFinite(length)) continue;
    if (!dash) { lines.push(...a, ...b); continue; }
    for (let at = 0; at < length;) {
      const rest = dash - travelled % dash;
      const to = Math.min(length, at + Math.max(rest, dash * 1e-3));
      if (Math.floor(travelled / dash) % 2 === 0) {
        for (const s of [at / length, to / length]) for (let k = 0; k < 3; ++k) lines.push(a[k] + s * (b[k] - a[k]));
      }
      travelled += to - at;
      at = to;
    }
  }
  return new Float32Array(lines);
}

function readScene(data) {
  const size = data.radius / 70;
  const layers = [{ kind: "points", paint: "ink", mode: "points", values: readPoints(data.points) }];
  for (const robot of data.robots) {
    layers.push({ kind: "paths", paint: robot.paint, mode: "lines", values: strokes(floats(robot.path), 0) });
    layers.push({ kind: "keyframes", paint: robot.paint, mode: "lines", values: frusta(robot.keyframes, size) });
  }
  for (const path of data.truth) {
    layers.push({ kind: "truth", paint: "truth", mode: "lines", values: strokes(floats(path), data.radius / 60) });
  }
  return layers;
}

const vertexCode = `attribute vec3 position; uniform mat4 matrix; uniform float size;
void main() { gl_Position = matrix * vec4(position, 1.0); gl_PointSize = size; }`;
const fragmentCode = `precision mediump float; uniform vec4 colour; void main() { gl_FragColor = colour; }`;

class Painter {
  constructor(gl, layers) {
    this.gl = gl;
    this.program = gl.createProgram();
    for (const [kind, code] of [[gl.VERTEX_SHADER, vertexCode], [gl.FRAGMENT_SHADER, fragmentCode]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, code);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
    }
    gl.bindAttribLocation(this.program, 0, "position");
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) throw new Error("WebGL refuses the program");
    gl.useProgram(this.program);
    gl.enableVertexAttribArray(0);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    this.layers = layers.map((layer) => ({ ...layer, buffer: this.upload(layer.values), count: layer.values.length / 3 }));
  }
  upload(values) {
    const buffer = this.gl.createBuffer();
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, buffer);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, values, this.gl.STATIC_DRAW);
    return buffer;
  }
  draw(matrix, colourOf, isShown, pointSize) {
    const gl = this.gl;
    const at = (name) => gl.getUniformLocation(this.program, name);
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clearColor(...colourOf("paper"), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(at("matrix"), false, matrix);
    gl.uniform1f(at("size"), pointSize);
    for (const layer of this.layers) {
      if (!isShown(layer.kind) || layer.count === 0) continue;
      gl.uniform4f(at("colour"), ...colourOf(layer.paint), layer.kind === "points" ? 0.55 : 1);
      gl.bindBuffer(gl.ARRAY_BUFFER, layer.buffer);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
      gl.drawArrays(layer.mode === "points" ? gl.POINTS : gl.LINES, 0, layer.count);
    }
  }
}
