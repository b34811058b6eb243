"""One BLAS call that scipy's own wrapper cannot make: on a block of a larger matrix, in place, without a copy."""

import ctypes

import numpy as np
from scipy.linalg import cython_blas  # pyright: ignore[reportAttributeAccessIssue]


def _pointer(name):
    """Function pointer that scipy exports for Cython, as a C function."""
    get_name, get_pointer = ctypes.pythonapi.PyCapsule_GetName, ctypes.pythonapi.PyCapsule_GetPointer
    get_name.restype, get_name.argtypes = ctypes.c_char_p, [ctypes.py_object]
    get_pointer.restype, get_pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    capsule = cython_blas.__pyx_capi__[name]
    return get_pointer(capsule, get_name(capsule))


_dgemm = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 13)(_pointer("dgemm"))
_one, _minus_one = ctypes.c_double(1.0), ctypes.c_double(-1.0)
_ONE, _MINUS_ONE = ctypes.addressof(_one), ctypes.addressof(_minus_one)
_int = ctypes.c_int


def subtract_product(P, W):
    """P -= W W' in place.

    Parameters
    ----------
    P : ndarray, shape (n, n)
        Column-major, or the leading block of a larger column-major matrix.
    W : ndarray, shape (n, m)
    """
    n, m = W.shape
    if not n or not m:
        return
    W = np.asfortranarray(W)
    size, rank, lda, ldc = _int(n), _int(m), _int(n), _int(P.strides[1] // P.itemsize)
    N, K, LDA, LDC = (ctypes.addressof(i) for i in (size, rank, lda, ldc))
    w = W.ctypes.data
    _dgemm(b"N", b"T", N, N, K, _MINUS_ONE, w, LDA, w, LDA, _ONE, P.ctypes.data, LDC)
