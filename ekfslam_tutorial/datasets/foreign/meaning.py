"""What the columns of a log mean: as the user says it, or by their names; and in which units they are."""

import re
from typing import Any

import numpy as np

from ...toolbox.scenario.keys import nearest

QUATERNION, ANGLES = ("qx", "qy", "qz", "qw"), ("roll", "pitch", "theta")
TWIST, STEP = ("vx", "vy", "vz", "wx", "wy", "wz"), ("dx", "dy", "dz", "dax", "day", "daz")
IMU = ("ax", "ay", "az", "wx", "wy", "wz")
POSE = ("x", "y", "z", *QUATERNION)
MEASURED = "range", "bearing", "elevation", "x", "y", "z", "px", "py", "depth", "disparity"
NOISE = {f"{m}_std": (m,) for m in MEASURED} | {f"cov_{a}{b}": (a, b) for a, b in ("xx", "xy", "yy", "xz", "yz", "zz")}
"""Columns that hold a measurement's own noise, standard deviations or a covariance, and of what."""
ROLES = {
    "odometry": tuple(
        dict.fromkeys(
            ("t", "robot", "v", "w", "steer", "x", "y", "theta", "dx", "dy", "dtheta", "left", "right")
            + (*POSE, *ANGLES, *TWIST, *STEP, *IMU)
        )
    ),
    "scan": ("t", "robot", "id", *MEASURED, *NOISE),
    "truth": ("t", "robot", "x", "y", "z", "theta", "roll", "pitch", *QUATERNION, "lat", "lon"),
    "gps": ("t", "robot", "x", "y", "z", "lat", "lon"),
    "map": ("id", "x", "y", "z", "lat", "lon"),
    "camera": ("fx", "fy", "cx", "cy", "width", "height", "d1", "d2", "d3", "d4", "d5"),
}
"""What a log can hold, and the columns of each."""
PLANE = {
    "odometry": (
        *({"v", "w"}, {"v", "steer"}, {"left", "right"}, {"dx", "dtheta"}, {"x", "y", "theta"}, {"v", "theta"}),
    ),
    "scan": ({"range", "bearing"}, {"x", "y"}),
    "truth": ({"x", "y", "theta"}, {"x", "y"}, {"lat", "lon"}),
    "gps": ({"x", "y"}, {"lat", "lon"}),
}
"""Columns that say all that is needed, the better ones first."""
SPACE = {
    "odometry": (
        *(set(TWIST), {"vx", "vy", "vz", "wz"}, set(STEP), set(POSE), {"x", "y", "z", *ANGLES}),
        *({"v", "w"}, {"v", "steer"}, {"left", "right"}, {"dx", "dtheta"}, {"x", "y", "theta"}, {"v", "theta"}),
        set(IMU),
    ),
    "scan": (
        *({"range", "bearing", "elevation"}, {"px", "py", "depth"}, {"px", "py", "disparity"}),
        *({"x", "y", "z"}, {"px", "py"}),
    ),
    "truth": (set(POSE), {"x", "y", "z", *ANGLES}, {"x", "y", "z"}, {"lat", "lon", "z"}),
    "gps": ({"x", "y", "z"}, {"lat", "lon", "z"}),
    "map": ({"id", "x", "y", "z"}, {"id", "lat", "lon", "z"}),
}
"""The same in space."""
PLANAR = ("t", "robot", "id", "v", "w", "steer", "x", "y", "theta", "dx", "dy", "dtheta", "left", "right", "lat", "lon")
LINE = "line"
"""A column of the order of lines in a file, where these begin with a word: what follows a step was seen at its end."""
OUT_OF_THE_PLANE = {"elevation", "z", "px", "py", "roll", "pitch", *QUATERNION, "vz", "dz", "dax", "ax", "az"}
"""Who names one of these columns means space."""
SETTINGS = ("from", "t_unit", "t_offset", "angle_unit", "length_unit", "base", "radius", "wheelbase", "clockwise")
SETTINGS += ("compass", "world", "frd", "steering_ratio")
SETTINGS += ("descriptor", "descriptor_std")
SETTINGS += ("position", "orientation_deg", "k", "d", "image_size", "baseline", "rectified", "gravity")
"""What can be said beside columns."""
OF_THE_SENSOR = ("max_range",)
"""Keys of a scenario that are looked for here."""
SWITCHES = {"clockwise": tuple(ROLES), "frd": tuple(ROLES), "rectified": ("scan",), "world": ("scan",)}
SWITCHES |= {"compass": ("odometry", "scan", "truth")}
"""Settings that are true or false, and the roles that have them."""
NAMES = {
    "t": "t time stamp timestamp sec secs seconds elapsed clock ms ns us msec usec nsec time_stamp unix epoch millis "
    f"utc date_time datetime seconds_since_boot {LINE}",
    "robot": "robot robot_id robot_name vehicle vehicle_id agent agent_id boat ship truck unit",
    "v": "v speed velocity vel linear lin_vel v_lin vx forward forward_speed twist.twist.linear.x twist.linear.x "
    "linear.x linear_velocity linear_velocity_x sog speed_over_ground stw "
    "speed_through_water",
    "w": "w omega om yaw_rate yawrate angular turn_rate gyro_z ang_vel wz yaw_speed gyro rotation_rate "
    "twist.twist.angular.z twist.angular.z angular.z angular_velocity.z angular_velocity angular_velocity_z",
    "steer": "steer steering steering_angle steer_angle front_wheel_angle",
    "left": "left left_speed v_left vl wheel_left left_wheel",
    "right": "right right_speed v_right vr wheel_right right_wheel",
    "dx": "dx d_x ds delta_s delta_x step distance_travelled",
    "dy": "dy d_y delta_y",
    "dtheta": "dtheta d_theta d_yaw dth dyaw delta_theta delta_yaw dheading",
    "x": "x px p_x pos_x x_pos position_x e east easting point.x position.x pose.position.x pose.pose.position.x "
    "odom_x",
    "y": "y py p_y pos_y y_pos position_y n north northing point.y position.y pose.position.y pose.pose.position.y "
    "odom_y",
    "theta": "theta th yaw heading phi orientation orientation.yaw pose.orientation.yaw pose.pose.orientation.yaw "
    "rotation.yaw hdg hdg_true hdg_mag hdt odom_yaw odom_theta odom_heading heading_true "
    "true_heading course cog course_over_ground",
    "id": "id landmark landmark_id lm lm_id beacon beacon_id tag tag_id marker marker_id barcode subject object_id "
    "track track_id anchor anchor_id ids node signature fiducial_id marker_ids name label code pillar pole target",
    "range": "range r dist distance rho ranges rng range_val",
    "bearing": "bearing true_bearing bearing_true brg brg_true brg_rel phi angle azimuth alpha beta bearings theta b "
    "heading az azimuth_angle",
    "elevation": "elevation elev inclination vertical_angle el pitch_angle",
    "depth": "depth",
    "disparity": "disparity disp",
    "px": "u pixel_x pixel_u pix_x img_x image_x u_px col column center_x centre_x bbox.center.position.x "
    "bbox.center.x centre.x center.x",
    "py": "v pixel_y pixel_v pix_y img_y image_y v_px row center_y centre_y bbox.center.position.y bbox.center.y "
    "centre.y center.y",
    "roll": "roll",
    "pitch": "pitch",
}
NAMES |= {
    "z": "z pz p_z pos_z z_pos position_z up alt altitude point.z position.z pose.position.z pose.pose.position.z "
    "translation.z p_rs_r_z tz",
    "lat": "lat latitude",
    "lon": "lon lng long longitude",
    "fx": "fx fu focal_x",
    "fy": "fy fv focal_y",
    "cx": "cx u0",
    "cy": "cy v0",
    "width": "width image_width",
    "height": "height image_height",
}
NAMES |= {f"d{i}": f"d{i}" for i in range(1, 6)}
for _a in "xyz":
    NAMES |= {
        f"v{_a}": f"v{_a} vel_{_a} velocity_{_a} v_rs_r_{_a} twist.twist.linear.{_a} twist.linear.{_a} linear.{_a} "
        f"linear_velocity_{_a}",
        f"w{_a}": f"w{_a} gyro_{_a} g{_a} omega_{_a} gyr_{_a} w_rs_s_{_a} twist.twist.angular.{_a} twist.angular.{_a} "
        f"angular.{_a} angular_velocity.{_a} angular_velocity_{_a} ang_vel_{_a}",
        f"a{_a}": f"a{_a} acc_{_a} accel_{_a} acceleration_{_a} a_rs_s_{_a} linear_acceleration.{_a} "
        f"linear_acceleration_{_a} lin_acc_{_a}",
        f"da{_a}": f"da{_a} dr{_a} r{_a} rot_{_a} drot_{_a} delta_rot_{_a}",
    }
