"""More answers in a style of their own to notebooks 14 to 24: single slips, and two at once. See `test_walked`."""

import re

import pytest

from ekfslam_tutorial.course import expect, registry

from .test_walked import TEXTS as BEFORE
from .test_walked import answer

pytestmark = pytest.mark.usefixtures("time_to_search")

TEXTS = {id: BEFORE[id] for id in ("12.4", "15.1", "18.1", "20.2", "22.6", "24.5")} | {
    "14.1": """
def find_range(used, k):
    n = len(used)
    for s in range(0, n - k + 1):
        if not any(used[s:s+k]):
            return np.array([s, s + k])
    last = max([i for i in range(n) if used[i]], default=-1)
    s = last + 1
    return np.array([s, s + k])
""",
    "14.2": """
def known_then_new(ids, known, n_inits):
    ids = np.asarray(ids)
    k = np.isin(ids, known)
    new = np.flatnonzero(~k & (ids >= 0))[:n_inits]
    return np.flatnonzero(k), new[ids[new] >= 0]
""",
    "15.2": """
def covariance_intersection(xa, Pa, xb, Pb):
    A, B = np.linalg.inv(Pa), np.linalg.inv(Pb)
    ws = np.linspace(0, 1, 1001)
    w = min(ws, key=lambda w: np.trace(np.linalg.inv(w * A + (1 - w) * B)))
    P = np.linalg.inv(w * A + (1 - w) * B)
    return P @ (w * A @ xa + (1 - w) * B @ xb), P
""",
    "17.2": """
def in_band(nees, dof):
    n = nees.shape[0]
    lo, hi = chi2.ppf(0.025, n*dof)/n, chi2.ppf(0.975, n*dof)/n
    m = nees.mean(0)
    return (lo <= m) & (m <= hi)
""",
    "19.1": """
def drive(x, u, dt, car):
    L, H, a, b = car
    v, al = u
    T = np.tan(al); D_ = 1 - H*T/L
    vc = v/D_; w = vc*T/L
    s, c = np.sin(x[2]), np.cos(x[2])
    arm = np.array([-a*s - b*c, a*c - b*s])
    vel = np.array([vc*c + w*arm[0], vc*s + w*arm[1], w])
    X = np.eye(3); X[:2, 2] = dt*np.array([-vel[1], vel[0]])
    sec2 = 1/np.cos(al)**2
    vc_a = v*H/L*sec2/D_**2
    w_a = (vc_a*T + vc*sec2)/L
    col = np.array([c + T/L*arm[0], s + T/L*arm[1], T/L])/D_
    return x + dt*vel, X, dt*np.column_stack([col, [vc_a*c + w_a*arm[0], vc_a*s + w_a*arm[1], w_a]])
""",
    "19.2": """
def sort_scan(D, gate, new_gate):
    k, n = D.shape
    j = np.full(k, -2)
    for i in range(k):
        if n == 0 or D[i].min() > new_gate: j[i] = -1
    for t in range(n):
        if k == 0: break
        i = D[:, t].argmin()
        if D[i, t] <= gate and D[i].argmin() == t: j[i] = t
    return j
""",
    "19.4": """
def gps_error(t, path, fixes, share):
    g = fixes[(fixes[:, 0] >= t[0]) & (fixes[:, 0] <= t[-1])]
    at = np.column_stack([np.interp(g[:, 0], t, path[:, i]) for i in (0, 1)])
    d = np.linalg.norm(at - g[:, 1:], axis=1)
    return d, np.sqrt(np.mean(np.sort(d)[:int(share * len(d))]**2))
""",
    "22.1": """
def image_line(F, l, k):
    u0, v0, au, av = k
    KL = np.array([[av, 0, 0], [0, au, 0], [-av*u0, -au*v0, au*av]])
    Rt = F.R.T
    M = np.hstack([Rt, -Rt @ hat(F.t)])
    return KL @ M @ l, KL @ M
""",
    "22.3": """
def new_line(camera, y, b):
    m, M_y = camera.retro(y)
    n, N_c = unit(np.cross(m[:3], m[3:]))
    e1, e2, A, B = plane_base(n)
    N_y = N_c @ np.c_[-hat(m[3:]), hat(m[:3])] @ M_y
    L_b = np.zeros((6, 2)); L_b[3:] = np.c_[e1, e2]
    return np.r_[n, b[0]*e1 + b[1]*e2], np.r_[N_y, (b[0]*A + b[1]*B) @ N_y], L_b
""",
    "22.5": """
def line_nees(l, P, truth):
    A = np.vstack([truth, np.roll(truth, 3)])
    B = np.linalg.svd(A)[2][2:]
    e = B @ l
    q = e @ np.linalg.pinv(B @ P @ B.T) @ e
    return abs(q)
""",
    "23.2": """
def sheet_noise(arw, density, gyro_walk, acc_walk, dt):
    a = np.radians(arw)/60
    b = density*1e-6*9.80665
    p = 2
    return np.diag([a**2/dt]*3 + [b**2/dt]*3 + [gyro_walk**p*dt]*3 + [acc_walk**p*dt]*3)
""",
    "23.3": """
def drift(t, b_w, b_a, n_w, n_a):
    from math import factorial
    const = lambda c, k: c * t**k / factorial(k)
    white = lambda n, k: n * t**(k - 0.5) / (factorial(k - 1) * np.sqrt(2*k - 1))
    return np.array([const(9.81*b_w, 3), const(b_a, 2), white(9.81*n_w, 3), white(n_a, 2)])
""",
    "23.4": """
def from_rest(w, a, acc_bias_std):
    f = a.mean(0); f = f/np.linalg.norm(f)
    q = np.array([1 + f[2], f[1], -f[0], 0.0])
    if 1 + f[2] < 1e-9: q = np.array([0, 0.6, 0.8, 0])
    return q/np.linalg.norm(q), w.mean(0), acc_bias_std/9.81
""",
    "23.5": """
def move_frame(x, P, move, us, U, dt):
    x, P = np.array(x), np.array(P)
    r, m = slice(0, 16), slice(16, None)
    first = x[r].copy()
    for u in us:
        new, A, B = move(x[r], u, dt)
        P[r, r] = A @ P[r, r] @ A.T + B @ U @ B.T
        P[r, m] = A @ P[r, m]
        P[m, r] = P[r, m].T
        x[r] = new
    return x, P
""",
}

