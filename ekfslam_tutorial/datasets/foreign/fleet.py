"""Several robots in one log: a column says whose row it is, or each robot has its own tables."""

from dataclasses import replace

import numpy as np

WITH_ROBOT = "odometry", "scan", "truth", "gps"
"""Roles whose rows are of one robot each; a map is of all."""
ROBOT = "robot"
"""The column of tables that are put one below the other."""


def stacked(tables, plan):
    """Put tables one below the other where a role of the plan comes from a list of them, one for each robot.

    Parameters
    ----------
    tables : list of Table
    plan : dict

    Returns
    -------
    tables : list of Table
        Those in the lists are replaced.
    plan : dict
        With the name of the one table in the place of each list.
    lists : dict of str to list of str
        By that name: the tables that it is made of.

    Raises
    ------
    ValueError
        One sentence: a table that is not there, or tables without a common column.
    """
    by_name, lists, plan = {table.name: table for table in tables}, {}, dict(plan)
    for role, entry in plan.items():
        names = entry.get("from") if isinstance(entry, dict) else None
        if not isinstance(names, list):
            continue
        missing = [name for name in names if name not in by_name]
        if missing or len(set(names)) < 2 or role not in WITH_ROBOT:
            raise ValueError(
                f"{role}: from = [...] names the tables of several robots, of {', '.join(WITH_ROBOT)}; "
                f"got {names!r}, there are {', '.join(by_name)}"
            )
        name = "+".join(names)
        lists[name] = names
        plan[role] = entry | {"from": name}
    gone = {name for names in lists.values() for name in names}
    made = [below(name, {str(k): by_name[n] for k, n in enumerate(names, 1)}) for name, names in lists.items()]
    return [table for table in tables if table.name not in gone] + made, plan, lists


def below(name, tables):
    """One table of several, one below the other, with a column that says whose row it is.

    Parameters
    ----------
    name : str
        Its name.
    tables : dict of str to Table
        By the name of the robot.

    Returns
    -------
    Table
    """
    several = list(tables.values())
    common = [c for c in several[0].columns if all(c in table.columns for table in several)]
    if not common:
        each = "; ".join(f"{table.name} has {', '.join(table.columns)}" for table in several)
        raise ValueError(f"tables of several robots need the same columns: {each}")
    columns = {c: np.concatenate([table.columns[c] for table in several]) for c in common if c != ROBOT}
    columns[ROBOT] = np.concatenate([np.full(len(table), float(k)) for k, table in enumerate(several, 1)])
    words = {c: ws for table in several for c, ws in table.words.items() if c in common}
    words[ROBOT] = {robot: k for k, robot in enumerate(tables, 1)}
    notes = tuple(f"{table.name}: {note}" for table in several for note in table.notes)
    return replace(several[0], name=name, columns=columns, words=words, notes=notes)


def robots_of(plan, tables):
    """Tell which robots a log is of.

    Parameters
    ----------
    plan : dict
        Checked and completed.
    tables : dict of str to Table

    Returns
    -------
    dict of str to dict of str to float
        By the name of each robot: the number that stands for it in each role. One robot without a name and numbers,
        if no column says whose row it is, or all are of one.

    Raises
    ------
    ValueError
        A role does not say whose its rows are, or one knows of other robots than another.
    """
    found = {}
    for role, entry in plan.items():
        if "robot" in entry:
            table = tables[entry["from"]]
            a, names = table.columns[entry["robot"]], {k: w for w, k in table.words.get(entry["robot"], {}).items()}
            numbers = np.unique(a[np.isfinite(a)]).tolist()
            found[role] = {names.get(int(k), f"{k:g}"): k for k in numbers}
    if max(map(len, found.values()), default=1) < 2:
        return {"": {}}
    several = next(role for role in plan if len(found.get(role, ())) > 1)
    for role in (role for role in WITH_ROBOT if role in plan):
        if role not in found:
            raise ValueError(
                f"{several} is of the robots {', '.join(found[several])}; whose are the rows of {plan[role]['from']}? "
                f"--set {role}.robot=COLUMN, or {role}.from=[...] with a table of each"
            )
    odometry, scan = set(found["odometry"]), set(found["scan"])
    if odometry != scan:
        raise ValueError(
            f"odometry is of the robots {', '.join(sorted(odometry))}, scan of {', '.join(sorted(scan))}: each robot "
            "needs both"
        )
    return {name: {role: robots[name] for role, robots in found.items() if name in robots} for name in found["scan"]}


def by_robot(plan, tables):
    """The tables with the rows of each robot together, as a path needs them.

    Parameters
    ----------
    plan : dict
    tables : dict of str to Table

    Returns
    -------
    dict of str to Table
    """
    tables = dict(tables)
    for entry in (entry for entry in plan.values() if "robot" in entry):
        table = tables[entry["from"]]
        order = np.argsort(table.columns[entry["robot"]], kind="stable")
        tables[table.name] = replace(table, columns={c: a[order] for c, a in table.columns.items()})
    return tables


def of_robot(plan, tables, numbers):
    """The plan and the tables of one robot, without the column that says so; a role that it has no rows of is left out.

    Parameters
    ----------
    plan : dict
    tables : dict of str to Table
    numbers : dict of str to float
        By role: what stands for this robot.

    Returns
    -------
    plan : dict
    tables : dict of str to Table
        Those of a role have its name, since one table may be of two roles.
    """
    own_plan, own = {}, {}
    for role, entry in plan.items():
        table = tables[entry["from"]]
        if "robot" in entry and numbers:
            if role not in numbers:
                continue
            mine = table.columns[entry["robot"]] == numbers[role]
            table = replace(table, columns={c: a[mine] for c, a in table.columns.items()})
        own_plan[role] = {m: c for m, c in entry.items() if m != "robot"}
        own[role] = table
    return own_plan, own
