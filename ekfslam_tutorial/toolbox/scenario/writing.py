"""A scenario as the text of a TOML file: the way back of `reading.parse_toml`."""

import json


def to_toml(table):
    """Write nested tables as a scenario file.

    Parameters
    ----------
    table : dict
        Numbers, texts, true and false, lists; tables, and lists of tables at the top.

    Returns
    -------
    str
        `parse_toml` reads the same table from it.
    """
    tables = {key: value for key, value in table.items() if isinstance(value, dict)}
    entries = {key: value for key, value in table.items() if _are_tables(value)}
    lines = [_line(key, value) for key, value in table.items() if key not in tables and key not in entries]
    for key, value in table.items():
        if key in tables:
            lines += ["", f"[{key}]", *(_line(*item) for item in value.items())]
        for entry in entries.get(key, ()):
            lines += ["", f"[[{key}]]", *(_line(*item) for item in entry.items())]
    return "\n".join(lines).lstrip("\n") + "\n"


def _are_tables(value):
    return isinstance(value, list) and bool(value) and all(isinstance(entry, dict) for entry in value)


def _line(key, value):
    return f"{key} = {_value(value)}"


def _value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, dict):
        return "{" + ", ".join(_line(*item) for item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    return repr(value)  # numbers: TOML has the words inf and nan, too
