"""The self-test of notebook 08."""

from ..quiz import Quiz

self_test = Quiz(
    "08.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question; nothing here needs a long computation.",
        "Turn or shift everything together: robot and map. Which numbers of the sensor change?",
        "The EKF takes each Jacobian at another point. Together they see a direction that none of them should see.",
    ),
)
self_test.ask(
    "stands_still",
    "a",
    "100 sights of one new landmark, robot at rest: information on its heading?  a: none  b: 100 times  c: 10 times",
    "Robot and landmark may turn together about the robot: does any measurement change?",
    {
        "b": "Each sight tells where the landmark is *relative to the robot*. Of the heading itself it tells nothing.",
        "c": "Each sight tells where the landmark is *relative to the robot*. Of the heading itself it tells nothing.",
    },
)
self_test.ask(
    "dimension",
    "c",
    "SLAM in the plane with range and bearing: invisible directions?  a: 0  b: 2  c: 3",
    "Shift in x, shift in y, and one more.",
    {
        "a": "Zero is localisation with a known map. In SLAM the whole world can be moved.",
        "b": "Two shifts, and a turn.",
    },
)
self_test.ask(
    "ekf_sees",
    "b",
    "the EKF's own Jacobians leave  a: 3 invisible directions  b: 2, the turn is lost  c: none",
    "Look at the table in section 4.",
    {
        "a": "Three is the truth, and first-estimates Jacobians keep it. The EKF wins false information.",
        "c": "The shifts stay invisible: H is the same wherever the whole world is shifted to.",
    },
)
self_test.ask(
    "fej",
    "c",
    "first-estimates Jacobians change  a: the measurement y  b: the expectation e  c: only where H (and F) is taken",
    "What did your function of exercise 08.2 change?",
    {
        "a": "The measurement is what the sensor says.",
        "b": "The expectation still belongs to the present estimate. Only the Jacobian is taken elsewhere.",
    },
)
self_test.ask(
    "joseph",
    True,
    "does the Joseph form hold for a gain that is not the best one?  True / False",
    "It is the covariance of (I - K H) dx - K v.",
    {False: "It is the covariance of (I - K H) dx - K v, for any K: that is its second virtue, beside rounding."},
)
