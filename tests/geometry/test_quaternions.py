"""Rotations: two views of every Jacobian, round trips, a second author, and the singular places."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ekfslam_tutorial import geometry as g
from ekfslam_tutorial.geometry import check_jacobians

RNG = np.random.default_rng(7)
AXES = np.concatenate([np.eye(3), [[1, 1, 0], [1, -2, 3]] / np.sqrt([[2], [14]])])

# Rotation vectors: ordinary ones, those near zero on both sides of the switch to series, and near a half turn.
SMALL_ANGLES = [0.0, 1e-12, 1e-8, 0.9e-4, 1.1e-4, 1e-3]
ANGLES = [*SMALL_ANGLES, 0.1, 1.0, 2.0, np.pi - 1e-3, np.pi - 1e-7, np.pi, np.pi + 1e-3, 5.0]
VECTORS = [a * u for a in ANGLES for u in AXES] + list(RNG.normal(size=(10, 3)))


def quaternion(v):
    """Unit quaternion of a rotation vector, by half-angle formulas and nothing of the package."""
    a = np.linalg.norm(v)
    return np.array([np.cos(a / 2), *(np.sin(a / 2) * v / a if a else v)])


UNIT = [quaternion(v) for v in VECTORS]
QUATERNIONS = UNIT + [1.3 * q for q in UNIT[::7]] + [-0.8 * q for q in UNIT[::11]]
EULER = [
    *RNG.uniform(-1.5, 1.5, (10, 3)),
    np.zeros(3),
    np.array([0.3, np.pi / 2 - 0.01, -2.0]),
    np.array([3.1, -1.5, 3.1]),
]


def away_from(test, values):
    return [v for v in values if not test(v)]


def no_axis(q):
    """Whether the axis is too near to undefined for a difference quotient of step 1e-6."""
    return np.linalg.norm(q[1:]) < 1e-2


def full_turn(q):
    """Whether q stands for a turn by 2 pi, where the rotation vector has no direction."""
    return q[0] < 0 and np.linalg.norm(q[1:]) < 1e-2


def tie(q):
    """Whether two components are the largest: there R2q changes its branch, and maybe the sign of q."""
    first, second = sorted(abs(q))[:1:-1]
    return first - second < 1e-5


def euler(q):
    """Euler angles near those of q, so that a difference quotient does not step over the seam at pi."""
    e = g.q2e(q)[0]
    return lambda q: (e + g.wrap(g.q2e(q)[0] - e), g.q2e(q)[1])


def gimbal(q):
    return abs(abs(q[0] * q[2] - q[1] * q[3]) / (q @ q) - 0.5) < 1e-5


# Function with its Jacobians, and the arguments to try. Outputs that belong together are split into single functions.
CASES = {
    "unit": (g.unit, [(q,) for q in QUATERNIONS]),
    "q_prod": (g.q_prod, list(zip(QUATERNIONS, QUATERNIONS[::-1], strict=True))),
    "q2qc": (g.q2qc, [(q,) for q in QUATERNIONS[::9]]),
    "q2R": (g.q2R, [(q,) for q in QUATERNIONS]),
    "R2q": (lambda R: (g.R2q(R)[0], g.R2q(R)[1].reshape(4, 9)), [(g.q2R(q)[0],) for q in away_from(tie, UNIT)]),
    "e2q": (g.e2q, [(e,) for e in EULER]),
    "q2e": (g.q2e, [(q,) for q in away_from(gimbal, QUATERNIONS)]),
    "e2R": (g.e2R, [(e,) for e in EULER]),
    "v2q": (g.v2q, [(v,) for v in VECTORS]),
    "q2v": (g.q2v, [(q,) for q in away_from(full_turn, QUATERNIONS)]),
    "v2au": (
        lambda v: (np.append(*g.v2au(v)[1::-1]), np.concatenate([g.v2au(v)[3], g.v2au(v)[2][None]])),
        [(v,) for v in VECTORS if np.linalg.norm(v) > 1e-2],
    ),
    "au2v": (lambda a, u: (v := g.au2v(a[0], u), (v[0], v[1][:, None], v[2]))[1], [(np.array([0.7]), u) for u in AXES]),
    "au2q": (lambda a, u: (q := g.au2q(a[0], u), (q[0], q[1][:, None], q[2]))[1], [(np.array([0.7]), u) for u in AXES]),
    "q2au": (
        lambda q: (np.append(*g.q2au(q)[1::-1]), np.concatenate([g.q2au(q)[3], g.q2au(q)[2][None]])),
        [(q,) for q in away_from(no_axis, QUATERNIONS)],
    ),
}
LINEAR = {"hat", "q2Q", "q2Qn", "q2Pi", "pi2pc", "w2omega", "q2R_q"}  # linear in their argument: tested by identities
OTHERS = {"ORIGIN", "Frame2", "Frame3", "align", "check_jacobians", "numerical_jacobian", "wrap"}


def test_every_exported_function_is_tested():
    assert set(g.__all__) == set(CASES) | LINEAR | OTHERS


@pytest.mark.parametrize("name", CASES)
def test_jacobians(name):
    f, arguments = CASES[name]
    assert len(arguments) >= 5
    for args in arguments:
        check_jacobians(euler(*args) if name == "q2e" else f, *args, rtol=1e-6)


@pytest.mark.parametrize("q", UNIT)
def test_a_second_author_agrees(q):
    """scipy's Rotation, [b c d a] there."""
    R = Rotation.from_quat([*q[1:], q[0]])
    v = np.array([0.3, -1.0, 2.0])
    assert np.allclose(g.q2R(q)[0], R.as_matrix(), atol=1e-14)
    assert np.allclose(g.q2R(q)[0] @ v, R.apply(v), atol=1e-14)
    shortest = g.q2v(q if q[0] >= 0 else -q)[0]
    if q[0] != 0:  # at a half turn both senses of rotation are as short
        assert np.allclose(shortest, R.as_rotvec(), atol=1e-12)
    if not gimbal(q):
        assert np.allclose(g.wrap(g.q2e(q)[0] - R.as_euler("ZYX")[::-1]), 0, atol=1e-12)


