"""Answers to the exercises of notebook 10 that are in no list of the package."""

import numpy as np

from ekfslam_tutorial.geometry import Frame3, R2q, numerical_jacobian, q2qc, q2R, q_prod, unit

from .collector import answer_to, check_of

# --- 10.5: the same in other words ---


def _value_5(Rf, Sf, p):
    return Sf.to_frame(Rf.to_frame(p)[0])[0]


@answer_to("10.5", right=True)
def by_composition_of_the_frames(Rf, Sf, p):
    C, C_r, C_s = Rf.compose(Sf)
    ps, PS_c, PS_p = C.to_frame(p)
    return ps, PS_c @ C_r, PS_c @ C_s, PS_p


@answer_to("10.5", right=True)
def finite_differences_as_lists(Rf, Sf, p):

    PS_r = numerical_jacobian(lambda F: _value_5(F, Sf, p), Rf)
    PS_s = numerical_jacobian(lambda F: _value_5(Rf, F, p), Sf)
    return _value_5(Rf, Sf, p).tolist(), PS_r.tolist(), PS_s.tolist(), (Sf.Rt @ Rf.Rt).tolist()


@answer_to("10.5", right=True)
def rotation_matrices(Rf, Sf, p):
    pr, PR_r, _ = Rf.to_frame(p)
    return Sf.R.T @ (pr - Sf.t), Sf.R.T @ PR_r, Sf.to_frame(pr)[1], (Rf.R @ Sf.R).T


# --- 10.2: the same in other words ---


@answer_to("10.2", right=True)
def with_rotation_matrices_as_a_list(F, G):
    R_F, R_G = q2R(F[3:])[0], q2R(G[3:])[0]
    return [*(R_F @ G[:3] + F[:3]), *R2q(R_F @ R_G)[0]]


@answer_to("10.2", right=True)
def with_two_quaternion_products_and_the_other_sign(F, G):
    q = F[3:]
    t = q_prod(q_prod(q, [0, *G[:3]])[0], q2qc(q)[0])[0][1:] + F[:3]
    return np.hstack([t, -q_prod(q, G[3:])[0]])


@answer_to("10.2", right=True)
def the_packages_frames(F, G):
    return Frame3(F).compose(Frame3(G))[0].x


# --- 10.4: the same in other words ---


@answer_to("10.4", right=True)
def the_packages_difference(x, truth):
    return Frame3(x).minus(Frame3(truth))[0]


@answer_to("10.4", right=True)
def scipys_rotations(x, truth):
    from scipy.spatial.transform import Rotation

    q, p = (Rotation.from_quat(np.roll(y[3:], -1)) for y in (x, truth))  # scipy: scalar last
    return [*np.subtract(x[:3], truth[:3]), *(p.inv() * q).as_rotvec()]


@answer_to("10.4", right=True)
def with_arctan2(x, truth):
    a, *b = q_prod(q2qc(truth[3:])[0], x[3:])[0]
    n = np.linalg.norm(b)
    if n < 1e-12:
        return np.array([*(x[:3] - truth[:3]), 0, 0, 0])
    angle = 2 * np.arctan2(n, a)
    angle = angle - 2 * np.pi if angle > np.pi else angle
    return np.array([*(x[:3] - truth[:3]), *(angle * np.array(b) / n)])


# --- 10.3: the same in other words ---


@answer_to("10.3", right=True)
def the_packages_frame(x, P):
    N, N_f = Frame3(x).normalized()
    return N.x, N_f @ P @ N_f.T


@answer_to("10.3", right=True)
def block_by_block_as_lists(x, P):
    u, U = unit(x[3:])
    new = np.block([[P[:3, :3], P[:3, 3:] @ U.T], [U @ P[3:, :3], U @ P[3:, 3:] @ U.T]])
    return [*x[:3], *u], new.tolist()


@answer_to("10.3", right=True)
def finite_differences(x, P):

    J = numerical_jacobian(lambda x: np.concatenate([x[:3], x[3:] / np.sqrt(x[3:] @ x[3:])]), x)
    J[:3, :3], J[:3, 3:], J[3:, :3] = np.eye(3), 0, 0
    return np.concatenate([x[:3], x[3:] / np.sqrt(x[3:] @ x[3:])]), J @ P @ J.T


# --- 10.1: the same in other words ---


@answer_to("10.1", right=True)
def solve_and_lists(t, R, p):
    R = np.asarray(R)
    back = np.linalg.inv(R)
    return np.linalg.solve(R, np.subtract(p, t)).tolist(), (-back).tolist(), back.tolist()


@answer_to("10.1", right=True)
def row_vectors(t, R, p):
    PF_p = R.T.copy()
    return (p - t) @ R, -1 * PF_p, PF_p


@answer_to("10.1", right=True)
def the_packages_frame_too(t, R, p):
    from ekfslam_tutorial.geometry import R2q

    pf, PF_f, PF_p = Frame3(np.concatenate([t, R2q(R)[0]])).to_frame(p)
    return pf, PF_f[:, :3], PF_p


test_the_check_is_right_about_it = check_of(__name__)
