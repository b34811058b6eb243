"""Classes of mistakes that students make in any exercise: each is told as what it is, and no other one beside it."""

import inspect
import linecache
import re
import textwrap

import numpy as np
import pytest

from ekfslam_tutorial.course import own_words, registry
from ekfslam_tutorial.course.diagnose import diagnose
from ekfslam_tutorial.course.exercise import Exercise
from ekfslam_tutorial.course.table import table

pytestmark = pytest.mark.usefixtures("time_to_search")
EXERCISES = [exercise for exercise in registry.everything() if isinstance(exercise, Exercise)]
FORMS = [(exercise, form) for exercise in EXERCISES for form in exercise.forms]


def judged(id, text, *places):
    """The verdict on a text, as from a cell, with some places written otherwise."""
    exercise, text = registry.get(id), textwrap.dedent(text)
    for old, new in places:
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times"
        text = text.replace(old, new)
    name, space = f"<cell {id} {len(linecache.cache)}>", dict(exercise.solution.__globals__)
    linecache.cache[name] = len(text), None, text.splitlines(keepends=True), name
    exec(compile(text, name, "exec"), space)
    return exercise.judge(space[exercise.name])


PREDICT = """
def predict(x, P, u, U):
    c, s = np.cos(x[2]), np.sin(x[2])
    F, G = np.eye(len(x)), np.zeros((len(x), 3))
    F[0, 2] = -s * u[0] - c * u[1]
    F[1, 2] = c * u[0] - s * u[1]
    G[:3] = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    new = np.array(x, float)
    new[:2] += [c * u[0] - s * u[1], s * u[0] + c * u[1]]
    new[2] += u[2]
    return new, F @ P @ F.T + G @ U @ G.T
"""
MATRICES = """
def inverse_observation(x_r, y):
    c, s = np.cos(x_r[2]), np.sin(x_r[2])
    C = np.array([[c, -s], [s, c]])
    dC = np.array([[-s, -c], [c, -s]])
    u, v = np.cos(y[1]), np.sin(y[1])
    p, P_y = y[0] * np.array([u, v]), np.array([[u, -y[0] * v], [v, y[0] * u]])
    return x_r[:2] + C @ p, np.hstack([np.eye(2), (dC @ p)[:, None]]), C @ P_y
"""
CHAIN = """
def close_chain(q, R, z):
    n = len(q)
    P = np.array([[sum(q[: min(i, k) + 1]) for k in range(n)] for i in range(n)])
    H = np.eye(n)[-1:]
    Z = (H @ P @ H.T + R)[0, 0]
    K = P @ H.T / Z
    return K[:, 0] * z, (np.eye(n) - K @ H) @ P
"""
ATE = """
def ate(path, truth):
    m, t = path.mean(axis=0), truth.mean(axis=0)
    U, _, Vt = np.linalg.svd((path - m).T @ (truth - t))
    R = Vt.T @ np.diag([1, np.linalg.det(Vt.T @ U.T)]) @ U.T
    new = (path - m) @ R.T + t
    return new, np.sqrt(np.mean(np.sum((new - truth) ** 2, axis=1)))
"""
COMPOSE = """
def compose(F, G):
    R, q = q2R(F[3:])[0], q_prod(F[3:], G[3:])[0]
    return np.concatenate([R @ G[:3] + F[:3], q])
"""
RHO = """
def correct_rho(rho, P, b, y, var):
    H = b / (1 + (b * rho) ** 2)
    Z = H * P * H + var
    K = P * H / Z
    return rho + K * (y - np.arctan(b * rho)), P - K * Z * K
"""
ERROR = """
def pose_error(x, truth):
    dq, _, _ = q_prod(q2qc(truth[3:])[0], x[3:])
    if dq[0] < 0:
        dq = -dq
    n = np.linalg.norm(dq[1:])
    v = 2 * np.arctan2(n, dq[0]) * dq[1:] / n if n > 0 else np.zeros(3)
    return np.concatenate([x[:3] - truth[:3], v])
"""
UNSEEN = """
def observability(H, F):
    rows, Phi = [], np.eye(H[0].shape[1])
    for k in range(len(H)):
        rows.append(H[k] @ Phi)
        if k < len(F):
            Phi = F[k] @ Phi
    O = np.vstack(rows)
    return O, O.shape[1] - np.linalg.matrix_rank(O)
"""
CORRECT = """
def correct(x, P, y, R, e, H):
    z = np.array(y - e)
    z[1] = wrap(z[1])
    Z = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(Z)
    return x + K @ z, P - K @ Z @ K.T
"""
STEP = """
def map_step(x, P, ids, seen, ys, x_r, R):
    ids = list(ids)
    for n in range(len(seen)):
        id, y = seen[n], ys[n]
        if id in ids:
            e, H = h(x, ids.index(id), x_r)
            z = y - e
            z[1] = wrap(z[1])
            Z = H @ P @ H.T + R
            K = P @ H.T @ np.linalg.inv(Z)
            x, P = x + K @ z, P - K @ H @ P
        else:
            x, P = add_landmark(x, P, y, x_r, R)
            ids.append(id)
    return x, P, ids
"""
FRAME = """
def slam_frame(x, P, ids, u, U, seen, ys, R):
    x, P = predict(x, P, u, U)
    start, known = x, list(ids)
    for id, y in zip(seen, ys):
        if id in ids:
            k = 3 + 2 * ids.index(id)
            e, H = observe(x, slice(k, k + 2))
            H = np.pad(H, ((0, 0), (0, len(x) - H.shape[1])))
            x, P = correct(x, P, y, R, e, H)
        else:
            x, P = augment(x, P, y, R)
            known.append(id)
    return x, P, known
"""
GROW = """
def add_landmark(x, P, y, x_r, R):
    a, n = x_r[2] + y[1], len(x)
    L = np.array([[np.cos(a), -y[0] * np.sin(a)], [np.sin(a), y[0] * np.cos(a)]])
    new = np.zeros((n + 2, n + 2))
    new[:n, :n], new[n:, n:] = P, L @ R @ L.T
    return np.append(x, x_r[:2] + y[0] * np.array([np.cos(a), np.sin(a)])), new
"""
BAND = """
def in_band(nees, dof):
    runs = len(nees)
    mean = nees.mean(axis=0)
    low, high = (chi2.ppf(p, runs * dof) / runs for p in (0.025, 0.975))
    return (low <= mean) & (mean <= high)
"""
TEXTS = {"05.1": PREDICT, "04.1": MATRICES, "06.2": CHAIN, "09.4": ATE, "13.1": RHO, "02.5": STEP, "05.5": FRAME,
         "02.4": GROW, "17.2": BAND, "10.4": ERROR, "08.1": UNSEEN, "05.3": CORRECT, "10.2": COMPOSE}  # fmt: skip


