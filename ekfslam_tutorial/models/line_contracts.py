"""The contract tests of lines, and of sensors that measure segments of them; `contracts.py` calls them."""

import numpy as np

from ..geometry import Frame3, check_jacobians
from .landmarks.lines import abscissas, ends, offsets
from .observation import observe, retro_project
from .trials import check_complete, check_noise, check_stack, check_three, of_stack, random_frame, written

SEEDS = range(4)
PRIOR = np.array([0.2, 0.15])


def segments(rng, n=20):
    """Random edges in front of a camera, from 4 to 10 m away: ends [p1; p2], shape (n, 6)."""
    return rng.normal(size=(n, 6)) + np.tile([0.0, 0.0, 7.0], 2)


def normals(p):
    """Normals of the planes through the origin in which edges lie."""
    return np.cross(p[..., :3], p[..., 3:])


def compared(sensor, e, y, *E_):
    """Innovation of measurements y, with the derivatives of an expectation e carried on to it."""
    z, Z_y, Z_e = sensor.innovation(y, e)
    return z, *(Z_e @ E for E in E_), Z_y


def check_line_sensor(model):
    """Test a sensor of segments: what it expects, its innovation, the way back, stacks, what it sees.

    Raises
    ------
    AssertionError
        With the first property that does not hold.

    See Also
    --------
    check_sensor : Calls it.
    """
    R = check_noise(model.R)
    for seed in SEEDS:
        p = segments(np.random.default_rng(seed))
        y, seen = model.segments(p)
        assert seen.any(), "visible() refuses every edge in front of the sensor"
        assert not model.segments(-p)[1].any(), "visible() accepts edges behind the sensor"
        p, y = p[seen], y[seen]
        assert y.shape == (len(p), len(R)), f"segments gives shape {y.shape}; it must be ({len(p)}, {len(R)})"
        n = normals(p)
        e, _ = check_stack(model.project, "project", n)
        check_stack(model.innovation, "innovation", y, e)
        assert np.allclose(model.residual(y, e), 0, atol=1e-6), "the ends of a segment are not on its line"
        assert model.visible(e, p).all(), "visible() refuses what segments() sees"
        y = y + np.random.default_rng(seed).normal(size=y.shape)
        check_jacobians(lambda n, y: compared(model, model.project(n)[0], y, model.project(n)[1]), n[0], y[0])
        v, _ = check_stack(model.retro, "retro", y)
        check_jacobians(model.retro, y[0])
        back = model.project(normals(v))[0]
        assert np.allclose(model.residual(y, back), 0, atol=1e-6), "project(retro(y)) does not pass through y"
    check_complete(model, "sensor")


def check_line(lmk):
    """Test a line type: Jacobians of all its maps, round trips, stacks, its ends.

    Raises
    ------
    AssertionError
        With the first property that does not hold; or, if all that is written is well, with what is missing.

    See Also
    --------
    check_landmark : Calls it.
    """
    assert written(lmk, "from_rays"), f"{type(lmk).__name__} has no from_rays: nothing can start it, or be tested"
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        F, v = random_frame(Frame3, rng), segments(rng)
        n = np.broadcast_to(PRIOR, (len(v), 2))
        out = of_stack(lmk.from_rays, "from_rays", v, n)
        check_three(out, "from_rays", "l, L_v, L_n")
        l = out[0]
        assert l.shape == (len(v), lmk.size), f"a landmark has shape {l.shape[1:]}; it must be ({lmk.size},)"
        check_jacobians(lmk.from_rays, v[0], n[0])
        for name in ("to_frame", "from_frame"):
            f = getattr(lmk, name)
            check_jacobians(f, F, l[0])
            check_stack(lambda l, f=f, F=F: f(F, l), name, l)
        t = np.tile([0.5, 2.0], (len(l), 1))
        p, l = lmk.from_frame(F, l)[0], lmk.to_frame(F, lmk.from_frame(F, l)[0])[0]
        assert np.allclose(lmk.normal(l)[0], lmk.normal(out[0])[0]), "to_frame(F, from_frame(F, l)) is not l"
        _check_seen(lmk, p, t)
    check_complete(lmk, "line")


def _check_seen(lmk, l, t):
    """Test the normal and the support of lines, and the ends with the abscissas t on them."""
    n, _ = check_stack(lmk.normal, "normal", l)
    p, _ = ends(lmk, l, t)
    assert np.allclose((n[:, None] * p).sum(-1), 0, atol=1e-6), "normal(l) is not across the points of l"
    check_jacobians(lmk.normal, l[0])
    p0, d, P0_l, D_l = check_stack(lmk.support, "support", l)
    check_jacobians(lambda l: lmk.support(l)[0::2], l[0])
    check_jacobians(lambda l: lmk.support(l)[1::2], l[0])
    eye = p0[:, None] + np.cross(d, [0.3, 0.2, 0.9])[:, None]  # somewhere beside the line
    assert np.allclose(abscissas(lmk, l, eye, p - eye), t, atol=1e-5), "a ray to an end does not meet it"
    assert np.allclose(offsets(lmk, l[0], *p[0])[0], 0, atol=1e-6), "a line is not where its ends are"
    check_jacobians(lambda l: offsets(lmk, l, *(p[0] + 0.01)), l[0], rtol=1e-5)
    if hasattr(lmk, "normalized"):
        check_jacobians(lmk.normalized, l[0])
        assert np.allclose(lmk.normalized(l)[0], l), "a line that is born is not in its normal form"


def check_line_pair(sensor, lmk):
    """Test a sensor of segments together with a line type: both observation models, and the round trip.

    Raises
    ------
    AssertionError
        With the first property that does not hold.

    See Also
    --------
    check_pair : Calls it.
    """
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        Rf, Sf = random_frame(Frame3, rng), random_frame(Frame3, rng)
        y, seen = sensor.segments(segments(rng))
        y = y[seen]
        l, *_ = retro_project(Rf, Sf, sensor, lmk, y, np.broadcast_to(PRIOR, (len(y), 2)))
        e, *_ = observe(Rf, Sf, sensor, lmk, l)
        assert np.allclose(sensor.residual(y, e), 0, atol=1e-5), "observe(retro_project(y)) does not pass through y"
        check_jacobians(lambda R, S, y, n: retro_project(R, S, sensor, lmk, y, n), Rf, Sf, y[0], PRIOR, rtol=1e-5)

        def innovation(R, S, l, y):
            e, *E_ = observe(R, S, sensor, lmk, l)
            return compared(sensor, e, y, *E_)

        check_jacobians(innovation, Rf, Sf, l[0], y[0] + 1.0, rtol=1e-5)
