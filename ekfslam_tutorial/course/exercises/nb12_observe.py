"""Exercise 12.4: a point of the world in a camera on a robot, the manual's direct model with all Jacobians."""

import numpy as np

from ...geometry import Frame3, numerical_jacobian, unit
from ...models.sensors.pin_hole import pin_hole as package_pin_hole
from .. import expect
from ..diagnose import same
from ..exercise import Exercise
from .nb12_pin_hole import pin_hole


def proj_euc_pnt(Rf, Sf, k, d, l):
    """Project a Euclidean point into a pin-hole camera on a robot: the manual's section 5.1.

    Rf: frame of the robot in the world. Sf: frame of the camera in the robot. Both are Frame3. l, shape (3,): the
    point in the world. k, shape (4,), and d, shape (n,), are those of `pin_hole(p, k, d)`, which returns u, U_p, U_k,
    U_d.
    `F.to_frame(p)` returns pf, PF_f, PF_p: the point in the frame F, and its derivatives by F.x and by p.
    Return the pixel u, shape (2,), and its derivatives U_r, U_s, both of shape (2, 7), U_k, shape (2, 4), U_d, shape
    (2, n), and U_l, shape (2, 3): by Rf.x, Sf.x, k, d and l.
    """
    lr, LR_r, LR_l = Rf.to_frame(l)
    ls, LS_s, LS_lr = Sf.to_frame(lr)
    u, U_ls, U_k, U_d = pin_hole(ls, k, d)
    U_lr = U_ls @ LS_lr
    return u, U_lr @ LR_r, U_ls @ LS_s, U_k, U_d, U_lr @ LR_l


projected = Exercise(
    "12.4",
    "A camera on a robot",
    proj_euc_pnt,
    hints=(
        "Three steps: world to robot, lr; robot to camera, ls; camera to pixel, u. Name the Jacobians of each.",
        "lr, LR_r, LR_l = Rf.to_frame(l), then ls, LS_s, LS_lr = Sf.to_frame(lr), then the pixel with U_ls, U_k, U_d.",
        "U_lr = U_ls @ LS_lr; U_r = U_lr @ LR_r; U_s = U_ls @ LS_s; U_l = U_lr @ LR_l. U_k and U_d are ready.",
    ),
)

NAMES = ("u", "U_r", "U_s", "U_k", "U_d", "U_l")


def _frame(rng, far=1.0):
    return Frame3(np.concatenate([far * rng.uniform(-2, 2, 3), unit(rng.normal(size=4))[0]]))


def case(rng, n=2):
    """A robot, a camera on it, k and d, and a point that the camera sees."""
    Rf, Sf = _frame(rng), _frame(rng, 0.2)
    z = rng.uniform(2, 5)
    ls = z * np.array([*rng.uniform(-0.6, 0.6, 2), 1.0])
    k = np.array([320.0, 240, 300, 350]) * rng.uniform(0.9, 1.1, 4)
    return Rf, Sf, k, rng.uniform(-0.2, 0.2, n), Rf.from_frame(Sf.from_frame(ls)[0])[0]


def _out(result):
    return expect.results(result, *NAMES)


def _value(Rf, Sf, k, d, l):
    return package_pin_hole(Sf.to_frame(Rf.to_frame(l)[0])[0], k, d)[0]


def _value_with(args, place, x):
    """The pixel with another value of one argument."""
    args[place] = Frame3(x) if place < 2 else x
    return _value(*args)


@projected.link("six results", "The function must end with `return u, U_r, U_s, U_k, U_d, U_l`.")
def _(f, rng):
    for n in (2, 1):
        for value, name, shape in zip(_out(f(*case(rng, n))), NAMES, (2, 7, 7, 4, n, 3), strict=True):
            expect.array(value, 2 if name == "u" else (2, shape), name)


@projected.link("pixel", "First into the frame of the robot, then of the camera, then the pixel.", part=0)
def _(f, rng):
    for _ in range(3):
        args = case(rng)
        expect.close(expect.array(_out(f(*args))[0], 2, "u"), _value(*args), "u", at=f"l = {args[4].round(2)}")


