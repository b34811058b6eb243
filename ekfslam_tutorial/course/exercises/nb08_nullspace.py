"""Exercise 08.1: how many directions of the state the measurements say nothing about."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def observability(H, F):
    """Observability matrix, and the number of directions of the first state that no measurement can see.

    H = [H_0, H_1, ..., H_K]: Jacobian of all measurements made at time k, shape (m_k, n); m_k may differ.
    F = [F_0, ..., F_K-1]: Jacobian of the motion from time k to time k+1, shape (n, n).
    Return O, shape (m_0 + ... + m_K, n): what an error of the first state does to all measurements, in this order;
    and the number of invisible directions, a whole number from 0 (all is observable) to n.
    """
    rows, Phi = [H[0]], np.eye(H[0].shape[1])
    for H_k, F_k in zip(H[1:], F, strict=True):
        Phi = F_k @ Phi
        rows.append(H_k @ Phi)
    O = np.vstack(rows)
    return O, O.shape[1] - np.linalg.matrix_rank(O, tol=1e-8 * np.linalg.norm(O, 2))


hidden = Exercise(
    "08.1",
    "The directions that no measurement sees",
    observability,
    hints=(
        "An error dx_0 of the first state becomes F_0 dx_0, then F_1 F_0 dx_0 ... What does each H_k see?",
        "Stack H_0, H_1 F_0, H_2 F_1 F_0, ... to one matrix O. A direction v is invisible if O v = 0.",
        "The number of such directions is n minus the rank of O (np.linalg.matrix_rank); n is the number of columns.",
    ),
)


def system(rng, n, d, sizes):
    """Jacobians H, F of a made-up system in which d of the n directions are invisible from the first state on."""
    V = np.linalg.qr(rng.normal(size=(n, n)))[0]
    H, F, Phi = [], [], np.eye(n)
    for k, m in enumerate(sizes):
        if k:
            F.append(np.linalg.qr(rng.normal(size=(n, n)))[0] + 0.2 * np.triu(rng.normal(size=(n, n)), 1))
            Phi = F[-1] @ Phi
        seen = rng.normal(size=(m, n - d)) @ V[:, d:].T  # blind for V[:, :d]
        H.append(seen @ np.linalg.inv(Phi))
    return H, F


def _two(result, H):
    O, d = expect.results(result, "O", "d")
    O = expect.array(O, (sum(len(h) for h in H), H[0].shape[1]), "O")
    d = float(expect.array(d, (), "the number of invisible directions"))
    expect.true(d == round(d), f"the number of invisible directions is {d:.4g}: it must be a whole number")
    return O, int(d)


def _number(f, H, F, want, what):
    got = _two(f(H, F), H)[1]
    expect.true(got == want, f"you find {got} invisible directions {what}, it should be {want}")


# states, invisible directions, measurements at each time
CASES = ((6, 2, [3, 4, 5]), (5, 1, [2, 2, 2, 2]), (4, 0, [1, 2, 3]), (7, 3, [2, 2, 2, 2]), (5, 4, [2] * 3))


@hidden.link("two results", "The function must end with `return O, d`; O has the rows of all H, and n columns.")
def _(f, rng):
    for case in CASES:
        H, F = system(rng, *case)
        _two(f(H, F), H)


@hidden.link("first measurements", "H_0 sees the first state itself: these rows of O are H_0.", part=0)
def _(f, rng):
    for case in CASES:
        H, F = system(rng, *case)
        expect.close(_two(f(H, F), H)[0][: len(H[0])], H[0], "the rows of O for time 0")


@hidden.link("one motion", "H_1 sees the state at time 1, F_0 dx_0: these rows of O are H_1 F_0.", part=0)
def _(f, rng):
    for case in CASES:
        H, F = system(rng, *case)
        rows = slice(len(H[0]), len(H[0]) + len(H[1]))
        expect.close(_two(f(H, F), H)[0][rows], H[1] @ F[0], "the block of rows of O for time 1")


@hidden.link("several motions", "The first motion acts first, so it stands on the right: H_2 F_1 F_0.", part=0)
def _(f, rng):
    for case in CASES:
        H, F = system(rng, *case)
        expect.close(_two(f(H, F), H)[0], _stack(H, F, _chain), "O")


@hidden.link("one time only", "Only H_0 and no motion: d is n minus the rank of H_0.", part=1)
def _(f, rng):
    for n, d, m in ((5, 2, 7), (4, 0, 6), (5, 2, 3)):
        _number(f, *system(rng, n, d, [m]), d, f"in a {m} x {n} matrix H_0 of rank {n - d}")


@hidden.link("fewer rows than columns", "O v = 0 has n minus rank solutions, and n is the number of *columns*.", part=1)
def _(f, rng):
    _number(f, *system(rng, 7, 1, [2, 2]), 3, "in 4 rows for 7 states")
    _number(f, *system(rng, 6, 0, [1, 1, 2]), 2, "in 4 rows for 6 states")


@hidden.link("several times", "All measurements of all times together: the rank of the whole O.", part=1)
def _(f, rng):
    for case in CASES:
        _number(f, *system(rng, *case), case[1], f"of {case[0]}, over {len(case[2])} times")


@hidden.link("other units", "Compare the singular values with the largest of them: no fixed threshold.", part=1)
def _(f, rng):
    for scale in (1e-5, 1e5):
        H, F = system(rng, 6, 2, [3, 3, 3])
        _number(f, [scale * h for h in H], F, 2, f"with all H times {scale:g}")


@hidden.link("nothing is seen", "A matrix of zeros sees nothing: all n directions are invisible.", part=1)
def _(f, rng):
    _number(f, [np.zeros((2, 3)), np.zeros((2, 3))], [np.eye(3)], 3, "of 3, if all H are zero")


def _stack(H, F, product):
    return np.vstack([H[0]] + [H[k] @ product(F, k) for k in range(1, len(H))])


def _chain(F, k):
    Phi = np.eye(F[0].shape[0])
    for F_j in F[:k]:
        Phi = F_j @ Phi
    return Phi


def _other_order(F, k):
    Phi = np.eye(F[0].shape[0])
    for F_j in F[:k]:
        Phi = Phi @ F_j
    return Phi


def _rank(O):
    return np.linalg.matrix_rank(O, tol=1e-8 * np.linalg.norm(O, 2))


def _wrong(name, hint, O_of=None, d_of=None):
    """A misconception in the matrix, O_of(H, F), or in the number, d_of(O)."""

    @hidden.wrong(name, hint)
    def _(H, F):
        O = O_of(H, F) if O_of else _stack(H, F, _chain)
        return O, d_of(O) if d_of else O.shape[1] - _rank(O)


# fmt: off
_wrong("motion forgotten", "H_1 sees the state at time 1. In terms of the first state that is H_1 F_0.",
       lambda H, F: np.vstack(H))
_wrong("only the last motion", "From time 0 to time 2 there are two steps: H_2 F_1 F_0.",
       lambda H, F: _stack(H, F, lambda F, k: F[k - 1]))
_wrong("only the first motion", "From time 0 to time 2 there are two steps: H_2 F_1 F_0.",
       lambda H, F: _stack(H, F, lambda F, k: F[0]))
_wrong("motions in the wrong order", "The first motion acts first, so it stands on the right: F_1 F_0.",
       lambda H, F: _stack(H, F, _other_order))
_wrong("motion transposed", "dx_1 = F_0 dx_0: no transpose.",
       lambda H, F: _stack(H, [f.T for f in F], _chain))
_wrong("motion undone", "dx_1 = F_0 dx_0: you look back from the last state; no inverse here.",
       lambda H, F: _stack(H, [np.linalg.inv(f) for f in F], _chain))
_wrong("one time too early", "H_0 belongs to the first state itself: no F. H_1 gets F_0, H_2 gets F_1 F_0.",
       lambda H, F: np.vstack([h @ _chain(F, min(k + 1, len(F))) if F else h for k, h in enumerate(H)]))
_wrong("rank instead of what is missing", "That is the number of directions that *are* seen. Return n minus it.",
       d_of=_rank)
_wrong("rows instead of columns", "n is the number of columns, one for each state: O.shape[1], not len(O).",
       d_of=lambda O: len(O) - _rank(O))
_wrong("only singular values that are zero", "O may have fewer rows than columns: then there are invisible directions "
       "without a zero singular value. n minus the rank counts all.",
       d_of=lambda O: min(O.shape) - _rank(O))
_wrong("always three", "Three is the answer for SLAM in the plane. Compute it: n minus the rank of O.",
       d_of=lambda O: 3)
_wrong("fixed threshold", "A fixed threshold depends on the units. Compare with the largest singular value, as "
       "np.linalg.matrix_rank does.",
       d_of=lambda O: O.shape[1] - int(np.sum(np.linalg.svd(O, compute_uv=False) > 1e-3)))
# fmt: on


@hidden.variant("singular value decomposition, as lists")
def _(H, F):
    Phi, O = np.eye(H[0].shape[1]), H[0]
    for k in range(len(F)):
        Phi = F[k] @ Phi
        O = np.concatenate([O, H[k + 1] @ Phi])
    s = np.linalg.svd(O, compute_uv=False)
    return [O.tolist(), O.shape[1] - int(np.sum(s > 1e-9 * s.max()))]


@hidden.variant("null space of scipy")
def _(H, F):
    from scipy.linalg import null_space

    O = _stack(H, F, _chain)
    return O, null_space(O, rcond=1e-10).shape[1]


@hidden.variant("rank with numpy's own tolerance")
def _(H, F):
    Phi, O = np.eye(H[0].shape[1]), [H[0]]
    for A, B in zip(H[1:], F, strict=True):
        Phi = B @ Phi
        O += [A @ Phi]
    return np.vstack(O), Phi.shape[0] - np.linalg.matrix_rank(np.vstack(O))


@hidden.variant("backwards, Horner's rule")
def _(H, F):
    O = H[-1]
    for A, B in zip(H[-2::-1], F[::-1], strict=True):
        O = np.vstack([A, O @ B])
    return O, O.shape[1] - np.linalg.matrix_rank(O)
