"""The self-test of notebook 15."""

from ..quiz import Quiz

self_test = Quiz(
    "15.self",
    "Self-test",
    name="self_test",
    hints=(
        "Each question has its section: one map, rumours, a meeting, a camera's mounting, a second camera.",
        "Ask each time: do these two errors have a common source? And: which motion would show the difference?",
        "Common landmarks, a common odometry and an exchanged estimate all make errors correlated.",
    ),
)
self_test.ask(
    "shared",
    "c",
    "two robots have seen one landmark. Their errors are  a: independent  b: equal  c: correlated",
    "Both depend on the error of the landmark.",
    {
        "a": "Independent they were before. The landmark is a link between them.",
        "b": "Each still has errors of its own.",
    },
)
self_test.ask(
    "incest",
    "a",
    "informations added at each exchange  a: count old data many times  b: average noise away  c: are right",
    "How many measurements are made while estimates are sent to and fro?",
    {
        "b": "No new measurement, no new noise to average: the error stays, only the claim gets smaller.",
        "c": "It is right if they are *independent*. After the first exchange they are not.",
    },
)
self_test.ask(
    "ci",
    "b",
    "covariance intersection  a: is as good as a joint filter  b: is safe, but not the best  c: needs the correlation",
    "Look at the dial: left of the green band, or in it?",
    {
        "a": "It must fear the worst correlation, so it claims less than the joint filter.",
        "c": "That is its point: it holds whatever the correlation is.",
    },
)
self_test.ask(
    "straight",
    "a",
    "a robot drives straight. Its camera cannot find its own turn  a: about the way ahead  b: about the vertical",
    "Turn the whole picture about the driving direction: what changes?",
    {
        "b": "Then the camera would seem to drift sideways, and the odometry says that it does not.",
    },
)
self_test.ask(
    "stereo",
    "c",
    "two cameras 25 cm apart, one picture: depth known to a few per cent for  a: all landmarks  b: far  c: near ones",
    "By how many pixels do the two pictures of a point differ?",
    {
        "a": "The pixels differ by f b / d: for far points that is less than the noise.",
        "b": "It is the other way round: far points have nearly the same pixel in both pictures.",
    },
)
