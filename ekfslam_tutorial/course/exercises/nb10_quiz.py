"""The self-test of notebook 10."""

from ..quiz import Quiz

self_test = Quiz(
    "10.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question; the widgets answer most of them.",
        "Read the names aloud: OUT_in is the derivative of OUT by in; inner names of a product must be equal.",
        "A pose in space has six degrees of freedom. The state that holds it has seven numbers.",
    ),
)
self_test.ask(
    "order",
    "b",
    "robot in the world F, camera on the robot G: camera in the world?  a: G F  b: F G  c: F + G  d: G F*",
    "A point of the camera goes out of G first, then out of F: what stands next to the point?",
    {
        "a": "That puts the robot onto the camera: rotations do not commute.",
        "c": "Frames cannot be added: the second step is seen from the turned robot.",
        "d": "The conjugate turns back; both steps go outwards here.",
    },
)
self_test.ask(
    "sign",
    "c",
    "q and -q are ...  a: opposite rotations  b: rotations by a and a + 180 deg  c: the same rotation  d: inverse",
    "R(q) is quadratic in q: what does the sign do?",
    {
        "a": "The opposite rotation is the conjugate: only b, c, d change their sign.",
        "b": "The angles differ by 360 degrees, which is no difference.",
        "d": "The inverse is the conjugate: only b, c, d change their sign.",
    },
)
self_test.ask(
    "rank",
    6,
    "rank of the 7 x 7 covariance of a frame after a right normalisation (nothing known exactly)?  a number",
    "How many degrees of freedom has a pose in space?",
    {7: "Along q there is no uncertainty left: the norm is one.", 3: "Position has three; and the rotation?"},
)
self_test.ask(
    "chain",
    "a",
    "which product can be right?  a: U_ps PS_pr PR_r  b: PR_r PS_pr U_ps  c: U_ps PR_r PS_pr  d: U_ps PS_s PR_r",
    "Inner names must be equal: what stands after the _ of a factor is the capital of the next.",
    {
        "b": "Inner names: r next to PS. The chain is read from the output on the left to the input on the right.",
        "c": "Inner names: ps next to PR. They must be equal.",
        "d": "Inner names: s next to PR. They must be equal.",
    },
)
self_test.ask(
    "shape",
    (2, 7),
    "pixel u (2 numbers), robot frame Rf (7 numbers): shape of U_r?  e.g. (3, 3)",
    "Rows: what comes out. Columns: what goes in.",
    {
        (7, 2): "That is the transpose: rows are outputs.",
        (2, 6): "The state that holds a frame has seven numbers, though it has six degrees of freedom.",
        (2, 3): "That would be the derivative by a point.",
    },
)
