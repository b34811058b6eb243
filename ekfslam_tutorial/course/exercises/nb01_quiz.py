"""Exercises 01.1 and 01.5 and the self-test of notebook 01: sizes, limits and meanings in EKF localisation."""

from ..quiz import Quiz

# ---- 01.1 sizes ----------------------------------------------------------------------------------------------------

sizes = Quiz(
    "01.1",
    "What size is it?",
    hints=(
        "Count the numbers: 3 in the state, 2 in the control, 2 in a measurement. Known landmarks are in none of them.",
        "A Jacobian has a row for each output and a column for each input. A covariance is square.",
        "F_x = d(3 numbers)/d(3 numbers). F_u = d(3)/d(2). H = d(2)/d(3). K turns 2 numbers into 3.",
    ),
)
sizes.ask(
    "shape_P",
    (3, 3),
    "the map has 20 known landmarks: shape of P?  e.g. (2, 2)",
    "P is the covariance of the state, and the state is the pose alone.",
    {
        (43, 43): "That is SLAM: there the landmarks are in the state. Here they are known.",
        (40, 40): "That is mapping: here the landmarks are known, and the pose is estimated.",
        (2, 2): "A pose in the plane has a heading, too.",
    },
)
sizes.ask(
    "shape_F_u",
    (3, 2),
    "shape of F_u, the derivative of the new pose by u = [v, w]?",
    "Rows: outputs. Columns: inputs.",
    {
        (2, 3): "That is the transpose: rows are outputs (the pose), columns are inputs (the control).",
        (3, 3): "That is F_x. The control has two numbers, v and w.",
        (2, 2): "That is U. F_u carries it over to the three numbers of the pose.",
    },
)
sizes.ask(
    "shape_FUF",
    (3, 3),
    "shape of F_u U F_u'?",
    "Multiply the shapes: (3, 2) (2, 2) (2, 3).",
    {(2, 2): "That is U itself. F_u U F_u' is added to P, so it has P's size."},
)
sizes.ask(
    "rank_FUF",
    2,
    "rank of F_u U F_u', one step?  a number",
    "The noise of one step comes from two numbers only.",
    {
        3: "Two noisy numbers, v and w, cannot move the pose in three independent directions in one step.",
        1: "Speed and turn rate have independent noises: that is two directions.",
    },
)
sizes.ask(
    "shape_H",
    (2, 3),
    "shape of H, the derivative of [range, bearing] by the pose?",
    "Rows: outputs. Columns: inputs.",
    {
        (3, 2): "That is the transpose: rows are outputs (range, bearing), columns are inputs (the pose).",
        (2, 2): "The bearing depends on the heading, too: three columns.",
        (2, 43): "That is SLAM. The landmarks are known here.",
    },
)
sizes.ask(
    "shape_Z",
    (2, 2),
    "shape of the innovation covariance Z = H P H' + R?",
    "It is the covariance of the innovation, and that has the size of one measurement.",
    {(3, 3): "H P H' has the size of the measurement, not of the state."},
)
sizes.ask(
    "shape_K",
    (3, 2),
    "shape of the gain K?",
    "K times the innovation (2 numbers) is a change of the pose (3 numbers).",
    {
        (2, 3): "That is the transpose: K takes 2 numbers and gives 3.",
        (3, 3): "K multiplies the innovation, which has 2 numbers.",
        (2, 2): "K gives a change of the pose, which has 3 numbers.",
    },
)

# ---- 01.5 limits of a straight line --------------------------------------------------------------------------------

limits = Quiz(
    "01.5",
    "How far does a straight line carry?",
    name="limits",
    hints=(
        "Section 2 has the widget: set a sigma and a distance, and compare the mean of the samples with f(mean).",
        "Ahead of the robot the samples are at d cos(error of the heading). What is the mean of a cosine near its top?",
        "cos(a) = 1 - a^2 / 2 + ..., so the mean of d cos(a) is d (1 - sigma^2 / 2), with sigma in radians.",
    ),
)
limits.ask(
    "ten_percent",
    "c",
    "one straight step: from which sigma of the heading is f(mean) 10 % too far?  a: 3 deg  b: 10 deg  c: 26 deg",
    "Set 10 m in the widget: f(mean) must be 1 m away from the mean of the samples.",
    {
        "a": "At 3 deg the mean of the samples is 0.14 % short of f(mean). That is what makes the EKF work.",
        "b": "At 10 deg = 0.175 rad it is sigma^2 / 2 = 1.5 % short. Compare the mean, not the width of the cloud.",
    },
)
limits.ask(
    "twice_as_far",
    "b",
    "the step is twice as long. That sigma is then  a: half  b: the same  c: twice as large",
    "Both f(mean) and the mean of the samples are proportional to the distance. And their ratio?",
    {
        "a": "The error in metres doubles, but so does the way: the share stays.",
        "c": "A longer step makes nothing more linear. The error in metres doubles, and so does the way.",
    },
)
limits.ask(
    "half_sigma",
    "a",
    "sigma is halved. The error of f(mean) becomes  a: a quarter  b: half  c: nothing",
    "The error is d sigma^2 / 2: a straight line leaves out the square.",
    {
        "b": "The *width* of the cloud is halved. What the straight line leaves out goes with the square.",
        "c": "It becomes small, not zero: the cosine is bent everywhere near its top.",
    },
)

# ---- the self-test -------------------------------------------------------------------------------------------------

self_test = Quiz(
    "01.self",
    "Self-test",
    name="self_test",
    hints=(
        "Each answer was a section of this notebook.",
        "Noise enters through the control. An angle is wrapped after it was subtracted. P depends on H, not on y.",
        "An innovation of nearly 2 pi moves the pose by K times that. A derivative is taken before the step.",
    ),
)
self_test.ask(
    "before_or_after",
    "a",
    "F_x is evaluated at  a: the pose before the step  b: the pose after it  c: either, it is the same",
    "F_x = df/dx at the x that goes into f.",
    {
        "b": "The step starts at the old heading: f goes from the old pose, and so does its derivative.",
        "c": "It is the same only if the robot does not turn.",
    },
)
self_test.ask(
    "landmark_known",
    "b",
    "a known landmark is seen. Its covariance  a: shrinks  b: is not in the filter  c: grows",
    "What is in the state?",
    {
        "a": "A known landmark has no covariance. In *mapping* it has one, and it shrinks.",
        "c": "A measurement never adds uncertainty, and this landmark has none.",
    },
)
self_test.ask(
    "surprise",
    "c",
    "a measurement is exactly as expected, z = 0. Then  a: nothing changes  b: only x changes  c: only P changes",
    "Put z = 0 into x + K z and into P - K H P.",
    {
        "a": "x stays. But the measurement has confirmed it: P shrinks.",
        "b": "It is the other way round: K z = 0.",
    },
)
self_test.ask(
    "half_dt",
    "b",
    "dt is halved, same white noise. The covariance U of the mean speed in one step  a: halves  b: doubles  c: stays",
    "A mean over a shorter time has more noise.",
    {
        "a": "That is the covariance of the *distance*: it grows with time. The mean speed has covariance S / dt.",
        "c": "Then twice as many steps would give half the noise: the filter would depend on dt.",
    },
)
self_test.ask(
    "wrap_what",
    "a",
    "which of these is wrapped?  a: bearing y minus bearing e  b: range y minus range e  c: both",
    "Which of them is an angle?",
    {
        "b": "A range is a length: it may be off by 4 m. The bearing is the angle.",
        "c": "A range is a length, not an angle: wrap the difference of the bearings only.",
    },
)
