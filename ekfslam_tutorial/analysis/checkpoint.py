"""A run that can be stopped at any moment and taken up again: its state and its history, in one file, now and then."""

from pathlib import Path

from ..toolbox import identity
from ..toolbox.files import value_file
from ..toolbox.run_state import run_state

FORMAT = "ekfslam checkpoint 2"


class Checkpoint:
    """Keeps a run every so many frames. Whatever happens in between, the last state kept is there, whole.

    Parameters
    ----------
    path : path
        The file. It is replaced in one step.
    data : UserData
    recording : Recording or None
        What is played.
    history : History
        It has seen each frame before this does.
    every : int
        Frames.
    n_frames : int
        Of the whole run. After the last one there is nothing to go on to.

    Raises
    ------
    ValueError
        For an interval that is no positive number of frames.
    """

    def __init__(self, path, data, recording, history, every, n_frames):
        if every < 1:
            raise ValueError(f"a run is kept every 1 or more frames, got {every}")
        self.path, self._data, self._history = Path(path), data, history
        self._every, self._n_frames = every, n_frames
        self._head = _head(data, recording)

    def add(self, snapshot):
        """Keep the run after this frame, if its turn has come."""
        done = snapshot.k - self._data.time.first + 1
        if done % self._every == 0 and done < self._n_frames:
            self.save(snapshot)

    def save(self, snapshot):
        """Keep the run after this frame."""
        state = {"run": run_state(snapshot, self._data), "history": self._history.state()}
        value_file.save(self.path, self._head | state)


def resume(path, data, recording, history):
    """Return what a checkpoint holds of this run.

    Parameters
    ----------
    path : path
    data : UserData
    recording : Recording or None
    history : History
        A new one; it gets what the old one had.

    Returns
    -------
    dict
        For `universal_slam(..., resume=...)`.

    Raises
    ------
    ValueError
        If the file is damaged, or was made of other inputs or by another version; it says what has changed.
    FileNotFoundError
    """
    kept = value_file.load(path)
    if not isinstance(kept, dict) or kept.get("format") != FORMAT:
        raise ValueError(f"{path} is no checkpoint of a run")
    head = _head(data, recording)
    if kept["program"] != head["program"]:
        raise ValueError(
            f"{path} is of another version of the program ({kept['program']}, not {head['program']}): "
            "resume with that one, or run without --resume"
        )
    if what := identity.changed(kept["inputs"], head["inputs"]):
        raise ValueError(f"{path} is of another run, changed is: {what}; resume with the same, or without --resume")
    history.restore(kept["history"], {robot.id: robot.frame for robot in data.robots})
    return kept["run"]


def _head(data, recording):
    inputs = {"seed": repr(data.seed)} | identity.of_scenario(data) | identity.of_recording(recording)
    return {"format": FORMAT, "program": identity.program(), "inputs": inputs}
