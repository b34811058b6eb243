"""Where sin and atan give way to series: each coefficient, seen beside longer series in exact fractions.

Just below the switch the second term is 1e-9 of the first: a test by differences does not see it.
"""

from fractions import Fraction
from math import factorial

import numpy as np
import pytest

from ekfslam_tutorial import geometry as g
from ekfslam_tutorial.models.motion import Unicycle

ANGLES = 0.99e-4, 3e-5, -0.99e-4, 1e-7, 1e-12


def series(a, first, coefficient, terms=6):
    """Sum of coefficient(i) a^(first + 2 i), i = 0, 1, ..."""
    a = Fraction(a)
    return float(sum(coefficient(i) * a ** (first + 2 * i) for i in range(terms)))


sign = lambda i: (-1) ** i
SINC = lambda a: series(a, 0, lambda i: Fraction(sign(i), factorial(2 * i + 1)))  # sin(a) / a
COSC = lambda a: series(a, 1, lambda i: Fraction(sign(i), factorial(2 * i + 2)))  # (1 - cos(a)) / a
SINC_A = lambda a: series(a, 1, lambda i: Fraction(-sign(i) * (2 * i + 2), factorial(2 * i + 3)))
COSC_A = lambda a: series(a, 0, lambda i: Fraction(sign(i) * (2 * i + 1), factorial(2 * i + 2)))


@pytest.mark.parametrize("a", ANGLES)
def test_a_flat_curve(a):
    """Of the unicycle: x, y and their derivatives by speed and turn rate."""
    v, dt = 2.0, 0.5
    x, X_x, X_u = Unicycle().move(np.zeros(3), np.array([v, a / dt]), dt)
    np.testing.assert_allclose(x, [v * dt * SINC(a), v * dt * COSC(a), a], rtol=1e-15)
    wanted = [[dt * SINC(a), v * dt**2 * SINC_A(a)], [dt * COSC(a), v * dt**2 * COSC_A(a)], [0.0, dt]]
    np.testing.assert_allclose(X_u[0, 1], wanted[0][1], rtol=3e-9)  # one term; what it lacks is a^2 / 10 of it
    X_u[0, 1] = wanted[0][1]
    np.testing.assert_allclose(X_u, wanted, rtol=1e-14)


@pytest.mark.parametrize("a", [abs(a) for a in ANGLES])
def test_a_small_rotation_vector(a):
    """v2q: sin(a/2) / a, and the derivative of that by a, over a, which is off the diagonal."""
    u = np.array([2.0, -1.0, 2.0]) / 3
    q, Q_v = g.v2q(a * u)
    half = lambda k, i: Fraction(sign(i + k), 2 ** (2 * i + 1 + 2 * k) * factorial(2 * i + 1 + 2 * k))
    s = series(a, 0, lambda i: half(0, i))
    ds = series(a, 0, lambda i: (2 * i + 2) * half(1, i))
    np.testing.assert_allclose(q[1:], s * a * u, rtol=1e-15)
    np.testing.assert_allclose(q[0], np.cos(a / 2), rtol=1e-15)
    np.testing.assert_allclose(Q_v[0], -s * a * u / 2, rtol=1e-15)
    for i, j in ((0, 1), (1, 2), (0, 2)):
        assert Q_v[1 + i, j] == pytest.approx(ds * a**2 * u[i] * u[j], rel=1e-13, abs=0)


@pytest.mark.parametrize("scale", [1.0, 0.6])
@pytest.mark.parametrize("n", [0.99e-4, 3e-5, 1e-7])
def test_a_quaternion_of_a_small_rotation(n, scale):
    """q2v: v = k [b c d] with k = 2 atan(t) / (t w), t = n / w."""
    u, w = np.array([2.0, -1.0, 2.0]) / 3, scale
    b = n * scale * u
    v, V_q = g.q2v(np.array([w, *b]))
    k = 2 / w * series(n, 0, lambda i: Fraction(sign(i), 2 * i + 1))
    k_n = 2 / w**3 * series(n, 0, lambda i: Fraction(-sign(i) * (2 * i + 2), 2 * i + 3))  # derivative by n, over n
    np.testing.assert_allclose(v, k * b, rtol=1e-15)
    np.testing.assert_allclose(V_q[:, 0], -2 * b / (w * w * (1 + n * n)), rtol=1e-15)
    for i, j in ((0, 1), (1, 2), (0, 2)):
        assert V_q[i, 1 + j] == pytest.approx(k_n * b[i] * b[j], rel=3e-8, abs=0)
    for i in range(3):
        assert V_q[i, 1 + i] == pytest.approx(k + k_n * b[i] ** 2, rel=1e-15)
