"""What this machine is, how fast it multiplies and moves bytes; and the physical limit of a filter on it."""

import importlib.metadata
import os
import platform
import sys

import numpy as np
from scipy.linalg.blas import dgemm
from threadpoolctl import threadpool_info

import ekfslam_tutorial

from .clock import Variant, compare

GEMM = 512  # rows of the square matrices whose product is timed
SIZES_MB = (0.0625, 0.25, 1, 4, 8, 16, 32, 64, 128, 256)
PACKAGES = ("numpy", "scipy", "filterpy", "roboticstoolbox-python", "stonesoup", "gtsam", "numba")


def describe():
    """Name and size of the machine; nothing that names its owner."""
    blas = [{key: pool.get(key) for key in ("internal_api", "version", "architecture")} for pool in threadpool_info()]
    return {
        "cpu": _cpu_name(),
        "cores": os.cpu_count(),
        "memory_gb": _memory_gb(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": sys.version.split()[0],
        "blas": blas,
    }


def versions():
    """Versions of the package and of the peers that are installed."""
    found = {"ekfslam_tutorial": ekfslam_tutorial.__version__}
    for name in PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


def _cpu_name():
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def _memory_gb():
    try:
        return round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30)
    except (ValueError, OSError, AttributeError):
        return None


# --- calibration -----------------------------------------------------------------------------------------------------


def gemm_variant():
    """A product of two matrices, C += A B: what multiplies fastest on this machine."""
    rng = np.random.default_rng(0)
    A, B = (np.asfortranarray(rng.normal(size=(GEMM, GEMM))) for _ in range(2))
    C = np.zeros((GEMM, GEMM), order="F")
    return Variant("dgemm", lambda: lambda k: dgemm(1.0, A, B, 0.0, C, overwrite_c=1))


def bandwidth_variant(n_bytes):
    """An array multiplied in place: each byte is read and written once."""

    def make():
        a = np.ones(max(int(n_bytes), 65536) // 8)
        return lambda k: np.multiply(a, 1.0, out=a)

    return Variant("in place", make, info={"bytes": max(int(n_bytes), 65536)})


def gflops(result):
    """10^9 floating-point operations per second, from the summary of `gemm_variant`."""
    return 2 * GEMM**3 / result["cpu_us"]["median"] / 1e3


def gigabytes(result):
    """10^9 bytes per second, read and written, from the summary of `bandwidth_variant`."""
    return 2 * result["bytes"] / result["cpu_us"]["median"] / 1e3


def calibrate(budget, sizes_mb=SIZES_MB):
    """The curve: GFLOP/s of dgemm, and GB/s in place for arrays of many sizes."""
    rate = compare([gemm_variant()], budget)["dgemm"]
    curve = []
    for size in sizes_mb:
        one = compare([bandwidth_variant(size * 2**20)], budget / 2, rounds=3)["in place"]
        curve.append({"mb": size, "gb_per_s": gigabytes(one)})
    return {"dgemm_gflops": gflops(rate), "in_place": curve}


# --- the limit -------------------------------------------------------------------------------------------------------


def triangle_bytes(n):
    """Bytes of one triangle of an n x n covariance."""
    return 4 * n * n


def limit_us(n, rank, times, gflops, gb_per_s):
    """Least time for `times` corrections of the given rank of an n x n covariance.

    One triangle of P -= W W' needs n^2 rank operations, and reads and writes 8 n^2 bytes. Whichever takes longer at the
    rates measured on this machine is the limit; computing W comes on top in any real filter.

    Returns
    -------
    float
        Microseconds.
    """
    return times * max(n * n * rank / gflops, 2 * triangle_bytes(n) / gb_per_s) / 1e3
