"""What a log holds, by role and meaning: columns in SI units and radians, sorted by time, and words on them."""

import numpy as np

from ...geometry import Frame3
from . import looks
from .earth import to_metres
from .fleet import of_robot
from .heading import from_the_bow, heading_at
from .meaning import DESCRIPTOR, MARK, NAMES, ROLES, plain

APART = 1e5
"""Times of two tables that are so many seconds apart are in different time bases."""
IN_G = 0.5, 2.0
"""Accelerations whose usual size is in between are multiples of the earth's."""
G = 9.80665
FROM_NORTH = "bearing", "theta"
"""What a compass counts from the north to the right: it becomes an angle from the x axis, which is to the east."""
CLOCKWISE = "bearing", "theta", "w", "steer", "dtheta", "wz", "daz"
FRD = "vy", "vz", "wy", "wz", "dy", "dz", "day", "daz", "ay", "az", "w", "dtheta"
"""What changes its sign where the robot's y is to the right and its z down, as pilots count."""
AGREE = 0.5
"""Headings go with a path if the mean of exp(i difference) is so long."""
TO_THE_RIGHT = "y", "cov_xy", "cov_yz"
"""What changes its sign, too, in a scan of points."""


class Log:
    """Columns by role and meaning, in SI units and radians, sorted by time; `said` has words on them.

    Parameters
    ----------
    plan : dict
        Checked and completed.
    tables : dict of str to Table
    space : bool
        True in space, False in the plane.
    robot : dict of str to float
        By role: the number of the robot whose log it is, if there are several. Units are those of all of them.
    origin : (float, float), optional
        Latitude and longitude of where x and y are zero.
    """

    def __init__(self, plan, tables, space, robot=(), origin=None):
        plan, own = of_robot(plan, tables, dict(robot))
        self.plan, self.space, self.said, self.notes, self.parts, self.origin = plan, space, [], [], {}, origin
        self.frames = {role: tables[entry["from"]].frame for role, entry in plan.items()}
        self.mounts = {child: where for table in tables.values() for child, where in table.mounts.items()}
        degrees, of_time = False, None
        for role in sorted(plan, key=list(ROLES).index):
            entry, table = plan[role], tables[plan[role]["from"]]
            alike = self._alike(entry, table, of_time)
            units = looks.units(entry, table, alike, degrees)
            degrees = degrees or any("deg" in words for m, (_, words) in units.items() if m in ("bearing", "theta"))
            if role == "odometry" and "t" in entry:
                of_time = units["t"][1].partition(",")[0], table.columns[entry["t"]]
            self.parts[role] = self._read(role, entry, own[role], units)
        if degrees and "odometry" in plan and "angle_unit" not in plan["odometry"]:  # bearings tell of turn rates
            entry, table = plan["odometry"], tables[plan["odometry"]["from"]]
            again = looks.units(entry, table, None, True)
            if again != looks.units(entry, table):
                self.said = [line for line in self.said if not line.startswith("odometry")]
                self.notes = [line for line in self.notes if not line.startswith("odometry")]
                self.parts["odometry"] = self._read("odometry", entry, own["odometry"], again)
        self._check_times()
        self._turn_scan()

    @staticmethod
    def _alike(entry, table, of_time):
        """The unit of the odometry's times, if those of this table are of the same size."""
        if of_time is None or "t" not in entry:
            return None
        mine, other = (np.nanmedian(np.abs(a)) for a in (table.columns[entry["t"]], of_time[1]))
        return of_time[0] if 0.1 < mine / max(other, 1e-12) < 10 else None

    @staticmethod
    def _columns(role, entry, table, units):
        """Columns by meaning, in SI units and radians."""
        part = {m: table.columns[c] for m, c in entry.items() if m in NAMES}
        if "t" in part:
            t = part["t"] * units["t"][0] + float(entry.get("t_offset", 0.0))
            part["t"] = np.round(t, 6)  # what is measured at one time has one time, whatever was added
        part |= {m: part[m] * factor for m, (factor, _) in units.items() if m != "t"}
        if entry.get("compass"):
            part |= {m: np.pi / 2 - part[m] for m in FROM_NORTH if m in part}
        if entry.get("clockwise"):
            flipped = (*CLOCKWISE, *(TO_THE_RIGHT if role == "scan" else ()))
            part |= {m: -part[m] for m in flipped if m in part}
        if entry.get("frd"):
            part |= {m: -part[m] for m in FRD if m in part}
        if "descriptor" in entry:
            columns = [*table.columns]
            first, last = map(columns.index, entry["descriptor"])
            part |= {f"{DESCRIPTOR}{c}": table.columns[c] for c in columns[first : last + 1]}
        return part

    def _read(self, role, entry, table, units):
        part = self._columns(role, entry, table, units)
        needed = [m for m in part if m != "id" or role == "map"]
        whole = np.all([np.isfinite(part[m]) for m in needed], axis=0)
        part = {m: a[whole] for m, a in part.items()}
        lost = int((~whole).sum())
        if not whole.any():
            raise ValueError(f"{role}: no row of {entry['from']} has a number in each of {', '.join(needed)}")
        named = [f"{m} = {entry[m]}" for m in part if m in entry]
        named += [f"descriptor = {' to '.join(entry['descriptor'])}"] if "descriptor" in entry else []
        words = [f"{role}: {', '.join(named)} of {entry['from']}"]
        same = {}  # one line for columns of which the same is said
        for m, (_, text) in units.items():
            same.setdefault(text, []).append(m)
        words += [f"  {', '.join(ms)}: {text}" for text, ms in same.items()]
        words += self._in_g(part)
        if lost:
            words.append(f"  {lost:,} of {len(whole):,} rows have no number in one of them and are left out")
        part = self._once(role, entry, part, words)
        if "t" in part:
            part = self._in_time(role, part, words)
        if "lat" in part:
            part, self.origin = to_metres(part, self.origin)
            place = f"{self.origin[0]:.7f}, {self.origin[1]:.7f}"
            words.append(
                f"  lat, lon: degrees on the ellipsoid WGS 84; x is metres to the east of {place}, y to the north"
            )
        if role == "truth" and {"x", "y", "theta"} <= set(part) and not {"clockwise", "compass"} & set(entry):
            words += self._from_north(part, words)
        if {"x", "y"} <= set(part) and role in ("odometry", "truth", "gps"):
            jump = looks.jumps(np.column_stack([part[m] for m in ("x", "y", "z") if m in part]))
            words += [f"  {jump}"] if jump else []
        if role == "odometry" and {"v", "theta"} <= set(part) and not {"compass", "clockwise"} & set(entry):
            words.append("  theta counts to the left; if from the north to the right: --set odometry.compass=true")
        if role == "scan":
            words.append(f"  {looks.ids(part.get('id', np.zeros(0)))}")
            if "bearing" in entry and MARK.search(plain(entry["bearing"])[0]) and not {"compass", "world"} & set(entry):
                words.append("  is the bearing one from the north, not from the bow? --set scan.compass=true")
        self.said += words
        return part

    def _once(self, role, entry, part, words):
        """Leave out rows that are copies of another one, which a filter would take for news; words on it."""
        if role == "camera":
            return part
        rows = np.nan_to_num(np.column_stack(list(part.values())), nan=-1.0)  # an id may be unknown
        first = np.sort(np.unique(rows, axis=0, return_index=True)[1])
        copies = len(rows) - len(first)
        if not copies:
            return part
        verb = "is a copy" if copies == 1 else "are copies"
        note = (
            f"{copies:,} of {len(rows):,} rows of {entry['from']} {verb} of another one (the same {', '.join(part)}) "
            "and left out: what is told twice is not known better"
        )
        words.append(f"  {note}")
        self.notes.append(f"{role}: {note}")
        return {m: a[first] for m, a in part.items()}

    @staticmethod
    def _from_north(part, words):
        """Turn headings that are counted from the north to the right, if only so they go with the path; words on it."""
        way = np.diff(part["x"]) + 1j * np.diff(part["y"])
        if not np.abs(way).any():
            return []
        share = np.abs(way) / np.abs(way).sum()
        goes = lambda theta: abs(np.sum(share * np.exp(1j * (np.angle(way) - theta[:-1]))))
        north = np.pi / 2 - part["theta"]
        if goes(part["theta"]) > AGREE or goes(north) < AGREE:
            return []
        part["theta"] = north
        words[:] = [line.partition("; they do not go")[0] for line in words]
        return ["  theta: from the north to the right, as the path goes; truth.clockwise says otherwise"]

    @staticmethod
    def _in_time(role, part, words):
        """Put rows in the order of their times; words on these."""
        back = int((np.diff(part["t"]) < 0).sum())
        order = np.argsort(part["t"], kind="stable")
        part = {m: a[order] for m, a in part.items()}
        words.append(f"  {looks.rate(part['t'])}")
        if back:
            words.append(f"  times go back {back} time{'s' * (back > 1)}: rows are put in order")
        twice = len(part["t"]) - len(np.unique(part["t"]))
        if twice and role == "odometry":
            words.append(f"  {twice:,} rows have the time of another one and are left out; were times rounded?")
            first = np.unique(part["t"], return_index=True)[1]
            part = {m: a[first] for m, a in part.items()}
        return part

    @staticmethod
    def _in_g(part):
        """Put accelerations into m/s^2; words on their size."""
        if "ax" not in part:
            return []
        size = float(np.median(np.sqrt(sum(part[m] ** 2 for m in ("ax", "ay", "az")))))
        if IN_G[0] < size < IN_G[1]:
            part |= {m: G * part[m] for m in ("ax", "ay", "az")}
            return [f"  ax, ay, az: of the size {size:.3g}, so they are in g; times {G}"]
        return [f"  ax, ay, az: m/s^2, of the size {size:.3g}; the earth's is 9.81"]

    def _check_times(self):
        if "odometry" not in self.parts:
            return
        begin = {role: float(part["t"][0]) for role, part in self.parts.items() if "t" in part}
        end = {role: float(part["t"][-1]) for role, part in self.parts.items() if "t" in part}
        for role in begin:
            if role == "odometry" or (begin[role] <= end["odometry"] and end[role] >= begin["odometry"]):
                continue
            spans = [f"{begin[r]:.10g} to {end[r]:.10g} s" for r in ("odometry", role)]
            other = abs(begin[role] - begin["odometry"]) > APART
            why = "they are in different time bases" if other else "they do not meet"
            raise ValueError(
                f"odometry lasts from {spans[0]}, {role} from {spans[1]}: {why}; --set {role}.t_unit=ms, or "
                f"--set {role}.t_offset={begin['odometry'] - begin[role]:.6f} (s), puts them together "
                "if both began at once"
            )

    def _turn_scan(self):
        """Turn what was seen along the axes of the world by the heading at its time.

        Raises
        ------
        ValueError
            The odometry has no heading, or one that counts from elsewhere.
        """
        entry, odo = self.plan["scan"], self.parts.get("odometry", {})
        if not (entry.get("compass") or entry.get("world")):
            return
        word = "compass" if entry.get("compass") else "world"
        if "theta" not in odo:
            raise ValueError(
                f"scan: {word} = true turns what was seen by the heading of the odometry, and it has none: "
                "--set odometry.theta=COLUMN"
            )
        told = self.plan["odometry"]
        if entry.get("compass") and told.get("clockwise"):
            raise ValueError("odometry: clockwise does not say where zero is; --set odometry.compass=true: the north")
        scan = self.parts["scan"]
        outside = (scan["t"] < odo["t"][0]) | (scan["t"] > odo["t"][-1])
        scan = {m: a[~outside] for m, a in scan.items()}
        self.parts["scan"] = from_the_bow(scan, heading_at(odo, scan["t"]))
        words = f"scan: turned by the heading at its time, theta = {told['theta']} of the odometry: {word} = true"
        lost = f"; {outside.sum():,} rows are outside the times of the heading and are left out"
        self.said.append(words + lost * bool(outside.any()))

    def mount(self):
        """Pose [t; q] of the sensor on the robot by /tf_static; None if that does not say it."""
        if not self.mounts:
            return None
        chains = []
        for role in "odometry", "scan":
            name = self.frames.get(role, "")
            chain: dict = {name: Frame3(np.array([0.0, 0, 0, 1, 0, 0, 0]))}
            while name in self.mounts:  # from the frame to what carries it, to what carries that
                parent, pose = self.mounts[name]
                if parent in chain:
                    break
                F, _ = Frame3(pose).normalized()
                chain[parent] = F.compose(chain[name])[0]
                name = parent
            chains.append(chain)
        for name, F in chains[0].items():
            if name in chains[1]:
                return F.inverse()[0].compose(chains[1][name])[0].x
        return None

    @property
    def t0(self):
        """Time at which the robot starts: one step of the odometry before the first of its messages, s."""
        first = float(self.parts["scan"]["t"][0])
        if "odometry" not in self.parts:
            return first
        t = np.unique(self.parts["odometry"]["t"])
        step = float(np.median(np.diff(t))) if len(t) > 1 else 0.1
        return min(float(t[0]), first) - step
