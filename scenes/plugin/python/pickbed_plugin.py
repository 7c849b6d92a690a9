"""Pose estimators and grasp planners for pickbed, written in Python.

A plug-in is a program that pickbed starts and asks, image by image. The shortest one:

    import numpy as np
    import pickbed_plugin as pb

    @pb.estimator
    def estimate(frame):
        points_C = frame.points_C()
        nearest_C = points_C[points_C[:, 2].argmin()]
        return [pb.Pose(frame.setup.objects[0].name, np.eye(3), nearest_C, score=0.5)]

    pb.serve()

Use it with

    pickbed plugin check "python3 my_estimator.py"
    pickbed run SCENARIO --set estimator.name=process --set estimator.command="python3 my_estimator.py"

or, on another machine, `python3 my_estimator.py --listen 0.0.0.0:5555` and
--set estimator.connect=MACHINE:5555.

Lengths are in metres. X_AB is the pose of frame B in frame A as a 4 x 4 matrix: p_A = X_AB @ p_B.
Frames: W world (z up, origin in the center of the bin floor), B bin, C camera (x right, y down,
z forward; pixel (0, 0) is the center of the first pixel), O object, G gripper (z approach, x
closing direction).

print() is safe: it goes to standard error, which pickbed keeps in the folder logs of the results.
The protocol is described in the documentation, page "Plug-in protocol". This file needs Python 3.8,
numpy and msgpack.
"""

import os
import socket
import struct
import sys
import threading
import traceback
from collections import namedtuple
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Sequence, Tuple

import msgpack
import numpy as np

PROTOCOL = 1

_own_streams: Optional[Tuple[int, int]] = None


def _take_streams():
    """Keeps the message stream for itself: from now on, print() writes to standard error.

    Returns the descriptors (input, output) of the messages.
    """
    global _own_streams
    if _own_streams is None:
        _own_streams = (os.dup(0), os.dup(1))
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.close(nothing)
        os.dup2(2, 1)
        # What was printed before, but not written yet, goes to standard error as well.
        sys.stdout.reconfigure(line_buffering=True)
        sys.stdout.flush()
    return _own_streams


if os.environ.get("PICKBED_PLUGIN"):
    _take_streams()  # before other modules print


# ---- What a plug-in gets ---------------------------------------------------------------------


@dataclass
class Object:
    """An object that may be in the bin."""

    name: str
    mesh: str  # path of an OBJ file in metres, on the machine of pickbed
    vertices_m: np.ndarray  # N x 3, in O
    triangles: np.ndarray  # M x 3, indices of vertices, counter-clockwise from outside
    diameter_m: float
    mass_kg: float
    friction: float
    discrete_symmetries: List[np.ndarray]  # 4 x 4 each, without the identity
    continuous_symmetries: List[Tuple[np.ndarray, np.ndarray]]  # (axis, point on the axis) in O

    def sample(self, count: int, rng: np.random.Generator):
        """Draws points uniformly on the surface. Returns points (N x 3, m) and unit normals."""
        a, b, c = (self.vertices_m[self.triangles[:, i]] for i in range(3))
        cross = np.cross(b - a, c - a)
        area = np.linalg.norm(cross, axis=1)
        faces = rng.choice(len(area), count, p=area / area.sum())
        u, v = rng.random((2, count, 1))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        points = a[faces] + u * (b - a)[faces] + v * (c - a)[faces]
        return points, cross[faces] / area[faces, None]


@dataclass
class Gripper:
    """A gripper of the robot. Frame G is between the finger tips, or in the suction lip."""

    name: str
    mechanism: str  # "parallel_jaw" or "suction_cup"
    max_opening_m: float
    approach_m: float  # straight motion along z of G before the grasp
    settings: str  # all settings as YAML


@dataclass
class Setup:
    """What is known before the first image."""

    objects: List[Object]
    width: int  # of the images, px
    height: int
    K: np.ndarray  # 3 x 3
    working_distance_m: float  # camera to objects
    bin_size_m: Optional[np.ndarray]  # inner length, width, height; None: unknown
    min_score: float  # poses with a lower score are not used
    model: str  # the setting estimator.model
    mode: str  # the setting estimator.mode
    grippers: List[Gripper] = field(default_factory=list)  # of a planner

    def object(self, name: str) -> Object:
        return next(o for o in self.objects if o.name == name)


