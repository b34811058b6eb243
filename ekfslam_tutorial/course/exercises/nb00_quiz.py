"""Exercise 00.2 and the self-test of notebook 00: the letters of other authors, and how the course works."""

from ..quiz import Quiz

# ---- 00.2 translate ------------------------------------------------------------------------------------------------

letters = Quiz(
    "00.2",
    "Translate the letters",
    name="translation",
    hints=(
        "All answers are in the table above. Find the author's column first, then the row of the meaning.",
        "What is it: something measured, something expected, or the difference? Noise of the sensor or of the motion?",
        "Here y is the measurement and z the innovation; R belongs to the sensor, U to the control.",
    ),
)
letters.ask(
    "lecture_R",
    "b",
    "the lecture's R (J_u R J_u') is here  a: R  b: U  c: Z",
    "In J_u R J_u' it stands beside the derivative by the control u.",
    {
        "a": "Here R is the noise of the *measurement*. The lecture's R stands beside J_u: it is noise of the control.",
        "c": "Z is the covariance of the innovation. The lecture's R is noise of the control.",
    },
)
letters.ask(
    "lecture_Q",
    "a",
    "the lecture's Q (in G P G' + Q) is here  a: R  b: U  c: Z",
    "It is added to the uncertainty of the expected measurement.",
    {
        "b": "U is the noise of the control, which enters in the prediction. Q is added to G P G' in the update.",
        "c": "Z is the whole sum G P G' + Q; Q is only a part of it.",
    },
)
letters.ask(
    "lecture_z",
    "b",
    "the lecture's z (what the sensor says) is here  a: z  b: y  c: e",
    "One letter each for what is measured, what is expected, and the difference.",
    {
        "a": "Here z is the *innovation*, measured minus expected. What the sensor says is y.",
        "c": "e is what the filter *expects* the sensor to say.",
    },
)
letters.ask(
    "filterpy_y",
    "a",
    "the y of filterpy (measured minus expected) is here  a: z  b: y  c: e",
    "What is the name of the difference between measured and expected?",
    {
        "b": "In filterpy y is the innovation; here y is the measurement. The two letters are exchanged.",
        "c": "e is what is expected. The difference has a letter of its own.",
    },
)
letters.ask(
    "corke_W",
    "a",
    "Corke's W (noise of the sensor) is here  a: R  b: U  c: P",
    "Noise of the sensor: the row 'noise of the measurement'.",
    {
        "b": "U is the noise of the control; Corke calls that V.",
        "c": "P is the uncertainty of the state, not of the sensor.",
    },
)

# ---- the self-test -------------------------------------------------------------------------------------------------

self_test = Quiz(
    "00.self",
    "Self-test",
    name="self_test",
    hints=(
        "Each answer stands in one of the sections above.",
        "Angles: write the two directions on a sheet of paper. Checks: read what they printed in this notebook.",
        "A check never stops the notebook: it hands on your function, or the reference solution.",
    ),
)
self_test.ask(
    "fallback",
    "b",
    "your answer fails; what does check(...) return?  a: an error  b: the reference solution  c: your answer",
    "Later cells must work in any case.",
    {
        "a": "A failed check raises no error: the notebook goes on.",
        "c": "Your wrong answer would spoil all later cells: check returns the reference solution instead.",
    },
)
self_test.ask(
    "difference",
    "c",
    "heading 179 deg, compass -179 deg: how far is the compass from the heading?  a: -358 deg  b: -2 deg  c: +2 deg",
    "Subtract (compass minus heading), then wrap.",
    {
        "a": "The difference is not wrapped: nearly a whole turn for two directions that are nearly the same.",
        "b": "The size is right. The sign: from 179 deg go on to the *left* by 2 deg, and you are at 181 = -179 deg.",
    },
)
self_test.ask(
    "units",
    "a",
    "angles inside the package are in  a: radians  b: degrees  c: both, by the size of the number",
    "Which unit did wrap have?",
    {
        "b": "Degrees are for figures and for the user's files, where the name says so (..._deg). Inside: radians.",
        "c": "No number tells its unit. Inside the package all angles are in radians.",
    },
)
self_test.ask(
    "innovation",
    "c",
    "the innovation is, in this course,  a: y  b: e  c: z",
    "Measured minus expected.",
    {"a": "y is the measurement itself.", "b": "e is the expected measurement."},
)
self_test.ask(
    "three_sigma",
    "b",
    "share of honest estimates inside a 3-sigma ellipse in the plane:  a: 99.7 %  b: 98.9 %  c: 100 %",
    "Look at the caption of the figure with the legend.",
    {
        "a": "99.7 % is for one number. In two dimensions there is more room outside: 98.9 %.",
        "c": "A Gaussian has no end: about one in ninety lies outside.",
    },
)
