"""Exercise 02.5: wrong and right answers. The wrong ones are the same loop with one thing broken."""

import numpy as np

from ...geometry import wrap
from .nb02_grow import add_landmark
from .nb02_h import h
from .nb02_q import landmark_of, q
from .nb02_step import information, map_step, step


def _z(y, e):
    return np.array([y[0] - e[0], wrap(y[1] - e[1])])


def _update(x, P, i, y, x_r, R, z_of=_z, R_of=lambda R: R, P_of=None, with_R=True):
    e, H = h(x, i, x_r)
    Z = H @ P @ H.T + (R_of(R) if with_R else 0)
    K = P @ H.T @ np.linalg.inv(Z)
    return x + K @ z_of(np.asarray(y), e), P - K @ H @ P if P_of is None else P_of(P, K, H)


def _looped(new, known):
    """map_step with other ways to treat new and known landmarks: functions of (x, P, ids, id, y, x_r, R)."""

    def answer(x, P, ids, seen, ys, x_r, R):
        ids = list(ids)
        for id, y in zip(seen, ys, strict=True):
            x, P, ids = (known if id in ids else new)(x, P, ids, id, y, x_r, R)
        return x, P, ids

    return answer


def _new(x, P, ids, id, y, x_r, R):
    return *add_landmark(x, P, y, x_r, R), [*ids, id]


def _correct(**changes):
    def known(x, P, ids, id, y, x_r, R):
        return *_update(x, P, ids.index(id), y, x_r, R, **changes), ids

    return known


def _then(new, known):
    def both(x, P, ids, id, y, x_r, R):
        return known(*new(x, P, ids, id, y, x_r, R), id, y, x_r, R)

    return both


def _restart(x, P, ids, id, y, x_r, R):
    i, x, P = 2 * ids.index(id), x.copy(), P.copy()
    x[i : i + 2], L_y = q(y, x_r)
    P[i : i + 2, i : i + 2] = L_y @ R @ L_y.T
    return x, P, ids


def _mean_of_two(x, P, ids, id, y, x_r, R):
    i, x = 2 * ids.index(id), x.copy()
    x[i : i + 2] = (x[i : i + 2] + landmark_of(y, x_r)) / 2
    return x, P, ids


WRONG = {
    "double counting": (
        "The landmark was started with this measurement and then updated with it: P is exactly half. Use `else`.",
        _looped(_then(_new, _correct()), _correct()),
    ),
    "no filtering": (
        "A known landmark is started anew at each sight: the star cloud. Combine old and new by the gain K.",
        _looped(_new, _restart),
    ),
    "known landmarks ignored": (
        "A known landmark stays as it was at first sight. Its new measurement must correct x and P.",
        _looped(_new, lambda x, P, ids, *_: (x, P, ids)),
    ),
    "known landmark added again": (
        "A known landmark was put into the map a second time. Look it up in `ids`.",
        _looped(_new, _new),
    ),
    "plain mean": (
        "Old and new are weighted equally, whatever P and R say. The gain K weighs them.",
        _looped(_new, _mean_of_two),
    ),
    "innovation reversed": (
        "z is measurement minus expectation, y - e. Yours pushes the landmark away.",
        _looped(_new, _correct(z_of=lambda y, e: _z(e, y))),
    ),
    "bearing not wrapped": (
        "At the seam the difference of two bearings jumps by 2 pi: z[1] = wrap(z[1]).",
        _looped(_new, _correct(z_of=lambda y, e: y - e)),
    ),
    "range wrapped, too": (
        "Only the bearing is an angle: do not wrap the range.",
        _looped(_new, _correct(z_of=lambda y, e: wrap(y - e))),
    ),
    "P not updated": (
        "x was corrected, P was not: P = (I - K H) P.",
        _looped(_new, _correct(P_of=lambda P, K, H: P)),
    ),
    "P grows": (
        "A measurement never makes the map more uncertain: P *minus* K H P.",
        _looped(_new, _correct(P_of=lambda P, K, H: P + K @ H @ P)),
    ),
    "P forgotten behind the bracket": (
        "(I - K H) must still be multiplied by P.",
        _looped(_new, _correct(P_of=lambda P, K, H: np.eye(len(P)) - K @ H)),
    ),
    "R missing in Z": (
        "Z = H P H' + R: without R the filter believes each measurement blindly.",
        _looped(_new, _correct(with_R=False)),
    ),
    "R squared": (
        "R holds variances already: do not square it.",
        _looped(_new, _correct(R_of=lambda R: R @ R)),
    ),
    "square root of R": (
        "R holds variances, and Z wants variances: no square root.",
        _looped(_new, _correct(R_of=lambda R: np.sqrt(np.abs(R)))),
    ),
    "diagonal of R": (
        "You used the diagonal of R only. R may have a covariance between range and bearing.",
        _looped(
            lambda x, P, ids, id, y, x_r, R: _new(x, P, ids, id, y, x_r, R),
            _correct(R_of=lambda R: np.diag(np.diag(R))),
        ),
    ),
}
for name, (text, answer) in WRONG.items():
    step.wrong(name, text)(answer)


