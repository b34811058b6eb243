"""Exercise 13.2: a pixel and a prior make an inverse-depth landmark, the anchor included."""

import numpy as np

from ...geometry import Frame3, e2q
from ...models.landmarks import IdpPnt
from ...models.sensors import PinHole
from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def new_idp(F, P_F, camera, y, R, n, N):
    """A new inverse-depth landmark from one pixel, as in the manual's section 5.2.

    F is the frame of the camera in the world, a Frame3, and P_F its covariance, shape (7, 7). y, shape (2,), is the
    pixel with the noise covariance R, shape (2, 2). n, shape (1,), is the prior of the inverse distance, which the
    pixel does not show, and N, shape (1, 1), its covariance.
    `camera.retro(y)` returns v, V_y: the ray in the frame of the camera. `IdpPnt().from_ray(v, n)` returns
    l_c, LC_v, LC_n: the landmark in that frame. `IdpPnt().from_frame(F, l_c)` returns l, L_F, L_lc.
    Return l = [anchor; pitch; yaw; rho], shape (6,), P_ll, shape (6, 6), and P_lF, shape (6, 7): its own covariance,
    and its covariance with the camera frame.
    """
    v, V_y = camera.retro(y)
    l_c, LC_v, LC_n = IdpPnt().from_ray(v, n)
    l, L_F, L_lc = IdpPnt().from_frame(F, l_c)
    L_y, L_n = L_lc @ LC_v @ V_y, L_lc @ LC_n
    P_lF = L_F @ P_F
    return l, P_lF @ L_F.T + L_y @ R @ L_y.T + L_n @ N @ L_n.T, P_lF


born = Exercise(
    "13.2",
    "A pixel and a prior make a landmark",
    new_idp,
    hints=(
        "Three calls, in the order of the docstring. Then the chain rule: how does l depend on y, on n, on F?",
        "L_y = L_lc LC_v V_y and L_n = L_lc LC_n. Three independent errors: of F, y and n. Covariances add.",
        "P_lF = L_F P_F; P_ll = L_F P_F L_F' + L_y R L_y' + L_n N L_n'.",
    ),
)

LENSES = (
    PinHole(),
    PinHole((300.0, 220.0, 400.0, 380.0), (-0.2, 0.05)),
    PinHole((310.0, 250.0, 250.0, 260.0), pixel_std=2.0),
)


def case(rng, lens=None, still=False):
    """Arguments: a camera somewhere, a pixel, a prior; noises correlated and of different sizes."""
    angles = np.zeros(3) if still else rng.uniform([-0.5, -0.5, -3], [0.5, 0.5, 3])
    camera = LENSES[int(rng.integers(3)) if lens is None else lens]
    look = e2q(np.array([-np.pi / 2, 0, -np.pi / 2]))[0]  # forward is the x axis of the world
    F = Frame3(np.concatenate([rng.uniform(-3, 3, 3), e2q(angles)[0]])).compose(
        Frame3(np.concatenate([np.zeros(3), look]))
    )[0]
    P_F = random_covariance(rng, 7, 0.05)
    n, N = np.array([rng.uniform(0.05, 0.5)]), np.array([[rng.uniform(0.05, 0.5) ** 2]])
    return F, P_F, camera, rng.uniform([150, 120], [500, 380]), random_covariance(rng, 2, 2.0), n, N


def _three(result):
    l, P_ll, P_lF = expect.results(result, "l", "P_ll", "P_lF")
    return expect.array(l, 6, "l"), expect.array(P_ll, (6, 6), "P_ll"), expect.array(P_lF, (6, 7), "P_lF")


def _compare(got, args, part):
    """The landmark, number by number; pitch and yaw modulo a turn."""
    want = new_idp(*args)[0]
    if part == "anchor":
        expect.close(got[:3], want[:3], "the anchor l[:3]")
    if part == "direction":
        expect.angle(got[3], want[3], "the pitch l[3]")
        expect.angle(got[4], want[4], "the yaw l[4]")
    if part == "rho":
        expect.close(got[5:], want[5:], "the inverse distance l[5]")


