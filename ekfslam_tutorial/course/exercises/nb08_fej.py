"""Exercise 08.2: a correction with first-estimates Jacobians."""

import numpy as np

from ...geometry import Frame2, wrap
from ...models.sensors.range_bearing import polar
from .. import expect
from ..table import table
from .nb04_blocks import random_covariance


def observe(x, i):
    """Expected measurement [range, bearing] of landmark i, shape (2,), and its Jacobian, shape (2, n).

    x, shape (n,): the robot's pose [x, y, theta], then the landmarks, two numbers each; i counts from 0.
    """
    l = slice(3 + 2 * i, 5 + 2 * i)
    p, P_r, P_l = Frame2(x[:3]).to_frame(x[l])
    e, E_p = polar(p)
    H = np.zeros((2, len(x)))
    H[:, :3], H[:, l] = E_p @ P_r, E_p @ P_l
    return e, H


def correct_fej(x, P, y, i, x_first, R):
    """Correct the joint state with first-estimates Jacobians.

    x, shape (n,): the robot's pose [x, y, theta], then the landmarks; P, shape (n, n): its covariance.
    y = [range, bearing] of landmark i (counted from 0); R, shape (2, 2): its covariance.
    x_first, shape (n,): the first estimates, where the Jacobian is taken. observe(x, i) returns e and H at x.
    Return the new x and P.
    """
    e, _ = observe(x, i)
    _, H = observe(x_first, i)
    z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
    Z = H @ P @ H.T + R
    K = np.linalg.solve(Z, H @ P).T
    return x + K @ z, P - K @ Z @ K.T


def case(rng, n=2, i=None, z=None):
    """Return the arguments at random; the first estimates are close to x, but clearly others."""
    x_first = np.concatenate([rng.uniform(-1, 1, 2), [rng.uniform(-3, 3)], rng.uniform(3, 9, 2 * n)])
    P = random_covariance(rng, 3 + 2 * n, 0.05)
    x = x_first + rng.uniform(0.1, 0.4, len(x_first)) * rng.choice([-1, 1], len(x_first))
    i = int(rng.integers(n)) if i is None else i
    R = random_covariance(rng, 2, 0.02)
    y = observe(x, i)[0] + (rng.normal(size=2) * [0.3, 0.1] if z is None else z)
    return x, P, np.array([y[0], wrap(y[1])]), i, x_first, R


def ordinary(rng, n):
    """Return the same where the first estimate is the estimate."""
    x, P, y, i, _, R = case(rng, n)
    return x, P, y, i, x, R


def behind(rng, side):
    """Return a landmark behind the robot: the bearings of y and e lie on both sides of the seam."""
    x, P, y, i, x_first, R = case(rng, 2, 1)
    back = np.arctan2(*(x[5:7] - x[:2])[::-1]) + np.pi - side * 0.02
    x_first[2] += back - x[2]
    x[2] = back
    e = observe(x, 1)[0]
    return x, P, np.array([e[0] + 0.1, wrap(e[1] - side * 0.05)]), i, x_first, R


