"""Exercise 20.2: a guard for predictions, which needs no other filter to compare with."""

import numpy as np

from ...geometry import numerical_jacobian, wrap
from ...models.motion import Unicycle
from .. import expect, museum
from ..exercise import Exercise
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
    return P_new - (F_x @ P @ F_x.T + F_u @ U @ F_u.T)


watch = Exercise(
    "20.2",
    "A guard for predictions",
    guard,
    hints=(
        "The new mean is a function of x and u. Its derivatives say what the new P must be, whatever the model is.",
        "F_x = numerical_jacobian(lambda x: predict(x, P, u, U)[0], x), and F_u the same for u. Then compare P2 with "
        "F_x P F_x' + F_u U F_u'.",
        "predict may wrap the heading: take the differences to x2 first, wrap entry 2 of them, and differentiate "
        "that. At the end: return P2 - (F_x @ P @ F_x.T + F_u @ U @ F_u.T).",
    ),
    seconds=1.8,
)


def unicycle(x, P, u, U):
    """A right prediction for another control: u = [v, w]."""
    pose, X_x, X_u = Unicycle().move(x[:3], u, 1.0)
    return museum.join(pose, x), museum.propagate(P, X_x, X_u @ U @ X_u.T)


def wrapped(x, P, u, U):
    """A right prediction that keeps the heading in (-pi, pi]."""
    x, P = museum.predict(x, P, u, U)
    x[2] = wrap(x[2])
    return x, P


def case(rng, n=7, k=3):
    """Arguments at random: nothing zero, nothing symmetric."""
    x = rng.uniform(-4, 4, n)
    x[2] = rng.uniform(-2, 2)
    u = np.array([rng.uniform(0.5, 2), rng.uniform(0.2, 0.8), rng.uniform(0.2, 0.8)])[:k]
    return x, random_covariance(rng, n), u, random_covariance(rng, k, 0.05)


def difference(f, predict, arguments):
    """The student's answer as an array."""
    n = len(arguments[0])
    return expect.array(f(predict, *arguments), (n, n), "the difference")


def wanted(predict, arguments):
    """What the guard should return."""
    return guard(predict, *arguments)


RTOL = 1e-4  # of the largest entry of P: other finite differences than ours are good to 1e-6


def same(got, predict, arguments, what):
    """The difference must be the one wanted."""
    want = wanted(predict, arguments)
    scale = np.abs(arguments[1]).max()
    expect.close(got, want, f"the difference for {what}", 1e-4, RTOL * scale)


@watch.link("shape", "The function must end with `return` and a matrix of the shape of P.")
def _(f, rng):
    for n in (7, 3):
        difference(f, museum.predict, case(rng, n))


@watch.link("silent where nothing is wrong", "A right prediction must give zero: P2 - (F_x P F_x' + F_u U F_u').")
def _(f, rng):
    for n in (7, 3, 5):
        c = case(rng, n)
        same(difference(f, museum.predict, c), museum.predict, c, "the right prediction of notebook 05")


MUTANTS = {
    "predict_elementwise": "P_rr multiplied entry by entry",
    "predict_transposed": "F_x' P F_x in place of F_x P F_x'",
    "predict_no_heading": "a last row 0 0 0 in the Jacobian",
    "predict_swapped": "sine and cosine swapped in the Jacobian",
    "predict_late": "the Jacobian taken after the motion",
}


@watch.link(
    "rings at wrong Jacobians",
    "Compare the whole P2 with F_x P F_x' + F_u U F_u', F_x and F_u taken at x, before the step.",
)
def _(f, rng):
    for name, what in MUTANTS.items():
        c, predict = case(rng), getattr(museum, name)
        same(difference(f, predict, c), predict, c, what)


@watch.link("rings at P_rm", "The covariance of the robot with the map, P_rm, belongs to the comparison, too.")
def _(f, rng):
    c = case(rng)
    same(difference(f, museum.predict_pose_only, c), museum.predict_pose_only, c, "a P_rm that stays behind")