@born.link("three results", "The function must end with `return l, P_ll, P_lF`.")
def _(f, rng):
    _three(f(*case(rng)))


for name, help in (
    ("anchor", "The anchor is where the camera is: the position of F."),
    ("rho", "The pixel says nothing about the distance: the last number is the prior n, as it is."),
    ("direction", "`camera.retro` gives the ray in the camera; `from_frame` turns it into the world."),
):

    @born.link(name, help, part=0)
    def _(f, rng, name=name):
        for lens in (0, 1, 2):
            args = case(rng, lens)
            _compare(_three(f(*args))[0], args, name)


@born.link("the prior stays", "rho has the variance of its prior, N, whatever the pixel and the pose.", part=1)
def _(f, rng):
    for lens in (0, 1):
        args = case(rng, lens)
        expect.close(_three(f(*args))[1][5:, 5:], args[-1], "P_ll[5, 5], the variance of rho")


@born.link("the anchor is the camera", "The anchor *is* the position of the camera: both have the same error.", part=2)
def _(f, rng):
    for _ in range(2):
        args = case(rng)
        P_lF = _three(f(*args))[2]
        expect.close(P_lF[:3], args[1][:3], "P_lF[:3], anchor and camera frame,")


@born.link("known pose", "With a known pose (P_F = 0) only pixel and prior are left: L_y R L_y' + L_n N L_n'.", part=1)
def _(f, rng):
    for lens in (0, 1):
        args = case(rng, lens)
        args = (args[0], 0 * args[1], *args[2:])
        expect.close(_three(f(*args))[1], new_idp(*args)[1], "P_ll", at="P_F = 0")


@born.link("covariance with the camera", "Error of the frame in, error of the landmark out: P_lF = L_F P_F.", part=2)
def _(f, rng):
    for lens in (0, 1, 2):
        args = case(rng, lens)
        expect.close(_three(f(*args))[2], new_idp(*args)[2], "P_lF")


@born.link("own covariance", "Three causes of error, three terms: pose, pixel, prior.", part=1)
def _(f, rng):
    for lens in (0, 1, 2):
        args = case(rng, lens)
        P_ll = _three(f(*args))[1]
        expect.symmetric(P_ll, "P_ll", 1e-7)
        expect.close(P_ll, new_idp(*args)[1], "P_ll")


def _parts(F, camera, y, n):
    """Value and Jacobians by F, y, n."""
    v, V_y = camera.retro(y)
    l_c, LC_v, LC_n = IdpPnt().from_ray(v, n)
    l, L_F, L_lc = IdpPnt().from_frame(F, l_c)
    return l, L_F, L_lc @ LC_v @ V_y, L_lc @ LC_n, l_c


def _wrong(name, hint, change):
    """A misconception: change(right parts, arguments) returns l, P_ll, P_lF."""

    @born.wrong(name, hint)
    def _(F, P_F, camera, y, R, n, N):
        l, L_F, L_y, L_n, l_c = _parts(F, camera, y, n)
        own = L_F @ P_F @ L_F.T + L_y @ R @ L_y.T + L_n @ N @ L_n.T
        return change(dict(l=l, L_F=L_F, L_y=L_y, L_n=L_n, l_c=l_c, own=own, P_F=P_F, R=R, n=n, N=N, F=F))


def _l(d, **entries):
    l = d["l"].copy()
    for i, value in entries.items():
        l[int(i[1:])] = value
    return l, d["own"], d["L_F"] @ d["P_F"]


# fmt: off
_wrong("landmark left in the camera frame", "That is the landmark as the camera sees it: `from_frame(F, l_c)` brings "
       "it into the world.", lambda d: (d["l_c"], d["own"], d["L_F"] @ d["P_F"]))
_wrong("distance for inverse distance", "The last number is the *inverse* distance, in 1/m: n, not 1 / n.",
       lambda d: _l(d, _5=1 / d["n"][0]))