fej = table(
    "08.2 First-estimates Jacobians",
    correct_fej,
    hints=(
        "Only one thing differs from the ordinary correction: *where* the Jacobian H is taken. What stays as it was?",
        "Two calls of observe: the expectation e at the present x, the Jacobian H at x_first.",
        "z = y - e with the bearing wrapped, Z = H P H' + R, K = P H' inv(Z); x + K z, and (I - K H) P.",
    ),
    returns="x, P",
    angles={"x": 2},
    cases={
        "any": lambda rng: [case(rng, n) for n in (1, 2, 4)],
        "ordinary": lambda rng: [ordinary(rng, n) for n in (2, 1, 3)],
        "expected": lambda rng: [case(rng, z=0.0) for _ in range(3)],
        "sizes": lambda rng: [case(rng, n) for n in (1, 2, 3)],
        "behind": lambda rng: [behind(rng, side) for side in (-1, 1)],
        "aside": lambda rng: [case(rng, 2, 1, z=np.array([0.1, off])) for off in (2.0, -2.5)],
        "far": lambda rng: [case(rng, 2, 1, z=np.array([far, 0.05])) for far in (4.0, -3.6)],
    },
    checks="""
    first estimate = estimate | x, P | ordinary | If x_first is x, this is the ordinary EKF correction with landmark i: x + K z and P - K Z K', with z = y - e (bearing wrapped), Z = H P H' + R and K = P H' inv(Z).
    no innovation, no change  | x    | expected | Here y is just what the present x makes us expect. e is taken at x, its pose and its landmark: z = y - e is zero, and the new mean x + K z is x.
    covariance                | P    | sizes    | H is taken at x_first, its pose and its landmark. This H stands in Z = H P H' + R, in K = P H' inv(Z) and in the new P, (I - K H) P.
    mean                      | x    | sizes    | e is taken at x: the innovation is what it always was. The gain comes from x_first.
    seam of the bearing       | x    | behind   | A landmark behind the robot: the bearings of y and e are near the seam, +-pi. The bearing of z is wrapped into -pi ... pi: it is small here, above or below 0.
    a bearing far off         | x    | aside    | The bearing of y - e is 2 rad here, and then -2.5 rad, or a whole turn more or less. Wrapped it lies between -pi and pi.
    the range is no angle     | x    | far      | Only the bearing is wrapped: a range may be off by more than pi.
    """,
    wrong="""
    ordinary EKF | _, H = observe(x_first, i) -> _, H = observe(x, i) | With H at the present x it is the ordinary EKF: take H at x_first.
    all at the first estimate | e, _ = observe(x, i) -> e, _ = observe(x_first, i) | The expectation e belongs to the present x. Only the Jacobian is taken at x_first.
    the two places swapped | _, H = observe(x_first, i) -> e, H = observe(x_first, i)[0], observe(x, i)[1] | It is the other way round: e at the present x, H at x_first.
    first estimate of the robot only | observe(x_first, i) -> observe(np.concatenate([x_first[:3], x[3:]]), i) | The landmark, too, is taken at its first estimate: H at the whole x_first.
    first estimate of the landmark only | observe(x_first, i) -> observe(np.concatenate([x[:3], x_first[3:]]), i) | The pose, too, is taken at its first estimate: H at the whole x_first.
    correction added to x_first | return x + K @ z -> return x_first + K @ z | Add the correction to the present x: x + K z.
    half turns removed | wrap(y[1] - e[1]) -> np.arctan(np.tan(y[1] - e[1])) | A whole turn is 2 pi. Directions that differ by pi are opposite, not the same.
    arcsine of the sine | wrap(y[1] - e[1]) -> np.arcsin(np.sin(y[1] - e[1])) | An arcsine ends at 90 degrees: a difference of 100 degrees becomes one of 80. arctan2(sine, cosine) knows all directions.
    bearing not wrapped | wrap(y[1] - e[1]) -> y[1] - e[1] | Near the seam y and e may differ by 2 pi: wrap the bearing of z.
    bearing not wrapped, nor expected so | wrap(y[1] - e[1]) -> y[1] - (np.arctan2(x[4 + 2 * i] - x[1], x[3 + 2 * i] - x[0]) - x[2]) | Near the seam y and e may differ by 2 pi: wrap the bearing of z.
    all at the first estimate, not wrapped | e, _ = observe(x, i) -> e, _ = observe(x_first, i) | Two things. Near the seam y and e may differ by 2 pi: wrap the bearing of z. And the expectation e belongs to the present x: only the Jacobian is taken at x_first.
        wrap(y[1] - e[1]) -> y[1] - (np.arctan2(x_first[4 + 2 * i] - x_first[1], x_first[3 + 2 * i] - x_first[0]) - x_first[2])
    brackets forgotten | wrap(y[1] - e[1]) -> (y[1] - e[1] + np.pi) % 2 * np.pi - np.pi | Python reads `% 2*np.pi` as `(... % 2) * np.pi`. The whole turn needs brackets: % (2 * np.pi).
    wrapped to 0 ... 2 pi | wrap(y[1] - e[1]) -> (y[1] - e[1]) % (2 * np.pi) | A small negative difference must stay small and negative: wrap into -pi ... pi.
    bearing in degrees | wrap(y[1] - e[1]) -> np.degrees(wrap(y[1] - e[1])) | Angles are in radians everywhere.
    range wrapped, too | [y[0] - e[0], -> [wrap(y[0] - e[0]), | The range is a distance, not an angle: wrap z[1] only.
    K H transposed | P - K @ Z @ K.T -> P - (K @ H).T @ P | K H P, in this order and not transposed: yours is P - (K H)' P.
    innovation with the wrong sign | Z = H @ P -> z = -z; Z = H @ P | The innovation is measured minus expected: z = y - e.
    R forgotten in Z | H @ P @ H.T + R -> H @ P @ H.T | Z = H P H' + R: the noise of the measurement is missing.
    R counted twice | H @ P @ H.T + R -> H @ P @ H.T + 2 * R | Z = H P H' + R: the noise of the measurement counts once.
    R squared | H @ P @ H.T + R -> H @ P @ H.T + R @ R | R holds variances already: do not square it.
    only the diagonal of R | H @ P @ H.T + R -> H @ P @ H.T + np.diag(np.diag(R)) | Use the whole R: the noise of range and bearing may be correlated.
    mean not corrected | return x + K @ z -> return x.copy() | The innovation moves the present x: x + K z.
    covariance not corrected | P - K @ Z @ K.T -> P | P shrinks in a correction: (I - K H) P.
    covariance added | P - K @ Z @ K.T -> P + K @ Z @ K.T | The measurement brings information: K Z K' is subtracted.
    always the first landmark | observe(x, i) -> observe(x, 0) | y belongs to landmark i: observe(..., i).
        observe(x_first, i) -> observe(x_first, 0)
    gain at x, covariance at x_first | return x + K @ z -> G = observe(x, i)[1]; return x + P @ G.T @ np.linalg.inv(G @ P @ G.T + R) @ z | One H, taken at x_first, for the gain and for the covariance.
    gain at x_first, covariance at x | P - K @ Z @ K.T -> P - P @ (G := observe(x, i)[1]).T @ np.linalg.inv(G @ P @ G.T + R) @ G @ P | One H, taken at x_first, for the gain and for the covariance.
    Joseph without the noise | P - K @ Z @ K.T -> (np.eye(len(x)) - K @ H) @ P @ (np.eye(len(x)) - K @ H).T | The new P is (I - K H) P, with (I - K H) once. With it on both sides, as in Joseph's form, a second term belongs there: + K R K'.
    shifted, as by an iterated filter | Z = H @ P -> d = x_first - x; d[2] = wrap(d[2]); z = z - H @ d; Z = H @ P | The innovation is y - e, with e at the present x, and nothing more: only the Jacobian is taken at x_first.
    R missing in the new P | P - K @ Z @ K.T -> P - P @ H.T @ np.linalg.inv(H @ P @ H.T) @ H @ P | P - K H P has the gain K = P H' inv(H P H' + R) in it: R is missing there.
    H of the present x in (I - K H) P | P - K @ Z @ K.T -> P - K @ observe(x, i)[1] @ P | The same H in the gain and in (I - K H) P: that of x_first. Yours takes that of x for P.
    half-way between the two | observe(x_first, i) -> observe((x + x_first) / 2, i) | H is taken at x_first itself, the first estimate, not half-way to the present x.
    expectation along the tangent | Z = H @ P -> d = x - x_first; d[2] = wrap(d[2]); e = observe(x_first, i)[0] + H @ d; z = np.array([y[0] - e[0], wrap(y[1] - e[1])]); Z = H @ P | The expectation is h(x) itself, at the present x. Only the Jacobian is taken at x_first.
    whole state wrapped | return x + K @ z, -> return wrap(x + K @ z), | Only the heading is an angle: positions are metres, and are not wrapped.
    """,
)


