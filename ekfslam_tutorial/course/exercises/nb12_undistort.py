"""Exercise 12.5: the way back through the lens."""

import numpy as np

from ...models.sensors.lens import exact_undistort
from .. import expect
from ..table import table
from .nb12_distort import distort


def undistort(ud, d):
    """The ideal image point of a distorted one: `distort(up, d)` must give ud again, to 1e-6.

    ud, shape (2,), is the distorted point; it may be [0, 0]. d, shape (n,), is the distortion vector, maybe empty.
    ud lies well before the fold of the lens, so that there is one answer near the axis: the one that is wanted.
    `distort(up, d)` returns the distorted point, its derivative UD_up, shape (2, 2), and one by d.
    Return up, shape (2,), and UP_ud, shape (2, 2): its derivative by ud.
    """
    up = ud.copy()
    for _ in range(20):
        u, UD_up, _ = distort(up, d)
        up = up + np.linalg.solve(UD_up, ud - u)
    UP_ud = np.linalg.inv(distort(up, d)[1])
    return up, UP_ud


LENSES = ([-0.25], [-0.3, 0.09], [0.2], [-0.28, 0.1, -0.02], [0.05, 0.1])


def case(rng, d, r=None):
    """A distorted point whose ideal one has the radius r, and the lens."""
    a, r = rng.uniform(-np.pi, np.pi), rng.uniform(0.4, 0.75) if r is None else r
    return distort(r * np.array([np.cos(a), np.sin(a)]), np.array(d))[0], np.array(d)


undistorted = table(
    "12.5 The way back",
    undistort,
    hints=(
        "No formula: solve distort(up, d) = ud. Start at up = ud, and repeat a step that makes the difference smaller.",
        "Newton: up + inv(UD_up) (ud - distorted point). Or simply up = ud / f(up), some 60 times.",
        "The derivative of an inverse is the inverse of the derivative: UP_ud = inv(UD_up), with UD_up taken at up.",
    ),
    returns="up, UP_ud",
    cases={"any": lambda rng: [case(rng, [-0.2]), case(rng, [0.1, 0.05])]},
    checks="",
    wrong="""
    minus d | return up -> return distort(ud, -d)[0] | distort(ud, -d) is only a first guess. Try the round trip: distort(up, d) does not give ud.
    minus d in all: distort(ud, -d) is only a first guess, and so is its derivative. Try the round trip: distort(up, d) does not give ud.
        return up -> return distort(ud, -d)[0]
        np.linalg.inv(distort(up, d)[1]) -> distort(ud, -d)[1]
    divided once | range(20) -> range(1) | ud / f(ud) uses f at the distorted point. It is a first step: put its result into f, and repeat.
        up + np.linalg.solve(UD_up, ud - u) -> ud / _f(up, d)
    divided twice | range(20) -> range(2) | Two steps are not enough. Repeat until nothing changes.
        up + np.linalg.solve(UD_up, ud - u) -> ud / _f(up, d)
    divided thrice | range(20) -> range(3) | Three steps are not enough. Repeat until nothing changes.
        up + np.linalg.solve(UD_up, ud - u) -> ud / _f(up, d)
    distorted once more | return up -> return distort(ud, d)[0] | distort goes from up to ud. The way back is its inverse.
    returned as it came | return up -> return ud | ud is where you start, not the answer: distort(up, d) must give ud.
    one Newton step | range(20) -> range(1) | This is up after one Newton step, and not yet the answer: go on until distort(up, d) gives ud to 1e-6.
    two Newton steps | range(20) -> range(2) | This is up after two Newton steps, and not yet the answer: go on until distort(up, d) gives ud to 1e-6.
    Jacobian not inverted | np.linalg.inv(distort(up, d)[1]) -> distort(up, d)[1] | UD_up is the derivative of the way there. That of the way back is its inverse.
    Jacobian at the distorted point | np.linalg.inv(distort(up, d)[1]) -> np.linalg.inv(distort(ud, d)[1]) | UD_up must be taken at up, the result, not at ud.
    1 / f for the Jacobian | np.linalg.inv(distort(up, d)[1]) -> np.eye(2) / _f(up, d) | f changes with up as well: invert the whole matrix UD_up.
    entries inverted one by one | np.linalg.inv(distort(up, d)[1]) -> np.array([[1 / v if v else 0 for v in row] for row in distort(up, d)[1]]) | 1 / UD_up inverts each entry. The inverse of a matrix is np.linalg.inv.
    Jacobian with minus d | np.linalg.inv(distort(up, d)[1]) -> distort(ud, -d)[1] | The derivative of the inverse is inv(UD_up); distort with -d has another one.
    identity | np.linalg.inv(distort(up, d)[1]) -> np.eye(2) | The lens stretches: UP_ud is I only in the middle of the image.
    multiplied by f: ud = f up, so up is ud *divided* by f(up): yours multiplies.
        up = up + np.linalg.solve(UD_up, ud - u) -> up = ud * _f(up, d)
    minus d, and the Jacobian there: distort(ud, -d) is only a first guess. Try the round trip: distort(up, d) does not give ud.
        up = ud.copy() -> up = distort(ud, -d)[0]
        range(20) -> range(0)
    first order of the inverse | np.linalg.inv(distort(up, d)[1]) -> 2 * np.eye(2) - distort(up, d)[1] | 2 I - UD_up is the inverse to first order only: for a strong lens take np.linalg.inv.
    diagonal inverted | np.linalg.inv(distort(up, d)[1]) -> np.diag(1 / np.diag(distort(up, d)[1])) | The inverse of a matrix is not that of its diagonal: np.linalg.inv of the whole UD_up.
    no step made | range(20) -> range(0) | ud is where you start, not the answer. No step is made, or its result is not kept: go on until distort(up, d) gives ud.
    lens on the result, no step made | range(20) -> range(0) | ud is where you start, not the answer, and distort goes from up to ud: go on until distort(up, d) gives ud.
        return up -> return distort(ud, d)[0]
    ten simple steps: This is up after ten simple steps, up + ud - distort(up, d), and near the fold they are too few: go on until distort(up, d) gives ud to 1e-6, or take Newton's step.
        np.linalg.solve(UD_up, ud - u) -> ud - u
        range(20) -> range(10)
    twenty simple steps: This is up after twenty simple steps, up + ud - distort(up, d), and near the fold they are too few: go on until distort(up, d) gives ud to 1e-6, or take Newton's step.
        np.linalg.solve(UD_up, ud - u) -> ud - u
    five simple steps: This is up after five simple steps, up + ud - distort(up, d), and they are too few: go on until distort(up, d) gives ud to 1e-6, or take Newton's step.
        np.linalg.solve(UD_up, ud - u) -> ud - u
        range(20) -> range(5)
    """,
)