NAMES["dz"] = "dz delta_z"
for _a in "xyzw":
    NAMES[f"q{_a}"] = (
        f"q{_a} q_{_a} quat_{_a} quaternion_{_a} q_rs_{_a} orientation.{_a} pose.orientation.{_a} "
        f"pose.pose.orientation.{_a} rotation.{_a} transform.rotation.{_a}"
    )
NAMES["x"] += " translation.x p_rs_r_x tx"
NAMES["y"] += " translation.y p_rs_r_y ty"
NAMES |= {f"{m}_std": f"{m}_std std_{m} sigma_{m} {m}_sigma" for m in MEASURED}
NAMES |= {m: m for m in NOISE if m not in NAMES}
ENDINGS = {"t": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "msec": 1e-3, "us": 1e-6, "ns": 1e-9, "nsec": 1e-9}}
ENDINGS["angle"] = {"rad": 1.0, "rads": 1.0, "deg": np.pi / 180, "degrees": np.pi / 180, "dps": np.pi / 180}
ENDINGS["length"] = {"m": 1.0, "mps": 1.0, "cm": 0.01, "mm": 1e-3, "mmps": 1e-3, "km": 1e3, "ft": 0.3048}
ENDINGS["length"] |= {"kmh": 1 / 3.6, "kph": 1 / 3.6, "mph": 0.44704, "cbl": 185.2, "nmi": 1852.0, "nm": 1852.0}
ENDINGS["length"] |= dict.fromkeys(("kn", "kt", "kts", "knot", "knots"), 1852 / 3600)
UNITS = {
    "t": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "angle": {"rad": 1.0, "deg": np.pi / 180},
    "length": {m: ENDINGS["length"][m] for m in ("m", "cm", "mm", "ft", "kmh", "kn", "cbl", "nmi")},
}
KIND: dict[str, Any] = {"t": "t"} | dict.fromkeys((*QUATERNION, "px", "py", "disparity", "ax", "ay", "az"))
KIND |= dict.fromkeys(("id", "robot", "lat", "lon"))
KIND |= dict.fromkeys(
    ("w", "steer", "dtheta", "bearing", "elevation", "wx", "wy", "wz", "dax", "day", "daz", *ANGLES), "angle"
)
"""Of the columns; lengths if not here."""
IN_LISTS = "id", "range", "bearing", "elevation", "x", "y", "z"
"""What things in a list tell: `markers.id`, `det.p_x`; not a lone x, which may be of anything."""
FLAT = 1e-3
"""Heights that differ by less are of one plane, m."""
TRUE = re.compile(
    r"truth|reference|total.?station|(^|[^a-z])(gt|true|mocap|vicon|optitrack|ground|ppk|rtk|ref(?![a-z]))",
    re.IGNORECASE,
)
MARK = re.compile(r"(^|_)(true|truth|gt)(_|$)")
"""A part of a column's name that says that it is the truth."""
DESCRIPTOR = "look "
"""What the columns of a descriptor are called, with their numbers behind."""
SURVEY = re.compile(r"map|landmark|survey|anchor|beacon", re.IGNORECASE)
GPS = re.compile(r"gps|gnss|fix", re.IGNORECASE)
LOOK = re.compile(r"scan|det|laser|lidar|obs|meas|cone|tree|point|sonar|radar|uwb|range|camera|marker|tag|land", re.I)
STEPS = re.compile(r"odo|wheel|pose_est|dead", re.IGNORECASE)


