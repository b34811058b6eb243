"""Project 19: drive the park with a filter of one's own: the truck, the scans and the upkeep of the map."""

from dataclasses import replace
from functools import cache

import numpy as np

from ...datasets import victoria_park_twin
from ...geometry import wrap
from ...slam import NearestNeighbour
from ...toolbox import universal_slam
from .. import asks
from ..exercises.nb19_drive import drive
from ..exercises.nb19_gps import gps_error
from ..exercises.nb19_manage import manage
from ..exercises.nb19_scan import sort_scan
from ..logs.nb19 import TWIN, here, recording
from ..project import Project, Symptom, scores

EVERY = 10  # frames between two that are drawn: a scan has a tenth of a second

SCENARIO = """
name = "the park"
time = {last = 600}
robot = [{id = 1, motion = "vehicle", position = [-68.3, -40.6], orientation_deg = 36.6}]
landmark = {type = "euc_pnt"}

[[sensor]]
id = 1
robot = 1
type = "range_bearing"
range_std = 0.15
bearing_std_deg = 0.7
max_range = 40.0
fov_deg = 180.0
"""

START = SCENARIO[: SCENARIO.index("[[sensor]]")] + (
    "# Here: the laser. It sees 180 degrees and 40 m; a range is good to about 0.15 m, a bearing to about 0.7 degrees.\n"
)


def expected(x, P, R):
    """What the laser should see of n trees: e (n, 2), E_r (n, 2, 3), E_l (n, 2, 2), Z (n, 2, 2); which are in view."""
    d = x[3:].reshape(-1, 2) - x[:2]
    r, n = np.hypot(*d.T), len(d)
    e = np.column_stack([r, wrap(np.arctan2(d[:, 1], d[:, 0]) - x[2])])
    E_l = np.stack([d / r[:, None], np.column_stack([-d[:, 1], d[:, 0]]) / r[:, None] ** 2], 1)
    E_r = np.concatenate([-E_l, np.tile([[0.0], [-1.0]], (n, 1, 1))], 2)
    rows = 3 + np.arange(2 * n).reshape(n, 2)
    P_rl, P_ll = P[:3, 3:].reshape(3, n, 2).swapaxes(0, 1), P[rows[:, :, None], rows[:, None, :]]
    H, T = np.concatenate([E_r, E_l], 2), np.swapaxes
    B = np.block([[np.tile(P[:3, :3], (n, 1, 1)), P_rl], [T(P_rl, 1, 2), P_ll]])
    return e, E_r, E_l, H @ B @ T(H, 1, 2) + R, (r < 40) & (np.abs(e[:, 1]) < np.pi / 2)


