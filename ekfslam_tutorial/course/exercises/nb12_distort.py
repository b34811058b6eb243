"""Exercise 12.1: radial distortion and its Jacobians."""

import numpy as np

from ...models.sensors.lens import radial
from .. import expect
from ..exercise import Exercise


def distort(up, d):
    """Radial distortion of a normalised image point.

    up, shape (2,), is the ideal point [x/z, y/z]. d, shape (n,), is the distortion vector [d2, d4, d6, ...], with any
    number of entries, also none: f = 1 + d2 r^2 + d4 r^4 + d6 r^6 + ..., and r is the length of up.
    Return ud = f up, shape (2,), UD_up, shape (2, 2): its derivative by up, and UD_d, shape (2, n): that by d.
    """
    r2 = up @ up
    k = np.arange(1, len(d) + 1)
    powers = r2**k
    f = 1 + powers @ d
    f_r2 = (k * r2 ** (k - 1)) @ d
    return f * up, f * np.eye(2) + 2 * f_r2 * np.outer(up, up), np.outer(up, powers)


distorted = Exercise(
    "12.1",
    "Distort, with Jacobians",
    distort,
    hints=(
        "Work with r2 = up @ up, so that d2 r^2 + d4 r^4 + ... is a sum of d[i] * r2 ** (i + 1).",
        "ud = f up is a product: UD_up = f I + up f_up, and f_up = df/d(r2) * 2 up. UD_d: column i is up r2^(i + 1).",
        "f_r2 = d2 + 2 d4 r2 + 3 d6 r2^2 + ...; UD_up = f * np.eye(2) + 2 * f_r2 * np.outer(up, up).",
    ),
)


def case(rng, n):
    """An image point and a distortion vector of n numbers."""
    a, r = rng.uniform(-np.pi, np.pi), rng.uniform(0.4, 1.1)
    return r * np.array([np.cos(a), np.sin(a)]), rng.uniform(-0.3, 0.3, n)


def _out(result, n):
    ud, UD_up, UD_d = expect.results(result, "ud", "UD_up", "UD_d")
    return (
        expect.array(ud, 2, "ud"),
        expect.array(UD_up, (2, 2), "UD_up"),
        expect.array(UD_d, (2, n), "UD_d (2 rows, one column for each of d)"),
    )


@distorted.link("shapes", "ud has 2 numbers, UD_up 2 x 2, UD_d one column for each entry of d. d may have any length.")
def _(f, rng):
    for n in (2, 1, 3):
        _out(f(*case(rng, n)), n)


@distorted.link("an ideal lens", "With d = 0 nothing is bent: ud = up.", part=0)
def _(f, rng):
    for n in (1, 2, 0):
        up, d = case(rng, n)
        expect.close(_out(f(up, 0 * d), n)[0], up, "ud", at=f"d = {[0] * n}")


@distorted.link("the point", "ud = (1 + d2 r^2 + d4 r^4 + ...) up, with r = |up|.", part=0)
def _(f, rng):
    for n in (1, 2, 3, 5):
        up, d = case(rng, n)
        expect.close(_out(f(up, d), n)[0], radial(up, d)[0], "ud", at=f"up = {up.round(3)}, d = {d.round(3)}")


@distorted.link("UD_up", "ud = f up: both f and up change when up changes.", part=1)
def _(f, rng):
    for n in (1, 2, 3, 0):
        up, d = case(rng, n)
        J = _out(f(up, d), n)[1]
        expect.jacobian(J, lambda u, d=d: radial(u, d)[0], up, "UD_up", "xy", "xy")


@distorted.link("in the middle of the image", "At up = 0 the lens does nothing: UD_up = I, UD_d = 0.", part=1)
def _(f, rng):
    d = case(rng, 2)[1]
    _, UD_up, UD_d = _out(f(np.zeros(2), d), 2)
    expect.close(UD_up, np.eye(2), "UD_up", at="up = [0, 0]")
    expect.close(UD_d, np.zeros((2, 2)), "UD_d", at="up = [0, 0]")


@distorted.link("UD_d", "ud depends on d linearly: the column of d_2i is up r^(2 i).", part=2)
def _(f, rng):
    for n in (1, 3, 2):
        up, d = case(rng, n)
        names = [f"d{2 * i + 2}" for i in range(n)]
        expect.jacobian(_out(f(up, d), n)[2], lambda v, up=up: radial(up, v)[0], d, "UD_d", "xy", names)


def _parts(up, d):
    k, r2 = np.arange(1, len(d) + 1), up @ up
    return r2, k, 1 + (r2**k) @ d, (k * r2 ** (k - 1)) @ d


def _wrong(name, hint, ud=None, UD_up=None, UD_d=None):
    """A misconception in one of the three results, each a function of up and d."""

    @distorted.wrong(name, hint)
    def _(up, d):
        right = distort(up, d)
        return tuple(g(up, d) if g else part for g, part in zip((ud, UD_up, UD_d), right, strict=True))


def _all(up, d, scale):
    """Value and Jacobian by d when the powers of r are `scale(r, k)`."""
    r, k = np.sqrt(up @ up), np.arange(1, len(d) + 1)
    return (1 + scale(r, k) @ d) * up, np.outer(up, scale(r, k))


# fmt: off
_wrong("odd powers of r", "The powers are even: r^2, r^4, r^6. With r2 = up @ up: r2, r2^2, r2^3.",
       lambda u, d: _all(u, d, lambda r, k: r**k)[0])
