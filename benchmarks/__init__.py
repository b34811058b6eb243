"""Benchmark of ekfslam_tutorial beside other people's filters: `make bench`. See benchmarks/README.md."""
