"""Two BLAS calls that scipy's own wrappers cannot make: on a block of a larger matrix, in place, without a copy.

numpy keeps no function for `C -= A A'`, and scipy's wrappers copy a matrix that is not contiguous. The functions
themselves are there: scipy exports their addresses for Cython, and `ctypes` calls them in about 2 us.
"""

import ctypes
from typing import Any

from scipy.linalg import cython_blas  # pyright: ignore[reportAttributeAccessIssue]


def _function(name, n_arguments):
    """The function that scipy exports for Cython by this name, as a C function of so many pointers."""
    get_name, get_pointer = ctypes.pythonapi.PyCapsule_GetName, ctypes.pythonapi.PyCapsule_GetPointer
    get_name.restype, get_name.argtypes = ctypes.c_char_p, [ctypes.py_object]
    get_pointer.restype, get_pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    capsule = cython_blas.__pyx_capi__[name]
    pointer = get_pointer(capsule, get_name(capsule))
    return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * n_arguments)(pointer)


_dgemm, _dsyrk = _function("dgemm", 13), _function("dsyrk", 10)
_one, _minus_one = ctypes.c_double(1.0), ctypes.c_double(-1.0)
_ONE, _MINUS_ONE = ctypes.addressof(_one), ctypes.addressof(_minus_one)


class Downdate:
    """P -= W W' in place, on the leading block of a column-major matrix.

    Addresses and the leading dimension are looked up once for each matrix, not once for each call.

    Parameters
    ----------
    P : ndarray, shape (capacity, capacity)
        Column-major.
    """

    def __init__(self, P):
        assert P.flags.f_contiguous and P.dtype == float
        self._P = P  # it must live as long as its address is in use
        self._n, self._m, self._ld = ctypes.c_int(), ctypes.c_int(), ctypes.c_int(max(len(P), 1))
        self._address = P.ctypes.data
        self._at_n, self._at_m, self._at_ld = (ctypes.addressof(i) for i in (self._n, self._m, self._ld))

    def __call__(self, Wt, lower):
        """Subtract W W' from the first n rows and columns.

        Parameters
        ----------
        Wt : ndarray, shape (m, n)
            W', row-major.
        lower : bool
            Of the result only the lower triangle is needed: half the work.
        """
        self._m.value, self._n.value = Wt.shape
        if not Wt.size:
            return
        if not Wt.flags.c_contiguous:
            Wt = Wt.copy()
        w, n, m, P, ld = ctypes.addressof(_bytes(Wt)), self._at_n, self._at_m, self._address, self._at_ld
        if lower:
            _dsyrk(b"L", b"N", n, m, _MINUS_ONE, w, n, _ONE, P, ld)
        else:
            _dgemm(b"N", b"T", n, n, m, _MINUS_ONE, w, n, w, n, _ONE, P, ld)


_bytes: Any = ctypes.c_char.from_buffer  # three times faster than `.ctypes.data`
