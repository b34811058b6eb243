"""Throw broken and hostile files at every reader: `python tools/fuzz.py --inputs 100000 --seed 1`.

Each input is accepted, or refused with an exception that the reader documents and a message of one line, within a limit
of processor time. Anything else is a finding: it is printed, and its bytes are kept in a folder. There are two engines:
mutations of valid files drawn from a seed, and `--engine atheris`, which looks at what the code does with an input and
needs the package atheris in an environment of its own.
"""

import argparse
import hashlib
import importlib
import json
import signal
import sys
import time
import traceback
import warnings
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
CPU_LIMIT = 5.0
"""Seconds of processor time for one input of a few kilobytes."""

MESSAGE_LIMIT = 1000
MAX_SIZE = 8192
NUMBERS = [b"nan", b"inf", b"-1", b"0", b"1e400", b"1e308", b"-1e308", b"5e-324", b"9223372036854775808", b"2147483648"]
NUMBERS += [b"0.1", b"1_0", b"0x10", b"--1", b"1e", b"\xc2\xb2", b"18446744073709551616", b"true", b"null", b'""']
PIECES = [
    b"\x00",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"\n",
    b"\r",
    b",",
    b'"',
    b"[",
    b"]",
    b"{",
    b"}",
    b"=",
    b"(",
    b"#",
    b" ",
]
PIECES += [b"[" * 500, b'{"a":' * 300, b"(" * 300, b"'O'", b"'<U999999999'", b"'<M8'", b"'>c16'", b"(99999999999,)"]


class TooSlow(Exception):
    """An input took more processor time than it may."""


SMALL, ALL = (0, 1, 7, 7), range(9)


def mutate(rng, data, others, words=(), head=0):
    """Some bytes, made from valid ones: flipped, cut, doubled, moved, spliced, numbers exchanged.

    Half of the inputs have small changes only, and half of them an intact head.
    """
    head = head if rng.random() < 0.5 else 0
    head, data = data[:head], bytearray(data[head:])
    kinds = SMALL if rng.random() < 0.5 else ALL
    for _ in range(rng.geometric(0.6)):
        n, kind = len(data), kinds[rng.integers(len(kinds))]
        a, b = sorted(rng.integers(0, n + 1, 2).tolist())
        if kind == 0 and n:
            data[rng.integers(n)] ^= 1 << rng.integers(8)
        elif kind == 1 and n:
            data[rng.integers(n)] = rng.integers(256)
        elif kind == 2:
            del data[a : min(b, a + int(rng.geometric(0.05)))]
        elif kind == 3:
            del data[a:]
        elif kind == 4:
            data[a:a] = data[a:b][:200] * int(rng.integers(1, 4))
        elif kind == 5:
            other = others[rng.integers(len(others))]
            c = int(rng.integers(len(other) + 1))
            data[a:b] = other[c : c + 400]
        elif kind == 6:
            data[a:a] = PIECES[rng.integers(len(PIECES))]
        elif kind == 7:
            exchange_number(rng, data, [*NUMBERS, *words])
        else:
            data[a : a + 4] = rng.bytes(4)
    return head + bytes(data[:MAX_SIZE])


def exchange_number(rng, data, numbers):
    """Put something in the place of one number, or word, of a text."""
    at = int(rng.integers(len(data) + 1))
    part_of_word = lambda i: chr(data[i]).isalnum() or data[i] in b".-+_"
    while at < len(data) and not part_of_word(at):
        at += 1
    end = at
    while end < len(data) and part_of_word(end):
        end += 1
    while at and part_of_word(at - 1):
        at -= 1
    data[at:end] = numbers[rng.integers(len(numbers))]


class Judge:
    """Reads inputs and says what became of them.

    Parameters
    ----------
    keep : path or None
        Folder for the inputs that are findings.
    """

    def __init__(self, keep=None):
        self.counts, self.findings, self.keep = {}, {}, keep and Path(keep)
        signal.signal(signal.SIGVTALRM, self._too_slow)

    def _too_slow(self, *_):
        raise TooSlow(f"more than {CPU_LIMIT:g} s of processor time")

    def judge(self, name, target, member, data):
        """Read one input; True if what happened is as documented."""
        count = self.counts.setdefault(
            name, {"inputs": 0, "accepted": 0, "refused": 0, "findings": 0, "slowest_s": 0.0}
        )
        count["inputs"] += 1
        start = time.thread_time()
        signal.setitimer(signal.ITIMER_VIRTUAL, CPU_LIMIT)
        try:
            target.read(member, data)
            fault, kind = None, "accepted"
        except target.refusals as error:
            text = str(error)
            fault = None if text and "\n" not in text and len(text) < MESSAGE_LIMIT else error
            kind = "refused"
        except Exception as error:  # this is what is looked for
            fault, kind = error, "findings"
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        count["slowest_s"] = max(count["slowest_s"], time.thread_time() - start)
        count["findings" if fault else kind] += 1
        if fault:
            self._note(name, member, data, fault)
        return fault is None

    def _note(self, name, member, data, error):
        """Print a finding when it is the first of its kind, and keep its bytes."""
        place = traceback.extract_tb(error.__traceback__)[-1]
        kind = f"{name}: {type(error).__name__} at {Path(place.filename).name}:{place.lineno}"
        if kind not in self.findings:
            self.findings[kind] = 0
            file = f"{hashlib.sha256(data).hexdigest()[:12]}"
            print(f"FINDING {kind}: {str(error)[:200]!r} ({member}, {file})", flush=True)
            if self.keep:
                self.keep.mkdir(parents=True, exist_ok=True)
                (self.keep / file).write_bytes(data)
        self.findings[kind] += 1

    def report(self, **more):
        """What came of the run."""
        total = sum(count["inputs"] for count in self.counts.values())
        return {"inputs": total, "targets": self.counts, "findings": self.findings, **more}


