"""Errors that last: three kinds of one walk, of those that `tools/lasting_errors.py` makes 16 walks of."""

from itertools import islice
from pathlib import Path

import numpy as np
import pytest


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


def test_what_was_found_so_far_is_a_table(monkeypatch, capsys):
    """Interrupted in the second walk: the kinds of one walk and of two."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "tools"))
    import lasting_errors

    def study(seeds, in_full):
        for seed in seeds:
            for name in ("white", "lasts"):
                if (seed, name) == (2, "lasts"):
                    raise KeyboardInterrupt
                yield seed, name, seed * np.arange(1.0, 7.0)

    monkeypatch.setattr(lasting_errors, "study", study)
    monkeypatch.setattr("sys.argv", ["lasting_errors.py", "--walks", "3"])
    lasting_errors.main()
    out, err = capsys.readouterr()
    assert "walk 2 of 3, white" in err and "interrupted" in err
    _, white, lasts, off, _ = out.splitlines()
    assert white.split()[1:3] == ["1.50", "(50%)"] and white.endswith(" 2") and lasts.endswith(" 1")
    assert float(off.split()[-6]) == pytest.approx(np.log(2) / 4, abs=0.005)
