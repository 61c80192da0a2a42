#!/usr/bin/env python3
"""What corbslam_link.py does without a server. The generated code lies beside it (docs/clients.md)."""
import math
import tempfile
import unittest

import grpc

import corbslam_link as link
from corbslam.v1 import agent_service_pb2 as agent, map_store_service_pb2 as store

HALF = math.sqrt(0.5)
# A quarter turn about z: x becomes y.
QUARTER = (HALF, 0.0, 0.0, HALF)


class Broken(grpc.RpcError):
    def __init__(self, code):
        super().__init__()
        self.code = lambda: code


class TransformTest(unittest.TestCase):
    def assert_near(self, a, b):
        for x, y in zip(a, b, strict=True):
            self.assertAlmostEqual(x, y, places=12)

    def test_points_are_scaled_turned_and_moved(self):
        self.assert_near(link.Transform(QUARTER, (1, 2, 3), 2.0)((1, 0, 5)), (1, 4, 13))

    def test_a_product_does_the_right_one_first(self):
        a, b = link.Transform(QUARTER, (1, 2, 3), 2.0), link.Transform((HALF, HALF, 0.0, 0.0), (0, 0, 7), 3.0)
        self.assert_near((a @ b)((1, 2, 3)), a(b((1, 2, 3))))

    def test_an_inverse_takes_back(self):
        a = link.Transform(QUARTER, (1, 2, 3), 2.0)
        self.assert_near(a.inverse()(a((4, 5, 6))), (4, 5, 6))

    def test_a_camera_is_where_both_of_its_poses_say(self):
        pose = agent.WatchPoseResponse()
        self.assertIsNone(link.global_from_camera(pose))
        pose.local_from_camera.rotation_wxyz.extend((1, 0, 0, 0))
        pose.local_from_camera.translation.extend((1, 0, 0))
        self.assertIsNone(link.global_from_camera(pose))
        pose.global_from_local.rotation_wxyz.extend(QUARTER)
        pose.global_from_local.translation.extend((10, 0, 0))
        self.assert_near(link.global_from_camera(pose).translation, (10, 1, 0))


class FollowTest(unittest.TestCase):
    def setUp(self):
        self.slept = []
        self.addCleanup(setattr, link.time, "sleep", link.time.sleep)
        link.time.sleep = self.slept.append

    def test_a_stream_goes_on_where_it_broke(self):
        asked = []

        def call(request):
            asked.append(request.from_version)
            yield store.WatchMapResponse(version=len(asked))
            if len(asked) < 3:
                raise Broken(grpc.StatusCode.UNAVAILABLE)

        def resume(request, message):
            request.from_version = message.version

        told = list(link.follow(call, store.WatchMapRequest(), resume))
        self.assertEqual([message.version for message in told], [1, 2, 3])
        self.assertEqual(asked, [0, 1, 2])
        self.assertEqual(self.slept, [1, 1])

    def test_what_is_no_use_to_try_again_is_raised(self):
        def call(_):
            raise Broken(grpc.StatusCode.PERMISSION_DENIED)
            yield

        with self.assertRaises(Broken):
            list(link.follow(call, None))

    def test_a_server_that_stays_away_is_given_up_where_that_is_wanted(self):
        def call(_):
            raise Broken(grpc.StatusCode.UNAVAILABLE)
            yield

        with self.assertRaises(Broken):
            list(link.follow(call, None, attempts=6))
        self.assertEqual(self.slept, [1, 2, 4, 8, 15])


class ConnectTest(unittest.TestCase):
    def refused(self, words, **given):
        with self.assertRaisesRegex(ValueError, words):
            link.connect("localhost:1", **given)

    def test_what_would_be_dropped_is_refused(self):
        self.refused("without --ca", token="token")
        self.refused("without --ca", cert="a", key="b")
        self.refused("needs its key", ca="ca", cert="a")
        self.refused("needs its key", ca="ca", key="b")

    def test_files_are_named(self):
        self.refused("nowhere.pem can't be read: No such file", ca="nowhere.pem")
        with tempfile.NamedTemporaryFile() as file:
            self.refused(f"{file.name} is no PEM file", ca=file.name)


class KeyframesTest(unittest.TestCase):
    def test_keyframes_come_move_and_go_with_their_island(self):
        def change(version, slot, *, anew=False):
            made = store.WatchMapResponse(version=version, local_maps=[7, 9])
            return made, made.islands.add(slot=slot, anew=anew)

        def put(island, slot, index, x):
            keyframe = island.keyframes.add()
            keyframe.id.slot, keyframe.id.index = slot, index
            keyframe.camera_from_island.rotation_wxyz.extend((1, 0, 0, 0))
            keyframe.camera_from_island.translation.extend((x, 0, 0))

        held = link.Keyframes()
        first, island = change(1, 1, anew=True)
        put(island, 1, 0, 1.0)
        held.apply(first)
        second, island = change(2, 2, anew=True)
        put(island, 2, 5, 2.0)
        held.apply(second)
        third, island = change(3, 1)
        put(island, 1, 0, 4.0)
        put(island, 2, 5, 3.0)
        third.removed_island_slots.append(2)
        held.apply(third)
        self.assertEqual(held.version, 3)
        self.assertEqual(list(held.islands), [7])
        self.assertEqual(held.islands[7][(7, 0)].translation, (4.0, 0.0, 0.0))
        fourth, island = change(4, 1)
        gone = island.removed_keyframes.add()
        gone.slot, gone.index = 2, 5
        held.apply(fourth)
        self.assertEqual(list(held.islands[7]), [(7, 0)])


if __name__ == "__main__":
    unittest.main()
