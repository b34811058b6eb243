"""The data set that a scenario names: the real one, or its simulated twin."""

from .. import datasets
from ..toolbox import UserData
from .files import scenarios


def open_data(data, models=()):
    """The recording of the data set that a scenario asks for.

    Where the data set is not on this machine, its twin is taken: the shipped scenario NAME_twin, simulated.

    Parameters
    ----------
    data : UserData
        With `data.data`.
    models : iterable of classes
        For reading the twin.

    Returns
    -------
    data : UserData
        The scenario for the robots of the data set.
    recording : Recording or None
    said : str
        What the user should know.

    Raises
    ------
    FileNotFoundError
        If there is neither.
    """
    try:
        data, recording = datasets.prepare(data)
        return data, recording, ""
    except FileNotFoundError as missing:
        twin = scenarios().get(f"{data.data.name}_twin")
        if twin is None:
            raise
        said = (
            f"{missing}. Its simulated twin, {twin.name}, runs instead; `ekfslam data` tells where to get the real one."
        )
        twin_data = UserData.from_toml(twin, models=models)
        twin_data.seed = data.seed
        recording = None
        if twin_data.data is not None:
            twin_data, recording = datasets.prepare(twin_data)
        return twin_data, recording, said
