"""Exercise 15.1: one correction of a map that holds any number of robots, sensors and landmarks."""

import numpy as np

from .. import expect
from ..exercise import Exercise
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


exercise = Exercise(
    "15.1",
    "One correction for all",
    correct_blocks,
    hints=(
        "Build the Jacobian of the whole map, H: zeros, with each E_r in the columns of its slice.",
        "for r, E_r in blocks: skip r = None, else H[:, r] = E_r. Then it is the EKF that you know, with all of P.",
        "Z = H @ P @ H.T + R; K = P @ H.T @ inv(Z); x + K @ z; P - K @ H @ P.",
    ),
)

A, B, L = slice(0, 3), slice(3, 6), slice(6, 8)  # two robots in the plane and a landmark, in one map


def case(rng, n=8, m=2, slices=(A, B), none=False):
    """A map with correlated states, blocks in some slices, an innovation and its noise."""
    blocks = [(r, rng.normal(size=(m, r.stop - r.start))) for r in slices]
    if none:
        blocks.insert(1, (None, rng.normal(size=(m, 7))))
    R = random_covariance(rng, m, 0.5)
    return rng.normal(size=n), random_covariance(rng, n), blocks, rng.normal(size=m), R


def _out(result, n):
    x, P = expect.results(result, "x", "P")
    return expect.array(x, n, "x"), expect.array(P, (n, n), "P")


@exercise.link("two results", "The function must end with `return x, P`: the whole map, as large as before.")
def _(f, rng):
    _out(f(*case(rng)), 8)
    _out(f(*case(rng, 5, 1, (slice(2, 4),))), 5)


@exercise.link("no surprise", "z = 0: the measurement was what was expected. x stays, P shrinks.", part=0)
def _(f, rng):
    x, P, blocks, z, R = case(rng)
    expect.close(_out(f(x, P, blocks, 0 * z, R), 8)[0], x, "x", at="z = 0")


@exercise.link("uncorrelated states", "Each E_r goes into the columns of its own slice.", part=0)
def _(f, rng):
    for m in (2, 1):
        x, P, blocks, z, R = case(rng, m=m)
        args = x, np.diag(np.diag(P)), blocks, z, R
        expect.close(_out(f(*args), 8)[0], correct_blocks(*args)[0], "x", at="a diagonal P")


@exercise.link("a correlated map", "Z = H P H' + R has the cross terms, and K = P H' inv(Z) has a row for each state.")
def _(f, rng):
    for n, m, slices in ((8, 2, (A, B)), (8, 2, (L, A)), (8, 1, (B,)), (11, 3, (slice(8, 11), A, B))):
        args = case(rng, n, m, slices)
        for got, want, name in zip(_out(f(*args), n), correct_blocks(*args), "xP", strict=True):
            expect.close(got, want, name, at=f"blocks in {', '.join(f'{r.start}:{r.stop}' for r in slices)}")


@exercise.link("known states", "r = None: this state is not in the map. It has no columns in H: skip it.")
def _(f, rng):
    for slices in ((A, L), (B,)):
        args = case(rng, slices=slices, none=True)
        got = _out(f(*args), 8)
        for a, b, name in zip(got, correct_blocks(*args), "xP", strict=True):
            expect.close(a, b, name, at="a block with r = None")


@exercise.link(
    "a shared landmark", "Robots that have seen one landmark are correlated: P_12 must not stay zero.", part=1
)
def _(f, rng):
    P, R = np.zeros((6, 6)), 0.01 * np.eye(2)
    P[:2, :2], P[2:4, 2:4], P[4:, 4:] = np.eye(2), 2 * np.eye(2), 9 * np.eye(2)
    x = rng.normal(size=6)
    for robot in (slice(0, 2), slice(2, 4)):  # each measures the place of the landmark relative to itself
        blocks = [(robot, -np.eye(2)), (slice(4, 6), np.eye(2))]
        x, P = _out(f(x, P, blocks, rng.normal(size=2), R), 6)
    expect.true(
        np.abs(P[:2, 2:4]).max() > 0.1, "both robots have seen one landmark, and their covariance is still zero"
    )
    expect.symmetric(P, "P", 1e-7)
    expect.psd(P, "P", 1e-7)


def _H(x, blocks, m, order=None):
    H = np.zeros((m, len(x)))
    for r, E_r in blocks:
        if r is not None:
            H[:, r] = E_r
    return H


def _wrong(name, hint, step):
    """A misconception in the EKF: step(x, P, H, z, R) returns x and P."""

    @exercise.wrong(name, hint)
    def _(x, P, blocks, z, R):
        return step(x, P, _H(x, blocks, len(z)), z, R)


def _plain(x, P, H, z, R, Z=None, PHt=None, sign=1.0, P_new=None):
    """One EKF step with parts replaced."""
    Z = H @ P @ H.T + R if Z is None else Z
    PHt = P @ H.T if PHt is None else PHt
    K = PHt @ np.linalg.pinv(Z)
    return x + sign * K @ z, P - K @ H @ P if P_new is None else P_new(P, K)


