"""Exercise 05.5: wrong and right answers. The wrong ones are the same loop with one thing broken."""

import numpy as np

from ...geometry import wrap
from .nb05_augment import augment
from .nb05_correct import correct
from .nb05_frame import frame, slam_frame
from .nb05_observe import observe
from .nb05_predict import predict


def _range(ids, id):
    k = 3 + 2 * list(ids).index(id)
    return slice(k, k + 2)


def _known(x, P, ids, id, y, R):
    return *correct(x, P, y, R, *observe(x, _range(ids, id))), ids


def _new(x, P, ids, id, y, R):
    return *augment(x, P, y, R), [*ids, id]


def _loop(known=_known, new=_new, first=predict):
    """slam_frame in one loop, with other ways to move, to treat known landmarks, and new ones."""

    def answer(x, P, ids, u, U, seen, ys, R):
        x, P, ids = *first(x, P, u, U), list(ids)
        for id, y in zip(seen, ys, strict=True):
            x, P, ids = (known if id in ids else new)(x, P, ids, id, np.asarray(y), R)
        return x, P, ids

    return answer


def _nothing(x, P, ids, id, y, R):
    return x, P, ids


def _at(place):
    """A correction that takes landmark k from another place of the state: place(k)."""

    def known(x, P, ids, id, y, R):
        k = min(place(list(ids).index(id)), len(x) - 2)
        return *correct(x, P, y, R, *observe(x, slice(k, k + 2))), ids

    return known


def _restart(x, P, ids, id, y, R):
    """The known landmark is thrown away and started anew."""
    l = _range(ids, id)
    keep = np.delete(np.arange(len(x)), l)
    a, S = augment(x[keep], P[np.ix_(keep, keep)], y, R)
    order = np.insert(np.arange(len(a) - 2), l.start, [len(a) - 2, len(a) - 1])
    return a[order], S[np.ix_(order, order)], ids


def _wrong(name, hint, answer):
    frame.wrong(name, hint)(answer)


# fmt: off
_wrong("double counting", "The measurement that starts a landmark is used up. Your loop corrects with it once more, "
       "and P_ll is too small: use `else`.",
       _loop(new=lambda x, P, ids, id, y, R: _known(*_new(x, P, ids, id, y, R), id, y, R)))
_wrong("prediction forgotten", "The robot has moved: begin with predict(x, P, u, "
       "U).", _loop(first=lambda x, P, u, U: (x, P)))
_wrong("mean moved, covariance not", "predict returns both x and P: take both.",
       _loop(first=lambda x, P, u, U: (predict(x, P, u, U)[0], P)))
_wrong("covariance moved, mean not", "predict returns both x and P: take both.",
       _loop(first=lambda x, P, u, U: (x, predict(x, P, u, U)[1])))
_wrong("known landmarks not used", "A landmark that is in ids corrects the whole state: observe, then correct.",
       _loop(known=_nothing))
_wrong("new landmarks not started", "A landmark that is not in ids comes into the state: augment, and remember its id.",
       _loop(new=_nothing))
_wrong("every sight is a new landmark", "A landmark that is in ids is known: do not start it again, correct with it.",
       _loop(known=_new))
_wrong("known landmarks started anew", "A known landmark is corrected, with all that is known of it: do not replace "
       "it.",
       _loop(known=_restart))
_wrong("id not remembered", "Put the id of a new landmark at the end of ids, as augment puts the landmark at the end "
       "of x.",
       _loop(new=lambda x, P, ids, id, y, R: (*augment(x, P, y, R), ids)))
_wrong("id put in front", "augment puts the new landmark at the end of x: put its id at the end of ids, too.",
       _loop(new=lambda x, P, ids, id, y, R: (*augment(x, P, y, R), [id, *ids])))
_wrong("robot forgotten in the range", "The robot has the first three numbers: landmark k begins at 3 + 2 k.",
       _loop(known=_at(lambda k: 2 * k)))
_wrong("one number for a landmark", "Each landmark has two numbers: landmark k begins at 3 + 2 k.",
       _loop(known=_at(lambda k: 3 + k)))
_wrong("counted from one", "Python counts from 0: the first landmark in ids has the range 3:5.",
       _loop(known=_at(lambda k: 5 + 2 * k)))
_wrong("R squared", "R is a covariance already: hand it on as it is.",
       lambda x, P, ids, u, U, seen, ys, R: slam_frame(x, P, ids, u, U, seen, ys, R**2))