def plain(name):
    """A column's name without units, brackets and capitals; and the unit, where its ending or brackets say one."""
    word = name.strip().lower()
    unit = re.search(r"[\[(]\s*([^\])]+?)\s*[\])]$", word)
    word = re.sub(r"\s*[\[(].*[\])]$", "", word)
    word = re.sub(r"[\s-]+", "_", word)
    word = re.sub(r"_(deg|rad|grad|m|cm|mm)_s$", r"_\1", word).replace("_km_h", "_kmh")
    if unit:
        unit = re.sub(r"\s*(/s|s\^-1)$", "", unit[1].replace("°", "deg").replace("km/h", "kmh"))
        return word, unit
    stem, _, end = word.rpartition("_")
    if stem and any(end in units for units in ENDINGS.values()):
        return stem, end
    return word, {"ms": "ms", "ns": "ns", "us": "us", "millis": "ms", "msec": "ms", "nsec": "ns"}.get(word)


def find(table, meaning):
    """The column of a table that has this meaning, by its name; None if none has."""
    words = NAMES[meaning].split()
    names = {column: plain(column)[0] for column in table.columns}
    for word in words:
        for column, name in names.items():
            if name == word or ("." in word and name.endswith(f".{word}")):
                return column
    for column, name in names.items():  # of things in a list: markers.id, detections.range
        last = name.rpartition(".")[2]
        if meaning in IN_LISTS and last != name and last != meaning[-1] and last in words:
            return column
    if meaning == "t":  # in another language: Zeit_ms
        timed = [column for column in table.columns if plain(column)[1] in ENDINGS["t"]]
        return timed[0] if len(timed) == 1 else None
    return None


