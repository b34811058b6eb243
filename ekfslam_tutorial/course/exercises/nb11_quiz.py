"""The self-test of notebook 11."""

from ..quiz import Quiz

self_test = Quiz(
    "11.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question; the widgets answer most of them.",
        "Ask of each noise: in which axes, in which numbers, and how much per second?",
        "The rank of J U J' is at most that of U.",
    ),
)
self_test.ask(
    "frame",
    "a",
    "wheels slip along the driving direction: the noise is constant in  a: the robot's axes  b: the world's  c: both",
    "Turn the robot by 90 degrees: where does it slip now?",
    {"b": "The robot turns, and the slip turns with it.", "c": "They differ as soon as the robot turns."},
)
self_test.ask(
    "rank",
    6,
    "rank of X_u U X_u' for odometry in space, 7 x 7, U of full rank?  a number",
    "How many numbers has the control?",
    {7: "U has rank 6, and a product has no larger rank: nothing is uncertain along q.", 3: "Position *and* turn."},
)
self_test.ask(
    "const_vel_shape",
    (13, 6),
    "constant velocity: shape of X_u?  e.g. (3, 3)",
    "Rows: the state [t, q, v, w]. Columns: the impulses.",
    {
        (6, 13): "That is the transpose: rows are outputs.",
        (12, 6): "The quaternion has four numbers.",
        (7, 6): "v and w are states, too.",
    },
)
self_test.ask(
    "dt",
    "b",
    "the filter runs at 20 Hz instead of 10 Hz; U of one step must be  a: the same  b: half  c: a quarter",
    "In one second there are twice as many independent impulses. What adds up?",
    {
        "a": "Then the variance after one second would be twice as large.",
        "c": "Variances add, not standard deviations.",
    },
)
self_test.ask(
    "gimbal",
    "c",
    "at a pitch of 90 deg  a: the robot is stuck  b: no rotation matrix exists  c: roll and yaw turn about one axis",
    "It is the three numbers that fail, not the robot.",
    {
        "a": "Turn your hand: nothing is stuck. Only the Euler angles are.",
        "b": "R and q are as good there as anywhere else.",
    },
)
