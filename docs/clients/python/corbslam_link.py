"""What programs that follow robots and maps have in common; copy it beside yours.

Connecting with credentials, streams that go on when a server was away, poses that are composed, and a
mission's keyframes as WatchMap tells of them. It imports gRPC alone; the generated messages are yours."""
import dataclasses
import pathlib
import time

import grpc

# Worth trying again: the server is away or ends, or the line broke.
AWAY = (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.RESOURCE_EXHAUSTED)


def read(path):
    """The file's bytes; None without a path. ValueError, in a sentence, for one that can't be read."""
    if not path:
        return None
    try:
        return pathlib.Path(path).read_bytes()
    except OSError as error:
        raise ValueError(f"{path} can't be read: {error.strerror}") from error


def connect(address, ca=None, cert=None, key=None, token=None):
    """A channel to HOST:PORT: with TLS if `ca` is given, and then by certificate, by token, or by neither.

    ValueError, in a sentence, for what can't be meant. A token is read again for each call."""
    if bool(cert) != bool(key):
        raise ValueError("a certificate needs its key, and a key its certificate: give --cert and --key, or neither")
    if not ca:
        if cert or token:
            raise ValueError("without --ca there is no TLS, and nobody is told who you are: "
                             "give --ca, the file of the server's authority, too")
        return grpc.insecure_channel(address)
    for path, words in ((ca, b"BEGIN CERTIFICATE"), (cert, b"BEGIN CERTIFICATE"), (key, b"PRIVATE KEY")):
        if path and words not in read(path):
            raise ValueError(f"{path} is no PEM file with {words.decode()}")
    credentials = grpc.ssl_channel_credentials(read(ca), read(key), read(cert))
    if token:
        read(token)

        def show(_, done):
            done((("authorization", "Bearer " + read(token).decode().strip()),), None)

        credentials = grpc.composite_channel_credentials(credentials, grpc.metadata_call_credentials(show))
    return grpc.secure_channel(address, credentials)


def follow(call, request, resume=lambda request, message: None, attempts=None):
    """The messages of a stream, and on where it broke: `call(request)` again, after 1, 2, 4, up to 15 s.

    `resume(request, message)` notes in the request what each message has told, as
    `request.from_version = message.version`. Other errors than AWAY are raised, and AWAY after so many
    `attempts` in a row without a message. A stream that the server ended in order ends here, too."""
    failed = 0
    while True:
        try:
            for message in call(request):
                failed = 0
                resume(request, message)
                yield message
            return
        except grpc.RpcError as error:
            failed += 1
            if error.code() not in AWAY or (attempts and failed >= attempts):
                raise
            time.sleep(min(15, 2 ** (failed - 1)))


@dataclasses.dataclass(frozen=True)
class Transform:
    """x_target = scale * rotate(x_source) + translation: a Rigid or a Similarity of the wire."""

    rotation_wxyz: tuple = (1.0, 0.0, 0.0, 0.0)
    translation: tuple = (0.0, 0.0, 0.0)
    scale: float = 1.0

    @staticmethod
    def of(message):
        """That of a message; None where it has none (`if message.HasField(...)` says so first)."""
        if len(message.rotation_wxyz) != 4:
            return None
        scale = message.scale if "scale" in message.DESCRIPTOR.fields_by_name and message.HasField("scale") else 1.0
        return Transform(tuple(message.rotation_wxyz), tuple(message.translation), scale)

    def rotate(self, x):
        """The vector, turned."""
        (w, *v), c = self.rotation_wxyz, _cross(self.rotation_wxyz[1:], x)
        return tuple(a + 2 * (w * b + d) for a, b, d in zip(x, c, _cross(v, c)))

    def __call__(self, x):
        """x_target of x_source."""
        return tuple(self.scale * a + b for a, b in zip(self.rotate(x), self.translation))

    def __matmul__(self, other):
        """target_from_middle @ middle_from_source."""
        (w, *v), (u, *z) = self.rotation_wxyz, other.rotation_wxyz
        real = w * u - sum(a * b for a, b in zip(v, z))
        turned = tuple(w * b + u * a + c for a, b, c in zip(v, z, _cross(v, z)))
        return Transform((real, *turned), self(other.translation), self.scale * other.scale)

    def inverse(self):
        """source_from_target."""
        back = Transform((self.rotation_wxyz[0], *(-x for x in self.rotation_wxyz[1:])))
        turned = back.rotate(self.translation)
        return Transform(back.rotation_wxyz, tuple(-x / self.scale for x in turned), 1 / self.scale)


def _cross(a, b):
    return tuple(a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3))


def global_from_camera(pose):
    """Where the camera of a WatchPoseResponse is in the shared frame; None while nobody knows."""
    if not (pose.HasField("local_from_camera") and pose.HasField("global_from_local")):
        return None
    return Transform.of(pose.global_from_local) @ Transform.of(pose.local_from_camera)


class Keyframes:
    """A mission's keyframes, as WatchMap tells of them.

    `islands` has, by the id of the local map that names an island, a Transform camera_from_island of
    each keyframe, by (local map, index)."""

    def __init__(self):
        self.islands = {}
        self.version = 0

    def apply(self, change):
        """Takes a WatchMapResponse in; each once, in their order."""
        name = lambda slot: change.local_maps[slot - 1]
        ids = lambda refs: [(name(ref.slot), ref.index) for ref in refs]
        for slot in change.removed_island_slots:
            self.islands.pop(name(slot), None)
        for island in change.islands:
            if island.anew:
                self.islands.pop(name(island.slot), None)
            held = self.islands.setdefault(name(island.slot), {})
            for gone in ids(island.removed_keyframes):
                held.pop(gone, None)
            for keyframe in island.keyframes:
                held[(name(keyframe.id.slot), keyframe.id.index)] = Transform.of(keyframe.camera_from_island)
        self.version = change.version