@pytest.mark.parametrize("id", TEXTS)
def test_the_text_is_a_right_answer(id):
    assert judged(id, TEXTS[id]).passed


ONE = [  # exercise, what is told, places
    # a step that reaches a part only
    ("05.1", r"`x\[:2\]` is not changed in yours", ("new[:2] +=", "new[:2] + ")),
    # the heading in the middle of the step
    (
        "05.1",
        "turn it by the old heading, in X_x and X_u, too",
        ("np.cos(x[2]), np.sin(x[2])", "np.cos(a := x[2] + u[2] / 2), np.sin(a)"),
    ),
    # a matrix of one's own for the noise, used on both sides
    (
        "05.1",
        r"as if `X_u` were .*\[0, 0, 2\]\]\)`, not .* in `P\[:3, :3\] \+= X_u @ U @ X_u.T`",
        ("[0, 0, 1]]", "[0, 0, 2]]"),
    ),
    ("05.1", "add it after the motion", ("F @ P @ F.T + G @ U @ G.T", "F @ (P + G @ U @ G.T) @ F.T")),
    # one slip in another form, which would be two in the solution
    ("13.1", "In the form P - K Z K: A division is missing", ("P * H / Z", "P * H")),
    ("13.1", r"K\^2 var", ("P - K * Z * K", "(1 - K * H) ** 2 * P")),
    ("04.1", "In the form l = t . R p, .*: A transpose too many", ("C @ P_y", "C.T @ P_y")),
    ("04.1", "cos becomes -sin, and sin becomes cos", ("dC @ p", "C @ p")),
    (
        "09.4",
        "A free scale hides errors",
        ("R.T + t", "R.T * np.sqrt(np.sum((truth - t) ** 2) / np.sum((path - m) ** 2)) + t"),
    ),
    # where R is zero, a quotient is infinite or no number: that is one mistake all the same
    ("06.2", "not by R alone", ("P @ H.T / Z", "P @ H.T / R")),
    ("06.2", "must still be multiplied by P", ("(np.eye(n) - K @ H) @ P", "np.eye(n) - K @ H")),
    # the id is a name, whatever fails because of it
    ("02.5", "An id is the name of a landmark", ("ids.index(id)", "id")),
    ("02.5", "An id is the name of a landmark", ("ids.index(id)", "seen[n]")),
    ("05.5", "An id is the name of a landmark", ("2 * ids.index(id)", "2 * id")),
    # what is seen of a system, in any units, by all rows
    ("08.1", "A fixed threshold depends on the units", ("matrix_rank(O)", "matrix_rank(O, tol=1e-10)")),
    ("08.1", "A fixed threshold depends on the units", ("matrix_rank(O)", "matrix_rank(O, tol=1e-12)")),
    ("08.1", "(?!Divided).*A fixed threshold", ("matrix_rank(O)", "matrix_rank(O.T @ O, tol=1e-6)")),
    ("08.1", "the later ones may see", ("matrix_rank(O)", "matrix_rank(O[: O.shape[1]])")),
    ("08.1", "The rows of the last H are missing", ("range(len(H))", "range(len(F))")),
    # the position alone the wrong way round
    ("10.2", "You put the position of F into G", ("R @ G[:3] + F[:3]", "q2R(G[3:])[0] @ F[:3] + G[:3]")),
    ("10.2", "nothing is rolled", ("q2R(F[3:])", "q2R(np.roll(F[3:], -1))")),
    # no number comes of many mistakes: it is no sign of a root
    ("10.4", "(?!.*as if).*its axis is 0/0", (" if n > 0 else np.zeros(3)", "")),
    # the long way round
    ("10.4", "it is the sign of dq.0. that tells", ("if dq[0] < 0", "if x[3] < 0")),
    (
        "10.4",
        "not each component",
        ("    if dq[0] < 0:\n        dq = -dq\n", ""),
        ("dq[1:] / n if n > 0 else np.zeros(3)", "dq[1:] / (n or 1); v = (v + np.pi) % (2 * np.pi) - np.pi"),
    ),
    ("10.4", "half a turn vanishes", ("    if dq[0] < 0:\n        dq = -dq\n", "    dq = dq * np.sign(dq[0])\n")),
    ("17.2", "the argument dof: 6 is one case only", ("runs * dof", "runs * 6")),
]


