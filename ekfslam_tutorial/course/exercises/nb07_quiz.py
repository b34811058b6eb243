"""The self-test of notebook 07."""

from ..quiz import Quiz

self_test = Quiz(
    "07.self",
    "Self-test",
    name="self_test",
    hints=(
        "Each answer is a figure of this notebook.",
        "A missed match costs one measurement; a wrong match costs the map.",
        "Distances in sigma, chi2 with as many degrees of freedom as numbers, cross-covariances between pairs.",
    ),
)
self_test.ask(
    "nearest",
    "b",
    "the nearest landmark is the one with the least  a: distance in metres  b: z' inv(Z) z  c: bearing difference",
    "Remember the widget in which the two rankings disagreed.",
    {
        "a": "Metres do not know that the bearing is worse than the range, or how uncertain the pose is.",
        "c": "The range tells something, too: use both, in units of sigma.",
    },
)
self_test.ask(
    "two_inside",
    "c",
    "two landmarks pass the gate. The safe thing:  a: take the nearer  b: use both  c: use none  d: start a new one",
    "What does a wrong match cost, and what a measurement that is not used?",
    {
        "a": "In an ambiguous case the nearer one is often wrong.",
        "b": "One measurement belongs to one landmark: the other one would be pulled to a wrong place.",
        "d": "It is one of the two, so a new landmark would be a double.",
    },
)
self_test.ask(
    "wrong_match",
    "b",
    "after one wrong match, many right ones follow. The filter  a: forgets it  b: stays over-confident  c: notices it",
    "Look at the NEES of the map 80 frames after the swap.",
    {
        "a": "Nothing is ever taken out of an EKF: the wrong measurement was used like a right one.",
        "c": "The EKF has no memory of single measurements: it cannot find out which one was wrong.",
    },
)
self_test.ask(
    "dof",
    8,
    "4 pairs of [range, bearing] are tested together: degrees of freedom of the joint gate?  (a number)",
    "How many numbers has the stacked innovation?",
    {2: "That is the gate of a single pair.", 4: "Each pair brings two numbers.", 16: "That is the number of entries."},
)
self_test.ask(
    "jcbb",
    "a",
    "why does joint compatibility help?  a: pairs share the robot's error  b: the gate is smaller  c: it is faster",
    "Think of the corridor: all measurements were shifted by the same slip.",
    {
        "b": "The joint gate is not smaller; it tests something else: do the pairs lean the same way?",
        "c": "It is slower: it searches a tree of hypotheses.",
    },
)
