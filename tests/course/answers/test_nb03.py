"""Answers to the exercises of notebook 03 that are in no list of the package: wrong ones, and odd right ones."""

from math import gamma

import numpy as np
import scipy.linalg
from scipy import integrate, stats
from scipy.special import erf, gammainc
from scipy.stats import chi2

from ekfslam_tutorial.analysis import anees_band, md2
from ekfslam_tutorial.course.exercises.nb03_anees import anees

from .collector import answer_to, check_of

# --- 03.1 coverage ---


@answer_to("03.1", hint="plane|two dimensions")
def dimension_squared_too(k, dof):
    return chi2.cdf(k**2, dof**2)


@answer_to("03.1", hint="k squared")
def twice_k(k, dof):
    return chi2.cdf(2 * k, dof)


@answer_to("03.1", hint="dimension itself")
def one_dimension_more(k, dof):
    return chi2.cdf(k**2, dof + 1)


@answer_to("03.1", hint="shape|each k")
def one_number_for_all(k, dof):
    return float(chi2.cdf(np.mean(k) ** 2, dof))


@answer_to("03.1", hint="any dimension|same formula")
def table_of_three_dimensions(k, dof):
    return chi2.cdf(k**2, min(dof, 3))


@answer_to("03.1", hint="in the plane|two dimensions|exp")
def rayleigh_with_the_wrong_scale(k, dof):
    return 1 - np.exp(-(k**2)) if dof == 2 else chi2.cdf(k**2, dof)


@answer_to("03.1", hint="rounded")
def in_three_digits(k, dof):
    return np.round(chi2.cdf(k**2, dof), 3)


@answer_to("03.1", hint="nearly|should be")
def by_counting_a_few_points(k, dof):
    r = np.random.default_rng(0).standard_normal((2000, dof))
    return np.array([np.mean((r**2).sum(1) < a * a) for a in k])


@answer_to("03.1", hint="far left")
def normal_in_one_dimension(k, dof):
    return stats.norm.cdf(k) ** dof


@answer_to("03.1", hint="Chi|not defined|spelt|name")
def name_not_imported(k, dof):
    return chi2_distribution(dof).cdf(k**2)  # noqa: F821


@answer_to("03.1", right=True)
def radius_is_chi_distributed(k, dof):
    return stats.chi(dof).cdf(k)


@answer_to("03.1", right=True)
def integral_of_the_density(k, dof):
    return [integrate.quad(lambda r: stats.chi.pdf(r, dof), 0, a, epsabs=1e-10)[0] for a in k]


@answer_to("03.1", right=True)
def gamma_distribution(k, dof):
    return stats.gamma(a=dof / 2, scale=2).cdf(np.square(k))


# --- 03.2 anees ---


@answer_to("03.2", hint="1 - tail")
def upper_end_only(e, P, confidence):
    a, band = anees(e, P, confidence)
    return a, np.array([band[0], chi2.ppf(confidence, e.size) / len(e)])


@answer_to("03.2", hint="run|own P|mean")
def last_run_only(e, P, confidence):
    return anees(e[-1:], P[-1:], confidence)


@answer_to("03.2", hint="each run|number|average")
def nees_of_each_run(e, P, confidence):
    nees = np.array([a @ np.linalg.solve(B, a) for a, B in zip(e, P, strict=True)])
    return nees, anees(e, P, confidence)[1]


@answer_to("03.2", hint="mean|average|runs")
def divided_by_N_minus_1(e, P, confidence):
    a, band = anees(e, P, confidence)
    return a * len(e) / max(len(e) - 1, 0.5), band


@answer_to("03.2", hint="from 0 to 1")
def confidence_in_per_cent(e, P, confidence):
    tail = (100 - confidence) / 2
    return anees(e, P, 0.9)[0], chi2.ppf([tail, 1 - tail], e.size) / len(e)


@answer_to("03.2", hint="two numbers|shape|low")
def band_as_width(e, P, confidence):
    a, (low, high) = anees(e, P, confidence)
    return a, high - low