@watch.link("another motion model", "The guard must not know the model: take F_x and F_u from `predict` alone.")
def _(f, rng):
    c = case(rng, 5, 2)
    same(difference(f, unicycle, c), unicycle, c, "a right unicycle, u = [v, w]")


@watch.link(
    "seam of the heading",
    "This prediction wraps the heading, and the step ends at the seam. Differences of angles must be wrapped, in a "
    "test as well.",
)
def _(f, rng):
    x, P, u, U = case(rng)
    x[2] = np.pi - u[2] - 1e-9
    same(difference(f, wrapped, (x, P, u, U)), wrapped, (x, P, u, U), "a right prediction that ends at a heading of pi")


# ---- wrong and right answers ---------------------------------------------------------------------------------------


def parts(predict, x, P, u, U, at=None):
    """x2, P2, and F_x and F_u with wrapped headings, taken at x or at another place."""
    x2, P2 = predict(x, P, u, U)

    def moved(a, u):
        """Difference of the new means, the heading wrapped."""
        step = predict(a, P, u, U)[0] - x2
        step[2] = wrap(step[2])
        return step

    at = x if at is None else at
    return x2, P2, numerical_jacobian(lambda a: moved(a, u), at), numerical_jacobian(lambda b: moved(at, b), u)


@watch.wrong("seam forgotten", "Where the heading jumps by 2 pi, the finite differences do, too: wrap entry 2 of the "
             "difference to x2 before you differentiate.")  # fmt: skip
def _(predict, x, P, u, U):
    x2, P2 = predict(x, P, u, U)
    F_x = numerical_jacobian(lambda x: predict(x, P, u, U)[0], x)
    F_u = numerical_jacobian(lambda u: predict(x, P, u, U)[0], u)
    return P2 - (F_x @ P @ F_x.T + F_u @ U @ F_u.T)


@watch.wrong("only the robot's block", "You compare P_rr only. A filter that leaves P_rm behind passes your guard: "
             "compare all of P2.")  # fmt: skip
def _(predict, x, P, u, U):
    _, P2, F_x, F_u = parts(predict, x, P, u, U)
    D = np.zeros_like(P2)
    D[:3, :3] = (P2 - (F_x @ P @ F_x.T + F_u @ U @ F_u.T))[:3, :3]
    return D


@watch.wrong("noise forgotten", "The control is uncertain, too: F_u U F_u' is missing.")
def _(predict, x, P, u, U):
    _, P2, F_x, _ = parts(predict, x, P, u, U)
    return P2 - F_x @ P @ F_x.T


@watch.wrong("noise added as it is", "U is the covariance of the control. In the state it becomes F_u U F_u', with the "
             "Jacobian F_u by u.")  # fmt: skip
def _(predict, x, P, u, U):
    _, P2, F_x, _ = parts(predict, x, P, u, U)
    want = F_x @ P @ F_x.T
    want[: len(U), : len(U)] += U
    return P2 - want


@watch.wrong("transposed", "Your guard has the very bug it should find: F_x P F_x', not F_x' P F_x.")
def _(predict, x, P, u, U):
    _, P2, F_x, F_u = parts(predict, x, P, u, U)
    return P2 - (F_x.T @ P @ F_x + F_u @ U @ F_u.T)


@watch.wrong("Jacobians after the step", "F_x and F_u are taken at x, before the step, not at the new state.")
def _(predict, x, P, u, U):
    x2 = predict(x, P, u, U)[0]
    _, P2, F_x, F_u = parts(predict, x, P, u, U, at=x2)
    return P2 - (F_x @ P @ F_x.T + F_u @ U @ F_u.T)


@watch.wrong("other sign", "The order is: what P is, minus what it should be.")
def _(predict, x, P, u, U):
    _, P2, F_x, F_u = parts(predict, x, P, u, U)
    return F_x @ P @ F_x.T + F_u @ U @ F_u.T - P2


