"""Exercise 22.3: a line is born from one segment and a prior."""

import numpy as np

from ...geometry import hat, unit
from ...models.landmarks.lines import plane_base
from ...models.sensors import SegmentCam
from ..table import table


def new_line(camera, y, b):
    """Plücker line, in the frame of the camera, from one measured segment and a prior of what it leaves open.

    y = [u1, v1, u2, v2], shape (4,), are the ends (px). `camera.retro(y)` returns m, M_y: the rays of both ends one
    behind the other, m = [m1; m2], shape (6,), and their derivative, shape (6, 4). The plane through the camera and the
    line has the normal n = m1 x m2 / |m1 x m2|. The direction of the line in that plane is not seen: the prior b = [b1,
    b2], shape (2,), says v = b1 e1 + b2 e2 (1/m).
    `unit(c)` returns c / |c| and its derivative by c. `plane_base(n)` returns e1, e2, E1_n, E2_n: two unit vectors in
    the plane, and their derivatives by n. `hat(a) @ b` is a x b.
    Return l = [n; v], shape (6,), L_y, shape (6, 4), and L_b, shape (6, 2): its derivatives by the segment and by the
    prior.
    """
    m, M_y = camera.retro(y)
    c, C_m = np.cross(m[:3], m[3:]), np.hstack([-hat(m[3:]), hat(m[:3])])
    n, N_c = unit(c)
    e1, e2, E1_n, E2_n = plane_base(n)
    v, V_n = b[0] * e1 + b[1] * e2, b[0] * E1_n + b[1] * E2_n
    N_y = N_c @ C_m @ M_y
    L_y = np.vstack([N_y, V_n @ N_y])
    L_b = np.vstack([np.zeros((3, 2)), np.column_stack([e1, e2])])
    return np.concatenate([n, v]), L_y, L_b


CAMERAS = (
    SegmentCam(),
    SegmentCam((300.0, 220.0, 400.0, 380.0), (-0.2, 0.05)),
    SegmentCam((310.0, 250.0, 250.0, 260.0)),
)


def case(rng, camera):
    """A segment of some length, in any direction, and a prior."""
    middle, a = rng.uniform([250, 180], [390, 300]), rng.uniform(0, 2 * np.pi)
    half = rng.uniform(50, 120) * np.array([np.cos(a), np.sin(a)])
    return camera, np.concatenate([middle - half, middle + half]), rng.uniform([0.1, 0.1], [0.5, 0.4])


