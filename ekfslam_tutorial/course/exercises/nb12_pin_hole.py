"""Exercise 12.2: the pin-hole camera, a chain of three steps with its Jacobians."""

import numpy as np

from ...models.sensors.pin_hole import pin_hole as package_pin_hole
from .. import expect
from ..exercise import Exercise
from .nb12_distort import distort


def pin_hole(p, k, d):
    """From a point in the frame of the camera to its pixel: project, distort, pixellise.

    p, shape (3,), is the point [x, y, z] in metres: x right, y down, z ahead, z is not zero. k, shape (4,), holds
    [u0, v0, au, av] in pixels. d, shape (n,), is the distortion vector.
    The steps: up = [x/z, y/z]; ud = distort(up, d); u = [u0 + au * ud[0], v0 + av * ud[1]].
    Return u, shape (2,), and its Jacobians U_p, shape (2, 3), U_k, shape (2, 4), and U_d, shape (2, n).
    """
    x, y, z = p
    up = np.array([x, y]) / z
    UP_p = np.array([[1, 0, -x / z], [0, 1, -y / z]]) / z
    ud, UD_up, UD_d = distort(up, d)
    U_ud = np.diag(k[2:])
    U_k = np.hstack([np.eye(2), np.diag(ud)])
    return k[:2] + k[2:] * ud, U_ud @ UD_up @ UP_p, U_k, U_ud @ UD_d


camera = Exercise(
    "12.2",
    "The pin-hole camera",
    pin_hole,
    hints=(
        "Each of the three steps has a value and Jacobians. Write them one by one, with names OUT_in: UP_p, UD_up, "
        "UD_d, U_ud, U_k.",
        "UP_p = [[1/z, 0, -x/z^2], [0, 1/z, -y/z^2]]. U_ud = diag(au, av). U_k = [I, diag(ud)].",
        "The names chain: U_p = U_ud @ UD_up @ UP_p and U_d = U_ud @ UD_d.",
    ),
)

K = np.array([330.0, 235.0, 310.0, 420.0])


def case(rng, n=2, distance=None):
    """A point in front of a camera, the camera's k and d. The two focal lengths differ."""
    z = distance or rng.uniform(1.5, 6)
    p = z * np.array([*rng.uniform(0.25, 0.8, 2) * rng.choice([-1, 1], 2), 1.0])
    return p, K * rng.uniform(0.9, 1.1, 4), rng.uniform(-0.2, 0.2, n)


def _out(result, n):
    u, U_p, U_k, U_d = expect.results(result, "u", "U_p", "U_k", "U_d")
    return (
        expect.array(u, 2, "u"),
        expect.array(U_p, (2, 3), "U_p"),
        expect.array(U_k, (2, 4), "U_k"),
        expect.array(U_d, (2, n), "U_d"),
    )


@camera.link("shapes", "u has 2 numbers; U_p is 2 x 3, U_k 2 x 4, and U_d has one column for each entry of d.")
def _(f, rng):
    for n in (2, 1, 3, 0):
        _out(f(*case(rng, n)), n)


@camera.link("no distortion", "u = [u0 + au x / z, v0 + av y / z] where d = 0.", part=0)
def _(f, rng):
    for n, z in ((0, 1.0), (2, None), (1, None)):
        p, k, d = case(rng, n, z)
        expect.close(_out(f(p, k, 0 * d), n)[0], package_pin_hole(p, k, 0 * d)[0], "u", at=f"p = {p.round(2)}, d = 0")


@camera.link("the pixel", "Three steps in this order: project, distort, pixellise.", part=0)
def _(f, rng):
    for n in (1, 2, 3):
        p, k, d = case(rng, n)
        at = f"p = {p.round(2)}, d = {d.round(2)}"
        expect.close(_out(f(p, k, d), n)[0], package_pin_hole(p, k, d)[0], "u", at=at)


@camera.link("any depth", "The formula holds for each z but zero, near or negative: p and -p have the same pixel. "
             "Whether a point is seen is exercise 12.3.", part=0)  # fmt: skip
def _(f, rng):
    for n, scale in ((2, -1.0), (1, 0.02), (3, -0.3)):
        p, k, d = case(rng, n)
        u = _out(f(scale * p, k, d), n)[0]
        expect.close(u, package_pin_hole(p, k, d)[0], "u", at=f"p = {(scale * p).round(3)}, d = {d.round(2)}")


def _pixel_with(args, place, x):
    """The pixel with another value of one argument."""
    args[place] = x
    return package_pin_hole(*args)[0]


def _derivative(f, rng, part, name, columns, args):
    for n, side in ((2, 1.0), (1, 1.0), (3, 1.0), (2, -1.0)):  # the last point is behind the camera
        p, *others = case(rng, n)
        given = (side * p, *others)
        J = _out(f(*given), n)[part]
        value = lambda x, given=given: _pixel_with(list(given), part - 1, x)
        expect.jacobian(J, value, given[part - 1], name, "uv", columns or args[:n], rtol=1e-5, atol=1e-5)


