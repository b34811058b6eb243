"""`ekfslam graph RUN --to g2o|gtsam`: a run as a graph of poses and points, for other programs."""

from pathlib import Path

from ..analysis.factors import graph_of
from ..analysis.graph_files import g2o_text, gtsam_script
from .files import file_name, writable_folder, written
from .run import own_models, read, source, tell_notes, told_by_name

WAYS = {"g2o": (g2o_text, ".g2o"), "gtsam": (gtsam_script, "_gtsam.py")}


def main(options):
    """Run the command."""
    models = [cls for file in options.models for cls in own_models(file)]
    with told_by_name(options.models):
        data, recording = source(options, read(options, models))
        tell_notes(recording.notes if recording else [])
        graph = graph_of(data, recording)
    write, ending = WAYS[options.to]
    path = Path(options.out or Path("results") / f"{file_name(data.name)}{ending}")
    text = write(graph)
    writable_folder(path.parent)
    with written(path, text=True) as file:
        file.write(text)
    poses, looks = sum(key[0] == "robot" for key in graph.values), sum(len(look.lmks) for look in graph.looks)
    print(f"{poses} poses, {len(graph.types)} landmarks, {looks} measurements of them")
    print(f"written to {path}", flush=True)
    return 0
