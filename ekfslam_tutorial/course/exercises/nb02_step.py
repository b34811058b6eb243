"""Exercise 02.5: one time step of the lecture's algorithm, without counting a measurement twice."""

import numpy as np

from ...analysis import chi2_band
from ...geometry import wrap
from .. import expect
from ..table import table
from .nb02_grow import add_landmark
from .nb02_h import h
from .nb02_q import q  # noqa: F401  # two of the wrong answers


def map_step(x, P, ids, seen, ys, x_r, R):
    """Use all measurements of one time step.

    ids is the list of the landmarks in the map, in the order of x. ys, shape (m, 2), holds the measurements
    [range, bearing], and seen the id of each, none twice. x, P, x_r, R are as before. The landmarks do not move.
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


R0 = np.array([[0.04, 0.002], [0.002, 0.0009]])  # not diagonal
WORLD = {7: (3.0, 1.0), 3: (-2.0, 2.5), 12: (-3.0, -0.05), 4: (0.5, -4.0)}
EMPTY = np.zeros(0), np.zeros((0, 0)), []
POSE = np.array([0.4, -0.3, 0.3])


def scan(rng, x_r, seen, scale=1.0):
    """Return noisy measurements of some landmarks of the world."""
    S = np.linalg.cholesky(R0) * scale
    rows = [h(np.array(WORLD[id]), 0, x_r)[0] + S @ rng.normal(size=2) for id in seen]
    ys = np.array(rows).reshape(-1, 2)
    ys[:, 1] = wrap(ys[:, 1])
    return ys


def start(rng, ids=(7, 3, 12)):
    """Return a map of some landmarks, a bit wrong, with honest block-diagonal covariance."""
    P, x = np.zeros((2 * len(ids), 2 * len(ids))), np.zeros(2 * len(ids))
    for i, id in enumerate(ids):
        A = rng.normal(size=(2, 2)) * 0.2
        B = A @ A.T + 0.02 * np.eye(2)
        P[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = B
        x[2 * i : 2 * i + 2] = WORLD[id] + np.linalg.cholesky(B) @ rng.normal(size=2)
    return x, P, list(ids)


def sees(rng, *seen, ids=(7, 3, 12)):
    """Return a step in which the robot sees these landmarks."""
    return *(start(rng, ids) if ids else EMPTY), list(seen), scan(rng, POSE, seen), POSE, R0


def alone(l, sigma, y, theta=0.0):
    """Return a step with one landmark in the map, seen by a robot at the origin."""
    return np.array(l), sigma**2 * np.eye(2), [5], [5], np.array([y]), np.array([0.0, 0.0, theta]), R0


def across(side, theta):
    """Return a step in which the landmark is measured just across the line straight behind."""
    return alone([-3.0, 0.15 * side], 0.3, [3.05, wrap(-side * 3.09 - theta)], theta)


step = table(
    "02.5 The whole algorithm",
    map_step,
    hints=(
        "One loop over the measurements. A landmark is new or known: the measurement is used for one of the two, once.",
        "New: add_landmark(...) and remember its id. Known: i = ids.index(id), then e, H = h(x, i, x_r), innovation (wrap the bearing!), Z, K, new x, new P.",
        "z = y - e with z[1] wrapped; Z = H P H' + R; K = P H' inv(Z); x = x + K z; P = (I - K H) P.",
    ),
    returns="x, P, ids",
    ids=("seen", ("h", "observe")),
    cases={
        "any": lambda rng: [sees(rng, 7, ids=())],
        "new": lambda rng: [sees(rng, 7, 3, ids=()), sees(rng, 4)],
        "nothing": lambda rng: [sees(rng)],
        "7": lambda rng: [sees(rng, 7) for _ in range(3)],
        "3": lambda rng: [sees(rng, 3) for _ in range(3)],
        "seam": lambda rng: [across(1, 0.0), across(-1, 0.0), across(1, 9.0), across(-1, -9.0)],
        "far": lambda rng: [alone([10.0, 0.0], 2.0, [14.0, 0.01])],
        "aside": lambda rng: [alone([3.0, 0.0], 1.0, [3.0, bearing]) for bearing in (2.0, -2.5)],
        "mixed": lambda rng: [sees(rng, 4, 3, 12, 7, ids=(7, 3)), sees(rng, 12, 7, 3)],
    },
    checks="""
    first sight                    | x, P        | any     | The map is empty, and one landmark is seen. It is not in `ids`, so it is new: x and P are what add_landmark makes of this measurement.
    ids                            | ids, x      | new     | `ids` says which landmark sits where in x: in the order in which they came, each started with its own row of ys.
    nothing seen                   | x, P, ids   | nothing | Nothing is seen (`seen` is empty, ys has shape (0, 2)), and landmarks do not move: nothing is added to P, and x, P and ids come out as they went in.
    size                           | ids         | 3       | A known landmark is corrected in its place: the map does not grow.
    covariance of the first landmark  | P[:2, :2]   | 7       | P = (I - K H) P, with K = P H' inv(H P H' + R) and the H of the landmark that is seen, here the first one in x.
    covariance of the second landmark | P[2:4, 2:4] | 3       | P = (I - K H) P, with the H of the landmark that is seen: its place is ids.index(id).
    mean of the first landmark        | x[:2]       | 7       | x = x + K z, with z = y - e and K = P H' inv(H P H' + R).
    mean of the second landmark       | x[2:4]      | 3       | x = x + K z, with z = y - e and K = P H' inv(H P H' + R); e and H are those of the landmark that is seen, here the second one in x.
    the seam                       | x           | seam    | At +-pi, and where theta holds whole turns, y[1] - e[1] may hold whole turns, too: z[1] is that difference, wrapped; here it is a small angle.
    the range is no angle          | x           | far     | Here the range innovation is 4 m, which is more than pi: z[0] is the plain difference y[0] - e[0] of two lengths, and x = x + K z as always.
    a bearing far off              | x           | aside   | Here y[1] - e[1] is 2 rad, and then -2.5 rad. Both lie between -pi and pi: z[1] is that difference as it is.
    the others                     | x, P        | 3       | A measurement of one landmark tells nothing about the others: with a known pose they stay.
    a mixed scan                   | ids, x, P   | mixed   | Known and new landmarks in one scan, in any order: each row of ys is used once.
    """,
    wrong="""
    double counting | else: -> if True: | P of a new landmark is exactly half of what it should be. A measurement either starts a landmark or corrects it: use `else`.
    no filtering | x = x + K @ z -> i = 2 * ids.index(id); x = x.copy(); x[i : i + 2], L_y = q(y, x_r) | A known landmark is started anew at each sighting: the star cloud. Combine old and new by the gain K.
        P = P - K @ Z @ K.T -> P = P.copy(); P[i : i + 2, i : i + 2] = L_y @ R @ L_y.T
    known landmarks ignored | else: -> elif False: | In yours a known landmark stays as it was at first sight. Its new measurement must correct x and P.
    known landmark added again | if id not in ids: -> if True: | A known landmark was put into the map a second time. Look it up in `ids`.
    plain mean | x = x + K @ z -> i = 2 * ids.index(id); x = x.copy(); x[i : i + 2] = (x[i : i + 2] + q(y, x_r)[0]) / 2 | Old and new are weighted equally, whatever P and R say. The gain K weighs them.
        P = P - K @ Z @ K.T -> pass
    innovation reversed | Z = H @ P -> z = -z; Z = H @ P | Yours pushes the landmark away from where it was seen: x = x + K z, with z = y - e, measurement minus expectation.
    half turns removed | wrap(y[1] - e[1]) -> np.arctan(np.tan(y[1] - e[1])) | A whole turn is 2 pi. Directions that differ by pi are opposite, not the same.
    arcsine of the sine | wrap(y[1] - e[1]) -> np.arcsin(np.sin(y[1] - e[1])) | An arcsine ends at 90 degrees: a difference of 100 degrees becomes one of 80. arctan2(sine, cosine) knows all directions.
    bearing not wrapped | wrap(y[1] - e[1]) -> y[1] - e[1] | At the seam the difference of two bearings jumps by 2 pi: z[1] = wrap(z[1]).
    bearing not wrapped, nor expected so | wrap(y[1] - e[1]) -> y[1] - (np.arctan2(*(x.reshape(-1, 2)[ids.index(id)] - x_r[:2])[::-1]) - x_r[2]) | At the seam the difference of two bearings jumps by 2 pi: z[1] = wrap(z[1]).
    brackets forgotten | wrap(y[1] - e[1]) -> (y[1] - e[1] + np.pi) % 2 * np.pi - np.pi | Python reads `% 2*np.pi` as `(... % 2) * np.pi`. The whole turn needs brackets: % (2 * np.pi).
    wrapped to 0 ... 2 pi | wrap(y[1] - e[1]) -> (y[1] - e[1]) % (2 * np.pi) | A small negative difference must stay small and negative: wrap into -pi ... pi.
    bearing in degrees | wrap(y[1] - e[1]) -> np.degrees(wrap(y[1] - e[1])) | Angles are in radians everywhere.
    range wrapped, too | [y[0] - e[0], wrap -> [wrap(y[0] - e[0]), wrap | Only the bearing is an angle: do not wrap the range.
    x not updated | x = x + K @ z -> pass | P was corrected, x was not: x = x + K z.
    P not updated | P = P - K @ Z @ K.T -> pass | x was corrected, P was not: P = (I - K H) P.
    P grows | P = P - K @ Z -> P = P + K @ Z | A measurement never makes the map more uncertain: P *minus* K H P.
    P - K H | P = P - K @ Z @ K.T -> P = P - K @ H | The last P is missing: P - K H P, which is (I - K H) P.
    P forgotten behind the bracket | P = P - K @ Z @ K.T -> P = np.eye(len(P)) - K @ H | (I - K H) must still be multiplied by P.
    R missing in Z | H @ P @ H.T + R -> H @ P @ H.T | Z = H P H' + R: without R the filter believes each measurement blindly.
    R squared | H.T + R -> H.T + R @ R | R holds variances already: do not square it.
    square root of R | H.T + R -> H.T + np.sqrt(np.abs(R)) | R holds variances, and Z wants variances: no square root.
    diagonal of R | H.T + R -> H.T + np.diag(np.diag(R)) | You used the diagonal of R only. R may have a covariance between range and bearing.
    return inside the loop | zip(seen, ys -> zip(seen[:1], ys[:1] | Not all measurements are used: does your loop end too early, by a `return` or a `break` in it?
    only the last measurement | zip(seen, ys -> zip(seen[-1:], ys[-1:] | Only the last measurement is used: is the update outside the loop?
    ids not kept | ids.append(id) -> pass | The map has grown, but `ids` has not: append the id of each new landmark, and return the list.
    id put in front | ids.append(id) -> ids.insert(0, id) | add_landmark puts the new landmark at the end of x: append its id at the end of ids.
    id taken for the index | ids.index(id) -> id % len(ids) | The id of a landmark is its name. Its place in x is ids.index(id).
    id - 1 taken for the index | ids.index(id) -> (id - 1) % len(ids) | The id of a landmark is its name. Its place in x is ids.index(id), not id - 1.
    place in seen | ids.index(id) -> seen.index(id) | The place of a landmark in x is its place in `ids`, not in `seen`: ids.index(id).
    motion noise in the map | ids = list(ids) -> ids = list(ids); P = P + 0.01 * np.eye(len(P)) | The landmarks do not move: the prediction adds nothing to P.
    Joseph without the noise | P = P - K @ Z @ K.T -> P = (np.eye(len(x)) - K @ H) @ P @ (np.eye(len(x)) - K @ H).T | (I - K H) stands twice in your P. Once is right: (I - K H) P. With it on both sides, as in Joseph's form, a second term belongs there: + K R K'.
    place in the sorted ids | ids.index(id) -> sorted(ids).index(id) | `ids` is in the order of x, in which the landmarks came: its place there is ids.index(id), not that among the sorted ids.
    ids sorted at the end | return x, P, ids -> return x, P, sorted(ids) | `ids` stays in the order of x: a new one comes to the end, and nothing is sorted.
    """,
    forms="""
    P - K H P | P - K @ Z @ K.T -> P - K @ H @ P | P - K H P
    """,
)


@step.link(
    "honest over many runs",
    "15 runs: the errors must be as large as P says, NEES near the number of states. P stays symmetric, zero between landmarks.",
)
def _(f, rng):
    nees, seen, truth = 0.0, list(WORLD), np.array(list(WORLD.values())).ravel()
    runs, turns = 15, 8
    for _ in range(runs):
        state = EMPTY
        for k in range(turns):
            x_r = np.array([np.cos(k), np.sin(k), 0.8 * k])
            x, P, ids = expect.results(f(*state, seen, scan(rng, x_r, seen, 0.3), x_r, 0.09 * R0), "x", "P", "ids")
            state = expect.array(x, 8, "x"), expect.array(P, (8, 8), "P"), [int(id) for id in ids]
        x, P, _ = state
        expect.symmetric(P, "P after 8 steps", rtol=1e-6)
        expect.psd(P, "P after 8 steps")
        blocks = np.kron(np.eye(4), np.ones((2, 2))) > 0
        expect.true(not P[~blocks].any(), "after 8 steps the blocks between landmarks are not exactly zero")
        nees += (x - truth) @ np.linalg.solve(P, x - truth)
    low, high = np.array(chi2_band(8 * runs, 0.999)) / (8 * runs)
    ratio = nees / (8 * runs)
    expect.true(low < ratio < high, f"NEES per state is {ratio:.2f}, outside the 99.9 % band {low:.2f} to {high:.2f}")
