"""The table of docs/audit.md is that of the stored run of benchmarks/honesty.py."""

import json

from benchmarks.honesty import PAGE, TABLE, marked


def test_the_table_of_the_page_is_the_stored_one():
    kept = json.loads(TABLE.read_text(encoding="utf-8"))
    assert len(kept["peers"]) == 5 and marked(kept) in PAGE.read_text(encoding="utf-8")
    verdicts = [s["verdict"] for s in kept["peers"].values()]
    assert verdicts.count("honest") == 3, "what the page says below the table"
