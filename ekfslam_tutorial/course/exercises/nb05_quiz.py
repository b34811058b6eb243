"""The self-test of notebook 05."""

from ..quiz import Quiz

self_test = Quiz(
    "05.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question, or step through the widget and look at the framed blocks.",
        "The state has 3 + 2 n numbers. Prediction touches the rows and columns of what moves, correction touches all.",
        "A covariance of some states is a part of the whole matrix: nothing else of it is needed.",
    ),
)
self_test.ask(
    "shape_H",
    (2, 13),
    "5 landmarks in the state: shape of H for one measurement?  e.g. (3, 3)",
    "Rows: what is measured. Columns: the whole state, robot first.",
    {
        (2, 10): "The robot is in the state, too: 3 numbers more.",
        (2, 5): "Those are the columns that are not zero; H has one for each number of the state.",
        (2, 2): "That is the block of the landmark alone.",
        (13, 2): "That is the transpose: rows are outputs, columns are inputs.",
    },
)
self_test.ask(
    "predict",
    "c",
    "predict changes ...  a: all of P  b: P_rr only  c: P_rr, P_rm and P_mr  d: P_rr and P_mm",
    "Only the robot moves. In which blocks is the robot?",
    {
        "a": "P_mm holds errors of landmarks only, and they stand still.",
        "b": "P_rm is a mean of robot errors times landmark errors: one of the two has changed.",
        "d": "The landmarks stand still: P_mm stays. And what of P_rm?",
    },
)
self_test.ask(
    "correct",
    "b",
    "correct, one landmark seen; it may change ...  a: robot and landmark  b: all of x and P  c: x only  d: the robot",
    "K = P H' inv(Z) has a row for each number of the state. Which rows are zero?",
    {
        "a": "The others share errors with the robot: their rows of K are not zero.",
        "c": "The measurement brings information: P - K Z K'.",
        "d": "That would be localisation, with landmarks that are known exactly.",
    },
)
self_test.ask(
    "innovation",
    "b",
    "expected bearing +3.1 rad, measured -3.1 rad: innovation?  a: -6.2  b: +0.08  c: -0.08  d: 0",
    "Both directions are nearly straight behind the robot. Draw them.",
    {
        "a": "That is measured minus expected without a wrap: nearly a whole turn.",
        "c": "From +3.1 on to pi and over the seam to -3.1 the angle grows: -6.2 + 2 pi.",
        "d": "They are 0.08 rad apart: 2 pi - 6.2.",
    },
)
self_test.ask(
    "delete",
    "a",
    "a landmark is deleted; the covariance of the rest ...  a: stays  b: must grow  c: gets smaller  d: is reset",
    "The covariance of some of the states is a block of the whole P.",
    {
        "b": "What was learned through the landmark is in the other states already, and stays true.",
        "c": "Forgetting brings no information.",
        "d": "Take out the rows and columns of the landmark; the rest is right as it is.",
    },
)
