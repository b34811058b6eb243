"""A smoother beside the filter: all states of a run at once, by Gauss and Newton's way on the sparse graph of it.

The filter knows at each frame what was measured until then, and linearises once. The smoother knows all that was
measured in the whole run, and linearises anew until nothing moves. Where the models are linear, both agree in the last
frame.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from scipy.sparse import block_array, coo_array
from scipy.sparse.linalg import splu

from .chain import Chain, is_chain
from .factors import Birth, Graph, Motion, Prior, innovations, linearised

COLUMNS = 256
"""So many columns of the inverse are computed at a time."""
LASTING = 100
"""So many numbers of landmarks and mountings, and what is told of them, count as few."""
SMALL = 1e-10
"""A step that changes no number by more is the last one: m, rad, or the unit of the number."""


@dataclass(frozen=True)
class Smoothed:
    """Result of a smoother.

    Parameters
    ----------
    graph : Graph
        At the estimate.
    steps : list of float
        The largest change of a number in each step of Gauss and Newton.
    P : dict
        Covariance of each variable, by key.
    system : object
        What was solved last, for `joint`.
    """

    graph: Graph
    steps: list
    P: dict
    system: Any

    @property
    def converged(self):
        """True if the last step has changed nothing."""
        return self.steps[-1] <= SMALL

    def joint(self, keys):
        """Covariance of some variables together: what one tells of the other, too.

        Parameters
        ----------
        keys : list of tuple
            As in `Graph.values`. After `smooth_lagged`, of the last states only: older ones are marginalised.

        Returns
        -------
        ndarray, shape (n, n)
            In the order of the keys.

        Raises
        ------
        ValueError
        """
        for key in keys:
            if key not in self.system.at:
                raise ValueError(f"{key} is no variable of the last system that was solved")
        return self.system.joint(keys)

    def track(self, robot):
        """States of a robot and their covariances, of the start and after each frame.

        Returns
        -------
        x : ndarray, shape (F + 1, n)
        P : ndarray, shape (F + 1, n, n)
        """
        keys = [("robot", robot, k) for k in range(len(self.graph.t))]
        return np.array([self.graph.values[key] for key in keys]), np.array([self.P[key] for key in keys])

    def filtered(self, robot):
        """The same of the filter: what it knew after each frame."""
        x, P = zip(*[self.graph.filtered["robot", robot, k] for k in range(len(self.graph.t))], strict=True)
        return np.array(x), np.array(P)

    def landmarks(self):
        """Landmarks: id -> point and its covariance, metres."""
        found = {}
        for key, l in self.graph.values.items():
            if key[0] == "landmark":
                p, P_l = self.graph.types[key[1]].point(l)
                found[key[1]] = p, P_l @ self.P[key] @ P_l.T
        return found


def smooth(graph, iterations=50, after_step=lambda: None, enough=SMALL):
    """Find the most probable values of all variables, and their covariances.

    Factors of covariance Q = G C G' that may be singular stand in the system with a multiplier v each, and the others,
    H = J' R^-1 J and g = J' R^-1 z, as usual:

        [ -Q  A ] [v ]   [ -r ]
        [  A' H ] [dx] = [  g ],    w = C G' v

    The block of the inverse at dx is the covariance. With Q regular it is (H + A' Q^-1 A)^-1, as F. Dellaert,
    M. Kaess, "Factor Graphs for Robot Perception", 2017, section 2.

    Parameters
    ----------
    graph : Graph
        From `graph_of`; its values are moved.
    iterations : int
        At most so many steps.
    after_step : callable
        Called after each step, and once more when the covariances are known.
    enough : float
        A step that changes no number by more is the last one.

    Returns
    -------
    Smoothed

    Raises
    ------
    ValueError
        If the factors do not fix all variables.

    See Also
    --------
    smooth_lagged : Only the last states are moved.
    """
    steps = []
    while len(steps) < iterations and (not steps or steps[-1] > enough):
        steps.append(_step(graph, graph.stiff, graph.looks))
        after_step()
    system = System(graph, list(graph.values), graph.stiff, graph.looks)
    P = system.marginals()
    after_step()
    return Smoothed(graph, steps, P, system)


def smooth_lagged(graph, lag, iterations=3):
    """Smooth with a fixed lag: at each frame the last states and the map are moved, older states stay as they left.

    A state leaves `lag` frames after it came, and knows what was measured until then. It is marginalised: what the
    factors at it say of the others becomes a prior of these, of mean and covariance. With the lag of the whole run
    nothing leaves, and it is `smooth`.

    Parameters
    ----------
    graph : Graph
        From `graph_of`; its values are moved.
    lag : int
        Frames, 1 or more.
    iterations : int
        Steps of Gauss and Newton in each frame.

    Returns
    -------
    Smoothed

    Raises
    ------
    ValueError
    """
    if lag < 1:
        raise ValueError(f"the lag is a number of frames, 1 or more, got {lag}")
    guess, P, steps = dict(graph.values), {}, []
    priors, factors, looks = _by_frame(graph)
    graph.values = {key: guess[key] for prior in priors for key in prior.keys}
    last, oldest = len(graph.t) - 1, 0
    for k in range(1, last + 1):
        for factor in factors[k]:
            factor.w = 0.0
            if isinstance(factor, Motion):
                graph.values[factor.after] = guess[factor.after]
                graph.values[factor.after] = guess[factor.after] - factor.linear(graph)[0]  # where the step leads
        graph.move({key: np.zeros(len(guess[key])) for key in graph.values if key[0] == "robot" and key[2] == k})
        new = {key for look in [*looks[k], *factors[k]] for key in _lmks(look)} - set(graph.values)
        graph.values |= {key: guess[key] for key in sorted(new)}
        window = range(oldest, k + 1)
        inside = [*priors, *(f for i in window for f in factors[i] if i > oldest or not isinstance(f, Motion))]
        seen = [look for i in window for look in looks[i]]
        for _ in range(iterations):
            moved = _step(graph, inside, seen)
        steps.append(moved)
        system = System(graph, list(graph.values), inside, seen)
        while k - oldest >= lag:
            gone = [key for key in system.at if key[0] == "robot" and key[2] == oldest]
            P |= system.marginals(gone)
            guess |= {key: graph.values[key] for key in gone}
            priors = [_marginalised(graph, gone, priors, factors, looks, oldest)]
            for key in gone:
                del graph.values[key]
            oldest += 1
    P |= system.marginals([key for key in system.at if key in graph.values])
    graph.values = {key: graph.values.get(key, guess[key]) for key in guess}
    return Smoothed(graph, steps, P, system)


def _by_frame(graph):
    """Priors; and lists, by frame, of what else there is."""
    factors, looks = ([[] for _ in graph.t] for _ in range(2))
    for factor in graph.stiff:
        if not isinstance(factor, Prior):
            factors[factor.after[2] if isinstance(factor, Motion) else factor.k].append(factor)
    for look in graph.looks:
        looks[look.k].append(look)
    return [factor for factor in graph.stiff if isinstance(factor, Prior)], factors, looks


def _lmks(factor):
    keys = [factor.lmk] if isinstance(factor, Birth) else getattr(factor, "lmks", [])
    return [key for key in keys if isinstance(key, tuple) and key[0] == "landmark"]


def _marginalised(graph, gone, priors, factors, looks, k):
    """Join what the priors, the measurements of frame k and the steps from it say of all that stays: one prior."""
    steps = [f for f in factors[k + 1] if isinstance(f, Motion)]
    inside = [*priors, *(f for f in factors[k] if not isinstance(f, Motion)), *steps]
    keys = {key: None for prior in priors for key in prior.keys}
    keys |= dict.fromkeys(gone) | {f.after: None for f in steps}
    keys |= {key: None for f in [*looks[k], *factors[k]] for key in _lmks(f)}
    system, stays = System(graph, list(keys), inside, looks[k]), [key for key in keys if key not in gone]
    d, at = system.step(), np.concatenate([system.at[key] for key in stays])
    return Prior(stays, np.concatenate([graph.values[key] for key in stays]) + d[at], system.joint(stays))


def _step(graph, stiff, looks):
    """One step of Gauss and Newton; return the largest change of a number."""
    system = System(graph, list(graph.values), stiff, looks)
    d = system.step()
    graph.move({key: d[at] for key, at in system.at.items()})
    return float(np.abs(d).max())


class System:
    """The system at the present values, factorised.

    Parameters
    ----------
    graph : Graph
    keys : list of tuple
        The variables.
    stiff, looks : list
        The factors.

    Attributes
    ----------
    at : dict of tuple to ndarray
        Which numbers of the step are those of a variable.
    A, Q, J : sparse matrices
    r, z : ndarray
        Residuals of the stiff factors, and innovations, whitened.
    noise : list of (factor, C G', slice)
        Rows of A of a stiff factor.
    seen : list of (look, int, ndarray, slice)
        Rows of J of one measurement of a look, and what whitens it.
    """

    def __init__(self, graph, keys, stiff, looks):
        ends = np.cumsum([0, *(len(graph.values[key]) for key in keys)]).tolist()
        self.at = {key: np.arange(a, b) for key, a, b in zip(keys, ends, ends[1:], strict=False)}
        start, n = dict(zip(keys, ends, strict=False)), ends[-1]
        A, Q, r, when, self.noise = _Blocks(), _Blocks(), [], [], []
        row = 0
        for factor, e, blocks, G, C in linearised(graph, stiff):
            Q.add(row, row, G @ C @ G.T)
            for key, block in blocks.items():
                A.add(row, start[key], block)
            r.append(-e)
            when += [max(map(_frame, blocks))] * len(e)
            self.noise.append((factor, C @ G.T, slice(row, row + len(e))))
            row += len(e)
        J, z, rows, self.seen = _Blocks(), [np.zeros(0)], 0, []
        for innovation, R, each, whose in innovations(graph, looks):
            whiten = np.linalg.cholesky(np.linalg.inv(R)).swapaxes(1, 2)
            for one, W, blocks, (look, i) in zip(innovation, whiten, each, whose, strict=True):
                for key, block in blocks.items():
                    J.add(rows, start[key], W @ block)
                z.append(W @ one)
                self.seen.append((look, i, W, slice(rows, rows + len(one))))
                rows += len(one)
        self.A, self.Q, self.J = A, Q, J = A.matrix(row, n), Q.matrix(row, row), J.matrix(rows, n)
        self.r, self.z, self.n = -np.concatenate(r), np.concatenate(z), n
        self.b = np.concatenate([-self.r, J.T @ self.z])
        when = np.array(when + [_frame(key) for key in keys for _ in self.at[key]])
        try:
            self.factorised = _factorised(block_array([[-Q, A], [A.T, J.T @ J]], format="csc"), when, stiff)
        except (RuntimeError, np.linalg.LinAlgError) as error:
            raise ValueError("the factors do not fix all variables: their matrix is singular") from error

    def step(self):
        """The step dx; the factors learn the noise w that makes them fit."""
        found = self.factorised.solve(self.b)
        for factor, CG, rows in self.noise:
            factor.w = CG @ found[rows]
        return found[-self.n :]

    def columns(self, some):
        """Some columns of the covariance of all variables, shape (n, k)."""
        E = np.zeros((len(self.b), len(some)))
        E[len(self.b) - self.n + np.asarray(some), np.arange(len(some))] = 1.0
        return self.factorised.solve(E)[-self.n :]

    def joint(self, keys):
        """Covariance of some variables together."""
        at = np.concatenate([self.at[key] for key in keys])
        P = self.columns(at)[at]
        return (P + P.T) / 2

    def marginals(self, keys=None):
        """Covariances of some variables, of all if not given, by key."""
        at = self.at if keys is None else {key: self.at[key] for key in keys}
        if isinstance(self.factorised, Chain):
            P = self.factorised.inverse_at([len(self.b) - self.n + a for a in at.values()])
        else:
            P = self._blocks_by_columns(list(at.values()))
        return {key: (Q + Q.T) / 2 for key, Q in zip(at, P, strict=True)}

    def _blocks_by_columns(self, at):
        blocks, some = [], []
        for k, a in enumerate(at):
            some.append(a)
            if sum(map(len, some)) >= COLUMNS or k == len(at) - 1:
                C = self.columns(np.concatenate(some))
                ends = np.cumsum([0, *map(len, some)])
                blocks += [C[a, i:j] for a, i, j in zip(some, ends, ends[1:], strict=False)]
                some = []
        return blocks


def _factorised(M, when, stiff):
    """Factorise the system: frame by frame if few numbers last, else as the library finds it best.

    A prior of several variables, which marginalisation leaves, may be all that fixes a frame: then the library, too.
    """
    one_by_one = all(len(factor.keys) == 1 for factor in stiff if isinstance(factor, Prior))
    few = (when == np.inf).sum() <= LASTING
    return Chain(M, when) if few and one_by_one and is_chain(M, when) else splu(M)


def _frame(key):
    """Frame of a variable; infinite for landmarks and mountings, which last."""
    return key[2] if key[0] == "robot" else np.inf


class _Blocks:
    """Blocks of a sparse matrix."""

    def __init__(self):
        self._i, self._j, self._v = [], [], []

    def add(self, i, j, block):
        """Add a block whose first number is in row i and column j."""
        r, c = _indices(block.shape)
        self._i.append(i + r)
        self._j.append(j + c)
        self._v.append(block.ravel())

    def matrix(self, rows, columns):
        """The sparse matrix; what is in one place is summed."""
        i, j, v = (np.concatenate([np.zeros(0, int), *parts]) for parts in (self._i, self._j, self._v))
        return coo_array((v, (i, j)), shape=(rows, columns)).tocsr()


@cache
def _indices(shape):
    return tuple(a.ravel() for a in np.indices(shape))
