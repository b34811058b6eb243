"""Real logs as recordings, and where to find them.

Lives here: readers of the files that others publish, what is known to be wrong with them, and what calibrates a log.
May not: estimate, draw, or download without being asked.
"""

from .listing import DATASETS, check, report
from .registry import LOADERS, load_recording, prepare
from .sources import data_folders

__all__ = ["DATASETS", "LOADERS", "check", "data_folders", "load_recording", "prepare", "report"]
