"""Exercise 05.5: one frame of EKF-SLAM with known ids, no measurement used twice."""

import numpy as np

from ...analysis import anees_band
from ...geometry import wrap
from .. import expect
from ..table import table
from .nb05_augment import augment
from .nb05_correct import correct
from .nb05_observe import observe
from .nb05_predict import predict


def slam_frame(x, P, ids, u, U, seen, ys, R):
    """One frame of EKF-SLAM: move, correct with the known landmarks, start the new ones.

    The move comes first. Then each measurement is used once, in any order: to correct, if its landmark is in ids, or
    else to start it; a landmark that a measurement has started is not corrected with it.
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


EMPTY = np.zeros((0, 2))


def sees(rng, *seen, ids: tuple[int, ...] = (7, 3, 12)):
    """Return the arguments of a frame in which these landmarks are in view."""
    x, P, known, truth = start(rng, ids)
    truth = predict(truth, P[:3, :3], STEP, U0)[0]
    return x, P, known, STEP, U0, list(seen), scan(rng, truth, seen), R0


def out(result, n):
    """Return the results as arrays of the right size, and a list."""
    x, P, ids = expect.results(result, "x", "P", "ids")
    size = 3 + 2 * n
    x, P = expect.array(x, size, "x"), expect.array(P, (size, size), "P")
    try:
        return x, P, [int(i) for i in ids]
    except (TypeError, ValueError):
        raise expect.Failed(f"ids must be the list of landmark ids, got {ids!r:.60}") from None


frame = table(
    "05.5 The whole loop",
    slam_frame,
    hints=(
        "Predict once, before all else; for each known landmark observe and correct; for each new one augment.",
        "A measurement is used once: to correct a landmark that is in ids, or to start one that is not. Work on a new list of ids: ids = list(ids).",
        "k = 3 + 2 * ids.index(id); e, H = observe(x, slice(k, k + 2)); x, P = correct(x, P, y, R, e, H). After augment: ids = ids + [id].",
    ),
    returns="x, P, ids",
    ids=("seen", ("slice", "observe")),
    angles={"x": 2},
    rtol={"P": 1e-3},
    cases={
        "any": lambda rng: [sees(rng), sees(rng, ids=())],
        "new": lambda rng: [sees(rng, 12, ids=()), sees(rng, 12, ids=(7, 3))],
        "known": lambda rng: [sees(rng, id) for id in (3, 12, 7)],
    },
    checks="""
    nothing in view  | ids, x, P | any   | Without measurements the frame is a prediction with u and U, and nothing else; ids stay as they are.
    first sight      | ids, x, P | new   | A new landmark: predict with u and U, once in a frame, then augment with its measurement. Its id comes to the end of ids, as the landmark comes to the end of x.
    a known landmark | ids, x, P | known | Predict with u and U, then observe and correct with the landmark's own measurement and R. Its range in x follows from its place in ids; ids stay as they are.
    """,
    wrong="""
    double counting: The measurement that starts a landmark is used up: yours corrects that landmark with it once more, and its covariance is too small. In a frame a landmark is either started or corrected.
        x, P = augment(x, P, y, R) -> x, P = augment(x, P, y, R); x, P = correct(x, P, y, R, *observe(x, slice(len(x) - 2, len(x))))
    prediction forgotten | x, P = predict(x, P, u, U) -> pass | The robot has moved: begin with x, P = predict(x, P, u, U).
    mean moved, covariance not | x, P = predict( -> x, _ = predict( | predict returns both x and P: take both.
    covariance moved, mean not | x, P = predict( -> _, P = predict( | predict returns both x and P: take both.
    first measurement for all new ones | for _, y in new: -> for y in [ys[0]] * len(new): | Each new landmark is started with its own measurement, not with the first one of the frame.
    mean corrected, covariance not | x, P = correct( -> x, _ = correct( | correct returns both x and P: take both.
    known landmarks not used | x, P = correct(x, P, y, R, e, H) -> pass | A landmark that is in ids corrects the whole state: observe, then correct, and keep the x and P that it returns.
    new landmarks not started | new.append((id, y)) -> pass | A landmark that is not in ids comes into the state: augment, and remember its id.
    every sight is a new landmark | if id in ids: -> if False: | A landmark that is in ids is known: do not start it again, correct with it.
    id not remembered | ids + [id for id, _ in new] -> ids | Put the id of a new landmark at the end of ids, as augment puts the landmark at the end of x.
    id put in front | ids + [id for id, _ in new] -> [id for id, _ in new][::-1] + ids | augment puts the new landmark at the end of x: put its id at the end of ids, too.
    robot forgotten in the range | k = 3 + 2 * ids.index(id) -> k = 2 * ids.index(id) | The robot has the first three numbers: landmark k begins at 3 + 2 k.
    one number for a landmark | k = 3 + 2 * ids.index(id) -> k = 3 + ids.index(id) | Each landmark has two numbers: landmark k begins at 3 + 2 k.
    counted from one | k = 3 + 2 * ids.index(id) -> k = min(5 + 2 * ids.index(id), len(x) - 2) | Python counts from 0: the first landmark in ids has the range 3:5.
    R squared | x, P = predict -> R = R**2; x, P = predict | R is a covariance already: hand it on as it is.
    ids as the order of sight | k = 3 + 2 * ids.index(id) -> k = min(3 + 2 * seen.index(id), len(x) - 2) | Where a landmark is in the state is said by ids, not by its place in `seen`.
    only the first landmark in view | zip(seen, ys, -> zip(seen[:1], ys[:1], | Use all measurements: is `return` inside the loop?
    only the last landmark in view | zip(seen, ys, -> zip(seen[-1:], ys[-1:], | Use all measurements: does each correction start from the x and P of the one before?
    the robot moves last | x, P = predict(x, P, u, U) -> pass | The measurements were taken after the step: predict comes first.
        return x, P, -> x, P = predict(x, P, u, U); return x, P,
    all observed before the first correction: A correction moves robot and landmarks: observe the next landmark from the new x. With the old e the same error is corrected twice.
        x, P = predict(x, P, u, U) -> x, P = predict(x, P, u, U); old = x
        observe(x, slice -> observe(old, slice
    always the first measurement | x, P = correct(x, P, y, R, e, H) -> x, P = correct(x, P, ys[0], R, e, H) | Each landmark is corrected with its own measurement: ys[i] belongs to seen[i].
    measurement by the place in ids | x, P = correct(x, P, y, R, e, H) -> x, P = correct(x, P, ys[min(ids.index(id), len(ys) - 1)], R, e, H) | The place in ids says where a landmark is in x. Its measurement has the place that it has in `seen`: ys[i] belongs to seen[i].
    noise of the sensor in the prediction | predict(x, P, u, U) -> predict(x, P, u, R[0, 0] * np.eye(3)) | U is the noise of the step, R that of a measurement: predict(x, P, u, U).
    only the first known landmark: Each known landmark in view corrects, one after the other: is there a `break` in the loop?
        x, P = correct(x, P, y, R, e, H) -> x, P = correct(x, P, y, R, e, H) if id == next(i for i in seen if i in ids) else (x, P)
    the robot moves for each landmark: The robot moves once in a frame, in any case, with nothing in view, too: predict is called once, outside of the loop over the measurements, and nothing returns before it.
        x, P = predict(x, P, u, U) -> pass
        x, P = augment(x, P, y, R) -> pass
        e, H = observe( -> x, P = predict(x, P, u, U); e, H = observe(
        new.append((id, y)) -> x, P = augment(*predict(x, P, u, U), y, R); new.append((id, y))
    the robot moves for each landmark, and once more: The robot moves once in a frame: predict stands before the loop, and not in it.
        x, P = augment(x, P, y, R) -> pass
        e, H = observe( -> x, P = predict(x, P, u, U); e, H = observe(
        new.append((id, y)) -> x, P = augment(*predict(x, P, u, U), y, R); new.append((id, y))
    new ones from the pose before the corrections: The known landmarks have corrected the robot, too: a new one is placed from the pose as it is then, to which P belongs.
        x, P = predict(x, P, u, U) -> x, P = predict(x, P, u, U); old = x[:3]
        x, P = augment(x, P, y, R) -> pose = x[:3]; x, P = augment(np.concatenate([old, x[3:]]), P, y, R); x[:3] = pose
    the robot moves twice | x, P = predict(x, P, u, U) -> x, P = predict(*predict(x, P, u, U), u, U) | The robot moves once in a frame: one predict.
    bearing not wrapped, nor expected so | x, P = correct(x, P, y, R, e, H) -> e[1] = np.arctan2(x[k + 1] - x[1], x[k] - x[0]) - x[2]; Z = H @ P @ H.T + R; K = P @ H.T @ np.linalg.inv(Z); x, P = x + K @ (y - e), P - K @ Z @ K.T | At the seam the difference of two bearings jumps by 2 pi: wrap the bearing of y - e.
    """,
)


@frame.link(
    "two known landmarks",
    "Two known landmarks in one frame: each is observed from the x that the correction before it has left, and corrects the whole of x and P with its own measurement and R.",
)
def _(f, rng):
    x, P, ids, _ = start(rng)
    moved = predict(x, P, STEP, U0)
    for seen in ([12, 7], [3, 12]):
        rows = [observe(moved[0], slice(k, k + 2)) for k in (3 + 2 * ids.index(id) for id in seen)]
        z = 1e-3 * rng.normal(size=(2, 2))  # so small that it does not matter where H is taken
        ys = np.array([e for e, _ in rows]) + z
        x2, P2, _ = out(f(x, P, ids, STEP, U0, seen, ys, R0), 3)
        H = np.vstack([H for _, H in rows])
        K = np.linalg.solve(H @ moved[1] @ H.T + np.kron(np.eye(2), R0), H @ moved[1]).T
        shift = x2 - moved[0]
        shift[2] = wrap(shift[2])
        expect.close(shift, K @ z.ravel(), "the correction of x by two landmarks in one frame", 0.02, 1e-9)
        expect.close(P2, moved[1] - K @ H @ moved[1], "P after two landmarks in one frame", 0.01)


@frame.link(
    "known and new in one frame",
    "Known landmarks correct, new ones are started, each with its own measurement and once, whatever the order in `seen`. The ids of the new ones come to the end of ids, in their order in x.",
)
def _(f, rng):
    for seen in ([4, 3, 21], [3, 21, 4]):
        x, P, ids, _ = start(rng)
        moved = predict(x, P, STEP, U0)
        e, H = observe(moved[0], slice(5, 7))
        y = e + 0.1 * np.linalg.cholesky(R0) @ [1.0, -1.0]  # x moves by mm; in which order matters by 0.1 um only
        ys = np.array([y if id == 3 else measured(moved[0][:3], id) for id in seen])
        x2, P2, ids2 = out(f(x, P, ids, STEP, U0, seen, ys, R0), 5)
        expect.true(sorted(ids2) == [3, 4, 7, 12, 21], f"ids must be 7, 3, 12 and the new 4 and 21, got {ids2}")
        expect.true(ids2[:3] == ids, f"the old landmarks keep their places: ids must begin with {ids}, got {ids2}")
        want = correct(*moved, y, R0, e, H)
        for id in ids2[3:]:
            want = augment(*want, ys[seen.index(id)], R0)
        shift = np.zeros(len(x2))
        shift[2] = wrap(x2[2] - want[0][2]) - (x2[2] - want[0][2])
        told = f"after a frame with the landmarks {seen}, of which 3 is known"
        expect.close(x2 + shift, want[0], f"x {told}", 1e-6, 1e-5)
        expect.close(P2, want[1], f"P {told}", 1e-3)


def small_run(f, seed, frames=16):
    """Run f round the world; return the final state and the true one, in the order of ids."""
    rng = np.random.default_rng(seed)
    S, x, P, ids, truth = np.linalg.cholesky(U0), np.zeros(3), np.zeros((3, 3)), [], np.zeros(3)
    for _ in range(frames):
        truth = predict(truth, np.zeros((3, 3)), STEP, U0)[0]
        seen = [id for id in WORLD if measured(truth, id)[0] < 4.5]
        u = STEP + S @ rng.normal(size=3)
        x, P, ids = out(f(x, P, ids, u, U0, seen, scan(rng, truth, seen), R0), len(set(ids) | set(seen)))
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


@frame.wrong(
    "known landmarks started anew", "A known landmark is corrected, with all that is known of it: do not replace it."
)
def _(x, P, ids, u, U, seen, ys, R):
    x, P = predict(x, P, u, U)
    ids = list(ids)
    for id, y in zip(seen, ys, strict=True):
        if id not in ids:
            x, P, ids = *augment(x, P, y, R), [*ids, id]
            continue
        k = 3 + 2 * ids.index(id)
        kept = np.delete(np.arange(len(x)), [k, k + 1])
        x, P = augment(x[kept], P[np.ix_(kept, kept)], y, R)
        order = np.insert(np.arange(len(x) - 2), k, [len(x) - 2, len(x) - 1])
        x, P = x[order], P[np.ix_(order, order)]
    return x, P, ids