@dataclass
class Frame:
    """One image."""

    depth_m: np.ndarray  # height x width, float32, metres along z of C; 0 = no reading
    color: Optional[np.ndarray]  # height x width x 3, uint8, sRGB; None: no color
    K: np.ndarray  # 3 x 3
    X_WC: Optional[np.ndarray]  # pose of the camera; None: unknown
    X_CB: Optional[np.ndarray]  # pose of the bin in the camera frame; None: unknown
    counts: Optional[Dict[str, int]]  # number of instances by object; None: unknown
    seed: int  # for random numbers: the same image has the same seed
    setup: Setup = None

    def rng(self) -> np.random.Generator:
        """Returns random numbers that are the same in every run."""
        return np.random.default_rng(self.seed)

    def point_image_C(self) -> np.ndarray:
        """Returns the measured point of each pixel (height x width x 3, m); NaN = no reading."""
        v, u = np.mgrid[: self.depth_m.shape[0], : self.depth_m.shape[1]]
        z = np.where(self.depth_m > 0, self.depth_m, np.nan).astype(float)
        x = (u - self.K[0, 2]) / self.K[0, 0] * z
        y = (v - self.K[1, 2]) / self.K[1, 1] * z
        return np.stack([x, y, z], axis=-1)

    def points_C(self) -> np.ndarray:
        """Returns the measured points (N x 3, m)."""
        points = self.point_image_C().reshape(-1, 3)
        return points[~np.isnan(points[:, 2])]

    def points_in_bin_C(self, margin_m: float = 0.004) -> np.ndarray:
        """Returns the measured points between the walls and above the floor (N x 3, m).

        Needs X_CB and the size of the bin. Points within the margin of the bin are left out, and
        lone points: readings in the air between foreground and background.
        """
        smooth_m = 0.006  # largest step between neighbors of a surface
        neighbors = sum(np.abs(np.roll(self.depth_m, shift, axis) - self.depth_m) < smooth_m
                        for axis in (0, 1) for shift in (-1, 1))
        points_C = self.point_image_C()[(self.depth_m > 0) & (neighbors >= 3)]
        X_BC = np.linalg.inv(self.X_CB)
        points_B = points_C @ X_BC[:3, :3].T + X_BC[:3, 3]
        half = self.setup.bin_size_m[:2] / 2 - margin_m
        inside = (np.abs(points_B[:, :2]) < half).all(axis=1) & (points_B[:, 2] > margin_m)
        return points_C[inside]


# ---- What a plug-in gives --------------------------------------------------------------------

Pose = namedtuple("Pose", "object R t_m score")
Pose.__doc__ = """A pose X_CO: object name, rotation (3 x 3), position (3, m) and score.

The score is the estimated probability that the pose is right, 0 to 1. With estimator.scores=raw it
has any scale, higher is better; `pickbed calibrate` converts it into probabilities.
"""

Grasp = namedtuple("Grasp", "X_WG width_m score gripper pose", defaults=(None, None))
Grasp.__doc__ = """A grasp: pose of the gripper (4 x 4), distance of the contacts (m) and score.

The score has any scale; the grasp with the highest one is executed. `gripper` is a name; None: the first one.
`pose` is the index of the pose that it holds, if poses were given.
"""


class Estimator:
    """Base class of estimators with a state, such as a network. Override estimate()."""

    name = ""  # default: the name of the class
    version = ""  # identifies its code and weights; results of different versions are not mixed
    needs: Sequence[str] = ()  # inputs without which it cannot work: "color", "bin", "counts"

    def setup(self, setup: Setup) -> None:
        """Called once, before the first image."""

    def estimate(self, frame: Frame) -> Sequence[Pose]:
        """Returns the poses in the image; an empty list is a result."""
        raise NotImplementedError

    def close(self) -> None:
        """Called at the end. A server calls it when no pickbed uses it any more."""


class Planner:
    """Base class of grasp planners. Override plan_grasps()."""

    name = ""
    version = ""
    needs: Sequence[str] = ()

    def setup(self, setup: Setup) -> None:
        """Called once, before the first image."""

    def plan_grasps(self, frame: Frame, poses: Optional[List[Pose]]) -> Sequence[Grasp]:
        """Returns the grasps for an image. `poses` is None if none were estimated."""
        raise NotImplementedError

    def close(self) -> None:
        """Called at the end. A server calls it when no pickbed uses it any more."""


