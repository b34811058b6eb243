"""The self-test of notebook 18."""

from ..quiz import Quiz

self_test = Quiz(
    "18.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question: sighting, correction, four ways, gauge, maps.",
        "What is uncertain? What hangs together with what? Who has used which measurement already?",
        "Heading does not show in a point; K has rows for all; told twice counts twice; one filter, one frame.",
    ),
)
self_test.ask(
    "zero",
    "c",
    "a sees b: which column of the Jacobians is zero?  a: heading of a  b: x of b  c: heading of b",
    "Turn a robot on the spot. Who notices it in range and bearing?",
    {
        "a": "Turn the robot that looks: all that it sees moves to the other side.",
        "b": "Move the robot that is seen: range or bearing changes.",
    },
)
self_test.ask(
    "third",
    "b",
    "robot 1 sees robot 2; robot 3 moves in the map  a: never  b: if correlated with them  c: as much as robot 2",
    "K = P H' Z^-1: when are the rows of robot 3 zero?",
    {
        "a": "Robots that have seen the same landmarks are correlated: K has rows for robot 3.",
        "c": "How much it moves depends on its correlation with the two.",
    },
)
self_test.ask(
    "told",
    "b",
    "robots that tell each other their estimates as news get, in time,  a: too cautious  b: too sure  c: honest",
    "A tells B, B tells A. Whose information comes back to A?",
    {
        "a": "What comes back is counted again: the covariance shrinks without new information.",
        "c": "The news of B was in part A's own: counted twice.",
    },
)
self_test.ask(
    "numbers",
    3,
    "five robots in one filter, in the plane: how many numbers does the alignment with the truth have?",
    "How many frames does one filter have?",
    {
        15: "That is for five filters. The one filter knows how the robots lie to each other.",
        5: "One frame in the plane: two numbers for its place, one for its direction.",
        2: "The direction of the frame is free, too.",
    },
)
self_test.ask(
    "average",
    "a",
    "five maps, averaged landmark by landmark, lose  a: what is known about pairs  b: nothing  c: the scale",
    "What is in the blocks of P beside the diagonal?",
    {
        "b": "Compare the errors of section 6: with the whole covariances the map is better.",
        "c": "Ranges fix the scale of every map.",
    },
)
