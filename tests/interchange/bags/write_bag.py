#!/usr/bin/python3
"""Writes messages of make_messages.py as a ROS 1 bag, with ROS's own library (Debian's python3-rosbag).

    write_bag.py MESSAGES FILE.bag [none|bz2|lz4]
"""
import json
import sys

import genpy
import rosbag
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from tf2_msgs.msg import TFMessage


def time_of(text):
    ns = int(text)
    return genpy.Time(ns // 10**9, ns % 10**9)


def transforms_of(line):
    message = TFMessage()
    for given in line["transforms"]:
        one = TransformStamped()
        one.header.stamp = time_of(line["stamp_ns"])
        one.header.frame_id, one.child_frame_id = given["parent"], given["child"]
        for axis in "xyz":
            setattr(one.transform.translation, axis, given["translation"][axis])
        for axis in "xyzw":
            setattr(one.transform.rotation, axis, given["rotation"][axis])
        message.transforms.append(one)
    return message


def message_of(line, pictures):
    if line["type"] == "TFMessage":
        return transforms_of(line)
    message = {"Image": Image, "CompressedImage": CompressedImage, "CameraInfo": CameraInfo}[line["type"]]()
    message.header.stamp = time_of(line["stamp_ns"])
    message.header.frame_id = line["frame_id"]
    for field in ("height", "width", "encoding", "is_bigendian", "step", "format", "distortion_model", "D", "K", "R",
                  "P", "binning_x", "binning_y"):
        if field in line:
            setattr(message, field, line[field])
    for field, value in line.get("roi", {}).items():
        setattr(message.roi, field, value)
    if "size" in line:
        pictures.seek(line["offset"])
        message.data = pictures.read(line["size"])
    return message


def main():
    messages, out, compression = (sys.argv[1:] + ["none"])[:3]
    with rosbag.Bag(out, "w", compression=compression) as bag, open(f"{messages}.bin", "rb") as pictures:
        for text in open(f"{messages}.jsonl"):
            line = json.loads(text)
            bag.write(line["topic"], message_of(line, pictures), time_of(line["time_ns"]))


main()