_registered: list = []


def estimator(function=None, *, needs=(), version=""):
    """Decorator: the function, called with a Frame, returns the poses."""

    def register(f):
        served = Estimator()
        served.name, served.needs, served.version, served.estimate = f.__name__, needs, version, f
        _registered.append(served)
        return f

    return register(function) if function else register


def planner(function=None, *, needs=(), version=""):
    """Decorator: the function, called with a Frame and poses or None, returns the grasps."""

    def register(f):
        served = Planner()
        served.name, served.needs, served.version = f.__name__, needs, version
        served.plan_grasps = f
        _registered.append(served)
        return f

    return register(function) if function else register


# ---- Messages --------------------------------------------------------------------------------


def _array(value):
    """Reads {dtype, shape, data} without a copy; None stays None."""
    if value is None:
        return None
    return np.frombuffer(value["data"], value["dtype"]).reshape(value["shape"])


def _message_array(value, shape):
    """Writes numbers as {dtype, shape, data}."""
    array = np.ascontiguousarray(value, np.float64)
    if array.size != np.prod(shape):
        raise ValueError(f"expected numbers of shape {shape}, got {array.shape}")
    return {"dtype": "float64", "shape": list(shape), "data": array.tobytes()}


def _read_setup(message):
    def read_object(o):
        symmetries = o["symmetries"]
        return Object(
            name=o["name"], mesh=o["mesh"], vertices_m=_array(o["vertices_m"]),
            triangles=_array(o["triangles"]), diameter_m=o["diameter_m"], mass_kg=o["mass_kg"],
            friction=o["friction"],
            discrete_symmetries=[_array(X) for X in symmetries["discrete"]],
            continuous_symmetries=[(_array(a["axis"]), _array(a["offset_m"]))
                                   for a in symmetries["continuous"]])

    camera, the_bin = message["camera"], message["bin"]
    return Setup(
        objects=[read_object(o) for o in message["objects"]], width=camera["width"],
        height=camera["height"], K=_array(camera["K"]),
        working_distance_m=message["working_distance_m"],
        bin_size_m=None if the_bin is None else _array(the_bin["inner_size_m"]),
        min_score=message["min_score"], model=message["model"], mode=message["mode"],
        grippers=[Gripper(**g) for g in message["grippers"]])


def _read_frame(message, setup):
    return Frame(
        depth_m=_array(message["depth_m"]), color=_array(message["color"]),
        K=_array(message["K"]), X_WC=_array(message["X_WC"]), X_CB=_array(message["X_CB"]),
        counts=message["counts"], seed=message["seed"], setup=setup)


def _read_poses(message):
    if message["poses"] is None:
        return None
    return [Pose(p["object"], _array(p["R"]), _array(p["t_m"]), p["score"])
            for p in message["poses"]]


def _write_pose(pose):
    name, R, t_m, score = pose
    return {"object": str(name), "R": _message_array(R, (3, 3)), "t_m": _message_array(t_m, (3,)),
            "score": float(score)}


def _write_grasp(grasp):
    grasp = Grasp(*grasp)
    return {"X_WG": _message_array(grasp.X_WG, (4, 4)), "width_m": float(grasp.width_m),
            "score": float(grasp.score), "gripper": grasp.gripper,
            "pose": None if grasp.pose is None else int(grasp.pose)}


class _Stream:
    """Messages over two descriptors, each with its length before it."""

    def __init__(self, source, sink):
        self._source, self._sink = source, sink
        self._buffer = np.empty(0, np.uint8)

    def _read(self, size):
        """Returns a view of the next bytes, or None at the end of the stream."""
        if size > self._buffer.size:
            self._buffer = np.empty(size, np.uint8)
        view = memoryview(self._buffer)[:size]
        done = 0
        while done < size:
            got = os.readv(self._source, [view[done:]])
            if got == 0:
                return None
            done += got
        return view

    def receive(self):
        head = self._read(4)
        if head is None:
            return None
        body = self._read(struct.unpack(">I", head)[0])
        return None if body is None else msgpack.unpackb(body, raw=False)

    def send(self, message):
        body = msgpack.packb(message, use_bin_type=True)
        pieces = [memoryview(struct.pack(">I", len(body))), memoryview(body)]
        while pieces:
            sent = os.writev(self._sink, pieces)
            while pieces and sent >= len(pieces[0]):
                sent -= len(pieces.pop(0))
            if pieces:
                pieces[0] = pieces[0][sent:]


