"""Exercise 10.5: the chain rule with names."""

import numpy as np

from ...geometry import Frame3, numerical_jacobian, unit
from .. import expect
from ..diagnose import same
from ..exercise import Exercise


def see(Rf, Sf, p):
    """A point, seen from a sensor that stands on a robot, with all its derivatives.

    Rf: frame of the robot in the world. Sf: frame of the sensor in the robot. Both are Frame3.
    p, shape (3,): a point in the world.
    Return ps, shape (3,): the point in the sensor's frame; PS_r, PS_s, both of shape (3, 7): its derivatives by Rf.x
    and Sf.x; and PS_p, shape (3, 3): its derivative by p.
    """
    pr, PR_r, PR_p = Rf.to_frame(p)
    ps, PS_s, PS_pr = Sf.to_frame(pr)
    return ps, PS_pr @ PR_r, PS_s, PS_pr @ PR_p


exercise = Exercise(
    "10.5",
    "The chain rule",
    see,
    hints=(
        "Two steps: from the world to the robot, pr; from the robot to the sensor, ps. Each gives its own Jacobians.",
        "Write the names of the results as OUT_in: pr, PR_r, PR_p = Rf.to_frame(p). Which names make PS_r?",
        "ps, PS_s, PS_pr = Sf.to_frame(pr). In a product the inner names are equal: PS_pr @ PR_r. PS_p goes the same "
        "way.",
    ),
)


def _frame(rng):
    return Frame3(np.concatenate([rng.uniform(-2, 2, 3), unit(rng.normal(size=4))[0]]))


def _case(rng):
    return _frame(rng), _frame(rng), rng.uniform(-5, 5, 3)


def _out(result):
    return expect.results(result, "ps", "PS_r", "PS_s", "PS_p")


def _value(Rf, Sf, p):
    return Sf.to_frame(Rf.to_frame(p)[0])[0]


@exercise.link("four results", "The function must end with `return ps, PS_r, PS_s, PS_p`.")
def _(f, rng):
    names = ("ps", "PS_r", "PS_s", "PS_p")
    for value, name in zip(_out(f(*_case(rng))), names, strict=True):
        expect.true(value is not None, f"{name} is None: return {', '.join(names)}")


@exercise.link("value", "First into the robot's frame, then from there into the sensor's.", part=0)
def _(f, rng):
    none = Frame3(np.eye(7)[3])
    for which in (0, 1, 2, 2, 2):
        Rf, Sf, p = _case(rng)
        Rf, Sf = (none if which == 1 else Rf), (none if which == 0 else Sf)
        what = ("a sensor frame equal to the robot's", "a robot at the origin", "any two frames")[which]
        expect.close(expect.array(_out(f(Rf, Sf, p))[0], 3, "ps"), _value(Rf, Sf, p), "ps", at=what)


def _derivative(f, rng, part, name, vary, columns):
    for _ in range(3):
        Rf, Sf, p = _case(rng)
        x = (Rf.x, Sf.x, p)[part - 1]
        J = expect.array(_out(f(Rf, Sf, p))[part], (3, len(x)), name)
        value = lambda x, case=(Rf, Sf, p): _value(*vary(x, *case))
        try:
            expect.jacobian(J, value, x, name, ("x", "y", "z"), columns)
        except expect.Failed:
            T = _tangent(x)  # off the unit sphere formulas differ that are equal on it: compare along it
            if not same(J @ T, numerical_jacobian(value, x) @ T):
                raise


def _tangent(x):
    """Projector on the changes of a frame that keep |q| = 1; the identity for a point."""
    T = np.eye(len(x))
    T[3:, 3:] -= np.outer(x[3:], x[3:])
    return T


FRAME = ("t_x", "t_y", "t_z", "a", "b", "c", "d")


@exercise.link("by the sensor's frame", "PS_s comes out of the second step. It is taken at pr, not at p.", part=2)
def _(f, rng):
    _derivative(f, rng, 2, "PS_s", lambda x, Rf, Sf, p: (Rf, Frame3(x), p), FRAME)


@exercise.link("by the robot's frame", "Rf changes pr, and pr changes ps: PS_r = PS_pr PR_r.", part=1)
def _(f, rng):
    _derivative(f, rng, 1, "PS_r", lambda x, Rf, Sf, p: (Frame3(x), Sf, p), FRAME)


@exercise.link("by the point", "p changes pr, and pr changes ps: PS_p = PS_pr PR_p.", part=3)
def _(f, rng):
    _derivative(f, rng, 3, "PS_p", lambda x, Rf, Sf, p: (Rf, Sf, x), ("p_x", "p_y", "p_z"))


def _steps(Rf, Sf, p):
    return *Rf.to_frame(p), *Sf.to_frame(Rf.to_frame(p)[0])


