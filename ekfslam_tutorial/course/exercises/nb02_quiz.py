"""Exercise 02.1 and the self-test of notebook 02: the questions of the mapping lecture's slides."""

from ..quiz import Quiz

# ---- 02.1 the questions of the slides --------------------------------------------------------------------

quiz = Quiz(
    "02.1",
    "The map and its covariance",
    hints=(
        "Write the covariance of two landmarks on paper, all 16 entries, with their names.",
        "The shapes follow from the products: the gain K turns an innovation (2 numbers) into a change of x.",
        "P is 2n x 2n. H is the derivative of 2 numbers by 2n numbers. Z = H P H' + R, and K = P H' inv(Z).",
    ),
)
quiz.ask(
    "symmetric",
    True,
    "is P symmetric?  True / False",
    "Compare cov(a, b) with cov(b, a).",
    {False: "cov(a, b) = cov(b, a), so P = P'. Only a block of two *different* landmarks need not be symmetric."},
)
quiz.ask(
    "block_ii",
    "b",
    "block P_ij for i == j?  a: zero  b: covariance of landmark i  c: identity  d: cross-correlation",
    "Put i = j into the block with the entries cov(x_i, x_j), cov(x_i, y_j) ...",
    {
        "a": "cov(x_i, x_i) is the variance of x_i: zero only if the landmark is known exactly.",
        "c": "The identity would say: 1 m^2 of variance for each landmark, whatever was measured.",
        "d": "A *cross*-correlation is between two landmarks; here there is only one.",
    },
)
quiz.ask(
    "f",
    "c",
    "the motion function f(x)?  a: zero  b: x + robot step  c: x itself",
    "The state holds landmarks only. What do they do between two steps?",
    {
        "a": "f(x) = 0 would move every landmark to the origin.",
        "b": "The robot moves, but the robot is not in the state. The landmarks stand still.",
    },
)
quiz.ask(
    "jacobian_of_f",
    "c",
    "its Jacobian with respect to x?  a: zero  b: there is none  c: identity",
    "Differentiate your f by x.",
    {
        "a": "The derivative of x by x is not zero: with J = 0 the prediction would delete all uncertainty.",
        "b": "f(x) = x is a function like any other: differentiate it.",
    },
)
quiz.ask(
    "prediction_grows_P",
    False,
    "does P grow in the prediction step?  True / False",
    "Put f and its Jacobian into P <- J P J' + (noise of the motion).",
    {True: "J = I and no noise enters the state: P stays. Motion noise makes the *robot* uncertain."},
)
quiz.ask(
    "shape_P",
    (14, 14),
    "n = 7 landmarks: shape of P?  e.g. (3, 3)",
    "Each landmark brings two numbers.",
    {(7, 7): "Each landmark has two coordinates: the state has 2n numbers."},
)
quiz.ask(
    "shape_H",
    (2, 14),
    "shape of the Jacobian H of one measurement (slide: G)?",
    "Rows: what is measured, range and bearing. Columns: the *whole* state.",
    {
        (2, 2): "That is the block of the seen landmark; H has one column for each number in the state.",
        (14, 2): "That is the transpose: rows are outputs, columns are inputs.",
        (2, 7): "Each landmark has two coordinates: the state has 2n numbers.",
    },
)
quiz.ask(
    "shape_Z",
    (2, 2),
    "shape of the innovation covariance Z = H P H' + R?",
    "Z is the covariance of the innovation: how many numbers does one measurement have?",
    {(14, 14): "H P H' has the size of the measurement, not of the state."},
)
quiz.ask(
    "shape_K",
    (14, 2),
    "shape of the gain K?",
    "K times the innovation (2 numbers) must give a change of the whole state.",
    {
        (2, 14): "That is the transpose: K takes 2 numbers and gives 2n.",
        (2, 2): "One innovation changes the whole state, so K has 2n rows.",
        (14, 14): "K multiplies the innovation, which has 2 numbers: 2 columns.",
        (7, 2): "Each landmark has two coordinates: the state has 2n numbers.",
    },
)

# ---- the self-test at the end ----------------------------------------------------------------------------

self_test = Quiz(
    "02.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question; nothing here needs a computation of more than a line.",
        "Known pose: the noise of a measurement touches one landmark only. Information adds up: 1/P = 1/P1 + 1/P2.",
        "For a Gaussian in the plane the probability inside k sigma is 1 - exp(-k^2 / 2).",
    ),
)
self_test.ask(
    "LRL",
    "c",
    "slide 'What is this matrix?', L_y R L_y':  a: noise of the sensor  b: gain  c: covariance of the new landmark",
    "It stands on the diagonal of the new P, in metres squared.",
    {
        "a": "The noise of the sensor is R, in polar coordinates. L_y carries it into the map frame.",
        "b": "A gain turns an innovation into a change of x; this matrix is a block of P.",
    },
)
self_test.ask(
    "zero_blocks",
    "b",
    "why zeros beside it?  a: too small to matter  b: the pose is known, the noises are independent  c: by choice",
    "What would two landmarks have to share to be correlated?",
    {
        "a": "They are exactly zero, not small: change the noise as you like, they stay zero.",
        "c": "A covariance is computed, not chosen: a wrong zero makes a filter that is too sure of itself.",
    },
)
self_test.ask(
    "what_changes",
    "a",
    "after an update with landmark 3, P changes in  a: block (3, 3)  b: row and column 3  c: every block",
    "K = P H' inv(Z): which rows of K are not zero when P is block diagonal?",
    {
        "b": "Row and column 3 hold zeros beside block (3, 3), and zeros they stay.",
        "c": "That is SLAM. With a known pose the gain has two rows that are not zero.",
    },
)
self_test.ask(
    "twice",
    "b",
    "start a landmark, then update it with the same measurement: its variances are  a: right  b: half  c: a quarter",
    "Information adds up: the same information twice.",
    {
        "a": "The update cannot know that it has seen the measurement before. It believes in two.",
        "c": "The *determinant* is a quarter; each variance is half.",
    },
)
self_test.ask(
    "three_sigma",
    "b",
    "share of landmarks that should lie inside their 3-sigma ellipse:  a: 99.7 %  b: 98.9 %  c: 95.4 %",
    "In the plane the probability inside k sigma is 1 - exp(-k^2 / 2).",
    {
        "a": "99.7 % is right for one number. An ellipse holds less: 1 - exp(-9/2).",
        "c": "That is 2 sigma of one number.",
    },
)
