"""All innovations of a run as arrays, and what they say without a truth: likelihood, size, whiteness."""

from collections import defaultdict

import numpy as np


class Innovations:
    """Collector of the innovations of a run, those that the gate refused, too. A watcher, as `History` is."""

    def __init__(self):
        self._rows, self._sensors = defaultdict(list), {}

    def add(self, snapshot):
        """Keep those of one frame. Call it for each snapshot before the next one is drawn."""
        self._sensors = {rob.id: rob.sensors for rob in snapshot.robs}
        for o in snapshot.obs.values():
            if o.matched and o.z is not None:
                self._rows[o.sen].append((o.lmk, o.updated, np.array(o.z), o.E + o.R))

    def of(self, robot):
        """Innovations of a robot that were used, whitened: one landmark after the other, NaN between two.

        Only those of one landmark follow each other as independent numbers: the innovations of one frame are corrected
        together. Where sensors measure different numbers, they are those of the first one, and of its like.

        Returns
        -------
        ndarray, shape (K, m)
            Each landmark of each sensor in the order of time.
        """
        parts = []
        for rows in (self._rows[id] for id in self._sensors.get(robot, ()) if id in self._rows):
            lmk, used, w, _ = self._whiten(rows)
            parts += [w[used & (lmk == id)] for id in dict.fromkeys(lmk[used].tolist())]
        size = parts[0].shape[1] if parts else 0
        gap = np.full((1, size), np.nan)
        same = [part for one in parts if one.shape[1] == size for part in (one, gap)]
        return np.concatenate(same) if same else np.zeros((0, size))

    def whitened(self):
        """Innovations in units of what the filter expects, by sensor.

        Returns
        -------
        list of (lmk, used, w, logdet)
            lmk (N,), ids; used (N,), bool; w = L^-1 z (N, m), of which each number has the variance 1 in an honest
            filter, where L L' = Z; logdet (N,), log |Z|.
        """
        return [self._whiten(rows) for rows in self._rows.values()]

    @staticmethod
    def _whiten(rows):
        lmk, used, z, Z = (np.array(column) for column in zip(*rows, strict=True))
        L = np.linalg.cholesky(Z)
        w = np.linalg.solve(L, z[..., None])[..., 0]
        return lmk, used, w, 2 * np.log(np.diagonal(L, axis1=-2, axis2=-1)).sum(-1)

    def surprise(self, cap):
        """Mean of z' Z^-1 z + log |Z|: -2 log likelihood for an innovation, up to a constant.

        Parameters
        ----------
        cap : float
            A larger z' Z^-1 z counts as this: outliers must not decide.
        """
        parts = [np.minimum((w**2).sum(-1), cap) + logdet for _, _, w, logdet in self.whitened()]
        return float(np.concatenate(parts).mean())

    def __len__(self):
        return sum(map(len, self._rows.values()))

    def refused(self):
        """Share of those that the gate refused."""
        return 1 - sum(int(used.sum()) for _, used, _, _ in self.whitened()) / max(len(self), 1)

    def size(self):
        """Mean of z' Z^-1 z per degree of freedom, of those used: 1 in an honest filter without a gate."""
        squares = [w[used] ** 2 for _, used, w, _ in self.whitened()]
        return float(sum(s.sum() for s in squares) / max(sum(s.size for s in squares), 1))

    def dof(self):
        """Mean size of an innovation."""
        return sum(w.size for _, _, w, _ in self.whitened()) / max(len(self), 1)

    def whiteness(self):
        """Correlation of each innovation with the next one of the same landmark; 0 in an honest filter.

        Returns
        -------
        r : float
            Mean of w_k' w_k+1 over mean of w' w, of those used.
        n : int
            Numbers that it was found from; chance makes it 1 / sqrt(n).
        """
        pairs: list = [np.zeros(0)]
        lengths: list = [np.zeros(0)]
        for lmk, used, w, _ in self.whitened():
            lmk, w = lmk[used], w[used]
            order = np.argsort(lmk, kind="stable")
            lmk, w = lmk[order], w[order]
            same = lmk[1:] == lmk[:-1]
            pairs.append((w[1:] * w[:-1])[same].ravel())
            lengths.append(w.ravel())
        products, squares = np.concatenate(pairs), np.concatenate(lengths) ** 2
        if not products.size:
            return float("nan"), 0
        return float(products.mean() / squares.mean()), products.size
