"""Exercise 22.2: how far the ends of a measured segment are from the line that was expected."""

import numpy as np

from ..table import table


def line_innovation(y, h):
    """Distances of the two ends of a segment from an image line.

    y = [u1, v1, u2, v2], shape (4,), are the measured ends (px). h = [a, b, c], shape (3,), is the expected image line:
    a u + b v + c = 0 for its pixels. Its scale means nothing: h and 5 h are the same line.
    The distance of an end from the line is z_i = (a u_i + b v_i + c) / sqrt(a^2 + b^2) (px), with its sign.
    Return z, shape (2,), Z_y, shape (2, 4), and Z_h, shape (2, 3): its derivatives by y and by h.
    """
    z, Z_y, Z_h = np.zeros(2), np.zeros((2, 4)), np.zeros((2, 3))
    length = np.hypot(h[0], h[1])
    for i in 0, 1:
        q = np.array([y[2 * i], y[2 * i + 1], 1.0])
        z[i] = q @ h / length
        Z_y[i, 2 * i : 2 * i + 2] = h[:2] / length
        Z_h[i] = (q - z[i] * np.array([h[0], h[1], 0]) / length) / length
    return z, Z_y, Z_h


def case(rng, scale=1.0, off=20.0):
    """A segment, and a line that passes its ends at some pixels; its scale is any."""
    y = rng.uniform([100, 80, 350, 80], [300, 400, 540, 400])
    a, b = y.reshape(2, 2) + rng.normal(0, off, (2, 2))
    h = np.cross([*a, 1.0], [*b, 1.0])
    return y, scale * h / np.hypot(h[0], h[1])