@step.wrong("return inside the loop", "Only the first measurement is used: is the `return` inside the loop?")
def _(x, P, ids, seen, ys, x_r, R):
    return map_step(x, P, ids, seen[:1], ys[:1], x_r, R)


@step.wrong("only the last measurement", "Only the last measurement is used: is the update outside the loop?")
def _(x, P, ids, seen, ys, x_r, R):
    return map_step(x, P, ids, seen[-1:], ys[-1:], x_r, R)


@step.wrong(
    "ids not kept", "The map has grown, but `ids` has not: append the id of each new landmark, and return the list."
)
def _(x, P, ids, seen, ys, x_r, R):
    x, P, _ = map_step(x, P, ids, seen, ys, x_r, R)
    return x, P, list(ids)


@step.wrong("id taken for the index", "The id of a landmark is its name. Its place in x is ids.index(id).")
def _(x, P, ids, seen, ys, x_r, R):
    ids = list(ids)
    for id, y in zip(seen, ys, strict=True):
        if id in ids:
            x, P = _update(x, P, id % len(ids), y, x_r, R)
        else:
            x, P, ids = _new(x, P, ids, id, y, x_r, R)
    return x, P, ids


@step.wrong("motion noise in the map", "The landmarks do not move: the prediction adds nothing to P.")
def _(x, P, ids, seen, ys, x_r, R):
    return map_step(x, P + 0.01 * np.eye(len(P)), ids, seen, ys, x_r, R)


@step.variant("Joseph form, as lists")
def _(x, P, ids, seen, ys, x_r, R):
    def joseph(P, K, H):
        A = np.eye(len(P)) - K @ H
        return A @ P @ A.T + K @ R @ K.T

    x, P, ids = _looped(_new, _correct(P_of=joseph))(np.array(x), np.array(P), ids, seen, ys, x_r, R)
    return x.tolist(), P.tolist(), tuple(ids)


@step.variant("a filter of two states for each landmark")
def _(x, P, ids, seen, ys, x_r, R):
    x, P, ids = x.copy(), P.copy(), ids.copy()
    for id, y in zip(seen, ys, strict=True):
        if id in ids:
            i = ids.index(id)
            s = slice(2 * i, 2 * i + 2)
            x[s], P[s, s] = _update(x[s], P[s, s], 0, y, x_r, R)
        else:
            x, P = add_landmark(x, P, y, x_r, R)
            ids += [id]
    return x, P, ids


@step.variant("known landmarks in one stacked update, then the new ones")
def _(x, P, ids, seen, ys, x_r, R):
    old = [(ids.index(id), y) for id, y in zip(seen, ys, strict=True) if id in ids]
    if old:
        es, Hs = zip(*(h(x, i, x_r) for i, _ in old), strict=True)
        z, H = np.concatenate([_z(y, e) for (_, y), e in zip(old, es, strict=True)]), np.vstack(Hs)
        K = np.linalg.solve(H @ P @ H.T + np.kron(np.eye(len(old)), R), H @ P).T
        x, P = x + K @ z, (np.eye(len(x)) - K @ H) @ P
    new = [(id, y) for id, y in zip(seen, ys, strict=True) if id not in ids]
    for _, y in new:
        x, P = add_landmark(x, P, y, x_r, R)
    return x, P, ids + [id for id, _ in new]


@step.variant("information form")
def _(x, P, ids, seen, ys, x_r, R):
    x, P, ids = x.copy(), P.copy(), list(ids)
    for id, y in zip(seen, ys, strict=True):
        if id not in ids:
            x, P, ids = _new(x, P, ids, id, y, x_r, R)
            continue
        i = ids.index(id)
        s = slice(2 * i, 2 * i + 2)
        x[s], P[s, s] = information(x, P, i, y, x_r, R)
    return x, P, ids
