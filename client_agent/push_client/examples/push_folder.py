#!/usr/bin/env python3
"""Pushes a recorded stereo folder to a robot as a camera would, and writes the poses that come back.

  client_agent --source push:/tmp/camera.sock --rig rig.yaml &
  push_folder.py KITTI_FOLDER /tmp/camera.sock --rate 10 --poses poses.tum

The folder holds image_0 and image_1 with grey pictures of 8 bits, .pgm or .png (through libpng), in the
order of their names, and with --stamps recorded times.txt, a line of seconds for each. It needs
libcorbslam_push.so.0 and nothing else of Python's: a driver of yours takes Robot as it is.
"""

import argparse
import ctypes
import ctypes.util
import pathlib
import sys
import time

OK, TIMEOUT = 0, 1
GREY8 = 1
TRACKING = 1


class Picture(ctypes.Structure):
    _fields_ = [("format", ctypes.c_uint32), ("width_px", ctypes.c_uint32),
                ("height_px", ctypes.c_uint32), ("stride_bytes", ctypes.c_uint32)]


class Options(ctypes.Structure):
    _fields_ = [("socket_path", ctypes.c_char_p), ("rig_text", ctypes.c_char_p),
                ("name", ctypes.c_char_p), ("first", Picture), ("second", Picture),
                ("slots", ctypes.c_uint32), ("timeout_ms", ctypes.c_int32)]


class Pose(ctypes.Structure):
    _fields_ = [("timestamp_ns", ctypes.c_int64), ("state", ctypes.c_uint32),
                ("points_matched", ctypes.c_uint32), ("local_map", ctypes.c_uint64),
                ("dropped", ctypes.c_uint64), ("translation", ctypes.c_double * 3),
                ("rotation", ctypes.c_double * 4)]


class PushError(Exception):
    pass


class Robot:
    """A connection with a robot that plays push:SOCKET."""

    def __init__(self, socket, width, height, rig=None, library="libcorbslam_push.so.0"):
        self.push = ctypes.CDLL(library)
        picture = Picture(GREY8, width, height, 0)
        options = Options(socket.encode(), rig.encode() if rig else None, b"push_folder.py", picture,
                          picture, 0, 30000)
        self.connection = ctypes.c_void_p()
        error = ctypes.create_string_buffer(2100)
        if self.push.corbslam_push_connect(ctypes.byref(options), ctypes.byref(self.connection),
                                           error, ctypes.c_size_t(len(error))) != OK:
            raise PushError(error.value.decode(errors="replace"))

    def _succeeds(self, status):
        if status in (OK, TIMEOUT):
            return status == OK
        error = ctypes.create_string_buffer(2100)
        self.push.corbslam_push_error(self.connection, error, ctypes.c_size_t(len(error)))
        raise PushError(error.value.decode(errors="replace"))

    def frame(self, left, right, timestamp_ns, timeout_ms=50):
        """Returns False where no slot was free in time: the robot misses this frame."""
        return self._succeeds(self.push.corbslam_push_frame(
            self.connection, left, ctypes.c_size_t(0), right, ctypes.c_size_t(0),
            ctypes.c_int64(timestamp_ns), ctypes.c_int32(timeout_ms)))

    def pose(self, timeout_ms=0):
        """Returns None where none came in time."""
        pose = Pose()
        came = self._succeeds(self.push.corbslam_push_next_pose(
            self.connection, ctypes.c_int32(timeout_ms), ctypes.byref(pose)))
        return pose if came else None

    def close(self):
        self.push.corbslam_push_close(self.connection)


class PngImage(ctypes.Structure):
    _fields_ = [("opaque", ctypes.c_void_p), ("version", ctypes.c_uint32),
                ("width", ctypes.c_uint32), ("height", ctypes.c_uint32),
                ("format", ctypes.c_uint32), ("flags", ctypes.c_uint32),
                ("colormap_entries", ctypes.c_uint32), ("warning_or_error", ctypes.c_uint32),
                ("message", ctypes.c_char * 64)]


