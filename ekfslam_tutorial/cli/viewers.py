"""A run for the viewers Rerun and Foxglove: poses in time, paths, landmarks with their ellipsoids at three sigma."""

import tempfile
from pathlib import Path

import numpy as np

from ..geometry import R2q
from ..toolbox.files.writing import replacing
from .trajectories import frames_of, in_space

SIGMAS = 3.0
GREY, BLUE = (120, 120, 120), (0, 90, 181)


def ellipsoids(history):
    """Landmarks of the last frame: ids, points (n, 3), half axes (n, 3) at three sigma, quaternions (n, 4)."""
    s, found = history.last, []
    for id, lmk in s.lmks.items():
        p, P = lmk.point(s.map)
        if np.isfinite(p).all() and np.isfinite(P).all():
            P = np.pad(P, (0, 3 - len(p)))
            variances, R = np.linalg.eigh(P)
            R = R * np.sign(np.linalg.det(R))
            found.append((id, np.pad(p, (0, 3 - len(p))), SIGMAS * np.sqrt(variances.clip(1e-8)), R2q(R)[0]))
    ids, p, axes, q = zip(*found, strict=True) if found else ((), (), (), ())
    return list(ids), np.reshape(p, (-1, 3)), np.reshape(axes, (-1, 3)), np.reshape(q, (-1, 4))


def true_points(history):
    """True landmarks in space, (n, 3)."""
    world = history.last.sim_lmk
    points = np.zeros((0, 3)) if world is None else np.asarray(world.points, float)
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))


def write_rerun(out, history):
    """Write run.rrd; return its name.

    Raises
    ------
    ValueError
        Without the package rerun-sdk.
    """
    try:
        import rerun as rr  # type: ignore[import-not-found]
    except ImportError as error:
        raise ValueError("for Rerun the package rerun-sdk is needed: pip install ekfslam_tutorial[rerun]") from error
    rec = rr.RecordingStream("ekfslam")
    with replacing(out / "run.rrd") as part:
        rec.save(str(part))
        ids, p, axes, q = ellipsoids(history)
        turned = q[:, [1, 2, 3, 0]]  # its scalar comes last
        rec.log("map/landmarks", rr.Points3D(p, labels=[str(id) for id in ids], colors=BLUE), static=True)
        shown = rr.Ellipsoids3D(centers=p, half_sizes=axes, quaternions=turned, colors=BLUE)
        rec.log("map/sigma", shown, static=True)
        if len(truth := true_points(history)):
            rec.log("truth/landmarks", rr.Points3D(truth, colors=GREY), static=True)
        for id in history.robots:
            track = history.track(id)
            x, _ = frames_of(track)
            known = track.known
            paths = {f"robot-{id}": (track.t, x, BLUE)}
            paths[f"truth/robot-{id}"] = track.t[known], in_space(track.truth[known]), GREY
            for name, (times, poses, color) in paths.items():
                if not len(times):
                    continue
                rec.log(f"{name}/path", rr.LineStrips3D([poses[:, :3]], colors=color), static=True)
                for t, pose in zip(times, poses, strict=True):
                    rec.set_time("t", duration=float(t))
                    turn = rr.Quaternion(xyzw=pose[[4, 5, 6, 3]])
                    rec.log(f"{name}/pose", rr.Transform3D(translation=pose[:3], rotation=turn))
        rec.flush()
        rec.disconnect()
    return ["run.rrd"]


def write_mcap(out, history):
    """Write run.mcap: poses with covariances, paths and markers as messages of ROS 2, for Foxglove; return its name.

    Raises
    ------
    ValueError
        Without the package rosbags.
    """
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise ValueError("for MCAP the package rosbags is needed: pip install ekfslam_tutorial[bags]") from error
    store = get_typestore(Stores.ROS2_HUMBLE)
    with tempfile.TemporaryDirectory() as folder:
        with Writer(Path(folder) / "run", version=9, storage_plugin=StoragePlugin.MCAP) as bag:
            topics = {}
            for t, topic, message in sorted(_messages(history, store.types), key=lambda row: row[0]):
                kind = message.__msgtype__
                topics[topic] = topics.get(topic) or bag.add_connection(topic, kind, typestore=store)
                bag.write(topics[topic], round(1e9 * t), store.serialize_cdr(message, kind))
        with replacing(out / "run.mcap") as part:
            part.write_bytes(next((Path(folder) / "run").glob("*.mcap")).read_bytes())
    return ["run.mcap"]


def _messages(history, T):
    """(time, topic, message) of a run."""
    make = lambda kind, *values: T[kind](*values)

    def header(t):
        return make("std_msgs/msg/Header", make("builtin_interfaces/msg/Time", *divmod(round(1e9 * t), 10**9)), "map")

    def pose(x):
        point = make("geometry_msgs/msg/Point", *map(float, x[:3]))
        return make("geometry_msgs/msg/Pose", point, make("geometry_msgs/msg/Quaternion", *map(float, x[[4, 5, 6, 3]])))

    def stamped(t, x):
        return make("geometry_msgs/msg/PoseStamped", header(t), pose(x))

    for id in history.robots:
        track = history.track(id)
        x, P = frames_of(track)
        for t, x_k, P_k in zip(track.t, x, P, strict=True):
            both = make("geometry_msgs/msg/PoseWithCovariance", pose(x_k), P_k.reshape(36))
            yield t, f"/robot_{id}/pose", make("geometry_msgs/msg/PoseWithCovarianceStamped", header(t), both)
        paths = {f"/robot_{id}/path": (track.t, x)}
        if track.known.any():
            paths[f"/truth_{id}/path"] = track.t[track.known], in_space(track.truth[track.known])
        for topic, (times, poses) in paths.items():
            message = [stamped(t, p) for t, p in zip(times, poses, strict=True)]
            yield times[0], topic, make("nav_msgs/msg/Path", header(times[0]), message)
    t = history.last.t
    yield t, "/map", make("visualization_msgs/msg/MarkerArray", [*_markers(history, T, header(t), pose)])


def _markers(history, T, header, pose):
    """A sphere, stretched to its ellipsoid, for each landmark; a small grey one for each true place."""
    Color, Vector = T["std_msgs/msg/ColorRGBA"], T["geometry_msgs/msg/Vector3"]
    Marker, still = T["visualization_msgs/msg/Marker"], T["builtin_interfaces/msg/Duration"](0, 0)
    picture = T["sensor_msgs/msg/CompressedImage"](header, "", np.zeros(0, np.uint8))
    mesh = T["visualization_msgs/msg/MeshFile"]("", np.zeros(0, np.uint8))

    def sphere(name, id, x, size, rgb):
        color = Color(*(c / 255 for c in rgb), 0.5)
        size, nothing = Vector(*map(float, size)), (still, False, [], [], "", picture, [], "", "", mesh, False)
        return Marker(header, name, int(id), 2, 0, pose(x), size, color, *nothing)

    ids, p, axes, q = ellipsoids(history)
    for id, p_i, a, q_i in zip(ids, p, axes, q, strict=True):
        yield sphere("landmarks", id, np.concatenate([p_i, q_i]), 2 * a, BLUE)
    for k, p_i in enumerate(true_points(history)):
        yield sphere("truth", k, np.array([*p_i, 1.0, 0.0, 0.0, 0.0]), [0.1, 0.1, 0.1], GREY)
