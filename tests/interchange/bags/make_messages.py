#!/usr/bin/python3
"""Makes of a recorded folder the messages that a camera driver would publish, for the writers beside it.

    make_messages.py kitti|tum FOLDER OUT [--frames N] [--jpeg QUALITY] [--png] [--scale S] [--float-depth]
    make_messages.py drawn-stereo|drawn-depth - OUT [--frames N] [--jpeg QUALITY] [--png]

OUT.jsonl has a message a line, OUT.bin the pictures' bytes. Needs python3-numpy and python3-pil.
"""
import argparse
import io
import json
import struct
from pathlib import Path

import numpy
from PIL import Image

KITTI = {"fx": 718.856, "fy": 718.856, "cx": 607.1928, "cy": 185.2157, "shift": -386.1448}
TUM = {"fx": 517.306408, "fy": 516.469215, "cx": 318.643040, "cy": 255.313989,
       "d": [0.262383, -0.953104, -0.005358, 0.002628, 1.163314]}


class Messages:
    def __init__(self, out):
        self.lines = open(f"{out}.jsonl", "w")
        self.bytes = open(f"{out}.bin", "wb")

    def add(self, topic, kind, stamp_ns, frame, fields, data=None):
        # A recorder gets a message some milliseconds after its stamp.
        # Times are texts: JavaScript's numbers have too few digits.
        line = {"topic": topic, "type": kind, "time_ns": str(stamp_ns + 3_000_000), "stamp_ns": str(stamp_ns),
                "frame_id": frame, **fields}
        if data is not None:
            line["offset"], line["size"] = self.bytes.tell(), len(data)
            self.bytes.write(data)
        self.lines.write(json.dumps(line) + "\n")


def resized(picture, scale, how):
    if scale == 1:
        return picture
    return picture.resize((round(picture.width * scale), round(picture.height * scale)), how)


def info(picture, k, scale, shift=0.0, d=()):
    fx, fy, cx, cy = (k[name] * scale for name in ("fx", "fy", "cx", "cy"))
    return {"height": picture.height, "width": picture.width, "distortion_model": "plumb_bob", "D": list(d),
            "K": [fx, 0, cx, 0, fy, cy, 0, 0, 1], "R": [1, 0, 0, 0, 1, 0, 0, 0, 1],
            "P": [fx, 0, cx, shift * scale, 0, fy, cy, 0, 0, 0, 1, 0]}


def add_grey(messages, arguments, topic, stamp, frame, picture):
    if arguments.jpeg or arguments.png:
        packed = io.BytesIO()
        picture.save(packed, *(("JPEG",) if arguments.jpeg else ("PNG",)),
                     **({"quality": arguments.jpeg} if arguments.jpeg else {}))
        form = "mono8; jpeg compressed mono8" if arguments.jpeg else "mono8; png compressed mono8"
        messages.add(f"{topic}/compressed", "CompressedImage", stamp, frame, {"format": form}, packed.getvalue())
        return
    messages.add(topic, "Image", stamp, frame,
                 {"height": picture.height, "width": picture.width, "encoding": "mono8",
                  "step": picture.width}, picture.tobytes())


def add_depth(messages, arguments, stamp, picture):
    pixels = numpy.asarray(picture).astype("<u2")
    if arguments.jpeg or arguments.png:
        packed = io.BytesIO()
        Image.fromarray(pixels).save(packed, "PNG")
        messages.add("/camera/depth_registered/image_raw/compressedDepth", "CompressedImage", stamp, "camera_rgb",
                     {"format": "16UC1; compressedDepth png"}, struct.pack("<iff", 0, 0, 0) + packed.getvalue())
        return
    encoding, data = "16UC1", pixels
    if arguments.float_depth:
        metres = pixels.astype("<f4") / numpy.float32(5000)
        metres[pixels == 0] = numpy.nan
        encoding, data = "32FC1", metres
    messages.add("/camera/depth_registered/image_raw", "Image", stamp, "camera_rgb",
                 {"height": data.shape[0], "width": data.shape[1], "encoding": encoding,
                  "step": data.shape[1] * data.itemsize}, data.tobytes())


