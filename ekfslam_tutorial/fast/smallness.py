"""What counts as small where virtual states are made: `virtual.py`, and its loops in `compiled/`."""

EXPLAINED = 4e-15
"""Where no more than this share of a variance is left, given the others, nothing is left: `cholesky`."""

FLOOR = 1e-8
"""By this share the variances in L are larger: far more than rounding errors, 1e-16, and too little to cost digits."""

STILL = 1e-12  # of the largest variance: a state that is known as well as this counts as one that is known so well
TRIALS = 8  # each with 100 times the D of the one before
TINY = 1e-200