@exercise.wrong("frames swapped", "The point is in the world: it goes into the robot's frame first, then the sensor's.")
def _(Rf, Sf, p):
    ps, PS_s, PS_r, PS_p = see(Sf, Rf, p)
    return ps, PS_r, PS_s, PS_p


@exercise.wrong("from_frame", "from_frame goes out of a frame. The point comes from the world and goes in: to_frame.")
def _(Rf, Sf, p):
    pr, PR_r, PR_p = Rf.from_frame(p)
    ps, PS_s, PS_pr = Sf.from_frame(pr)
    return ps, PS_pr @ PR_r, PS_s, PS_pr @ PR_p


@exercise.wrong("one step only", "That is the point in the robot's frame. The sensor has a frame of its own on it.")
def _(Rf, Sf, p):
    pr, PR_r, PR_p = Rf.to_frame(p)
    return pr, PR_r, Sf.to_frame(p)[1], PR_p


@exercise.wrong("second step taken at p", "PS_s must be taken where the second step starts, at pr: Sf.to_frame(pr).")
def _(Rf, Sf, p):
    ps, PS_r, _, PS_p = see(Rf, Sf, p)
    return ps, PS_r, Sf.to_frame(p)[1], PS_p


@exercise.wrong("PR_r handed on", "PR_r is the derivative of pr, not of ps: the names must chain, PS_pr @ PR_r.")
def _(Rf, Sf, p):
    pr, PR_r, PR_p, ps, PS_s, PS_pr = _steps(Rf, Sf, p)
    return ps, PR_r, PS_s, PS_pr @ PR_p


@exercise.wrong("PS_pr for PS_p", "PS_pr is the derivative by the point in the *robot's* frame: PS_p = PS_pr @ PR_p.")
def _(Rf, Sf, p):
    pr, PR_r, PR_p, ps, PS_s, PS_pr = _steps(Rf, Sf, p)
    return ps, PS_pr @ PR_r, PS_s, PS_pr


@exercise.wrong("PR_p for PS_p", "PR_p is the derivative of pr. Of ps it is PS_pr @ PR_p: the names must chain.")
def _(Rf, Sf, p):
    pr, PR_r, PR_p, ps, PS_s, PS_pr = _steps(Rf, Sf, p)
    return ps, PS_pr @ PR_r, PS_s, PR_p


@exercise.wrong("product the wrong way round", "PR_p @ PS_pr: the names do not chain (p, then ps). Turn it round: "
                "PS_pr @ PR_p.")  # fmt: skip
def _(Rf, Sf, p):
    pr, PR_r, PR_p, ps, PS_s, PS_pr = _steps(Rf, Sf, p)
    return ps, PS_pr @ PR_r, PS_s, PR_p @ PS_pr


@exercise.wrong(
    "transposed factor", "A factor of the chain is transposed. Jacobians are used as they come: PS_pr @ PR_r."
)
def _(Rf, Sf, p):
    pr, PR_r, PR_p, ps, PS_s, PS_pr = _steps(Rf, Sf, p)
    return ps, PS_pr.T @ PR_r, PS_s, PS_pr.T @ PR_p


@exercise.wrong("Jacobians by frames swapped", "Return the derivative by the robot's frame first, then the sensor's.")
def _(Rf, Sf, p):
    ps, PS_r, PS_s, PS_p = see(Rf, Sf, p)
    return ps, PS_s, PS_r, PS_p


@exercise.wrong("PS_s multiplied once more", "PS_s is the derivative of ps already: nothing stands behind the sensor.")
def _(Rf, Sf, p):
    pr, PR_r, PR_p, ps, PS_s, PS_pr = _steps(Rf, Sf, p)
    return ps, PS_pr @ PR_r, PS_pr @ PS_s, PS_pr @ PR_p


@exercise.variant("by composition of the frames")
def _(Rf, Sf, p):
    C, C_r, C_s = Rf.compose(Sf)
    ps, PS_c, PS_p = C.to_frame(p)
    return ps, PS_c @ C_r, PS_c @ C_s, PS_p


@exercise.variant("finite differences, as lists")
def _(Rf, Sf, p):
    from ...geometry import numerical_jacobian

    PS_r = numerical_jacobian(lambda F: _value(F, Sf, p), Rf)
    PS_s = numerical_jacobian(lambda F: _value(Rf, F, p), Sf)
    return _value(Rf, Sf, p).tolist(), PS_r.tolist(), PS_s.tolist(), (Sf.Rt @ Rf.Rt).tolist()


@exercise.variant("rotation matrices")
def _(Rf, Sf, p):
    pr, PR_r, _ = Rf.to_frame(p)
    return Sf.R.T @ (pr - Sf.t), Sf.R.T @ PR_r, Sf.to_frame(pr)[1], (Rf.R @ Sf.R).T