def _derivative(f, rng, part, name, place, columns):
    for n in (2, 1, 3):
        args = case(rng, n)
        x = getattr(args[place], "x", args[place])
        J = expect.array(_out(f(*args))[part], (2, len(x)), name)

        def value(x, args=args):
            return _value_with(list(args), place, x)

        try:
            expect.jacobian(J, value, x, name, "uv", columns[: len(x)], atol=1e-4)
        except expect.Failed:
            T = np.eye(len(x))
            if place < 2:  # off the unit sphere formulas differ that are equal on it: compare along it
                T[3:, 3:] -= np.outer(x[3:], x[3:])
            if place > 1 or not same(J @ T, numerical_jacobian(value, x) @ T, atol=1e-4):
                raise


FRAME = ("t_x", "t_y", "t_z", "a", "b", "c", "d")


@projected.link("by the camera's frame", "U_s = U_ls LS_s, and LS_s is taken at lr, not at l.", part=2)
def _(f, rng):
    _derivative(f, rng, 2, "U_s", 1, FRAME)


@projected.link("by the robot's frame", "Rf changes lr, lr changes ls, ls changes u: U_r = U_ls LS_lr LR_r.", part=1)
def _(f, rng):
    _derivative(f, rng, 1, "U_r", 0, FRAME)


@projected.link("by the point", "l changes lr, lr changes ls, ls changes u: U_l = U_ls LS_lr LR_l.", part=5)
def _(f, rng):
    _derivative(f, rng, 5, "U_l", 4, ("x", "y", "z"))


@projected.link("by the camera's k", "No frame stands between k and the pixel: U_k comes out of pin_hole.", part=3)
def _(f, rng):
    _derivative(f, rng, 3, "U_k", 2, ("u0", "v0", "au", "av"))


@projected.link("by the distortion", "No frame stands between d and the pixel: U_d comes out of pin_hole.", part=4)
def _(f, rng):
    _derivative(f, rng, 4, "U_d", 3, ("d2", "d4", "d6"))


def _steps(Rf, Sf, k, d, l):
    lr, LR_r, LR_l = Rf.to_frame(l)
    ls, LS_s, LS_lr = Sf.to_frame(lr)
    return LR_r, LR_l, LS_s, LS_lr, pin_hole(ls, k, d)[1]


def _wrong(name, hint, **parts):
    """A misconception in some Jacobians: functions of LR_r, LR_l, LS_s, LS_lr, U_ls."""

    @projected.wrong(name, hint)
    def _(Rf, Sf, k, d, l):
        steps = _steps(Rf, Sf, k, d, l)
        right = dict(zip(NAMES, proj_euc_pnt(Rf, Sf, k, d, l), strict=True))
        return tuple((right | {name: g(*steps) for name, g in parts.items()}).values())


def _other_way(name, hint, point, frames=lambda Rf, Sf: (Rf, Sf)):
    """A misconception in the way of the point; the Jacobians are those of that way, by central differences."""

    @projected.wrong(name, hint)
    def _(Rf, Sf, k, d, l):
        right = proj_euc_pnt(Rf, Sf, k, d, l)
        return (package_pin_hole(point(Rf, Sf, l), k, d)[0], *right[1:])


# fmt: off
_other_way("frames swapped", "The point is in the world: it goes into the robot's frame first, then into the camera's.",
           lambda R, S, l: R.to_frame(S.to_frame(l)[0])[0])
_other_way("from_frame", "from_frame goes out of a frame. The point comes from the world and goes in: to_frame.",
           lambda R, S, l: S.from_frame(R.from_frame(l)[0])[0])
_other_way("camera at the centre of the robot", "The camera has a frame of its own on the robot: a second to_frame.",
           lambda R, S, l: R.to_frame(l)[0])
_other_way("camera in the world", "Sf is given in the robot: the point must go into the robot's frame first.",
           lambda R, S, l: S.to_frame(l)[0])
_wrong("U_r: camera left out", "LR_r is the derivative of lr. Two more steps follow: U_r = U_ls LS_lr LR_r.",
       U_r=lambda LR_r, LR_l, LS_s, LS_lr, U_ls: U_ls @ LR_r)
