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
    "00.1": """
def wrap(angle):
    turns = np.floor((np.asarray(angle) + np.pi) / (2*np.pi))
    return angle - 2*np.pi*turns
""",
    "01.2": """
def move(x, u, dt):
    v, w = u
    c, s = np.cos(x[2]), np.sin(x[2])
    F = np.eye(3)
    F[0, 2], F[1, 2] = -v*dt*s, v*dt*c
    return x + dt * np.array([v*c, v*s, w]), F, dt * np.array([[c, 0], [s, 0], [0, 1]])
""",
    "02.4": """
def add_landmark(x, P, y, x_r, R):
    r, b = y
    a = b + x_r[2]
    l = x_r[:2] + r * np.array([np.cos(a), np.sin(a)])
    L = np.array([[np.cos(a), -r*np.sin(a)], [np.sin(a), r*np.cos(a)]])
    n = len(x)
    return np.append(x, l), np.block([[P, np.zeros((n, 2))], [np.zeros((2, n)), L @ R @ L.T]])
""",
    "03.2": """
def anees(e, P, confidence):
    N, n = e.shape
    total = sum(a @ np.linalg.inv(B) @ a for a, B in zip(e, P))
    alpha = 1 - confidence
    return total / N, np.array([chi2.ppf(alpha/2, N*n), chi2.ppf(1 - alpha/2, N*n)]) / N
""",
    "04.1": """
def inverse_observation(x_r, y):
    C, S = np.cos(x_r[2]), np.sin(x_r[2])
    R, dR = np.array([[C, -S], [S, C]]), np.array([[-S, -C], [C, -S]])
    p = y[0] * np.array([np.cos(y[1]), np.sin(y[1])])
    P_y = np.array([[np.cos(y[1]), -y[0]*np.sin(y[1])], [np.sin(y[1]), y[0]*np.cos(y[1])]])
    L_r = np.column_stack([np.eye(2), dR @ p])
    return x_r[:2] + R @ p, L_r, R @ P_y
""",
    "04.3": """
def moved(P, X_x, X_u, U):
    n = len(P)
    F, G = np.eye(n), np.zeros((n, len(U)))
    F[:3, :3] = X_x
    G[:3] = X_u
    return F @ P @ F.T + G @ U @ G.T
""",
    "05.5": """
def slam_frame(x, P, ids, u, U, seen, ys, R):
    x, P = predict(x, P, u, U)
    known = list(ids)
    for i, y in zip(seen, ys):
        if i in ids:
            k = ids.index(i)
            e, H = observe(x, slice(3 + 2*k, 5 + 2*k))
            x, P = correct(x, P, y, R, e, H)
    for i, y in zip(seen, ys):
        if i not in ids:
            x, P = augment(x, P, y, R)
            known.append(i)
    return x, P, known
""",
    "08.3": """
def joseph(P, K, H, R):
    L = np.eye(len(P)) - K.dot(H)
    return L.dot(P).dot(L.T) + K.dot(R).dot(K.T)
""",
    "09.1": """
def by_time(rows):
    t = rows[:, 0]
    late = sum(1 for a, b in zip(t, t[1:]) if b < a)
    order = np.argsort(t, kind="stable")
    return rows[order], late, np.diff(t[order]).max()
""",
    "09.2": """
def landmarks_seen(rows, table, robots):
    who = {int(code): int(subject) for subject, code in table}
    t, s, m = [], [], []
    for time, code, r, b in rows:
        if int(code) not in who:
            continue
        if who[int(code)] in robots:
            continue
        t.append(time)
        s.append(who[int(code)])
        m.append([r, b])
    return np.array(t), np.array(s, int), np.array(m).reshape(-1, 2)
""",
    "09.3": """
def clock_offset(offsets, z, Z):
    nis = np.einsum("kmi,kmij,kmj->km", z, np.linalg.inv(Z), z)
    mean = nis.sum(axis=1) / nis.shape[1]
    return offsets[mean.argmin()], mean
""",
    "13.2": """
def new_idp(F, P_F, camera, y, R, n, N):
    v, V_y = camera.retro(y)
    l_c, LC_v, LC_n = IdpPnt().from_ray(v, n)
    l, L_F, L_lc = IdpPnt().from_frame(F, l_c)
    A, B = L_lc @ LC_v @ V_y, L_lc @ LC_n
    return l, L_F @ P_F @ L_F.T + A @ R @ A.T + B @ N @ B.T, L_F @ P_F
""",
    "19.1": """
def drive(x, u, dt, car):
    (v, al), (L, H, a, b), (c, s) = u, car, (np.cos(x[2]), np.sin(x[2]))
    t, sec2 = np.tan(al), 1 + np.tan(al)**2
    D = 1 - H*t/L
    vc, vc_u = v/D, np.array([1/D, v*H*sec2/(L*D**2)])
    w, w_u = vc*t/L, vc_u*t/L + np.array([0, vc*sec2/L])
    vx, vy = vc*c - w*(a*s + b*c), vc*s + w*(a*c - b*s)
    X_x = np.array([[1, 0, -dt*vy], [0, 1, dt*vx], [0, 0, 1]])
    X_u = dt * np.array([c*vc_u - (a*s + b*c)*w_u, s*vc_u + (a*c - b*s)*w_u, w_u])
    return x + dt * np.array([vx, vy, w]), X_x, X_u
""",
    "19.3": """
def manage(searched, found, visible, matched, min_search, min_ratio):
    s, f = searched + visible, found + matched
    gone = [i for i in range(len(s)) if visible[i] and s[i] >= min_search and f[i] < min_ratio * s[i]]
    return s, f, gone
""",
    "20.2": """
def guard(predict, x, P, u, U):
    x2, P2 = predict(x, P, u, U)
    def d(at):
        e = at - x2
        e[2] = wrap(e[2])
        return e
    F = numerical_jacobian(lambda a: d(predict(a, P, u, U)[0]), x)
    G = numerical_jacobian(lambda a: d(predict(x, P, a, U)[0]), u)
    return P2 - F @ P @ F.T - G @ U @ G.T
""",
    "21.1": """
def iterated_correct(x, P, y, R, observe, iterations):
    at = x.copy()
    for _ in range(iterations):
        e, H = observe(at)
        z = y - e - H @ (x - at)
        z[1] = wrap(z[1] + (H @ (x - at))[1]) - (H @ (x - at))[1]
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        at = x + K @ z
    J = np.eye(len(x)) - K @ H
    return at, J @ P
""",
    "22.2": """
def line_innovation(y, h):
    a, b, c = h
    n2 = a*a + b*b
    nn = np.sqrt(n2)
    z, Z_y, Z_h = np.zeros(2), np.zeros((2, 4)), np.zeros((2, 3))
    for i in range(2):
        u, v = y[2*i:2*i + 2]
        z[i] = (a*u + b*v + c) / nn
        Z_y[i, 2*i:2*i + 2] = a/nn, b/nn
        Z_h[i] = u/nn - z[i]*a/n2, v/nn - z[i]*b/n2, 1/nn
    return z, Z_y, Z_h
""",
    "22.6": """
def extend(t, l, c, m):
    n, v = l[:3], l[3:]
    d, w = v / np.linalg.norm(v), c - np.cross(v, n) / (v @ v)
    ts = list(t)
    for ray in m:
        g = ray / np.linalg.norm(ray)
        k = d @ g
        ts.append((d @ w - k * (g @ w)) / (1 - k*k))
    return np.array([min(ts), max(ts)])
""",
    "23.6": """
def flight_nees(p, v, P, p_true, v_true, yaw):
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    found = []
    for i in range(1, len(p)):
        e = np.append(p[i] - (R @ (p_true[i] - p_true[0]) + p[0]), v[i] - R @ v_true[i])
        found.append(e @ np.linalg.solve(P[i], e))
    return np.array(found)
""",
    "24.2": """
def ncc(patch, windows):
    a = patch.astype(float) - patch.mean()
    long, out = np.sqrt((a**2).sum()), np.zeros(len(windows))
    for i, w in enumerate(windows):
        b = w.astype(float) - w.mean()
        lb = np.sqrt((b**2).sum())
        if long > 0 and lb > 0:
            out[i] = (a * b).sum() / (long * lb)
    return out
""",
    "24.5": """
def agreeing(z, E, R, limit):
    K = len(z)
    sets = []
    for i in range(K):
        g = np.linalg.inv(E[i, :, i] + R) @ z[i]
        sets.append(np.array([np.hypot(*(z[j] - E[j, :, i] @ g)) < limit for j in range(K)]))
    return sets[int(np.argmax([s.sum() for s in sets]))]
""",
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
    "01.3": """
def innovation(y, e):
    z = np.array(y, float) - e
    z[..., 1] = wrap(z[..., 1])
    return z
""",
    "02.5": """
def map_step(x, P, ids, seen, ys, x_r, R):
    ids = list(ids)
    for id, y in zip(seen, ys):
        if id not in ids:
            x, P = add_landmark(x, P, y, x_r, R)
            ids.append(id)
            continue
        e, H = h(x, ids.index(id), x_r)
        z = y - e
        z[1] = wrap(z[1])
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        x = x + K @ z
        P = (np.eye(len(x)) - K @ H) @ P
    return x, P, ids
""",
    "04.4": """
def effect_on(P, H, R, b):
    Z = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(Z)
    P_new = P - K @ Z @ K.T
    return K[b], P_new[b, b]
""",
    "08.1": """
def observability(H, F):
    T, rows = np.eye(H[0].shape[1]), [H[0]]
    for k, F_k in enumerate(F):
        T = F_k @ T
        rows.append(H[k + 1] @ T)
    O = np.vstack(rows)
    return O, O.shape[1] - np.linalg.matrix_rank(O)
""",
    "10.3": """
def normalize(x, P):
    n = np.linalg.norm(x[3:])
    u = x[3:] / n
    J = np.eye(7)
    J[3:, 3:] = (np.eye(4) - np.outer(u, u)) / n
    return np.hstack([x[:3], u]), J @ P @ J.T
""",
    "10.5": """
def see(Rf, Sf, p):
    pr, PR_r, PR_p = Rf.to_frame(p)
    ps, PS_s, PS_pr = Sf.to_frame(pr)
    PS_r = PS_pr @ PR_r
    return ps, PS_r, PS_s, PS_pr @ PR_p
""",
}

