"""Exercise 11.4: noise that does not depend on the time step."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def impulse_noise(sigma_v, sigma_w, dt):
    """Covariance of the impulse u = [dv, dw] of one step of dt seconds.

    sigma_v, sigma_w: standard deviation of each entry of dv (m/s) and of dw (rad/s) after *one second*. The impulses
    of different steps are independent.
    Return U, shape (6, 6), so that the velocities become as uncertain in one second whatever dt is.
    """
    return dt * np.diag([sigma_v**2] * 3 + [sigma_w**2] * 3)


exercise = Exercise(
    "11.4",
    "Noise per second",
    impulse_noise,
    hints=(
        "One second has 1/dt steps. What adds up when independent errors are added: standard deviations or variances?",
        "n steps of variance U give the variance n U. For n = 1/dt this must be sigma squared.",
        "U = dt sigma^2 on the diagonal, three times for v, three times for w.",
    ),
)


def _U(result):
    return expect.array(result, (6, 6), "U")


@exercise.link("a 6 x 6 matrix", "Return the covariance of the six impulses.")
def _(f, rng):
    _U(f(0.3, 0.1, 0.1))


@exercise.link("one step of one second", "With dt = 1 s the variances are sigma squared; nothing is correlated.")
def _(f, rng):
    for sigma_v, sigma_w in ((0.3, 0.1), (2.0, 0.7)):
        U = _U(f(sigma_v, sigma_w, 1.0))
        want = np.diag([sigma_v**2] * 3 + [sigma_w**2] * 3)
        expect.close(U, want, "U", at=f"sigma_v = {sigma_v}, sigma_w = {sigma_w}, dt = 1 s")


@exercise.link("the same after one second", "Variances of independent steps add: n U(1/n) must be U(1).")
def _(f, rng):
    for n in (2, 10, 50):
        one, many = np.diag([0.09] * 3 + [0.01] * 3), n * _U(f(0.3, 0.1, 1 / n))
        expect.close(many, one, "the sum of the covariances of all steps", at=f"one second in {n} steps")


@exercise.link("any dt", "Half the step, half the variance.")
def _(f, rng):
    for _ in range(4):
        sigma_v, sigma_w, dt = (float(v) for v in rng.uniform(0.05, 2.5, 3))
        whole = _U(f(sigma_v, sigma_w, dt))
        expect.close(whole, 2 * _U(f(sigma_v, sigma_w, dt / 2)), "U(dt)", at="two halves of it")
        expect.close(whole, dt * np.diag([sigma_v**2] * 3 + [sigma_w**2] * 3), "U", at=f"dt = {dt:.2f} s")
        expect.symmetric(whole, "U")
        expect.psd(whole, "U")


def _diag(v, w):
    return np.diag([v] * 3 + [w] * 3)


# fmt: off
exercise.wrong("the same in each step", "With this U a filter of 100 Hz becomes 100 times as uncertain (in variance) "
               "as one of 1 Hz: U must shrink with dt.")(lambda v, w, dt: _diag(v**2, w**2))
exercise.wrong("sigma times dt", "(sigma dt) squared is the impulse of an acceleration that stays the same for the "
               "step. Independent impulses: the *variance* goes with dt.")(
    lambda v, w, dt: _diag((v * dt) ** 2, (w * dt) ** 2))
exercise.wrong("std for variance", "A covariance holds variances: sigma squared.")(lambda v, w, dt: dt * _diag(v, w))
exercise.wrong("std with its square root", "sqrt(dt) sigma is the standard deviation: square it.")(
    lambda v, w, dt: np.sqrt(dt) * _diag(v, w))
exercise.wrong("divided by dt", "Shorter steps have *smaller* impulses: multiply by dt.")(
    lambda v, w, dt: _diag(v**2, w**2) / dt)
exercise.wrong("variance with the root of dt", "The standard deviation goes with the root of dt, the variance with "
               "dt.")(lambda v, w, dt: np.sqrt(dt) * _diag(v**2, w**2))
exercise.wrong("v and w swapped", "The first three impulses are those of v.")(
    lambda v, w, dt: dt * _diag(w**2, v**2))
exercise.wrong("alternating", "u = [dv, dw]: first three times v, then three times w.")(
    lambda v, w, dt: dt * np.diag([v**2, w**2] * 3))
exercise.wrong("v for all", "The turn rate has its own sigma_w.")(lambda v, w, dt: dt * v**2 * np.eye(6))
exercise.wrong("full of ones", "Independent impulses: nothing beside the diagonal.")(
    lambda v, w, dt: dt * np.outer([v] * 3 + [w] * 3, [v] * 3 + [w] * 3))
# fmt: on


@exercise.variant("a square root, as lists")
def _(sigma_v, sigma_w, dt):
    S = np.sqrt(dt) * np.diag(np.repeat([sigma_v, sigma_w], 3))
    return (S @ S.T).tolist()


@exercise.variant("entry by entry")
def _(sigma_v, sigma_w, dt):
    U = np.zeros((6, 6))
    for i in range(6):
        U[i, i] = (sigma_v if i < 3 else sigma_w) ** 2 / (1 / dt)
    return U
