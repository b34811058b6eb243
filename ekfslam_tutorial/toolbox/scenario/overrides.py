"""Changes to a scenario from the command line: `--set robot.1.dx_std=0.01`."""

import re
import tomllib

from ..user_input import short_text


def parse_override(text):
    """Split KEY=VALUE into a dotted key and a value as in TOML; words, paths and topics need no quotes.

    >>> parse_override("data.robots=[1, 2]")
    ('data.robots', [1, 2])
    >>> parse_override("landmark.type=ahm_pnt")
    ('landmark.type', 'ahm_pnt')
    >>> parse_override("scan.from=/landmarks")
    ('scan.from', '/landmarks')
    """
    key, equals, value = text.partition("=")
    key, value = key.strip(), value.strip()
    if not equals or not re.fullmatch(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*", key):
        raise ValueError(
            f"--set {short_text(text)}: write KEY=VALUE, for example data.set=7 or robot.1.dx_std=[0.01, 0, 0]"
        )
    try:
        (parsed,) = tomllib.loads(f"value = {value}").values()
        return key, parsed
    except (ValueError, RecursionError):  # no TOML, or more than one value
        if re.fullmatch(r"([A-Za-z_/~]|\.{1,2}/)[\w./ -]*(\[[^\]]*\]|\([^)]*\))?", value):
            return key, value
        raise ValueError(
            f'--set {key}: {short_text(value)} is no value; write it as in TOML: 0.1, true, [1, 2], "text"'
        ) from None


def override(table, key, value):
    """Put a value into nested tables, under a dotted key.

    In a list of entries a number picks the one with that id; anything else goes to all of them.
    """
    _put(table, key.split("."), value, key)


def _put(table, path, value, key):
    if isinstance(table, list):
        _put_into_entries(table, path, value, key)
    elif not isinstance(table, dict) or not path:
        raise ValueError(f"--set {key}: this names a part of the scenario that takes no value as a whole")
    elif len(path) == 1:
        table[path[0]] = value
    else:
        _put(table.setdefault(path[0], {}), path[1:], value, key)


def _put_into_entries(entries, path, value, key):
    ids = [str(entry.get("id", number)) for number, entry in enumerate(entries, 1)]
    by_id = bool(path) and path[0].isdigit()
    if by_id and path[0] not in ids:
        raise ValueError(f"--set {key}: there is no entry with the id {path[0]}; ids: {', '.join(ids) or 'none'}")
    for id, entry in zip(ids, entries, strict=True):
        if not by_id:
            _put(entry, path, value, key)
        elif id == path[0]:
            _put(entry, path[1:], value, key)
