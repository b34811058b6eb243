"""Wrong answers in a style of their own: single slips, and two at once.

Each text is a right answer; a slip is one place of it, written otherwise. Nothing is said of two slips but both.
"""

import re

import numpy as np
import pytest
from scipy.stats import chi2

from ekfslam_tutorial.course import registry
from ekfslam_tutorial.course.exercises.nb08_fej import observe
from ekfslam_tutorial.course.exercises.nb12_pin_hole import pin_hole
from ekfslam_tutorial.geometry import Frame2, wrap

pytestmark = pytest.mark.usefixtures("time_to_search")

SPACE = {"np": np, "chi2": chi2, "wrap": wrap, "Frame2": Frame2, "observe": observe, "pin_hole": pin_hole}

TEXTS = {
    "02.2": """
def h(x, i, x_r):
    dx, dy = x[2*i] - x_r[0], x[2*i + 1] - x_r[1]
    rr = dx*dx + dy*dy
    rng = np.sqrt(rr)
    brg = np.arctan2(dy, dx) - x_r[2]
    brg = (brg + np.pi) % (2*np.pi) - np.pi
    J = np.zeros((2, len(x)))
    J[0, 2*i:2*i + 2] = dx/rng, dy/rng
    J[1, 2*i:2*i + 2] = -dy/rr, dx/rr
    return np.array([rng, brg]), J
""",
    "05.1": """
def predict(x, P, u, U):
    n = len(x)
    s, c = np.sin(x[2]), np.cos(x[2])
    y = x.copy()
    y[:3] = y[:3] + [c*u[0] - s*u[1], s*u[0] + c*u[1], u[2]]
    F = np.eye(n)
    F[0, 2] = -s*u[0] - c*u[1]
    F[1, 2] = c*u[0] - s*u[1]
    G = np.zeros((n, 3))
    G[:3] = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    return y, F @ P @ F.T + G @ U @ G.T
""",
    "05.3": """
def correct(x, P, y, R, e, H):
    z = y - e
    z[1] = wrap(z[1])
    Z = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(Z)
    x_new = x + K @ z
    P_new = P - K @ Z @ K.T
    return x_new, P_new
""",
    "05.4": """
def augment(x, P, y, R):
    th, r = x[2] + y[1], y[0]
    c, s = np.cos(th), np.sin(th)
    l = x[:2] + r * np.array([c, s])
    G = np.array([[1, 0, -r*s], [0, 1, r*c]])
    L = np.array([[c, -r*s], [s, r*c]])
    C = G @ P[:3]
    N = G @ P[:3, :3] @ G.T + L @ R @ L.T
    return np.append(x, l), np.vstack([np.hstack([P, C.T]), np.hstack([C, N])])
""",
    "06.2": """
def close_chain(q, R, z):
    n = len(q)
    s = np.cumsum(q)
    P = np.array([[s[min(i, k)] for k in range(n)] for i in range(n)])
    K = P[:, n - 1] / (P[n - 1, n - 1] + R)
    return K * z, P - np.outer(K, P[n - 1])
""",
    "06.4": """
def floor_of(P_0, x_0, l):
    d = l - x_0[:2]
    J = np.array([[1, 0, -d[1]], [0, 1, d[0]]])
    return J @ P_0 @ J.T
""",
    "07.1": """
def choose(zs, Zs, confidence):
    d2 = np.array([z @ np.linalg.inv(Z) @ z for z, Z in zip(zs, Zs)])
    limit = chi2.ppf(confidence, zs.shape[1])
    inside = [i for i, d in enumerate(d2) if d <= limit]
    return (inside[0] if len(inside) == 1 else None), d2
""",
    "07.2": """
def mutual_nearest(D, limit):
    k, n = D.shape
    j = np.full(k, -1)
    if k == 0 or n == 0:
        return j
    best_l = D.argmin(axis=1)
    best_y = D.argmin(axis=0)
    for i in range(k):
        if best_y[best_l[i]] == i and D[i, best_l[i]] <= limit:
            j[i] = best_l[i]
    return j
""",
    "07.4": """
def new_ones(ys, es, Es, R, confidence):
    D = np.zeros((len(ys), len(es)))
    for a, y in enumerate(ys):
        for b in range(len(es)):
            z = y - es[b]
            z[1] = wrap(z[1])
            D[a, b] = z @ np.linalg.solve(Es[b] + R, z)
    limit = chi2.ppf(confidence, 2)
    return [a for a in range(len(ys)) if (D[a] > limit).all()], D
""",
    "08.2": """
def correct_fej(x, P, y, i, x_first, R):
    e, _ = observe(x, i)
    _, H = observe(x_first, i)
    z = y - e
    z[1] = wrap(z[1])
    Z = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(Z)
    return x + K @ z, P - K @ Z @ K.T
""",
    "12.1": """
def distort(up, d):
    r2 = up @ up
    n = len(d)
    powers = np.array([r2 ** (i + 1) for i in range(n)])
    f = 1 + d @ powers
    df = sum(2 * (i + 1) * d[i] * r2 ** i for i in range(n))
    return f * up, f * np.eye(2) + df * np.outer(up, up), np.outer(up, powers)
""",
    "12.3": """
def visible(p, u, size, fold):
    ahead = p[:, 2] > 0
    inside = (u[:, 0] >= 0) & (u[:, 1] >= 0) & (u[:, 0] <= size[0]) & (u[:, 1] <= size[1])
    r = np.sqrt(p[:, 0]**2 + p[:, 1]**2) / abs(p[:, 2])
    return ahead & inside & (r < fold)
""",
    "12.4": """
def proj_euc_pnt(Rf, Sf, k, d, l):
    lr, LR_r, LR_l = Rf.to_frame(l)
    ls, LS_s, LS_lr = Sf.to_frame(lr)
    u, U_p, U_k, U_d = pin_hole(ls, k, d)
    return u, U_p @ LS_lr @ LR_r, U_p @ LS_s, U_k, U_d, U_p @ LS_lr @ LR_l
""",
    "15.1": """
def correct_blocks(x, P, blocks, z, R):
    H = np.zeros((len(z), len(x)))
    for r, E in blocks:
        if r is not None:
            H[:, r] += E
    Z = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(Z)
    return x + K @ z, P - K @ Z @ K.T
""",
    "15.3": """
def map_in_map(F1, F2, y):
    r, b12, b21 = y
    p = np.array([r * np.cos(b12), r * np.sin(b12)])
    G = Frame2(np.array([p[0], p[1], b12 + np.pi - b21]))
    return F1.compose(G)[0].compose(F2.inverse()[0])[0].x
""",
    "18.1": """
def meet(a, b):
    dx, dy = b[0] - a[0], b[1] - a[1]
    q = dx**2 + dy**2
    r = np.sqrt(q)
    e = np.array([r, wrap(np.arctan2(dy, dx) - a[2])])
    E_b = np.array([[dx/r, dy/r, 0], [-dy/q, dx/q, 0]])
    E_a = -E_b
    E_a[1, 2] = -1
    return e, E_a, E_b
""",
    "18.3": """
def align_all(paths, truths):
    p, t = np.vstack(paths), np.vstack(truths)
    a, b = p - p.mean(0), t - t.mean(0)
    th = np.arctan2((a[:, 0]*b[:, 1] - a[:, 1]*b[:, 0]).sum(), (a*b).sum())
    Rm = np.array([[np.cos(th), -np.sin(th)], [np.sin(th), np.cos(th)]])
    v = t.mean(0) - Rm @ p.mean(0)
    ates = [np.sqrt(((q @ Rm.T + v - g)**2).sum(1).mean()) for q, g in zip(paths, truths)]
    return np.array([v[0], v[1], th]), np.array(ates)
""",
    "18.4": """
def fuse(l1, P1, l2, P2):
    W1, W2 = np.linalg.inv(P1), np.linalg.inv(P2)
    P = np.linalg.inv(W1 + W2)
    return P @ (W1 @ l1 + W2 @ l2), P
""",
}

