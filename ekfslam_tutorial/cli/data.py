"""`ekfslam data`: which data sets are here, whether they are whole; `fetch` downloads them, `import` takes yours."""

import contextlib
import sys

from ..datasets import report


def main(options):
    """Run the command; 1 if something that is here is damaged."""
    if options.action == "fetch":
        return _fetch(options)
    if options.action == "import":
        return _import(options)
    text, ok = report(verify=not options.quick)
    print(text)
    return 0 if ok else 1


def _fetch(options):
    from ..datasets.fetch import data_set, fetch, target_folder

    dataset = data_set(options.name)
    if options.set and dataset.name != "mrclam":
        raise ValueError(f"--set is for mrclam; {dataset.name} has no sets")
    parts = [f"MRCLAM_Dataset{n}" for n in options.set] if options.set else list(dataset.parts)
    print(f"Please cite: {dataset.citation}.")
    with contextlib.ExitStack() as bars:
        for part in parts:  # each line as soon as it is true
            try:
                done = fetch(dataset.name, options.to, [part], progress=lambda part: _bar(bars, part))
            except ImportError as error:
                raise ValueError(str(error)) from error
            print("\n".join(done), flush=True)
    print(f"In {target_folder(options.to)}. It comes without a licence text: use it, do not pass it on.")
    return 0


def _bar(bars, part):
    """A progress bar as a function of bytes so far and bytes in all."""
    from ..analysis.progress import bar

    drawn = bars.enter_context(bar(0, f"{part}, kB", shown=sys.stderr.isatty()))

    def show(done, total):
        drawn.total = (total or 0) // 1000
        drawn.update(done // 1000 - drawn.n)

    return show


def _import(options):
    from ..datasets.arrivals import bring
    from ..datasets.fetch import target_folder

    print("\n".join(bring(options.path, target_folder(options.to), options.force)))
    return 0
