"""Slips of every formula: what is told of answers that are on no list, alone and beside another mistake.

An answer is a right one, written as a student may write it, with places of it written otherwise.
"""

import numpy as np
import pytest

from ekfslam_tutorial.course import registry, slips
from ekfslam_tutorial.course.diagnose import diagnose
from ekfslam_tutorial.geometry import Frame2, wrap

pytestmark = pytest.mark.usefixtures("time_to_search")

SPACE = {"np": np, "wrap": wrap, "Frame2": Frame2}

TEXTS = {
    "01.2": """
def move(x, u, dt):
    v, w = u
    th, d = x[2], v * dt
    F_x = np.array([[1, 0, -d * np.sin(th)], [0, 1, d * np.cos(th)], [0, 0, 1]])
    F_u = np.array([[dt * np.cos(th), 0], [dt * np.sin(th), 0], [0, dt]])
    return [x[0] + d * np.cos(th), x[1] + d * np.sin(th), th + w * dt], F_x, F_u
""",
    "04.4": """
def effect_on(P, H, R, b):
    S = np.linalg.inv(R + H @ P @ H.T)
    C = H @ P[:, b]
    return C.T @ S, P[b, b] - C.T @ S @ C
""",
    "05.4": """
def augment(x, P, y, R):
    a = x[2] + y[1]
    u, n = np.array([np.cos(a), np.sin(a)]), y[0] * np.array([-np.sin(a), np.cos(a)])
    G, L = np.column_stack([np.eye(2), n]), np.column_stack([u, n])
    T = np.vstack([np.eye(len(x)), np.zeros((2, len(x)))])
    T[-2:, :3] = G
    Q = T @ P @ T.T
    Q[-2:, -2:] += L @ R @ L.T
    return np.append(x, x[:2] + y[0] * u), Q
""",
    "13.1": """
def correct_rho(rho, P, b, y, var):
    H = b / (1 + (b * rho) ** 2)
    K = H * P / (H * P * H + var)
    return rho + K * (y - np.arctan(b * rho)), P - K * H * P
""",
    "18.4": """
def fuse(l1, P1, l2, P2):
    K = P1 @ np.linalg.inv(P1 + P2)
    return l1 + K @ (l2 - l1), P1 - K @ P1
""",
    "20.3": """
def turn_go_turn(x, P, u, U):
    r1, t, r2 = u
    c, s = np.cos(x[2] + r1), np.sin(x[2] + r1)
    F, G = np.eye(len(x)), np.zeros((len(x), 3))
    F[:2, 2] = -t * s, t * c
    G[:3] = [[-t * s, c, 0], [t * c, s, 0], [1, 0, 1]]
    new = np.array(x)
    new[:3] += [t * c, t * s, r1 + r2]
    return new, F @ P @ F.T + G @ U @ G.T
""",
    "21.1": """
def iterated_correct(x, P, y, R, observe, iterations):
    at, W = np.array(x), np.linalg.inv(R)
    for _ in range(iterations):
        e, H = observe(at)
        z = y - e
        z[1] = wrap(z[1])
        new = np.linalg.inv(np.linalg.inv(P) + H.T @ W @ H)
        at = x + new @ H.T @ W @ (z + H @ (at - x))
    return at, new
""",
    "21.3": """
def marginalise(A, b, keep):
    C = np.linalg.inv(A)
    new = np.linalg.inv(C[np.ix_(keep, keep)])
    return new, new @ (C @ b)[keep]
""",
}

SLIPS = [  # exercise, a part of what is told, the places
    ("01.2", "In radians already, so no conversion: `x[2]`", ("th, d = x[2]", "th, d = np.radians(x[2])")),
    ("01.2", "`x2, F_u, F_x` stood where `x2, F_x, F_u`", (", F_x, F_u\n", ", F_u, F_x\n")),
    ("04.4", "`(K_b @ Z @ K_b.T) / 2` stood where", ("C.T @ S @ C", "C.T @ S @ C / 2")),
    ("04.4", "`H @ PHt - R` stood where `H @ PHt + R`", ("(R + H @ P @ H.T)", "(H @ P @ H.T - R)")),
    ("05.4", "As in `inverse_observation`. Without effect in yours: `x_r[2]`", ("a = x[2] + y[1]", "a = y[1]")),
    ("05.4", "`[l, x]` stood where `[x, l]`", ("(x, x[:2] + y[0] * u)", "(x[:2] + y[0] * u, x)")),
    ("13.1", "`H * P` stood where `H * P * H`", ("H * P * H + var", "H * P + var")),
    ("13.1", "`P` is squared", ("    H = b", "    P = P**2; H = b")),
    ("18.4", "`P2 - K @ P1` stood where `P1 - K @ P1`", ("P1 - K @ P1", "P2 - K @ P1")),
    ("20.3", "`x[2]` stood where `x[2] + r1` belongs, in `x[:3]`", ("r1 + r2]", "r2]")),
    ("20.3", "`x[2]` stood where `x[2] + r1`", ("np.cos(x[2] + r1), np.sin(x[2] + r1)", "np.cos(x[2]), np.sin(x[2])")),
    ("20.3", "Exchanged in yours: `u[1]` and `u[2]`", ("r1, t, r2 = u", "r1, r2, t = u")),
    ("21.1", "distance, not an angle", ("z[1] = wrap(z[1])", "z = wrap(z)")),
    ("21.3", "were the inverse of", ("return new, ", "return C[np.ix_(keep, keep)], ")),
]
TWO = [  # exercise, a part of what is told first, and one of what is told then, the places
    (
        "04.4",
        "the gain is + P H' inv(Z)",
        "/ 2` stood",
        ("return C.T @ S", "return -C.T @ S"),
        ("S @ C\n", "S @ C / 2\n"),
    ),
    (
        "05.4",
        "`[l, x]` stood",
        "`L_y @ R` stood where",
        ("(x, x[:2] + y[0] * u)", "(x[:2] + y[0] * u, x)"),
        ("L @ R @ L.T", "L @ R"),
    ),
    (
        "21.3",
        "were the inverse of",
        "b_k - A_kg A_gg^-1 b_g",
        ("return new, ", "return C[np.ix_(keep, keep)], "),
        ("new @ (C @ b)", "b"),
    ),
]


