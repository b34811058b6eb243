"""`ekfslam nbgrader NN COURSE`: a notebook as an assignment of an nbgrader course."""

from pathlib import Path

from ..course import nbgrader


def main(options):
    """Run the command."""
    written = nbgrader.write(options.notebook, Path(options.course))
    print(f"written: {written} (with solutions and hidden tests: not for students)")
    print(f"next: cd {options.course} && nbgrader generate_assignment {written.stem} --create")
    return 0
