"""Exercise 12.4: a point of the world in a camera on a robot, the manual's direct model with all Jacobians."""

import numpy as np

from ..table import table
from .nb10_chain import frame, sphere
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
    U_r = U_ls @ LS_lr @ LR_r
    U_s = U_ls @ LS_s
    U_l = U_ls @ LS_lr @ LR_l
    return u, U_r, U_s, U_k, U_d, U_l


def case(rng, n=2):
    """A robot, a camera on it, k and d, and a point that the camera sees."""
    Rf, Sf = frame(rng), frame(rng, 0.2)
    ls = rng.uniform(2, 5) * np.array([*rng.uniform(-0.6, 0.6, 2), 1.0])
    k = np.array([320.0, 240, 300, 350]) * rng.uniform(0.9, 1.1, 4)
    return Rf, Sf, k, rng.uniform(-0.2, 0.2, n), Rf.from_frame(Sf.from_frame(ls)[0])[0]


projected = table(
    "12.4 A camera on a robot",
    proj_euc_pnt,
    hints=(
        "Three steps: world to robot, lr; robot to camera, ls; camera to pixel, u. Name the Jacobians of each.",
        "lr, LR_r, LR_l = Rf.to_frame(l), then ls, LS_s, LS_lr = Sf.to_frame(lr), then the pixel with U_ls, U_k, U_d.",
        "U_lr = U_ls @ LS_lr; U_r = U_lr @ LR_r; U_s = U_ls @ LS_s; U_l = U_lr @ LR_l. U_k and U_d are ready.",
    ),
    returns="u, U_r, U_s, U_k, U_d, U_l",
    symbols="LR_r, LR_l = the derivatives of lr, the point in the robot's frame, by Rf.x and by l; "
    "LS_s, LS_lr = the derivatives of ls, the point in the camera's frame, by Sf.x and by lr; "
    "U_ls = the derivative of u by ls",
    jacobians={"U_k": "u", "U_d": "u", "U_l": "u"},
    entries={"u": "u, v", "k": "u0, v0, au, av", "d": "d2, d4, d6", "l": "x, y, z"},
    along={"U_r": lambda Rf, Sf, k, d, l: sphere(Rf), "U_s": lambda Rf, Sf, k, d, l: sphere(Sf)},
    cases={"any": lambda rng: [case(rng, n) for n in (2, 1, 3)]},
    checks="""
    pixel                 | u         | any | First into the frame of the robot, then of the camera, then the pixel.
    by the camera's frame | U_s       | any | U_s = U_ls LS_s: LS_s is taken at lr, the point in the robot's frame, and U_ls at ls.
    by the robot's frame  | U_r       | any | Rf changes lr, lr changes ls, ls changes u: U_r = U_ls LS_lr LR_r.
    by the point          | d U_l / l | any | l changes lr, lr changes ls, ls changes u: U_l = U_ls LS_lr LR_l.
    by the camera's k     | d U_k / k | any | k acts in the last step, from ls, the point in the camera's frame, to u: U_k is what pin_hole gives there, as it is.
    by the distortion     | d U_d / d | any | d acts in the last step, from ls, the point in the camera's frame, to u: U_d is what pin_hole gives there, as it is.
    """,
    wrong="""
    frames swapped | return u, -> return pin_hole(Rf.to_frame(Sf.to_frame(l)[0])[0], k, d)[0], | The point is in the world: it goes into the robot's frame first, then into the camera's.
    from_frame | return u, -> return pin_hole(Sf.from_frame(Rf.from_frame(l)[0])[0], k, d)[0], | from_frame goes out of a frame. The point comes from the world and goes in: to_frame.
    camera at the centre of the robot | return u, -> return pin_hole(lr, k, d)[0], | The camera has a frame of its own on the robot: a second to_frame.
    camera in the world | return u, -> return pin_hole(Sf.to_frame(l)[0], k, d)[0], | Sf is given in the robot: the point must go into the robot's frame first.
    U_r: camera left out | U_ls @ LS_lr @ LR_r -> U_ls @ LR_r | LR_r is the derivative of lr. Two more steps follow: U_r = U_ls LS_lr LR_r.
    U_l: camera left out | U_ls @ LS_lr @ LR_l -> U_ls @ LR_l | LR_l is the derivative of lr. Two more steps follow: U_l = U_ls LS_lr LR_l.
    U_ls for U_l | U_ls @ LS_lr @ LR_l -> U_ls | U_ls is the derivative by the point in the *camera's* frame. By l it is U_ls LS_lr LR_l.
    U_lr for U_l | U_ls @ LS_lr @ LR_l -> U_ls @ LS_lr | U_lr is the derivative by the point in the *robot's* frame. The factor LR_l is missing.
    U_s: one factor too many | U_ls @ LS_s -> U_ls @ LS_lr @ LS_s | Sf acts in the second step, after lr: U_s = U_ls LS_s, without LS_lr.
    order of the factors | U_ls @ LS_lr @ LR_l -> U_ls @ LR_l @ LS_lr | The names must chain: U_ls LS_lr LR_l. In U_ls LR_l LS_lr they do not.
    a transposed factor | U_ls @ LS_lr @ LR_r -> U_ls @ LS_lr.T @ LR_r | The transpose of LS_lr stands in the chain. LS_lr is used as Sf.to_frame(lr) gives it: U_ls @ LS_lr.
        U_ls @ LS_lr @ LR_l -> U_ls @ LS_lr.T @ LR_l
    U_r of the camera | U_ls @ LS_lr @ LR_r -> U_ls @ LS_s | That is the derivative by Sf. Of the robot's frame it is U_ls LS_lr LR_r.
    frames in the wrong order: The point goes into the frame of the robot first, Rf, and the result into that of the camera, Sf.
        lr, LR_r, LR_l = Rf.to_frame(l) -> Rf, Sf = Sf, Rf; lr, LR_r, LR_l = Rf.to_frame(l)
        return u, U_r, U_s -> return u, U_s, U_r
    U_r and U_s exchanged | return u, U_r, U_s -> return u, U_s, U_r | Return the derivative by the robot's frame first, then by the camera's.
    U_r twice | U_ls @ LS_s -> U_ls @ LS_lr @ LR_r | U_s is the derivative by the camera's frame, the second step: U_s = U_ls LS_s.
    LS_s taken at l | U_ls @ LS_s -> U_ls @ Sf.to_frame(l)[1] | The second step starts at lr: Sf.to_frame(lr), not Sf.to_frame(l).
    pin_hole at lr | U_r = U_ls -> U_ls = pin_hole(lr, k, d)[1]; U_r = U_ls | The camera sees ls, the point in its own frame, not lr.
    from_frame for the camera | Sf.to_frame(lr) -> Sf.from_frame(lr) | Both steps go into a frame: to_frame, for the camera, too.
    from_frame for the robot | Rf.to_frame(l) -> Rf.from_frame(l) | Both steps go into a frame: to_frame, for the robot, too.
    U_r: orientation forgotten | U_r = U_ls @ LS_lr @ LR_r -> U_r = U_ls @ LS_lr @ (LR_r * [1, 1, 1, 0, 0, 0, 0]) | A robot that turns sees the point elsewhere, too: the last four columns of U_r are not zero.
    U_s: orientation forgotten | U_s = U_ls @ LS_s -> U_s = U_ls @ (LS_s * [1, 1, 1, 0, 0, 0, 0]) | A camera that turns sees the point elsewhere, too: the last four columns of U_s are not zero.
    """,
)
