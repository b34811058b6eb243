"""What lines share: a line is seen as a plane through the eye, and remembered as a stretch between two ends.

A line type says `normal(l)`, the normal of the plane through the origin in which it lies, and `support(l)`, a point of
the line and its direction. The rest is written here, once for all types: where the ends are of what has been seen of
a line, and how far a line is from the true one. The ends are no states. They are parameters of the landmark (manual:
Lmk.par), two abscissas t: the points p0 + t d of the line.
"""

from typing import Any

import numpy as np

from ...geometry import hat, unit


def vector_product(a, b):
    """Vector product c = a x b. Returns c, C_a, C_b."""
    return np.cross(a, b), -hat(b), hat(a)


def plane_base(n):
    """Two unit vectors in the plane of the unit normal n, e1 without a part along z. Returns e1, e2, E1_n, E2_n."""
    e1, E1_c = unit(np.cross(n, [0.0, 0.0, 1.0]))
    E1_n = E1_c @ -hat(np.array([0.0, 0.0, 1.0]))
    e2, C_n, C_e1 = vector_product(n, e1)
    return e1, e2, E1_n, C_n + C_e1 @ E1_n


def ends(lmk, l, t):
    """Points p0 + t d of lines, for two abscissas each.

    Parameters
    ----------
    lmk : LmkType
        A line type.
    l : ndarray, shape (..., lmk.size)
    t : ndarray, shape (..., 2)

    Returns
    -------
    p : ndarray, shape (..., 2, 3)
    P_l : ndarray, shape (..., 2, 3, lmk.size)

    See Also
    --------
    abscissas : The inverse, from where they are seen.
    """
    p0, d, P0_l, D_l = lmk.support(l)
    p = p0[..., None, :] + t[..., None] * d[..., None, :]
    return p, P0_l[..., None, :, :] + t[..., None, None] * D_l[..., None, :, :]


def abscissas(lmk, l, c, m):
    """Abscissas t where lines pass nearest to two rays each: from the point c into the directions m, shape (..., 2, 3).

    See Also
    --------
    ends : The points of these abscissas.
    """
    p0, d, *_ = lmk.support(l)
    w, d = c - p0[..., None, :], d[..., None, :]
    dd, dm, mm, wd, wm = ((a * b).sum(-1) for a, b in ((d, d), (d, m), (m, m), (w, d), (w, m)))
    return (wd * mm - wm * dm) / (dd * mm - dm**2)


def offsets(lmk, l, a, b):
    """Error of a line, if the true one goes through a and b: its four degrees of freedom, in metres.

    In the plane across the true line at a, and in that at b, two coordinates of the point where the line goes through:

        e_a = B' (p0 + s d - a),    s = u' (a - p0) / u' d

    u is the direction from a to b, and B two directions across it. A line has no scale, and slides along itself for
    nothing: so whatever a type stores, the error of a line is these four numbers.

    Parameters
    ----------
    lmk : LmkType
    l : ndarray, shape (lmk.size,)
    a, b : ndarray, shape (3,)
        Two points of the true line.

    Returns
    -------
    e : ndarray, shape (4,)
    E_l : ndarray, shape (4, lmk.size)
    """
    p0, d, P0_l, D_l = lmk.support(l)
    u = unit(np.subtract(b, a))[0]
    B = np.linalg.svd(u[None])[2][1:]
    along = np.eye(3) - np.outer(d, u) / (u @ d)  # slide along the line until across at the point
    e, E_l = [], []
    for q in (a, b):
        s = u @ (q - p0) / (u @ d)
        e.append(B @ (p0 + s * d - q))
        E_l.append(B @ along @ (P0_l + s * D_l))
    return np.concatenate(e), np.concatenate(E_l)


class TwoPoints:
    """A line through two points of one type, stored one behind the other; an anchor they share is stored once.

    A line type that inherits says which points, `kind`, and how many numbers of their anchor they share, `anchor`. All
    the line can do follows from what the points can do.

    See Also
    --------
    IdpLin, HmgLin, AhmLin : Those of the package.
    PlkLin : A line without points.
    """

    dim = 3
    kind: Any
    anchor: int

    @property
    def size(self):
        """Length of the state."""
        return 2 * self.kind.size - self.anchor

    def _parts(self):
        """Selections (k, size) of the first point's and of the second point's state."""
        k, rows = self.kind.size, np.eye(self.size)
        return rows[:k], np.concatenate([rows[: self.anchor], rows[k:]])

    def _joined(self):
        """Derivatives (size, k) of the line's state by those of its points."""
        S1, S2 = self._parts()
        J2 = S2.T.copy()
        J2[:, : self.anchor] = 0  # the anchor is the first point's
        return S1.T, J2

    def _change(self, transform, l):
        (S1, S2), (J1, J2) = self._parts(), self._joined()
        a, A_f, A_l = transform(l @ S1.T)
        b, B_f, B_l = transform(l @ S2.T)
        return a @ J1.T + b @ J2.T, J1 @ A_f + J2 @ B_f, J1 @ A_l @ S1 + J2 @ B_l @ S2

    def to_frame(self, F, l):
        """Both points in frame F. Returns l_F, LF_f, LF_l.

        See Also
        --------
        from_frame : The inverse.
        """
        return self._change(lambda point: self.kind.to_frame(F, point), l)

    def from_frame(self, F, l):
        """Both points of frame F in its parent. Returns l, L_f, L_lf.

        See Also
        --------
        to_frame : The inverse.
        """
        return self._change(lambda point: self.kind.from_frame(F, point), l)

    def normal(self, l):
        """n = u1 x u2 of the images u = v / v_z of both points. Returns n, N_l.

        The scale of n means nothing for a line; it decides, by the size of its covariance, who is corrected first.

        See Also
        --------
        from_rays : The inverse.
        """
        (u1, U1_l), (u2, U2_l) = (self._image(l, S) for S in self._parts())
        n, N_u1, N_u2 = vector_product(u1, u2)
        return n, N_u1 @ U1_l + N_u2 @ U2_l

    def _image(self, l, S):
        v, V_p = self.kind.ray(l @ S.T)
        u = v / v[..., 2:]
        U_v = (np.eye(3) - u[..., :, None] * np.eye(3)[2]) / v[..., 2:, None]
        return u, U_v @ V_p @ S

    def support(self, l):
        """The first point p1, and the way p2 - p1 to the second. Returns p0, d, P0_l, D_l."""
        (p1, P1), (p2, P2) = (self.kind.point(l @ S.T) for S in self._parts())
        P1, P2 = (P @ S for P, S in zip((P1, P2), self._parts(), strict=True))
        return p1, p2 - p1, P1, P2 - P1

    def from_rays(self, v, n):
        """Line seen along two rays v = [v1; v2], n = [n1, n2] the prior inverse distances. Returns l, L_v, L_n.

        See Also
        --------
        normal : The inverse.
        """
        J1, J2 = self._joined()
        a, A_v, A_n = self.kind.from_ray(v[..., :3], n[..., :1])
        b, B_v, B_n = self.kind.from_ray(v[..., 3:], n[..., 1:])
        return a @ J1.T + b @ J2.T, np.concatenate([J1 @ A_v, J2 @ B_v], -1), np.concatenate([J1 @ A_n, J2 @ B_n], -1)