_wrong("U_l: camera left out", "LR_l is the derivative of lr. Two more steps follow: U_l = U_ls LS_lr LR_l.",
       U_l=lambda LR_r, LR_l, LS_s, LS_lr, U_ls: U_ls @ LR_l)
_wrong("U_ls for U_l", "U_ls is the derivative by the point in the *camera's* frame. By l it is U_ls LS_lr LR_l.",
       U_l=lambda LR_r, LR_l, LS_s, LS_lr, U_ls: U_ls)
_wrong("U_lr for U_l", "U_lr is the derivative by the point in the *robot's* frame. The factor LR_l is missing.",
       U_l=lambda LR_r, LR_l, LS_s, LS_lr, U_ls: U_ls @ LS_lr)
_wrong("U_s: one factor too many", "Sf acts in the second step, after lr: U_s = U_ls LS_s, without LS_lr.",
       U_s=lambda LR_r, LR_l, LS_s, LS_lr, U_ls: U_ls @ LS_lr @ LS_s)
_wrong("order of the factors", "The names must chain: U_ls LS_lr LR_l. In U_ls LR_l LS_lr they do not.",
       U_l=lambda LR_r, LR_l, LS_s, LS_lr, U_ls: U_ls @ LR_l @ LS_lr)
_wrong("a transposed factor", "A factor of the chain is transposed. Jacobians are used as they come: U_ls @ LS_lr.",
       U_r=lambda LR_r, LR_l, LS_s, LS_lr, U_ls: U_ls @ LS_lr.T @ LR_r,
       U_l=lambda LR_r, LR_l, LS_s, LS_lr, U_ls: U_ls @ LS_lr.T @ LR_l)
_wrong("U_r of the camera", "That is the derivative by Sf. Of the robot's frame it is U_ls LS_lr LR_r.",
       U_r=lambda LR_r, LR_l, LS_s, LS_lr, U_ls: U_ls @ LS_s)
# fmt: on


@projected.wrong("U_r and U_s exchanged", "Return the derivative by the robot's frame first, then by the camera's.")
def _(Rf, Sf, k, d, l):
    u, U_r, U_s, *rest = proj_euc_pnt(Rf, Sf, k, d, l)
    return u, U_s, U_r, *rest


@projected.wrong("LS_s taken at l", "The second step starts at lr: Sf.to_frame(lr), not Sf.to_frame(l).")
def _(Rf, Sf, k, d, l):
    u, U_r, _, *rest = proj_euc_pnt(Rf, Sf, k, d, l)
    U_ls = _steps(Rf, Sf, k, d, l)[4]
    return u, U_r, U_ls @ Sf.to_frame(l)[1], *rest


@projected.wrong("pin_hole at lr", "The camera sees ls, the point in its own frame, not lr.")
def _(Rf, Sf, k, d, l):
    LR_r, LR_l, LS_s, LS_lr, _ = _steps(Rf, Sf, k, d, l)
    right = proj_euc_pnt(Rf, Sf, k, d, l)
    U = pin_hole(Rf.to_frame(l)[0], k, d)[1]
    return right[0], U @ LS_lr @ LR_r, U @ LS_s, right[3], right[4], U @ LS_lr @ LR_l


@projected.variant("by composition of the frames")
def _(Rf, Sf, k, d, l):
    C, C_r, C_s = Rf.compose(Sf)
    ls, LS_c, LS_l = C.to_frame(l)
    u, U_ls, U_k, U_d = pin_hole(ls, k, d)
    U_c = U_ls @ LS_c
    return u, U_c @ C_r, U_c @ C_s, U_k, U_d, U_ls @ LS_l


@projected.variant("finite differences, as lists")
def _(Rf, Sf, k, d, l):
    args = [Rf, Sf, np.asarray(k, float), np.asarray(d, float), np.asarray(l, float)]

    def by(i):
        def value(x):
            return _value_with(list(args), i, x)

        return numerical_jacobian(value, getattr(args[i], "x", args[i])).tolist()

    return (_value(*args).tolist(), *(by(i) for i in range(5)))