def loop(world):
    """The truck in the park: yield the map after each frame.

    world.x, shape (3,), and world.P, shape (3, 3), are the pose of the laser before the first frame; `for now in world`
    goes through the scans. now.u[1] = [v, alpha, slip] is the control, slip is 0, and now.U[1], shape (3, 3), its
    covariance; now.dt the time: five small steps of `drive` are better than one long one. Slip moves the truck
    sideways, by v dt slip. now.seen[1] is a list of pairs (-1, [range, bearing]): detections without a name.
    world.sens[0].model.R is their noise. Gates: 9.2 and 25. A tree begins with the counts searched = found = 1, and
    goes if it was looked for 10 times and found in less than 20 % of them.
    Yield x, P, lmks after each frame: the whole map, the pose first, and a dictionary id: slice, with ids of your own.
    """
    car, R = (2.83, 0.76, 3.78, 0.50), world.sens[0].model.R
    x, P, ids = world.x, world.P, []
    searched = found = np.zeros(0)
    for now in world:
        A, B = np.eye(3), np.zeros((3, 2))
        for _ in range(5):
            x[:3], X_x, X_u = drive(x[:3], now.u[1][:2], now.dt / 5, car)
            A, B = X_x @ A, X_x @ B + X_u
        sideways = now.u[1][0] * now.dt * np.array([-np.sin(x[2]), np.cos(x[2]), 0.0])
        B = np.column_stack([B, sideways])
        P[:3] = A @ P[:3]
        P[:, :3] = P[:, :3] @ A.T
        P[:3, :3] += B @ now.U[1] @ B.T

        y = np.array([y for _, y in now.seen[1]]).reshape(-1, 2)
        e, E_r, E_l, Z, visible = expected(x, P, R)
        z = y[:, None] - e
        z[..., 1] = wrap(z[..., 1])
        j = sort_scan(np.einsum("knj,njl,knl->kn", z, np.linalg.inv(Z), z), 9.2, 25.0).astype(int)
        used = np.flatnonzero(j >= 0)
        if len(used):
            H = np.zeros((2 * len(used), len(x)))
            for i, k in enumerate(used):
                H[2 * i : 2 * i + 2, :3] = E_r[j[k]]
                H[2 * i : 2 * i + 2, 3 + 2 * j[k] : 5 + 2 * j[k]] = E_l[j[k]]
            Z = H @ P @ H.T + np.kron(np.eye(len(used)), R)
            K = np.linalg.solve(Z, H @ P).T
            x, P = x + K @ z[used, j[used]].ravel(), P - K @ Z @ K.T
            P = (P + P.T) / 2  # so that rounding does not grow
        matched = np.isin(np.arange(len(ids)), j)
        searched, found, gone = manage(searched, found, visible | matched, matched, 10, 0.2)

        for range_, bearing in y[j == -1]:
            u = np.array([np.cos(x[2] + bearing), np.sin(x[2] + bearing)])
            v = np.array([-u[1], u[0]])
            L_r, L_y = np.column_stack([np.eye(2), range_ * v]), np.column_stack([u, range_ * v])
            P_lx = L_r @ P[:3]
            x = np.append(x, x[:2] + range_ * u)
            P = np.block([[P, P_lx.T], [P_lx, P_lx[:, :3] @ L_r.T + L_y @ R @ L_y.T]])
            ids, searched, found = [*ids, max(ids, default=0) + 1], np.append(searched, 1), np.append(found, 1)
        gone = np.array(gone, int)
        rows = 3 + np.concatenate([2 * gone, 2 * gone + 1])
        x, P = np.delete(x, rows), np.delete(np.delete(P, rows, 0), rows, 1)
        ids, searched, found = (np.delete(a, gone) for a in (np.array(ids, int), searched, found))
        ids = ids.tolist()
        yield x, P, {id: slice(3 + 2 * i, 5 + 2 * i) for i, id in enumerate(ids)}


@cache
def log():
    """The real log where it is, else its twin, which knows the true poses."""
    which = here()
    rec = recording(which)
    if which != TWIN:
        return rec
    return replace(rec, truth={1: victoria_park_twin.simulate()[1].poses})


@cache
def by_the_package(laser, last):
    """What `row` keeps of each of the first scans, of the package, with a laser of these standard deviations (m, rad)."""
    data = PROJECT.read(SCENARIO)
    model = replace(data.sensors[0].model, range_std=laser[0], bearing_std=laser[1])
    data = replace(data, sensors=[replace(data.sensors[0], model=model)])
    rules = NearestNeighbour(confidence=0.99, new_confidence=0.999996)
    options = replace(data.options, association=rules, joint=True, compressed=True, min_search=10, min_match_ratio=0.2)
    rows = []
    for now in universal_slam(replace(data, options=options, time=replace(data.time, last=last)), log()):
        map, r = now.map, now.robs[0].r
        rows.append(row(now.t, map.state(r), map.variances(r), [map.variances(lmk.r) for lmk in now.lmks.values()]))
    return np.array(rows)


def noise_of(data):
    """Standard deviations of the laser's range and bearing."""
    return tuple(np.sqrt(np.diag(data.sensors[0].model.R)).round(9).tolist())


def row(t, pose, variances, of_trees):
    """What is kept of a scan: time, x, y, trees, sigma of the position, and median sigma of the trees (m)."""
    sigmas = [np.sqrt(v[:2].sum()) for v in (variances, *of_trees)]
    return [t, *pose[:2], len(of_trees), sigmas[0], np.median(sigmas[1:]) if of_trees else np.nan]