SLIPS = [  # exercise, what is wrong, a pattern that the student must read, the places
    ("00.1", "ceil", r"np.ceil counts one too many", ("np.floor(", "np.ceil(")),
    ("00.1", "no brackets", r"needs brackets", ("/ (2*np.pi)", "/ 2*np.pi")),
    ("01.2", "entries exchanged", r"exchanged\.$", ("-v*dt*s, v*dt*c", "v*dt*c, -v*dt*s")),
    (
        "02.4",
        "not differentiated",
        r"cos becomes -sin",
        ("-r*np.sin(a)], [np.sin(a), r*np.cos(a)", "r*np.cos(a)], [np.sin(a), r*np.sin(a)"),
    ),
    (
        "02.4",
        "theta in l only",
        r"In L_y, too",
        (
            "[[np.cos(a), -r*np.sin(a)], [np.sin(a), r*np.cos(a)]]",
            "[[np.cos(b), -r*np.sin(b)], [np.sin(b), r*np.cos(b)]]",
        ),
    ),
    ("03.2", "N - 1", r"not by N - 1", ("total / N", "total / (N - 1)")),
    ("04.1", "P_y before R", r"R stands on the left", ("R @ P_y", "P_y @ R")),
    ("04.1", "dR transposed", r"is not transposed", ("dR @ p", "dR.T @ p")),
    ("04.1", "R transposed", r"not its transpose", ("x_r[:2] + R @ p", "x_r[:2] + R.T @ p")),
    ("04.1", "sign in P_y", r"-r sin\(beta\)", ("-y[0]*np.sin", "y[0]*np.sin")),
    ("04.1", "R for I", r"the identity", ("[np.eye(2), dR @ p]", "[R, dR @ p]")),
    ("04.3", "noise on a landmark", r"rows 3 and 4", ("    G[:3] = X_u\n", "    G[:3] = X_u\n    G[3:5] = X_u[:2]\n")),
    (
        "05.1",
        "entries exchanged",
        r"are exchanged",
        ("F[0, 2]", "F[-1, -1], F[0, 2]"),
        ("-s*u[0] - c*u[1]", "1, c*u[0] - s*u[1]"),
        ("F[1, 2] = c*u[0] - s*u[1]", "F[1, 2] = -s*u[0] - c*u[1]"),
    ),
    ("05.3", "Z diagonal", r"not only its diagonal", ("Z = H @ P @ H.T + R", "Z = np.diag(np.diag(H @ P @ H.T + R))")),
    ("05.3", "K H", r"K H has no unit", ("K @ Z @ K.T", "K @ H")),
    ("05.5", "first measurement", r"its own measurement", ("correct(x, P, y,", "correct(x, P, ys[0],")),
    ("05.5", "place in ids", r"in `seen`", ("correct(x, P, y,", "correct(x, P, ys[min(k, len(ys) - 1)],")),
    ("05.5", "break", r"`break`", ("R, e, H)\n", "R, e, H)\n            break\n")),
    (
        "05.5",
        "another noise",
        r"U is the noise of the step",
        ("predict(x, P, u, U)", "predict(x, P, u, R[0, 0] * np.eye(3))"),
    ),
    ("07.4", "E of the first", r"Es\[j\]", ("Es[b] + R", "Es[0] + R")),
    ("07.4", "another row", r"Row i of D", ("z = y - es[b]", "z = ys[b % len(ys)] - es[b]")),
    ("08.3", "Z for R", r"only the noise v", ("K.dot(R)", "K.dot(H @ P @ H.T + R)")),
    ("09.1", "next column", r"use a stable sort", ('np.argsort(t, kind="stable")', "np.lexsort((rows[:, 1], t))")),
    (
        "09.2",
        "break",
        r"`continue`, not `break`",
        ("not in who:\n            continue", "not in who:\n            break"),
    ),
    (
        "09.2",
        "by subject",
        r"do not sort them",
        (
            "    return np.array(t)",
            '    o = np.argsort(s, kind="stable")\n'
            "    t, s, m = (np.array(v)[o] for v in (t, s, m))\n"
            "    return np.array(t)",
        ),
    ),
    ("09.3", "first Z", r"takes the first one", ("np.linalg.inv(Z)", "np.linalg.inv(Z[:, :1])")),
    ("09.3", "nearest to one", r"No ideal value", ("mean.argmin()", "abs(mean - 1).argmin()")),
    ("09.3", "m - 1", r"not by m - 1", ("nis.shape[1]\n", "(nis.shape[1] - 1)\n")),
    ("13.2", "R squared", r"do not square it", ("A @ R @ A.T", "A @ R @ R.T @ A.T")),
    (
        "15.1",
        "own blocks",
        r"the covariance between two states",
        (
            "    Z = H",
            "    Q = np.zeros_like(P)\n"
            "    for r in (r for r, _ in blocks if r is not None):\n"
            "        Q[r, r] = P[r, r]\n"
            "    Z = H",
        ),
        ("Z = H @ P", "Z = H @ Q"),
        ("K = P @", "K = Q @"),
    ),
    ("19.1", "sign of b", r"b has the other sign", ("s*vc_u + (a*c - b*s)", "s*vc_u + (a*c + b*s)")),
    ("19.1", "no dt in X_x", r"in the row of y, too", ("dt*vx]", "vx]")),
    ("19.3", "old finds", r"\*new\* number of finds", ("f[i] < min_ratio", "found[i] < min_ratio")),
    (
        "20.2",
        "no noise",
        r"yours calls it with U = 0",
        ("x2, P2 = predict(x, P, u, U)", "x2, P2 = predict(x, P, u, 0 * U)"),
    ),
    ("20.2", "U squared", r"U is a covariance already", ("G @ U @ G.T", "G @ U @ U.T @ G.T")),
    ("21.1", "P twice", r"once\.$", ("return at, J @ P", "return at, J @ J @ P")),
    ("22.2", "c", r"its derivative is 1 / L", ("1/nn\n", "1\n")),
    ("22.2", "divided once", r"divide by L twice", ("z[i]*b/n2", "z[i]*b/nn")),
    ("22.6", "ray of any length", r"divide each ray by its length", ("g = ray / np.linalg.norm(ray)", "g = ray")),
    ("22.6", "second ray", r"use both rays", ("for ray in m:", "for ray in m[1:]:")),
    ("22.6", "k", r"k is squared", ("(1 - k*k)", "(1 - k)")),
    (
        "23.6",
        "moved first",
        r"Turn first",
        ("R @ (p_true[i] - p_true[0]) + p[0]", "R @ (p_true[i] - p_true[0] + p[0])"),
    ),
    ("23.6", "frame before", r"its own frame", ("solve(P[i], e)", "solve(P[max(i - 1, 1)], e)")),
    ("24.2", "one root", r"as that of the patch", ("lb = np.sqrt((b**2).sum())", "lb = (b**2).sum()")),
    ("24.5", "2 R", r"stands in .* once", ("E[i, :, i] + R)", "E[i, :, i] + 2 * R)")),
    ("24.5", "R / 2", r"not a half", ("E[i, :, i] + R)", "E[i, :, i] + R / 2)")),
    ("24.5", "R R", r"do not square it", ("E[i, :, i] + R)", "E[i, :, i] + R @ R)")),
    ("24.5", "a fifth more", r"the whole of R", ("E[i, :, i] + R)", "E[i, :, i] + 1.2 * R)")),
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
        r"\*all\* landmarks",
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
        r"Each instant counts once",
        (
            "a, b = p - p.mean(0), t - t.mean(0)",
            "mp, mt = (np.mean([q.mean(0) for q in of], 0) for of in (paths, truths)); a, b = p - mp, t - mt",
        ),
        ("v = t.mean(0) - Rm @ p.mean(0)", "v = mt - Rm @ mp"),
    ),
    ("18.4", "covariances added", r"What adds up is the information", ("P = np.linalg.inv(W1 + W2)", "P = P1 + P2")),
    (
        "00.1",
        "negative angles",
        r"Angles below -pi stay as they are",
        (
            "return angle - 2*np.pi*turns",
            "return np.where(np.asarray(angle) > np.pi, np.asarray(angle) - 2*np.pi, angle)",
        ),
    ),
    ("02.5", "id - 1", r"ids\.index\(id\), not id - 1", ("ids.index(id)", "(id - 1) % len(ids)")),
    ("02.5", "an index too large", r"a place is no id", ("ids.index(id)", "id")),
    ("02.5", "place in seen", r"not in `seen`", ("ids.index(id)", "seen.index(id)")),
    (
        "04.3",
        "column times X_x",
        r"P_mr becomes P_mr X_x'",
        ("return F @ P @ F.T + G @ U @ G.T", "M = F @ P @ F.T + G @ U @ G.T; M[3:, :3] = P[3:, :3] @ X_x; return M"),
    ),
    (
        "05.1",
        "X_u transposed",
        r"Either the order is wrong, or X_u is the transpose",
        ("[[c, -s, 0], [s, c, 0]", "[[c, s, 0], [-s, c, 0]"),
    ),
    (
        "07.1",
        "index 0",
        r"0 counts as False",
        ("(inside[0] if len(inside) == 1 else None)", "inside[0] if inside == inside[:1] and any(inside) else None"),
    ),
    ("08.1", "H before", r"after F_k comes H_k\+1", ("H[k + 1] @ T", "H[k] @ T")),
    ("10.3", "norm of all", r"norm of the quaternion, x\[3:\], alone", ("np.linalg.norm(x[3:])", "np.linalg.norm(x)")),
]

