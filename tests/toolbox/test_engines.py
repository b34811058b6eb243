"""The engine: an option of the scenario, or a word to `universal_slam`; both run the same scenarios."""

from collections import Counter

import numpy as np
import pytest

from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.toolbox import Options, UserData, create_slam_structures, engines, universal_slam
from ekfslam_tutorial.toolbox.engines import ENGINES, Engine, engine
from tests.toolbox.scenarios import FLAT, SPACE


def last(data, **how):
    *_, snapshot = universal_slam(data, **how)
    return snapshot


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("table", [FLAT, SPACE], ids=["flat", "space"])
def test_both_run_a_scenario(table, name):
    data = UserData.from_dict(table, {"options.engine": name, "time.last": 12})
    run = universal_slam(data)
    snapshots = list(run)
    assert run.engine == name and len(snapshots) == 12 and len(snapshots[-1].lmks) > 3


@pytest.mark.parametrize("table", [FLAT, SPACE], ids=["flat", "space"])
def test_both_give_the_same_estimate(table):
    data = UserData.from_dict(table)
    plain, fast = (last(data, engine=name) for name in ("plain", "fast"))
    assert list(plain.lmks) == list(fast.lmks) and len(plain.lmks) > 3
    for a, b in [*zip(plain.robs, fast.robs, strict=True), *((plain.lmks[i], fast.lmks[i]) for i in plain.lmks)]:
        assert np.allclose(plain.map.x[a.r], fast.map.x[b.r], rtol=0, atol=1e-9)
        assert np.allclose(plain.map.P[a.r, a.r], fast.map.P[b.r, b.r], rtol=1e-6, atol=1e-12)


def test_the_fast_one_runs_unless_another_is_asked_for():
    data = UserData.from_dict(FLAT)
    assert data.options.engine == Options().engine == "fast"
    assert universal_slam(data).engine == "fast" and universal_slam(data, engine="plain").engine == "plain"
    asked = UserData.from_dict(FLAT, {"options.engine": "plain"})
    assert universal_slam(asked).engine == "plain" and universal_slam(asked, engine="fast").engine == "fast"
    assert asked.options.engine == "plain"  # the user's data stay as they are


def test_an_engine_is_named_with_its_options():
    assert engine(Options(engine="plain")).name == "plain"
    assert engine(Options()).name == "fast"
    data = UserData.from_dict(FLAT, {"options.compressed": True, "options.joint": True})
    assert universal_slam(data).engine == engine(data.options).name == "fast, compressed"


def test_the_map_is_that_of_the_engine():
    """The plain one has the map of `ekf`, the compressed map is of another class; a capacity reaches each of them."""
    kinds = {"options.engine": "plain"}, {}, {"options.compressed": True}
    maps = [create_slam_structures(UserData.from_dict(FLAT, {"options.capacity": 40, **kind}))[0] for kind in kinds]
    plain, fast, compressed = maps
    assert plain.capacity == fast.capacity == compressed.capacity == 40
    assert type(plain) is Map and type(compressed) not in (Map, type(fast))


@pytest.mark.parametrize("name", ENGINES)
def test_the_loop_takes_its_map_and_every_step_from_the_engine(name, monkeypatch):
    calls = Counter()

    def counted(what, step):
        def call(*arguments, **named):
            calls[what] += 1
            return step(*arguments, **named)

        return call

    def watched(options):
        made = engine(options)
        return made._replace(**{what: counted(what, getattr(made, what)) for what in Engine._fields[1:]})

    monkeypatch.setattr(engines, "engine", watched)
    last(UserData.from_dict(FLAT, {"time.last": 7}), engine=name)
    assert calls == {"new_map": 1, "move": 7, "correct_known_lmks": 7, "init_new_lmks": 7}


WRONG = [
    ({"engine": "quick"}, "engine must be 'plain' or 'fast', got 'quick'"),
    ({"engine": "Plain"}, "engine must be 'plain' or 'fast', got 'Plain'"),
    ({"engine": None}, "engine must be 'plain' or 'fast', got None"),
    *(
        (
            {"engine": "plain", name: True},
            f"{name} is an option of the engine 'fast', got it with the engine 'plain': "
            f"take the engine 'fast', or {name} = false",
        )
        for name in ("compressed", "compiled")
    ),
]


@pytest.mark.parametrize(("options", "message"), WRONG, ids=["other", "capital", "none", "compressed", "compiled"])
def test_what_no_engine_can_do_is_refused_in_one_sentence(options, message):
    with pytest.raises(ValueError) as error:
        Options(**options)
    assert str(error.value) == message


def test_a_scenario_file_is_refused_with_its_place(tmp_path):
    path = tmp_path / "mine.toml"
    text = find_scenario("range_bearing_2d").read_text(encoding="utf-8")
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"^mine\.toml: \[options\]: engine must be 'plain' or 'fast', got 'quick'$"):
        UserData.from_toml(path, {"options.engine": "quick"})
    with pytest.raises(ValueError, match=r"^mine\.toml: \[options\]: engine must be a text in quotes, got 3$"):
        UserData.from_toml(path, {"options.engine": 3})


def test_the_word_to_universal_slam_is_checked_at_once():
    with pytest.raises(ValueError, match="engine must be 'plain' or 'fast', got 'quick'"):
        universal_slam(UserData.from_dict(FLAT), engine="quick")
    with pytest.raises(ValueError, match="compressed is an option of the engine 'fast'"):
        universal_slam(UserData.from_dict(FLAT, {"options.compressed": True}), engine="plain")