def kitti(messages, arguments):
    folder = Path(arguments.folder)
    times = [line.strip() for line in open(folder / "times.txt") if line.strip()]
    for number, time in enumerate(times[:arguments.frames]):
        # As the folder's own reader: KITTI's times are rounded to nanoseconds.
        stamp = round(float(time) * 1e9)
        for side, camera, shift in (("left", 0, 0.0), ("right", 1, KITTI["shift"])):
            picture = resized(Image.open(folder / f"image_{camera}" / f"{number:06d}.png"), arguments.scale,
                              Image.BILINEAR)
            frame = f"stereo_{side}"
            add_grey(messages, arguments, f"/stereo/{side}/image_raw", stamp, frame, picture)
            messages.add(f"/stereo/{side}/camera_info", "CameraInfo", stamp, frame,
                         info(picture, KITTI, arguments.scale, shift))


def tum(messages, arguments):
    folder = Path(arguments.folder)
    lines = [line.split() for line in open(folder / "associated.txt") if line[0] != "#"]
    for time, grey, _, depth in lines[:arguments.frames]:
        seconds, _, rest = time.partition(".")
        stamp = int(seconds) * 10**9 + int(rest.ljust(9, "0")[:9])
        picture = resized(Image.open(folder / grey), arguments.scale, Image.BILINEAR)
        add_grey(messages, arguments, "/camera/rgb/image_raw", stamp, "camera_rgb", picture)
        messages.add("/camera/rgb/camera_info", "CameraInfo", stamp, "camera_rgb",
                     info(picture, TUM, arguments.scale, d=TUM["d"]))
        add_depth(messages, arguments, stamp, resized(Image.open(folder / depth), arguments.scale, Image.NEAREST))


DRAWN = {"fx": 40.0, "fy": 40.0, "cx": 19.5, "cy": 14.5}


def drawn(number, side):
    """A picture of 40x30 that client_agent/source/bag/testing/drawn_bags.h draws too."""
    y, x = numpy.mgrid[0:30, 0:40]
    return Image.fromarray(((7 * x + 13 * y + 31 * number + 101 * side) % 256).astype("u1"))


def drawn_stereo(messages, arguments):
    for number in range(arguments.frames or 3):
        stamp = 1_600_000_000_000_000_000 + number * 100_000_000
        for side, name, shift in ((0, "left", 0.0), (1, "right", -4.0)):
            add_grey(messages, arguments, f"/stereo/{name}/image_raw", stamp, f"stereo_{name}", drawn(number, side))
            messages.add(f"/stereo/{name}/camera_info", "CameraInfo", stamp, f"stereo_{name}",
                         info(drawn(0, 0), DRAWN, 1, shift))


def drawn_depth(messages, arguments):
    start = 1_600_000_000_000_000_000
    messages.add("/tf_static", "TFMessage", start, "", {"transforms": [
        {"parent": "base", "child": name, "translation": {"x": x, "y": 0.0, "z": 0.0},
         "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}} for name, x in (("colour", 0.05), ("depth", 0.02))]})
    for number in range(arguments.frames or 3):
        stamp = start + number * 100_000_000
        add_grey(messages, arguments, "/camera/color/image_raw", stamp, "colour", drawn(number, 0))
        messages.add("/camera/color/camera_info", "CameraInfo", stamp, "colour", info(drawn(0, 0), DRAWN, 1))
        depth = numpy.full((30, 40), 1000 + 100 * number, "<u2")
        packed = io.BytesIO()
        Image.fromarray(depth).save(packed, "PNG")
        messages.add("/camera/depth/image_rect_raw/compressedDepth", "CompressedImage", stamp + 5_000_000, "depth",
                     {"format": "16UC1; compressedDepth png"}, struct.pack("<iff", 0, 0, 0) + packed.getvalue())
        messages.add("/camera/depth/camera_info", "CameraInfo", stamp + 5_000_000, "depth",
                     info(drawn(0, 0), DRAWN, 1))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("kind", choices=("kitti", "tum", "drawn-stereo", "drawn-depth"))
    parser.add_argument("folder")
    parser.add_argument("out")
    parser.add_argument("--frames", type=int)
    parser.add_argument("--jpeg", type=int)
    parser.add_argument("--png", action="store_true")
    parser.add_argument("--scale", type=float, default=1)
    parser.add_argument("--float-depth", action="store_true")
    arguments = parser.parse_args()
    {"kitti": kitti, "tum": tum, "drawn-stereo": drawn_stereo, "drawn-depth": drawn_depth}[arguments.kind](Messages(arguments.out), arguments)


main()