_wrong("point instead of anchor", "The first three numbers are the anchor, where the camera was, not the point.",
       lambda d: (np.concatenate([IdpPnt().point(d["l"])[0], d["l"][3:]]), d["own"], d["L_F"] @ d["P_F"]))
_wrong("pitch and yaw swapped", "The order is [anchor; pitch; yaw; rho]: first the elevation, then the azimuth.",
       lambda d: _l(d, _3=d["l"][4], _4=d["l"][3]))
_wrong("prior forgotten", "The prior is uncertain, too: its term L_n N L_n' is missing. Without it the filter "
       "believes that it knows the distance.",
       lambda d: (d["l"], d["own"] - d["L_n"] @ d["N"] @ d["L_n"].T, d["L_F"] @ d["P_F"]))
_wrong("N as a standard deviation", "N is a covariance already: do not square it.",
       lambda d: (d["l"], d["own"] + d["L_n"] @ (d["N"] @ d["N"] - d["N"]) @ d["L_n"].T, d["L_F"] @ d["P_F"]))
_wrong("N and R swapped by identity", "The term of the prior is L_n N L_n', that of the pixel L_y R L_y': "
       "neither covariance is the identity.",
       lambda d: (d["l"], d["own"] + d["L_n"] @ (1 - d["N"]) @ d["L_n"].T, d["L_F"] @ d["P_F"]))
_wrong("pixel noise forgotten", "The pixel is noisy: its term L_y R L_y' is missing.",
       lambda d: (d["l"], d["own"] - d["L_y"] @ d["R"] @ d["L_y"].T, d["L_F"] @ d["P_F"]))
_wrong("pose taken as known", "That is the formula of mapping. The camera pose is uncertain: L_F P_F L_F' belongs "
       "into P_ll, and P_lF = L_F P_F.",
       lambda d: (d["l"], d["own"] - d["L_F"] @ d["P_F"] @ d["L_F"].T, 0 * d["L_F"]))
_wrong("anchor not correlated", "An anchor that is not correlated with the camera pose is a second, independent "
       "origin: the anchor *is* the camera position. P_lF = L_F P_F.", lambda d: (d["l"], d["own"], 0 * d["L_F"]))
_wrong("pose noise forgotten in P_ll", "P_lF is there, but P_ll lacks the error of the pose: L_F P_F L_F'.",
       lambda d: (d["l"], d["own"] - d["L_F"] @ d["P_F"] @ d["L_F"].T, d["L_F"] @ d["P_F"]))
_wrong("L_F instead of P_lF", "A Jacobian is not a covariance: P_lF = L_F P_F.",
       lambda d: (d["l"], d["own"], d["L_F"]))
_wrong("P_Fl", "P_lF has the landmark in its rows: L_F P_F, shape (6, 7).",
       lambda d: (d["l"], d["own"], (d["L_F"] @ d["P_F"]).T))
# fmt: on


@born.variant("one big Jacobian")
def _(F, P_F, camera, y, R, n, N):
    l, L_F, L_y, L_n, _ = _parts(F, camera, y, n)
    J = np.hstack([L_F, L_y, L_n])
    C = np.zeros((10, 10))
    C[:7, :7], C[7:9, 7:9], C[9:, 9:] = P_F, R, N
    return l, J @ C @ J.T, (J @ C)[:, :7]


@born.variant("by central differences")
def _(F, P_F, camera, y, R, n, N):
    def g(a):
        l_c = IdpPnt().from_ray(camera.retro(a[7:9])[0], a[9:])[0]
        return IdpPnt().from_frame(Frame3(a[:7]), l_c)[0]

    a, h = np.concatenate([F.x, y, n]), 1e-6
    J = np.array([(g(a + h * d) - g(a - h * d)) / (2 * h) for d in np.eye(10)]).T
    noise = J[:, 7:9] @ R @ J[:, 7:9].T + J[:, 9:] @ N @ J[:, 9:].T
    return tuple(g(a)), J[:, :7] @ P_F @ J[:, :7].T + noise, J[:, :7] @ P_F
