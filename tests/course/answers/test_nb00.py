"""Answers to the exercises of notebook 00 that are in no list of the package: wrong ones, and odd right ones."""

import math

import numpy as np

from ekfslam_tutorial.course.exercises.nb00_wrap import wrap

from .collector import answer_to, check_of

# --- 00.1 wrap ---


@answer_to("00.1", hint="between pi and 2 pi|between -pi and pi|2 pi")
def modulo_pi(angle):
    return angle % np.pi


@answer_to("00.1", hint="2 pi")
def whole_turns_by_int(angle):
    return angle - 2 * np.pi * int(angle / (2 * np.pi))


@answer_to("00.1", hint="rounded")
def pi_is_3_14(angle):
    return (angle + 3.14) % 6.28 - 3.14


@answer_to("00.1", hint="rounded")
def rounded(angle):
    return np.round(wrap(angle), 2)


@answer_to("00.1", hint="half turns|arctan2|direction")
def arcsine(angle):
    return np.arcsin(np.sin(angle))


@answer_to("00.1", hint="sign|left")
def arccosine(angle):
    return np.arccos(np.cos(angle))


@answer_to("00.1", hint="numpy .* take arrays")
def math_functions(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


@answer_to("00.1", hint="array|number")
def always_an_array(angle):
    return np.atleast_1d(wrap(angle))


@answer_to("00.1", hint="changes its input|number")
def in_place(angle):
    angle[angle > np.pi] -= 2 * np.pi
    angle[angle < -np.pi] += 2 * np.pi
    return angle


@answer_to("00.1", hint="array")
def if_on_the_remainder(angle):
    a = angle % (2 * np.pi)
    if a > np.pi:
        a = a - 2 * np.pi
    return a


@answer_to("00.1", hint="return")
def prints_it(angle):
    print(wrap(angle))


@answer_to("00.1", hint="many|several|loop|all turns")
def two_turns_at_most(angle):
    for _ in range(2):
        angle = np.where(angle > np.pi, angle - 2 * np.pi, angle)
        angle = np.where(angle <= -np.pi, angle + 2 * np.pi, angle)
    return angle


@answer_to("00.1", right=True)
def remainder_for_each(angle):
    return np.vectorize(lambda a: math.remainder(a, math.tau))(angle)


@answer_to("00.1", right=True)
def turns_by_ceil(angle):
    return angle - 2 * np.pi * np.ceil((angle - np.pi) / (2 * np.pi))


@answer_to("00.1", right=True)
def masks_until_done(angle):
    a = np.array(angle, dtype=float)
    while np.any(a > np.pi):
        a = np.where(a > np.pi, a - 2 * np.pi, a)
    while np.any(a < -np.pi):
        a = np.where(a < -np.pi, a + 2 * np.pi, a)
    return a


@answer_to("00.1", right=True)
def by_cases(angle):
    a = np.fmod(angle, 2 * np.pi)
    return a + np.where(a > np.pi, -2 * np.pi, np.where(a < -np.pi, 2 * np.pi, 0))


# --- right answers in other words ---


@answer_to("00.1", right=True)
def arctan2_of_sine_and_cosine(angle):
    return np.arctan2(np.sin(angle), np.cos(angle))


@answer_to("00.1", right=True)
def with_a_shift(angle):
    return (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi


@answer_to("00.1", right=True)
def nearest_whole_turn_removed(angle):
    return angle - 2 * np.pi * np.round(np.asarray(angle) / (2 * np.pi))


@answer_to("00.1", right=True)
def complex_numbers(angle):
    return np.angle(np.exp(1j * np.asarray(angle)))


@answer_to("00.1", right=True)
def a_loop_over_the_entries_as_lists(angle):
    def one(a):
        while a > np.pi:
            a -= 2 * np.pi
        while a < -np.pi:
            a += 2 * np.pi
        return a

    a = np.asarray(angle, float)
    return one(float(a)) if a.ndim == 0 else np.array([one(v) for v in a.ravel()]).reshape(a.shape).tolist()


test_the_check_is_right_about_it = check_of(__name__)
