"""The self-test of notebook 06."""

from ..quiz import Quiz

self_test = Quiz(
    "06.self",
    "Self-test",
    name="self_test",
    hints=(
        "Each answer is a picture of this notebook: the map before and after, the curves, the floor.",
        "Two landmarks with a common error move together; what they have in common cancels in their difference.",
        "Worst after the closure: half way. Floor: the first pose. Distance of two fully correlated landmarks: exact.",
    ),
)
self_test.ask(
    "worst",
    "c",
    "loop just closed: which landmark is the least certain?  a: the first  b: the last  c: one half way round",
    "Think of a rope that is held at both ends.",
    {
        "a": "The first one was seen from the start, and it holds the loop.",
        "b": "It was the worst before. Now it hangs on the first landmark, which is near and well known.",
    },
)
self_test.ask(
    "unseen",
    "a",
    "a measurement of landmark 0; the sigma of landmark 9, not in view  a: stays or falls  b: may grow  c: stays",
    "P becomes P - K Z K': what is subtracted?",
    {"b": "K Z K' is a covariance: what is subtracted is never negative.", "c": "That is so without correlation only."},
)
self_test.ask(
    "floor",
    "b",
    "first position 0.3 m, heading exact, very many rounds: sigma of a landmark goes to  a: 0  b: 0.3 m  c: 0.15 m",
    "No sensor on the robot measures where the first pose was.",
    {
        "a": "The map becomes exact in itself, but nobody knows where it lies.",
        "c": "No measurement on the way tells anything about the first position: it does not even fall by half.",
    },
)
self_test.ask(
    "difference",
    "c",
    "two landmarks, each 0.3 m, correlation 1: sigma of their difference  a: 0.6 m  b: 0.42 m  c: 0",
    "P_aa + P_bb - P_ab - P_ba, with all four equal.",
    {"a": "That would be correlation -1.", "b": "That would be correlation 0."},
)
self_test.ask(
    "without",
    "b",
    "cross-covariances set to 0, then the loop is closed; what moves?  a: all  b: robot, seen landmark  c: nothing",
    "Which rows of P H' are not zero?",
    {
        "a": "A landmark moves only if it shares an error with what is measured.",
        "c": "The measurement depends on robot and seen landmark: they move.",
    },
)
