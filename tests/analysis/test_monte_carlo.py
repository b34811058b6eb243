"""Many runs: the same numbers wherever they are made, nothing lost, nothing counted twice, mistakes told at once.

Half of the time, 10 s, is that of a cluster on this computer, one of whose workers is killed and replaced.
"""

import os
import signal
import threading
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from dataclasses import fields, replace
from importlib import import_module
from multiprocessing import get_context

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History, anees_band, monte_carlo, run_scores, run_seeds, series
from ekfslam_tutorial.simulation import draw
from ekfslam_tutorial.toolbox import Data, UserData, World, universal_slam

module = import_module("ekfslam_tutorial.analysis.monte_carlo")  # the package has the function under this name

FAST = {
    "name": "fast",
    "seed": 7,
    "time": {"dt": 0.5, "last": 8},
    "world": {"type": "ring", "n": 6, "radius": 4},
    "robot": [{"motion": "unicycle", "v": 1.0, "w_deg": 10, "v_std": 0.1, "w_std_deg": 2.0}],
    "sensor": [{"type": "range_bearing", "range_std": 0.1, "bearing_std_deg": 1.0, "max_range": 5.0}],
}
SLOW = FAST | {"options": {"joint": True}}  # not batched: a task for each run


def scenario(table=FAST, **changes):
    return UserData.from_dict(table | changes)


def assert_same(a, b):
    """All numbers, to the last bit."""
    for f in fields(a):
        left, right = getattr(a, f.name), getattr(b, f.name)
        same = (
            np.array_equal(left, right, equal_nan=left.dtype.kind == "f")
            if isinstance(left, np.ndarray)
            else left == right
        )
        assert same, f.name


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    """Blocks of 10 runs, so that few runs make many tasks."""
    monkeypatch.setattr(module, "RUNS", 10)


# --- the numbers ------------------------------------------------------------------------------------------------------


def test_the_scores_are_those_of_single_runs():
    """Beside `History`, which scores single runs; and the batched runs beside the others."""
    data = scenario()
    result = monte_carlo(data, 3)
    for i, seed in enumerate(result.seeds.tolist()):
        history = History("fixed")
        for _ in history.watch(universal_slam(data, seed=seed)):
            pass
        one, row = history.summary(), result.per_run()[i]
        assert row["run"] == i and row["seed"] == seed and row["n_landmarks"] == one["n_landmarks"]
        for mine, its in (
            ("rmse_m", "ate_rmse_m"),
            ("heading_rmse_deg",) * 2,
            ("nees_mean",) * 2,
            ("landmark_rmse_m",) * 2,
        ):
            assert row[mine] == pytest.approx(one[its], rel=1e-6), mine
    alone, failures = run_scores.score_block(data, result.seeds.tolist(), together=False)
    assert not failures
    for name in (*run_scores.FRAMES, *run_scores.ENDS):  # NEES divides by small covariances: relative 1e-6
        np.testing.assert_allclose(getattr(result, name), alone[name], rtol=1e-6, atol=1e-10, err_msg=name)


def test_the_summary_is_that_of_the_runs():
    result = monte_carlo(scenario(), 40)
    s = result.summary()
    assert s["runs"] == 40 and s["frames"] == 8 and s["complete"] and s["nees_dof"] == 3 and not s["failed"]
    assert s["rmse_m"] == pytest.approx(np.sqrt((result.position**2).mean()))
    assert s["nees_mean"] == pytest.approx(np.nanmean(result.nees))
    assert s["nees_band"] == list(anees_band(3, 40)) == list(result.band())
    assert result.over_time("nees")[-1, 0] == pytest.approx(result.nees[:, -1, 0].mean())
    assert s["nees_last_verdict"] == "as it should be"
    low, high = anees_band(3, 40, 0.999)
    assert low < s["nees_last"] < high and s["landmark_nees_mean"] < 4


def test_a_filter_that_lies_is_found_out(monkeypatch):
    """The simulator's sensor is worse than the filter believes."""
    batch_slam = import_module("ekfslam_tutorial.analysis.batch_slam")
    monkeypatch.setattr(batch_slam, "draw", lambda rng, cov, shape: 2 * draw(rng, cov, shape))
    assert monte_carlo(scenario(), 40).summary()["nees_last_verdict"] == "over-confident"


