"""How long a user waits before anything happens: the import, and the first figure of a notebook."""

import json
import subprocess
import sys

CLOCK = "import time; start = time.perf_counter()"
TELL = "import json, sys; print(json.dumps([time.perf_counter() - start, 'matplotlib' in sys.modules]))"
FIGURE = """
from ekfslam_tutorial.course import check, explore, hint, progress, replay, reveal, show
from ekfslam_tutorial.course.draws import nb00
from ekfslam_tutorial.course.figures import png
from ekfslam_tutorial.graphics import use_style
use_style()
png(nb00.legend_figure()[0])
"""
WAITS = {"import ekfslam_tutorial": "import ekfslam_tutorial", "first figure of notebook 00": FIGURE}


def run(repeats):
    """Rows: what, seconds (least and median of fresh processes), and whether matplotlib came along."""
    rows = []
    for what, code in WAITS.items():
        script, found = f"{CLOCK}\n{code}\n{TELL}", []
        for _ in range(repeats):
            out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
            found.append(json.loads(out))
        seconds = sorted(one[0] for one in found)
        rows.append(
            {
                "what": what,
                "least_s": seconds[0],
                "median_s": seconds[len(seconds) // 2],
                "matplotlib": any(one[1] for one in found),
            }
        )
    return rows