EDITED = [  # exercise, what is told of the solution with these places written otherwise
    ("03.1", "belongs to the normal", ("chi2.cdf(k**2, dof)", "2 * chi2.cdf(k**2, dof) - 1")),
    ("05.4", "the .first. 3 numbers of x", ("inverse_observation(x[:3], y)", "inverse_observation(x[-3:], y)")),
    ("05.4", "rows and columns of P come last", ("[[P, P_lx.T], [P_lx, P_ll]]", "[[P_ll, P_lx], [P_lx.T, P]]")),
    ("06.3", "two of the four blocks are missing", ("P[a, a] + P[b, b] - P[a, b] - P[b, a]", "P[b, b] - P[a, b]")),
    ("07.2", "No landmark is used twice", ("np.argmin(D[:, near]) == i", "D[i, near] == min(D[:, near])")),
    ("09.4", "divided by n, not by n - 1", ("path.mean(axis=0)", "(m := sum(path) / (len(path) - 1))"),
     ("truth - truth.mean(axis=0)", "truth - (t := sum(truth) / (len(path) - 1))"), ("+ truth.mean(axis=0)", "+ t")),
    ("09.4", "over axis=0", ("a, b = path - path.mean(axis=0)", "a, b = path - path.mean(axis=1)[:, None]"),
     (" truth - truth.mean(axis=0)", " truth - truth.mean(axis=1)[:, None]"),
     ("+ truth.mean(axis=0)", "+ truth.mean(axis=1)[:, None]")),
    ("11.1", "the whole rotation vector", ("v2q(u[3:])", "v2q(u[3:] / 2)")),
    ("11.1", "in radians already", ("v2q(u[3:])", "v2q(np.deg2rad(u[3:]))")),
    ("11.1", "for small turns only", ("q_prod(x[3:], dq)", "q_prod(x[3:], [1, *u[3:] / 2])")),
    ("00.1", "`//` counts the whole turns", ("np.pi - (np.pi - angle) % (2 * np.pi)", "angle // (2 * np.pi)")),
]  # fmt: skip


