"""Exercise 24.5: 1-point RANSAC."""

import numpy as np

from ..table import table
from .nb04_blocks import random_covariance


def agreeing(z, E, R, limit):
    """1-point RANSAC: the largest set of matches that one of them explains.

    z, shape (K, 2), are the innovations of K matches of one frame (px). E, shape (K, 2, K, 2), is the joint covariance
    of what was expected: E[j, :, i] is H_j P H_i', shape (2, 2). R, shape (2, 2), is the noise of each match.
    If the map were corrected by match i alone, the expectation of match j would move by E_ji (E_ii + R)^-1 z_i. The
    matches whose innovation is then shorter than `limit` (px) agree with match i.
    Return K truth values: the set of the match with which most agree; of the first such one, if there are several.
    """
    best = np.zeros(len(z), bool)
    for i in range(len(z)):
        move = E[:, :, i] @ np.linalg.solve(E[i, :, i] + R, z[i])
        agree = np.linalg.norm(z - move, axis=1) < limit
        if agree.sum() > best.sum():
            best = agree
    return best


def case(rng, K=6, bad=(), noise=0.3, shared=8.0, by=12.0):
    """Matches whose expectations share one error, as those of one camera do; some are wrong by many pixels."""
    shift = random_covariance(rng, 2, 1.0)
    shift = shared * shift / np.trace(shift)
    gain = rng.uniform(0.7, 1.3, (K, 1, 1)) * np.eye(2)
    own = np.array([0.02 * random_covariance(rng, 2, 1.0) for _ in range(K)])
    E = np.einsum("iab,bc,jdc->iajd", gain, shift, gain)
    E[np.arange(K), :, np.arange(K)] += own
    z = np.einsum("iab,b->ia", gain, np.linalg.cholesky(shift) @ rng.choice([-1.0, 1.0], 2) * 1.2)
    z = z + rng.normal(0, noise, (K, 2)) * 0.5
    for i in bad:
        z[i] += by * np.array([np.cos(i), np.sin(i)])
    return z, E, 0.25 * np.eye(2), 1.5