def _block_diagonal(P, H):
    """P without the covariances between states that H joins with others; seen columns only."""
    seen = np.any(H != 0, axis=0)
    out, start = np.zeros_like(P), 0
    edges = [0, *np.flatnonzero(np.diff(seen.astype(int))) + 1, len(P)]
    edges = sorted({*edges, *(e for e in (3, 6) if e < len(P))})
    for start, stop in zip(edges[:-1], edges[1:], strict=True):
        out[start:stop, start:stop] = P[start:stop, start:stop]
    return out


# fmt: off
_wrong("innovation turned round", "z is measured minus expected: x + K z.", lambda *a: _plain(*a, sign=-1.0))
_wrong("noise forgotten", "Z = H P H' + R: the measurement has noise of its own.",
       lambda x, P, H, z, R: _plain(x, P, H, z, R, Z=H @ P @ H.T))
_wrong("R squared", "R is a covariance already: add it as it is.",
       lambda x, P, H, z, R: _plain(x, P, H, z, R, Z=H @ P @ H.T + R @ R))
_wrong("only the variances of R", "R has off-diagonal entries: the numbers of a measurement may be correlated.",
       lambda x, P, H, z, R: _plain(x, P, H, z, R, Z=H @ P @ H.T + np.diag(np.diag(R))))
_wrong("correlations in P ignored", "Z and K take all of P: what two robots know of each other is in the off-diagonal "
       "blocks.", lambda x, P, H, z, R: _plain(x, P, H, z, R, Z=H @ np.diag(np.diag(P)) @ H.T + R))
_wrong("separate filters", "That treats the robots as strangers: Z needs E_a P_ab E_b', the covariance between them.",
       lambda x, P, H, z, R: _plain(x, P, H, z, R, Z=H @ _block_diagonal(P, H) @ H.T + R))
_wrong("only what was seen moves", "A state that was not seen moves, too, if it is correlated with one that was: K has "
       "a row for every state.",
       lambda x, P, H, z, R: _plain(x, P, H, z, R, PHt=np.any(H != 0, axis=0)[:, None] * (P @ H.T)))
_wrong("P not corrected", "A correction makes P smaller: P - K H P.", lambda *a: _plain(*a, P_new=lambda P, K: P))
_wrong("P grows", "Information is gained: P - K H P.",
       lambda x, P, H, z, R: _plain(x, P, H, z, R, P_new=lambda P, K: P + K @ H @ P))
_wrong("gain without inverse", "K = P H' inv(Z): Z must be inverted.",
       lambda x, P, H, z, R: _plain(x, P, H, z, R, Z=np.linalg.inv(H @ P @ H.T + R)))
_wrong("covariances between robots dropped", "The new P has blocks between all states: do not keep the diagonal ones "
       "only.", lambda x, P, H, z, R: (_plain(x, P, H, z, R)[0],
                                       _block_diagonal(_plain(x, P, H, z, R)[1], H)))
# fmt: on


@exercise.wrong("known states take the first columns", "A known state (r = None) has no columns in H: skip it.")
def _(x, P, blocks, z, R):
    H = np.zeros((len(z), len(x)))
    for r, E_r in blocks:
        H[:, : min(E_r.shape[1], len(x)) if r is None else None][:, r if r is not None else slice(None)] = (
            E_r[:, : len(x)] if r is None else E_r
        )
    return _plain(x, P, H, z, R)


@exercise.wrong(
    "columns in the order of the blocks", "Each E_r belongs into the columns of its slice r: H[:, r] = E_r."
)
def _(x, P, blocks, z, R):
    H = np.zeros((len(z), len(x)))
    E = np.hstack([E_r for r, E_r in blocks if r is not None])
    H[:, : E.shape[1]] = E
    return _plain(x, P, H, z, R)


@exercise.wrong("one block after the other", "One measurement, one correction. Using it once for each block counts it "
                "several times.")  # fmt: skip
def _(x, P, blocks, z, R):
    for block in blocks:
        if block[0] is not None:
            x, P = correct_blocks(x, P, [block], z, R)
    return x, P


@exercise.variant("block by block")
def _(x, P, blocks, z, R):
    PHt = np.zeros((len(x), len(z))) + sum(P[:, r] @ np.asarray(E).T for r, E in blocks if r is not None)
    Z = np.asarray(R) + sum(np.asarray(E) @ PHt[r] for r, E in blocks if r is not None)
    K = PHt @ np.linalg.inv(Z)
    return list(x + K @ z), (P - K @ Z @ K.T).tolist()


@exercise.variant("Joseph form")
def _(x, P, blocks, z, R):
    H = _H(x, blocks, len(z))
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    J = np.eye(len(x)) - K @ H
    return x + K @ z, J @ P @ J.T + K @ R @ K.T


@exercise.variant("information form")
def _(x, P, blocks, z, R):
    H = _H(x, blocks, len(z))
    new = np.linalg.inv(np.linalg.inv(P + 1e-12 * np.eye(len(x))) + H.T @ np.linalg.solve(R, H))
    return x + new @ H.T @ np.linalg.solve(R, z), new
