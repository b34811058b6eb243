"""Recorder: the frames of a run become a recording."""

import numpy as np

from .logs import ControlLog
from .recording import Recording


class Recorder:
    """Collector of the frames of a run, for a `Recording`.

    Examples
    --------
    >>> recorder = Recorder()
    >>> for snapshot in universal_slam(userdata):
    ...     recorder.add(snapshot)
    >>> recorder.recording("my run").save("my_run.npz").name
    'my_run.npz'
    """

    def __init__(self):
        self._t, self._controls, self._raw, self._met, self._truth, self._landmarks = [], {}, {}, {}, {}, None

    def add(self, snapshot):
        """Keep one frame: copies of the controls, the raw data and the true poses."""
        self._t.append(snapshot.t)
        self._landmarks = snapshot.sim_lmk
        for rob in snapshot.robs:
            self._controls.setdefault(rob.id, []).append((np.array(rob.u), np.array(rob.U), rob.dt))
        for sen, obs in snapshot.raw.items():
            self._raw.setdefault(sen, []).append(obs)
        for sen, obs in snapshot.met.items():
            self._met.setdefault(sen, []).append(obs)
        for rob, x in snapshot.truth.items():
            self._truth.setdefault(rob, []).append(np.array(x))

    def recording(self, name, notes=()):
        """Make a recording of all frames so far."""
        robots = {}
        for i, controls in self._controls.items():
            u, U, dt = zip(*controls, strict=True)
            if u[0].ndim == 1:
                robots[i] = ControlLog(np.array(u), np.array(U))
            else:  # many a frame
                rows = np.cumsum([0, *map(len, u)])
                robots[i] = ControlLog(np.concatenate(u), np.concatenate(U), rows, np.concatenate(dt))
        truth = {i: np.array(x) for i, x in self._truth.items()}
        return Recording(name, np.array(self._t), robots, self._raw, truth, self._landmarks, list(notes), self._met)
