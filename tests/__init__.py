"""Tests. A package, so that `python -m tests.golden.functions DIR` can be run from the repository."""
