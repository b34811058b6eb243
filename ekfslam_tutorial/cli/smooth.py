"""`ekfslam smooth RUN`: the filter, and a smoother beside it, of the same models and measurements."""

from pathlib import Path

from ..analysis.factors import graph_of
from .files import file_name, writable_folder
from .run import own_models, read, source, tell_notes, told_by_name
from .smoothing import check, smoothed, tell, write


def main(options):
    """Run the command: 0, or 1 where the smoother has found no end."""
    models = [cls for file in options.models for cls in own_models(file)]
    with told_by_name(options.models):
        data, recording = source(options, read(options, models))
        check(data)
        tell_notes(recording.notes if recording else [])
        found = smoothed(graph_of(data, recording), options.lag)
    out = writable_folder(options.out or Path("results") / f"{file_name(data.name)}-smoothed")
    names = write(out, found, data.name)
    tell(found, data.name, options.lag)
    print(f"written to {out}: {', '.join(names)}", flush=True)
    return 0 if found.converged or options.lag is not None else 1
