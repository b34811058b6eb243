"""Exercise 02.5: one time step of the lecture's algorithm, without counting a measurement twice."""

import numpy as np

from ...analysis import chi2_band
from ...geometry import wrap
from .. import expect
from ..exercise import Exercise
from .nb02_grow import add_landmark
from .nb02_h import h
from .nb02_q import landmark_of, q


def map_step(x, P, ids, seen, ys, x_r, R):
    """Use all measurements of one time step.

    ids is the list of the landmarks in the map, in the order of x. ys, shape (m, 2), holds the measurements
    [range, bearing], and seen the id of each. x, P, x_r, R are as before. The landmarks do not move.
    Return the new x, P and ids. Do not change the inputs.
    """
    ids = list(ids)
    for id, y in zip(seen, ys, strict=True):
        if id not in ids:
            x, P = add_landmark(x, P, y, x_r, R)
            ids.append(id)
        else:
            e, H = h(x, ids.index(id), x_r)
            z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
            Z = H @ P @ H.T + R
            K = P @ H.T @ np.linalg.inv(Z)
            x = x + K @ z
            P = P - K @ Z @ K.T
    return x, P, ids


step = Exercise(
    "02.5",
    "The whole algorithm",
    map_step,
    hints=(
        "One loop over the measurements. A landmark is new or known: the measurement is used for one of the two, once.",
        "New: add_landmark(...) and remember its id. Known: i = ids.index(id), then e, H = h(x, i, x_r), innovation "
        "(wrap the bearing!), Z, K, new x, new P.",
        "z = y - e with z[1] wrapped; Z = H P H' + R; K = P H' inv(Z); x = x + K z; P = (I - K H) P.",
    ),
)

R0 = np.array([[0.04, 0.002], [0.002, 0.0009]])  # not diagonal
WORLD = {7: (3.0, 1.0), 3: (-2.0, 2.5), 12: (-3.0, -0.05), 4: (0.5, -4.0)}


def _scan(rng, x_r, seen, scale=1.0):
    """Noisy measurements of some landmarks of the world."""
    S = np.linalg.cholesky(R0) * scale
    rows = [h(np.array(WORLD[id]), 0, x_r)[0] + S @ rng.normal(size=2) for id in seen]
    ys = np.array(rows).reshape(-1, 2)
    ys[:, 1] = wrap(ys[:, 1])
    return ys


