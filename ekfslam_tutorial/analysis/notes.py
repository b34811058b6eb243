"""What a run should be told for: sentences on figures that are not as they should be, each with a next step.

All of it is known without the truth, except the NEES. An honest run says nothing.
"""

import numpy as np

from ..ekf import chi_square
from ..models.landmarks import PlkLin
from ..slam.association import gate
from ..toolbox.scenario.agreement import started_by
from .consistency import anees_band, chi2_band

FEW = 50
"""So many frames may pass without a landmark being measured a second time."""
MORE = 0.02
"""Share of innovations that may be refused beyond what the gate refuses of right ones."""
MANY = 0.2
"""If more than this share is refused, something is wrong with the log, not with a few of its measurements."""
SURPRISED = 10
"""Squared innovations so many times as large as expected are not a question of tuning: something is wrong."""
NIS_BAND = 0.8, 1.25
"""The mean NIS may be so many times what is expected, for filters are not linear; and as far as chance takes it."""
CONFIDENCE = 0.9999
"""Of the band of chance of the NIS."""
NEES_CONFIDENCE = 0.99
"""Of the band of the mean NEES. The frames of a run are correlated: they count as one pose."""
BEYOND = 2.0
"""A prior whose mean is less than so many of its standard deviations reaches over infinity: in 2.3 % of its lines."""
ONCE = 0.3
"""If more than this share of the landmarks was measured once only, some are none, or are there twice."""
ASK = "are units, signs, mounting, ids and noise right?"
SIGN = "is the sign of the bearing right (positive to the left), and are units, mounting, ids and noise?"
MOUNTING = "first look at the mounting of the sensor, the sign of y and bearings, and the compass"
"""They look like noise, and no noise mends them."""
TUNE = "`ekfslam tune` finds a factor for R and U from the log alone"


def notes(figures, data, recording=None):
    """Sentences on what is not as it should be in a run.

    Parameters
    ----------
    figures : dict
        From `History.summary`.
    data : UserData
    recording : Recording, optional
        What was played.

    Returns
    -------
    list of str
        One sentence each: what was found, what would be right, what to do next. If the measurements do not fit at all,
        only that is said, and not what follows from it.
    """
    found = [*ids_left_out(data, recording), *copies(data, recording)] if recording else []
    gross = gross_fault(figures, data)
    if gross:
        return [*found, gross]
    return [*found, *filter(None, (f(figures, data) for f in (refused, once, rings, nis, ratio, nees, far_lines)))]


def ids_left_out(data, recording):
    """Measurements without an id, which `known_ids` passes over."""
    if not getattr(data.options.association, "by_id", False):
        return
    for sensor in (s for s in data.sensors if not hasattr(s.model, "without_lmks")):
        ids = recording.raw[sensor.id].ids if sensor.id in recording.raw else np.zeros(0, int)
        without = int((ids < 0).sum())
        if without:
            yield (
                f"{without:,} of the {len(ids):,} measurements of sensor {sensor.id} have the id -1, and known_ids "
                "passes over them: --set options.association=nearest_neighbour uses all"
            )


def copies(data, recording):
    """Measurements that are there twice in a frame, of which `known_ids` uses the first."""
    if not getattr(data.options.association, "by_id", False):
        return
    for log in (recording.raw[s.id] for s in data.sensors if s.id in recording.raw):
        known = log.ids >= 0
        frames = np.repeat(np.arange(len(log)), np.diff(log.offsets))
        rows = np.column_stack([frames, log.ids, log.y])[known] if len(log.ids) else np.zeros((0, 2))
        n = len(rows) - len(np.unique(rows, axis=0))
        if n:
            yield (
                f"{n:,} of the {len(log.ids):,} measurements of sensor {log.sen} are copies of another one in a frame "
                "and were dropped: what is told twice is not known better"
            )


def gross_fault(figures, data):
    """Find signs that the log is not what the scenario takes it for."""
    n, refused = figures["n_innovations"], figures["n_refused"]
    if not n and figures["frames"] > FEW:
        return f"no landmark was measured a second time: {ASK}"
    if refused > MANY * n and refused > 5:
        ask = SIGN if any("rad" in getattr(sensor.model, "units", ()) for sensor in data.sensors) else ASK
        return f"of {n:,} innovations {refused:,} did not pass the gate: {ask}"
    if (figures["nis_mean"] or 0.0) > SURPRISED * (figures["nis_dof"] or 0.0):
        return f"the mean NIS is {figures['nis_mean']:.3g}, and {figures['nis_dof']:.3g} is expected: {ASK}"
    return None