@pytest.mark.parametrize(("id", "told", "places"), [(i, t, p) for i, t, *p in EDITED], ids=lambda v: str(v)[:40])
def test_a_mistake_that_looks_like_another_is_told_as_itself(id, told, places):
    hint = " ".join(judged(id, registry.get(id).source(), *places).hint.split())
    assert re.search(told, hint) and "Two things" not in hint, hint


@pytest.mark.parametrize(("id", "told", "places"), [(i, t, p) for i, t, *p in ONE], ids=lambda v: str(v)[:40])
def test_one_mistake_is_told_as_one(id, told, places):
    verdict = judged(id, TEXTS[id], *places)
    hint = " ".join(verdict.hint.split())
    assert verdict.status == "failed" and re.search(told, hint) and "Two things" not in hint, hint


TWO = [  # exercise, what is told of each, places
    # no name of the solution is said to stand for another one
    (
        "09.4",
        "`a @ R.T` stood where",
        "take the mean of the squares",
        ("R.T + t", "R.T"),
        ("np.mean(np.sum", "np.sum(np.sum"),
    ),
    # truth values of many frames
    (
        "17.2",
        "limits of .one. NEES",
        "there is an upper limit",
        ("runs * dof) / runs", "dof)"),
        ("& (mean <= high)", ""),
    ),
    (
        "17.2",
        "2.5 % on each side",
        "are those of the .mean.",
        ("0.025, 0.975", "0.05, 0.95"),
        ("nees.mean(", "np.median(nees, "),
    ),
    # together they are as if Z, which is right, had the wrong sign
    ("05.3", "z = y - e", "K Z K' is subtracted", ("y - e", "e - y"), ("P - K @ Z", "P + K @ Z")),
    # another exercise, written anew: its own words
    (
        "02.4",
        "As in `q`. ",
        "A landmark twice as far away",
        ("L = np", "b = y[1]; L = np"),
        ("[np.cos(a), np.sin(a)]", "[np.cos(b), np.sin(b)]"),
        ("-y[0] * np.sin(a)], [np.sin(a), y[0] * np.cos(a)]", "-np.sin(a)], [np.sin(a), np.cos(a)]"),
    ),
    (
        "04.1",
        "Angles count counter-clockwise",
        "The last column of L_r is not zero",
        ("c, s = np.cos(x_r[2]), np.sin(x_r[2])", "c, s = np.cos(x_r[2]), np.sin(x_r[2]); y = np.array([y[0], -y[1]])"),
        ("u, -y[0] * v], [v, y[0] * u", "u, y[0] * v], [v, -y[0] * u"),
        ("dC @ p", "0 * p"),
    ),
]


@pytest.mark.parametrize(("id", "one", "other", "places"), [(i, a, b, p) for i, a, b, *p in TWO],
                         ids=lambda v: str(v)[:40])  # fmt: skip
def test_of_two_mistakes_each_is_told(id, one, other, places):
    hint = " ".join(judged(id, TEXTS[id], *places).hint.split())
    assert hint.startswith("Two things, in this order") and re.search(one, hint) and re.search(other, hint), hint


def turned_over(a, b):
    """Return [a + 0.5, b], the latter with the sign of a."""
    return np.array([a + 0.5, b if a >= 0 else -b])


