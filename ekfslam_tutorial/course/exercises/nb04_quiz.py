"""The self-test of notebook 04."""

from ..quiz import Quiz

self_test = Quiz(
    "04.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question; nothing here needs more than a line of computation.",
        "Write the errors, not the states: dl = L_r dx_r + L_y v, and dx_r' = X_x dx_r + X_u w.",
        "A measurement corrects everything that shares an error with what is measured; it never adds uncertainty.",
    ),
)
self_test.ask(
    "instrument",
    "c",
    "mapping formula used in SLAM: what shows it?  a: the look of the map  b: NIS  c: NEES  d: position error",
    "Look at the table of the experiment: which number differs by a factor, not by some percent?",
    {
        "a": "The picture stays pretty: that is the danger.",
        "b": "The NIS was 2.0 with both formulas.",
        "d": "The position error changes by some percent only; a single run does not show it.",
    },
)
self_test.ask(
    "P_rm",
    "b",
    "the robot moves; P_rm ...  a: stays  b: becomes X_x P_rm  c: becomes 0  d: becomes X_x P_rm X_x'",
    "Multiply the errors: dx_r' = X_x dx_r + X_u w and dm' = dm.",
    {
        "a": "P_rm belongs to the robot, too, and the robot moves.",
        "c": "Moving does not make robot and map independent.",
        "d": "Only one of the two errors, the robot's, goes through X_x.",
    },
)
self_test.ask(
    "shape_Plx",
    (2, 9),
    "robot and 3 landmarks in the state, a 4th is new: shape of P_lx?  e.g. (3, 3)",
    "Two rows for the new landmark. How many numbers does the state have so far?",
    {
        (2, 3): "That is the part with the robot. The new landmark is correlated with the old ones, too.",
        (2, 6): "The robot is in the state, too: 3 numbers more.",
        (9, 2): "That is P_xl, the transpose.",
        (2, 11): "The state *so far* does not hold the new landmark yet.",
    },
)
self_test.ask(
    "zero_cross",
    "c",
    "P_lx is exactly zero if ...  a: never  b: the sensor is exact  c: the pose is known exactly  d: it is far away",
    "P_lx = L_r P[:3]. When is that zero?",
    {
        "a": "It is so in notebook 02: put P[:3] = 0 into P_lx = L_r P[:3].",
        "b": "R is not in P_lx at all.",
        "d": "A far landmark has a large L_r: its covariance with the heading is even larger.",
    },
)
self_test.ask(
    "unseen",
    "b",
    "A is measured, B is not in view: sigma of B ...  a: stays  b: stays or falls  c: may grow  d: falls always",
    "P_bb becomes P_bb - K_b Z K_b'. Can that be larger than P_bb? Can it be equal?",
    {
        "a": "So it would be without correlation. In SLAM, B shares the robot's errors.",
        "c": "K_b Z K_b' is a covariance: it is subtracted, so nothing grows.",
        "d": "If B shares no error with robot and A, K_b is zero.",
    },
)
