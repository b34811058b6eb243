"""Answers to the exercises of notebook 24 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np

from ekfslam_tutorial.course.exercises.nb24_agree import agreeing
from ekfslam_tutorial.course.exercises.nb24_corner import corner_score
from ekfslam_tutorial.course.exercises.nb24_inside import inside
from ekfslam_tutorial.course.exercises.nb24_ncc import ncc
from ekfslam_tutorial.course.exercises.nb24_patch import patch_of

from .collector import answer_to, check_of

# --- 24.1 a patch ---


@answer_to("24.1", hint="middle|row")
def one_pixel_off(image, y, h):
    return patch_of(image, y + 1.0, h)


@answer_to("24.1", hint="8 bits|float|mean")
def sum_in_eight_bits(image, y, h):
    patch, _, contrast = patch_of(image, y, h)
    return patch, patch.astype(np.uint8).sum(dtype=np.uint8) / patch.size, contrast


@answer_to("24.1", hint="shape|order|patch")
def patch_last(image, y, h):
    patch, mean, contrast = patch_of(image, y, h)
    return mean, contrast, patch


@answer_to("24.1", right=True)
def by_take(image, y, h):
    u, v = np.round(y).astype(int)
    around = np.arange(-h, h + 1)
    patch = image[np.ix_(v + around, u + around)] * 1.0
    return patch, patch.sum() / patch.size, np.sqrt((patch**2).mean() - patch.mean() ** 2)


@answer_to("24.1", right=True)
def by_lists(image, y, h):
    u, v = int(np.rint(y[0])), int(np.rint(y[1]))
    patch = [[float(image[v + j, u + i]) for i in range(-h, h + 1)] for j in range(-h, h + 1)]
    flat = [grey for row in patch for grey in row]
    mean = sum(flat) / len(flat)
    return patch, mean, (sum((grey - mean) ** 2 for grey in flat) / len(flat)) ** 0.5


# --- 24.2 normalised cross-correlation ---


@answer_to("24.2", hint="mean|light")
def cosine_of_the_grey_values(patch, windows):
    a, b = np.ravel(patch).astype(float), windows.reshape(len(windows), -1).astype(float)
    return b @ a / (np.linalg.norm(a) * np.linalg.norm(b, axis=1))


@answer_to("24.2", hint="flat|0 / 0|number")
def by_corrcoef(patch, windows):
    return np.array([np.corrcoef(patch.ravel(), w.ravel())[0, 1] for w in windows])


@answer_to("24.2", hint="shape|window")
def one_number(patch, windows):
    return ncc(patch, windows)[0]


@answer_to("24.2", hint="1|itself|sum|mean")
def divided_by_s(patch, windows):
    return ncc(patch, windows) / len(patch)


@answer_to("24.2", right=True)
def by_standard_scores(patch, windows):
    n = patch.size
    a, b = patch.reshape(-1).astype(float), windows.reshape(-1, n).astype(float)
    s = a.std() * b.std(1)
    covariance = b @ a / n - a.mean() * b.mean(1)
    return np.divide(covariance, s, out=np.zeros(len(b)), where=s > 1e-9)


@answer_to("24.2", right=True)
def window_by_window(patch, windows):
    found = []
    for w in windows:
        a, b = (x.astype(float) - x.mean() for x in (patch, w))
        long = np.linalg.norm(a) * np.linalg.norm(b)
        found.append(float(np.vdot(a, b) / long) if long > 0 else 0.0)
    return found


# --- 24.3 the search ellipse ---


@answer_to("24.3", hint="k\\^2|square|sigma")
def twice_the_sigmas(pixels, e, S, k):
    return inside(pixels, e, S, 2 * k)


@answer_to("24.3", hint="S|ellipse|correlat")
def one_over_the_entries(pixels, e, S, k):
    z = pixels - e
    return np.einsum("ni,ij,nj->n", z, 1 / (S + 1e-12), z) <= k**2


@answer_to("24.3", hint="shape|truth value|each row")
def numbers_of_them(pixels, e, S, k):
    return np.flatnonzero(inside(pixels, e, S, k))


@answer_to("24.3", right=True)
def by_cholesky(pixels, e, S, k):
    w = np.linalg.solve(np.linalg.cholesky(S), np.transpose(pixels - e))
    return np.hypot(*w) <= k


@answer_to("24.3", right=True)
def by_the_axes(pixels, e, S, k):
    D, V = np.linalg.eigh(S)
    along = (pixels - e) @ V / np.sqrt(D)
    return [bool(a @ a <= k * k + 1e-9) for a in along]


# --- 24.4 a good corner ---


@answer_to("24.4", hint="smaller|edge|eigenvalue")
def harris(windows):
    g_v, g_u = np.gradient(windows, axis=(1, 2))
    a, b, c = ((p * q).sum((1, 2)) for p, q in ((g_u, g_u), (g_u, g_v), (g_v, g_v)))
    return a * c - b * b - 0.05 * (a + c) ** 2


@answer_to("24.4", hint="corner|contrast|eigenvalue")
def contrast(windows):
    return windows.std((1, 2))


@answer_to("24.4", hint="shape|each|window")
def of_the_first(windows):
    return corner_score(windows)[:1].repeat(max(len(windows) - 1, 0))


@answer_to("24.4", right=True)
def by_the_formula(windows):
    g_v, g_u = np.gradient(np.asarray(windows, float), axis=(1, 2))
    a, b, c = ((p * q).sum((1, 2)) for p, q in ((g_u, g_u), (g_u, g_v), (g_v, g_v)))
    return ((a + c) / 2 - np.hypot((a - c) / 2, b)).tolist()


@answer_to("24.4", right=True)
def by_singular_values(windows):
    g_v, g_u = np.gradient(windows, axis=(1, 2))
    return [np.linalg.svd(np.column_stack([u.ravel(), v.ravel()]))[1][1] ** 2 for u, v in zip(g_u, g_v, strict=True)]


# --- 24.5 which matches agree ---


@answer_to("24.5", hint="long innovation|camera has moved|all are long|one match explains|left")
def gate_each_alone(z, E, R, limit):
    return np.array([v @ np.linalg.solve(E[i, :, i] + R, v) < limit**2 for i, v in enumerate(z)])


@answer_to("24.5", hint="largest|left|limit")
def near_the_median(z, E, R, limit):
    return np.linalg.norm(z - np.median(z, axis=0), axis=1) < limit


@answer_to("24.5", hint="shape|truth value|each")
def numbers_of_those_that_agree(z, E, R, limit):
    return np.flatnonzero(agreeing(z, E, R, limit))


@answer_to("24.5", right=True)
def all_hypotheses_at_once(z, E, R, limit):
    K = len(z)
    i = np.arange(K)
    w = np.linalg.solve(E[i, :, i] + R, z[:, :, None])[..., 0]
    left = z[None] - np.einsum("jaib,ib->ija", E, w)
    agree = (left**2).sum(-1) < limit**2
    return agree[agree.sum(1).argmax()]


@answer_to("24.5", right=True)
def by_counting(z, E, R, limit):
    sets = []
    for i in range(len(z)):
        gain = np.linalg.inv(E[i, :, i] + R)
        sets.append([float(np.linalg.norm(z[j] - E[j, :, i] @ gain @ z[i])) < limit for j in range(len(z))])
    return max(sets, key=sum)


@answer_to("24.5", hint="rows of E_ji belong to match j")
def the_block_of_i_and_j(z, E, R, limit):
    best = np.zeros(len(z), bool)
    for i in range(len(z)):
        w = np.linalg.solve(E[i, :, i] + R, z[i])
        agree = np.array([np.linalg.norm(z[j] - E[i, :, j] @ w) < limit for j in range(len(z))])
        best = agree if agree.sum() > best.sum() else best
    return best


@answer_to("24.2", hint="length 0")
def one_where_both_are_flat(patch, windows):
    def unit(a):
        a = a - a.mean(axis=(-2, -1), keepdims=True)
        length = np.sqrt((a**2).sum(axis=(-2, -1), keepdims=True))
        return np.where(length > 1e-9, a / np.where(length > 1e-9, length, 1), 1)

    return (unit(patch.astype(float)) * unit(windows.astype(float))).sum(axis=(-2, -1))


test_the_check_is_right_about_it = check_of(__name__)