def refused(figures, data):
    """A few per cent of the innovations are refused: of right ones the gate refuses less."""
    n, refused, threshold = figures["n_innovations"], figures["n_refused"], data.options.md2_threshold
    if not n or not figures["nis_dof"]:
        return None
    right = 1.0 - float(chi_square.cdf(threshold, figures["nis_dof"]))
    too_many = refused - right * n
    if too_many <= max(MORE * n, 5 * np.sqrt(n * right * (1 - right)) + 5):
        return None
    return (
        f"{100 * refused / n:.1f} % of {n:,} innovations did not pass the gate, {100 * right:.2g} % would be right, "
        "and nis_mean does not count them: compare with a run without a gate, --set options.md2_threshold=inf, "
        "and look where they are refused; the noise may be told too small"
    )


def once(figures, data):
    """Many landmarks were never found again, where nobody says whose a measurement is."""
    n, all = figures.get("n_seen_once", 0), figures.get("n_landmarks") or 0
    if getattr(data.options.association, "by_id", False) or n <= max(ONCE * all, 5):
        return None
    return (
        f"{n} of {all} landmarks were measured once only. False ones go with --set options.min_search=10 --set "
        "options.min_match_ratio=0.3 and with --set sensor.1.max_range=..., m, beyond which nothing is looked for. If "
        "true ones start again and again, the mounting or the sign of bearings or y is wrong, or the noise is told too "
        "small"
    )


def rings(figures, data):
    """Beacons that were heard and are no landmarks."""
    n = figures.get("n_rings", 0)
    if not n:
        return None
    beacons = "a beacon that was heard is" if n == 1 else f"{n} beacons that were heard are"
    return (
        f"{beacons} still a ring of hypotheses, and no landmark: ranges from a straight path do not tell on which side "
        "it is, and ranges with little noise bend too much for a Gaussian from far away; where the odometry drifts "
        "fast besides, such a ring begins anew rather than choose wrongly"
    )


def nis_band(figures, data):
    """Band of the mean NIS of an honest filter: (low, high); of innovations that a gate has let pass.

    What passes a gate at d^2 has the mean m F(d^2; m + 2) / F(d^2; m), F the distribution of chi-square.
    """
    m, n = figures["nis_dof"], max(figures["n_innovations"] - figures["n_refused"], 1)
    confidence = getattr(data.options.association, "confidence", None)
    threshold = min(data.options.md2_threshold, gate(confidence, m) if confidence else np.inf)
    mean = m * float(chi_square.cdf(threshold, m + 2) / chi_square.cdf(threshold, m)) if threshold < np.inf else m
    low, high = (bound / m for bound in anees_band(m, n, CONFIDENCE))
    return mean * NIS_BAND[0] * min(low, 1), mean * NIS_BAND[1] * max(high, 1)


def nis(figures, data):
    """The innovations are larger, or smaller, than the filter expects."""
    if figures["nis_mean"] is None:
        return None
    low, high = nis_band(figures, data)
    value, should = figures["nis_mean"], f"an honest filter has {low:.2f} to {high:.2f} here"
    if value > high:
        return f"the mean NIS is {value:.3g}, {should}: {MOUNTING}; else R or U is told too small, and {TUNE}"
    if value < low:
        return (
            f"the mean NIS is {value:.3g}, {should}: R or U is told too large; perhaps on purpose, "
            "because errors last: then the NIS is no guide, and correction_ratio is"
        )
    return None


def ratio(figures, data):
    """The corrections go the same way for too long."""
    value, seconds, limit = (figures[f"correction_ratio{end}"] for end in ("", "_s", "_limit"))
    if value is None or value <= limit:
        return None
    return (
        f"sums of corrections over {seconds} s are {value:.2g} times as large, squared, as the filter expects, and up "
        f"to {limit:.2g} would be chance: it is too sure of the pose; {MOUNTING}; then {TUNE}"
    )


def nees(figures, data):
    """The errors are larger, or smaller, than the filter thinks; the truth is needed for that."""
    if figures["nees_mean"] is None or not figures["nees_dof"]:
        return None
    low, high = chi2_band(figures["nees_dof"], NEES_CONFIDENCE)
    value, right = figures["nees_mean"], f"{figures['nees_dof']} is right and {low:.2g} to {high:.3g} would be chance"
    if value > high:
        return f"the mean NEES is {value:.3g}, {right}: the errors are larger than the filter thinks; {TUNE}"
    if value < low:
        return f"the mean NEES is {value:.2g}, {right}: the filter is too cautious; R, U or the start is told too large"
    return None


def far_lines(figures, data):
    """Plücker lines without an anchor, of which some are born beyond infinity: they become too sure of a direction."""
    n, N = data.landmark.prior()
    plucker = [k for k in (started_by(data, s) for s in data.sensors) if isinstance(k, PlkLin)]
    std = np.sqrt(N.diagonal().max())
    if not plucker or np.linalg.norm(n) >= BEYOND * std:
        return None
    return (
        f"lines are born with the inverse distance {np.linalg.norm(n):.3g} and a standard deviation of {std:.3g} 1/m: "
        "Plücker lines without an anchor may become too sure with a prior so wide; landmark.type=apl_lin, which has "
        "one, holds it"
    )
