"""Answers to the exercises of notebook 14 that are in no list of the package."""

import numpy as np

from .collector import answer_to, check_of

# --- 14.2: the same in other words ---


@answer_to("14.2", right=True)
def with_masks(ids, known, n_inits):
    ids = np.asarray(ids)
    old = np.isin(ids, known) & (ids >= 0)
    return np.flatnonzero(old), np.flatnonzero(~old & (ids >= 0))[:n_inits]


@answer_to("14.2", right=True)
def in_one_walk(ids, known, n_inits):
    old, new, there = [], [], {int(i) for i in known}
    for place, id in enumerate(ids):
        if int(id) in there and id != -1:
            old.append(place)
        elif id != -1 and len(new) < n_inits:
            new.append(place)
    return old, new


# --- 14.1: the same in other words ---


@answer_to("14.1", right=True)
def by_trying_every_start(used, k):
    for s in range(len(used) + 1):
        if not any(used[s : s + k]) and (s + k <= len(used) or not any(used[s:])):
            return [s, s + k]


@answer_to("14.1", right=True)
def as_text(used, k):
    text = "".join("1" if u else "0" for u in used)
    s = text.find("0" * int(k))
    s = len(text.rstrip("0")) if s < 0 else s
    return np.array([s, s + k], dtype=float)


@answer_to("14.1", hint="index \\+ 1")
def behind_the_last_but_one(used, k):
    for s in range(len(used) - k + 1):
        if not any(used[s : s + k]):
            return [s, s + k]
    last = max((i for i, u in enumerate(used) if u), default=0)
    return [last, last + k]


@answer_to("14.2", hint="one too many")
def one_landmark_too_many(ids, known, n_inits):
    old = [i for i, id in enumerate(ids) if id != -1 and id in known]
    return old, [i for i, id in enumerate(ids) if id != -1 and id not in known][: n_inits + 1]


test_the_check_is_right_about_it = check_of(__name__)