def test_seeds_come_from_the_seed_of_the_series():
    assert run_seeds(7, 5) == run_seeds(7, 9)[:5] and run_seeds(7, 5) != run_seeds(8, 5)
    assert len(set(run_seeds(0, 2000))) == 2000
    few, more = monte_carlo(scenario(), 13), monte_carlo(scenario(), 25, seed=7)
    assert np.array_equal(few.nees, more.nees[:13], equal_nan=True)
    assert not np.array_equal(few.position, monte_carlo(scenario(), 13, seed=8).position)


@pytest.mark.parametrize("table", [FAST, SLOW], ids=["batched", "one by one"])
def test_the_numbers_do_not_depend_on_the_workers(table):
    data, runs = scenario(table), 25 if table is FAST else 10
    alone = monte_carlo(data, runs)
    with ThreadPoolExecutor(8) as eight:
        assert_same(alone, monte_carlo(data, runs, eight))
    if table is FAST:
        with ProcessPoolExecutor(2, get_context("spawn")) as two:
            assert_same(alone, monte_carlo(data, runs, two))


class Backwards(Executor):
    """Does the last task first, in the thread that asks for it."""

    def __init__(self):
        self.tasks = []

    def submit(self, fn, /, *args, **kwargs):
        self.tasks.append((Future(), fn, args))
        if len(self.tasks) == 3:
            for future, fn, args in reversed(self.tasks):
                future.set_result(fn(*args))
        return self.tasks[-1][0]


def test_the_order_in_which_tasks_come_back_does_not_matter():
    assert_same(monte_carlo(scenario(), 25), monte_carlo(scenario(), 25, Backwards()))


class Breaking(Executor):
    """One of its workers has died: a thread marks all tasks, one after the other, as that of a process pool does."""

    def __init__(self):
        self.futures, self.told, self.thread, self.mistakes = [], threading.Event(), None, []

    def submit(self, fn, /, *args, **kwargs):
        self.futures.append(Future())
        if len(self.futures) == 3:
            self.thread = threading.Thread(target=self.mark)
            self.thread.start()
        return self.futures[-1]

    def mark(self):
        """The first is marked; the others as soon as the caller, who knows by now, has done something with them."""
        self.futures[0].set_exception(BrokenExecutor("died"))
        self.told.wait()
        try:
            for future in self.futures[1:]:
                future.set_exception(BrokenExecutor("died"))
        except Exception as mistake:
            self.mistakes.append(mistake)


def test_nothing_is_cancelled_while_a_broken_executor_marks_its_tasks(monkeypatch):
    """A pool's thread that finds a cancelled task among those ends, and the workers that it should end live on."""
    pool = Breaking()
    cancel = Future.cancel
    monkeypatch.setattr(Future, "cancel", lambda future: [cancel(future), pool.told.set()][0])
    monkeypatch.setattr(
        import_module("ekfslam_tutorial.analysis.monte_carlo"), "wait", lambda f: pool.told.set() or wait(f)
    )
    with pytest.raises(ChildProcessError, match="a worker process has died; 0 of 25 runs are done"):
        monte_carlo(scenario(), 25, pool)
    pool.thread.join()
    assert not pool.mistakes


# --- stopped and taken up again ---------------------------------------------------------------------------------------


def stopping_after(monkeypatch, tasks):
    """Ctrl-C when so many tasks are done."""
    count, score = [0], run_scores.score_block

    def scored(*args):
        count[0] += 1
        if count[0] > tasks:
            raise KeyboardInterrupt
        return score(*args)

    monkeypatch.setattr(module, "score_block", scored)


