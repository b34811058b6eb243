"""The two functions of the chi-square distribution against scipy.stats."""

import numpy as np
from scipy.stats import chi2

from ekfslam_tutorial.ekf import chi_square


def test_quantile_and_probability_are_those_of_scipy():
    p, dof = np.array([[1e-6], [0.025], [0.5], [0.99], [1 - 1e-6]]), np.array([1, 2, 3, 6, 40, 1000])
    x = chi_square.quantile(p, dof)
    assert np.allclose(x, chi2.ppf(p, dof), rtol=1e-12) and np.allclose(chi_square.cdf(x, dof), p, rtol=1e-9)
    assert np.allclose(chi_square.cdf(x, dof), chi2.cdf(x, dof), rtol=1e-12)
