"""GTSAM's batch beside the filter on the flight of EuRoC. Needs EKFSLAM_DATA and the package gtsam."""

import re

import pytest


def test_both_stay_near_the_truth(data_dir, capsys):
    """The first half: the take-off and 10 s of flight. Measured: filter 0.016 m, GTSAM 0.009 m."""
    pytest.importorskip("gtsam", reason="GTSAM is not installed: pip install gtsam")
    from benchmarks import flight

    flight.main(["--set", "data.last=300"])
    lines = re.findall(r"^(filter|GTSAM).*?position ([\d.]+) m", capsys.readouterr().out, re.M)
    errors = {name: float(error) for name, error in lines}
    assert set(errors) == {"filter", "GTSAM"} and max(errors.values()) < 0.04