born = table(
    "22.3 Born from one segment",
    new_line,
    hints=(
        "Value first: two rays, their cross product, its unit vector, a basis of the plane, v. Then the chain, by name.",
        "c = m1 x m2 has the derivative -hat(m2) by m1 and hat(m1) by m2. v depends on n through e1 and e2, and on b.",
        "N_y = N_c @ C_m @ M_y; V_n = b1 E1_n + b2 E2_n; L_y = [N_y; V_n N_y]; L_b = [0; e1 e2].",
    ),
    returns="l, L_y, L_b",
    symbols="N_y = the derivative of n by y; V_n = the derivative of v by n; "
    "C_m, N_c = the derivatives of c = m1 x m2 by m, and of n by c",
    jacobians={"L_y": "l", "L_b": "l"},
    entries={"l": "n_x, n_y, n_z, v_x, v_y, v_z", "y": "u1, v1, u2, v2", "b": "b1, b2"},
    cases={"any": lambda rng: [case(rng, camera) for camera in CAMERAS]},
    checks="""
    normal       | l[:3]     | any | The normal is across both rays, m1 x m2 in this order, and of length one.
    direction    | l[3:]     | any | v = b1 e1 + b2 e2, with the e1 and e2 of plane_base(n): a vector in the plane, n' v = 0. Its length, set by b, says how near the line is.
    by the prior | d L_b / b | any | v is linear in b: by b1 it moves along e1, by b2 along e2, and nothing of n moves: the plane was measured.
    by the ends  | d L_y / y | any | A pixel turns the plane: n changes, by the whole chain from the pixels over the rays and m1 x m2 to the unit vector. And e1, e2 lie in that plane, so v turns with n.
    """,
    wrong="""
    rays exchanged | np.cross(m[:3], m[3:]) -> np.cross(m[3:], m[:3]) | n is m1 x m2, in this order and with this sign: turned round, the line runs backwards.
    one normal for any length | n, N_c = unit(c) -> n, N_c = c, np.eye(3) | n has the length one here: unit(c), with its derivative.
    prior of length one | np.column_stack([e1, e2])]) -> np.column_stack([e1, e2]) / np.linalg.norm(b)]) | v = b1 e1 + b2 e2 is linear in b: its derivative is [e1, e2], whatever the length of b is.
    normal of any length, v of the unit one: n has the length one here: unit(c), with its derivative.
        np.concatenate([n, v]), -> np.concatenate([c, v]),
        np.vstack([N_y, V_n @ N_y]) -> np.vstack([C_m @ M_y, V_n @ N_y])
    v of length one | v, V_n = b[0] * e1 + b[1] * e2, -> v, V_n = (b[0] * e1 + b[1] * e2) / np.linalg.norm(b), | The length of v is the inverse distance of the line (n has the length one): do not take it away.
    e1 and e2 exchanged | v, V_n = b[0] * e1 + b[1] * e2, -> v, V_n = b[1] * e1 + b[0] * e2, | b1 goes with e1, which is parallel to the image; b2 with e2.
    prior forgotten | v, V_n = b[0] * e1 + b[1] * e2, -> v, V_n = e1, | The direction in the plane comes from the prior: v = b1 e1 + b2 e2.
    v as a point | np.concatenate([n, v]), -> np.concatenate([n, m[:3]]), | v is the *direction* of the line, not the ray to one of its ends.
    v first | np.concatenate([n, v]), -> np.concatenate([v, n]), | The normal stands first: l = [n; v].
    plane does not turn v | np.vstack([N_y, V_n @ N_y]) -> np.vstack([N_y, 0 * N_y]) | e1 and e2 lie in the plane: when a pixel turns the plane, v turns with it: its derivative by n, times that of n by the pixels, is missing.
    chain cut: the unit vector | N_c @ C_m @ M_y -> C_m @ M_y | The derivative of the unit vector is missing in the chain of n: unit vector, cross product, rays, each by what it is made of.
    chain cut: the rays | N_c @ C_m @ M_y -> (N_c @ C_m)[:, [0, 1, 3, 4]] | From pixels to rays there is the derivative of `retro`: the chain of n ends with it.
    sign of the first ray | np.hstack([-hat(m[3:]), hat(m[:3])]) -> np.hstack([hat(m[3:]), hat(m[:3])]) | m1 x m2 = -m2 x m1: by m1 the derivative is -hat(m2).
    hats exchanged | np.hstack([-hat(m[3:]), hat(m[:3])]) -> np.hstack([hat(m[:3]), -hat(m[3:])]) | By m1 the derivative has the *other* ray, -hat(m2); by m2 it is hat(m1).
    prior moves the normal | np.vstack([np.zeros((3, 2)), np.column_stack([e1, e2])]) -> np.vstack([np.column_stack([e1, e2]), np.zeros((3, 2))]) | The prior says where the line lies *in* its plane: rows of v. The normal was measured.
    prior times itself | np.column_stack([e1, e2])]) -> np.column_stack([b[0] * e1, b[1] * e2])]) | v = b1 e1 + b2 e2 is linear in b: the columns of L_b are e1 and e2 themselves, without b.
    prior in rows | np.column_stack([e1, e2])]) -> np.vstack([e1, e2, e1])[:, :2]]) | The columns of L_b are by b1 and b2: e1 and e2 stand upright.
    prior reshaped | np.column_stack([e1, e2])]) -> np.array([e1, e2]).reshape(3, 2)]) | reshape leaves the numbers in their order and mixes e1 with e2: the columns of L_b are e1 and e2, so transpose, or np.column_stack.
    rays exchanged, in the derivative, too: n is m1 x m2, in this order and with this sign: turned round, the line runs backwards.
        np.cross(m[:3], m[3:]), np.hstack([-hat(m[3:]), hat(m[:3])]) -> np.cross(m[3:], m[:3]), np.hstack([hat(m[3:]), -hat(m[:3])])
    divided by the length, not projected | n, N_c = unit(c) -> n, N_c = unit(c)[0], np.eye(3) / np.linalg.norm(c) | The length of c depends on the rays, too: the derivative of n by c is that of `unit`, (I - n n') / |c|.
    normal of any length, unit in the derivative | np.concatenate([n, v]), -> np.concatenate([c, v]), | n has the length one here: unit(c).
    prior left out of V_n | b[0] * E1_n + b[1] * E2_n -> E1_n + E2_n | v = b1 e1 + b2 e2: the derivatives of e1 and e2 come with b1 and b2, too.
    columns of the ends exchanged | N_y = N_c @ C_m @ M_y -> N_y = (N_c @ C_m @ M_y)[:, [2, 3, 0, 1]] | The first two columns of L_y belong to the first end, u1 and v1.
    rays interleaved | c, C_m = np.cross(m[:3], m[3:]), -> m, M_y = m[[0, 2, 4, 1, 3, 5]], M_y[[0, 2, 4, 1, 3, 5]]; c, C_m = np.cross(m[:3], m[3:]), | The rays stand one behind the other: m1 is m[:3], m2 is m[3:].
    """,
)
