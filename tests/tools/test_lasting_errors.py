"""Errors that last: three kinds of one walk, of those that `tools/lasting_errors.py` makes 16 walks of."""

from itertools import islice
from pathlib import Path

import numpy as np


def test_a_factor_for_errors_that_last_and_none_for_white_noise(monkeypatch):
    """The same seed, the same numbers: bands of a NEES would be those of one walk, so only the order is asked."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "tools"))
    from lasting_errors import judged, lasting, walk

    data, log = walk(1, eights=2)
    assert (np.diff(log.raw[1].offsets) > 0).all()  # a robot that sees nothing has no corrections to be judged by
    kinds = islice(lasting(log, np.random.default_rng(1)), 3)
    white, *wrong = [judged(data, each) for _, each, _ in kinds]
    assert (white == white[0]).all() and white[0] < 1.7
    for nees, by_map, by_robot, larger, residuals, both in wrong:
        assert nees > white[0] and max(by_map, by_robot, residuals) < nees
        assert larger == min(by_map, by_robot)
        assert abs(np.log(both)) < abs(np.log(nees))
