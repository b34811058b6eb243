"""The self-test of notebook 09."""

from ..quiz import Quiz

self_test = Quiz(
    "09.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question: times, barcodes, clock, noise, gauge.",
        "What is unknown, and what do the data fix? What does a number tell when you only make R larger?",
        "A wrong landmark is worse than none. A sum of squares must be small for stamps, near its mean for R.",
    ),
)
self_test.ask(
    "spurious",
    "b",
    "a barcode is in no list, and comes twice in 5 min:  a: new landmark  b: drop it  c: take the nearest code",
    "How sure are you what it was? What does a wrong landmark do to the map?",
    {
        "a": "Twice in thousands of sightings is a reading error; what is really there comes again and again.",
        "c": "Codes are labels: 3 is not nearly 4. The row would correct a landmark that was not seen.",
    },
)
self_test.ask(
    "gap",
    "c",
    "odometry is missing for 1.2 s while driving; best:  a: stand still  b: no noise  c: hold the command",
    "What does the robot most likely do in the gap, and how sure are you?",
    {
        "a": "The robot drives on: it would be wrong by the whole way.",
        "b": "Nothing is less certain than a gap: noise must go on growing with time and way.",
    },
)
self_test.ask(
    "minimise",
    "a",
    "which may be found as the minimum of the mean NIS?  a: clock offset  b: R  c: both",
    "Make R very large: what does the NIS do?",
    {
        "b": "The NIS falls for ever when R grows. For R it must be *near its ideal*, 2.",
        "c": "The offset, yes. But the NIS falls for ever when R grows.",
    },
)
self_test.ask(
    "gauge",
    3,
    "range and bearing in the plane: how many numbers does the alignment of a map have?",
    "A rigid motion in the plane: which numbers describe it?",
    {
        2: "Moving has two numbers; the direction of the start is not known either.",
        4: "The scale is not free: ranges fix it.",
        6: "That is space; here it is the plane.",
    },
)
self_test.ask(
    "align",
    "c",
    "why is aligning legal?  a: it makes errors small  b: all do it  c: no measurement depends on it",
    "Move and turn robot and map together: which range, which bearing changes?",
    {
        "a": "A scale would make them smaller still, and is not legal here.",
        "b": "True, but no reason. What do the measurements say about the frame of the map?",
    },
)