def true_columns(table):
    """Columns of a true pose beside others: x_true, y_true, th_true; nothing if x and y are not among them."""
    stems = {c: MARK.sub("", plain(c)[0]).strip("_") for c in table.columns if MARK.search(plain(c)[0])}
    found = {m: c for m in ROLES["truth"] for c, stem in stems.items() if stem in NAMES[m].split()}
    return found if {"x", "y"} <= set(found) else {}


def guess_role(table):
    """Guess what a table is, by the names of its columns and its own; None if it is nothing."""
    has = {meaning for meaning in NAMES if find(table, meaning)}
    if {"fx", "fy", "cx", "cy"} <= has:
        return "camera"
    on_earth = {"lat", "lon"} <= has
    placed = on_earth or {"x", "y"} <= has
    if "t" not in has and placed and ("id" in has or TRUE.search(table.name) or SURVEY.search(table.name)):
        return "map"
    if TRUE.search(table.name) and placed:
        return "truth" if has & {"theta", "qw"} else "gps"
    if placed and (GPS.search(table.name) or (on_earth and "t" in has and not has & {"v", "range"})):
        return "gps"
    if pixels(table, has) and ("id" in has or LOOK.search(table.name)):
        return "scan"
    if has & {"v", "w", "dx", "left"} or set(IMU) <= has:
        return "odometry"
    if "range" in has or {"id", "x", "y"} <= has or {"id", "bearing"} <= has:
        return "scan"
    if {"x", "y"} <= has:
        if LOOK.search(table.name) and not STEPS.search(table.name):
            return "scan"
        return "odometry" if has & {"theta", "qw"} else None
    return None


