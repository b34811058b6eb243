"""Exercise 10.5: the chain rule with names."""

import numpy as np

from ...geometry import Frame3, unit
from ..table import table


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


def frame(rng, far=1.0):
    """Return some frame; `far` scales its position."""
    return Frame3(np.concatenate([far * rng.uniform(-2, 2, 3), unit(rng.normal(size=4))[0]]))


def point(rng):
    """Return some point."""
    return rng.uniform(-5, 5, 3)


def sphere(F):
    """Return the projector on the changes of a frame that keep |q| = 1."""
    T = np.eye(7)
    T[3:, 3:] -= np.outer(F.q, F.q)
    return T


NONE = Frame3(np.eye(7)[3])

exercise = table(
    "10.5 The chain rule",
    see,
    hints=(
        "Two steps: from the world to the robot, pr; from the robot to the sensor, ps. Each gives its own Jacobians.",
        "Write the names of the results as OUT_in: pr, PR_r, PR_p = Rf.to_frame(p). Which names make PS_r?",
        "ps, PS_s, PS_pr = Sf.to_frame(pr). In a product the inner names are equal: PS_pr @ PR_r. PS_p goes the same way.",
    ),
    returns="ps, PS_r, PS_s, PS_p",
    symbols="PR_r, PR_p = the derivatives of pr, the point in the robot's frame, by Rf.x and by p; "
    "PS_pr = the derivative of ps by pr",
    jacobians={"PS_p": "ps"},
    along={"PS_r": lambda Rf, Sf, p: sphere(Rf), "PS_s": lambda Rf, Sf, p: sphere(Sf)},
    cases={
        "any": lambda rng: [(frame(rng), frame(rng), point(rng)) for _ in range(4)],
        "one": lambda rng: [(frame(rng), NONE, point(rng)), (NONE, frame(rng), point(rng))],
    },
    checks="""
    one frame             | ps         | one | First into the robot's frame, then from there into the sensor's.
    value                 | ps         | any | First into the robot's frame, then from there into the sensor's.
    by the sensor's frame | PS_s       | any | PS_s is the derivative of the second step by Sf.x, as Sf.to_frame(pr) returns it.
    by the robot's frame  | PS_r       | any | Rf changes pr, and pr changes ps: PS_r = PS_pr PR_r.
    by the point          | d PS_p / p | any | p changes pr, and pr changes ps: PS_p = PS_pr PR_p.
    """,
    wrong="""
    frames swapped | pr, PR_r, PR_p = Rf.to_frame(p) -> pr, PS_s, PR_p = Sf.to_frame(p) | The point is in the world: it goes into the robot's frame first, then the sensor's.
        ps, PS_s, PS_pr = Sf.to_frame(pr) -> ps, PS_r, PS_pr = Rf.to_frame(pr)
        return ps, PS_pr @ PR_r, PS_s -> return ps, PS_r, PS_pr @ PS_s
    from_frame | Rf.to_frame -> Rf.from_frame | from_frame goes out of a frame. The point comes from the world and goes in: to_frame.
        Sf.to_frame -> Sf.from_frame
    one step only | return ps, PS_pr @ PR_r, PS_s, PS_pr @ PR_p -> return pr, PR_r, Sf.to_frame(p)[1], PR_p | That is the point in the robot's frame. The sensor has a frame of its own on it.
    second step taken at p | PR_r, PS_s, -> PR_r, Sf.to_frame(p)[1], | PS_s must be taken where the second step starts, at pr: Sf.to_frame(pr).
    PR_r handed on | PS_pr @ PR_r -> PR_r | PR_r is the derivative of pr, not of ps: the names must chain, PS_pr @ PR_r.
    PS_pr for PS_p | PS_pr @ PR_p -> PS_pr | PS_pr is the derivative by the point in the *robot's* frame: PS_p = PS_pr @ PR_p.
    PR_p for PS_p | PS_pr @ PR_p -> PR_p | PR_p is the derivative of pr. Of ps it is PS_pr @ PR_p: the names must chain.
    product the wrong way round | PS_pr @ PR_p -> PR_p @ PS_pr | PR_p @ PS_pr: the names do not chain (p, then ps). Turn it round: PS_pr @ PR_p.
    transposed factor | PS_pr @ PR_r -> PS_pr.T @ PR_r | A factor of the chain is transposed. Jacobians are used as they come: PS_pr @ PR_r.
        PS_pr @ PR_p -> PS_pr.T @ PR_p
    frames swapped, not their names | Rf.to_frame(p) -> Sf.to_frame(p) | The point is in the world: it goes into the robot's frame first, then the sensor's.
        Sf.to_frame(pr) -> Rf.to_frame(pr)
    Jacobians by frames swapped | PS_pr @ PR_r, PS_s, -> PS_s, PS_pr @ PR_r, | Return the derivative by the robot's frame first, then the sensor's.
    PS_s multiplied once more | PS_s, PS_pr @ PR_p -> PS_pr @ PS_s, PS_pr @ PR_p | PS_s is the derivative of ps already: nothing stands behind the sensor.
    both factors transposed | PS_pr @ PR_p -> PS_pr.T @ PR_p.T | Jacobians are used as they come: PS_pr @ PR_p, no transposes.
    PS_r twice | PR_r, PS_s, -> PR_r, PS_pr @ PR_r, | PS_s is the derivative by the sensor's frame: it comes out of the second step, Sf.to_frame(pr).
    the other factor | PS_pr @ PR_r -> PR_p @ PR_r | PS_r goes through pr: its factors are PS_pr and PR_r, not PR_p.
    positions with a plus | return ps, PS_pr @ PR_r, PS_s, -> S = np.array([-1, -1, -1, 1, 1, 1, 1]); return ps, PS_pr @ (PR_r * S), PS_s * S, | When a frame goes forward, the point comes nearer in it: the derivatives by a position have a minus, -R'.
    """,
)