SLIPS = [  # exercise, what is wrong, a pattern that the student must read, the places
    (
        "05.1",
        "X_u after the pose has changed",
        r"X_u is taken at the pose",
        ("G = np.zeros", "s, c = np.sin(y[2]), np.cos(y[2]); G = np.zeros"),
    ),
    ("05.4", "heading subtracted", r"theta \+ beta", ("th, r = x[2] + y[1], y[0]", "th, r = y[1] - x[2], y[0]")),
    ("06.2", "loss without Z", r"yours has R alone", ("P - np.outer(K, P[n - 1])", "P - np.outer(K, K) * R")),
    (
        "06.4",
        "turned into degrees",
        r"no conversion",
        ("-d[1]], [0, 1, d[0]]", "-np.radians(d[1])], [0, 1, np.radians(d[0])]"),
    ),
    (
        "07.2",
        "furthest measurement of a landmark",
        r"\*nearest\* measurement",
        ("D.argmin(axis=0)", "D.argmax(axis=0)"),
    ),
    (
        "07.4",
        "far from the first landmark",
        r"\*every\* landmark",
        ("(D[a] > limit).all()", "(D[a, 0] > limit if len(es) else True)"),
    ),
    ("08.2", "R twice", r"counts once", ("H @ P @ H.T + R", "H @ P @ H.T + 2 * R")),
    ("12.1", "r for its square", r"even|were the root of `up @ up`", ("r2 = up @ up", "r2 = np.sqrt(up @ up)")),
    (
        "12.3",
        "one of two borders",
        r"four borders",
        ("(u[:, 0] <= size[0]) & (u[:, 1] <= size[1])", "((u[:, 0] <= size[0]) | (u[:, 1] <= size[1]))"),
    ),
    (
        "12.4",
        "into the camera's frame first",
        r"robot's frame first|the frame of the robot, then of the camera",
        ("lr, LR_r, LR_l = Rf.to_frame(l)", "lr, LR_r, LR_l = Sf.to_frame(l)"),
        ("ls, LS_s, LS_lr = Sf.to_frame(lr)", "ls, LS_s, LS_lr = Rf.to_frame(lr)"),
    ),
    (
        "15.1",
        "a known state in H",
        r"skip it",
        (
            "        if r is not None:\n            H[:, r] += E",
            "        H[:, r if r is not None else slice(0, E.shape[1])] += E",
        ),
    ),
    ("15.3", "robot 2 does not look back", r"turned by pi", ("b12 + np.pi - b21", "b12 - b21")),
    ("18.1", "heading of the other", r"heading of a", ("- a[2])", "- b[2])")),
    (
        "18.3",
        "mean of the means",
        r"each instant counting once",
        (
            "a, b = p - p.mean(0), t - t.mean(0)",
            "mp, mt = (np.mean([q.mean(0) for q in of], 0) for of in (paths, truths)); a, b = p - mp, t - mt",
        ),
        ("v = t.mean(0) - Rm @ p.mean(0)", "v = mt - Rm @ mp"),
    ),
    ("18.4", "covariances added", r"What adds up is the information", ("P = np.linalg.inv(W1 + W2)", "P = P1 + P2")),
]