def read_png(path):
    png = ctypes.CDLL(ctypes.util.find_library("png16") or "libpng16.so.16")
    image = PngImage(version=1)
    if not png.png_image_begin_read_from_file(ctypes.byref(image), str(path).encode()):
        raise PushError(f"{path}: {image.message.decode()}")
    image.format = 0  # Grey, 8 bits.
    pixels = ctypes.create_string_buffer(image.width * image.height)
    if not png.png_image_finish_read(ctypes.byref(image), None, pixels, 0, None):
        raise PushError(f"{path}: {image.message.decode()}")
    return image.width, image.height, pixels.raw


def read_pgm(path):
    content = path.read_bytes()
    fields = content.split(maxsplit=4)
    if fields[0] != b"P5" or fields[3] != b"255":
        raise PushError(f"{path}: is no PGM of 8 bits (P5, 255)")
    width, height = int(fields[1]), int(fields[2])
    return width, height, content[-width * height:]


def read(path):
    return read_png(path) if path.suffix == ".png" else read_pgm(path)


def frames(folder):
    left = sorted((folder / "image_0").iterdir())
    right = sorted((folder / "image_1").iterdir())
    if len(left) != len(right) or not left:
        raise PushError(f"{folder}: {len(left)} left and {len(right)} right pictures")
    return list(zip(left, right))


def stamps(folder, count):
    """The recording's times in ns."""
    lines = (folder / "times.txt").read_text().split()
    if len(lines) < count:
        raise PushError(f"{folder}/times.txt: {len(lines)} times for {count} pairs")
    return [round(float(line) * 1e9) for line in lines]


def as_tum(pose):
    """A line of seconds, position and quaternion x y z w."""
    numbers = [f"{value:.9f}" for value in [*pose.translation, *pose.rotation]]
    return " ".join([f"{pose.timestamp_ns // 10**9}.{pose.timestamp_ns % 10**9:09d}", *numbers])


def play(arguments, out):
    pairs = frames(arguments.folder)
    recorded = stamps(arguments.folder, len(pairs)) if arguments.stamps == "recorded" else None
    width, height, _ = read(pairs[0][0])
    rig = arguments.rig.read_text() if arguments.rig else None
    robot = Robot(arguments.socket, width, height, rig, arguments.library)
    missed, poses, dropped = 0, 0, 0

    def listen(timeout_ms):
        nonlocal poses, dropped
        while (pose := robot.pose(timeout_ms)) is not None:
            dropped = pose.dropped
            if pose.state == TRACKING:
                poses += 1
                print(as_tum(pose), file=out, flush=True)

    begin = time.monotonic_ns()
    for i, (left, right) in enumerate(pairs):
        _, _, left_pixels = read(left)
        _, _, right_pixels = read(right)
        due = begin + round(i * 1e9 / arguments.rate)
        time.sleep(max(0, due - time.monotonic_ns()) / 1e9)
        stamp = recorded[i] if recorded else time.monotonic_ns()
        missed += not robot.frame(left_pixels, right_pixels, stamp)
        listen(0)
    listen(2000)
    robot.close()
    print(f"{len(pairs)} pairs, {missed} for which no slot was free, {dropped} dropped by the robot, "
          f"{poses} poses in {(time.monotonic_ns() - begin) / 1e9:.1f} s", file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("socket")
    parser.add_argument("--rig", type=pathlib.Path, help="Rig file, where the robot has none")
    parser.add_argument("--rate", type=float, default=10, help="Frames a second")
    parser.add_argument("--stamps", choices=["clock", "recorded"], default="clock",
                        help="The monotonic clock's, as a camera's, or those of times.txt")
    parser.add_argument("--poses", default="-", help="File for the poses, as TUM; -: standard output")
    parser.add_argument("--library", default="libcorbslam_push.so.0")
    arguments = parser.parse_args()
    try:
        if arguments.poses == "-":
            play(arguments, sys.stdout)
        else:
            with open(arguments.poses, "w", encoding="utf-8") as out:
                play(arguments, out)
    except (PushError, OSError) as error:
        sys.exit(f"push_folder.py: {error}")


if __name__ == "__main__":
    main()