def _f(u, d):
    return 1 + (u @ u) ** np.arange(1, len(d) + 1) @ d


def _link(name, help, cases, rtol=2e-6):
    """The point must be the one wanted, to about 1e-6: a student stops there."""

    @undistorted.link(name, help, part=0)
    def _(f, rng):
        for ud, d in cases(rng):
            up = expect.array(expect.results(f(ud, d), "up", "UP_ud")[0], 2, "up")
            expect.close(up, undistort(ud, d)[0], "up", rtol, 2e-6, at=f"ud = {ud.round(3)}, d = {d.tolist()}")


_link(
    "an ideal lens",
    "Where d = 0, or empty, nothing has been bent: up = ud.",
    lambda rng: [case(rng, d) for d in ([0.0], [0.0, 0.0], [])],
)
_link(
    "there and back",
    "distort(up, d) must give ud again, to 1e-6, with the up nearest to the axis. Repeat a step until it does: divide ud by f(up), or add inv(UD_up) times what is missing, ud - distort(up, d).",
    lambda rng: [case(rng, d) for d in LENSES],
)
_link(
    "in the middle of the image",
    "ud = [0, 0] is the middle of the image, where the lens does nothing: up = [0, 0]. The length of ud is zero here.",
    lambda rng: [(np.zeros(2), np.array([-0.25, 0.05]))],
)
_link(
    "near the fold",
    "Near the fold the way back is steep, and more steps may be needed: distort(up, d) must be ud to 1e-6, with up before the fold, which is at the length 1.155 here.",
    lambda rng: [case(rng, [-0.25], 0.95)],  # the fold is at 1.155
    5e-6,
)


@undistorted.link(
    "UP_ud", "UP_ud is the inverse of UD_up at up, the point for which distort(up, d) is ud to 1e-6.", part=1
)
def _(f, rng):
    for ud, d in (*(case(rng, d) for d in LENSES[:4]), (np.zeros(2), np.array([-0.25, 0.05]))):
        back = lambda x, d=d: exact_undistort(x, d)[0]
        J = expect.array(expect.results(f(ud, d), "up", "UP_ud")[1], (2, 2), "UP_ud")
        expect.jacobian(J, back, ud, "UP_ud", "xy", "xy", rtol=1e-4)
