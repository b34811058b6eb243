"""How long a user waits before anything happens: the import."""

import json
import subprocess
import sys

IMPORT = """
import time; start = time.perf_counter()
import ekfslam_tutorial
import json, sys
print(json.dumps({"seconds": time.perf_counter() - start, "matplotlib": "matplotlib" in sys.modules}))
"""


def run(repeats):
    """Rows: what, seconds (least and median of fresh processes), and whether matplotlib came along."""
    found = []
    for _ in range(repeats):
        out = subprocess.run([sys.executable, "-c", IMPORT], capture_output=True, text=True, check=True).stdout
        found.append(json.loads(out))
    seconds = sorted(one["seconds"] for one in found)
    return [
        {
            "what": "import ekfslam_tutorial",
            "least_s": seconds[0],
            "median_s": seconds[len(seconds) // 2],
            "matplotlib": any(one["matplotlib"] for one in found),
        }
    ]
