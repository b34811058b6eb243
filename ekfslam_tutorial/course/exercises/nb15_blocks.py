"""Exercise 15.1: one correction of a map that holds any number of robots, sensors and landmarks."""

import numpy as np

from .. import expect
from ..table import table
from .nb04_blocks import random_covariance


def correct_blocks(x, P, blocks, z, R):
    """Correct the whole map with one measurement, whoever has made it.

    x, shape (n,), and P, shape (n, n), are the map: robots, sensors and landmarks, all in one state. blocks is a list
    of pairs (r, E_r), one for each state that the measurement depends on: r is the slice of that state in x, and E_r,
    shape (m, k), the derivative of the expected measurement by it. r is None where that state is known: it is not in
    the map. z, shape (m,), is the innovation, and R, shape (m, m), the covariance of the noise.
    Return the new x, shape (n,), and the new P, shape (n, n).
    """
    H = np.zeros((len(z), len(x)))
    for r, E_r in blocks:
        if r is not None:
            H[:, r] = E_r
    Z = H @ P @ H.T + R
    K = np.linalg.solve(Z, H @ P).T
    return x + K @ z, P - K @ H @ P


A, B, L = slice(0, 3), slice(3, 6), slice(6, 8)  # two robots in the plane and a landmark, in one map


def case(rng, n=8, m=2, slices=(A, B), none=False):
    """A map with correlated states, blocks in some slices, an innovation and its noise."""
    blocks = [(r, rng.normal(size=(m, r.stop - r.start))) for r in slices]
    if none:
        blocks.insert(1, (None, rng.normal(size=(m, 7))))
    R = random_covariance(rng, m, 0.5)
    return 4 * rng.normal(size=n), random_covariance(rng, n), blocks, rng.normal(size=m), R


def as_expected(x, P, blocks, z, R):
    """The same with a measurement that is the expected one."""
    return x, P, blocks, 0 * z, R


def uncorrelated(x, P, blocks, z, R):
    """The same with states that are not correlated."""
    return x, np.diag(np.diag(P)), blocks, z, R