def test_products_agree_with_a_second_author():
    for q1, q2 in zip(UNIT, UNIT[::-1], strict=True):
        q = (Rotation.from_quat([*q1[1:], q1[0]]) * Rotation.from_quat([*q2[1:], q2[0]])).as_quat()
        ours = g.q_prod(q1, q2)[0]
        assert np.allclose(abs(ours @ np.array([q[3], *q[:3]])), 1, atol=1e-14)


@pytest.mark.parametrize("q", UNIT)
def test_matrix_to_quaternion_and_back(q):
    """All four branches of R2q, half turns included; q and -q are the same rotation."""
    back = g.R2q(g.q2R(q)[0])[0]
    assert np.allclose(abs(back @ q), 1, atol=1e-14)
    assert back[np.argmax(abs(back))] > 0


def test_each_branch_of_R2q_is_taken():
    largest = {int(np.argmax(abs(g.R2q(g.q2R(q)[0])[0]))) for q in UNIT}
    assert largest == {0, 1, 2, 3}


@pytest.mark.parametrize("e", [e for e in EULER if abs(e[1]) < np.pi / 2])
def test_euler_angles_and_back(e):
    assert np.allclose(g.q2e(g.e2q(e)[0])[0], e, atol=1e-12)
    Rx, Ry, Rz = (Rotation.from_rotvec(a * u).as_matrix() for a, u in zip(e, np.eye(3), strict=True))
    assert np.allclose(g.e2R(e)[0], Rz @ Ry @ Rx, atol=1e-14)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-9, 1e-6 - np.pi / 2])