@camera.link("U_p", "U_p = U_ud UD_up UP_p: three factors, and the inner names are equal.", part=1)
def _(f, rng):
    _derivative(f, rng, 1, "U_p", ("p_x", "p_y", "p_z"), ())


@camera.link("U_k", "u0 and v0 shift the pixel, au and av scale ud: U_k = [I, diag(ud)].", part=2)
def _(f, rng):
    _derivative(f, rng, 2, "U_k", ("u0", "v0", "au", "av"), ())


@camera.link("U_d", "d changes ud, and ud changes u: U_d = U_ud UD_d.", part=3)
def _(f, rng):
    _derivative(f, rng, 3, "U_d", None, ("d2", "d4", "d6"))


def _steps(p, k, d):
    """The right steps: up, UP_p, ud, UD_up, UD_d, U_ud."""
    x, y, z = p
    UP_p = np.array([[1, 0, -x / z], [0, 1, -y / z]]) / z
    return (p[:2] / z, UP_p, *distort(p[:2] / z, d), np.diag(k[2:]))


def _wrong(name, hint, u=None, U_p=None, U_k=None, U_d=None):
    """A misconception in one of the four results, each a function of p, k and d."""

    @camera.wrong(name, hint)
    def _(p, k, d):
        return tuple(g(p, k, d) if g else a for g, a in zip((u, U_p, U_k, U_d), pin_hole(p, k, d), strict=True))


def _pixel(up, k, d):
    return k[:2] + k[2:] * distort(up, d)[0]


def _chain(p, k, d, change):
    """U_p with the factors U_ud, UD_up, UP_p as `change` returns them."""
    up, UP_p, ud, UD_up, UD_d, U_ud = _steps(p, k, d)
    return change(U_ud, UD_up, UP_p)


def _bent_UP(p, third):
    x, y, z = p
    return np.column_stack([np.eye(2) / z, third(np.array([x, y]), z)])


# fmt: off
_wrong("distorted in pixels", "The lens comes before the sensor: distort the point in metres per metre, up, then "
       "pixellise. In pixels r^2 is about 100000.", lambda p, k, d: distort(k[:2] + k[2:] * p[:2] / p[2], d)[0])
_wrong("distorted around the image centre, in pixels", "r is the length of up = [x/z, y/z]. In pixels it is some "
       "hundred times as large.", lambda p, k, d: k[:2] + distort(k[2:] * p[:2] / p[2], d)[0])
_wrong("not distorted", "The second step is missing: ud = distort(up, d).",
       lambda p, k, d: k[:2] + k[2:] * p[:2] / p[2])
_wrong("depth without its sign", "x / z with the sign of z: behind the camera both signs turn, and the pixel is that "
       "of -p. Leave it to `visible` to refuse the point.",
       lambda p, k, d: _pixel(p[:2] / abs(p[2]), k, d))
_wrong("not divided by the depth", "Perspective: up = [x/z, y/z]. A point twice as far is half as far from the centre.",
       lambda p, k, d: _pixel(p[:2], k, d))
_wrong("divided by the distance", "up = [x/z, y/z]: divide by the depth z, not by the distance |p|.",
       lambda p, k, d: _pixel(p[:2] / np.sqrt(p @ p), k, d))
_wrong("depth times", "Perspective divides by z.", lambda p, k, d: _pixel(p[:2] * p[2], k, d))
_wrong("x ahead", "The camera's axes are x right, y down, z ahead: divide by z.",
       lambda p, k, d: _pixel(-p[1:] / p[0], k, d))
_wrong("k in another order", "k = [u0, v0, au, av]: first the centre, then the focal lengths.",
       lambda p, k, d: k[2:] + k[:2] * distort(p[:2] / p[2], d)[0])
_wrong("k as [u0, au, v0, av]", "k = [u0, v0, au, av]: first the centre, then the focal lengths.",
       lambda p, k, d: k[[0, 2]] + k[[1, 3]] * distort(p[:2] / p[2], d)[0])
_wrong("centre subtracted", "Pixels are counted from the corner: the centre [u0, v0] is added.",
       lambda p, k, d: -k[:2] + k[2:] * distort(p[:2] / p[2], d)[0])
_wrong("centre forgotten", "Pixels are counted from the corner: add the centre [u0, v0].",
       lambda p, k, d: k[2:] * distort(p[:2] / p[2], d)[0])
_wrong("v upwards", "The y axis of the camera points down, as v does: plus av y.",
       lambda p, k, d: k[:2] + k[2:] * [1, -1] * distort(p[:2] / p[2], d)[0])
