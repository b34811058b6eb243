"""Exercise 20.2: a guard for predictions, which needs no other filter to compare with."""

import numpy as np

from ...geometry import numerical_jacobian, wrap
from ...models.motion import Unicycle
from .. import expect, museum
from ..table import table
from .nb04_blocks import random_covariance


def guard(predict, x, P, u, U):
    """What the P of a prediction is, minus what it should be: all zero (up to rounding) if there is no bug.

    predict(x, P, u, U) is the function under test: it returns the new x and P, for any motion model.
    x, shape (n,), and P, shape (n, n): joint state, heading in x[2], and its covariance. u, shape (k,): the control;
    U, shape (k, k): its covariance. Return the difference, shape (n, n).
    """
    x_new, P_new = predict(x, P, u, U)

    def moved(x, u):
        """Difference of the new means, the heading wrapped."""
        step = np.subtract(predict(x, P, u, U)[0], x_new)
        step[2] = wrap(step[2])
        return step

    F_x = numerical_jacobian(lambda x: moved(x, u), x)
    F_u = numerical_jacobian(lambda u: moved(x, u), u)
    D = P_new - (F_x @ P @ F_x.T + F_u @ U @ F_u.T)
    return D


def unicycle(x, P, u, U):
    """A right prediction for another control: u = [v, w]."""
    pose, X_x, X_u = Unicycle().move(x[:3], u, 1.0)
    return museum.join(pose, x), museum.propagate(P, X_x, X_u @ U @ X_u.T)


def with_speeds(x, P, u, U):
    """A right prediction of a robot with its speeds in the state, [x, y, theta, v, w]: u = [dv, dw]."""
    c, s, n = np.cos(x[2]), np.sin(x[2]), len(x)
    F, G, new = np.eye(n), np.zeros((n, 2)), x.copy()
    F[:2, 2], F[:2, 3], F[2, 4] = [-x[3] * s, x[3] * c], [c, s], 1
    G[3, 0] = G[4, 1] = 1
    new[:5] += [x[3] * c, x[3] * s, x[4], *u]
    return new, F @ P @ F.T + G @ U @ G.T


def one_sided(x, P, u, U):
    """A prediction with a bug: the columns of the robot stay behind, so that P is not symmetric."""
    new, moved = museum.predict(x, P, u, U)
    moved[3:, :3] = P[3:, :3]
    return new, moved


def wrapped(x, P, u, U):
    """A right prediction that keeps the heading in (-pi, pi]."""
    x, P = museum.predict(x, P, u, U)
    x[2] = wrap(x[2])
    return x, P


def case(rng, predict=museum.predict, n=7, k=3, at_seam=False):
    """A prediction and arguments at random: nothing zero, nothing symmetric."""
    x = rng.uniform(-4, 4, n)
    x[2] = rng.uniform(-2, 2)
    u = np.array([rng.uniform(0.5, 2), rng.uniform(0.2, 0.8), rng.uniform(0.2, 0.8)])[:k]
    if at_seam:
        x[2] = np.pi - u[2] - 1e-9
    return predict, x, random_covariance(rng, n), u, random_covariance(rng, k, 0.05)


def without_noise(D):
    """Return the difference without what finite differences leave of a zero."""
    D = np.asarray(D, float)
    return np.where(np.abs(D) < 1e-8, 0.0, D)


