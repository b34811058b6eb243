"""`ekfslam data`: which data sets are here."""

from .. import datasets


def main(options):
    """Run the command: the data sets know themselves."""
    return datasets.main(options.rest)