def pixels(table, has):
    """Return True if there are both coordinates of a pixel, and not those of a point or the speed of a robot."""
    return {"px", "py"} <= has and "z" not in has and "w" not in has and "range" not in has


def guess(tables, space=None):
    """A plan for these tables: {role: {"from": table, meaning: column}}, as `[convert]` in a scenario has it.

    Parameters
    ----------
    tables : list of Table
    space : bool, optional
        True in space, False in the plane; None: by what the scan measures.
    """
    candidates = {}
    for table in (table for table in tables if len(table)):
        role = guess_role(table)
        if role:
            candidates.setdefault(role, []).append(table)
    if "scan" not in candidates:  # all in one table
        both = [table for table in candidates.get("odometry", ()) if find(table, "range")]
        candidates |= {"scan": both} if both else {}
    if "truth" not in candidates:
        marked = [table for table in tables if len(table) and true_columns(table) and find(table, "t")]
        candidates |= {"truth": marked} if marked else {}
    if "gps" not in candidates:  # a receiver's columns beside others
        on_earth = [table for table in tables if len(table) and all(find(table, m) for m in ("t", "lat", "lon"))]
        candidates |= {"gps": on_earth} if on_earth else {}
    if space is None:
        space = any(
            out_of_the_plane(table, columns_of(table, "scan", True)) for table in candidates.get("scan", ())[:1]
        )
    plan = {}
    for role, some in candidates.items():
        table = max(some, key=lambda table: _worth(table, role, space))  # of the same worth, the first
        true = true_columns(table) if role == "truth" else {}
        whose = {m: c for m in ("t", "robot") if (c := find(table, m))}
        true = whose | true if true else columns_of(table, role, space)
        plan[role] = {"from": table.name} | true
    return plan


def _worth(table, role, space):
    """Rank of a table by what a role needs: the number of its way, from the end; 0 if it has none whole."""
    ways = (SPACE if space else PLANE).get(role, ())
    found = {m for m in ROLES[role] if find(table, m)}
    return max((len(ways) - k for k, way in enumerate(ways) if way <= found and alive(table, way)), default=0)


def out_of_the_plane(table, entry):
    """Return True if a scan with these columns measures in space: elevations, pixels, or heights that differ."""
    if {"elevation", "px"} & set(entry):
        return True
    z = table.columns[entry["z"]] if "z" in entry else np.zeros(1)
    z = z[np.isfinite(z)]
    return bool(z.size and np.ptp(z) > FLAT)


def alive(table, way):
    """Return True if some of these columns is not always zero: messages have fields that nobody fills in."""
    columns = [table.columns[find(table, m)] for m in way if m not in ("t", "id", "qw")]
    return any((np.nan_to_num(c) != 0).any() for c in columns)


def columns_of(table, role, space=False):
    """Columns by meaning, as far as names tell: the first way to say it that is whole."""
    found = {m: c for m in ROLES[role] if (c := find(table, m))}
    if {"x", "y"} <= set(found):
        found = {m: c for m, c in found.items() if m not in ("lat", "lon")}
    ways = [way for way in (SPACE if space else PLANE).get(role, ()) if way <= set(found)]
    if role == "scan" and not pixels(table, set(found)):
        ways = [way for way in ways if "px" not in way]
    if role == "odometry" or (space and role != "camera"):
        for way in [way for way in ways if alive(table, way)] or ways:
            return {
                m: c
                for m, c in found.items()
                if m in way | {"t", "id", "robot"} or (m == "dy" and "dx" in way) or set(NOISE.get(m, "?")) <= way
            }
    if role == "scan":
        kept = {"t", "id", "robot", "bearing"} | ({"range"} if "range" in found else {"x", "y"})
        return {m: c for m, c in found.items() if m in kept or set(NOISE.get(m, "?")) <= kept}
    if not space and role in ("odometry", "truth", "gps", "map"):
        return {m: c for m, c in found.items() if m in PLANAR}
    return found


