"""The self-test of notebook 16."""

from ..quiz import Quiz

self_test = Quiz(
    "16.self",
    "Self-test",
    name="self_test",
    hints=(
        "Each question has its section: entry points, the contract, the run, the ring, the camera.",
        "The chain of frames is written once for all sensors. A contract looks at one class, a NEES at a whole run.",
        "A straight way has a mirror image: left and right give the same ranges. A curve has none.",
    ),
)
self_test.ask(
    "chain",
    "b",
    "a new sensor class must contain  a: the way from world to sensor  b: the sensor's own equations  c: an EKF",
    "Which lines did you write, and which were there before?",
    {
        "a": "Frames are written once, in `observe`, for every sensor: your class sees points in its own frame.",
        "c": "The filter asks the sensor for h and its Jacobian. It never asks what kind of sensor it is.",
    },
)
self_test.ask(
    "only_h",
    False,
    "True or False: with h (project) written, the sensor is complete.",
    "Count the places where a run stopped.",
    {True: "The run also stopped at the residual, at visible, at R, and, for new landmarks, at retro."},
)
self_test.ask(
    "contract",
    "c",
    "check_sensor passes. The NEES of the runs can  a: not be wrong any more  b: only be too small  c: still be wrong",
    "The contract looks at the equations. What does it know of the noise of your hardware?",
    {
        "a": "A wrong R, or a wrong motion model, is no error of the sensor's equations.",
        "b": "An R that is too small gives a NEES that is too large.",
    },
)
self_test.ask(
    "straight",
    "b",
    "ranges to one beacon from a straight way leave  a: one place  b: two places  c: a whole ring",
    "Mirror the beacon at the line of the way: which of the ranges changes?",
    {
        "a": "The mirror image, on the other side of the way, gives the same ranges.",
        "c": "One range leaves a ring. Two places of the robot cut two rings: two points.",
    },
)
self_test.ask(
    "why_many",
    "a",
    "many narrow Gaussians on the ring, not a wide one, since  a: each is nearly linear  b: it is faster  c: of NEES",
    "What happens to a Jacobian that is taken far from the truth?",
    {
        "b": "It is slower: each measurement corrects every hypothesis.",
        "c": "The NEES tells that one Gaussian fails. It does not say why.",
    },
)