_wrong("every power squared", "The powers go up by two: r^2, r^4, r^6. So r2^k, not r2^(2 k).",
       lambda u, d: _all(u, d, lambda r, k: r ** (4 * k))[0])
_wrong("the same power for all", "d4 stands with r^4, d6 with r^6: the powers go up.",
       lambda u, d: _all(u, d, lambda r, k: r**2 + 0 * k)[0])
_wrong("powers doubled at each step", "The powers go up by two, r^2, r^4, r^6, r^8: they are not squared each time.",
       lambda u, d: _all(u, d, lambda r, k: r ** (2.0**k))[0])
_wrong("only the first of d", "d may have more than one number. All of them count.",
       lambda u, d: u * (1 + (u @ u) * d[:1].sum()))
_wrong("divides by f", "The direct model multiplies: ud = f up. Dividing is a first guess of the way back.",
       lambda u, d: u / _parts(u, d)[2])
_wrong("minus in f", "f = 1 + d2 r^2 + ...: a barrel lens has a negative d2, not a minus in the formula.",
       lambda u, d: u * (2 - _parts(u, d)[2]))
_wrong("1 forgotten", "f = 1 + ...: with d = 0 the point must stay where it is.",
       lambda u, d: u * (_parts(u, d)[2] - 1))
_wrong("adds f instead of multiplying", "The lens moves a point along its radius: f times up, not f plus up.",
       lambda u, d: u + _parts(u, d)[2] - 1)
_wrong("each axis with its own power", "r is the length of the vector up. It is the same for both axes.",
       lambda u, d: u * (1 + sum(di * u ** (2 * i + 2) for i, di in enumerate(d))))
_wrong("f taken as a constant", "f depends on up, too. The product rule gives a second term, 2 f_r2 up up'.",
       UD_up=lambda u, d: _parts(u, d)[2] * np.eye(2))
_wrong("factor 2 of r^2", "d(r2)/d(up) = 2 up': the factor 2 is missing.",
       UD_up=lambda u, d: _parts(u, d)[2] * np.eye(2) + _parts(u, d)[3] * np.outer(u, u))
_wrong("only the diagonal", "x changes r, and r changes y: UD_up has entries off its diagonal, up up' is an outer "
       "product.", UD_up=lambda u, d: _parts(u, d)[2] * np.eye(2) + 2 * _parts(u, d)[3] * np.diag(u * u))
_wrong("inner product for outer", "up up' is a matrix, np.outer(up, up). `up @ up` is a number.",
       UD_up=lambda u, d: (_parts(u, d)[2] + 2 * _parts(u, d)[3] * (u @ u)) * np.eye(2))
_wrong("f I forgotten", "Product rule: f I + up f_up. The first term is missing.",
       UD_up=lambda u, d: 2 * _parts(u, d)[3] * np.outer(u, u))
_wrong("factors of the powers forgotten", "d(r2^k)/d(r2) = k r2^(k - 1): the factor k is missing.",
       UD_up=lambda u, d: _parts(u, d)[2] * np.eye(2)
       + 2 * ((_parts(u, d)[0] ** (_parts(u, d)[1] - 1)) @ d) * np.outer(u, u))
_wrong("sign of the second term", "Both terms of the product rule have a plus.",
       UD_up=lambda u, d: _parts(u, d)[2] * np.eye(2) - 2 * _parts(u, d)[3] * np.outer(u, u))
_wrong("UD_d: odd powers", "The column of d2 is up r^2, with r^2 = up @ up: no root.",
       UD_d=lambda u, d: _all(u, d, lambda r, k: r**k)[1])
_wrong("UD_d: multiplied by d", "ud is linear in d: its derivative does not contain d.",
       UD_d=lambda u, d: np.outer(u, (u @ u) ** np.arange(1, len(d) + 1) * d))
_wrong("UD_d: distorted point", "The columns are up r^(2 i), with the ideal point up, not ud.",
       UD_d=lambda u, d: _parts(u, d)[2] * np.outer(u, (u @ u) ** np.arange(1, len(d) + 1)))
# fmt: on


@distorted.variant("a loop, lists")
def _(up, d):
    x, y = up
    r2, f, f_r2, UD_d = x * x + y * y, 1.0, 0.0, [[], []]
    for i, di in enumerate(d):
        f += di * r2 ** (i + 1)
        f_r2 += (i + 1) * di * r2**i
        UD_d[0].append(x * r2 ** (i + 1))
        UD_d[1].append(y * r2 ** (i + 1))
    return [f * x, f * y], [[f + 2 * f_r2 * x * x, 2 * f_r2 * x * y], [2 * f_r2 * x * y, f + 2 * f_r2 * y * y]], UD_d


@distorted.variant("central differences")
def _(up, d):
    d = np.array(d, float)

    def g(u, d):
        r = np.hypot(*u)
        return u * (1 + sum(c * r ** (2 * i + 2) for i, c in enumerate(d)))

    h = 1e-6
    J = np.array([(g(up + h * e, d) - g(up - h * e, d)) / (2 * h) for e in np.eye(2)]).T
    D = np.array([(g(up, d + h * e) - g(up, d - h * e)) / (2 * h) for e in np.eye(len(d))]).reshape(len(d), 2).T
    return g(up, d), J, D


@distorted.variant("with the package's function")
def _(up, d):
    return radial(np.asarray(up), np.asarray(d, float))