SLIPS = [  # exercise, what is wrong, a pattern that the student must read, the places
    (
        "12.4",
        "frames in the wrong order",
        r"robot first, Rf",
        ("    lr, LR_r", "    Rf, Sf = Sf, Rf\n    lr, LR_r"),
        ("U_p @ LS_lr @ LR_r, U_p @ LS_s", "U_p @ LS_s, U_p @ LS_lr @ LR_r"),
    ),
    ("14.2", "no limit", r"is a limit, too", ("[:n_inits]", "[:n_inits or None]")),
    (
        "22.3",
        "n of any length",
        r"length one here",
        ("np.r_[n, b", "np.r_[np.cross(m[:3], m[3:]), b"),
        ("np.r_[N_y,", "np.r_[np.c_[-hat(m[3:]), hat(m[:3])] @ M_y,"),
    ),
    ("14.1", "multiples of k", r"multiples of k", ("range(0, n - k + 1)", "range(0, n - k + 1, k)")),
    ("14.1", "not at 0", r"begins at number 0", ("range(0,", "range(1,")),
    ("14.1", "one further", r"right \*behind\* the last", ("last + 1\n", "last + 2\n")),
    ("14.2", "nobody's counted", r"does not count against n_inits", (" & (ids >= 0))", ")")),
    (
        "15.1",
        "gain by own block",
        r"not its own block",
        (
            "    K = P @ H.T",
            "    G = np.zeros((len(x), len(z)))\n    for r, E in blocks:\n        G[r] = P[r, r] @ E.T\n    K = G",
        ),
    ),
    ("15.2", "weights of x", r"w goes with a", ("w * A @ xa + (1 - w) * B", "(1 - w) * A @ xa + w * B")),
    ("17.2", "mean of all", r"its own mean", ("nees.mean(0)", "np.full(nees.shape[1], nees.mean())")),
    ("19.1", "divided by v", r"must not be divided by v|that is 0 / 0", ("col = np", "col = vel / v; np")),
    ("19.2", "column alone", r"the column \*and\* in the row", (" and D[i].argmin() == t", "")),
    ("19.4", "rounded", r"drops the decimals", ("int(share", "round(share")),
    ("20.2", "new P", r"the P before the step", ("F @ P @ F.T", "F @ P2 @ F.T")),
    ("22.1", "t x v not turned", r"R' turns both terms", ("-Rt @ hat", "-hat")),
    ("22.3", "times b", r"without b", ("np.c_[e1, e2]", "np.c_[b[0] * e1, b[1] * e2]")),
    ("22.5", "inverse before B", r"then its inverse", ("np.linalg.pinv(B @ P @ B.T)", "B @ np.linalg.pinv(P) @ B.T")),
    ("22.5", "first rows", r"from 2 on", ("[2][2:]", "[2][:4]")),
    ("23.3", "k = 3", r"two integrals only", ("white(n_a, 2)", "white(n_a, 3)")),
    ("23.4", "upside down", r"half a turn", ("< 1e-9", "< -1")),
    ("23.4", "measured gravity", r"Gravity is known", ("acc_bias_std/9.81", "acc_bias_std/np.linalg.norm(a.mean(0))")),
    (
        "23.5",
        "at the start",
        r"start of the frame",
        ("move(x[r], u, dt)", "(move(x[r], u, dt)[0], *move(first, u, dt)[1:])"),
    ),
    ("24.5", "gain of j", r"not \(E_jj \+ R\)", ("@ g)) <", "@ np.linalg.solve(E[j, :, j] + R, z[i]))) <")),
    ("24.5", "without i", r"belongs to its own set", ("< limit for j", "< limit and j != i for j")),
]

