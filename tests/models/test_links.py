"""Whole camera functions that no sensor of the package calls as they stand: others build on them."""

import numpy as np

from ekfslam_tutorial.geometry import check_jacobians
from ekfslam_tutorial.models.sensors.omni_cam import omni_ray
from ekfslam_tutorial.models.sensors.pin_hole import inv_pin_hole, pin_hole

K, D, C = np.array([320.0, 240.0, 300.0, 310.0]), np.array([-0.05, 0.01]), np.array([0.05, -0.003])


def test_the_inverse_pin_hole(rng):
    """Without a lens it is the inverse to rounding; its derivatives are those of differences, with and without."""
    p = rng.uniform([-1, -1, 2], [1, 1, 5], (20, 3))
    u, s = pin_hole(p, K, np.zeros(0))[0], p[:, 2:]
    assert np.allclose(inv_pin_hole(u, s, K, np.zeros(0))[0], p, rtol=1e-12)
    for c in (np.zeros(0), C):
        check_jacobians(inv_pin_hole, u[0], s[0], K, c, rtol=1e-5)
    for d in (np.zeros(0), D):
        check_jacobians(pin_hole, p[0], K, d, rtol=1e-5)


def test_the_ray_of_an_omnidirectional_camera(rng):
    """Its first two numbers are those of the image; the third is a polynomial of their radius, in its middle, too."""
    c = np.array([-0.8, 0.0, 0.4, 0.1])
    u = rng.uniform(-1, 1, (10, 2))
    r = np.hypot(*u.T)
    v = omni_ray(u, c)[0]
    assert np.array_equal(v[:, :2], u) and np.allclose(np.abs(v[:, 2]), np.abs(np.vander(r, 4, increasing=True) @ c))
    check_jacobians(omni_ray, u[0], c, rtol=1e-6)
    middle, V_u, _ = omni_ray(np.zeros(2), c)
    assert np.allclose(np.abs(middle), [0, 0, 0.8]) and np.isfinite(V_u).all()