@pytest.mark.parametrize("table", [FAST, SLOW], ids=["batched", "one by one"])
def test_stopped_and_resumed_is_as_if_it_had_not_been_stopped(table, tmp_path, monkeypatch):
    data, runs, path = scenario(table), 34 if table is FAST else 6, tmp_path / "runs.npz"
    with monkeypatch.context() as patch:
        stopping_after(patch, 2)
        part = monte_carlo(data, runs, path=path)
    assert not part.complete and list(part.runs) == list(range(20 if table is FAST else 2)) and part.wanted == runs
    with pytest.raises(ValueError, match="runs.npz holds an unfinished series: resume it"):
        monte_carlo(data, runs, path=path)
    whole = monte_carlo(data, runs)
    assert_same(whole, monte_carlo(data, runs, path=path, resume=True))
    with monkeypatch.context() as patch:
        stopping_after(patch, 0)  # nothing is left to do
        assert_same(whole, monte_carlo(data, runs, path=path, resume=True))
    longer = monte_carlo(data, runs + 3, path=path, resume=True)
    assert_same(longer, monte_carlo(data, runs + 3))
    assert [p.name for p in tmp_path.iterdir()] == ["runs.npz"]


@pytest.mark.parametrize("looked", [True, False], ids=["taken", "not taken yet"])
def test_a_signal_keeps_what_other_threads_have_done(looked, tmp_path, monkeypatch):
    """Ctrl-C when three runs are done and the fourth is at work, whether or not their results have been looked at."""
    data, path = scenario(SLOW), tmp_path / "runs.npz"
    at_work, stopped, score, taken = threading.Event(), threading.Event(), run_scores.score_block, []

    def score_block(*block):
        """The fourth run ends after the signal has been answered."""
        if block[1][0] == seeds[3]:
            at_work.set()
            stopped.wait()
        return score(*block)

    def ctrl_c(futures):
        """The main thread waits for results here: the signal meets it before the first, or after the third."""
        for future in as_completed(futures) if looked else ():
            yield future
            taken.append(future)
            if len(taken) == 3:
                break
        at_work.wait()
        signal.raise_signal(signal.SIGINT)
        raise AssertionError("the signal was not heard")

    seeds, as_completed = run_seeds(data.seed, 30), module.as_completed
    monkeypatch.setattr(module, "score_block", score_block)
    monkeypatch.setattr(module, "as_completed", ctrl_c)
    with ThreadPoolExecutor(1) as one:
        try:
            part = monte_carlo(data, 30, one, path=path)
        finally:
            stopped.set()
    assert list(part.runs) == [0, 1, 2] and not part.complete and len(taken) == (3 if looked else 0)
    assert np.array_equal(part.position, monte_carlo(data, 3).position)
    assert len(series.read(path)[1]) == 3


def test_before_the_first_run_ctrl_c_is_ctrl_c(monkeypatch):
    stopping_after(monkeypatch, 0)
    with pytest.raises(KeyboardInterrupt):
        monte_carlo(scenario(), 20)


def test_it_is_saved_on_the_way(tmp_path, monkeypatch):
    monkeypatch.setattr(series, "SAVE_EVERY", 0.0)
    path, seen = tmp_path / "runs.npz", []
    score = run_scores.score_block
    look = lambda *args: (seen.append(len(series.read(path)[1]) if path.exists() else 0), score(*args))[1]
    monkeypatch.setattr(module, "score_block", look)
    monte_carlo(scenario(), 34, path=path)
    assert seen == [0, 10, 20, 30]


@pytest.mark.parametrize(
    ("other", "what"),
    [(scenario(time={"dt": 0.5, "last": 9}), "scenario, changed is: time of the scenario")]
    + [(scenario(world={"type": "lecture"}), "scenario, changed is: world of the scenario"), (scenario(seed=8), "seed")]
    + [(scenario(options={"md2_threshold": 9.0}), "scenario, changed is: options of the scenario")],
)
def test_another_series_is_not_taken_up(other, what, tmp_path):
    path = tmp_path / "runs.npz"
    monte_carlo(scenario(), 5, path=path)
    with pytest.raises(ValueError, match=f"runs.npz holds runs of another {what}; give another folder"):
        monte_carlo(other, 5, path=path, resume=True)
    monte_carlo(scenario(name="renamed"), 5, path=path, resume=True)  # a name changes no number


def test_a_damaged_file_is_told(tmp_path):
    path = tmp_path / "runs.npz"
    for content in b"", b"PK\x03\x04 not a zip":
        path.write_bytes(content)
        with pytest.raises(ValueError, match="runs.npz is no file of Monte-Carlo runs, or it is damaged"):
            monte_carlo(scenario(), 5, path=path, resume=True)
    np.savez(path, other=np.zeros(3))
    with pytest.raises(ValueError, match="is no file of Monte-Carlo runs"):
        monte_carlo(scenario(), 5, path=path, resume=True)


