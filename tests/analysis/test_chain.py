"""Elimination in the order of time: solutions and marginals are those of the dense matrix."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from ekfslam_tutorial.analysis.chain import Chain, is_chain


def system(frames, lasting, seed=1):
    """An indefinite symmetric matrix whose frames meet their neighbours, and the frame of each row, in disorder."""
    rng = np.random.default_rng(seed)
    when = rng.permutation(np.concatenate([np.repeat(np.arange(len(frames)) + 3.0, frames), np.full(lasting, np.inf)]))
    M = rng.normal(size=(len(when),) * 2)
    apart = np.where(np.isfinite(when), when, 0)
    far = (np.abs(apart[:, None] - apart) > 1) & np.isfinite(when) & np.isfinite(when)[:, None]
    M = np.where(far, 0.0, M + M.T)
    return M + np.diag(rng.choice([-20.0, 20.0], len(when))), when


@pytest.mark.parametrize("frames, lasting", [([2, 5, 3, 4, 1], 6), ([3, 3, 3], 0), ([4], 2), ([], 5)], ids=str)
def test_it_is_the_dense_one(frames, lasting):
    M, when = system(frames, lasting)
    chain, inverse, rng = Chain(csr_array(M), when), np.linalg.inv(M), np.random.default_rng(2)
    assert is_chain(csr_array(M), when)
    for b in (rng.normal(size=len(M)), rng.normal(size=(len(M), 3))):
        np.testing.assert_allclose(chain.solve(b), inverse @ b, atol=1e-12)
    rows = [np.flatnonzero(when == k) for k in np.unique(when)]
    for found, r in zip(chain.inverse_at([r[::-1] for r in rows]), rows, strict=True):
        np.testing.assert_allclose(found, inverse[np.ix_(r[::-1], r[::-1])], atol=1e-12)


def test_frames_that_meet_others_are_no_chain():
    M, when = system([2, 2, 2], 1)
    i, j = np.flatnonzero(when == 3)[0], np.flatnonzero(when == 5)[0]
    M[i, j] = M[j, i] = 1.0
    assert not is_chain(csr_array(M), when)


def test_a_singular_one_is_refused():
    M, when = system([2, 2], 1)
    M[when == 4] = 0.0
    with pytest.raises(np.linalg.LinAlgError):
        Chain(csr_array(M), when)