def answer(id, *places):
    """The answer of a text with some places written otherwise."""
    text = TEXTS[id]
    for old, new in places:
        assert text.count(old) == 1, f"{id}: {old!r} stands {text.count(old)} times"
        text = text.replace(old, new)
    space = dict(SPACE)
    exec(text, space)
    return space[text.split("(")[0].split()[1]]


@pytest.mark.parametrize("id", TEXTS)
def test_the_text_is_a_right_answer(id):
    assert registry.get(id).judge(answer(id)).passed


@pytest.mark.parametrize(("id", "told", "places"), [(i, t, p) for i, t, *p in SLIPS], ids=lambda v: str(v)[:40])
def test_a_slip_is_told_with_its_place(id, told, places):
    verdict = registry.get(id).judge(answer(id, *places))
    assert verdict.status == "failed" and told in " ".join(verdict.hint.split()), verdict


@pytest.mark.parametrize(
    ("id", "first", "then", "places"), [(i, a, b, p) for i, a, b, *p in TWO], ids=lambda v: str(v)[:40]
)
def test_a_slip_beside_another_mistake_is_told_too(id, first, then, places):
    hint = registry.get(id).judge(answer(id, *places)).hint
    assert hint.startswith("Two things, in this order")
    assert first in hint.split(" Then: ")[0] and then in hint.split(" Then: ")[1], hint


def test_a_slip_that_fits_by_chance_is_not_named():
    """Truth values that are all True fit many pairs of mistakes."""
    assert registry.get("17.2").judge(lambda nees, dof: [True] * nees.shape[1]).misconception.count("+") == 0


def test_a_column_is_called_so():
    cut = lambda P_0, x_0, l: np.array([[1, 0, x_0[1] - l[1]], [0, 1, l[0] - x_0[0]]]) @ P_0[:, :2]
    assert "Without effect in yours: column 2 of `P_0`" in registry.get("06.4").judge(cut).hint


def test_a_number_of_a_vector_is_called_so():
    assert any("Exchanged in yours: `l[0]` and `l[1]`." in slip.hint for slip in registry.get("06.4").slips())


def test_a_loop_over_one_of_several_is_told():
    exercise = registry.get("15.1")
    verdict = exercise.judge(lambda x, P, blocks, z, R: exercise.solution(x, P, blocks[:1], z, R))
    assert "only the first of `blocks` counted" in verdict.hint


def test_slips_of_a_solution_are_functions_and_none_stands_twice():
    found = registry.get("05.1").slips()
    assert len(found) == len({(s.body, s.user) for s in found}) > 300
    assert sum(s.answer is not None for s in found) > 0.9 * len(found)
    assert all("`" in s.hint and len(s.hint) < 500 for s in found)
    assert slips.slips(registry.get("05.1").solution, "    return (") == []


@pytest.mark.parametrize(
    ("got", "told"),
    [
        ([[1, 0, 3], [0, 1, 2]], "The entries at [0, 2], [1, 2] are exchanged."),
        ([[1, 0, -3], [0, 1, -2]], "The entries at [0, 2], [1, 2] are exchanged, and their sign is wrong."),
    ],
)
def test_entries_that_are_exchanged(got, told):
    assert diagnose(got, [[1, 0, 2], [0, 1, 3]]) == told


@pytest.mark.parametrize(
    ("want", "told"),
    [
        ([2.0, 1.0, 6.28, 0.5], "Wrong sign at [0], [1]."),  # the same numbers exchanged, but nothing says so
        ([1.0, -1.0, 6.28, 0.5], "The entries at [0], [1] are exchanged."),
        ([1.0, 1.0, 6.28, 0.5], "Wrong at [0], [1] only."),  # as like as not they were chosen so
    ],
)
def test_a_sign_is_no_exchange(want, told):
    assert diagnose(np.array(want) * [-1, -1, 1, 1], want) == told


def test_an_inverse_is_told():
    A = np.array([[2.0, 0.5], [0.5, 3.0]])
    assert diagnose(np.linalg.inv(A), A) == "Yours is the inverse."
