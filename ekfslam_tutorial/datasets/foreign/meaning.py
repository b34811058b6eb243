"""What the columns of a log mean: as the user says it, or by their names; and in which units they are."""

import re

import numpy as np

from ...toolbox.scenario.keys import nearest

ROLES = {
    "odometry": ("t", "v", "w", "x", "y", "theta", "dx", "dy", "dtheta", "left", "right"),
    "scan": ("t", "id", "range", "bearing", "x", "y"),
    "truth": ("t", "x", "y", "theta"),
    "gps": ("t", "x", "y"),
    "map": ("id", "x", "y"),
}
"""What a log can hold, and the columns of each."""
WAYS = {
    "odometry": ({"v", "w"}, {"left", "right"}, {"dx", "dtheta"}, {"x", "y", "theta"}),
    "scan": ({"range", "bearing"}, {"x", "y"}),
}
"""Columns that say all that is needed."""
SETTINGS = ("from", "t_unit", "t_offset", "angle_unit", "length_unit", "base", "clockwise")
"""What can be said beside columns."""
NAMES = {
    "t": "t time stamp timestamp sec secs seconds elapsed clock ms ns us msec usec nsec time_stamp unix epoch millis",
    "v": "v speed velocity vel linear lin_vel v_lin vx forward forward_speed twist.twist.linear.x twist.linear.x "
    "linear.x linear_velocity linear_velocity_x",
    "w": "w omega yaw_rate yawrate angular turn_rate gyro_z ang_vel wz yaw_speed gyro rotation_rate "
    "twist.twist.angular.z twist.angular.z angular.z angular_velocity.z angular_velocity angular_velocity_z",
    "left": "left left_speed v_left vl wheel_left left_wheel",
    "right": "right right_speed v_right vr wheel_right right_wheel",
    "dx": "dx ds delta_s delta_x step distance_travelled",
    "dy": "dy delta_y",
    "dtheta": "dtheta dth dyaw delta_theta delta_yaw dheading",
    "x": "x px pos_x x_pos position_x east easting point.x position.x pose.position.x pose.pose.position.x",
    "y": "y py pos_y y_pos position_y north northing point.y position.y pose.position.y pose.pose.position.y",
    "theta": "theta th yaw heading phi orientation orientation.yaw pose.orientation.yaw pose.pose.orientation.yaw "
    "rotation.yaw",
    "id": "id landmark landmark_id lm lm_id beacon beacon_id tag tag_id marker marker_id barcode subject object_id "
    "track track_id anchor anchor_id ids node",
    "range": "range r dist distance rho ranges rng range_val",
    "bearing": "bearing brg phi angle azimuth alpha beta bearings theta",
}
ENDINGS = {"t": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "msec": 1e-3, "us": 1e-6, "ns": 1e-9, "nsec": 1e-9}}
ENDINGS["angle"] = {"rad": 1.0, "rads": 1.0, "deg": np.pi / 180, "degrees": np.pi / 180, "dps": np.pi / 180}
ENDINGS["length"] = {"m": 1.0, "mps": 1.0, "cm": 0.01, "mm": 1e-3, "mmps": 1e-3, "km": 1e3, "ft": 0.3048}
ENDINGS["length"] |= {"kmh": 1 / 3.6, "kph": 1 / 3.6, "mph": 0.44704}
UNITS = {
    "t": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "angle": {"rad": 1.0, "deg": np.pi / 180},
    "length": {"m": 1.0, "cm": 0.01, "mm": 1e-3, "ft": 0.3048},
}
KIND = {"t": "t", "id": None, "w": "angle", "theta": "angle", "dtheta": "angle", "bearing": "angle"}
"""Of the columns; lengths if not here."""
TRUE = re.compile(r"truth|(^|[^a-z])(gt|true|mocap|vicon|ground)", re.IGNORECASE)
GPS = re.compile(r"gps|gnss|fix", re.IGNORECASE)
LOOK = re.compile(r"scan|det|laser|lidar|obs|meas|cone|tree|point|sonar|radar|uwb|range|camera|marker|tag|land", re.I)
STEPS = re.compile(r"odo|wheel|pose_est|dead", re.IGNORECASE)


