"""`ekfslam data`: which data sets are here, whether they are whole, where to get the missing ones."""

from ..datasets import report


def main(options):
    """Run the command; 1 if something that is here is damaged."""
    text, ok = report(verify=not options.quick)
    print(text)
    return 0 if ok else 1