exercise = table(
    "15.1 One correction for all",
    correct_blocks,
    hints=(
        "Build the Jacobian of the whole map, H: zeros, with each E_r in the columns of its slice.",
        "for r, E_r in blocks: skip r = None, else H[:, r] = E_r. Then it is the EKF that you know, with all of P.",
        "Z = H @ P @ H.T + R; K = P @ H.T @ inv(Z); x + K @ z; P - K @ H @ P.",
    ),
    returns="x, P",
    cases={
        "any": lambda rng: [
            case(rng, 8, 2, (A, B)),
            case(rng, 8, 2, (L, A)),
            case(rng, 8, 1, (B,)),
            case(rng, 11, 3, (slice(8, 11), A, B)),
        ],
        "z = 0": lambda rng: [as_expected(*case(rng))],
        "diagonal": lambda rng: [uncorrelated(*case(rng, m=m)) for m in (2, 1)],
        "known": lambda rng: [case(rng, slices=slices, none=True) for slices in ((A, L), (B,))],
    },
    checks="""
    no surprise         | x | z = 0    | The new x has the shape of x. Where z = 0 the measurement was what was expected: x stays, P shrinks.
    uncorrelated states | x | diagonal | P is diagonal here. H, the derivative by the whole map, has each E_r in the columns of its own slice. Z = H P H' + R, K = P H' inv(Z), and the new x is x + K z.
    a correlated map    | x, P | any      | The states are correlated: Z = H P H' + R and K = P H' inv(Z) take all blocks of P, and K has a row for each state. The new x is x + K z, the new P is P - K Z K' (or Joseph's form, with + K R K').
    known states        | x, P | known    | r = None: this state is known, it is not in the map and has no columns in H: skip it. All other blocks count as they do without it.
    """,
    wrong="""
    innovation turned round | x + K @ z -> x - K @ z | z is measured minus expected: x + K z.
    noise forgotten | H.T + R -> H.T | Z = H P H' + R: the measurement has noise of its own.
    R squared | H.T + R -> H.T + R @ R | R is a covariance already: add it as it is.
    only the variances of R | H.T + R -> H.T + np.diag(np.diag(R)) | R has off-diagonal entries: the numbers of a measurement may be correlated.
    correlations in P ignored | H @ P @ H.T -> H @ np.diag(np.diag(P)) @ H.T | Z and K take all of P: what two robots know of each other is in the off-diagonal blocks.
    first block alone in Z | Z = H @ P @ H.T + R -> Z = next((E_r @ (H @ P)[:, r].T for r, E_r in blocks if r is not None), 0) + R | Z = H P H' + R with all blocks in H: what the first block alone adds is a part of it.
    separate filters | H @ P @ H.T -> H @ _block_diagonal(P, H) @ H.T | That treats the robots as strangers: Z = H P H' + R with all of P, the covariance between them, too.
    only what was seen moves | return x + -> K = np.any(H != 0, axis=0)[:, None] * K; return x + | A state that was not seen moves, too, if it is correlated with one that was: K has a row for every state.
    P not corrected | P - K @ H @ P -> P | A correction makes P smaller: P - K H P.
    K R K' taken off | P - K @ H @ P -> P - K @ R @ K.T | P falls by K Z K' with the whole Z = H P H' + R, not by K R K'.
    Z left out | P - K @ H @ P -> P - K @ K.T | P falls by K Z K', which is K H P: Z stands between the two gains.
    K H taken off | P - K @ H @ P -> P - K @ H | K H has no unit: P - K H P.
    P grows | P - K @ H -> P + K @ H | Information is gained: P - K H P.
    gain without inverse | np.linalg.solve(Z, H @ P).T -> P @ H.T @ Z | K = P H' inv(Z): Z must be inverted.
    covariances between robots dropped | P - K @ H @ P -> _block_diagonal(P - K @ H @ P, H) | The new P has blocks between all states: do not keep the diagonal ones only.
    known states take the first columns | if r is not None: -> if True: | A known state (r = None) has no columns in H: skip it.
        H[:, r] = E_r -> H[:, slice(E_r.shape[1]) if r is None else r] = E_r[:, : len(x)]
    columns in the order of the blocks | in blocks: -> in _in_order(blocks): | Each E_r belongs in the columns of its slice r: H[:, r] = E_r.
    one block after the other | return x + K @ z, P - K @ H @ P -> return _one_by_one(x, P, blocks, z, R) | One measurement, one correction. Using it once for each block counts it several times.
    added up | H[:, r] = E_r -> H[:, : E_r.shape[1]] += E_r | Each state has columns of its own in H: do not add the blocks.
    each state by its own block of P: Z and K take all of P: Z has the covariance between two states in it, and K has a row for each state that is correlated with them.
        H @ P @ H.T -> H @ _own_blocks(P, blocks) @ H.T
        np.linalg.solve(Z, H @ P) -> np.linalg.solve(Z, H @ _own_blocks(P, blocks))
    gain by the own block of P | np.linalg.solve(Z, H @ P) -> np.linalg.solve(Z, H @ _own_blocks(P, blocks)) | K = P H' inv(Z) with all of P: the rows of a state take its covariance with *all* states that were measured, not its own block of P alone.
    R counted twice | H.T + R -> H.T + 2 * R | The noise of a measurement counts once, however many states it depends on: Z = H P H' + R.
    Joseph without the noise | P - K @ H @ P -> (np.eye(len(x)) - K @ H) @ P @ (np.eye(len(x)) - K @ H).T | The new P is P - K Z K', or (I - K H) P with (I - K H) once. With it on both sides, as in Joseph's form, a second term belongs there: + K R K'.
    stops at a known state | in blocks: -> in blocks[: next((i for i, (r, _) in enumerate(blocks) if r is None), len(blocks))]: | Only the block of the known state (r = None) is skipped, those behind it count, too: `continue` goes on with them.
    only the last block kept | H[:, r] = E_r -> H[:] = 0; H[:, r] = E_r | H is made once, before the loop: each block comes into it, and none is lost.
    R once for each block | Z = H @ P @ H.T + R -> Z = H @ P @ H.T + R * max(1, sum(r is not None for r, _ in blocks)) | The measurement has its noise once, whatever the number of states it depends on: Z = H P H' + R.
    a known state with a covariance | Z = H @ P @ H.T + R -> Z = H @ P @ H.T + R + sum(E_r @ E_r.T for r, E_r in blocks if r is None) | A known state (r = None) has no error: it adds nothing to Z.
    factors in the wrong order | P - K @ H @ P -> P - P @ K @ H | The order matters: P - K H P, that is (I - K H) P.
    only the diagonal of Z | np.linalg.solve(Z, H @ P) -> np.linalg.solve(np.diag(np.diag(Z)), H @ P) | The numbers of a measurement are correlated: use the whole Z.
    measurement for innovation | x + K @ z -> x + K @ (z - H @ x) | z is the innovation already: do not subtract H x from it.
    each cross term once | Z = H @ P @ H.T + R -> Z = R + sum((E_r @ P[r, s] @ E_s.T for a, (r, E_r) in enumerate(blocks) for s, E_s in blocks[a:] if r is not None and s is not None), 0 * R) | Each pair of states comes twice in H P H', E_1 P_12 E_2' and its transpose.
    R once for each pair | H @ P @ H.T + R -> H @ P @ H.T + R * max(1, sum(r is not None for r, _ in blocks)) ** 2 | The measurement has its noise once, whatever the number of pairs of states: + R outside of the loop.
    """,
    forms="""
    gain by the inverse | np.linalg.solve(Z, H @ P).T -> P @ H.T @ np.linalg.inv(Z) | K = P H' inv(Z)
    P - K Z K' | P - K @ H @ P -> P - K @ Z @ K.T | P - K Z K'
    Joseph | P - K @ H @ P -> (np.eye(len(P)) - K @ H) @ P @ (np.eye(len(P)) - K @ H).T + K @ R @ K.T | of Joseph
    """,
)


