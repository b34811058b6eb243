"""Settings of the command line that change nothing, because a recording is played that has its own."""

import numpy as np

from ..toolbox import parse_override

SIMULATED = {"p_detect", "clutter"}
"""Keys of a sensor that only the simulator asks for."""


def without_effect(options, read, data, recording):
    """Sentences for settings that have no effect on a run.

    Parameters
    ----------
    options : argparse.Namespace
        Of the command: `set`, `recording`.
    read : callable
        A list of texts KEY=VALUE -> the scenario with these changes.
    data : UserData
        The scenario with all changes, with its own robots.
    recording : Recording or None

    Returns
    -------
    list of str
    """
    if recording is None:
        return []
    notes = []
    for i, text in enumerate(options.set):
        key = parse_override(text)[0]
        why = _why(key, lambda i=i: read([*options.set[:i], *options.set[i + 1 :]]), data, recording, options)
        if why:
            notes.append(f"--set {text} has no effect: {why}")
    return notes


def _why(key, before, data, recording, options):
    """Why a key has no effect; None if it has one. `before` makes the scenario without it."""
    part, last = key.split(".")[0], key.split(".")[-1]
    if part == "world" or (part == "sensor" and last in SIMULATED) or key == "time.dt":
        return "that is for simulations, and a recording is played"
    if part == "data" and options.recording:
        return "a recording was given by --recording"
    if part == "sensor":
        return _noise_of_sensors(before, data, recording)
    if part == "robot":
        return _noise_of_robots(before, data, recording)
    return None


def _noise_of_sensors(before, data, recording):
    pairs = zip(before().sensors, data.sensors, strict=True)
    changed = [s for old, s in pairs if not np.array_equal(old.model.R, s.model.R)]
    own = all(log.R is not None for log in recording.raw.values())
    if changed and own:
        id = changed[0].id
        return f"the recording has its own noise R; --set sensor.{id}.noise_factor=2 tells twice that R"
    return None


def _noise_of_robots(before, data, recording):
    for old, robot in zip(before().robots, data.robots, strict=True):
        if not np.array_equal(old.controls(), robot.controls()):
            return "the recording has its own controls"
        own = all(log.U is not None for log in recording.robots.values())
        if own and not np.array_equal(old.U(), robot.U()):
            return f"the recording has its own noise U; --set robot.{robot.id}.noise_factor=2 tells twice that U"
    return None
