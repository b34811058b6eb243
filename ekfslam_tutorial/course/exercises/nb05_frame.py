"""Exercise 05.5: one frame of EKF-SLAM with known ids, no measurement used twice."""

import numpy as np

from ...analysis import anees_band
from ...geometry import wrap
from .. import expect
from ..exercise import Exercise
from .nb05_augment import augment
from .nb05_correct import correct
from .nb05_observe import observe
from .nb05_predict import predict


def slam_frame(x, P, ids, u, U, seen, ys, R):
    """One frame of EKF-SLAM: move, correct with the known landmarks, start the new ones.

    x, P: joint state, the robot's pose first, and its covariance. ids: the ids of the landmarks in the state, in its
    order: landmark ids[k] has the range 3 + 2 k to 5 + 2 k.
    u, U: measured step of the robot and its covariance. seen: ids of the landmarks in view. ys, shape (m, 2): the
    measurement [range, bearing] of each; R, shape (2, 2): the covariance of one measurement.
    Return the new x, P and ids. Do not change the inputs.
    """
    x, P = predict(x, P, u, U)
    new = []
    for id, y in zip(seen, ys, strict=True):
        if id in ids:
            k = 3 + 2 * ids.index(id)
            e, H = observe(x, slice(k, k + 2))
            x, P = correct(x, P, y, R, e, H)
        else:
            new.append((id, y))
    for _, y in new:
        x, P = augment(x, P, y, R)
    return x, P, ids + [id for id, _ in new]


frame = Exercise(
    "05.5",
    "The whole loop",
    slam_frame,
    hints=(
        "Three steps in this order: predict once; for each known landmark observe and correct; for each new one "
        "augment.",
        "A measurement is used once: to correct a landmark that is in ids, or to start one that is not. Work on a new "
        "list of ids: ids = list(ids).",
        "k = 3 + 2 * ids.index(id); e, H = observe(x, slice(k, k + 2)); x, P = correct(x, P, y, R, e, H). After "
        "augment: ids = ids + [id].",
    ),
)

R0 = np.array([[0.01, 0.0002], [0.0002, 0.0004]])  # 0.1 m and 1.1 degrees, a bit correlated
U0 = np.array([[4e-4, 1e-5, 0], [1e-5, 1e-4, 2e-5], [0, 2e-5, 1e-4]])  # 2 cm ahead, 1 cm sideways, 0.6 degrees
STEP = np.array([0.6, -0.1, 0.4])
WORLD = {7: (3.0, 1.0), 3: (-2.0, 2.5), 12: (-3.0, -0.05), 4: (0.5, -4.0), 21: (2.5, 3.5)}


def measured(x_r, id):
    """Return the exact measurement of a landmark of the world."""
    return observe(np.array([*x_r, *WORLD[id]]), slice(3, 5))[0]


def scan(rng, x_r, seen, scale=1.0):
    """Return measurements with noise, scale times its standard deviation, shape (m, 2)."""
    noise = scale * rng.normal(size=(len(seen), 2)) @ np.linalg.cholesky(R0).T
    ys = np.array([measured(x_r, id) for id in seen]).reshape(-1, 2) + noise
    ys[:, 1] = wrap(ys[:, 1])
    return ys


def start(rng, ids: tuple[int, ...] = (7, 3, 12)):
    """Return a map of some landmarks as SLAM would have made it: state, covariance, ids, and the true pose."""
    x, P, truth = np.zeros(3), np.zeros((3, 3)), np.zeros(3)
    for _ in range(4):
        truth = predict(truth, P[:3, :3], STEP, U0)[0]
        x, P = predict(x, P, STEP + rng.normal(size=3) * np.sqrt(np.diag(U0)), U0)
    for y in scan(rng, truth, ids):
        x, P = augment(x, P, y, R0)
    return x, P, list(ids), truth


def _out(result, n):
    x, P, ids = expect.results(result, "x", "P", "ids")
    size = 3 + 2 * n
    x, P = expect.array(x, size, "x"), expect.array(P, (size, size), "P")
    try:
        return x, P, [int(i) for i in ids]
    except (TypeError, ValueError):
        raise expect.Failed(f"ids must be the list of landmark ids, got {ids!r:.60}") from None


EMPTY = np.zeros((0, 2))


def _same(got, want, what, rtol=1e-3):
    """x and P must agree up to rounding, the heading up to whole turns."""
    (x, P), (x_want, P_want) = got, want
    shift = np.zeros(len(x))
    shift[2] = wrap(x[2] - x_want[2]) - (x[2] - x_want[2])
    expect.close(x + shift, x_want, f"x {what}", rtol * 1e-2, 1e-6)
    expect.close(P, P_want, f"P {what}", rtol)


@frame.link("three results", "The function must end with `return x, P, ids`.")
def _(f, rng):
    x, P, ids, _ = start(rng)
    expect.results(f(x, P, ids, STEP, U0, [], EMPTY, R0), "x", "P", "ids")


@frame.link("nothing in view", "Without measurements the frame is a prediction, and nothing else.")
def _(f, rng):
    for some in ((7, 3, 12), ()):
        x, P, ids, _ = start(rng, some)
        x2, P2, ids2 = _out(f(x, P, ids, STEP, U0, [], EMPTY, R0), len(some))
        expect.true(ids2 == ids, f"without measurements ids must stay {ids}, got {ids2}")
        _same((x2, P2), predict(x, P, STEP, U0), "after a frame without measurements")


