"""Exercise 12.2: the pin-hole camera, a chain of three steps with its Jacobians."""

import numpy as np

from ..table import table
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
    u = k[:2] + k[2:] * ud
    U_ud = np.diag(k[2:])
    U_k = np.hstack([np.eye(2), np.diag(ud)])
    return u, U_ud @ UD_up @ UP_p, U_k, U_ud @ UD_d


K = np.array([330.0, 235.0, 310.0, 420.0])


def case(rng, n=2, scale=1.0):
    """A point in front of a camera, the camera's k and d. The two focal lengths differ. `scale` moves the point."""
    p = rng.uniform(1.5, 6) * np.array([*rng.uniform(0.25, 0.8, 2) * rng.choice([-1, 1], 2), 1.0])
    return scale * p, K * rng.uniform(0.9, 1.1, 4), rng.uniform(-0.2, 0.2, n)


def ideal(p, k, d):
    """The same without distortion."""
    return p, k, 0 * d


camera = table(
    "12.2 The pin-hole camera",
    pin_hole,
    hints=(
        "Each of the three steps has a value and Jacobians. Write them one by one, with names OUT_in: UP_p, UD_up, UD_d, U_ud, U_k.",
        "UP_p = [[1/z, 0, -x/z^2], [0, 1/z, -y/z^2]]. U_ud = diag(au, av). U_k = [I, diag(ud)].",
        "The names chain: U_p = U_ud @ UD_up @ UP_p and U_d = U_ud @ UD_d.",
    ),
    returns="u, U_p, U_k, U_d",
    symbols="UP_p = the derivative of up by p; UD_up, UD_d = the derivatives of ud by up and by d; "
    "U_ud = the derivative of u by ud",
    jacobians={"U_p": "u", "U_k": "u", "U_d": "u"},
    entries={"u": "u, v", "p": "p_x, p_y, p_z", "k": "u0, v0, au, av", "d": "d2, d4, d6"},
    cases={
        "any": lambda rng: [case(rng, n) for n in (2, 1, 3, 0)],
        "ideal": lambda rng: [ideal(*case(rng, n, scale)) for n, scale in ((0, 0.3), (2, 1), (1, 1))],
        "depth": lambda rng: [case(rng, n, scale) for n, scale in ((2, -1.0), (1, 0.02), (3, -0.3))],
        "lens": lambda rng: [case(rng, n, side) for n, side in ((2, 1), (1, 1), (3, 1), (2, -1))],
    },
    checks="""
    no distortion | u         | ideal | u = [u0 + au x / z, v0 + av y / z] where d = 0.
    the pixel     | u         | any   | Project, distort, pixellise: up = [x/z, y/z]; ud is the first result of distort(up, d); u = [u0 + au ud[0], v0 + av ud[1]].
    any depth     | u         | depth | The formula holds for each z but zero, near or negative: p and -p have the same pixel. Whether a point is seen is exercise 12.3.
    U_p           | d U_p / p | lens  | U_p = U_ud UD_up UP_p: one factor for each step. Each is the derivative of its step, taken at what goes into that step.
    U_k           | d U_k / k | lens  | u0 and v0 shift the pixel, au and av scale ud: U_k = [I, diag(ud)].
    U_d           | d U_d / d | lens  | d changes ud, and ud changes u: U_d = U_ud UD_d.
    """,
    wrong="""
    distorted in pixels | u = k[:2] + k[2:] * ud -> u = distort(k[:2] + k[2:] * up, d)[0] | The lens comes before the sensor: distort the point in metres per metre, up, then pixellise. In pixels r^2 is about 100000.
    distorted around the image centre, in pixels | u = k[:2] + k[2:] * ud -> u = k[:2] + distort(k[2:] * up, d)[0] | r is the length of up = [x/z, y/z]. In pixels it is some hundred times as large.
    not distorted | u = k[:2] + k[2:] * ud -> u = k[:2] + k[2:] * up | The pixel is made of the distorted point, ud = distort(up, d): au and av scale ud.
    depth without its sign | u = k[:2] + k[2:] * ud -> u = k[:2] + k[2:] * np.sign(z) * ud | x / z with z as it is, sign included: behind the camera both signs turn, and the pixel is that of -p. `pin_hole` gives it for every z that is not zero.
    not divided by the depth | u = k[:2] + k[2:] * ud -> u = k[:2] + k[2:] * distort(p[:2], d)[0] | Perspective: up = [x/z, y/z]. A point twice as far is half as far from the centre.
    divided by the distance | u = k[:2] + k[2:] * ud -> u = k[:2] + k[2:] * distort(p[:2] / np.sqrt(p @ p), d)[0] | up = [x/z, y/z]: divide by the depth z, not by the distance |p|.
    depth times | u = k[:2] + k[2:] * ud -> u = k[:2] + k[2:] * distort(p[:2] * z, d)[0] | Perspective divides by z.
    x ahead | u = k[:2] + k[2:] * ud -> u = k[:2] + k[2:] * distort(-p[1:] / x, d)[0] | The camera's axes are x right, y down, z ahead: divide by z.
    k in another order | u = k[:2] + k[2:] * ud -> u = k[2:] + k[:2] * ud | k = [u0, v0, au, av]: first the centre, then the focal lengths.
    k as [u0, au, v0, av] | u = k[:2] + k[2:] * ud -> u = k[::2] + k[1::2] * ud | k = [u0, v0, au, av]: first the centre, then the focal lengths.
    centre subtracted | u = k[:2] + k[2:] * ud -> u = k[2:] * ud - k[:2] | Pixels are counted from the corner: the centre [u0, v0] is added.
    centre forgotten | u = k[:2] + k[2:] * ud -> u = k[2:] * ud | Pixels are counted from the corner: add the centre [u0, v0].
    v upwards | u = k[:2] + k[2:] * ud -> u = k[:2] + k[2:] * [1, -1] * ud | The y axis of the camera points down, as v does: plus av y.
    one focal length for both | u = k[:2] + k[2:] * ud -> u = k[:2] + k[2] * ud | The pixels need not be square: au for u, av for v.
    one focal length in all: The pixels need not be square: au for u, av for v, in the derivatives, too.
        u = k[:2] + k[2:] * ud -> u = k[:2] + k[2] * ud
        U_ud = np.diag(k[2:]) -> U_ud = k[2] * np.eye(2)
    UP_p: sign of the depth | [[1, 0, -x / z], [0, 1, -y / z]] -> [[1, 0, x / z], [0, 1, y / z]] | d(x/z)/dz = -x/z^2: a point that moves away goes towards the centre.
    UP_p: depth forgotten | [[1, 0, -x / z], [0, 1, -y / z]] -> [[1, 0, 0], [0, 1, 0]] | z changes the pixel, too: the third column of UP_p is -up / z.
    UP_p: z not squared | [[1, 0, -x / z], [0, 1, -y / z]] -> [[1, 0, -x], [0, 1, -y]] | d(x/z)/dz = -x/z^2: one z is missing.
    UP_p: not divided | -y / z]]) / z -> -y / z]]) | d(x/z)/dx = 1/z, not 1.
    U_p: lens left out | U_ud @ UD_up @ UP_p -> U_ud @ UP_p | The chain has three factors: U_ud UD_up UP_p. UD_up is missing.
    U_p: focal lengths left out | U_ud @ UD_up @ UP_p -> UD_up @ UP_p | The chain has three factors: U_ud UD_up UP_p. U_ud = diag(au, av) is missing.
    U_p: order of the factors | U_ud @ UD_up @ UP_p -> UD_up @ U_ud @ UP_p | The names must chain: U_ud UD_up UP_p. UD_up U_ud is another matrix where au and av differ.
    U_ud: one focal length | U_ud = np.diag(k[2:]) -> U_ud = k[2] * np.eye(2) | The second row of U_ud is that of v: U_ud = diag(au, av), not diag(au, au).
    U_k: ideal point | np.diag(ud) -> np.diag(up) | au multiplies ud, the distorted point: the last two columns are diag(ud).
    U_k: only the centre | np.diag(ud) -> np.zeros((2, 2)) | au and av change the pixel, too: the last two columns are diag(ud).
    U_k: order of the columns | [np.eye(2), np.diag(ud)] -> [np.diag(ud), np.eye(2)] | The columns go as k does: u0, v0, au, av.
    U_k: focal lengths | np.diag(ud) -> np.diag(k[2:]) | The derivative of au x by au is x: the last two columns are diag(ud), not diag(au, av).
    U_d: focal lengths left out | U_ud @ UD_d -> UD_d | UD_d is the derivative of ud. Of the pixel it is U_ud UD_d.
    U_d: one factor too many | U_ud @ UD_d -> U_ud @ UD_up @ UD_d | d acts in the lens itself: U_d = U_ud UD_d. UD_up is not in this chain.
    k in another order, in U_ud, too | u = k[:2] + k[2:] * ud -> k = k[[2, 3, 0, 1]]; u = k[:2] + k[2:] * ud | k = [u0, v0, au, av]: first the centre, then the focal lengths.
    U_d: one focal length | U_ud @ UD_d -> k[2] * UD_d | u goes with au, v with av: U_d is U_ud UD_d, with both.
    k in another order, in all: k = [u0, v0, au, av]: first the centre, then the focal lengths.
        u = k[:2] + k[2:] * ud -> k = np.roll(k, 2); u = k[:2] + k[2:] * ud
        np.hstack([np.eye(2), np.diag(ud)]) -> np.hstack([np.diag(ud), np.eye(2)])
    v upwards, in all: The y axis of the camera points down, as v does: plus av y, in the derivatives, too.
        k[:2] + k[2:] * ud -> k[:2] + k[2:] * [1, -1] * ud
        U_ud = np.diag(k[2:]) -> U_ud = np.diag(k[2:] * [1, -1])
        np.diag(ud)]) -> np.diag(ud * [1, -1])])
    U_k as [u0, au, v0, av] | U_k = np.hstack([np.eye(2), np.diag(ud)]) -> U_k = np.hstack([np.eye(2), np.diag(ud)])[:, [0, 2, 1, 3]] | The columns go as k does: u0, v0, au, av.
    UD_up at the distorted point | U_ud = np.diag(k[2:]) -> U_ud, UD_up = np.diag(k[2:]), distort(ud, d)[1] | UD_up is the derivative of distort at its input, up, not at what comes out of it.
    UD_d at the distorted point | U_ud = np.diag(k[2:]) -> U_ud, UD_d = np.diag(k[2:]), distort(ud, d)[2] | UD_d is that of distort at its input, up, not at what comes out of it.
    """,
)
