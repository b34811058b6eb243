"""Every `ekfslam ...` on the pages can be typed as it stands: words, scenario, changes, and what is resumed."""

import re
import shlex
from pathlib import Path

import pytest

from ekfslam_tutorial.cli.files import find_scenario, scenarios
from ekfslam_tutorial.cli.main import parser
from ekfslam_tutorial.toolbox import UserData, parse_override

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), ROOT / "data" / "README.md"]
TYPED = re.compile(r"^(?:    )?(?:\.venv/bin/)?ekfslam (\S.*)$|`ekfslam ([a-z][^`]*)`", re.MULTILINE)
STANDS_FOR = {
    "SCENARIO": "cloister_idp", "FILE": "cloister_idp", "NAME": "cloister_idp", "KEY=VALUE": "time.last=9", "SEED": "1",
    "N": "1", "data.set=S": "data.set=7", "data.robots=[R]": "data.robots=[1]", "robot.toml": "cloister_idp",
    "my_log/scenario.toml": "range_bearing_2d",
    "sensor|landmark|motion": "sensor", "DIR": "out", "FILE.html": "talk.html",
}  # fmt: skip


def typed(page):
    """The commands of a page, with their optional parts; not what is only talked about: `ekfslam run --resume`."""
    for match in TYPED.finditer(page.read_text(encoding="utf-8")):
        text = re.sub(r"\[(-[^\]]*?)(?: \.\.\.)?\]", r"\1", match[1] or match[2]).replace("RESULT...", "RESULT")
        if not re.match(r"recording|checkpoint|COMMAND|run (--|\.\.\.)", text):
            yield [STANDS_FOR.get(word, word) for word in shlex.split(text.replace("\\|", "|"))]


COMMANDS = [(page.name, words) for page in PAGES for words in typed(page)]


@pytest.mark.parametrize(("page", "words"), COMMANDS, ids=lambda v: " ".join(v) if isinstance(v, list) else v)
def test_a_command_of_the_pages_can_be_typed(page, words):
    options = vars(parser().parse_args(words))
    changes = dict(map(parse_override, options.get("set", []))) if options["command"] != "data" else {}
    if options.get("scenario"):
        assert Path(options["scenario"]).stem in scenarios()
        UserData.from_toml(find_scenario(options["scenario"]), changes)


def test_what_is_resumed_is_the_same_scenario():
    for name in {page for page, _ in COMMANDS}:
        given = [parser().parse_args(words) for page, words in COMMANDS if page == name]
        begun = [vars(o) for o in given if o.command in ("run", "monte-carlo") and o.out and not o.resume]
        for o in (vars(o) for o in given if getattr(o, "resume", False) and o.out):
            same = [b for b in begun if b["out"] == o["out"]]
            assert not same or any((b["scenario"], b["set"]) == (o["scenario"], o["set"]) for b in same), o["out"]


def test_there_are_commands_on_the_pages():
    assert len(COMMANDS) > 30 and any(page == "monte_carlo.md" for page, _ in COMMANDS)


def test_the_readme_names_every_scenario_that_there_is():
    section = re.split(
        r"^## ", (ROOT / "README.md").read_text(encoding="utf-8").split("\n## Scenarios\n")[1], flags=re.M
    )[0]
    assert set(re.findall(r"`([a-z0-9_]+)`", section)) == set(scenarios())