def run(inputs, seed, only=(), keep=None, seconds=float("inf"), out=None):
    """Mutations of valid files.

    Parameters
    ----------
    inputs : int
        Of all targets together.
    seed : int
    only : list of str
        Names of targets; all of them if empty.
    keep : path, optional
        Folder for the inputs that are findings.
    seconds : float
        Stop after this time.
    out : path, optional
        File for what is known so far, now and then.

    Returns
    -------
    dict
        Counts of each target, and of each kind of finding.
    """
    import resource

    from fuzz_targets import scratch, targets

    judge, start, rng = Judge(keep), time.monotonic(), np.random.default_rng(seed)
    with scratch() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        chosen = {name: t for name, t in targets(folder).items() if not only or name in only}
        turns = [(name, t) for name, t in chosen.items() for _ in range(t.share)]
        for target in chosen.values():  # the seeds are valid, or nothing is tested
            for member, data in target.seeds:
                target.read(member, data)
        for k in range(inputs):
            name, target = turns[k % len(turns)]
            member, data = target.seeds[rng.integers(len(target.seeds))]
            data = mutate(rng, data, [other for _, other in target.seeds], target.words, target.head)
            judge.judge(name, target, member, data)
            if k % 1000 == 0 and time.monotonic() - start > seconds:
                break
            if out and k % 10_000 == 0:
                Path(out).write_text(json.dumps(judge.report(engine="mutation", seed=seed), indent=1))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // (1024 if sys.platform == "linux" else 2**20)
    return judge.report(engine="mutation", seed=seed, seconds=round(time.monotonic() - start), peak_memory_mb=peak)


def run_atheris(name, inputs, seed, keep, out):
    """The same with coverage guidance, one target at a time; the first byte chooses the member."""
    atheris = importlib.import_module("atheris")  # not in the environment of the project
    with atheris.instrument_imports(include=["ekfslam_tutorial"]):
        from fuzz_targets import scratch, targets

    judge, folder = Judge(keep), scratch()
    target = targets(folder.name)[name]
    corpus = Path(folder.name, "corpus")
    corpus.mkdir()
    for number, (_, data) in enumerate(target.seeds):
        (corpus / str(number)).write_bytes(bytes([number]) + data[:MAX_SIZE])

    def one(data):
        member, _ = target.seeds[(data[0] if data else 0) % len(target.seeds)]
        judge.judge(name, target, member, data[1:])
        if judge.counts[name]["inputs"] % 500 == 0:
            Path(out).write_text(json.dumps(judge.report(engine="atheris", seed=seed), indent=1))

    warnings.simplefilter("ignore")
    options = [f"-runs={inputs}", f"-seed={seed}", f"-max_len={MAX_SIZE}", "-timeout=60", "-rss_limit_mb=2000"]
    atheris.Setup([sys.argv[0], *options, "-print_final_stats=1", "-verbosity=0", str(corpus)], one)
    atheris.Fuzz()


def main(arguments=None):
    """Run one engine and print its report; 1 if there are findings."""
    parser = argparse.ArgumentParser(description="Throw broken and hostile files at every reader.")
    parser.add_argument("--inputs", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--target", action="append", default=[], help="its name; all of them if not given")
    parser.add_argument("--engine", choices=("mutation", "atheris"), default="mutation")
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("--keep", default="build/fuzz", help="folder for the inputs that are findings")
    parser.add_argument("--out", help="write the report to this file, too")
    options = parser.parse_args(arguments)
    if options.engine == "atheris":
        run_atheris(options.target[0], options.inputs, options.seed, options.keep, options.out)
    report = run(options.inputs, options.seed, options.target, options.keep, options.seconds, options.out)
    print(json.dumps(report, indent=1))
    if options.out:
        Path(options.out).write_text(json.dumps(report, indent=1))
    return 1 if report["findings"] else 0


if __name__ == "__main__":
    sys.exit(main())
