"""The self-test of notebook 21."""

from ..quiz import Quiz

self_test = Quiz(
    "21.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question; nothing here needs a long computation.",
        "A filter keeps the last pose and all landmarks; a smoother keeps the old poses as well.",
        "To take an unknown out of the state links all its neighbours with each other.",
    ),
)
self_test.ask(
    "iterated",
    "b",
    "an iterated EKF looks again at  a: all old measurements  b: the measurement of this frame  c: its old poses",
    "What is inside the loop of exercise 21.1?",
    {
        "a": "That is the batch. The iterated EKF uses each measurement in its own frame only, and then never again.",
        "c": "Old poses are no longer in its state.",
    },
)
self_test.ask(
    "prior",
    False,
    "iterated EKF: does the second iteration start from the corrected P?  True / False",
    "How often may a measurement be used?",
    {True: "Then the measurement is used twice. Only the point of linearisation moves; prior x, P stay."},
)
self_test.ask(
    "sparse",
    "c",
    "A of all poses and landmarks is sparse:  a: P is small  b: noise is white  c: few unknowns in each measurement",
    "Which blocks does one sight of one landmark fill?",
    {
        "a": "P is dense there: everything is correlated with everything.",
        "b": "White noise makes R diagonal by blocks. That A has so few entries comes from H.",
    },
)
self_test.ask(
    "marginal",
    "a",
    "a pose saw 4 landmarks and is marginalised:  a: all pairs of them are linked  b: their links go  c: no change",
    "Look at the fill-in of section 5.",
    {
        "b": "What the pose knew of them must go somewhere: into links between them.",
        "c": "The Schur complement A_kg A_gg^-1 A_gk is not zero for its neighbours.",
    },
)
self_test.ask(
    "lag",
    "b",
    "a fixed-lag smoother with lag 1 is  a: the batch  b: a filter  c: dead reckoning",
    "How many poses are in its state?",
    {
        "a": "That is a lag as long as the log.",
        "c": "It uses all measurements, each in its own frame.",
    },
)