def _only_table(entry, role, tables):
    """The name of the only table that has all columns of an entry; None if there is another one."""
    named = {str(c) for m, c in entry.items() if m in ROLES.get(role, ()) and c is not False}
    having = [table.name for table in tables if named <= set(table.columns)]
    return having[0] if len(having) == 1 and (named or len(tables) == 1) else None


def checked(plan, tables):
    """Check a plan against the tables; return it with `from` everywhere.

    Raises
    ------
    ValueError
        One sentence with what was said and what is possible.
    """
    if not isinstance(plan, dict):
        raise ValueError("[convert] must be a table of odometry, scan, truth, gps, map and camera")
    _check_misplaced(plan)
    by_name, done = {table.name: table for table in tables}, {}
    for role, entry in plan.items():
        if role not in ROLES:
            raise ValueError(f"[convert] has no {role!r}; possible: {', '.join(ROLES)}{nearest(role, ROLES)}")
        if entry is False:  # not this one
            continue
        if not isinstance(entry, dict):
            raise ValueError(f"[convert.{role}] must be a table, or false to leave it out, got {entry!r}")
        name = entry.get("from") or _only_table(entry, role, tables)
        if name is None:
            raise ValueError(f"{role}: from which table? from = one of {', '.join(by_name)}")
        if name not in by_name:
            hint = nearest(str(name), by_name)
            raise ValueError(f"{role}: the log has no {name!r}; there are {', '.join(by_name)}{hint}")
        entry = {"from": name} | {k: str(v) if k in ROLES[role] else v for k, v in entry.items()}
        for key, value in entry.items():
            if key not in ROLES[role] and key not in SETTINGS:
                known = (*ROLES[role], *SETTINGS)
                raise ValueError(f"{role}: no key {key!r}; possible are {', '.join(known)}{nearest(key, known)}")
            if (key in NOISE or key == "id") and value == str(False):  # not this one
                continue
            if key in SWITCHES and (role not in SWITCHES[key] or not isinstance(value, bool)):
                roles = " and ".join(SWITCHES[key])
                raise ValueError(f"{role}: {key} is true or false, of {roles}, got {value!r}")
            if key in ROLES[role] and value not in by_name[name].columns:
                there, hint = ", ".join(by_name[name].columns), nearest(value, by_name[name].columns)
                raise ValueError(f"{role}: {name} has no column {value!r}; there are {there}{hint}")
            kind = key.removesuffix("_unit")
            if key.endswith("_unit") and value not in UNITS[kind]:
                raise ValueError(f"{role}: {key} must be one of {', '.join(UNITS[kind])}, got {value!r}")
        if "descriptor" in entry:
            entry["descriptor"] = _first_and_last(entry["descriptor"], by_name[name])
        done[role] = entry
    return done


def _check_misplaced(plan):
    """Refuse keys of the scenario, with the words that would be right."""
    if "sensor" in plan:
        raise ValueError(
            f"sensor is a part of the scenario, and {', '.join(ROLES)} are those of a log: "
            "ekfslam run ... --set sensor.1.KEY=VALUE"
        )
    for role, entry in plan.items():
        for key in set(OF_THE_SENSOR) & set(entry if isinstance(entry, dict) else ()):
            raise ValueError(
                f"{role}: {key} is no word about columns but a key of the scenario: "
                f"ekfslam run ... --set sensor.1.{key}={entry[key]}"
            )


def _first_and_last(told, table):
    """The first and the last column of a descriptor, checked."""
    columns = [*table.columns]
    if not isinstance(told, list) or len(told) != 2 or not {*map(str, told)} <= {*columns}:
        raise ValueError(
            f"scan: descriptor must be its first and its last column, [4, 13], got {told!r}; there are "
            + ", ".join(columns)
        )
    first, last = (columns.index(str(name)) for name in told)
    if first > last:
        raise ValueError(f"scan: descriptor: column {told[0]} comes after column {told[1]}")
    return [columns[first], columns[last]]
