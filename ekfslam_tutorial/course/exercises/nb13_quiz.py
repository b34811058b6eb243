"""The self-test of notebook 13."""

from ..quiz import Quiz

self_test = Quiz(
    "13.self",
    "Self-test",
    name="self_test",
    hints=(
        "Each question has its section: a ray, two Gaussians, six numbers, and the change to three.",
        "A pixel has two numbers, a point three. A Gaussian in rho holds rho = 0 as an ordinary value.",
        "Two landmarks born in one picture have one and the same anchor. Converting too early freezes a bad Gaussian.",
    ),
)
self_test.ask(
    "one_pixel",
    "b",
    "one pixel fixes  a: a point  b: a ray, and so a point only together with a prior  c: a distance",
    "Count: how many numbers does a pixel have, and how many a point?",
    {
        "a": "All points of a ray have the same pixel. The distance must come from elsewhere.",
        "c": "Of direction and distance the pixel gives the direction.",
    },
)
self_test.ask(
    "large_sigma",
    "a",
    "depth unknown, Gaussian in depth with a huge sigma:  a: still wrong in shape  b: right, only slow  c: right",
    "What shape has the posterior of a depth after small parallax? Is it symmetric?",
    {
        "b": "More measurements do not help: half of the runs ended outside the gate after 20 angles.",
        "c": "A huge sigma also holds depths behind the camera, and h is far from linear over it.",
    },
)
self_test.ask(
    "prior_variance",
    "c",
    "right after the birth, the variance of rho is  a: zero  b: that of the pixel  c: that of the prior",
    "What does one pixel say about the distance?",
    {
        "a": "Zero would mean: the distance is known.",
        "b": "The pixel noise goes into pitch and yaw.",
    },
)
self_test.ask(
    "anchors",
    "c",
    "two landmarks born in one picture: their anchors are  a: independent  b: a little correlated  c: the same error",
    "Where is the anchor of each, and what error does that place have?",
    {
        "a": "Then the map would believe in two independent origins. Look at the heat map again.",
        "b": "Both anchors are copies of one and the same camera position: correlation 1.",
    },
)
self_test.ask(
    "when",
    "b",
    "when may a landmark become three Euclidean numbers?  a: at once  b: when its linearity index is small  c: never",
    "The conversion keeps mean and covariance. When is that enough to describe what is known?",
    {
        "a": "That freezes the Gaussian in depth, which leaves half of the runs outside the gate.",
        "c": "Six numbers cost twice the room, and four times the time, of three. Once it is linear, convert.",
    },
)
