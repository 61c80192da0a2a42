#!/usr/bin/env python3
"""Asks a map store what it has, follows a mission's map, and follows a robot's pose.

  client.py STORE                                  its missions
  client.py STORE --mission lab --messages 3       the mission's map, as it grows
  client.py STORE --mission lab --picture hall.png --camera "517.3 516.5 318.6 255.3"
  client.py STORE --mission lab --events           what happened in the mission, and what happens
  client.py ROBOT --pose --messages 3              where a robot is; ROBOT is its --listen
  client.py ROBOT --pose --events                  what changes for whoever follows the pose

docs/clients.md says how to make the code that it imports; corbslam_link.py lies beside it. """
import argparse
import itertools
import sys

import grpc
from corbslam_link import Keyframes, Transform, connect, follow, global_from_camera, read
from corbslam.v1 import agent_service_pb2 as agent, agent_service_pb2_grpc as agent_grpc
from corbslam.v1 import localize_pb2 as localize
from corbslam.v1 import map_store_service_pb2 as store, map_store_service_pb2_grpc as store_grpc


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
    def resume(request, change):
        # Of a change in several messages the last one is the whole.
        if not change.continues:
            request.from_version = change.version

    held = Keyframes()
    changes = follow(stub.WatchMap, store.WatchMapRequest(mission=f"missions/{args.mission}"), resume)
    for change in itertools.islice(changes, args.messages):
        held.apply(change)
        keyframes = sum(len(island.keyframes) for island in change.islands)
        print(f"version {change.version}: {keyframes} keyframes came or moved,",
              f"{sum(map(len, held.islands.values()))} are there, in {len(held.islands)} islands", flush=True)


def watch_events(call, request, messages):
    def resume(request, event):
        request.after_number = event.number

    for event in itertools.islice(follow(call, request, resume), messages):
        if isinstance(event, agent.AgentEvent):
            print(event.number, agent.AgentEventKind.Name(event.kind), event.local_map, flush=True)
        else:
            print(event.number, event.WhichOneof("event"), f"revision {event.revision}", flush=True)


def find_picture(stub, args):
    request = localize.LocalizeRequest(mission=f"missions/{args.mission}")
    request.picture.encoded = read(args.picture)
    camera = request.picture.camera
    numbers = list(map(float, args.camera.split()))
    camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px = numbers[:4]
    camera.distortion.extend(numbers[4:])  # k1 k2 p1 p2 k3 of the lens, if it distorts.
    answer = stub.Localize(request, timeout=60)
    found = answer.stage == localize.LOCATE_STAGE_LOCATED
    place = Transform.of(answer.camera_from_island).inverse().translation if found else ()
    print(localize.LocateStage.Name(answer.stage), f"{answer.inliers} points agree",
          f"at {[round(x, 4) for x in place]} metres" if found else "")


def watch_pose(stub, messages):
    poses = follow(stub.WatchPose, agent.WatchPoseRequest(max_rate_hz=5))
    for pose in itertools.islice(poses, messages):
        shared = global_from_camera(pose)
        print(pose.timestamp_ns, agent.TrackingState.Name(pose.state), list(pose.local_from_camera.translation),
              f"in the shared frame at {[round(x, 4) for x in shared.translation]}" if shared else "", flush=True)


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("address")
    for flag in ("--ca", "--cert", "--key", "--token", "--mission", "--picture", "--camera"):
        parser.add_argument(flag)
    parser.add_argument("--pose", action="store_true")
    parser.add_argument("--events", action="store_true")
    parser.add_argument("--messages", type=int, default=3)
    args = parser.parse_args()
    if args.picture and not args.camera:
        parser.error("--picture needs --camera \"FX FY CX CY\"")
    with connect(args.address, args.ca, args.cert, args.key, args.token) as channel:
        if args.pose:
            robot = agent_grpc.AgentStub(channel)
            if args.events:
                return watch_events(robot.WatchEvents, agent.WatchAgentEventsRequest(), args.messages)
            return watch_pose(robot, args.messages)
        stub = store_grpc.MapStoreStub(channel)
        if not args.mission:
            return list_missions(stub)
        if args.events:
            request = store.WatchEventsRequest(mission=f"missions/{args.mission}")
            return watch_events(stub.WatchEvents, request, args.messages)
        return find_picture(stub, args) if args.picture else watch_map(stub, args)


if __name__ == "__main__":
    try:
        main()
    except grpc.RpcError as error:
        sys.exit(f"{error.code().name}: {error.details()}")
    except ValueError as error:
        sys.exit(str(error))
    except KeyboardInterrupt:
        pass