TWO = [  # exercise, a pattern of the names of both, the places
    (
        "18.1",
        "bearing row of E_a exchanged + range row with the wrong sign",
        ("[[dx/r, dy/r, 0],", "[[-dx/r, -dy/r, 0],"),
        ("E_a[1, 2] = -1", "E_a[1] = E_a[1, 1], E_a[1, 0], -1"),
    ),
    ("22.1", "R for R' + added in both", ("Rt = F.R.T", "Rt = F.R"), ("-Rt @ hat", "Rt @ hat")),
    ("14.1", "one behind the end + never at number 0", ("range(0,", "range(1,"), ("last + 1\n", "last + 2\n")),
    (
        "22.5",
        "rows from 2 on + (root taken|slip: Yours is the root.*)",
        ("[2][2:]", "[2][:4]"),
        ("abs(q)", "np.sqrt(abs(q))"),
    ),
    ("23.2", "micro forgotten + walks not squared", ("density*1e-6", "density"), ("p = 2", "p = 1")),
    (
        "23.5",
        "only one side of the correlations + U shared by the controls",
        ("        P[m, r] = P[r, m].T\n", ""),
        ("B @ U @", "B @ (U / len(us)) @"),
    ),
    (
        "24.5",
        "votes of the others + length squared",
        ("[s.sum() for s in sets]", "np.sum(sets, axis=0)"),
        ("@ g)) < limit", "@ g)) ** 2 < limit"),
    ),
]


@pytest.mark.parametrize("id", sorted(set(TEXTS) - set(BEFORE)))
def test_the_text_is_a_right_answer(id):
    assert registry.get(id).judge(answer(id, texts=TEXTS)).passed


@pytest.mark.parametrize(
    ("id", "name", "pattern", "slips"), [(i, n, p, s) for i, n, p, *s in SLIPS], ids=lambda v: str(v)[:40]
)
def test_a_slip_is_told(id, name, pattern, slips):
    verdict = registry.get(id).judge(answer(id, *slips, texts=TEXTS))
    assert verdict.status == "failed" and re.search(pattern, verdict.hint), verdict


@pytest.mark.parametrize(("id", "names", "slips"), [(i, n, s) for i, n, *s in TWO], ids=lambda v: str(v)[:40])
def test_two_slips_are_told_both(id, names, slips):
    verdict = registry.get(id).judge(answer(id, *slips, texts=TEXTS))
    assert verdict.status == "failed" and re.fullmatch(names.replace("+", "\\+"), verdict.misconception), verdict


def test_a_result_of_floats_has_lost_no_decimals():
    """The old part of the line is whole by chance: t = [-1., 1.]."""
    in_order = answer("22.6", ("[min(ts), max(ts)]", "[min(t[0], ts[2]), max(t[1], ts[3])]"))
    verdict = registry.get("22.6").judge(in_order)
    assert "t is [-1.,  1.]" in verdict.message and "decimals" not in verdict.message and "any order" in verdict.hint


@pytest.mark.parametrize("got", [3.8e6, 1.0])
def test_a_small_number_beside_a_large_one_is_not_shown_as_zero(got):
    with pytest.raises(expect.Failed, match=r"it should be \[3\.8e-06, 0\]\."):
        expect.close([got, 0.0], [3.8e-6, 0.0], "U")
    with pytest.raises(expect.Failed, match=r"it should be \[0\.5, +0\.00000[0-9]+ *\]|it should be \[0\.5, 2e-06\]"):
        expect.close([0.5, got], [0.5, 2e-6], "U")
