"""`ekfslam export RUN --to tum|kitti|euroc|rerun|mcap`: paths and map of a run, for other programs."""

from pathlib import Path

from ..analysis import History
from ..analysis.progress import bar
from ..toolbox import universal_slam
from .files import file_name, writable_folder
from .run import own_models, read, source, tell_notes, told_by_name
from .trajectories import write_covariances, write_euroc, write_kitti, write_tum
from .viewers import write_mcap, write_rerun

WAYS = {
    "tum": lambda out, history: [*write_tum(out, history), *write_covariances(out, history)],
    "kitti": lambda out, history: [*write_kitti(out, history), *write_covariances(out, history)],
    "euroc": lambda out, history: [*write_euroc(out, history), *write_covariances(out, history)],
    "rerun": write_rerun,
    "mcap": write_mcap,
}


def main(options):
    """Run the command."""
    models = [cls for file in options.models for cls in own_models(file)]
    with told_by_name(options.models):
        data, recording = source(options, read(options, models))
        tell_notes(recording.notes if recording else [])
        out = writable_folder(Path(options.out or Path("results") / f"{file_name(data.name)}-{options.to}"))
        run, history = universal_slam(data, recording), History()
        with bar(len(run), "frames") as done:
            for _ in history.watch(run):
                done.update()
    print(f"written to {out}: {', '.join(WAYS[options.to](out, history))}", flush=True)
    return 0