def test_no_number_is_no_sign_of_a_mistake_that_gives_none_either():
    """The slip `-np.sqrt(b)` for `-b` gives NaN in the one call in which the answer, for another reason, does."""
    made = table(
        "99.1 Turned over",
        turned_over,
        hints=("", "", ""),
        returns="c",
        cases={"any": lambda rng: [(1.2, 0.3), (0.7, -2.1), (-1.4, -0.8), (2.6, 1.9)]},
        checks="value | c | any | Look at the sign.",
        wrong="no half | a + 0.5 -> a | The half is missing.",
    )
    verdict = made.judge(lambda a, b: turned_over(a, b) if a >= 0 else np.array([a + 0.5, np.nan]))
    assert "NaN" in verdict.message and "root too many" not in verdict.hint and not verdict.misconception


def test_two_that_may_be_one_are_told_so():
    """With a slip beside it nobody knows whether the student has made two mistakes."""
    listed = judged("17.2", BAND, ("runs * dof) / runs", "dof)"), ("& (mean <= high)", "")).hint
    slip = judged("09.4", ATE, ("R.T + t", "R.T"), ("np.mean(np.sum", "np.sum(np.sum")).hint
    assert "one mistake may be behind both" in slip and "one mistake" not in listed


def test_of_a_result_with_few_values_its_mistake_is_named_though_another_one_is_wrong_too():
    places = ("observe(x, ", "observe(start, "), ("known.append(id)", "known.insert(0, id)")
    assert "put its id at the end of ids" in judged("05.5", FRAME, *places).hint


@pytest.mark.parametrize(("exercise", "form"), FORMS, ids=lambda e: e.id)
def test_each_form_is_a_right_answer_whose_text_can_be_read(exercise, form):
    assert exercise.judge(form.solution).passed and form.note
    assert own_words.formulas(form.solution) and inspect.getsource(form.solution).startswith("def ")


def test_places_are_told_from_ids():
    def by_place(seen, ys, x):
        return [x[2 * k : 2 * k + 2] + y for k, y in enumerate(ys)]

    def by_id(seen, ys, x):
        return [x[2 * id : 2 * id + 2] + y for id, y in zip(seen, ys, strict=True)]

    def named(seen, ys, x):
        return [h(x, i) for n, i in enumerate(seen)]  # noqa: F821

    found = [own_words.ids_as_places(f, "seen", ("h",)) for f in (by_place, by_id, named, eval("lambda seen: 2"))]
    assert found == [False, True, True, False]


def test_a_covariance_by_dt_is_known():
    exercise = next(e for e in EXERCISES if "dt" in e.parameters() and "U" in e.parameters())
    hints = [slip.hint for slip in exercise.slips()]
    assert {f"`U` is {what} by dt in yours." for what in ("multiplied", "divided")} <= set(hints)


# ---- remarks on numbers -----------------------------------------------------------------------------------


def test_of_two_remarks_that_fit_none_is_made():
    assert diagnose(2.0, 4.0) == ""  # the half and the root
    assert diagnose(1.5, 3.0) == "Yours is exactly half." and diagnose(3.0, 9.0) == "Yours is the square root."


def test_what_rounding_has_left_of_zero_is_zero():
    P = np.array([[0.04, 0.01], [0.01, 0.02]])
    assert diagnose(np.array([[-6.9e-18, 3e-18], [1e-18, 2e-18]]), P) == "Yours is zero."
    assert diagnose(np.array([[0.04, 1e-18], [3e-18, 0.02]]), P) == "Missing (zero) at [0, 1], [1, 0]."


def test_a_sign_is_no_sign_where_the_numbers_were_chosen_by_hand():
    assert "sign" not in diagnose([3.0, 0.0, -1.0], [3.0, 0.0, 1.0])
    assert diagnose([3.0, 0.0, -1.2], [3.0, 0.0, 1.2]) == "Wrong sign at [2]."


def test_whole_numbers_have_lost_no_decimals_by_chance():
    assert "decimals" not in diagnose(np.eye(2), [[1, 0.8], [0.8, 1]])  # 06.1: beside the diagonal nothing is filled
    assert "decimals" not in diagnose([1, 0, 0], [1.66, 0.13, 0.12])  # 10.2: [q, t] for [t, q]
    assert "decimals" in diagnose([1, 0, 2], [1.66, 0.13, 2.12])


