"""Makes sequences in KITTI's layout out of others, by links to their pictures."""
import shutil


def link_frames(sequence, frames, folder):
    """Makes `folder` of the frames of those numbers, in that order, with calibration, without times."""
    folder.mkdir(parents=True)
    shutil.copy(sequence / "calib.txt", folder)
    for name in ("image_0", "image_1"):
        pictures = sorted((sequence / name).iterdir())
        (folder / name).mkdir()
        for place, frame in enumerate(frames):
            (folder / name / f"{place:06d}{pictures[0].suffix}").symlink_to(
                pictures[frame].resolve())