def born(rng, std):
    """Return x, P, R of one landmark, just seen for the first time by a robot whose heading is uncertain."""
    y, R, theta = np.array([8.0, 0.2]), np.diag([0.1, np.radians(1)]) ** 2, float(rng.normal() * std)
    c, s = np.cos(theta + y[1]), np.sin(theta + y[1])
    L_r, L_y = y[0] * np.array([[0, 0, -s], [0, 0, c]]), np.array([[c, -y[0] * s], [s, y[0] * c]])
    L_r[:, :2] = np.eye(2)
    P_rr = np.diag([1e-8, 1e-8, std**2])
    P = np.block([[P_rr, P_rr @ L_r.T], [L_r @ P_rr, L_r @ P_rr @ L_r.T + L_y @ R @ L_y.T]])
    return np.array([0, 0, theta, y[0] * c, y[0] * s]), P, R


@fej.link("a robot that stands still", "Heading sigma 30 degrees before, 30 degrees after: nothing tells the heading.")
def _(f, rng):
    x, P, R = born(rng, np.radians(30))
    x_first = x.copy()
    for _ in range(20):
        y = np.array([8.0, 0.2]) + rng.normal(size=2) * np.sqrt(np.diag(R))
        x, P = expect.results(f(x, P, y, 0, x_first, R), "x", "P")
        x, P = expect.array(x, 5, "x"), expect.array(P, (5, 5), "P")
        x[2] = wrap(x[2])
    sigma = np.degrees(np.sqrt(P[2, 2]))
    expect.true(abs(sigma - 30) < 0.01, f"the heading sigma is {sigma:.1f} degrees after 20 sightings, it was 30")
    expect.symmetric(P, "P", 1e-6)