def test_a_result_of_type_int_is_told():
    """The covariances are small: only zeros are left of them, and zeros are the result of many mistakes."""

    def filled(x, P, y, R):
        x_new, P_new = registry.get("05.4").solution(x, P, y, R)
        whole = np.empty(P_new.shape, int)
        whole[:] = P_new
        return x_new, whole

    verdict = registry.get("05.4").judge(filled)
    assert verdict.hint.startswith("Your array is of type int") and not verdict.misconception


def test_no_listed_hint_praises_another_part_of_the_answer():
    """Beside another mistake it may be wrong, too."""
    praising = [m.hint for e in EXERCISES for m in e.misconceptions if re.search(r"\b(is|are) right, but\b", m.hint)]
    assert not praising


@pytest.mark.parametrize("given", [4, np.array([4, -4, 7])])
def test_whole_numbers_are_wrapped_with_their_decimals(given):
    def wrap(angle):
        a = np.array(angle)
        while np.any(a > np.pi):
            a[a > np.pi] = a[a > np.pi] - 2 * np.pi
        while np.any(a < -np.pi):
            a[a < -np.pi] = a[a < -np.pi] + 2 * np.pi
        return a

    exercise = registry.get("00.1")
    assert "dtype=float" in exercise.judge(wrap).hint and not np.allclose(wrap(given), exercise.solution(given))

    def changes(angle):
        angle -= 2 * np.pi * np.round(angle / (2 * np.pi))
        return angle

    assert "np.array(angle, dtype=float)" in exercise.judge(changes).hint


# ---- names ------------------------------------------------------------------------------------------------

A_NAME = re.compile(r"(?<![\w'.])(?:[A-Z]_\w+|[A-Z])(?![\w(])")  # P_x, L
ENGLISH = {"A", "I", "K", "H", "Z", "P", "R", "U"}  # and what all filters have


@pytest.mark.parametrize("id", ["16.3", "20.3", "22.2"])
def test_names_in_hints_are_those_of_the_statement_or_are_explained(id):
    exercise = registry.get(id)
    known = set(re.findall(r"\w+", f"{exercise.solution.__doc__} {exercise.symbols}")) | ENGLISH
    said = " ".join([*(m.hint for m in exercise.misconceptions), *(link.help for link in exercise.links)])
    assert set(A_NAME.findall(said)) <= known


def test_what_a_name_means_is_told_with_the_hint_that_has_it():
    exercise = registry.get("22.2")
    hints = {
        m.name: exercise.judge(m.answer).hint
        for m in exercise.misconceptions
        if m.name in ("negative", "Z_y without length")
    }
    assert "Here L = sqrt(a^2 + b^2)." in hints["Z_y without length"] and "Here" not in hints["negative"]


def test_a_wrong_size_gets_no_help_of_a_case_of_another_size():
    """In the first case of 14.2 the map knows all ids: nothing may be said of an empty map."""

    def starts_all(ids, known, n_inits):
        correct = [i for i, id in enumerate(ids) if id in known]
        return np.array(correct, int), np.arange(len(ids))[:n_inits]

    verdict = registry.get("14.2").judge(starts_all)
    assert "empty map" not in verdict.hint
    assert "A case that you can do on paper: ids = [4, 7, 9], known = [7, 9, 4, 2], n_inits = 5." in verdict.hint


SCORE = """
def corner_score(windows):
    gv, gu = np.gradient(windows, axis=(1, 2))
    a, b, c = (gu * gu).sum((1, 2)), (gu * gv).sum((1, 2)), (gv * gv).sum((1, 2))
    return (a + c - np.sqrt((a - c) ** 2 + 4 * b**2)) / 2
"""


def test_a_factor_of_the_whole_result_is_one_mistake():
    once = judged("24.4", SCORE, (") / 2", ")")).hint
    assert "Yours is twice as much" in once and "Two things" not in once
    twice = judged("24.4", SCORE, (") / 2", ")"), ("4 * b**2", "b**2")).hint
    assert "yours lacks the 4" in twice and "Yours is twice as much" in twice


def test_what_a_wrong_result_is_fed_back_with_tells_no_second_mistake():
    text = """
    def correct_blocks(x, P, blocks, z, R):
        H = np.zeros((len(z), len(x)))
        for r, E in blocks:
            if r is not None:
                H[:, r] += E
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        return x + K @ z, P - K @ H @ P
    """
    told = judged("15.1", text, ("P - K @ H @ P", "P - K @ H")).hint
    assert "K H has no unit" in told and "transpose" not in told


