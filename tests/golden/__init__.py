"""Numbers recorded from other programs, and how this package compares with them.

`python -m tests.golden.functions DIR`   values of low-level functions
`python -m tests.golden.runs DIR`        whole SLAM runs: controls and measurements replayed
"""