watch = table(
    "20.2 A guard for predictions",
    guard,
    hints=(
        "The new mean is a function of x and u. Its derivatives say what the new P must be, whatever the model is.",
        "F_x = numerical_jacobian(lambda x: predict(x, P, u, U)[0], x), and F_u the same for u. Then compare the new P with F_x P F_x' + F_u U F_u'.",
        "predict may wrap the heading: take the differences to the new x first, wrap entry 2 of them, and differentiate that. At the end: return P_new - (F_x @ P @ F_x.T + F_u @ U @ F_u.T).",
    ),
    seconds=1.8,
    returns="difference",
    symbols="F_x, F_u = the derivatives of the new x by x and by u; P_rr = P[:3, :3]; P_rm = P[:3, 3:]",
    form="The function must end with `return` and a matrix of the shape of P.",
    canonical=without_noise,
    cases={"any": lambda rng: [case(rng, n=n) for n in (7, 3)]},
    checks="",
    wrong="""
    seam forgotten | step[2] = wrap(step[2]) -> pass | Where the heading jumps by 2 pi, the finite differences do, too: wrap entry 2 of the difference to the new x before you differentiate.
    brackets of the wrapping | wrap(step[2]) -> (step[2] + np.pi) % 2 * np.pi - np.pi | `%` and `*` are done from left to right: (angle + pi) % (2 * pi) - pi needs the brackets round 2 * pi.
    only the robot's block | return D -> return np.pad(D[:3, :3], (0, len(D) - 3)) | You compare P_rr only. A filter that leaves P_rm behind passes your guard: compare all of the new P.
    noise forgotten | + F_u @ U @ F_u.T -> + 0 | The control is uncertain, too: F_u U F_u' is missing.
    noise added as it is | F_u @ U @ F_u.T -> np.pad(U, (0, len(P) - len(U))) | U is the covariance of the control. In the state it becomes F_u U F_u', with the Jacobian F_u by u.
    transposed | F_x @ P @ F_x.T -> F_x.T @ P @ F_x | Your guard has the very bug it should find: F_x P F_x', not F_x' P F_x.
    Jacobians after the step | moved(x, u), x) -> moved(x, u), x_new) | F_x and F_u are taken at x, before the step, not at the new state.
        lambda u: moved(x, u) -> lambda u: moved(x_new, u)
    F_x after the step | moved(x, u), x) -> moved(x, u), x_new) | F_x is taken at x, before the step, not at the new state.
    F_u at no control | lambda u: moved(x, u), u) -> lambda u: moved(x, u), 0 * u) | F_u is taken at u, the control that was given, not at zero.
    F_x of three numbers | F_x @ P @ F_x.T -> (F_x := np.eye(len(x)) + np.pad(F_x[:3, :3] - np.eye(3), (0, len(x) - 3))) @ P @ F_x.T | A motion model may have more than three numbers of its own, such as speeds: F_x is the derivative of the whole new x by the whole x.
    F_u of three numbers | F_u @ U @ F_u.T -> (F_u := np.pad(F_u[:3], ((0, len(x) - 3), (0, 0)))) @ U @ F_u.T | A motion model may have more than three numbers of its own, such as speeds: F_u has a row for each number of x.
    U left out | F_u @ U @ F_u.T -> F_u @ F_u.T | U belongs between the two: F_u U F_u'.
    other sign | return D -> return -D | The order is: what P is, minus what it should be.
    magnitude | return D -> return np.abs(D) | Give the difference with its sign, without abs: the sign tells whether P is too large or too small.
    symmetry only | return D -> return P_new - P_new.T | A symmetric P can be wrong: F_x' P F_x is symmetric. Compare the new P with F_x P F_x' + F_u U F_u'.
    compared with the known filter | return D -> return P_new - museum.predict(x, P, u, U)[1] | Your guard knows one motion model only. Let `predict` itself say how the mean moves, by finite differences.
    what P should be | return D -> return P_new - D | That is what P should be. The guard returns the difference to what P is.
    old P as it was | F_x @ P @ F_x.T -> P | P is moved by F_x: F_x P F_x', not P.
    diagonal only | return D -> return np.diag(np.diag(D)) | Covariances count as much as variances: compare the whole matrices.
    elementwise | F_x @ P @ F_x.T -> F_x * P * F_x.T | `*` multiplies entry by entry. The product of matrices is `@`.
    predicted without noise | x_new, P_new = predict(x, P, u, U) -> x_new, P_new = predict(x, P, u, 0 * U) | The P under test is what `predict` makes of x, P, u and U, all as they are: yours calls it with U = 0, and the noise is missing on that side.
    new P in what should be | F_x @ P @ F_x.T -> F_x @ P_new @ F_x.T | In F_x P F_x' stands the P before the step, not the new one.
    U squared | F_u @ U @ F_u.T -> F_u @ U @ U @ F_u.T | U is a covariance already: F_u U F_u'.
    made symmetric | return D -> return (D + D.T) / 2 | A P that is not symmetric is a bug that the guard is to show: return the difference as it is.
    derivatives twice as large: Your F_x and F_u are twice what they should be. In central differences the two points are two steps apart: divide by 2 s. numerical_jacobian does that.
        step[2] = wrap(step[2]) -> step[2] = wrap(step[2]); step = 2 * step
    derivatives half as large: Your F_x and F_u are half of what they should be. Divide a difference by the distance of its two points: one step, or two in central differences. numerical_jacobian does that.
        step[2] = wrap(step[2]) -> step[2] = wrap(step[2]); step = step / 2
    """,
)


def _link(name, help, *cases):
    """The difference must be the one wanted, but for the finite differences: others than ours are good to 1e-6."""

    @watch.link(name, help)
    def _(f, rng):
        for what, options in cases:
            args = case(rng, **options)
            got = expect.array(f(*args), args[2].shape, "the difference")
            expect.close(got, guard(*args), f"the difference for {what}", 1e-4, 1e-4 * np.abs(args[2]).max())


_link(
    "silent where nothing is wrong",
    "After a right prediction the difference is zero: the new P that `predict` returns, minus (F_x P F_x' + F_u U F_u'), with the P and U that it was given.",
    *(("the right prediction of notebook 05", {"n": n}) for n in (7, 3, 5)),
)
_link(
    "rings at wrong Jacobians",
    "The new P of `predict` is wrong here, its new x is right. Return the whole new P minus (F_x P F_x' + F_u U F_u'), with its signs; F_x and F_u come from the new x, and are taken at x and u, before the step.",
    ("P_rr multiplied entry by entry", {"predict": museum.predict_elementwise}),
    ("F_x' P F_x in place of F_x P F_x'", {"predict": museum.predict_transposed}),
    ("a last row 0 0 0 in the Jacobian", {"predict": museum.predict_no_heading}),
    ("sine and cosine swapped in the Jacobian", {"predict": museum.predict_swapped}),
    ("the Jacobian taken after the motion", {"predict": museum.predict_late}),
)
_link(
    "rings at P_rm",
    "The bug is in the covariance of the robot with the map: P_rm, or its mirror image below the diagonal, stays behind. The difference is that of the whole matrices, entry by entry, and it is not zero there.",
    ("a P_rm that stays behind", {"predict": museum.predict_pose_only}),
    ("a P_mr that stays behind, and P_rm does not", {"predict": one_sided}),
)
_link(
    "another motion model",
    "Another model, another number of controls, more numbers for the robot: F_x, n x n, and F_u, n x k, come from `predict` alone, all rows and columns. A right prediction gives zero.",
    ("a right unicycle, u = [v, w]", {"predict": unicycle, "n": 5, "k": 2}),
    ("a right prediction with the speeds in the state, [x, y, theta, v, w]", {"predict": with_speeds, "k": 2}),
)
_link(
    "seam of the heading",
    "This prediction wraps the heading, and the step ends at the seam. Differences of angles must be wrapped, in a test as well.",
    ("a right prediction that ends at a heading of pi", {"predict": wrapped, "at_seam": True}),
)