@frame.link("first sight", "A new landmark: predict, then augment with its measurement, and that is all.")
def _(f, rng):
    for some in ((), (7, 3)):
        x, P, ids, truth = start(rng, some)
        truth = predict(truth, P[:3, :3], STEP, U0)[0]
        y = scan(rng, truth, [12])
        x2, P2, ids2 = _out(f(x, P, ids, STEP, U0, [12], y, R0), len(some) + 1)
        expect.true(ids2 == [*ids, 12], f"after the first sight of landmark 12 ids must be {[*ids, 12]}, got {ids2}")
        moved = predict(x, P, STEP, U0)
        n = len(x)
        _same((x2[:n], P2[:n, :n]), moved, "of robot and old landmarks, after the first sight of a new one")
        _same((x2, P2), augment(*moved, y[0], R0), "after the first sight of landmark 12")


@frame.link("a known landmark", "Predict, then observe and correct. Is the right range taken from ids?")
def _(f, rng):
    for id in (3, 12, 7):
        x, P, ids, truth = start(rng)
        truth = predict(truth, P[:3, :3], STEP, U0)[0]
        y = scan(rng, truth, [id])
        x2, P2, ids2 = _out(f(x, P, ids, STEP, U0, [id], y, R0), 3)
        expect.true(ids2 == ids, f"ids must stay {ids}, got {ids2}")
        moved, k = predict(x, P, STEP, U0), 3 + 2 * ids.index(id)
        want = correct(*moved, y[0], R0, *observe(moved[0], slice(k, k + 2)))
        _same((x2, P2), want, f"after a measurement of landmark {id}, the {ids.index(id) + 1}. in the state")


@frame.link("two known landmarks", "After the first correction x is new: observe the second landmark from there.")
def _(f, rng):
    x, P, ids, _ = start(rng)
    moved = predict(x, P, STEP, U0)
    for seen in ([12, 7], [3, 12]):
        rows = [observe(moved[0], slice(k, k + 2)) for k in (3 + 2 * ids.index(id) for id in seen)]
        z = 1e-3 * rng.normal(size=(2, 2))  # so small that it does not matter where H is taken
        ys = np.array([e for e, _ in rows]) + z
        x2, P2, _ = _out(f(x, P, ids, STEP, U0, seen, ys, R0), 3)
        H = np.vstack([H for _, H in rows])
        K = np.linalg.solve(H @ moved[1] @ H.T + np.kron(np.eye(2), R0), H @ moved[1]).T
        shift = x2 - moved[0]
        shift[2] = wrap(shift[2])
        expect.close(shift, K @ z.ravel(), "the correction of x by two landmarks in one frame", 0.02, 1e-9)
        expect.close(P2, moved[1] - K @ H @ moved[1], "P after two landmarks in one frame", 0.01)


@frame.link("known and new in one frame", "Each measurement is used once, whatever the order in which they come.")
def _(f, rng):
    for seen in ([4, 3, 21], [3, 21, 4]):
        x, P, ids, _ = start(rng)
        moved = predict(x, P, STEP, U0)
        e, H = observe(moved[0], slice(5, 7))
        ys = np.array([e if id == 3 else measured(moved[0][:3], id) for id in seen])  # no surprise
        x2, P2, ids2 = _out(f(x, P, ids, STEP, U0, seen, ys, R0), 5)
        expect.true(sorted(ids2) == [3, 4, 7, 12, 21], f"ids must be 7, 3, 12 and the new 4 and 21, got {ids2}")
        expect.true(ids2[:3] == ids, f"the old landmarks keep their places: ids must begin with {ids}, got {ids2}")
        want = correct(*moved, e, R0, e, H)
        for id in ids2[3:]:
            want = augment(*want, ys[seen.index(id)], R0)
        _same((x2, P2), want, f"after a frame with the landmarks {seen}, of which 3 is known")


def small_run(f, seed, frames=16):
    """Run f round the world; return the final state and the true one, in the order of ids."""
    rng = np.random.default_rng(seed)
    S, x, P, ids, truth = np.linalg.cholesky(U0), np.zeros(3), np.zeros((3, 3)), [], np.zeros(3)
    for _ in range(frames):
        truth = predict(truth, np.zeros((3, 3)), STEP, U0)[0]
        seen = [id for id in WORLD if measured(truth, id)[0] < 4.5]
        u = STEP + S @ rng.normal(size=3)
        x, P, ids = _out(f(x, P, ids, u, U0, seen, scan(rng, truth, seen), R0), len(set(ids) | set(seen)))
    return x, P, np.concatenate([truth, *(WORLD.get(id, (0, 0)) for id in ids)])


@frame.link("honest over 20 runs", "Errors must be as large as P says: NEES near the number of states.")
def _(f, rng):
    runs, total = 20, 0.0
    for seed in range(runs):
        x, P, truth = small_run(f, seed)
        expect.symmetric(P, "P after 16 frames", 1e-6)
        expect.psd(P, "P after 16 frames", 1e-7)
        d = x - truth
        d[2] = wrap(d[2])
        total += d @ np.linalg.solve(P, d)
    n = len(truth)
    low, high = anees_band(n, runs, 0.999)
    text = (
        f"the mean NEES of {runs} runs is {total / runs:.1f}; for {n} states the 99.9 % band is {low:.1f} to {high:.1f}"
    )
    expect.true(low < total / runs < high, text)
