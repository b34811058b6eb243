"""Wrong answers to the exercises of notebooks 05 to 21 that are in no list of the package, as edits of the solutions.

Each block is the exercise and what is wrong, a pattern that the student must read, and the edits.
"""

from ekfslam_tutorial.course import edits, registry

from .collector import answer_to, check_of

WRONG = r"""
05.2 bearing by arcsine: quadrant|arctan2|behind
    wrap(np.arctan2(dy, dx) - x[2]) -> np.arcsin(np.clip(dy / r, -1, 1)) - x[2]
05.3 R counted twice: H P H' \+ R|R
    H @ PHt + R -> H @ PHt + 2 * R
05.4 covariance with the robot only in y: P_lx|pose|independent causes
    P_lx = L_r @ P[:3] -> P_lx = L_r @ P[:3] * [[0.0], [1.0]]
09.1 sorted by the last column: column 0|whole
    np.argsort(rows[:, 0], kind="stable") -> np.argsort(rows[:, -1], kind="stable")
09.1 late as a share: back|file|late
    int(np.sum(np.diff(rows[:, 0]) < 0)) -> float(np.mean(np.diff(rows[:, 0]) < 0))
09.1 any late: back|file|late
    int(np.sum(np.diff(rows[:, 0]) < 0)) -> bool(np.any(np.diff(rows[:, 0]) < 0))
09.1 shortest gap: longest|sort
    np.max(np.diff -> np.min(np.diff
09.2 unknown barcodes as subject 0: not in the table|[Dd]rop|misread
    (barcode, -1) -> (barcode, 0)
    (subjects != -1) & ~np -> ~np
09.2 only one robot dropped: robots|rows
    np.isin(subjects, robots) -> np.isin(subjects, robots[:1])
09.2 range twice: Columns 2 and 3
    rows[keep, 2:] -> rows[keep][:, [2, 2]]
09.3 first component only: z' inv|Z
    np.einsum("kmi,kmi->km", z, np.linalg.solve(Z, z[..., None])[..., 0]) -> z[..., 0] ** 2 / Z[..., 0, 0]
09.3 last offset: smallest
    np.argmin(nis) -> -1
09.4 root of the sum over n: mean|root
    np.sqrt(np.mean(d2)) -> np.sqrt(np.sum(d2)) / len(d2)
09.4 only x: x and y|distance|root
    np.sum((aligned - truth) ** 2, axis=1) -> (aligned - truth)[:, 0] ** 2
10.1 t turned as well and taken away: origin of the frame|R pf
    R.T @ (p - t) -> R.T @ p - R @ t
10.1 PF_p negative: PF_p = R', with a plus
    PF_t, PF_p = -R.T, R.T -> PF_t, PF_p = -R.T, -R.T
10.1 row by row: R turns|other way|frame
    R.T @ (p - t) -> (R * (p - t)).sum(1)
10.1 PF_t and PF_p exchanged by a transpose: PF_t|-R'
    PF_t, PF_p = -R.T, R.T -> PF_t, PF_p = -R, R.T
10.1 the sign of t: t - p|p - t|origin
    R.T @ (p - t) -> R.T @ (t - p) + 0 * p
10.2 position of G only: add t_F.*turn it with R_F
    t = F[:3] + R @ G[:3] -> t = G[:3]
10.2 quaternion of G only: turned by G first, then by F|product
    q, _, _ = q_prod(F[3:], G[3:]) -> q = G[3:]
10.2 conjugate of F: turned|commute|F
    q_prod(F[3:], G[3:]) -> q_prod(F[3:] * [1, -1, -1, -1], G[3:])
10.2 t of G added before the turn: R_F|turn
    t = F[:3] + R @ G[:3] -> t = R @ (F[:3] + G[:3])
10.2 half of the product: exactly half
    q, _, _ = q_prod(F[3:], G[3:]) -> q = q_prod(F[3:], G[3:])[0] / 2
10.3 position normalised, too: position
    return np.concatenate([x[:3], u]) -> return np.concatenate([x[:3] / np.linalg.norm(x[:3]), u])
10.3 u u' added, not divided: U_q|I - u u'
    (np.eye(4) - np.outer(u, u)) / n -> (np.eye(4) + np.outer(u, u))
10.3 sum of the entries as norm: q / \|q\|
    np.linalg.norm(x[3:]) -> np.sum(np.abs(x[3:]))
10.3 norm of the vector part: q / \|q\||norm
    np.linalg.norm(x[3:]) -> np.linalg.norm(x[4:])
10.3 half of the old covariance: U_q|quaternion
    J @ P @ J.T -> (J @ P @ J.T + P) / 2
10.4 position error negative: estimate minus truth
    x[:3] - truth[:3] -> truth[:3] - x[:3]
10.4 half the vector: exactly half
    v, _ = q2v(dq if dq[0] >= 0 else -dq) -> v = q2v(dq if dq[0] >= 0 else -dq)[0] / 2
10.4 conjugate of the estimate, and the right order: q_truth|true|turn
    q_prod(q2qc(truth[3:])[0], x[3:]) -> q_prod(truth[3:], q2qc(x[3:])[0])
10.4 long way round: short|length|pi
    dq if dq[0] >= 0 else -dq -> dq if dq[0] < 0 else -dq
10.4 position and rotation exchanged: first|position|three
    np.concatenate([x[:3] - truth[:3], v]) -> np.concatenate([v, x[:3] - truth[:3]])
10.5 PS_p by two transposes: no transposes
    PS_pr @ PR_p -> PS_pr.T @ PR_p.T
10.5 PS_s of the robot's frame: second step|pr
    PR_r, PS_s, PS_pr @ PR_p -> PR_r, PS_pr @ PR_r, PS_pr @ PR_p
10.5 PS_r negative: Rf changes pr|sign
    return ps, PS_pr @ PR_r -> return ps, -PS_pr @ PR_r
10.5 PS_s by the first step, too: order of the factors
    PR_r, PS_s, PS_pr -> PR_r, PS_s @ PR_r, PS_pr
10.5 only the first factor of PS_p: PS_p|chain|PR_p
    PS_s, PS_pr @ PR_p -> PS_s, PR_p @ PR_p
11.1 turn twice: right|q dq|axes of the robot
    q2, Q_q, Q_dq = q_prod(x[3:], dq) -> q2, Q_q, Q_dq = q_prod(q_prod(x[3:], dq)[0], dq)
11.1 turn backwards: right|q dq|axes of the robot
    dq, DQ_v = v2q(u[3:]) -> dq, DQ_v = v2q(-u[3:])
11.1 degrees: radians|axes of the robot|right
    dq, DQ_v = v2q(u[3:]) -> dq, DQ_v = v2q(np.radians(u[3:]))
11.1 Q_q left out: q2 depends on q|R\(q\)
    X_x[3:, 3:] = Q_q -> X_x[3:, 3:] = 0
11.1 X_u of dx with the old sign: X_u|R|dx
    X_u[:3, :3] = R -> X_u[:3, :3] = -R
11.2 P doubled: X_x P X_x'|twice
    X_x @ P @ X_x.T -> 2 * X_x @ P @ X_x.T
11.2 U doubled: X_u U X_u'|twice|robot's axes
    X_u @ U @ X_u.T -> 2 * X_u @ U @ X_u.T
11.2 P moved by the transposed Jacobian alone: X_x P X_x'
    X_x @ P @ X_x.T -> P @ X_x.T
11.2 step made twice: once|twice|mean|x
    x2, X_x, X_u = odo3(x, u) -> x2, X_x, X_u = odo3(odo3(x, u)[0], u)
11.2 noise of the turn left out: U|noise
    U @ X_u.T -> (U * ([1, 1, 1, 0, 0, 0] * np.ones((6, 1)))) @ X_u.T
11.3 velocity also turned by dq: world|keep their values
    v + u[:3], w -> q2R(dq)[0] @ v + u[:3], w
11.3 impulses swapped: keep their values|impulse
    v + u[:3], w + u[3:] -> v + u[3:], w + u[:3]
11.3 dt squared: t \+ v dt|world
    t + v * dt -> t + v * dt**2
11.3 w left as it was: impulse|w
    w + u[3:]]) -> w])
11.3 velocity also moves the turn: w|turn
    v2q(w * dt) -> v2q(v * dt)
11.4 twelve steps: [Vv]ariance|sigma
    return dt * np -> return dt / 12 * np
11.4 half the variance: half|sigma
    return dt * np -> return 0.5 * dt * np
11.4 one for each: 6, 6|impulses
    [sigma_v**2] * 3 + [sigma_w**2] * 3 -> [sigma_v**2, sigma_w**2]
11.4 turn left out: sigma_w|turn|v and w|six|6
    [sigma_w**2] * 3 -> [0.0] * 3
11.4 dt added to all variances: variance|sigma squared|step
    return dt * np -> return dt * np.eye(6) + np
12.1 half the second term: product|f and up|factor 2
    2 * f_r2 -> 0.5 * f_r2
12.1 UD_d without up: column|linear
    np.outer(up, powers) -> np.outer(np.ones(2), powers)
12.2 pixel from the far corner: u0|order
    u = k[:2] + k[2:] * ud -> u = k[:2] - k[2:] * ud
12.2 UP_p transposed block: U_ud UD_up UP_p|UP_p
    UP_p = np.array([[1, 0, -x / z], [0, 1, -y / z]]) / z -> UP_p = np.array([[1, 0, -y / z], [0, 1, -x / z]]) / z
12.3 half of the image: border|width
    (u <= size) -> (u <= size / 2)
12.3 depth of one metre: front|ahead|near
    p[:, 2] > 0 -> p[:, 2] > 1
12.4 U_s with the robot's Jacobian: LS_s
    U_s = U_ls @ LS_s -> U_s = U_ls @ LS_lr @ LR_r
12.4 U_k negative: pin_hole|k
    U_s, U_k, U_d, U_l -> U_s, -U_k, U_d, U_l
12.5 a step too long: distort\(up, d\)|repeat|enough|Repeat
    ud - u) -> 2.5 * (ud - u))
12.5 five halves of a step: distort\(up, d\)|enough|steps
    ud - u) -> 0.3 * (ud - u))
13.1 gain by the noise alone: K = P H
    K = P * H / (H * P * H + var) -> K = P * H / var
13.1 H squared forgotten: factor 1 - K H|K = P H|H
    (H * P * H + var) -> (H * P + var)
13.1 innovation by the sine: angle|arctan
    e = np.arctan(b * rho) -> e = np.sin(b * rho)
13.1 noise twice: K|var
    (H * P * H + var) -> (H * P * H + 2 * var)
13.1 corrected twice: K|y - e
    K * (y - e), -> 2 * K * (y - e),
13.2 R taken twice: L_y R L_y'|pixel
    L_y @ R @ L_y.T -> 2 * L_y @ R @ L_y.T
13.2 rho negative: prior
    l, L_F, L_lc = IdpPnt().from_frame(F, l_c) -> l, L_F, L_lc = IdpPnt().from_frame(F, l_c); l[5] *= -1
13.2 the ray left where the camera looks: V_y|pixel|chain
    L_lc @ LC_v @ V_y -> L_lc @ LC_v[:, :2]
13.2 N counted twice: L_n N L_n'|prior
    L_n @ N @ L_n.T -> 2 * L_n @ N @ L_n.T
13.2 covariance with the camera by half: P_lF|L_F P_F
    P_lF = L_F @ P_F -> P_lF = 0.5 * L_F @ P_F
13.3 half the way: anchor \+ m / rho
    p = a + m / rho -> p = a + m / (2 * rho)
13.3 states behind it dropped: n - 3
    [x[:i], p, x[i + 6 :]] -> [x[:i], p]
13.3 anchor moved by rho: anchor|a \+ m
    p = a + m / rho -> p = a * (1 + rho) + m / rho
13.3 angles left out of the derivative: pitch|angle|M_py|differences
    M_py / rho, -m -> 0 * M_py, -m
13.3 one row too few behind: behind|rest|identity|other
    = np.eye(len(x) - i - 6) -> = 0.5 * np.eye(len(x) - i - 6)
14.1 gap behind the first state: gap|piece
    [i + 1 - k, i + 1] -> [i - k, i]
14.1 last of the gaps: first|gap
    enumerate(used): -> enumerate(used[::-1]):
14.1 reversed search: first|gap|piece
    return np.array([i + 1 - k, i + 1]) -> return np.array([i - k, i])
14.1 one more than asked for: k|length|number|stop|end
    return np.array([n, n + k]) -> return np.array([n, n + k + 1])
14.1 a gap must be larger: gap|fits|piece
    if free == k: -> if free == k + 1:
14.2 known by place: Known|known
    id in known] -> i in known]
    id not in known] -> i not in known]
14.2 all of known: [Kk]nown
    if id >= 0 and id in known -> if id in known or id == -1
14.2 only one correction: all|[Kk]nown|every
    np.array(correct, dtype=int), np -> np.array(correct[:1], dtype=int), np
14.2 corrections limited, too: n_inits|known|limit
    np.array(correct, dtype=int), np -> np.array(correct[:n_inits], dtype=int), np
14.2 new only with a greater number: [Kk]nown|start|new
    if id >= 0 and id not in known -> if id > max([*known], default=-1)
14.2 sorted by id: order|measure|index|indices
    correct, start = np.array(correct, -> correct, start = np.array(sorted(correct, key=lambda i: -ids[i]),
15.1 R halved: Z = H P H' \+ R|noise
    H.T + R -> H.T + R / 2
15.1 gain of a diagonal Z: use the whole Z
    np.linalg.solve(Z, H @ P).T -> (P @ H.T) / np.diag(Z)
15.1 z added to all: K|slice|stays
    x + K @ z -> x + K.sum() * z.sum()
15.2 w of the largest entry: trace
    np.trace(Ps, axis1=1, axis2=2) -> Ps.max(axis=(1, 2))
15.2 one estimate doubled: each information has its weight
    w * Ia @ xa + (1 - w) * Ib @ xb -> Ia @ xa + Ib @ xb
15.3 both headings added: robot 2
    F1.theta + b12 -> F1.theta + F2.theta + b12
15.3 robot 2 in its own map: robot 2|map
    robot2.compose(back)[0].x -> back.x
16.1 distance from the corner: length
    np.linalg.norm(p, axis=-1, keepdims=True) -> np.sqrt(np.abs(np.sum(p, axis=-1, keepdims=True)))
16.1 Jacobian of the square: squared range
    np.asarray(p) / r -> 2 * np.asarray(p)
16.2 range from the side: max_range|further
    y[..., 0] <= max_range -> p[..., 0] <= max_range
16.2 cone of fov in the other unit: fov|radians
    fov / 2 -> np.radians(fov) / 2
16.3 heading twice: theta \+ beta
    c, s = np.cos(x[2] + beta), np.sin(x[2] + beta) -> c, s = np.cos(2 * x[2] + beta), np.sin(2 * x[2] + beta)
16.3 P_px of P_pp: P_x P
    P_px = P_x @ P -> P_px = P_pp @ P_x
16.4 variances normalised: likelihood|Gaussian|wide
    np.log(Z) -> np.log(Z / Z.sum()) * 3
16.4 the square of the old weights: old weight|[Ww]eight
    np.log(w) - 0.5 -> 2 * np.log(w) - 0.5
16.4 sign of the height: root|height|Gaussian|wide
    + np.log(Z)) -> - np.log(Z))
16.5 elevation from the axis x: plane|arctan2\(z
    np.arctan2(z, s) -> np.arctan2(z, np.abs(x))
16.5 E_p without its last entry: elevation
    s / r2], axis -> 0 * s], axis
16.5 azimuth from behind: azimuth|arctan2\(y
    np.arctan2(y, x), np -> np.arctan2(-y, -x), np
17.1 sum of all: one number|each
    .sum(-1) -> .sum()
17.2 limits of 99 per cent: 2.5 %|limit
    [0.025, 0.975] -> [0.005, 0.995]
17.2 variance of the mean forgotten: runs|band|limits
    runs * dof) / runs -> dof * runs) * runs
18.1 range of three numbers: distance
    np.array([r, wrap -> np.array([np.linalg.norm(b - a), wrap
18.1 both headings in the bearing: heading of a|direction
    np.arctan2(dy, dx) - a[2] -> np.arctan2(dy, dx) - a[2] - b[2]
18.2 K without P_ab: P H'|rows|hand
    np.linalg.solve(Z, H @ P).T -> np.linalg.solve(Z, H @ np.diag(np.diag(P))).T
18.2 z counted twice: K z|twice|hand
    x + K @ z -> x + 2 * K @ z
18.3 first positions together: angle|vector|motion
    a, b = p - p.mean(axis=0), q - q.mean(axis=0) -> a, b = p - p[0], q - q[0]
18.3 twice the angle: rigid motion
    np.sum(a * b)) -> np.sum(a * b)) * 2
18.4 gain of map 2: weight|hand|smaller
    np.linalg.solve(P1 + P2, P1).T -> np.linalg.solve(P1 + P2, P2).T
18.4 sum of both: weight|hand|mean
    l = l1 + K @ (l2 - l1) -> l = l1 + K @ l2
19.1 steering times v: tan|w = v_c
    x2 = x + dt * k * v * way -> x2 = x + dt * k * v * way + [0, 0, dt * alpha]
19.1 H for L: v_c|turn
    k = 1 / (1 - H * t / L) -> k = 1 / (1 - L * t / H / 20)
19.1 the arm twice as long: laser|arm|a sin|w
    along + around * t / L -> along + 2 * around * t / L
19.1 brakes: dt|v_c|ahead|back
    x2 = x + dt * k * v * way -> x2 = x - dt * k * v * way
19.1 half of X_x: X_x|heading|derivative
    X_x[:2, 2] = dt * k -> X_x[:2, 2] = 0.5 * dt * k
19.2 nearest of all: nearest|claim|not used
    D[np.arange(k), best] <= gate -> D.min() <= gate
19.2 limits exchanged: limits|gate|far
    > new_gate -> < new_gate
19.2 farthest detection of a tree: other|nearest|nearer|each
    D.argmin(axis=0) -> D.argmax(axis=0)
19.2 new ones by the mean distance: too near to a tree|every|is not used
    D.min(axis=1, initial=np.inf) > new_gate -> (D.mean(axis=1) if n else np.full(k, np.inf)) > new_gate
19.2 gate of a wider kind: gate|far|limit
    <= gate) -> <= 2 * gate)
19.3 one scan too many: often enough|looked for|scan
    searched >= min_search -> searched + 1 >= min_search
19.3 share of 1: share|less|found
    min_ratio * searched -> min_ratio
19.3 everything out of view: view|visible|looked
    bad = visible & -> bad = ~visible &
19.4 fixes by their order: line between|time
    np.interp(inside[:, 0], t, path[:, i]) -> np.interp(np.linspace(t[0], t[-1], len(inside)), t, path[:, i])
19.4 half of the share: share|nearest|best
    int(share * len(d)) -> int(0.5 * share * len(d))
19.4 y of the path forgotten: x and y|distance|path
    for i in (0, 1)]) -> for i in (0, 0)])
19.4 time in the wrong unit: time|line between|fixes
    np.interp(inside[:, 0], t, path[:, i]) -> np.interp(inside[:, 0] / 2, t, path[:, i])
20.2 halves: counted twice|half|silent|right prediction|P2
    D = P_new - ( -> D = P_new - 0.5 * (
20.3 r1 added twice: theta \+ r1
    wrap(x[2] + r1 + r2) -> wrap(x[2] + 2 * r1 + r2)
20.3 U in degrees: X_u U X_u'
    X_u @ U @ X_u.T -> np.radians(X_u) @ U @ np.radians(X_u).T
21.1 gain halved: ordinary EKF|K z
    K @ (z - H -> 0.5 * K @ (z - H
21.1 iterated from zero: prior|H \(x - at\)|ordinary
    at, P_new = np.array(x, float), P -> at, P_new = np.zeros(len(x)) + x[0], P
21.2 R on the right side squared: R\^-1|variance
    W.T @ z -> np.linalg.solve(R, W).T @ z
21.2 damped, as by Levenberg: no damping
    A = H.T @ W -> A = H.T @ W + np.eye(H.shape[1])
21.3 A of those that go: stay|keep
    A_kk - S @ A_kg.T -> A_gg[: len(keep), : len(keep)] if len(gone) >= len(keep) else A_kk
21.3 half of it taken away: inverse|inv|A_gg|known
    A_kk - S @ A_kg.T -> A_kk - S @ A_kg.T / 2
"""


def made(text):
    """Yield exercise, name, pattern and answer of each block."""
    for title, pattern, places in edits.blocks(text):
        id, _, name = title.partition(" ")
        answer = edits.mistake(registry.get(id).solution, name, pattern, places).answer
        answer.__name__, answer.__module__ = name, __name__
        yield id, pattern, answer


for id, pattern, answer in made(WRONG):
    answer_to(id, hint=pattern)(answer)

test_the_check_is_right_about_it = check_of(__name__)
