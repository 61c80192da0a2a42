
"use strict";
// Vectors are arrays of three, matrices of sixteen numbers, column by column, as WebGL takes them.
const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

function multiply(a, b) {
  const c = new Array(16).fill(0);
  for (let column = 0; column < 4; ++column) {
    for (let row = 0; row < 4; ++row) {
      for (let k = 0; k < 4; ++k) c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
    }
  }
  return c;
}

function perspective(tanHalfHeight, aspect, near, far) {
  const f = 1 / tanHalfHeight;
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1,
          0, 0, 2 * far * near / (near - far), 0];
}

// The point of q * x * q', of a quaternion [w, x, y, z].
function rotate(q, x) {
  const u = [q[1], q[2], q[3]];
  const t = scale(cross(u, x), 2);
  return add(add(x, scale(t, q[0])), cross(u, t));
}

// Looks at a target from a distance, turned by yaw around the upward axis and by pitch above the ground.
class Camera {
  constructor(centre, radius) {
    this.home = { target: centre, distance: radius * 2.2, yaw: -0.35, pitch: 0.75 };
    this.radius = radius;
    this.reset();
  }
  reset() { Object.assign(this, this.home, { target: this.home.target.slice() }); }
  top() { this.yaw = 0; this.pitch = Math.PI / 2; }
  turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, this.pitch + pitch));
  }
  nearer(factor) {
    this.distance = Math.min(20 * this.radius, Math.max(0.01 * this.radius, this.distance / factor));
  }
  axes() {
    const cy = Math.cos(this.yaw), sy = Math.sin(this.yaw);
    const cp = Math.cos(this.pitch), sp = Math.sin(this.pitch);
    const right = [cy, sy, 0];
    const back = [sy * cp, -cy * cp, sp];
    return { right, back, up: cross(back, right) };
  }
  // Moves along the picture by shares of its height.
  pan(x, y) {
    const { right, up } = this.axes();
    const size = 2 * Camera.tanHalfHeight * this.distance;
    this.target = add(this.target, add(scale(right, -x * size), scale(up, y * size)));
  }
  matrix(aspect) {
    const { right, up, back } = this.axes();
    const eye = add(this.target, scale(back, this.distance));
    const view = [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
                  -dot(right, eye), -dot(up, eye), -dot(back, eye), 1];
    const near = Math.max(this.distance * 0.01, this.radius * 1e-3);
    // Where the picture is higher than wide, its width is what has to hold the map.
    const tanHalfHeight = Camera.tanHalfHeight / Math.min(1, aspect);
    return multiply(perspective(tanHalfHeight, aspect, near, this.distance + 20 * this.radius), view);
  }
}
Camera.tanHalfHeight = Math.tan(Math.PI / 8);
