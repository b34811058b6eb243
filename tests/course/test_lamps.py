"""What notebooks 01 and 04 say of the sign lamps and of the dragged correlation, computed."""

import numpy as np
import pytest

from ekfslam_tutorial.analysis.consistency import anees_band
from ekfslam_tutorial.course.draws import nb01_lamp, nb04_drag


def red(mistake, heading=30.0, rate=40.0):
    """How many entries and which readings are red: prediction (p), NIS (n), correction (c)."""
    used, numeric, (predicted, corrected), nis = nb01_lamp.tried(mistake, heading, rate)
    entries = sum((abs(getattr(used, J) - getattr(numeric, J)) > 1e-6).sum() for J in ("F_x", "F_u", "H"))
    alarms = ""
    for letter, values, dof in ("p", predicted, 3), ("n", nis, 2), ("c", corrected, 3):
        low, high = anees_band(dof, nb01_lamp.RUNS, 0.999)
        alarms += "" if low < values.mean() < high else letter
    return entries, alarms


@pytest.mark.parametrize("heading", [-180.0, -70.0, 0.0, 30.0, 90.0])
@pytest.mark.parametrize("rate", [0.0, 60.0])
def test_without_a_mistake_no_lamp_is_red(heading, rate):
    assert red("none", heading, rate) == (0, "")


def test_the_sign_of_the_innovation_is_seen_by_the_errors_alone():
    assert red("z: expected minus measured") == (0, "c")


def test_a_jacobian_taken_too_late_is_seen_by_finite_differences_alone_and_only_in_a_turn():
    assert red("F_x, F_u: taken after the move") == (4, "")
    assert red("F_x, F_u: taken after the move", rate=0.0) == (0, "")


def test_a_wrong_sign_hides_where_its_term_is_zero():
    assert red("F_x: sign of the sine", heading=0.0) == (0, "")
    assert red("F_x: sign of the sine", heading=90.0) == (1, "pn")


@pytest.mark.parametrize("rho", [-0.5, 0.0, 0.9])
def test_b_follows_a_as_a_conditional_gaussian(rho):
    """B given the measured A, from the blocks: B + P_BA (P_AA + R)^-1 z, P_BB - P_BA (P_AA + R)^-1 P_AB."""
    P, x, after = nb04_drag.seen(rho, shift=1.0, noise=0.2)
    A, B = nb04_drag.A, nb04_drag.B
    gain = P[B, A] @ np.linalg.inv(P[A, A] + 0.2**2 * np.eye(2))
    np.testing.assert_allclose(x[B], nb04_drag.PLACES[B] + gain @ [1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(after[B, B], P[B, B] - gain @ P[A, B], atol=1e-12)
    assert (rho == 0.0) == np.allclose(x[B], nb04_drag.PLACES[B])
