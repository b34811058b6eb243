"""`ekfslam progress`: which exercises are done."""

from ..course.checks import progress


def main(options):
    """Run the command."""
    number = options.notebook
    progress(number.zfill(2) if number and number.isdecimal() else number)
    return 0
