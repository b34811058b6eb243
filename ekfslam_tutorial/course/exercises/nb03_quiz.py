"""Exercises 03.3 and 03.4 and the self-test of notebook 03: which filter is honest, and which bug is it?"""

from ..quiz import Quiz

# ---- 03.3 four mappers ---------------------------------------------------------------------------------------------

mappers = Quiz(
    "03.3",
    "Four mappers and their instruments",
    name="verdicts",
    hints=(
        "First the NEES and the NIS: above the band is over-confident, below the band is too cautious.",
        "A lie about the noise of the sensor moves NIS and NEES the same way. Information that is used twice does not "
        "change the noise: the NIS moves much less than the NEES.",
        "A pose that is wrong makes the picture itself wrong: the RMSE rises. Compare the RMSE of the four.",
    ),
)
_OPTIONS = "a: honest  b: told too much noise  c: uses each scan twice  d: its poses are wrong"
_SAYS = {
    "a": "An honest mapper has NIS and NEES inside their bands. Look at the table again.",
    "b": "Too much noise makes P and Z too large: NIS and NEES would be *below* their bands.",
    "c": "Double counting makes P too small, but the estimates hardly change: high NEES, and an RMSE as good as any.",
    "d": "With wrong poses the measurements contradict each other: high NIS, and a large RMSE.",
}
for _name, _right in zip("ABCD", "cadb", strict=True):
    mappers.ask(
        f"mapper_{_name}",
        _right,
        f"mapper {_name}?  {_OPTIONS}",
        "Compare its NIS, NEES and RMSE with those of the others.",
        {letter: says for letter, says in _SAYS.items() if letter != _right},
    )

# ---- 03.4 which bug is it? -----------------------------------------------------------------------------------------

bugs = Quiz(
    "03.4",
    "Which bug is it?",
    name="diagnosis",
    hints=(
        "Sort the panels: NIS far below 2, NIS exploded, NIS about 2. Each sort has its own bugs.",
        "NIS about 2 with a NEES far too high: the map and the pose have lost their correlation.",
        "The NIS compares with what is *told*: too much noise lowers it at once. A jump of 2 pi explodes it.",
    ),
)
_BUGS = "a: std taken for variance  b: bearing not wrapped  c: no cross-covariance  d: P_rm not moved  e: correct"
_NOT = {
    "a": "A standard deviation below 1 is larger than its square: told too much noise, the NIS would fall.",
    "b": "An innovation that is wrong by 2 pi throws everything away: RMSE, NIS and NEES would all explode.",
    "c": "Without the cross-covariance of new landmarks the NIS stays at 2; only the NEES shows it.",
    "d": "If P_rm does not follow the motion, P is no covariance any more: look at the last column.",
    "e": "A correct EKF has NIS 2 and NEES a little above 3. Look at the row again.",
}
for _name, _right in zip("PQRST", "cbade", strict=True):
    bugs.ask(
        f"panel_{_name}",
        _right,
        f"panel {_name}?  {_BUGS}",
        "Compare NIS, NEES and P >= 0 with those of the others.",
        {letter: says for letter, says in _NOT.items() if letter != _right},
    )

# ---- the self-test at the end --------------------------------------------------------------------------------------

self_test = Quiz(
    "03.self",
    "Self-test",
    name="self_test",
    hints=(
        "Go back to the section of each question; nothing here needs a long computation.",
        "The mean of a chi-square number is its degrees of freedom. More runs make the band narrower.",
        "NIS needs measurements only; NEES needs the truth. Neither is about how *small* the error is.",
    ),
)
self_test.ask(
    "one_sigma",
    "a",
    "share of landmarks inside their 1-sigma ellipse (2D), honest filter:  a: 39 %  b: 68 %  c: 95 %",
    "1 - exp(-k^2 / 2) with k = 1.",
    {
        "b": "68 % is right for one number. In the plane it is 1 - exp(-1/2).",
        "c": "That is 2 sigma of one number.",
    },
)
self_test.ask(
    "nees_5",
    "b",
    "20 runs, 3 states, average NEES 5.1. The filter is  a: honest  b: over-confident  c: too cautious",
    "The band for 20 runs and 3 states is 2.02 to 4.16.",
    {
        "a": "5.1 is above the band, 2.02 to 4.16.",
        "c": "A NEES that is too high means: errors larger than P says.",
    },
)
self_test.ask(
    "nis_needs",
    "c",
    "a real robot can compute the NIS: it needs  a: the true map  b: many runs  c: only the filter's own numbers",
    "z' Z^-1 z: where do z and Z come from?",
    {
        "a": "The *NEES* needs the truth.",
        "b": "One long run gives many innovations: their average is judged.",
    },
)
self_test.ask(
    "low_rmse",
    False,
    "filter A has a smaller RMSE than filter B. Is A the more honest one?  True / False",
    "The RMSE does not look at P at all.",
    {True: "The RMSE does not look at P: an accurate filter can lie about how accurate it is."},
)
self_test.ask(
    "nis_enough",
    "b",
    "NIS is in its band. Then  a: P is right  b: innovations fit, but P may be wrong  c: the noise is zero",
    "Remember the panel with NIS 2.0 and a NEES far too high.",
    {
        "a": "The NIS sees only H P H' + R, and R is often the larger part: P can be wrong.",
        "c": "Without noise Z would be too large, and the NIS far below its band.",
    },
)
