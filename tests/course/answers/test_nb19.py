"""Answers to the exercises of notebook 19 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
import pytest

from ekfslam_tutorial.course import registry
from ekfslam_tutorial.course.exercises.nb19_gps import gps_error
from ekfslam_tutorial.course.exercises.nb19_scan import sort_scan

from .collector import answer_to, check_of

# --- 19.2 labels are no quantities ---


@pytest.mark.parametrize("misconception", registry.get("19.2").misconceptions, ids=lambda m: m.name)
def test_a_label_is_not_half_or_twice_another(misconception):
    message = registry.get("19.2").judge(misconception.answer).message
    assert "Yours" not in message and "rong sign" not in message, message


@answer_to("19.2", right=True)
def numbers_with_a_point(D, gate, new_gate):
    return sort_scan(D, gate, new_gate).astype(float)


# --- 19.3 who stays in the map ---


@answer_to("19.3", hint="This scan counts, too")
def asks_in_a_loop_and_counts_after(searched, found, visible, matched, min_search, min_ratio):
    gone, s, m = [], searched.copy(), found.copy()
    for i in np.flatnonzero(visible):
        if s[i] >= min_search and m[i] / max(s[i], 1) < min_ratio:
            gone.append(int(i))
        s[i] += 1
        m[i] += matched[i]
    return s, m, gone


@answer_to("19.3", hint="At least.* min_search: >=")
def too_patient_by_one(searched, found, visible, matched, min_search, min_ratio):
    s, m = searched + visible, found + matched
    return s, m, [i for i in range(len(s)) if visible[i] and s[i] > min_search and m[i] < min_ratio * s[i]]


# --- 19.4 a path beside GPS ---


@answer_to("19.4", hint="order of fixes")
def sorted_in_place(t, path, fixes, share):
    d = gps_error(t, path, fixes, share)[0]
    d.sort()
    return d, np.sqrt(np.mean(d[: int(share * len(d))] ** 2))


test_the_check_is_right_about_it = check_of(__name__)