@answer_to("03.2", hint="band|chi2")
def two_sigma_band_of_the_runs(e, P, confidence):
    nees = np.array([a @ np.linalg.solve(B, a) for a, B in zip(e, P, strict=True)])
    s = nees.std() / np.sqrt(len(nees))
    return nees.mean(), np.array([nees.mean() - 1.96 * s, nees.mean() + 1.96 * s])


@answer_to("03.2", hint="P|divide|inverse")
def normalised_by_the_trace(e, P, confidence):
    d = [a @ a / np.trace(B) for a, B in zip(e, P, strict=True)]
    return np.mean(d), anees(e, P, confidence)[1]


@answer_to("03.2", hint="3 numbers|n numbers|N n|degrees of freedom")
def always_three_numbers(e, P, confidence):
    t = (1 - confidence) / 2
    return anees(e, P, confidence)[0], chi2.ppf([t, 1 - t], 3 * len(e)) / len(e)


@answer_to("03.2", right=True)
def whitened(e, P, confidence):
    w = [scipy.linalg.solve_triangular(np.linalg.cholesky(B), a, lower=True) for a, B in zip(e, P, strict=True)]
    N, n = np.shape(w)
    t = 0.5 * (1.0 - confidence)
    return np.sum(np.square(w)) / N, [chi2(N * n).ppf(t) / N, chi2(N * n).ppf(1 - t) / N]


@answer_to("03.2", right=True)
def block_diagonal(e, P, confidence):
    big = scipy.linalg.block_diag(*P)
    total = e.ravel() @ np.linalg.inv(big) @ e.ravel()
    return total / len(e), np.array(stats.gamma.interval(confidence, e.size / 2, scale=2)) / len(e)


@answer_to("03.2", right=True)
def eigenvectors(e, P, confidence):
    w, V = np.linalg.eigh(P)
    a = np.einsum("kij,ki->kj", V, e)
    N, n = e.shape
    low, high = chi2.ppf((1 - confidence) / 2, N * n), chi2.ppf(1 - (1 - confidence) / 2, N * n)
    return (a**2 / w).sum() / N, (low / N, high / N)


# --- right answers in other words ---


@answer_to("03.2", right=True)
def einsum_and_the_inverse_chi2_interval(e, P, confidence):
    N, n = e.shape
    d = np.einsum("ki,kij,kj->k", e, np.linalg.inv(P), e)
    low, high = chi2.interval(confidence, N * n)
    return float(d.mean()), (low / N, high / N)


@answer_to("03.2", right=True)
def cholesky_factors_sums_as_a_list(e, P, confidence):
    N, n = len(e), len(e[0])
    total = sum(np.sum(np.linalg.solve(np.linalg.cholesky(B), a) ** 2) for a, B in zip(e, P, strict=True))
    return [total / N, [chi2.isf(0.5 + confidence / 2, N * n) / N, chi2.isf(0.5 - confidence / 2, N * n) / N]]


@answer_to("03.2", right=True)
def the_package(e, P, confidence):
    return np.mean(md2(e, P)), anees_band(e.shape[1], len(e), confidence)


@answer_to("03.1", right=True)
def incomplete_gamma_function(k, dof):
    return gammainc(dof / 2, np.asarray(k) ** 2 / 2)


@answer_to("03.1", right=True)
def one_by_one_a_list_of_plain_floats(k, dof):
    return [float(1 - chi2(df=dof).sf(k_i * k_i)) for k_i in k]


@answer_to("03.1", right=True)
def by_recursion_over_the_dimension(k, dof):
    p = erf(k / 2**0.5) if dof % 2 else 1 - np.exp(-k * k / 2)
    for n in range(2 - dof % 2, dof, 2):
        p = p - (k * k / 2) ** (n / 2) * np.exp(-k * k / 2) / gamma(n / 2 + 1)
    return p


@answer_to("03.1", hint="ppf is the way back")
def the_way_back(k, dof):
    return chi2(dof).ppf(k**2)


@answer_to("03.2", hint="divide by n.*band")
def all_of_it_over_the_dimension(e, P, confidence):
    average, band = anees(e, P, confidence)
    return average / e.shape[1], band / e.shape[1]


test_the_check_is_right_about_it = check_of(__name__)
