"""Options that cannot be right are refused before the run, whether the user writes them for `slam` or the toolbox."""

import numpy as np
import pytest

from ekfslam_tutorial import slam, toolbox
from ekfslam_tutorial.slam import KnownIds

WRONG = [
    (dict(n_updates=1.5), "n_updates must be a whole number of 0 or more, or None, got 1.5"),
    (dict(max_lmks="ten"), "max_lmks must be a whole number of 0 or more, or None, got 'ten'"),
    (dict(reopen_after=0), "reopen_after must be a whole number of 1 or more, or None, got 0"),
    (dict(n_inits=(1.5, 2)), r"n_inits must be two whole numbers of 0 or more, or None, got \(1.5, 2\)"),
    (dict(n_inits=7), "n_inits must be two whole numbers of 0 or more, or None, got 7"),
    (dict(reopen_std=0.3), "reopen_std must be two finite numbers of 0 or more, got 0.3"),
    (dict(reopen_std=(1, 2, 3)), "reopen_std must be two finite numbers of 0 or more"),
    (dict(reopen_std=(0.1, -0.2)), "reopen_std must be two finite numbers of 0 or more"),
    (dict(reopen_std=(0.1, np.inf)), "reopen_std must be two finite numbers of 0 or more"),
    (dict(min_search=True), "min_search must be a whole number of 0 or more, got True"),
    (dict(min_rho=-5), "min_rho must be a positive number, got -5"),
    (dict(md2_threshold="9"), "md2_threshold must be a positive number, got '9'"),
    (dict(init_margin=-1000), "init_margin must be a number of 0 or more, got -1000"),
    (dict(min_inlier_ratio=None), "min_inlier_ratio must be between 0 and 1, got None"),
    (dict(association="known_ids"), r"association must be an object to call, such as KnownIds\(\), got 'known_ids'"),
    (dict(error="right"), "error must be 'invariant' or 'additive', got 'right'"),
    (dict(error="invariant", first_estimates=True), r"error must be 'additive' with first_estimates \(.*\), got 'inv"),
    (dict(association=KnownIds), r"association must be an object to call, such as KnownIds\(\), got <class"),
]


@pytest.mark.parametrize("kind", [slam.Options, toolbox.Options], ids=["slam", "toolbox"])
@pytest.mark.parametrize(("options", "message"), WRONG, ids=[m[:30] for _, m in WRONG])
def test_wrong_options(kind, options, message):
    with pytest.raises(ValueError, match=message):
        kind(**options)


@pytest.mark.parametrize("kind", [slam.Options, toolbox.Options], ids=["slam", "toolbox"])
def test_which_error_there_is_where_nobody_says(kind):
    assert kind().error == "invariant"
    assert kind(first_estimates=True).error == kind(first_estimates=True, error="additive").error == "additive"


@pytest.mark.parametrize("kind", [slam.Options, toolbox.Options], ids=["slam", "toolbox"])
def test_numbers_of_numpy_and_lists_are_as_good(kind):
    many = np.arange(1, 4)
    kind(n_updates=many[1], reopen_after=many[0], n_inits=[*many[:2]], reopen_std=np.zeros(2), md2_threshold=np.inf)
    kind(min_match_ratio=0, min_inlier_ratio=1, n_inits=None, reopen_std=[1, 0.0], init_margin=np.float32(2))
