"""A sparse symmetric system in the order of time: each frame meets the one before it, and a border of what lasts."""

import numpy as np


class Chain:
    """Such a system, factorised frame by frame.

        [ D_0  C_1'            F_0 ]
        [ C_1  D_1  C_2'       F_1 ]
        [      C_2  D_2  ...   F_2 ]
        [           ...            ]
        [ F_0' F_1' F_2' ...   D   ]

    Elimination in the order of time leaves of each frame S_k, and how it meets the border, B_k:

        S_k = D_k - C_k S_k-1^-1 C_k',    B_k = F_k - C_k S_k-1^-1 B_k-1,    S = D - sum B_k' S_k^-1 B_k

    Parameters
    ----------
    M : sparse matrix, shape (N, N)
        Symmetric, not necessarily positive: but each S_k can be inverted.
    when : ndarray, shape (N,)
        Frame of each row, infinite for the border.

    Raises
    ------
    LinAlgError
        If it is singular.

    See Also
    --------
    is_chain : Whether a matrix is one.
    """

    def __init__(self, M, when):
        inner = np.isfinite(when)
        _, frame = np.unique(when[inner], return_inverse=True)
        size = np.bincount(frame)
        K, n, m = len(size), size.max(initial=0), len(when) - len(frame)
        order = np.argsort(frame, kind="stable")
        self.place = np.empty(len(when), int)  # of a row: its number in its frame, and frames follow each other
        self.place[np.flatnonzero(inner)[order]] = n * frame[order] + np.concatenate([np.arange(k) for k in [*size, 0]])
        self.place[~inner] = K * n + np.arange(m)

        M = M.tocoo()
        i, j, v = self.place[M.coords[0]], self.place[M.coords[1]], M.data
        D, C, F = np.zeros((K, n, n)), np.zeros((K, n, n)), np.zeros((K, n, m))
        D[:] = np.eye(n) * (np.arange(n) >= size[:, None])[:, None]  # frames are filled up to one size
        (f, a), (g, b) = np.divmod(i, max(n, 1)), np.divmod(j, max(n, 1))
        within, down = np.maximum(i, j) < K * n, np.maximum(i, j) >= K * n
        same, before, side = within & (f == g), within & (f == g + 1), down & (i < K * n)
        D[f[same], a[same], b[same]] = v[same]
        C[f[before], a[before], b[before]] = v[before]
        F[f[side], a[side], j[side] - K * n] = v[side]
        S, corner = np.zeros((m, m)), np.minimum(i, j) >= K * n
        S[i[corner] - K * n, j[corner] - K * n] = v[corner]

        self.S_inv, self.C, self.B = np.zeros_like(D), C, F
        for k in range(K):
            if k:
                G = C[k] @ self.S_inv[k - 1]
                D[k] -= G @ C[k].T
                F[k] -= G @ F[k - 1]
            self.S_inv[k] = np.linalg.inv(D[k])
        S -= np.einsum("kia,kib->ab", F, self.S_inv @ F, optimize=True)
        self.corner = np.linalg.inv(S)

    def solve(self, b):
        """Solve M x = b.

        Parameters
        ----------
        b : ndarray, shape (N,) or (N, c)

        Returns
        -------
        ndarray, of the same shape
        """
        K, n, m = self.B.shape
        whole = np.zeros((K * n + m, b[:1].size))
        whole[self.place] = b.reshape(len(b), -1)
        x, y = whole[: K * n].reshape(K, n, whole.shape[1]), whole[K * n :]
        for k in range(1, K):
            x[k] -= self.C[k] @ (self.S_inv[k - 1] @ x[k - 1])
        y[:] = self.corner @ (y - np.einsum("kim,kij,kjc->mc", self.B, self.S_inv, x, optimize=True))
        x -= self.B @ y
        for k in range(K - 1, -1, -1):
            if k < K - 1:
                x[k] -= self.C[k + 1].T @ x[k + 1]
            x[k] = self.S_inv[k] @ x[k]
        return whole[self.place].reshape(b.shape)

    def inverse_at(self, rows):
        """Blocks of the inverse, on its diagonal; they come back from the end.

        With N the next frame and the border, and W_k = S_k^-1 [C_k+1'  B_k]:

            Z_kk = S_k^-1 + W_k Z_NN W_k',    Z_kN = -W_k Z_NN

        K. Takahashi, J. Fagan, M.-S. Chin, "Formation of a sparse bus impedance matrix and its application to short
        circuit study", 1973.

        Parameters
        ----------
        rows : list of ndarray
            Rows of each block, all of one frame or all of the border.

        Returns
        -------
        list of ndarray
        """
        K, n, m = self.B.shape
        Z = np.zeros_like(self.S_inv)
        N = self.corner
        for k in range(K - 1, -1, -1):
            W = self.S_inv[k] @ (self.B[k] if k == K - 1 else np.hstack([self.C[k + 1].T, self.B[k]]))
            WN = W @ N
            Z[k] = self.S_inv[k] + WN @ W.T
            to_border = -WN[:, len(N) - m :]
            N = np.block([[Z[k], to_border], [to_border.T, self.corner]])
        places = [self.place[r] for r in rows]
        frame = lambda p: (self.corner, p - K * n) if p[0] >= K * n else (Z[p[0] // n], p % n)
        return [block[np.ix_(at, at)] for block, at in map(frame, places)]


def is_chain(M, when):
    """Return True if no frame meets another one than its neighbours."""
    when = np.where(np.isfinite(when), np.unique(when, return_inverse=True)[1], np.inf)
    i, j = M.nonzero()
    inner = np.isfinite(when[i] + when[j])
    i, j = i[inner], j[inner]
    return bool((np.abs(when[i] - when[j]) <= 1).all())
