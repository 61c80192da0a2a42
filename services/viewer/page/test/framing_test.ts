import assert from 'node:assert/strict';
import test from 'node:test';
import { Box3, PerspectiveCamera, Vector3 } from 'three';
import { distanceToSee } from '../src/scene/framing';

const WAYS = [new Vector3(0.35, 0.75, 0.9), new Vector3(0, 1, 1e-4), new Vector3(1, 0.01, 0), new Vector3(0, 1, 0)];
const BOXES = [new Box3(new Vector3(-50, -2, -80), new Vector3(10, 6, 30)), new Box3(new Vector3(3, 3, 3), new Vector3(4, 90, 5))];

test('all of a box is seen, and it is not farther than needed', () => {
  for (const box of BOXES) {
    for (const way of WAYS) {
      const away = way.clone().normalize();
      const camera = new PerspectiveCamera(45, 1.6, 0.01, 1e4);
      const up = Math.tan((22.5 * Math.PI) / 180);
      const middle = box.getCenter(new Vector3());
      camera.position.copy(middle).addScaledVector(away, distanceToSee(box, away, camera.up, 1.6 * up, up));
      camera.lookAt(middle);
      camera.updateMatrixWorld();
      const farthest = Math.max(...corners(box).flatMap((corner) => {
        const { x, y } = corner.project(camera);
        return [Math.abs(x), Math.abs(y)];
      }));
      assert.ok(Math.abs(farthest - 1) < 0.01, `the outermost corner is at ${farthest}, from ${away.toArray()}`);
    }
  }
});

test('a box without size needs no distance', () => {
  assert.equal(distanceToSee(new Box3(new Vector3(1, 1, 1), new Vector3(1, 1, 1)), new Vector3(0, 0, 1), new Vector3(0, 1, 0), 1, 1), 0);
});

function corners({ min, max }: Box3): Vector3[] {
  return Array.from({ length: 8 }, (_, i) => new Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z));
}