def _start(rng, seen=(7, 3, 12)):
    """A map of some landmarks, a bit wrong, with honest block-diagonal covariance."""
    P, x = np.zeros((2 * len(seen), 2 * len(seen))), np.zeros(2 * len(seen))
    for i, id in enumerate(seen):
        A = rng.normal(size=(2, 2)) * 0.2
        B = A @ A.T + 0.02 * np.eye(2)
        P[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = B
        x[2 * i : 2 * i + 2] = WORLD[id] + np.linalg.cholesky(B) @ rng.normal(size=2)
    return x, P, list(seen)


def _out(result, n):
    x, P, ids = expect.results(result, "x", "P", "ids")
    x, P = expect.array(x, 2 * n, "x"), expect.array(P, (2 * n, 2 * n), "P")
    try:
        return x, P, [int(i) for i in ids]
    except (TypeError, ValueError):
        raise expect.Failed(f"ids must be the list of landmark ids, got {ids!r:.60}") from None


EMPTY = np.zeros(0), np.zeros((0, 0)), []
POSE = np.array([0.4, -0.3, 0.3])


@step.link("three results", "The function must end with `return x, P, ids`.")
def _(f, rng):
    expect.results(f(*EMPTY, [7], _scan(rng, POSE, [7]), POSE, R0), "x", "P", "ids")


@step.link("first sight", "A landmark that is not in `ids` is started with its measurement, and that is all.")
def _(f, rng):
    ys = _scan(rng, POSE, [7])
    x, P, _ = _out(f(*EMPTY, [7], ys, POSE, R0), 1)
    l, L_y = q(ys[0], POSE)
    expect.close(x, l, "the new landmark")
    expect.close(P, L_y @ R0 @ L_y.T, "the covariance of the new landmark")


@step.link("ids", "`ids` says which landmark sits where in x: in the order in which they came.")
def _(f, rng):
    ys = _scan(rng, POSE, [7, 3])
    x, P, ids = _out(f(*EMPTY, [7, 3], ys, POSE, R0), 2)
    expect.true(ids == [7, 3], f"after landmarks 7 and 3, ids must be [7, 3], got {ids}")
    expect.close(x, [*landmark_of(ys[0], POSE), *landmark_of(ys[1], POSE)], "x")


@step.link(
    "nothing seen", "Landmarks do not move, and no motion noise enters the map: without measurements nothing changes."
)
def _(f, rng):
    x, P, ids = _start(rng)
    x2, P2, ids2 = _out(f(x, P, ids, [], np.zeros((0, 2)), POSE, R0), 3)
    expect.close(x2, x, "x")
    expect.close(P2, P, "P")
    expect.true(ids2 == ids, f"ids must stay {ids}, got {ids2}")


@step.link("size", "A known landmark is corrected in its place: the map does not grow.")
def _(f, rng):
    x, P, ids = _start(rng)
    *_, ids2 = _out(f(x, P, ids, [3], _scan(rng, POSE, [3]), POSE, R0), 3)
    expect.true(ids2 == ids, f"ids must stay {ids}, got {ids2}")


def information(x, P, i, y, x_r, R):
    """Mean and covariance of landmark i after one update, by adding information: inv(P) + H' inv(R) H."""
    s = slice(2 * i, 2 * i + 2)
    e, H = h(x[s], 0, x_r)
    B = np.linalg.inv(np.linalg.inv(P[s, s]) + H.T @ np.linalg.solve(R, H))
    z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
    return x[s] + B @ H.T @ np.linalg.solve(R, z), B


def _known(f, rng, x_r, id, i):
    x, P, ids = _start(rng)
    ys = _scan(rng, x_r, [id])
    x2, P2, _ = _out(f(x, P, ids, [id], ys, x_r, R0), 3)
    return x, P, x2, P2, *information(x, P, i, ys[0], x_r, R0)


@step.link("covariance of a known landmark", "P = (I - K H) P: the information of the measurement is added.", part=1)
def _(f, rng):
    for id, i in ((7, 0), (3, 1)):
        *_, P2, l, B = _known(f, rng, POSE, id, i)
        expect.close(P2[2 * i : 2 * i + 2, 2 * i : 2 * i + 2], B, f"the block of landmark {i}")


@step.link("mean of a known landmark", "x = x + K z, with z = y - e and K = P H' inv(H P H' + R).", part=0)
def _(f, rng):
    for id, i in ((7, 0), (3, 1), (7, 0), (3, 1), (7, 0)):
        _, _, x2, _, l, B = _known(f, rng, POSE, id, i)
        expect.close(x2[2 * i : 2 * i + 2], l, f"landmark {i}")


@step.link("the seam", "At +-pi the difference of two bearings is not small: wrap it.", part=0)
def _(f, rng):
    for side, theta in ((1, 0.0), (-1, 0.0), (1, 9.0), (-1, -9.0)):
        x, P, x_r = np.array([-3.0, 0.15 * side]), 0.1 * np.eye(2), np.array([0.0, 0.0, theta])
        y = np.array([3.05, wrap(-side * 3.09 - theta)])  # just across the line straight behind
        x2, *_ = _out(f(x, P, [5], [5], y[None], x_r, R0), 1)
        expect.close(x2, information(x, P, 0, y, x_r, R0)[0], "a landmark measured across the seam")


@step.link("the range is no angle", "Only the bearing is wrapped: a range innovation may be larger than pi.", part=0)
def _(f, rng):
    x, P, y = np.array([10.0, 0.0]), 4.0 * np.eye(2), np.array([14.0, 0.01])
    x2, *_ = _out(f(x, P, [9], [9], np.array([y]), np.zeros(3), R0), 1)
    expect.close(x2, information(x, P, 0, y, np.zeros(3), R0)[0], "a landmark that was 4 m off")


@step.link("the others", "A measurement of one landmark tells nothing about the others: with a known pose they stay.")
def _(f, rng):
    x, P, x2, P2, *_ = _known(f, rng, POSE, 3, 1)
    keep = [0, 1, 4, 5]
    expect.close(x2[keep], x[keep], "the landmarks that were not seen")
    expect.close(P2[np.ix_(keep, keep)], P[np.ix_(keep, keep)], "their covariance")
    expect.true(not P2[np.ix_(keep, [2, 3])].any(), "the blocks between landmarks are not exactly zero")


@step.link("a mixed scan", "Known and new landmarks in one scan, in any order: each row of ys is used once.")
def _(f, rng):
    x, P, ids = _start(rng, (7, 3))
    seen = [4, 3, 12, 7]
    ys = _scan(rng, POSE, seen)
    x2, P2, ids2 = _out(f(x, P, ids, seen, ys, POSE, R0), 4)
    expect.true(ids2 == [7, 3, 4, 12], f"ids must be [7, 3, 4, 12] after seeing 4, 3, 12, 7, got {ids2}")
    for i, row in ((0, 3), (1, 1)):
        l, B = information(x, P, i, ys[row], POSE, R0)
        expect.close(x2[2 * i : 2 * i + 2], l, f"known landmark {ids[i]}")
        expect.close(P2[2 * i : 2 * i + 2, 2 * i : 2 * i + 2], B, f"the block of known landmark {ids[i]}")
    for i, row in ((2, 0), (3, 2)):
        expect.close(x2[2 * i : 2 * i + 2], landmark_of(ys[row], POSE), f"new landmark {seen[row]}")


@step.link("honest over many runs", "Errors must be as large as P says: NEES near the number of states.")
def _(f, rng):
    nees, seen, truth = 0.0, list(WORLD), np.array(list(WORLD.values())).ravel()
    runs, turns = 15, 8
    for _ in range(runs):
        state = EMPTY
        for k in range(turns):
            x_r = np.array([np.cos(k), np.sin(k), 0.8 * k])
            state = _out(f(*state, seen, _scan(rng, x_r, seen, 0.3), x_r, 0.09 * R0), 4)
        x, P, _ = state
        expect.symmetric(P, "P after 8 steps", rtol=1e-6)
        expect.psd(P, "P after 8 steps")
        blocks = np.kron(np.eye(4), np.ones((2, 2))) > 0
        expect.true(not P[~blocks].any(), "after 8 steps the blocks between landmarks are not exactly zero")
        nees += (x - truth) @ np.linalg.solve(P, x - truth)
    low, high = np.array(chi2_band(8 * runs, 0.999)) / (8 * runs)
    ratio = nees / (8 * runs)
    expect.true(low < ratio < high, f"NEES per state is {ratio:.2f}, outside the 99.9 % band {low:.2f} to {high:.2f}")
