"""`ekfslam progress`: which exercises are done."""

from ..course.checks import progress


def main(options):
    """Run the command."""
    progress(options.notebook)
    return 0
