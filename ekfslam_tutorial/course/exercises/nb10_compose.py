"""Exercise 10.2: a frame in a frame."""

import numpy as np

from ...geometry import q2qc, q2R, q_prod, unit  # noqa: F401
from ..table import table


def compose(F, G):
    """Express frame G, which is given in frame F, in the parent of F.

    F, G, shape (7,): frames [t, q]; t is the position, q = [a, b, c, d] the unit quaternion, local to global.
    Return the composed frame [t, q], shape (7,).
    """
    R, _ = q2R(F[3:])
    t = F[:3] + R @ G[:3]
    q, _, _ = q_prod(F[3:], G[3:])
    return np.concatenate([t, q])


def one_sign(x):
    """Return the frame with the one of q and -q whose largest entry is positive: both are the same rotation."""
    x = np.array(x, float)
    q = x[3:]
    return np.concatenate([x[:3], q * np.sign(q[np.argmax(np.abs(q))])])


def _signed(got, want):
    """The frame with the one of q and -q that is nearer to the one wanted."""
    x, q = got[0], got[0][3:]
    return [np.concatenate([x[:3], q if q @ want[0][3:] >= 0 else -q])]


def frame(rng, t=True, q=True):
    """Return some frame, without its step or its turn if so wanted."""
    x = np.concatenate([rng.uniform(-3, 3, 3), unit(rng.normal(size=4))[0]])
    return np.concatenate([x[:3] if t else np.zeros(3), x[3:] if q else [1, 0, 0, 0]])


LEFT = np.array([1.0, 2, 0, np.sqrt(0.5), 0, 0, np.sqrt(0.5)])  # turned a quarter to the left
AHEAD = np.array([3.0, 0, 0, 1, 0, 0, 0])


def _three(A, B, C):
    return [(compose(A, B), C), (A, compose(B, C))]