@exercise.link(
    "a shared landmark",
    "Two robots have seen one landmark, one after the other: the covariance between them, P_12, comes of that. The new P is symmetric and has no negative eigenvalue.",
    part=1,
)
def _(f, rng):
    x, P, R = rng.normal(size=6), np.diag([1.0, 1, 2, 2, 9, 9]), 0.01 * np.eye(2)
    for robot in (slice(0, 2), slice(2, 4)):  # each measures the place of the landmark relative to itself
        blocks = [(robot, -np.eye(2)), (slice(4, 6), np.eye(2))]
        x, P = expect.results(f(x, P, blocks, rng.normal(size=2), R), "x", "P")
        x, P = expect.array(x, 6, "x"), expect.array(P, (6, 6), "P")
    shared = np.abs(P[:2, 2:4]).max()
    expect.true(shared > 0.1, "both robots have seen one landmark, and their covariance is still zero")
    expect.symmetric(P, "P", 1e-7)
    expect.psd(P, "P", 1e-7)


def _block_diagonal(P, H):
    """P without the covariances between states that H joins with others; seen columns only."""
    seen = np.any(H != 0, axis=0)
    edges = {0, 3, 6, len(P), *(np.flatnonzero(np.diff(seen.astype(int))) + 1)}
    edges, out = sorted(e for e in edges if e <= len(P)), np.zeros_like(P)
    for start, stop in zip(edges[:-1], edges[1:], strict=True):
        out[start:stop, start:stop] = P[start:stop, start:stop]
    return out


def _own_blocks(P, blocks):
    """P without the covariances between the states that a measurement depends on, and without the others."""
    out = np.zeros_like(P)
    for r, _ in blocks:
        if r is not None:
            out[r, r] = P[r, r]
    return out


def _in_order(blocks):
    """The blocks with slices one behind the other."""
    start = 0
    for r, E_r in blocks:
        if r is not None:
            yield slice(start, start + E_r.shape[1]), E_r
            start += E_r.shape[1]


def _one_by_one(x, P, blocks, z, R):
    for block in blocks:
        x, P = correct_blocks(x, P, [block], z, R)
    return x, P
