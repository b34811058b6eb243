"""Logs in and out: what robots did and saw, recorded, saved, loaded.

Read from below: `logs.py` is one robot or one sensor, `npz_file.py` and `csv_folder.py` are the two kinds of files,
`recording.py` is the whole, `recorder.py` makes one of a run.
"""

from .logs import ControlLog, RawLog
from .recorder import Recorder
from .recording import Recording

__all__ = ["ControlLog", "RawLog", "Recorder", "Recording"]