def figures(rows):
    """Trees in the mean, distance to GPS (m) without the worst 5 %, and the two sigmas in the last third (m)."""
    _, gps = gps_error(rows[:, 0], rows[:, 1:3], log().fixes[1], 0.95)
    rms = np.sqrt(np.nanmean(rows[-max(len(rows) // 3, 1) :, 4:] ** 2, 0))
    return float(rows[:, 3].mean()), gps, *map(float, rms)


class Park(Project):
    """A project on a log without a truth: runs are compared with GPS, and with the package's run on the same scans."""

    beside_reference = False
    remark = (
        "Detections have no names, so the picture cannot show which were used: all that is expected is `predicted`."
    )

    def read(self, scenario):
        """Return the `UserData` of a text; detections without a name want a rule that needs none."""
        data = super().read(scenario)
        return replace(data, options=replace(data.options, association=NearestNeighbour()))

    def trial(self, run, seed, watch=None):
        """Run the loop; keep its path, and draw some of the frames."""
        rows = []

        def keep(world, before, estimate):
            """Note where the estimate is."""
            variances = np.diag(estimate.P)
            rows.append(row(world._t, estimate.x, variances, [variances[r] for r in estimate.lmks.values()]))
            if watch is not None and (world.k % EVERY == 0 or world.k == len(world)):
                watch(world, before, estimate)

        trial = super().trial(run, seed, keep)
        trial.path, trial.noise = np.array(rows).reshape(-1, 6), noise_of(run.data)
        return trial

    def measured(self, trials, reference=None):
        """What the sentences of the verdict are about."""
        (trial,) = trials
        theirs = figures(by_the_package(noise_of(self.read(SCENARIO)), len(trial.path)))[:2]
        sigmas = figures(by_the_package(trial.noise, len(trial.path)))[2:]  # with the same laser
        return _Measured(figures(trial.path), (*theirs, *sigmas), scores([trial]) if trial.errors else None, trial)

    def summary(self, trials):
        """One line on a run."""
        (trial,) = trials
        if trial is None or trial.failed or not len(getattr(trial, "path", ())):
            return "no result"
        s = self.measured(trials)
        honest = f", mean NEES {s.nees:.1f} (honest 3, band {self.band[0]:g} to {self.band[1]:g})" if s.truth else ""
        return (
            f"{here()}, {len(trial.path)} scans: distance to GPS {s.gps:.2f} m (the package {s.want_gps:.2f} m), "
            f"{s.trees:.0f} trees in the mean (the package {s.want_trees:.0f}), {trial.size[-1]} at the end, sigma of the "
            f"position {s.sigma:.2f} m in the last third (the package {s.want_sigma:.2f} m){honest}"
        )


class _Measured:
    """A run beside that of the package."""

    def __init__(self, mine, theirs, truth, trial):
        self.trees, self.gps, self.sigma, self.tree_sigma = mine
        self.want_trees, self.want_gps, self.want_sigma, self.want_tree_sigma = theirs
        self.claim, self.tree_claim = self.sigma / self.want_sigma, self.tree_sigma / self.want_tree_sigma
        self.truth, self.seconds = truth, trial.seconds
        self.nees = truth.nees if truth else np.nan
        self.lost = self.gps > 1.25 * self.want_gps + 0.3  # m


CLAIMED = (
    "in the last third of the run the filter claims {s.sigma:.2f} m for the truck and "
    "{s.tree_sigma:.2f} m for a tree: {s.claim:.2f} and {s.tree_claim:.2f} times what the package claims on the same scans "
    "({p.claims[0]:g} to {p.claims[1]:g})"
)

SYMPTOMS = (
    Symptom(
        "the map",
        lambda s, p: s.trees < 0.7 * s.want_trees,
        "{s.trees:.0f} trees are in the map in the mean; the package has {s.want_trees:.0f} on the same scans",
        "Trees are not started, or thrown out at once: does every -1 start one, with its counts searched = found = 1? Does `manage` hear of trees behind the truck as of trees in view?",
    ),
    Symptom(
        "the path",
        lambda s, p: s.lost and s.trees > 1.25 * s.want_trees,
        "the path is {s.gps:.1f} m from GPS (the package: {s.want_gps:.1f} m), and {s.trees:.0f} trees are in the map (the package: {s.want_trees:.0f})",
        "The filter does not recognise its own trees, and starts them again. Look at the motion first: five small steps in a scan? The place of the laser, `car`? The slip in the noise? Are x and P both corrected? Then at the innovation: measured minus expected, its bearing wrapped.",
    ),
    Symptom(
        "the covariance is corrected",
        lambda s, p: s.claim > p.claims[1],  # of the truck: trees that nobody deletes have large ones, too
        CLAIMED,
        "Too cautious: x is corrected and P is not? P - K Z K' belongs to every correction. Or is a noise counted twice, or a standard deviation taken for a variance?",
    ),
    Symptom(
        "the path",
        lambda s, p: s.lost,
        "the path is {s.gps:.1f} m from GPS (the package: {s.want_gps:.1f} m), and {s.trees:.0f} trees are in the map (the package: {s.want_trees:.0f})",
        "Does every scan add its noise, B U B', the slip in it, to P[:3, :3]? Do corrections reach the pose (x[:3] and P[:3])? Is the sign of the innovation right? Are all detections of a scan used that have a tree?",
    ),
    Symptom(
        "the upkeep",
        lambda s, p: s.trees > 1.25 * s.want_trees,
        "the path is right, but {s.trees:.0f} trees are in the map in the mean; the package has {s.want_trees:.0f}",
        "Trees that are never found again stay: does `manage` get which trees are in view and which were found, with the counts of the scan before? Do those that it names go out of x, of P (rows and columns), and of the counts? Or are there doubles: is the gate of new trees 25?",
    ),
    Symptom(
        "no more is claimed than can be known",
        lambda s, p: min(s.claim, s.tree_claim) < p.claims[0],
        CLAIMED,
        "Too sure: is the third column of B, the slip, in the noise? Has a new tree its covariance with *all* of the map, P_lx = L_r P[:3]? Is R in Z, once for each detection?",
    ),
    Symptom(
        "honest",
        lambda s, p: s.nees > p.band[1],
        "path and map are right, but the mean NEES is {s.nees:.1f} (band {p.band[0]:g} to {p.band[1]:g}, honest 3)",
        "Too sure: is `car` that of the truck, with the laser 3.78 m ahead? Is now.U[1] with the slip in P? Is R that of the laser? Does a new tree get its covariance with the whole map, P_lx = L_r P[:3]?",
    ),
    Symptom(
        "honest",
        lambda s, p: s.nees < p.band[0],
        "path and map are right, but the mean NEES is {s.nees:.2f} (band {p.band[0]:g} to {p.band[1]:g}, honest 3)",
        "Too cautious: is P corrected, too? Is a noise counted twice?",
    ),
)


def _a_laser(data):
    model = data.sensors[0].model
    for key, got, about, most in (
        ("range_std", model.range_std, 0.15, 1.0),
        ("bearing_std_deg", np.degrees(model.bearing_std), 0.7, 5.0),
    ):
        if got > most:
            return f"the laser has {key} = {got:.3g}, the task has about {about:g} and takes up to {most:g}"
    return None


PROJECT = project = Park(
    "19.project",
    "Drive the park",
    loop,
    scenario=SCENARIO,
    start=START,
    hints=(
        "Four parts for a scan: drive (five small steps), `sort_scan` on the squared distances, one correction with all that have a tree, the upkeep: `manage`, births, deletions. Keep ids, searched and found in the order of the trees in x.",
        "Motion: A = X_x A and B = X_x B + X_u over the five steps, a third column of B for the slip, Q = B U B'. "
        "z = y[:, None] - e has the shape (k, n, 2); D = z' Z^-1 z for each pair. Stack E_r and E_l of the used ones into H, "
        "R on the diagonal. A tree that is matched counts as one in view; or use only detections whose tree is in view: both are right. After the correction P = (P + P') / 2, so that rounding does not grow. Delete: rows 3 + 2i and 4 + 2i of x and of P, and columns of P.",
    ),
    asks=(
        asks.robots("vehicle"),
        asks.sensors("range_bearing"),
        _a_laser,
        asks.landmarks("euc_pnt"),
        asks.frames(300, 1200),
        asks.estimated(),
    ),
    band=(0.2, 9.0),
    claims=(0.85, 1.3),
    symptoms=SYMPTOMS,
    seconds=90.0,
    recording=lambda data: log(),
    helpers=(expected,),
)
