"""Exercise 20.1, eight bugs behind numbers, and the self-test of notebook 20."""

import numpy as np

from .. import museum
from ..quiz import Quiz

PANELS = dict(zip("ABCDEFGH", ("no_heading", "not_squared", "pose_only", "over_q", "identity", "elementwise",
                               "not_wrapped", "transposed"), strict=True))  # fmt: skip
"""Which exhibit stands behind which letter."""

LETTERS = dict(zip(("over_q", "elementwise", "transposed", "pose_only", "no_heading", "not_wrapped", "not_squared",
                    "identity"), "abcdefgh", strict=True))  # fmt: skip
"""The letter of each answer: the order of the museum."""

INSTRUMENTS = ("RMSE", "NIS", "NEES", "runs with P < 0", "position, sensor covered", "heading, sensor covered",
               "first sight, pose known")  # fmt: skip
READINGS = {
    "no_heading": (0.50, 2.40, 99.5, 0, 49.5, 62.5, 2.12),
    "not_squared": (0.784, 1.19, 2.98, 0, 0.0240, 0.0123, 2.12),
    "pose_only": (5, 100, 500, 20, 1.90, 1.01, 2.12),
    "over_q": (0.741, 2.41, 135, 0, 1.90, 1.01, 2.12),
    "identity": (0.374, 1.98, 4.66, 0, 1.90, 1.01, 0.0366),
    "elementwise": (5, 100, 500, 20, 51.3, 1.01, 2.12),
    "not_wrapped": (2.28, 100, 500, 0, 1.90, 1.01, 2.12),
    "transposed": (0.444, 2.28, 297, 0, 51.1, 0.00711, 2.12),
}
"""What the instruments of notebook 20 show, in the order of INSTRUMENTS, at most MOST; a test computes them again."""

MOST = (5, 100, 500, 20, 1000, 1000, 1000)
"""Beyond these readings a filter has diverged: its numbers mean nothing any more."""


def telling(right, wrong):
    """The instrument that tells two bugs apart best: its name, and its readings for the right one and the wrong one."""
    a, b = (np.array(READINGS[key], float) for key in (right, wrong))
    apart = np.abs(np.log10((a + 0.01) / (b + 0.01))) * [0.4, 0.5, 0.5, 0, 1, 1, 1]
    apart[3] = a[3] != b[3]  # runs with P < 0: none or all
    i = int(np.argmax(apart))
    return INSTRUMENTS[i], _number(a[i], MOST[i]), _number(b[i], MOST[i])


def _number(value, most):
    """Two or three digits; a reading at its upper end has none."""
    if value == most != 20:
        return f"more than {most}"
    return f"{value:.0f}" if value >= 10 or value == 0 else f"{value:.2g}"


def _hint(letter, right, wrong):
    instrument, here, there = telling(right, wrong)
    name = museum.BY_KEY[wrong].name
    return f"'{name}' would read {there} at the instrument '{instrument}'; panel {letter} reads {here}."


bugs = Quiz(
    "20.1",
    "Eight bugs behind numbers",
    name="diagnosis",
    hints=(
        "Take the filter to pieces. Which panels are wrong with the sensor covered? There the prediction is wrong.",
        "Sensor covered, heading: a NEES far above 1 says that the variance of the heading is too small; far below 1 too large. If both NEES there are far too small, the noise that is told is too large.",
        "Panels whose parts are honest have their bug in the correction, or in P_rm (then P gets negative eigenvalues). A landmark behind the robot makes the NIS explode; a wrong entry of H does not.",
    ),
)
for _letter, _key in PANELS.items():
    bugs.ask(
        f"panel_{_letter}",
        LETTERS[_key],
        f"panel {_letter}?  one of a ... h",
        f"Compare panel {_letter} with the others, instrument by instrument.",
        {LETTERS[other]: _hint(_letter, _key, other) for other in LETTERS if other != _key},
    )

# ---- the self-test at the end --------------------------------------------------------------------------------------

self_test = Quiz(
    "20.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question; nothing here needs a long computation.",
        "The table of section 6 has a column for each test: count.",
        "A guard that compares P with the mean believes the mean. A statistic sees only what is larger than its band.",
    ),
)
self_test.ask(
    "it_runs",
    "a",
    "how many of the twelve bugs stop the program?  a: none  b: three  c: all",
    "Look at the first column of the table in section 6.",
    {
        "b": "Not one of them: twelve programs run to the end and print numbers.",
        "c": "Not one of them: twelve programs run to the end and print numbers.",
    },
)
self_test.ask(
    "late",
    "c",
    "the Jacobian after the motion is found by  a: RMSE  b: NEES  c: finite differences  d: nothing",
    "Which column of the table has a mark in its row?",
    {
        "a": "Its RMSE is that of the right filter.",
        "b": "Its NEES is that of the right filter: steps are short, the two Jacobians differ little.",
        "d": "The guard of exercise 20.2 rings.",
    },
)
self_test.ask(
    "covered",
    False,
    "the NEES with the sensor covered is honest. Is the prediction free of bugs?  True / False",
    "Which of the mutants of `predict` needs a map to do harm?",
    {True: "'P_rm not moved' is a bug of the prediction that needs a map: without landmarks there is no P_rm."},
)
self_test.ask(
    "both_wrong",
    False,
    "mean and Jacobian have the same error (both turn the wrong way). Does the guard ring?  True / False",
    "What does the guard compare P with?",
    {True: "The guard takes F from the mean: it believes it. Only the data, or a second author, know the right mean."},
)
self_test.ask(
    "nees_fine",
    "b",
    "NEES 3.0 for 3 states, NIS 1.2 for 2 numbers. The filter  a: is honest  b: is told too much noise  c: diverges",
    "Which panel of exercise 20.1 reads like that?",
    {
        "a": "The NIS is far below its band: innovations are smaller than Z says.",
        "c": "A filter that diverges has innovations that are too large.",
    },
)