# --- what goes wrong --------------------------------------------------------------------------------------------------


def test_a_run_that_fails_does_not_take_the_others_with_it(monkeypatch):
    whole = monte_carlo(scenario(), 20)
    bad = int(whole.seeds[13])
    one, many = run_scores._scores_alone, run_scores.batch_slam

    def batch(data, seeds):
        if bad in seeds:
            raise ValueError("the innovation must be finite")
        return many(data, seeds)

    monkeypatch.setattr(run_scores, "batch_slam", batch)
    result = monte_carlo(scenario(), 20)
    assert result.failures == {13: "the innovation must be finite"} and result.complete and len(result.runs) == 20
    others = np.arange(20) != 13
    assert np.array_equal(result.nees[others], whole.nees[others], equal_nan=True) and np.isnan(result.nees[13]).all()
    assert result.summary()["failed"] == 1 and result.per_run()[13]["rmse_m"] is None
    assert result.band() == anees_band(3, 19) and one is run_scores._scores_alone


def die(*_):
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no such signal on this system")
def test_a_worker_that_dies_is_one_sentence_and_no_loss(tmp_path):
    path = tmp_path / "runs.npz"
    monte_carlo(scenario(), 10, path=path)
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        pool.submit(die)
        with pytest.raises(ChildProcessError, match="a worker process has died; 10 of 30 runs are done and kept in"):
            monte_carlo(scenario(), 30, pool, path=path, resume=True)
    assert_same(monte_carlo(scenario(), 30, path=path, resume=True), monte_carlo(scenario(), 30))


def test_bad_input_is_one_sentence(tmp_path):
    data = scenario()
    with pytest.raises(ValueError, match="runs must be a number of 1 or more, got 0"):
        monte_carlo(data, 0)
    with pytest.raises(ValueError, match=r"executor must be one of concurrent.futures.*got 4"):
        monte_carlo(data, 5, 4)
    with pytest.raises(ValueError, match="plays the data set 'mrclam': there is no chance in it, only one run"):
        monte_carlo(replace(data, data=Data(name="mrclam")), 5)
    with pytest.raises(ValueError, match="a simulation needs a world"):
        monte_carlo(replace(data, world=None), 5)
    with pytest.raises(FileNotFoundError, match="no folder .*nowhere to keep the runs in"):
        monte_carlo(data, 5, path=tmp_path / "nowhere" / "runs.npz")
    with pytest.raises(FileNotFoundError, match="no scenario file"):
        monte_carlo(tmp_path / "none.toml", 5)
    own = replace(data, world=World(build=lambda rng: (np.arange(2), rng.uniform(-3, 3, (2, 2)))))
    with ProcessPoolExecutor(1) as pool, pytest.raises(ValueError, match="cannot be sent to other processes: "):
        monte_carlo(own, 5, pool)
    assert len(monte_carlo(own, 5).runs) == 5


# --- a cluster --------------------------------------------------------------------------------------------------------


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no such signal on this system")
def test_a_cluster_that_loses_a_worker_loses_no_run(tmp_path, monkeypatch):
    """Two workers in processes of their own; one is killed while it has tasks done and tasks to do."""
    distributed = pytest.importorskip("distributed", reason="the package distributed is not installed")
    data, runs, killed = scenario(SLOW, time={"dt": 0.5, "last": 20}), 60, []
    cluster = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": ":0", "silence_logs": 60}
    cluster["local_directory"] = str(tmp_path)
    with distributed.LocalCluster(**cluster) as local, distributed.Client(local) as client:
        pids, take = client.run(os.getpid), series.Series.take

        def take_and_kill(self, *answer):
            take(self, *answer)
            if self.done.sum() == 10:
                busy, tasks = max(client.processing().items(), key=lambda item: len(item[1]))
                os.kill(pids[busy], signal.SIGKILL)
                killed.append(len(tasks))

        monkeypatch.setattr(series.Series, "take", take_and_kill)
        result = monte_carlo(data, runs, client.get_executor(pure=False))
    assert len(killed) == 1 and killed[0] > 0  # once, in the middle, at work
    monkeypatch.undo()
    assert_same(result, monte_carlo(data, runs))