def test_at_the_gimbal_lock_the_rotation_is_still_right(pitch):
    """Roll and yaw are one rotation there; which part is called which does not matter, but their sum does."""
    for roll, yaw in ((0.4, -0.3), (-2.0, 3.0), (0.0, 0.0)):
        q = g.e2q(np.array([roll, pitch, yaw]))[0]
        e = g.q2e(q)[0]
        assert np.allclose(g.e2R(e)[0], g.q2R(q)[0], atol=1e-7)


@pytest.mark.parametrize("v", [v for v in VECTORS if np.linalg.norm(v) < 2 * np.pi])
def test_rotation_vector_and_back(v):
    assert np.allclose(g.q2v(g.v2q(v)[0])[0], v, rtol=1e-12, atol=1e-15)
    a, u, *_ = g.v2au(v)
    assert np.allclose(g.au2v(a, u)[0], v) and np.allclose(g.au2q(a, u)[0], g.v2q(v)[0])
    assert g.q2au(g.v2q(v)[0])[0] == pytest.approx(a, abs=1e-12)


def test_no_step_at_the_switch_to_series():
    """Just below and just above the switch, value and Jacobian differ by what the change of the argument explains."""
    u = AXES[-1]
    for f, below, above in (
        (g.v2q, 1e-4 * (1 - 1e-9) * u, 1e-4 * (1 + 1e-9) * u),
        (g.q2v, np.append(1, 1e-4 * (1 - 1e-9) * u), np.append(1, 1e-4 * (1 + 1e-9) * u)),
    ):
        for low, high in zip(f(below), f(above), strict=True):
            assert np.allclose(low, high, rtol=0, atol=1e-11)  # 2e-13 of the argument times a derivative of 2


@pytest.mark.parametrize("n", [1.0, 1e-3, 1.01e-4, 0.99e-4, 1e-6, 1e-9, 1e-15, 1e-100])
@pytest.mark.parametrize("scale", [1.0, 0.7])
def test_almost_a_whole_turn(n, scale):
    """q and -q are the same rotation: v(q) = v(-q) + 2 pi u, and the derivative of that. -q is close to [1 0 0 0]."""
    axis = np.array([2.0, -1.0, 2.0]) / 3
    q = scale * np.append(-np.cos(n), np.sin(n) * axis)
    (v, V_q), (rest, REST_q), (u, U_b) = g.q2v(q), g.q2v(-q), g.unit(q[1:])
    np.testing.assert_allclose(v, rest + 2 * np.pi * u, rtol=1e-13)
    wanted = -REST_q
    wanted[:, 1:] += 2 * np.pi * U_b
    np.testing.assert_allclose(V_q, wanted, rtol=1e-9, atol=1e-13 * np.abs(wanted).max())
    assert np.linalg.norm(v) == pytest.approx(2 * np.pi - 2 * n, rel=1e-13)


@pytest.mark.parametrize("rest", [[0, 0, 0], [0, -0.0, 1e-200], [5e-324, 0, 0], [1e-162, 1e-162, 0]])
def test_a_whole_turn_is_finite(rest):
    """No axis is defined, or none can be told; alone and in a stack with other quaternions."""
    v, V_q = g.q2v(np.array([-1.0, *rest]))
    assert np.array_equal(v, [2 * np.pi, 0, 0]) and not V_q.any()
    stack, J = g.q2v(np.array([[-1.0, *rest], [1, 0, 0, 0], [-0.6, 0, 0.8, 0]]))
    assert np.array_equal(stack[0], v) and not stack[1].any() and np.array_equal(J[1], [[0, 2, 0, 0], *J[1, 1:]])
    assert np.array_equal(stack[2], g.q2v(np.array([-0.6, 0, 0.8, 0]))[0])


def test_no_rotation_has_an_axis_all_the_same():
    a, u, A_v, U_v = g.v2au(np.zeros(3))
    assert a == 0 and np.linalg.norm(u) == 1 and not A_v.any() and not U_v.any()


