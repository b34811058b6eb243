"""Exercise 11.4: noise that does not depend on the time step."""

import numpy as np

from ..table import table


def impulse_noise(sigma_v, sigma_w, dt):
    """Covariance of the impulse u = [dv, dw] of one step of dt seconds.

    sigma_v, sigma_w: standard deviation of each entry of dv (m/s) and of dw (rad/s) after *one second*. The impulses
    of different steps are independent.
    Return U, shape (6, 6), so that the velocities become as uncertain in one second whatever dt is.
    """
    return dt * np.diag([sigma_v**2] * 3 + [sigma_w**2] * 3)


exercise = table(
    "11.4 Noise per second",
    impulse_noise,
    hints=(
        "One second has 1/dt steps. What adds up when independent errors are added: standard deviations or variances?",
        "n steps of variance U give the variance n U. For n = 1/dt this must be sigma squared.",
        "U = dt sigma^2 on the diagonal, three times for v, three times for w.",
    ),
    returns="U",
    cases={
        "any": lambda rng: [tuple(float(v) for v in rng.uniform(0.05, 2.5, 3)) for _ in range(4)],
        "one second": lambda rng: [(0.3, 0.1, 1.0), (2.0, 0.7, 1.0)],
        "n steps": lambda rng: [(0.3, 0.1, 1 / n) for n in (5, 10, 50)],
        "noise of one": lambda rng: [(0.0, 0.4, 0.2), (0.4, 0.0, 0.2)],
    },
    checks="""
    one step of one second    | U | one second   | With dt = 1 s the variances are sigma squared: three of sigma_v, then three of sigma_w; nothing is correlated.
    the same after one second | U | n steps      | Variances of independent steps add: n U(1/n) must be U(1).
    any dt                    | U | any          | Half the step, half the variance.
    noise of one              | U | noise of one | One of the two sigmas is zero here, so three variances are zero; the other three are as in the checks before. U is a covariance, 6 x 6.
    """,
    wrong="""
    the same in each step | return dt * np -> return np | With this U a filter of 100 Hz becomes 100 times as uncertain (in variance) as one of 1 Hz: U must shrink with dt.
    sigma times dt | return dt * np -> return dt**2 * np | (sigma dt) squared is the impulse of an acceleration that stays the same for the step. Independent impulses: the *variance* goes with dt.
    std for variance | [sigma_v**2] * 3 + [sigma_w**2] * 3 -> [sigma_v] * 3 + [sigma_w] * 3 | A covariance holds variances: sigma squared.
    std with its square root | return dt * np.diag([sigma_v**2] * 3 + [sigma_w**2] * 3) -> return np.sqrt(dt) * np.diag([sigma_v] * 3 + [sigma_w] * 3) | sqrt(dt) sigma is the standard deviation: square it.
    divided by dt | return dt * np -> return 1 / dt * np | Shorter steps have *smaller* impulses: multiply by dt.
    variance with the root of dt | return dt * np -> return np.sqrt(dt) * np | The standard deviation goes with the root of dt, the variance with dt.
    v and w swapped | [sigma_v**2] * 3 + [sigma_w**2] * 3 -> [sigma_w**2] * 3 + [sigma_v**2] * 3 | The first three impulses are those of v.
    alternating | [sigma_v**2] * 3 + [sigma_w**2] * 3 -> [sigma_v**2, sigma_w**2] * 3 | u = [dv, dw]: first three times v, then three times w.
    v for all | [sigma_w**2] * 3 -> [sigma_v**2] * 3 | The turn rate has its own sigma_w.
    full of ones | np.diag([sigma_v**2] * 3 + [sigma_w**2] * 3) -> np.outer([sigma_v] * 3 + [sigma_w] * 3, [sigma_v] * 3 + [sigma_w] * 3) | Independent impulses: nothing beside the diagonal.
    the sum of one second | return dt * np -> return dt / 3 * np | sigma is that of each axis: a variance is not shared among the three.
    three impulses as one | np.diag([sigma_v**2] * 3 + [sigma_w**2] * 3) -> np.kron(np.diag([sigma_v**2, sigma_w**2]), np.ones((3, 3))) | The three entries of an impulse are independent: beside its diagonal U is zero.
    dt forgotten for w | [sigma_w**2] * 3 -> [sigma_w**2 / dt] * 3 | Both variances go with dt, that of dw, too.
    dt forgotten for v | [sigma_v**2] * 3 -> [sigma_v**2 / dt] * 3 | Both variances go with dt, that of dv, too.
    """,
)
