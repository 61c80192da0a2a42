// What corbslam_link.mjs does without a server: node --test.
import assert from "node:assert/strict";
import { test } from "node:test";
import grpc from "@grpc/grpc-js";
import { compose, follow, globalFromCamera, loadServices, makeCredentials, rotate } from "./corbslam_link.mjs";

const half = Math.SQRT1_2;
// A quarter turn about z: x becomes y.
const quarter = { rotation_wxyz: [half, 0, 0, half], translation: [1, 2, 3], scale: 2 };
const near = (a, b) => a.forEach((x, i) => assert.ok(Math.abs(x - b[i]) < 1e-12, `${a} is not ${b}`));

test("points are turned", () => near(rotate(quarter.rotation_wxyz, [1, 0, 5]), [0, 1, 5]));

test("a product does the right one first", () => {
  const tilted = { rotation_wxyz: [half, half, 0, 0], translation: [0, 0, 7], scale: 3 };
  const apply = (t, x) => rotate(t.rotation_wxyz, x).map((a, i) => t.scale * a + t.translation[i]);
  near(apply(compose(quarter, tilted), [1, 2, 3]), apply(quarter, apply(tilted, [1, 2, 3])));
});

test("a camera is where both of its poses say", () => {
  const local_from_camera = { rotation_wxyz: [1, 0, 0, 0], translation: [1, 0, 0] };
  assert.equal(globalFromCamera({ local_from_camera, global_from_local: null }), null);
  near(globalFromCamera({ local_from_camera, global_from_local: quarter }).translation, [1, 4, 3]);
});

test("what would be dropped is refused", () => {
  assert.throws(() => makeCredentials({ token: "t" }), /without --ca/);
  assert.throws(() => makeCredentials({ ca: "ca", cert: "c" }), /needs its key/);
  assert.throws(() => makeCredentials({ ca: "nowhere.pem" }), /nowhere.pem can't be read/);
  assert.throws(() => loadServices("/nowhere"), /--proto/);
});

test("a stream goes on where it broke, and other errors are thrown", async () => {
  const asked = [];
  let cancelled = 0;
  const call = (request) => {
    asked.push(request.from_version);
    const messages = (async function* () {
      yield { version: asked.length };
      if (asked.length === 1) throw Object.assign(new Error("away"), { code: grpc.status.UNAVAILABLE });
      if (asked.length === 2) throw Object.assign(new Error("no"), { code: grpc.status.PERMISSION_DENIED });
    })();
    return Object.assign(messages, { cancel: () => ++cancelled });
  };
  const told = [];
  await assert.rejects(async () => {
    for await (const message of follow(call, { from_version: 0 }, (request, m) => { request.from_version = m.version; })) {
      told.push(message.version);
    }
  }, /no/);
  assert.deepEqual([asked, told, cancelled], [[0, 1], [1, 2], 2]);
});
