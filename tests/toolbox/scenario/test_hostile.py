"""Scenario files that nobody should write: whatever is in them gets one sentence, never a crash."""

import copy
import json

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ekfslam_tutorial.toolbox import UserData, parse_override, universal_slam
from tests.toolbox.scenarios import FLAT, SPACE

WORDS = ["type", "motion", "id", "robot", "v", "w_deg", "w", "k", "d", "position", "position_std", "range_std", "fov"]
WORDS += ["euc_pnt", "idp_pnt", "pin_hole", "range_bearing", "unicycle", "jcbb", "ring", "cloister", "inf", ""]
scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 5),
    st.integers(),
    st.floats(),
    st.sampled_from(WORDS),
    st.text(max_size=6),
)
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(WORDS), inner, max_size=3),
    max_leaves=8,
)


def paths(table):
    """All places of a nested table, as tuples of keys."""
    items = table.items() if isinstance(table, dict) else enumerate(table) if isinstance(table, list) else ()
    for key, value in items:
        yield (key,)
        yield from ((key, *rest) for rest in paths(value))


def put(table, path, value):
    for key in path[:-1]:
        table = table[key]
    table[path[-1]] = value


PLACES = [(table, path) for table in (FLAT, SPACE) for path in paths(table)]
NEW = [
    (t, (*p, word)) for t in (FLAT, SPACE) for p in ((), ("robot", 0), ("sensor", 0), ("landmark",)) for word in WORDS
]


@settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.sampled_from(PLACES + NEW), values)
def test_any_value_anywhere_is_taken_or_refused_in_one_sentence(place, value):
    table, path = place
    changed = copy.deepcopy(table)
    put(changed, path, value)
    before = json.dumps(changed, default=repr)
    try:
        data = UserData.from_dict(changed)
        assert data.world is None or json.dumps(changed, default=repr) == before
    except (ValueError, TypeError) as error:
        assert str(error) and "\n" not in str(error) and "object has no attribute" not in str(error)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.sampled_from(PLACES), st.floats() | st.integers(-3, 3))
def test_what_is_taken_can_be_run_or_is_refused_before_its_first_frame(place, value):
    table, path = place
    if "n" in path or "last" in path:
        return  # a large world or a long run is slow, not wrong
    changed = copy.deepcopy(table)
    put(changed, path, value)
    try:
        run = universal_slam(UserData.from_dict(changed, {"time.last": 1}))
    except (ValueError, TypeError, OverflowError):
        return
    try:
        next(run)
    except ValueError as error:  # numbers beyond all measure, noticed by the filter
        assert "finite" in str(error) or "definite" in str(error)


@settings(max_examples=200, deadline=None)
@given(st.text(max_size=20))
def test_any_override_is_parsed_or_refused(text):
    for candidate in (text, f"key={text}", f"{text}=1"):
        try:
            key, _ = parse_override(candidate)
            assert key
        except ValueError as error:
            assert str(error).startswith("--set")