_wrong("one focal length for both", "The pixels need not be square: au for u, av for v.",
       lambda p, k, d: k[:2] + k[2] * distort(p[:2] / p[2], d)[0])
_wrong("UP_p: sign of the depth", "d(x/z)/dz = -x/z^2: a point that moves away goes towards the centre.",
       U_p=lambda p, k, d: _chain(p, k, d, lambda A, B, C: A @ B @ _bent_UP(p, lambda xy, z: xy / z**2)))
_wrong("UP_p: depth forgotten", "z changes the pixel, too: the third column of UP_p is -up / z.",
       U_p=lambda p, k, d: _chain(p, k, d, lambda A, B, C: A @ B @ _bent_UP(p, lambda xy, z: 0 * xy)))
_wrong("UP_p: z not squared", "d(x/z)/dz = -x/z^2: one z is missing.",
       U_p=lambda p, k, d: _chain(p, k, d, lambda A, B, C: A @ B @ _bent_UP(p, lambda xy, z: -xy / z)))
_wrong("UP_p: not divided", "d(x/z)/dx = 1/z, not 1.",
       U_p=lambda p, k, d: _chain(p, k, d, lambda A, B, C: A @ B @ (C * p[2])))
_wrong("U_p: lens left out", "The chain has three factors: U_ud UD_up UP_p. UD_up is missing.",
       U_p=lambda p, k, d: _chain(p, k, d, lambda A, B, C: A @ C))
_wrong("U_p: focal lengths left out", "The chain has three factors: U_ud UD_up UP_p. U_ud = diag(au, av) is missing.",
       U_p=lambda p, k, d: _chain(p, k, d, lambda A, B, C: B @ C))
_wrong("U_p: order of the factors", "The names must chain: U_ud UD_up UP_p. UD_up U_ud is another matrix where au and "
       "av differ.", U_p=lambda p, k, d: _chain(p, k, d, lambda A, B, C: B @ A @ C))
_wrong("U_k: ideal point", "au multiplies ud, the distorted point: the last two columns are diag(ud).",
       U_k=lambda p, k, d: np.hstack([np.eye(2), np.diag(p[:2] / p[2])]))
_wrong("U_k: only the centre", "au and av change the pixel, too: the last two columns are diag(ud).",
       U_k=lambda p, k, d: np.hstack([np.eye(2), np.zeros((2, 2))]))
_wrong("U_k: order of the columns", "The columns go as k does: u0, v0, au, av.",
       U_k=lambda p, k, d: np.hstack([np.diag(distort(p[:2] / p[2], d)[0]), np.eye(2)]))
_wrong("U_k: focal lengths", "The derivative of au x by au is x: the last two columns are diag(ud), not diag(au, av).",
       U_k=lambda p, k, d: np.hstack([np.eye(2), np.diag(k[2:])]))
_wrong("U_d: focal lengths left out", "UD_d is the derivative of ud. Of the pixel it is U_ud UD_d.",
       U_d=lambda p, k, d: distort(p[:2] / p[2], d)[2])
_wrong("U_d: one factor too many", "d acts in the lens itself: U_d = U_ud UD_d. UD_up is not in this chain.",
       U_d=lambda p, k, d: np.diag(k[2:]) @ distort(p[:2] / p[2], d)[1] @ distort(p[:2] / p[2], d)[2])
# fmt: on


@camera.variant("written out, as lists")
def _(p, k, d):
    x, y, z = (float(c) for c in p)
    u0, v0, au, av = k
    (a, b), J, D = distort(np.array([x / z, y / z]), d)
    J, D = np.asarray(J), np.asarray(D)
    rows = [[au / z * J[0, 0], au / z * J[0, 1], -au / z**2 * (J[0] @ [x, y])],
            [av / z * J[1, 0], av / z * J[1, 1], -av / z**2 * (J[1] @ [x, y])]]  # fmt: skip
    return [u0 + au * a, v0 + av * b], rows, [[1, 0, a, 0], [0, 1, 0, b]], [au * D[0], av * D[1]]


@camera.variant("homogeneous coordinates")
def _(p, k, d):
    up = np.asarray(p) / p[2]
    ud, UD_up, UD_d = distort(up[:2], d)
    A = np.array([[k[2], 0, k[0]], [0, k[3], k[1]]])
    UP_p = (np.eye(3)[:2] - np.outer(up[:2], np.eye(3)[2])) / p[2]
    U_k = np.column_stack([np.eye(2), [ud[0], 0], [0, ud[1]]])
    return A @ np.append(ud, 1), A[:, :2] @ UD_up @ UP_p, U_k, A[:, :2] @ UD_d


@camera.variant("with the package's function")
def _(p, k, d):
    return package_pin_hole(np.asarray(p), k, np.asarray(d))
