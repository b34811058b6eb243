"""Exercise 22.1: a Plücker line of the world and its image."""

import numpy as np

from ...geometry import Frame3, hat
from ..table import table
from .nb10_chain import frame


def image_line(F, l, k):
    """Image of a Plücker line: where the plane through camera and line meets the image.

    F, a Frame3, is the camera in the world: F.t its position, shape (3,), and F.R its rotation, shape (3, 3), of which
    the columns are the camera's axes. l = [n; v], shape (6,), is the line: its points p have p x v = n.
    k = [u0, v0, au, av], shape (4,), are the camera's centre and focal lengths in pixels. `hat(a)` is the matrix,
    shape (3, 3), with hat(a) @ b = a x b.
    Seen from the camera the normal is n_c = R' (n - t x v), and the image line is h = K_L n_c, with
    K_L = [[av, 0, 0], [0, au, 0], [-av u0, -au v0, au av]].
    Return h = [a, b, c], shape (3,): the pixels of the line have a u + b v + c = 0; and H_l, shape (3, 6), its
    derivative by l.
    """
    n, v = l[:3], l[3:]
    u0, v0, au, av = k
    K_L = np.array([[av, 0, 0], [0, au, 0], [-av * u0, -au * v0, au * av]])
    H_n = K_L @ F.R.T
    h = H_n @ (n - np.cross(F.t, v))
    H_l = np.hstack([H_n, -H_n @ hat(F.t)])
    return h, H_l


def line_of(a, b):
    """The Plücker line through two points."""
    return np.concatenate([np.cross(a, b), b - a])


def case(rng, moved=1.0, turned=1.0, size=1.0):
    """A camera, moved and turned or not, a line before it, and two focal lengths; `size` scales the pixels."""
    F = frame(rng)
    x = np.concatenate([moved * F.t, F.q if turned else [1.0, 0, 0, 0]])
    a, b = rng.normal(size=(2, 3)) + [0, 0, 4]
    return Frame3(x), line_of(a, b), size * np.array([320.0, 240, 300, 350]) * rng.uniform(0.9, 1.1, 4)