class _Session:
    """Answers the requests of one pickbed."""

    def __init__(self, served, lock, in_use):
        self._served = served
        self._lock = lock
        self._in_use = in_use  # what the sessions with a setup use, one entry per session
        self._active = None
        self._setup = None

    def run(self, stream):
        try:
            self._answer_all(stream)
        finally:
            self._end()

    def _end(self):
        if self._setup is None:  # pickbed may only have asked what this is
            return
        with self._lock:
            self._in_use.remove(id(self._active))
            if id(self._active) not in self._in_use:
                self._active.close()

    def _answer_all(self, stream):
        while True:
            message = stream.receive()
            if message is None or message.get("verb") == "close":
                break
            try:
                with self._lock:
                    answer = self._answer(message)
            except Exception as error:  # the report of any error of a plug-in goes to pickbed
                report = traceback.format_exc()
                print(report, file=sys.stderr, flush=True)
                text = f"{type(error).__name__}: {error}"
                answer = {"error": text, "traceback": report}
            stream.send(answer)

    def _answer(self, message):
        verb = message.get("verb")
        if verb == "hello":
            return self._hello(message)
        if verb == "setup":
            setup = _read_setup(message)
            if self._setup is None:
                self._in_use.append(id(self._active))
            self._setup = setup
            self._active.setup(setup)
            return {}
        if verb == "estimate":
            poses = self._active.estimate(_read_frame(message, self._setup))
            return {"poses": [_write_pose(pose) for pose in poses]}
        if verb == "plan_grasps":
            grasps = self._active.plan_grasps(_read_frame(message, self._setup),
                                              _read_poses(message))
            return {"grasps": [_write_grasp(grasp) for grasp in grasps]}
        raise ValueError(f"unknown verb {verb!r}")

    def _hello(self, message):
        def role(served):
            return "planner" if isinstance(served, Planner) else "estimator"

        for served in self._served:
            if role(served) == message["role"]:
                self._active = served
        answering = self._active or self._served[0]
        return {"protocol": PROTOCOL, "name": answering.name or type(answering).__name__,
                "version": str(answering.version),
                "roles": [role(served) for served in self._served],
                "needs": list(answering.needs)}


def _serve_connection(connection, served, lock, in_use):
    with connection:
        _Session(served, lock, in_use).run(_Stream(connection.fileno(), connection.fileno()))


def _listen(address, served):
    host, _, port = address.rpartition(":")
    lock, in_use = threading.Lock(), []
    server = socket.create_server((host or "127.0.0.1", int(port)))
    print(f"listening on {host or '127.0.0.1'}:{server.getsockname()[1]}", file=sys.stderr,
          flush=True)
    while True:
        connection, _ = server.accept()
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        threading.Thread(target=_serve_connection, args=(connection, served, lock, in_use),
                         daemon=True).start()


def serve(*served):
    """Answers requests until pickbed ends the plug-in.

    served: instances of Estimator or Planner. Default: the decorated functions. With the
    arguments `--listen [HOST:]PORT` the program is a server for any number of pickbed workers. Its
    requests are then answered one at a time. Each needs a setup of its own, so an estimator with a
    state must derive everything that depends on the objects from frame.setup.
    """
    served = list(served) or _registered
    if not served:
        raise SystemExit("nothing to serve: decorate a function, or give an Estimator to serve()")
    if "--listen" in sys.argv:
        at = sys.argv.index("--listen") + 1
        if at >= len(sys.argv):
            raise SystemExit("--listen needs [HOST:]PORT")
        return _listen(sys.argv[at], served)
    if not os.environ.get("PICKBED_PLUGIN") and sys.stdin.isatty():
        raise SystemExit(f"this is a plug-in of pickbed; run it with\n  pickbed plugin check "
                         f"\"python3 {sys.argv[0]}\"\nor start a server with --listen PORT")
    _Session(served, threading.Lock(), []).run(_Stream(*_take_streams()))