def plain(name):
    """A column's name without units, brackets and capitals; and the unit, where its ending or brackets say one."""
    word = name.strip().lower()
    unit = re.search(r"[\[(]\s*([^\])]+?)\s*[\])]$", word)
    word = re.sub(r"\s*[\[(].*[\])]$", "", word)
    word = re.sub(r"[\s-]+", "_", word)
    if unit:
        return word, unit[1].replace("°", "deg").removesuffix("/s").replace("km/h", "kmh")
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
        if meaning in ("id", "range", "bearing") and "." in name and name.rpartition(".")[2] in words:
            return column
    return None


def guess_role(table):
    """What a table may be, by the names of its columns and its own; None if it is nothing."""
    has = {meaning for meaning in NAMES if find(table, meaning)}
    if "t" not in has and {"id", "x", "y"} <= has:
        return "map"
    if TRUE.search(table.name) and {"x", "y"} <= has:
        return "truth" if "theta" in has else "gps"
    if GPS.search(table.name) and {"x", "y"} <= has:
        return "gps"
    if has & {"v", "w", "dx", "left"}:
        return "odometry"
    if "range" in has or {"id", "x", "y"} <= has or {"id", "bearing"} <= has:
        return "scan"
    if {"x", "y"} <= has:
        if LOOK.search(table.name) and not STEPS.search(table.name):
            return "scan"
        return "odometry" if "theta" in has else None
    return None


def guess(tables):
    """A plan for these tables: {role: {"from": table, meaning: column}}, as `[convert]` in a scenario has it."""
    plan = {}
    for table in (table for table in tables if len(table)):
        role = guess_role(table)
        if role and role not in plan:
            plan[role] = {"from": table.name} | columns_of(table, role)
    for table in tables:  # all in one table
        both = "odometry" in plan and plan["odometry"]["from"] == table.name and find(table, "range")
        if both and "scan" not in plan:
            plan["scan"] = {"from": table.name} | columns_of(table, "scan")
    return plan


def columns_of(table, role):
    """Columns by meaning, as far as names tell: the first way to say it that is whole."""
    found = {m: c for m in ROLES[role] if (c := find(table, m))}
    if role == "scan":
        found = {m: c for m, c in found.items() if m in ("t", "id", "range", "bearing")} if "range" in found else found
    if role == "odometry":
        for way in WAYS[role]:
            if way <= set(found):
                return {m: c for m, c in found.items() if m in way | {"t"} or (m == "dy" and "dx" in way)}
    return found


def checked(plan, tables):
    """Check a plan against the tables; return it with `from` everywhere.

    Raises
    ------
    ValueError
        One sentence with what was said and what is possible.
    """
    if not isinstance(plan, dict):
        raise ValueError("[convert] must be a table of odometry, scan, truth, gps and map")
    by_name, done = {table.name: table for table in tables}, {}
    for role, entry in plan.items():
        if role not in ROLES:
            raise ValueError(f"[convert] has no {role!r}; possible: {', '.join(ROLES)}{nearest(role, ROLES)}")
        if entry is False:  # not this one
            continue
        if not isinstance(entry, dict):
            raise ValueError(f"[convert.{role}] must be a table, or false to leave it out, got {entry!r}")
        name = entry.get("from") or (tables[0].name if len(tables) == 1 else None)
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
            if key in ROLES[role] and value not in by_name[name].columns:
                there, hint = ", ".join(by_name[name].columns), nearest(value, by_name[name].columns)
                raise ValueError(f"{role}: {name} has no column {value!r}; there are {there}{hint}")
            kind = key.removesuffix("_unit")
            if key.endswith("_unit") and value not in UNITS[kind]:
                raise ValueError(f"{role}: {key} must be one of {', '.join(UNITS[kind])}, got {value!r}")
        done[role] = entry
    return done