TWO = [  # exercise, the names of both, the places
    ("02.2", "heading added + sign of the bearing row", ("- x_r[2]", "+ x_r[2]"), ("-dy/rr, dx/rr", "dy/rr, -dx/rr")),
    ("05.1", "step not turned + no noise", ("[c*u[0] - s*u[1], s*u[0] + c*u[1], u[2]]", "u"), (" + G @ U @ G.T", "")),
    ("05.3", "Z without R + bearing not wrapped", ("    z[1] = wrap(z[1])\n", ""), ("H @ P @ H.T + R", "H @ P @ H.T")),
    (
        "05.4",
        "noise not in metres + zero cross-covariance",
        ("C = G @ P[:3]", "C = 0 * G @ P[:3]"),
        ("L @ R @ L.T", "R"),
    ),
    (
        "06.2",
        "R squared + sign of dx",
        ("P[n - 1, n - 1] + R)", "P[n - 1, n - 1] + R**2)"),
        ("return K * z", "return -K * z"),
    ),
    (
        "07.1",
        "diagonal of Z + nearest of several",
        ("inside[0] if len(inside) == 1 else None", "int(np.argmin(d2)) if inside else None"),
        ("np.linalg.inv(Z)", "np.linalg.inv(np.diag(np.diag(Z)))"),
    ),
    ("07.4", "R forgotten + bearing not wrapped", ("            z[1] = wrap(z[1])\n", ""), ("Es[b] + R", "Es[b]")),
    (
        "08.2",
        "bearing not wrapped + ordinary EKF",
        ("observe(x_first, i)", "observe(x, i)"),
        ("    z[1] = wrap(z[1])\n", ""),
    ),
    ("12.3", "x ahead + the fold itself", ("p[:, 2] > 0", "p[:, 0] > 0"), ("(r < fold)", "(r <= fold)")),
    ("15.3", "half a turn forgotten + F2 not inverted", ("b12 + np.pi - b21", "b12 - b21"), ("F2.inverse()[0]", "F2")),
    (
        "18.1",
        "heading of the other robot + heading of a forgotten",
        ("- a[2])", "- b[2])"),
        ("    E_a[1, 2] = -1\n", ""),
    ),
    (
        "18.4",
        "plain mean, fused covariance + covariances added",
        ("np.linalg.inv(W1 + W2)", "P1 + P2"),
        ("P @ (W1 @ l1 + W2 @ l2)", "(l1 + l2) / 2"),
    ),
]


def answer(id, *slips):
    """The answer of a text with some places written otherwise."""
    text = TEXTS[id]
    for old, new in slips:
        assert text.count(old) == 1, f"{id}: {old!r} stands {text.count(old)} times"
        text = text.replace(old, new)
    space = dict(SPACE)
    exec(text, space)
    return space[re.search(r"def (\w+)", text)[1]]


@pytest.mark.parametrize("id", TEXTS)
def test_the_text_is_a_right_answer(id):
    assert registry.get(id).judge(answer(id)).passed


@pytest.mark.parametrize(
    ("id", "name", "pattern", "slips"), [(i, n, p, s) for i, n, p, *s in SLIPS], ids=lambda v: str(v)[:40]
)
def test_a_slip_is_told(id, name, pattern, slips):
    verdict = registry.get(id).judge(answer(id, *slips))
    assert verdict.status == "failed" and re.search(pattern, " ".join(verdict.hint.split())), verdict


@pytest.mark.parametrize(("id", "names", "slips"), [(i, n, s) for i, n, *s in TWO], ids=lambda v: str(v)[:40])
def test_two_slips_are_told_both(id, names, slips):
    verdict = registry.get(id).judge(answer(id, *slips))
    assert verdict.status == "failed" and verdict.misconception == names and "Two things, in this order" in verdict.hint


def test_an_answer_that_is_all_one_names_none():
    """With both slips nothing is ever seen: so it is with many others, and which they are is a guess."""
    verdict = registry.get("12.3").judge(answer("12.3", ("p[:, 2] > 0", "p[:, 2] < 0"), ("(r < fold)", "(r > fold)")))
    assert verdict.status == "failed" and verdict.misconception == "" and "must be seen" in verdict.hint