def test_q_and_minus_q_turn_by_angles_that_add_up_to_a_full_turn():
    for q in away_from(no_axis, UNIT):
        assert g.q2au(q)[0] + g.q2au(-q)[0] == pytest.approx(2 * np.pi)


@pytest.mark.parametrize("q", QUATERNIONS[::5])
def test_matrices_of_the_product(q, rng):
    """Products, cross products and rates are the same bilinear form."""
    p, v, w = rng.normal(size=4), rng.normal(size=3), rng.normal(size=3)
    product = g.q_prod(q, p)[0]
    assert np.allclose(g.q2Q(q) @ p, product) and np.allclose(g.q2Qn(p) @ q, product)
    assert np.allclose(g.hat(v) @ w, np.cross(v, w))
    rate = g.q_prod(q, np.append(0, w))[0]
    assert np.allclose(g.q2Pi(q) @ w, rate) and np.allclose(g.w2omega(w) @ q, rate)
    assert np.allclose(g.pi2pc(g.q2Pi(q)), g.q2Pi(g.q2qc(q)[0]))
    assert np.allclose(g.q2R_q(q) @ q, 2 * g.q2R(q)[0])  # Euler: R is homogeneous of degree two


def test_the_rotation_of_a_quaternion_that_is_not_unit_is_scaled():
    q = 1.7 * UNIT[40]
    assert np.allclose(g.q2R(q)[0], 1.7**2 * g.q2R(UNIT[40])[0])


STACKED = (
    "q2R",
    "R2q",
    "q2e",
    "q2v",
    "q2au",
    "q2qc",
    "e2q",
    "e2R",
    "v2q",
    "v2au",
    "unit",
    "hat",
    "q2Q",
    "q2Pi",
    "pi2pc",
)


@pytest.mark.parametrize("name", STACKED)
def test_stacks_of_arguments_give_stacks_of_results(name, rng):
    f = getattr(g, name)
    shape = {"R2q": (3, 3), "pi2pc": (4, 3), "hat": (3,)}.get(name, (4,) if name[0] in "qu" else (3,))
    x = rng.normal(size=(2, 5, *shape))
    if name == "R2q":
        x = g.q2R(g.unit(rng.normal(size=(2, 5, 4)))[0])[0]
    stacked = f(x) if isinstance(f(x), tuple) else (f(x),)
    for i in np.ndindex(2, 5):
        single = f(x[i]) if isinstance(f(x[i]), tuple) else (f(x[i]),)
        for many, one in zip(stacked, single, strict=True):
            assert np.allclose(np.broadcast_to(many, (2, 5, *np.shape(one)))[i], one)


def test_how_small_a_rotation_has_an_axis():
    """Down to 1e-150 rad, where squares are still numbers; below it the axis is [1 0 0], with a zero derivative."""
    a, u, A_v, U_v = g.v2au(np.array([0.0, 1.5e-150, 0.0]))
    assert a == 1.5e-150 and u.tolist() == [0, 1, 0] and A_v.tolist() == [0, 1, 0] and U_v[0, 0] == 1 / a
    a, u, A_v, U_v = g.v2au(np.array([0.0, 0.9e-150, 0.0]))
    assert a == 0.9e-150 and u.tolist() == [1, 0, 0] and not A_v.any() and not U_v.any()


def test_how_near_to_the_gimbal_lock_the_yaw_is_its_own():
    """Farther than 1e-4 rad, roll and yaw are told apart by r11 and r21; nearer, by what is left of R."""
    for away, exact in ((1.5e-4, 1e-11), (0.5e-4, 1e-11), (1e-9, 1e-9), (0.0, 1e-9)):
        for side in (1, -1):
            e = np.array([0.3, side * (np.pi / 2 - away), -2.0])
            R = g.e2R(e)[0]
            assert np.allclose(g.e2R(g.q2e(g.e2q(e)[0])[0])[0], R, atol=exact)
