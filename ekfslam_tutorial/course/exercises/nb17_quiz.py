"""Quizzes of notebook 17: four anonymous landmark types, and the self-test."""

from ..quiz import Quiz

judge = Quiz(
    "17.3",
    "Four anonymous landmark types",
    name="judged",
    hints=(
        "The numbers of the map first: 7 are the robot's, the rest is shared by the landmarks.",
        "(numbers - 7) / landmarks is 3, 4, 6 or 7. The NEES then tells what becomes of it.",
        "eucPnt 3, hmgPnt 4, idpPnt 6, ahmPnt 7. Of those that are honest with good odometry, take the smallest map.",
    ),
)
judge.ask(
    "four_numbers",
    "d",
    "which letter, a to d, is hmgPnt: 4 numbers for each landmark, from the world's origin?",
    "(numbers - 7) / landmarks must be 4.",
    {
        "a": "(211 - 7) / 34 = 6: that one stores an anchor, two angles and an inverse distance.",
        "b": "Only 3 numbers for each landmark: a Euclidean point.",
        "c": "7 numbers for each landmark: the largest map of all.",
    },
)
judge.ask(
    "guessed",
    "b",
    "which letter is eucPnt, started at a guessed depth?",
    "A Gaussian in depth is wrong in shape from its birth on: it is dishonest in both pictures, and stores 3 numbers.",
    {
        "a": "That one is honest with good odometry.",
        "c": "That one is honest with good odometry.",
        "d": "Nearly honest with good odometry, and 4 numbers for each landmark. One letter is far worse.",
    },
)
judge.ask(
    "same",
    "b",
    "A and C have one and the same NEES. They differ in  a: nothing  b: the size of the map  c: the prior",
    "Read the numbers in the map.",
    {
        "a": "One has 6, the other 7 numbers for each landmark.",
        "c": "All have the same prior of the inverse distance.",
    },
)
judge.ask(
    "choose",
    "a",
    "good odometry, one camera: which letter is honest with the smallest map?",
    "First honesty, then size: of those in or near the band, the one with fewer numbers.",
    {
        "b": "The smallest map, but a NEES of hundreds: it does not know how wrong it is.",
        "c": "Honest, but with 7 numbers where 6 do the same.",
        "d": "Small, but its NEES leaves the band early, and goes to hundreds with poor odometry.",
    },
)
judge.ask(
    "cure",
    "c",
    "poor odometry: no letter is honest. What helped?  a: more runs  b: 7 numbers instead of 6  c: measured depth",
    "Compare with the last row of the table before: the same odometry, another camera.",
    {
        "a": "More runs make the band narrower. They say more clearly that the filter is not honest.",
        "b": "A and C have the same NEES: the seventh number changes nothing.",
    },
)

self_test = Quiz(
    "17.self",
    "Self-test",
    name="self_test",
    hints=(
        "Each question has its section: errors of a pose, the band, the landmark types, the size of the map.",
        "A pose in space has 3 + 3 degrees of freedom. The mean of R runs scatters like 1 / sqrt(R).",
        "The time of a correction goes with the square of the numbers in the map: (7/3)^2 is more than 5.",
    ),
)
self_test.ask(
    "dof",
    6,
    "the mean NEES of an honest pose in space (a number)",
    "Degrees of freedom, not numbers in the state.",
    {
        7: "A quaternion has 4 numbers and 3 degrees of freedom: its length is always 1.",
        3: "That is a pose in the plane, or a position in space.",
    },
)
self_test.ask(
    "singular",
    "b",
    "P of [t, q] has no inverse, because  a: of rounding  b: q cannot change along itself  c: the filter is wrong",
    "The length of q is 1, whatever the orientation.",
    {
        "a": "Rounding is what makes it *seem* to have one: then the inverse is noise.",
        "c": "It would be wrong if it had full rank.",
    },
)
self_test.ask(
    "runs",
    "a",
    "four times as many runs make the band of the mean NEES  a: half as wide  b: a quarter as wide  c: no different",
    "It is a mean of independent numbers.",
    {
        "b": "The variance is a quarter; the width goes with its root.",
        "c": "A mean of more numbers scatters less.",
    },
)
self_test.ask(
    "honest",
    False,
    "True or False: the filter with the smaller position error is the more honest one.",
    "Honest means: the error is as large as the filter says.",
    {True: "A filter can be off by 1 m and say so. Error and honesty are two readings: you need both."},
)
self_test.ask(
    "cost",
    "c",
    "34 landmarks of 7 numbers instead of 3: a correction costs about  a: as much  b: twice  c: five times",
    "The covariance has n^2 numbers, and each is touched.",
    {
        "a": "The covariance has n^2 entries, and n has more than doubled.",
        "b": "The state is about twice as long; the covariance has the square of it.",
    },
)