pictured = table(
    "22.1 The image of a line",
    image_line,
    hints=(
        "Two steps: the normal seen from the camera, then the image line. Both are linear in l, so H_l is a product.",
        "h = K_L R' n - K_L R' (t x v). The first part has the derivative K_L R' by n. And t x v = hat(t) @ v.",
        "H_n = K_L @ F.R.T; h = H_n @ (n - np.cross(F.t, v)); H_l = np.hstack([H_n, -H_n @ hat(F.t)]).",
    ),
    returns="h, H_l",
    jacobians={"H_l": "h"},
    entries={"h": "a, b, c", "l": "n_x, n_y, n_z, v_x, v_y, v_z"},
    cases={
        "any": lambda rng: [case(rng), case(rng), case(rng, size=0.01)],
        "at home": lambda rng: [case(rng, 0.0, 0.0), case(rng, 0.0, 0.0, 0.01)],
        "turned": lambda rng: [case(rng, 0.0) for _ in range(2)],
    },
    checks="""
    camera at the origin | h         | at home | With the camera at the origin n_c is n itself, and h = K_L n with the K_L of the text.
    turned camera        | h         | turned  | The camera is turned, and stands at the origin. A normal is a direction: seen from the camera it is n_c = R' n, and h = K_L n_c.
    moved camera         | h         | any     | From the camera's place the plane is another one: n_c = R' (n - t x v), with the sign, the order and the brackets of the text.
    derivative           | d H_l / l | any     | h is linear in l: three columns for n, K_L R', and three for v, -K_L R' hat(t).
    """,
    wrong="""
    matrix of points | [[av, 0, 0], [0, au, 0], [-av * u0, -au * v0, au * av]] -> [[au, 0, u0], [0, av, v0], [0, 0, 1]] | That is K, which takes points to pixels. A line goes through K_L: the inverse transposed of K, times au av.
    transposed | au * av]]) -> au * av]]).T | K_L is transposed: the centre u0, v0 stands in its last row.
    au and av exchanged | u0, v0, au, av = k -> u0, v0, av, au = k | au and av are exchanged: k = [u0, v0, au, av], and the first row of K_L has av, the second au.
    u0 and v0 exchanged | u0, v0, au, av = k -> v0, u0, au, av = k | k = [u0, v0, au, av]: u0 comes first, it goes with the columns of the image.
    sign of the centre | [-av * u0, -au * v0, -> [av * u0, au * v0, | The last row is [-av u0, -au v0, au av]: mind the signs.
    R for R' | K_L @ F.R.T -> K_L @ F.R | F.R goes from the camera to the world. The normal comes from the world and goes into the camera: R'.
    rotation forgotten | K_L @ F.R.T -> K_L | The camera is turned: n and v are world directions, R' brings them into the camera.
    place of the camera forgotten | n - np.cross(F.t, v) -> n | n is the normal of the plane through the *origin*. The plane through the camera has another one: n - t x v.
    place of the camera forgotten, in the derivative, too: n is the normal of the plane through the *origin*. The plane through the camera has another one, n - t x v, and v counts in the derivative, too.
        n - np.cross(F.t, v) -> n
        -H_n @ hat(F.t) -> 0 * H_n
    place of the camera not turned: R' turns both terms: n_c = R' (n - t x v), not R' n - t x v.
        h = H_n @ (n - np.cross(F.t, v)) -> h = H_n @ n - K_L @ np.cross(F.t, v)
        -H_n @ hat(F.t) -> -K_L @ hat(F.t)
    added instead | n - np.cross(F.t, v) -> n + np.cross(F.t, v) | The sign: n_c = R' (n - t x v). Check: (p - t) x v = p x v - t x v.
    n and v exchanged | n, v = l[:3], l[3:] -> n, v = l[3:], l[:3] | The normal stands first: l = [n; v].
    n and v exchanged, in the derivative, too: The normal stands first: l = [n; v], and so do its columns of H_l.
        n, v = l[:3], l[3:] -> n, v = l[3:], l[:3]
        np.hstack([H_n, -H_n @ hat(F.t)]) -> np.hstack([-H_n @ hat(F.t), H_n])
    added in both: The sign: n_c = R' (n - t x v), in the derivative, too. Check: (p - t) x v = p x v - t x v.
        n - np.cross(F.t, v) -> n + np.cross(F.t, v)
        -H_n @ hat(F.t) -> H_n @ hat(F.t)
    derivative by v: sign | -H_n @ hat(F.t) -> H_n @ hat(F.t) | -t x v has the derivative -hat(t) by v: the minus sign stays.
    derivative by v: no effect | -H_n @ hat(F.t) -> 0 * H_n | A camera that has moved sees another plane when v changes: the last three columns are not zero.
    derivative by v: hat(v) | -H_n @ hat(F.t) -> -H_n @ hat(v) | t x v = hat(t) @ v: its derivative by v is hat(t). With hat(v) it is the one by t, but for the sign.
    derivative by v: K_L R' forgotten | -H_n @ hat(F.t) -> -hat(F.t) | The change of n_c goes through K_L R' to the image: both parts of H_l have this factor.
    camera's place taken off n | n - np.cross(F.t, v) -> n - F.t | The normal of the plane changes by t x v, the moment of the line about the new place: n is no point.
    derivative without K_L: h = K_L R' (n - t x v): K_L stands in both blocks of its derivative.
        H_l = np.hstack([H_n, -H_n @ hat(F.t)]) -> H_l = np.hstack([F.R.T, -F.R.T @ hat(F.t)])
    h divided by its length: h = K_L n_c as it comes: it is not divided by the length of [a, b], and H_l is its derivative.
        return h, H_l -> return h / np.hypot(h[0], h[1]), H_l
    factors in the wrong order, by v | -H_n @ hat(F.t) -> -K_L @ hat(F.t) @ F.R.T | n_c = R' (n - t x v): the product with t comes first, then R'. By v it is -K_L R' hat(t).
    t not turned | h = H_n @ (n - np.cross(F.t, v)) -> h = K_L @ (F.R.T @ n - np.cross(F.t, F.R.T @ v)) | t is told in the world, R' v in the camera: take the cross product in one frame, R' (n - t x v).
        -H_n @ hat(F.t) -> -K_L @ hat(F.t) @ F.R.T
    """,
)