@watch.wrong(
    "magnitude", "Give the difference with its sign, without abs: the sign tells whether P is too large or too small."
)
def _(predict, x, P, u, U):
    _, P2, F_x, F_u = parts(predict, x, P, u, U)
    return np.abs(P2 - (F_x @ P @ F_x.T + F_u @ U @ F_u.T))


@watch.wrong("symmetry only", "A symmetric P can be wrong: F_x' P F_x is symmetric. Compare P2 with F_x P F_x' "
             "+ F_u U F_u'.")  # fmt: skip
def _(predict, x, P, u, U):
    P2 = predict(x, P, u, U)[1]
    return P2 - P2.T


@watch.wrong("compared with the known filter", "Your guard knows one motion model only. Let `predict` itself say how "
             "the mean moves, by finite differences.")  # fmt: skip
def _(predict, x, P, u, U):
    return predict(x, P, u, U)[1] - museum.predict(x, P, u, U)[1]


@watch.wrong("what P should be", "That is what P should be. The guard returns the difference to what P is.")
def _(predict, x, P, u, U):
    _, _, F_x, F_u = parts(predict, x, P, u, U)
    return F_x @ P @ F_x.T + F_u @ U @ F_u.T


@watch.wrong("old P as it was", "P is moved by F_x: F_x P F_x', not P.")
def _(predict, x, P, u, U):
    _, P2, _, F_u = parts(predict, x, P, u, U)
    return P2 - (P + F_u @ U @ F_u.T)


@watch.wrong("diagonal only", "Covariances count as much as variances: compare the whole matrices.")
def _(predict, x, P, u, U):
    _, P2, F_x, F_u = parts(predict, x, P, u, U)
    return np.diag(np.diag(P2 - (F_x @ P @ F_x.T + F_u @ U @ F_u.T)))


@watch.wrong("elementwise", "`*` multiplies entry by entry. The product of matrices is `@`.")
def _(predict, x, P, u, U):
    _, P2, F_x, F_u = parts(predict, x, P, u, U)
    return P2 - (F_x * P * F_x.T + F_u @ U @ F_u.T)


@watch.variant("one Jacobian of everything")
def _(predict, x, P, u, U):
    n, (x2, P2) = len(x), predict(x, P, u, U)

    def moved(a):
        d = predict(a[:n], P, a[n:], U)[0] - x2
        d[2] = np.arctan2(np.sin(d[2]), np.cos(d[2]))
        return d

    J = numerical_jacobian(moved, np.concatenate([x, u]))
    S = np.zeros((n + len(u), n + len(u)))
    S[:n, :n], S[n:, n:] = P, U
    return (P2 - J @ S @ J.T).tolist()


@watch.variant("differences by hand")
def _(predict, x, P, u, U):
    x2, P2 = predict(x, P, u, U)

    def column(dx, du):
        d = predict(x + dx, P, u + du, U)[0] - predict(x - dx, P, u - du, U)[0]
        d[2] = (d[2] + np.pi) % (2 * np.pi) - np.pi
        return d / 2e-5

    F_x = np.array([column(h, 0 * u) for h in 1e-5 * np.eye(len(x))]).T
    F_u = np.array([column(0 * x, h) for h in 1e-5 * np.eye(len(u))]).T
    return np.subtract(P2, F_x @ P @ F_x.T) - F_u @ U @ F_u.T


@watch.variant("sine and cosine of the heading turned back")
def _(predict, x, P, u, U):
    x2, P2 = predict(x, P, u, U)

    def mean(x, u):
        new = np.array(predict(x, P, u, U)[0])
        new[2] += 2 * np.pi * np.round((x2[2] - new[2]) / (2 * np.pi))
        return new

    F_x = numerical_jacobian(lambda x: mean(x, u), x)
    F_u = numerical_jacobian(lambda u: mean(x, u), u)
    return P2 - F_x @ P @ F_x.T - F_u @ U @ F_u.T