def rolled(rng, K=5):
    """The camera has rolled: each expectation moves in its own direction, so E_ji is not symmetric."""
    a = np.linspace(0.0, 2.0, K) + rng.uniform(-0.1, 0.1, K)
    turn = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]).transpose(2, 0, 1)
    E = 9.0 * np.einsum("iab,jcb->iajc", turn, turn)
    z = turn @ np.array([4.0, rng.uniform(2.0, 4.0)]) + rng.normal(0, 0.15, (K, 2))
    z[K // 2] = -z[K // 2]
    return z, E, 0.25 * np.eye(2), 1.5


def independent(rng, K=5):
    """Expectations without a common error: a match says nothing of the others."""
    E = np.zeros((K, 2, K, 2))
    E[np.arange(K), :, np.arange(K)] = 2.0 * np.eye(2)
    z = rng.uniform(0.2, 0.9, (K, 2)) * rng.choice([-1, 1], (K, 2))
    z[0] *= 6.0
    return z, E, 0.25 * np.eye(2), 1.5


def noisy(rng):
    """R as large as E: a match moves the others by half of its innovation only."""
    E = np.einsum("ab,ij->iajb", 4.0 * np.eye(2), np.ones((5, 5)))
    z = rng.uniform(4.0, 5.0) * np.ones((5, 2)) + rng.normal(0, 0.3, (5, 2))
    z[3:] *= 0.25  # these are explained by half a movement, the others by a whole one
    return z, E, np.diag([4.0, 4.0]), 1.9


def near_the_limit(rng, noise=1.0):
    """Matches around the place to which the first one moves them, just inside and just outside of the limit.

    The others, believed alone, explain none: the first set is the largest. By how far the first one moves them depends
    on R, a whole matrix: an R that is not the right one puts some of them on the other side of the limit.
    """
    limit = 1.5
    C, R = random_covariance(rng, 2, 1.0), random_covariance(rng, 2, 1.0)
    C, R = 12.0 * C / np.trace(C), noise * R / np.trace(R)
    a = rng.uniform(0, 2 * np.pi)
    place = 8 * limit * np.array([np.cos(a), np.sin(a)])
    around = a + np.arange(8) * np.pi / 4
    distance = limit * np.tile([0.97, 1.03], 4)[:, None]
    z = np.vstack(
        [(C + R) @ np.linalg.solve(C, place), place + distance * np.column_stack([np.cos(around), np.sin(around)])]
    )
    return z, np.einsum("ab,ij->iajb", C, np.ones((9, 9))), R, limit


def limits(rng):
    """Other limits, and one that is met exactly: by a camera that is known, no match moves."""
    z = np.array([[3.0, 0.0], [0.0, 4.0], [1.0, 0.0], [0.0, -2.0], [2.4, -2.6]])
    return [(z, np.zeros((5, 2, 5, 2)), np.eye(2), limit) for limit in (2.0, 3.0, 3.5, 5.0)]


def tie(rng):
    """Two sets of two: that of the first match counts."""
    z = np.array([[10.0, 0.0], [10.2, 0.1], [-10.0, 0.0], [-10.1, 0.2]])
    E = np.einsum("ab,ij->iajb", 60.0 * np.eye(2), np.ones((4, 4)))
    return z, E, 0.25 * np.eye(2), 1.5


consensus = table(
    "24.5 Which matches agree",
    agreeing,
    hints=(
        "Each match in turn is believed alone. What does that make of the others' innovations?",
        "move of match j: E_ji (E_ii + R)^-1 z_i, E_ji = E[j, :, i]. What is left is z_j - move. Count those shorter than the limit.",
        "E[:, :, i] has the shape (K, 2, 2): E[:, :, i] @ w are the moves of all matches at once, w = solve(E[i, :, i] + R, z[i]).",
    ),
    returns="good",
    symbols="z_i, z_j = the innovations of matches i and j",
    cases={
        "any": lambda rng: [case(rng, 6, (4,)), case(rng, 5, (0,)), case(rng, 7, (1, 5))],
        "all right": lambda rng: [case(rng, 6), case(rng, 4)],
        "rolled": lambda rng: [rolled(rng, K) for K in (4, 5, 6)],
        "independent": lambda rng: [independent(rng) for _ in range(2)],
        "noisy": lambda rng: [noisy(rng) for _ in range(3)],
        "near": lambda rng: [near_the_limit(rng, noise) for noise in (4.0, 9.0, 16.0)],
        "limit": limits,
        "tie": lambda rng: [tie(rng)],
        "few": lambda rng: [case(rng, 1), case(rng, 2)],
        "many": lambda rng: [case(rng, 12, (0, 3, 7, 8), by=8.0) for _ in range(3)],
    },
    checks="""
    all right              | good | all right   | The camera has moved: all innovations are long, and one match explains them all. All agree.
    some are wrong         | good | any         | If match i is believed, z_j - E_ji (E_ii + R)^-1 z_i is left of match j, and j agrees if that is shorter than the limit. Of the K sets found so the largest is asked for.
    much noise             | good | noisy       | R = E_ii = E_ji: match i moves each match, itself too, by half of z_i, E_ji (E_ii + R)^-1 z_i. What is left is compared with the limit, for i as for the others. The largest set has two of the five matches.
    near the limit         | good | near        | What is left of some is just below the limit, of others just above it. How far match i moves the others depends on E_ji, on E_ii and on the whole of R. Then the *length* of what is left counts, and the set of match i is what i explains.
    each its own direction | good | rolled      | E_ji = E[j, :, i] turns what match i shows into the direction of match j: its rows belong to j, its columns to i.
    a camera that is known | good | limit       | With E = 0 nothing moves: a match agrees where |z| is shorter than the limit; the limit itself is too long.
    nothing in common      | good | independent | Where E_ji is 0, match i does not move match j: what is left of j is its innovation.
    two sets alike         | good | tie         | Of two sets of the same size, that of the first match counts.
    one or two matches     | good | few         | One match or two: the rule is the same.
    many                   | good | many        | Twelve matches, four of them wrong: of the twelve sets, one for each match that is believed, the largest is asked for.
    """,
    wrong="""
    R forgotten | E[i, :, i] + R, -> E[i, :, i], | The match is noisy: (E_ii + R)^-1. Without R its noise is taken for a movement.
    R counted twice | E[i, :, i] + R, -> E[i, :, i] + 2 * R, | R stands in (E_ii + R)^-1 once, as it is: E_ii is the covariance of what was expected, without the noise.
    half of R | E[i, :, i] + R, -> E[i, :, i] + R / 2, | R stands in (E_ii + R)^-1 as it is: the whole of it, not a half.
    R squared | E[i, :, i] + R, -> E[i, :, i] + R @ R, | R holds variances already: do not square it.
    R entry by entry squared | E[i, :, i] + R, -> E[i, :, i] + R**2, | R holds variances already: do not square it.
    only the diagonal of R | E[i, :, i] + R, -> E[i, :, i] + np.diag(np.diag(R)), | Use the whole R: the noise of u and that of v may be correlated.
    the identity for R | E[i, :, i] + R, -> E[i, :, i] + np.eye(2), | The noise of the matches is R, not 1 px in u and in v.
    the short ones | move = E[:, :, i] @ np.linalg.solve(E[i, :, i] + R, z[i]) -> move = 0 * z | A long innovation is not wrong: the camera may have moved, and then all are long. Correct by one match first, then look at what is left.
    all moved alike | move = E[:, :, i] @ np.linalg.solve(E[i, :, i] + R, z[i]) -> move = z[i] | Match j does not move by z_i, but by E_ji (E_ii + R)^-1 z_i: that is less, and different for each.
    E_ij for E_ji | move = E[:, :, i] @ -> move = np.swapaxes(E[i], 0, 1) @ | The rows of E_ji belong to match j, its columns to match i: E[j, :, i].
    E_jj for E_ji | move = E[:, :, i] @ -> move = E[np.arange(len(z)), :, np.arange(len(z))] @ | What match i says of match j is in E_ji, their covariance; E_jj is the covariance of j with itself.
    E_jj in the gain: The gain is that of match i, which is believed: (E_ii + R)^-1, not (E_jj + R)^-1.
        move = E[:, :, i] @ np.linalg.solve(E[i, :, i] + R, z[i]) -> move = np.array([E[j, :, i] @ np.linalg.solve(E[j, :, j] + R, z[i]) for j in range(len(z))])
    match i left out | z - move, axis=1) < limit -> z - move, axis=1) < limit; agree[i] = False | Match i belongs to its own set, if what is left of it is shorter than the limit.
    votes of the others: The set of match i is what i explains. Yours counts by how many matches each one is explained.
        best = np.zeros(len(z), bool) -> sets, best = [], np.zeros(len(z), bool)
        agree.sum() > best.sum() -> sets.append(agree)
        return best -> return sets[np.argmax(np.sum(sets, axis=0))] if sets else best
    moved the wrong way | z - move -> z + move | The expectation moves *towards* what match i has measured: what is left of j is z_j - move.
    the move for what is left | np.linalg.norm(z - move, axis=1) -> np.linalg.norm(move, axis=1) | Compare what is *left* of match j, z_j - move, with the limit, not the move itself.
    the worst set | agree.sum() > best.sum() -> i == 0 or agree.sum() < best.sum() | The *largest* set counts.
    the last set | agree.sum() > best.sum() -> True | The largest set counts, not the last.
    the last of the largest | agree.sum() > best.sum() -> agree.sum() >= best.sum() | Of two sets of the same size the first one counts.
    all sets together | best = agree -> best = best | agree | One set: that of the best match. Together they hold nearly everything.
    limit squared | axis=1) < limit -> axis=1) < limit**2 | The limit is a length in pixels: compare it with the length, or both squared.
    length squared | np.linalg.norm(z - move, axis=1) < limit -> np.sum((z - move) ** 2, axis=1) < limit | The *length* of what is left is compared with the limit: take the root.
    each coordinate | np.linalg.norm(z - move, axis=1) < limit -> np.all(np.abs(z - move) < limit, axis=1) | The length of what is left counts, not each of u and v.
    the limit itself | axis=1) < limit -> axis=1) <= limit | Shorter than the limit: <, not <=.
    those that disagree | return best -> return ~best | True is for those that agree.
    how many | return best -> return best * best.sum() | Return a truth value for each match, not how many.
    the set that explains one match: The set of match i is what i explains: a row, if A[i, j] says that i explains j. Yours counts and returns by columns.
        best = np.zeros(len(z), bool) -> sets, best = [], np.zeros(len(z), bool)
        agree.sum() > best.sum() -> sets.append(agree)
        return best -> return np.array(sets)[:, np.argmax(np.sum(sets, axis=0))] if sets else best
    one match after the other: Each match is believed *alone*: it begins with the innovations z as they came, not with what another one has left of them.
        best = np.zeros(len(z), bool) -> best, z = np.zeros(len(z), bool), z.copy()
        z - move, axis=1) < limit -> z - move, axis=1) < limit; z -= move
    least sum of what is left: The largest set counts: ask how many agree, not how small all that is left is together. One wrong match would decide.
        best = np.zeros(len(z), bool) -> best, least = np.zeros(len(z), bool), np.inf
        agree.sum() > best.sum(): -> (total := np.linalg.norm(z - move, axis=1).sum()) < least:
        best = agree -> best, least = agree, total
    blocks mixed by reshape | best = np.zeros(len(z), bool) -> E, best = E.reshape(len(z), len(z), 2, 2).transpose(0, 2, 1, 3), np.zeros(len(z), bool) | E has the axes match, number, match, number: reshape mixes the numbers of different matches. E[j, :, i] is the block.
    """,
)
