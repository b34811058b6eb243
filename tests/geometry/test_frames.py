"""Frames of both dimensions: the same laws, the same tests."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from ekfslam_tutorial.geometry import ORIGIN, Frame2, Frame3, check_jacobians, e2q, numerical_jacobian, v2q

HALF_TURNS = np.concatenate([np.zeros((3, 1)), np.eye(3)], 1)


def frames2(rng):
    """Ordinary poses, and headings on and near the seam."""
    headings = [*rng.uniform(-3, 3, 5), 0.0, np.pi, -np.pi, np.pi - 1e-9, 4.0]
    return [Frame2(np.array([*rng.normal(size=2), a])) for a in headings]


def frames3(rng):
    """Ordinary poses, half turns about each axis, and quaternions that are not quite of norm one."""
    qs = [*rng.normal(size=(5, 4)), *HALF_TURNS, np.array([-1.0, 0, 0, 0]), e2q(np.array([0.2, np.pi / 2, -0.4]))[0]]
    frames = [Frame3(np.concatenate([rng.normal(size=3), q])).normalized()[0] for q in qs]
    return frames + [Frame3(np.concatenate([F.t, 1.2 * F.q])) for F in frames[:2]]


def many(cls, seed=3):
    return (frames2 if cls is Frame2 else frames3)(np.random.default_rng(seed))


BOTH = pytest.mark.parametrize("cls", [Frame2, Frame3])
EACH = pytest.mark.parametrize("F", [*many(Frame2), *many(Frame3)], ids=str)


def unit(F):
    """Whether F is a pose: a quaternion that is not of norm one scales as well."""
    return F.dim == 2 or np.isclose(np.linalg.norm(F.q), 1)


@EACH
@pytest.mark.parametrize("w", [1.0, 0.0, 0.3], ids=["point", "direction", "homogeneous"])
def test_jacobians_of_points(F, w, rng):
    p = rng.normal(size=F.dim)
    check_jacobians(lambda F, p: F.to_frame(p, w), F, p)
    check_jacobians(lambda F, p: F.from_frame(p, w), F, p)


@EACH
def test_jacobians_of_frames(F):
    G = many(type(F), seed=4)[1]
    check_jacobians(lambda F, G: F.compose(G), F, G)
    check_jacobians(lambda F, G: F.compose(G), G, F)
    check_jacobians(lambda F: F.inverse(), F)
    if not (F.dim == 2 and abs(abs(F.theta) - np.pi) < 1e-6):  # a difference quotient across the seam is none
        check_jacobians(lambda F: F.normalized(), F)
    if unit(F):
        check_jacobians(lambda F: F.minus(G), F)


@EACH
def test_points_there_and_back(F, rng):
    if unit(F):
        p = rng.normal(size=F.dim)
        assert np.allclose(F.from_frame(F.to_frame(p)[0])[0], p)
        assert np.allclose(F.to_frame(F.from_frame(p)[0])[0], p)


@BOTH
def test_the_laws_of_a_group(cls, rng):
    F, G, H = many(cls)[:3]
    p = rng.normal(size=F.dim)
    FG, FI = F.compose(G)[0], F.inverse()[0]
    assert np.allclose(FG.from_frame(p)[0], F.from_frame(G.from_frame(p)[0])[0])
    assert np.allclose(FI.from_frame(p)[0], F.to_frame(p)[0])
    assert np.allclose(FG.compose(H)[0].x, F.compose(G.compose(H)[0])[0].x)
    origin = F.compose(FI)[0].normalized()[0]
    assert np.allclose(origin.minus(cls(np.eye(7)[3] if cls is Frame3 else np.zeros(3)))[0], 0)


@EACH
def test_normal_form_is_the_same_pose(F, rng):
    N, _ = F.normalized()
    p = rng.normal(size=F.dim)
    if unit(F):
        assert np.allclose(N.from_frame(p)[0], F.from_frame(p)[0])
    if F.dim == 3:
        assert np.isclose(np.linalg.norm(N.q), 1) and N.q @ F.q > 0
    else:
        assert -np.pi < N.theta <= np.pi


def test_normalising_a_quaternion_takes_the_covariance_along_it_away():
    F = many(Frame3)[0]
    N_f = F.normalized()[1]
    assert np.allclose(N_f[3:, 3:] @ F.q, 0) and np.linalg.matrix_rank(N_f) == 6


@BOTH
def test_difference_of_a_pose_from_itself(cls):
    for F in many(cls):
        if unit(F):
            assert np.allclose(F.minus(F)[0], 0, atol=1e-12)


def test_difference_takes_the_short_way_round():
    e, _ = Frame2(np.array([0.0, 0, 3.1])).minus(Frame2(np.array([0.0, 0, -3.1])))
    assert e[2] == pytest.approx(6.2 - 2 * np.pi)
    F = many(Frame3)[0]
    G = Frame3(np.concatenate([F.t, -F.q]))
    assert np.allclose(F.minus(G)[0], 0) and np.allclose(G.minus(F)[0], 0)


def test_difference_of_small_turns_is_the_rotation_vector():
    F = many(Frame3)[0]
    v = np.array([0.01, -0.02, 0.03])
    turned = F.compose(Frame3(np.concatenate([[0.1, 0, 0], [np.cos(np.linalg.norm(v) / 2)], v / 2])))[0].normalized()[0]
    assert np.allclose(turned.minus(F)[0][3:], v, atol=1e-5)  # q is built to second order


def test_covariance_of_the_difference_has_full_rank():
    F, G = many(Frame3)[:2]
    assert np.linalg.matrix_rank(F.minus(G)[1]) == 6


@BOTH
def test_stacks(cls, rng):
    frames = [F for F in many(cls) if unit(F)]
    stack, p = cls(np.stack([F.x for F in frames])), rng.normal(size=(len(frames), frames[0].dim))
    G = frames[1]
    for f in (
        lambda F, p: F.to_frame(p),
        lambda F, p: F.from_frame(p),
        lambda F, p: F.compose(G),
        lambda F, p: F.inverse(),
        lambda F, p: F.normalized(),
        lambda F, p: F.minus(G),
    ):
        for k, many_out in enumerate(f(stack, p)):
            ones = [np.asarray(getattr(f(F, pi)[k], "x", f(F, pi)[k])) for F, pi in zip(frames, p, strict=True)]
            got = np.asarray(getattr(many_out, "x", many_out))
            assert np.allclose(np.broadcast_to(got, np.shape(ones)), ones)


@BOTH
def test_one_frame_many_points(cls, rng):
    F = many(cls)[0]
    p = rng.normal(size=(4, F.dim))
    pf, PF_f, _ = F.to_frame(p)
    assert pf.shape == p.shape and PF_f.shape == (4, F.dim, F.size)
    assert np.allclose(pf[2], F.to_frame(p[2])[0]) and np.allclose(PF_f[2], F.to_frame(p[2])[1])


def test_named_parts():
    F = many(Frame3)[0]
    assert np.array_equal(F.t, F.x[:3]) and np.array_equal(F.q, F.x[3:])
    assert np.allclose(F.Rt, F.R.T) and F.R_q is F.R_o and np.allclose(F.R @ F.Rt, np.eye(3))
    assert many(Frame2)[0].theta == many(Frame2)[0].x[2]


@pytest.mark.parametrize("cls, n", [(Frame2, 4), (Frame2, 0), (Frame3, 6)])
def test_a_wrong_number_of_numbers_is_named(cls, n):
    with pytest.raises(ValueError, match=rf"{cls.__name__} needs {cls.size} numbers .* got shape \({n},\)"):
        cls(np.zeros(n))


def test_a_frame_cannot_change():
    with pytest.raises(FrozenInstanceError):
        Frame2(np.zeros(3)).x = np.ones(3)


def test_equal_frames():
    assert Frame2(np.zeros(3)) == Frame2([0, 0, 0]) and Frame2(np.zeros(3)) != Frame2(np.ones(3))
    assert Frame2(np.zeros(3)) != Frame3(np.zeros(7))


def test_a_heading_at_the_seam_is_plus_pi():
    """Both ends of the circle are one heading, and it has one number; what is inside stays the same frame."""
    assert Frame2([1.0, 2.0, -np.pi]).normalized()[0].theta == np.pi
    assert Frame2([1.0, 2.0, np.pi]).normalized()[0].theta == np.pi
    inside = Frame2([1.0, 2.0, np.nextafter(-np.pi, 0)])
    assert inside.normalized()[0] is inside
    stack = Frame2(np.array([[0.0, 0.0, -np.pi], [0.0, 0.0, 0.5]]))  # one of them is enough
    assert stack.normalized()[0].theta.tolist() == [np.pi, 0.5]
    assert Frame2([0, 0, 0.5 * np.pi]).minus(Frame2([0, 0, -0.5 * np.pi]))[0][2] == np.pi


def test_half_a_turn_is_taken_in_the_sense_of_its_quaternion():
    """Both senses are as short: that of q is taken where its first component is zero, and -q where it is below."""
    o = Frame3(np.eye(7)[3])
    for first, sense in ((0.0, 1.0), (1e-12, 1.0), (-1e-12, -1.0)):
        e, E_f = Frame3([0, 0, 0, first, 0.0, 1.0, 0.0]).minus(o)
        assert np.allclose(e, [0, 0, 0, 0, sense * np.pi, 0], atol=1e-11)
        assert np.isfinite(E_f).all() and E_f[4, 3] == pytest.approx(-2.0)


def test_a_small_step_away_from_the_origin():
    """Sizes; and X_step, the derivative of the frame that a shift and a turn lead to, where there are none."""
    assert [(F.dim, F.size, F.dof) for F in (Frame2, Frame3)] == [(2, 3, 3), (3, 7, 6)]
    assert (
        ORIGIN[2].x.tolist() == [0, 0, 0] and ORIGIN[3].x.tolist() == [0, 0, 0, 1, 0, 0, 0] and list(ORIGIN) == [2, 3]
    )
    assert np.array_equal(Frame2.X_step, np.eye(3))
    step = lambda e: np.concatenate([e[:3], v2q(e[3:])[0]])
    assert np.allclose(Frame3.X_step, numerical_jacobian(step, np.zeros(6)), atol=1e-9)
    for F in (Frame2, Frame3):
        _, E_f = ORIGIN[F.dim].minus(ORIGIN[F.dim])
        assert np.allclose(E_f @ F.X_step, np.eye(F.dof))