_wrong("ids as the order of sight", "Where a landmark is in the state is said by ids, not by its place in `seen`.",
       lambda x, P, ids, u, U, seen, ys, R: _by_place(x, P, ids, u, U, seen, ys, R))
_wrong("only the first landmark in view", "Use all measurements: is `return` inside the loop?",
       lambda x, P, ids, u, U, seen, ys, R: slam_frame(x, P, ids, u, U, seen[:1], ys[:1], R))
_wrong("only the last landmark in view", "Use all measurements: does each correction start from the x and P of the one "
       "before?",
       lambda x, P, ids, u, U, seen, ys, R: slam_frame(x, P, ids, u, U, seen[-1:], ys[-1:], R))
# fmt: on


def _by_place(x, P, ids, u, U, seen, ys, R):
    x, P, ids = *predict(x, P, u, U), list(ids)
    for i, (id, y) in enumerate(zip(seen, ys, strict=True)):
        known = _at(lambda k, i=i: 3 + 2 * i) if id in ids else _new
        x, P, ids = known(x, P, ids, id, y, R)
    return x, P, ids


@frame.wrong("the robot moves for each landmark", "The robot moves once in a frame: predict stands before the loop.")
def _(x, P, ids, u, U, seen, ys, R):
    ids = list(ids)
    for id, y in zip(seen, ys, strict=True):
        x, P = predict(x, P, u, U)
        x, P, ids = (_known if id in ids else _new)(x, P, ids, id, y, R)
    return (x, P, ids) if len(seen) else (*predict(x, P, u, U), ids)


@frame.wrong("the robot moves last", "The measurements were taken after the step: predict comes first.")
def _(x, P, ids, u, U, seen, ys, R):
    x, P, ids = _loop(first=lambda x, P, u, U: (x, P))(x, P, ids, u, U, seen, ys, R)
    return *predict(x, P, u, U), ids


@frame.wrong("all observed before the first correction", "A correction moves robot and landmarks: observe the next "
             "landmark from the new x. With the old e the same error is corrected twice.")  # fmt: skip
def _(x, P, ids, u, U, seen, ys, R):
    x, P = predict(x, P, u, U)
    expected = {id: observe(x, _range(ids, id)) for id in seen if id in ids}
    ids = list(ids)
    for id, y in zip(seen, ys, strict=True):
        if id in expected:
            x, P = correct(x, P, y, R, *expected[id])
        else:
            x, P, ids = _new(x, P, ids, id, y, R)
    return x, P, ids


@frame.variant("one loop, new landmarks as they come")
def _(x, P, ids, u, U, seen, ys, R):
    return _loop()(x, P, ids, u, U, seen, ys, R)


@frame.variant("new landmarks first")
def _(x, P, ids, u, U, seen, ys, R):
    x, P = predict(x, P, u, U)
    old, ids = set(ids), list(ids)
    for id, y in sorted(zip(seen, ys, strict=True), key=lambda pair: pair[0] in old):
        x, P, ids = (_known if id in old else _new)(x, P, ids, id, y, R)
    return x, P, ids


@frame.variant("all known landmarks in one correction, lists and an array of ids")
def _(x, P, ids, u, U, seen, ys, R):
    x, P = predict(x, P, u, U)
    known = [i for i, id in enumerate(seen) if id in ids]
    if known:
        rows = [observe(x, _range(ids, seen[i])) for i in known]
        H = np.vstack([H for _, H in rows])
        z = np.concatenate([[ys[i][0] - e[0], wrap(ys[i][1] - e[1])] for i, (e, _) in zip(known, rows, strict=True)])
        K = np.linalg.solve(H @ P @ H.T + np.kron(np.eye(len(known)), R), H @ P).T
        x, P = x + K @ z, P - K @ H @ P
        P = (P + P.T) / 2
    for i, id in enumerate(seen):
        if i not in known:
            x, P = augment(x, P, ys[i], R)
            ids = [*ids, id]
    return x.tolist(), P.tolist(), np.array(ids)


@frame.variant("in the opposite order, heading not wrapped")
def _(x, P, ids, u, U, seen, ys, R):
    x, P, ids = slam_frame(x, P, ids, u, U, seen[::-1], ys[::-1], R)
    x[2] += 2 * np.pi
    return x, P, ids
