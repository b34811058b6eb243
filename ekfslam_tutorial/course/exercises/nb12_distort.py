"""Exercise 12.1: radial distortion and its Jacobians."""

import numpy as np

from ..table import table


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
    ud = f * up
    UD_up = f * np.eye(2) + 2 * f_r2 * np.outer(up, up)
    UD_d = np.outer(up, powers)
    return ud, UD_up, UD_d


def case(rng, n, r=None):
    """An image point, at the radius r, and a distortion vector of n numbers."""
    a, r = rng.uniform(-np.pi, np.pi), rng.uniform(0.4, 1.1) if r is None else r
    return r * np.array([np.cos(a), np.sin(a)]), rng.uniform(-0.3, 0.3, n)


def ideal(up, d):
    """The same point, and a lens that does nothing."""
    return up, 0 * d


distorted = table(
    "12.1 Distort, with Jacobians",
    distort,
    hints=(
        "Work with r2 = up @ up, so that d2 r^2 + d4 r^4 + ... is a sum of d[i] * r2 ** (i + 1).",
        "ud = f up is a product: UD_up = f I + up f_up, and f_up = df/d(r2) * 2 up. UD_d: column i is up r2^(i + 1).",
        "f_r2 = d2 + 2 d4 r2 + 3 d6 r2^2 + ...; UD_up = f * np.eye(2) + 2 * f_r2 * np.outer(up, up).",
    ),
    returns="ud, UD_up, UD_d",
    symbols="f_r2 = the derivative of f by r^2; f_up = the derivative of f by up",
    jacobians={"UD_up": "ud", "UD_d": "ud"},
    entries={"ud": "x, y", "up": "x, y", "d": "d2, d4, d6, d8, d10"},
    cases={
        "any": lambda rng: [case(rng, n) for n in (1, 2, 3, 5, 0)],
        "ideal": lambda rng: [ideal(*case(rng, n)) for n in (1, 2, 0)],
        "bent": lambda rng: [case(rng, n) for n in (1, 2, 3, 5)],
        "middle": lambda rng: [case(rng, n, 0.0) for n in (2, 1)],
        "far": lambda rng: [case(rng, 4, 1.7)],
    },
    checks="""
    an ideal lens           | ud    | ideal  | With d = 0 nothing is bent: ud = up.
    the point               | ud    | any    | ud = (1 + d2 r^2 + d4 r^4 + ...) up, with r = |up|.
    far from the axis       | ud    | far    | ud = (1 + d2 r^2 + d4 r^4 + ...) up, with r the length of up: the same formula for each r, here r = 1.7.
    UD_up                   | d UD_up / up | any | ud = f up is a product, and f = 1 + d2 r^2 + d4 r^4 + ... changes with up, too: UD_up comes of the product rule.
    UD_d                    | d UD_d / d | bent | ud depends on d linearly: the columns of UD_d are up r^2, up r^4 and so on.
    in the middle of the image | UD_up, UD_d | middle | At up = 0 the lens does nothing: UD_up = I, UD_d = 0.
    """,
    wrong="""
    odd powers of r | ud = f * up -> ud = (1 + np.sqrt(r2) ** k @ d) * up | The powers are even: r^2, r^4, r^6. With r2 = up @ up: r2, r2^2, r2^3.
    order of d | ud = f * up -> ud = (1 + powers @ d[::-1]) * up | The first number of d stands with r^2, the second with r^4: yours go the other way round.
    order of d, in UD_up, too: The first number of d stands with r^2, the second with r^4: yours go the other way round.
        f = 1 + powers @ d -> f = 1 + powers @ d[::-1]
        (k - 1)) @ d -> (k - 1)) @ d[::-1]
    odd powers of r, in all: The powers are even: r^2, r^4, r^6. With r2 = up @ up: r2, r2^2, r2^3.
        powers = r2**k -> powers = np.sqrt(r2) ** k
        (k * r2 ** (k - 1)) @ d -> (k / 2 * r2 ** (k / 2 - 1)) @ d if r2 > 0 else 0.0
    every power squared | ud = f * up -> ud = (1 + powers**2 @ d) * up | The powers go up by two: r^2, r^4, r^6. Not r^4, r^8, r^12.
    the same power for all | ud = f * up -> ud = (1 + r2 * np.sum(d)) * up | d4 stands with r^4, d6 with r^6: the powers go up.
    powers doubled at each step | ud = f * up -> ud = (1 + r2 ** (2.0 ** (k - 1)) @ d) * up | The powers go up by two, r^2, r^4, r^6, r^8: they are not squared each time.
    only the first of d | ud = f * up -> ud = (1 + r2 * np.sum(d[:1])) * up | d may have more than one number. All of them count.
    divides by f | ud = f * up -> ud = up / f | The direct model multiplies: ud = f up. Dividing is a first guess of the way back.
    minus in f | ud = f * up -> ud = (1 - powers @ d) * up | f = 1 + d2 r^2 + ...: a barrel lens has a negative d2, not a minus in the formula.
    1 forgotten | ud = f * up -> ud = (powers @ d) * up | f = 1 + ...: with d = 0 the point must stay where it is.
    adds f instead of multiplying | ud = f * up -> ud = up + powers @ d | The lens moves a point along its radius: f times up. A number that is added to x and y moves it off its radius.
    each axis with its own power | ud = f * up -> ud = (1 + up[:, None] ** (2 * k) @ d) * up | r is the length of the vector up. It is the same for both axes.
    f taken as a constant | + 2 * f_r2 * np.outer(up, up) -> + 0 | f depends on up, too. The product rule gives a second term: up times the derivative of f by up.
    factor 2 of r^2 | + 2 * f_r2 -> + f_r2 | r^2 = up' up has the derivative 2 up' by up: the factor 2 is missing.
    only the diagonal | np.outer(up, up) -> np.diag(up * up) | x changes r, and r changes y: UD_up has entries off its diagonal, up up' is an outer product.
    inner product for outer | np.outer(up, up) -> r2 * np.eye(2) | up up' is a matrix, np.outer(up, up). `up @ up` is a number.
    f I forgotten | f * np.eye(2) + 2 -> 2 | Product rule: f I, and up times the derivative of f. The first term is missing.
    factors of the powers forgotten | (k * r2 -> (r2 | By r^2 the powers r^2, r^4, r^6 have the derivatives 1, 2 r^2, 3 r^4: these factors are missing.
    sign of the second term | + 2 * f_r2 -> - 2 * f_r2 | Both terms of the product rule have a plus.
    power not lowered | (k - 1)) @ d -> k) @ d | By r^2 the powers r^2, r^4, r^6 have the derivatives 1, 2 r^2, 3 r^4: each power goes down by one.
    UD_d: odd powers | np.outer(up, powers) -> np.outer(up, np.sqrt(r2) ** k) | The column of d2 is up r^2, with r^2 = up @ up: no root.
    UD_d: multiplied by d | np.outer(up, powers) -> np.outer(up, powers * d) | ud is linear in d: its derivative does not contain d.
    UD_d: distorted point | np.outer(up, powers) -> np.outer(ud, powers) | The columns are up r^(2 i), with the ideal point up, not ud.
    entry by entry for outer | np.outer(up, up) -> np.tile(up * up, (2, 1)) | up up' is a matrix, np.outer(up, up). `up * grad` goes entry by entry, and is a vector.
    f forgotten | f * np.eye(2) + 2 -> np.eye(2) + 2 | Product rule: f I, and up times the derivative of f. In the first term f is missing.
    UD_d: powers only | np.outer(up, powers) -> np.outer(np.ones(2), powers) | ud is linear in d: each column of UD_d is up, a vector, times a power of r.
    only the last term of the derivative | (k * r2 ** (k - 1)) @ d -> (k * r2 ** (k - 1) * d)[-1:].sum() | Each power has its term in the derivative of f: sum them up, and do not keep the last one only.
    zero in the middle | return ud, UD_up, UD_d -> return ud, UD_up * (r2 > 0), UD_d | In the middle of the image the lens does nothing, ud = up: UD_up is the identity there, not zero.
    columns of UD_d one power lower | UD_d = np.outer(up, powers) -> UD_d = np.outer(up, r2 ** (k - 1)) | Column i of UD_d is up times the power that d[i] has in f: r^2 for the first one, not 1.
    r not divided by | 2 * f_r2 * np.outer(up, up) -> 2 * f_r2 * np.sqrt(r2) * np.outer(up, up) | The derivative of r by up is up / r, of length one: the division by r is missing.
    """,
)