TWO = [  # exercise, the names of both, the places
    (
        "04.1",
        "rotation transposed + factors of L_y exchanged",
        ("x_r[:2] + R @ p", "x_r[:2] + R.T @ p"),
        ("R @ P_y", "P_y @ R"),
    ),
    (
        "24.5",
        "R forgotten + the last of the largest",
        ("E[i, :, i] + R)", "E[i, :, i])"),
        ("int(np.argmax([s.sum() for s in sets]))", "K - 1 - int(np.argmax([s.sum() for s in sets[::-1]]))"),
    ),
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
    (
        "01.3",
        "expected minus measured + one measurement only",
        ("np.array(y, float) - e", "e - np.array(y, float)"),
        ("z[..., 1] = wrap(z[..., 1])", "z[1] = wrap(z[1])"),
    ),
    ("02.5", "innovation reversed + bearing not wrapped", ("y - e", "e - y"), ("        z[1] = wrap(z[1])\n", "")),
    ("04.4", "sign of the gain + covariance added", ("return K[b]", "return -K[b]"), ("P - K @", "P + K @")),
    (
        "05.3",
        "bearing not wrapped + I - K H",
        ("    z[1] = wrap(z[1])\n", ""),
        ("P - K @ Z @ K.T", "np.eye(len(P)) - K @ H"),
    ),
    (
        "08.2",
        "bearing not wrapped + innovation with the wrong sign",
        ("y - e", "e - y"),
        ("    z[1] = wrap(z[1])\n", ""),
    ),
    (
        "10.5",
        "frames swapped, not their names + PR_r handed on",
        ("Rf.to_frame(p)", "Sf.to_frame(p)"),
        ("Sf.to_frame(pr)", "Rf.to_frame(pr)"),
        ("PS_pr @ PR_r", "PR_r"),
    ),
]