def test_a_mistake_in_a_value_and_its_derivative_is_one():
    text = """
    def q(y, x_r):
        a = x_r[2] - y[1]
        c, s = np.cos(a), np.sin(a)
        return x_r[:2] + y[0] * np.array([c, s]), np.array([[c, y[0] * s], [s, -y[0] * c]])
    """
    told = judged("02.3", text).hint
    assert "*plus* beta" in told and "Two things" not in told


JOINT = """
def jointly_compatible(zs, Hs, P, R, confidence):
    m = len(zs)
    z, H = zs.reshape(-1), Hs.reshape(2 * m, -1)
    Z = H @ P @ H.T + np.kron(np.eye(m), R)
    d2 = z @ np.linalg.inv(Z) @ z
    return d2 <= chi2.ppf(confidence, 2 * m), d2, Z
"""
SWAPPED = "np.kron(np.eye(m), R)", "np.kron(R, np.eye(m))"


@pytest.mark.parametrize("beside", [(), (SWAPPED,)], ids=["alone", "beside another"])
def test_a_result_that_is_always_the_same_names_no_slip(beside):
    """It says that ok is wrong, and not why."""
    told = judged("07.3", JOINT, ("chi2.ppf(confidence, 2 * m)", "chi2.ppf(confidence, 2 * m) / 1000"), *beside).hint
    assert "as if" not in told and ("repeats R along the diagonal" in told) == bool(beside)


def test_the_other_tail_is_told_beside_another_mistake():
    tail = "ppf(confidence", "ppf(1 - confidence"
    assert "to be *inside*" in judged("07.3", JOINT, tail).hint
    both = judged("07.3", JOINT, tail, SWAPPED).hint
    assert "repeats R along the diagonal" in both and "to be *inside*" in both and "as if" not in both


SCORE_OF_SUMS = """
def corner_score(windows):
    gv, gu = np.gradient(windows, axis=(1, 2))
    mean = lambda q: q.mean(axis=(1, 2))
    a, c, b = mean(gu * gu), mean(gv * gv), mean(gu) * mean(gv)
    return (a + c - np.sqrt((a - c) ** 2 + 4 * b**2)) / 2
"""


def test_two_listed_mistakes_that_seem_far_from_the_result_are_found():
    """Neither adds up to it, nor multiplies: all pairs of listed mistakes are tried, the likely ones first."""
    told = judged("24.4", SCORE_OF_SUMS).hint
    assert "Multiply first, then add" in told and "*sums* over the window" in told


SORTED = """
def known_then_new(ids, known, n_inits):
    if len(known) == 0:
        hit = np.zeros(len(ids), bool)
    else:
        hit = known[np.clip(np.searchsorted(known, ids), 0, len(known) - 1)] == ids
    new = ~hit & (ids >= 0)
    return np.flatnonzero(hit), np.flatnonzero(new)[:n_inits]
"""


def test_lists_of_exchanged_lengths_need_not_be_in_another_order():
    """Of three known ids none is found, so all are new: three places and none become none and three."""
    told = judged("14.2", SORTED)
    assert "order" not in told.message and "first list, second list" not in told.hint


def test_a_heading_may_be_wrapped_and_the_prior_of_an_iteration_must_be_then():
    exercise = registry.get("19.1")

    def wrapped(x, u, dt, car):
        x2, X_x, X_u = exercise.solution(x, u, dt, car)
        x2[2] = np.pi - (np.pi - x2[2]) % (2 * np.pi)
        return x2, X_x, X_u

    assert exercise.judge(wrapped).status == "passed"
    told = judged(
        "21.1",
        """
        def iterated_correct(x, P, y, R, observe, iterations):
            at = x.copy()
            for _ in range(iterations):
                e, H = observe(at)
                z = y - e
                z[1] = wrap(z[1])
                K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
                at = x + K @ (z - H @ (x - at))
                at[2] = wrap(at[2])
            return at, P - K @ H @ P
        """,
    ).hint
    assert "x - at is a difference of angles" in told