apart = table(
    "22.2 The distance of a segment from a line",
    line_innovation,
    hints=(
        "One end after the other: z_i is a fraction. Numerator and denominator both depend on h, the numerator on y.",
        "By y: [a, b] / L for the end's own two columns, zero for the other's. By h: quotient rule, dL/d[a, b] = [a, b] / L.",
        "With q = [u, v, 1] and L = hypot(a, b): z = q @ h / L, and dz/dh = (q - z [a, b, 0] / L) / L.",
    ),
    returns="z, Z_y, Z_h",
    symbols="L = sqrt(a^2 + b^2); q = [u, v, 1]",
    jacobians={"Z_y": "z", "Z_h": "z"},
    entries={"z": "end 1, end 2", "y": "u1, v1, u2, v2", "h": "a, b, c"},
    cases={
        "any": lambda rng: [case(rng, scale) for scale in (1.0, 40.0, -0.3)],
        "unit": lambda rng: [case(rng) for _ in range(2)],
        "scaled": lambda rng: [case(rng, scale) for scale in (7.0, 0.02, -3.0)],
    },
    checks="""
    unit line         | z         | unit   | With sqrt(a^2 + b^2) = 1 the distance is z_i = a u_i + b v_i + c, first for the end (u1, v1), then for (u2, v2). It keeps its sign.
    any scale         | z         | scaled | h and 5 h are one line and have the same distances; with -3 h their signs are turned. z_i = (a u_i + b v_i + c) / sqrt(a^2 + b^2).
    by the ends       | d Z_y / y | any    | An end that moves by 1 px across the line changes its own distance by 1 px: [a, b] / L in its own columns, zero in the other's.
    by the line       | d Z_h / h | any    | Quotient rule: L changes with a and b, too. With q = [u, v, 1]: (q - z [a, b, 0] / L) / L.
    """,
    wrong="""
    scale of the line | length = np.hypot(h[0], h[1]) -> length = 1.0 | h has any scale: without the division by sqrt(a^2 + b^2) these are no pixels.
    length with c | np.hypot(h[0], h[1]) -> np.linalg.norm(h) | The normal of the line in the image is [a, b]; c is no part of it. Divide by sqrt(a^2 + b^2).
    length with c in all: The normal of the line in the image is [a, b]; c is no part of it, nor of its derivative. Divide by sqrt(a^2 + b^2).
        np.hypot(h[0], h[1]) -> np.linalg.norm(h)
        np.array([h[0], h[1], 0]) -> h
    squared length | np.hypot(h[0], h[1]) -> h[0]**2 + h[1]**2 | Divide by the length of [a, b], not by its square: a root is missing.
    distance without sign | z[i] = q @ h / length -> z[i] = abs(q @ h) / length | Keep the sign: on which side of the line an end lies tells where to move it. An innovation has the mean zero.
    negative | z[i] = q @ h / length -> z[i] = -(q @ h) / length | The sign is that of a u + b v + c.
    c forgotten | y[2 * i + 1], 1.0]) -> y[2 * i + 1], 0.0]) | A pixel is [u, v, 1]: with c its product with h is a distance from the line, without it from a parallel through the corner.
    u and v exchanged | [y[2 * i], y[2 * i + 1], 1.0] -> [y[2 * i + 1], y[2 * i], 1.0] | y = [u1, v1, u2, v2]: u belongs to a, v to b.
    both u before both v | [y[2 * i], y[2 * i + 1], 1.0] -> [y[i], y[2 + i], 1.0] | y = [u1, v1, u2, v2]: the first end has the first two numbers, the second end the others.
    both u before both v, in all: y = [u1, v1, u2, v2]: the first end has the first two numbers, the second end the others; so it is with the columns of Z_y.
        [y[2 * i], y[2 * i + 1], 1.0] -> [y[i], y[2 + i], 1.0]
        Z_y[i, 2 * i : 2 * i + 2] = -> Z_y[i, i::2] =
    one end twice | [y[2 * i], y[2 * i + 1], 1.0] -> [y[0], y[1], 1.0] | That is the distance of the first end, twice. The second end is (u2, v2).
    columns of the first end | Z_y[i, 2 * i : 2 * i + 2] = -> Z_y[i, :2] = | Each end has its own two columns in Z_y: the second row is not zero in the last two.
    both ends in each row | Z_y[i, 2 * i : 2 * i + 2] = h[:2] / length -> Z_y[i] = np.tile(h[:2], 2) / length | The distance of one end does not depend on the other end: its two columns are zero.
    Z_y without length | h[:2] / length -> h[:2] | Z_y has the unit px per px: [a, b] / L, a vector of length one.
    L taken for a constant | (q - z[i] * np.array([h[0], h[1], 0]) / length) / length -> q / length | L depends on a and b, too: the quotient rule has a second term. Without it, a mere change of scale would change z.
    second term: sign | (q - z[i] * np.array -> (q + z[i] * np.array | Quotient rule: the derivative of the denominator comes with a minus sign.
    Z_h without length | 0]) / length) / length -> 0]) / length) | The derivative of q @ h is q; it is divided by L as z is.
    derivative by c is 1 | return z, Z_y, Z_h -> Z_h[:, 2] = 1; return z, Z_y, Z_h | The whole of a u + b v + c is divided by L, c with it: its derivative is 1 / L.
    second term divided once: The power of L in the second term is wrong. With the distance z it is -z [a, b] / L^2, and with the numerator, z L, it is -(z L) [a, b] / L^3: once by the quotient rule, once by dL/d[a, b] = [a, b] / L.
        np.array([h[0], h[1], 0]) / length) / length -> np.array([h[0], h[1], 0])) / length
    second term divided once, by b | np.array([h[0], h[1], 0]) -> np.array([h[0], h[1] * length, 0]) | By b the second term is -z b / L^2, as it is -z a / L^2 by a: divide by L twice.
    negative in all: The sign is that of a u + b v + c, and so it is with the derivatives.
        return z, Z_y, Z_h -> return -z, -Z_y, -Z_h
    distance of the first end in both | Z_h[i] = (q - z[i] -> Z_h[i] = (q - z[0] | Row i of Z_h has the distance of end i in it, z_i.
    sign of the line chosen | length = np.hypot(h[0], h[1]) -> length = np.hypot(h[0], h[1]) * (-1 if h[2] > 0 else 1) | The sign of h counts as it comes: -h would turn the sign of z.
    """,
)