exercise = table(
    "10.2 A frame in a frame",
    compose,
    canonical=one_sign,
    settled=_signed,
    hints=(
        "Where is the origin of G, seen from the parent? It is a point of F: take it out of F.",
        "t = R_F t_G + t_F. For the rotation: a vector of G is turned by G first, then by F.",
        "R, _ = q2R(F[3:]); t = R @ G[:3] + F[:3]; q, _, _ = q_prod(F[3:], G[3:]).",
    ),
    returns="x",
    symbols="F = [t_F, q_F]; G = [t_G, q_G]; R_F = the rotation matrix of q_F",
    cases={
        "any": lambda rng: [(frame(rng), frame(rng)) for _ in range(4)],
        "not turned": lambda rng: [(frame(rng, q=False), frame(rng, q=False)) for _ in range(2)],
        "ahead": lambda rng: [(LEFT, AHEAD)],
        "one turned": lambda rng: [(frame(rng, q=False), frame(rng)), (frame(rng), frame(rng, q=False))] * 2,
        "three": lambda rng: _three(frame(rng), frame(rng), frame(rng)),
    },
    checks="""
    no rotation  | x[:3] | not turned | Two steps without a turn: the positions add.
    ahead        | x[:3] | ahead      | The position of G is a point of F: turn it by R_F, then add the position of F.
    position     | x[:3] | any        | The position of G is a point of F: turn it by R_F, then add the position of F.
    one turn     | x[3:] | one turned | A vector of G is turned by G first, then by F: q = q_F q_G. Quaternions are [a, b, c, d], the scalar part first.
    orientation  | x[3:] | any        | A vector of G is turned by G first, then by F: q = q_F q_G. Quaternions are [a, b, c, d], the scalar part first.
    points       | x     | one turned | Out of G, then out of F, must be the same as out of the composed frame.
    three frames | x     | three      | (A B) C must be A (B C).
    """,
    wrong="""
    frames swapped | R, _ = -> F, G = G, F; R, _ = | You put F into G: first out of G, then out of F, so F stands on the left.
    quaternions swapped | q_prod(F[3:], G[3:]) -> q_prod(G[3:], F[3:]) | The product of the quaternions is the wrong way round: q_F q_G.
    the position of F in G | t = F[:3] + R @ G[:3] -> t = G[:3] + q2R(G[3:])[0] @ F[:3] | You put the position of F into G. It is G that is given in F: t_F + R_F t_G.
    positions added | R @ G[:3] -> G[:3] | t_G is given in the axes of F: turn it with R_F before you add it.
    everything added | np.concatenate([t, q]) -> F + G | Frames cannot be added: turn t_G with R_F, and multiply the quaternions.
    position turned back | R @ G -> R.T @ G | You go out of F: R_F, not its transpose.
    turned by G | q2R(F[3:]) -> q2R(G[3:]) | The position of G is a point of F: it is turned by F, not by G.
    the wrong position is turned | F[:3] + R @ G[:3] -> R @ F[:3] + G[:3] | t_F is in the parent already. It is t_G that must be turned, by R_F.
    product entry by entry | q, _, _ = q_prod(F[3:], G[3:]) -> q = F[3:] * G[3:] | The product of two quaternions is q_prod, not `*`.
    quaternions added | q, _, _ = q_prod(F[3:], G[3:]) -> q = F[3:] + G[3:] | Two rotations one after the other: multiply the quaternions, q_prod.
    added and normalised | q, _, _ = q_prod(F[3:], G[3:]) -> q = unit(F[3:] + G[3:])[0] | A sum of quaternions is some rotation between the two. Multiply: q_prod.
    a conjugate too many | G[3:]) -> q2qc(G[3:])[0]) | With the conjugate of q_G you turn back. Local to global: q_F q_G.
    scalar part last | [t, q] -> [t, np.roll(q, -1)] | q = [a, b, c, d]: the scalar part comes first, in the result, too.
    scalar part moved to the end | R, _ = q2R(F[3:]) -> R, _ = q2R(np.roll(F[3:], -1)) | q2R takes [a, b, c, d], the scalar part first, as the frames have it: nothing is rolled.
    scalar part moved to the end, in the product, too | R, _ = q2R(F[3:]) -> R, _ = q2R(np.roll(F[3:], -1)) | q2R and q_prod take [a, b, c, d], the scalar part first, as the frames have it: nothing is rolled.
        q_prod(F[3:], G[3:]) -> q_prod(np.roll(F[3:], -1), np.roll(G[3:], -1))
    orientation of F kept | q, _, _ = q_prod(F[3:], G[3:]) -> q = F[3:] | G is turned in F: a vector of G is turned by G first, then by F. So q = q_F q_G, not q_F alone.
    orientation of G kept | q, _, _ = q_prod(F[3:], G[3:]) -> q = G[3:] | F is turned, too: a vector of G is turned by G first, then by F. So q = q_F q_G, not q_G alone.
    conjugate of the left factor | q_prod(F[3:], -> q_prod(q2qc(F[3:])[0], | With the conjugate of q_F you turn back. Local to global: q_F q_G.
    position of F forgotten | F[:3] + R -> R | The origin of F is not that of the parent: add t_F.
    position of F turned, too | t = F[:3] + R @ G[:3] -> t = R @ (F[:3] + G[:3]) | F stands in the parent already: turn the position of G alone, then add that of F.
    position with a minus | F[:3] + R @ G[:3] -> F[:3] - R @ G[:3] | From the parent to F, and on to G: the two ways add up, t_F + R_F t_G.
    quaternion first | [t, q] -> [q, t] | A frame is [t, q]: the position comes first, in the result, too.
    turned by the whole orientation | R, _ = q2R(F[3:]) -> R, _ = q2R(q_prod(F[3:], G[3:])[0]) | t_G is a point of F: it is turned by F alone, not by what comes of both.
    turned by the heading only | R, _ = q2R(F[3:]) -> yaw = np.arctan2(2 * (F[3] * F[6] + F[4] * F[5]), 1 - 2 * (F[5] ** 2 + F[6] ** 2)); R, _ = q2R(np.array([np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)])) | In space a frame is turned about three axes: all of R_F turns the position, not its heading alone.
    the axis of G turned | return np.concatenate([t, q]) -> return np.concatenate([t, q_prod(q, q2qc(F[3:])[0])[0]]) | q_F q_G q_F* is the turn of G about an axis that F has turned. The orientation is q_F q_G.
    into F instead of out of it, in both: You go out of F, for the position and for the orientation: R_F and q_F themselves, no transpose and no conjugate.
        R @ G[:3] -> R.T @ G[:3]
        q_prod(F[3:], -> q_prod(q2qc(F[3:])[0],
    """,
)
