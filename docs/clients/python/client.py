#!/usr/bin/env python3
"""Asks a map store what it has, follows a mission's map, and follows a robot's pose.

  client.py STORE                                  its missions
  client.py STORE --mission lab --messages 3       the mission's map, as it grows
  client.py STORE --mission lab --picture hall.png --camera "517.3 516.5 318.6 255.3"
  client.py ROBOT --pose --messages 3              where a robot is; ROBOT is its --listen

docs/clients.md says how to make the code that it imports. """
import argparse
import itertools
import pathlib
import sys

import grpc
from corbslam.v1 import agent_service_pb2 as agent, agent_service_pb2_grpc as agent_grpc
from corbslam.v1 import localize_pb2 as localize
from corbslam.v1 import map_store_service_pb2 as store, map_store_service_pb2_grpc as store_grpc


def read(path):
    return pathlib.Path(path).read_bytes() if path else None


def connect(args):
    """A channel: with TLS if --ca is given, and then by certificate, by token, or by neither."""
    if not args.ca:
        return grpc.insecure_channel(args.address)
    credentials = grpc.ssl_channel_credentials(read(args.ca), read(args.key), read(args.cert))
    if args.token:
        token = grpc.access_token_call_credentials(read(args.token).decode().strip())
        credentials = grpc.composite_channel_credentials(credentials, token)
    return grpc.secure_channel(args.address, credentials)


def place(pose):
    """Where a camera is, whose pose takes points from the map's frame into its own: -R^T t."""
    (w, *v), t = pose.rotation_wxyz, pose.translation
    cross = lambda a, b: [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]
    turned = cross(v, [c - w * x for c, x in zip(cross(v, t), t)])
    return [round(-(x + 2 * y), 4) for x, y in zip(t, turned)]


def list_missions(stub):
    request = store.ListMissionsRequest(page_size=100)
    while True:
        page = stub.ListMissions(request, timeout=10)
        for mission in page.missions:
            print(f"{mission.name}: {mission.keyframes} keyframes, {mission.islands} islands")
        if not page.next_page_token:
            return
        request.page_token = page.next_page_token


def watch_map(stub, args):
    request = store.WatchMapRequest(mission=f"missions/{args.mission}")
    for change in itertools.islice(stub.WatchMap(request), args.messages):
        keyframes = sum(len(island.keyframes) for island in change.islands)
        print(f"version {change.version}: {keyframes} keyframes came or moved")


def find_picture(stub, args):
    request = localize.LocalizeRequest(mission=f"missions/{args.mission}")
    request.picture.encoded = read(args.picture)
    camera = request.picture.camera
    numbers = list(map(float, args.camera.split()))
    camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px = numbers[:4]
    camera.distortion.extend(numbers[4:])  # k1 k2 p1 p2 k3 of the lens, if it distorts.
    answer = stub.Localize(request, timeout=60)
    located = answer.stage == localize.LOCATE_STAGE_LOCATED
    print(localize.LocateStage.Name(answer.stage), f"{answer.inliers} points agree",
          f"at {place(answer.camera_from_island)} metres" if located else "")


def watch_pose(stub, messages):
    for pose in itertools.islice(stub.WatchPose(agent.WatchPoseRequest(max_rate_hz=5)), messages):
        print(pose.timestamp_ns, agent.TrackingState.Name(pose.state),
              list(pose.local_from_camera.translation))


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("address")
    for flag in ("--ca", "--cert", "--key", "--token", "--mission", "--picture", "--camera"):
        parser.add_argument(flag)
    parser.add_argument("--pose", action="store_true")
    parser.add_argument("--messages", type=int, default=3)
    args = parser.parse_args()
    with connect(args) as channel:
        if args.pose:
            return watch_pose(agent_grpc.AgentStub(channel), args.messages)
        stub = store_grpc.MapStoreStub(channel)
        if not args.mission:
            return list_missions(stub)
        return find_picture(stub, args) if args.picture else watch_map(stub, args)


if __name__ == "__main__":
    try:
        main()
    except grpc.RpcError as error:
        sys.exit(f"{error.code().name}: {error.details()}")