def answer(id, *slips, texts=TEXTS):
    """The answer of a text with some places written otherwise."""
    text = texts[id]
    for old, new in slips:
        assert text.count(old) == 1, f"{id}: {old!r} stands {text.count(old)} times"
        text = text.replace(old, new)
    space = {**SPACE, **registry.get(id).solution.__globals__}
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
    assert verdict.status == "failed" and verdict.misconception == "" and "All these points are seen" in verdict.hint


def test_a_slip_in_numbers_of_its_own_is_a_second_mistake():
    """Beside it no other one may be behind both."""
    slips = ("= -v*dt*s,", "= v*dt*s,"), ("[0, 1]]", "[0, 1 / dt]]")
    verdict = registry.get("01.2").judge(answer("01.2", *slips))
    assert "Two things, in this order. First" in verdict.hint and "minus* the sine" in verdict.hint


def test_both_jacobians_after_the_step_are_one_mistake():
    after = ("    F = np.eye(3)\n", "    F = np.eye(3)\n    c, s = np.cos(x[2] + w*dt), np.sin(x[2] + w*dt)\n")
    pose = ("v*c, v*s, w]), F", "v*np.cos(x[2]), v*np.sin(x[2]), w]), F")
    verdict = registry.get("01.2").judge(answer("01.2", after, pose))
    assert verdict.misconception == "Jacobians after the move" and "in F_x and F_u" in verdict.hint


def test_what_is_filled_entry_by_entry_is_not_explained_by_its_zeros():
    some = registry.get("07.4").slips()
    assert any("(with limit = chi2" in slip.hint for slip in some) and not any("(with D" in slip.hint for slip in some)


def test_names_of_the_solution_are_explained_and_the_names_in_that_too():
    told = [slip.hint for slip in registry.get("05.3").slips()]
    assert any("(with K = np.linalg.solve(Z, PHt.T).T; PHt = P @ H.T; Z = H @ PHt + R)." in hint for hint in told)


def test_of_two_mistakes_that_hide_each_other_both_are_told():
    """08.2: e at x_first, where an observe of the student's own leaves whole turns, and no wrap."""
    bearing = "e[1] = np.arctan2(x_first[4 + 2*i] - x_first[1], x_first[3 + 2*i] - x_first[0]) - x_first[2]"
    slips = ("e, _ = observe(x, i)", f"e = observe(x_first, i)[0]; {bearing}"), ("    z[1] = wrap(z[1])\n", "")
    hint = registry.get("08.2").judge(answer("08.2", *slips)).hint
    assert "wrap the bearing of z" in hint and "e belongs to the present x" in hint
