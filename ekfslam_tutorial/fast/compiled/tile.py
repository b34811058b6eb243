"""Sums that stay in the registers of the processor: the one place where instructions are chosen by hand.

A compiler makes vectors of inner loops, but keeps no block of the result in registers while it sums. Here that counts.
P -= W W' for 203 states and 20 rows of W': plain loops need 30 us, BLAS 24 us, tiles 16 us, the arithmetic alone 15 us.
And before each loop a compiler asks whether its arrays overlap: of 20 rows of H P, 66 numbers each, that was a third.
"""

from functools import partial
from typing import Any

from llvmlite import ir
from llvmlite.binding import get_host_cpu_features
from numba import extending, types
from numba.core import cgutils

from ..storage import LINE as ROWS  # storage is whole lines of the cache, so tiles never leave it
from ..storage import WIDTH

COLUMNS = 8 if get_host_cpu_features().get("avx512f") else 4  # for which there are registers
TALL = 2 if COLUMNS == 8 else 1  # lines of a tall tile, for which there are registers, too

NUMBERS = ir.VectorType(ir.DoubleType(), ROWS)
FIRST = ir.Constant(ir.IntType(32), 0)
SAME = ir.Constant(ir.VectorType(ir.IntType(32), ROWS), [FIRST] * ROWS)
intrinsic: Any = extending.intrinsic  # what it makes is called without `typing`
ONCE = ("contract",)  # a - b c may be rounded once


@intrinsic
def subtract_tile(typing, P, i, j, Wt):
    """P[i : i + ROWS, j : j + COLUMNS] -= W[i : i + ROWS] W[j : j + COLUMNS]'; nobody looks whether that is inside.

    P is column-major, and W' row-major.
    """
    return types.void(P, types.intp, types.intp, Wt), _subtracted_tile


@intrinsic
def subtract_tall_tile(typing, P, i, j, Wt):
    """Do as `subtract_tile`, of TALL lines: what is read of W' for the columns serves all of them."""
    return types.void(P, types.intp, types.intp, Wt), partial(_subtracted_tile, lines=TALL)


@intrinsic
def product_tile(typing, out, i, j, At, Bt):
    """out[i : i + ROWS, j : j + COLUMNS] = A[i : i + ROWS] B[j : j + COLUMNS]'; nobody looks whether that is inside.

    `out` is column-major, A' and B' are row-major.
    """
    return types.void(out, types.intp, types.intp, At, Bt), _tile


@intrinsic
def subtract_rows(typing, out, i, j, H, rows, n, factor):
    """out[i, j : j + WIDTH] -= H[i, :n] rows[:n, j : j + WIDTH], times a factor; nobody looks whether that is inside.

    Numbers of a row stand side by side. A row of `out` may be one of a matrix whose rows before it are `rows`.
    """
    return types.void(out, types.intp, types.intp, H, rows, types.intp, types.float64), _row


def _subtracted_tile(context, builder, signature, arguments, lines=1):
    (P_type, _, _, Wt_type), (P, i, j, Wt) = signature.args, arguments
    P, Wt = _Array(context, builder, P_type, P), _Array(context, builder, Wt_type, Wt)
    places, products = _of_a_tile(builder, P, i, j, Wt, Wt, lines)
    _sum(builder, places, Wt.length, products, builder.fsub, [builder.load(place, align=8) for place in places])
    return context.get_dummy_value()


def _tile(context, builder, signature, arguments):
    (out_type, _, _, *kinds), (out, i, j, *factors) = signature.args, arguments
    out = _Array(context, builder, out_type, out)
    At, Bt = (_Array(context, builder, kind, a) for kind, a in zip(kinds, factors, strict=True))
    places, products = _of_a_tile(builder, out, i, j, At, Bt)
    _sum(builder, places, At.length, products, builder.fadd, [ir.Constant(NUMBERS, [0.0] * ROWS)] * len(places))
    return context.get_dummy_value()


def _of_a_tile(builder, P, i, j, At, Bt, lines=1):
    """Places of the lines of a tile of P, and what comes to them from row k of A' and B'."""
    js = [builder.add(j, ir.Constant(j.type, column)) for column in range(COLUMNS)]
    rows = [builder.add(i, ir.Constant(i.type, line * ROWS)) for line in range(lines)]

    def products(k):
        a = [At.line(k, row) for row in rows]
        b = [Bt.everywhere(k, j) for j in js]
        return [builder.fmul(a_i, b_j, flags=ONCE) for b_j in b for a_i in a]

    return [P.place(row, j) for j in js for row in rows], products


def _row(context, builder, signature, arguments):
    out_type, _, _, H_type, rows_type, _, _ = signature.args
    out, i, j, H, rows, n, factor = arguments
    out, H, rows = (_Array(context, builder, kind, a) for kind, a in ((out_type, out), (H_type, H), (rows_type, rows)))
    js = [builder.add(j, ir.Constant(j.type, column)) for column in range(0, WIDTH, ROWS)]

    def products(k):
        h_k = H.everywhere(i, k)
        return [builder.fmul(h_k, rows.line(k, j), flags=ONCE) for j in js]

    places = [out.place(i, j) for j in js]
    before = [builder.load(place, align=8) for place in places]
    _sum(builder, places, n, products, builder.fsub, before, everywhere(builder, factor))
    return context.get_dummy_value()


def _sum(builder, places, n, products, sign, before, factor=None):
    """Add products(k), or subtract them, for all k < n; then write them to these places: sums stay in registers."""
    sums = [cgutils.alloca_once_value(builder, line) for line in before]
    with cgutils.for_range(builder, n) as k:
        for line, product in zip(sums, products(k.index), strict=True):
            builder.store(sign(builder.load(line), product, flags=ONCE), line)
    for place, line in zip(places, sums, strict=True):
        total = builder.load(line)
        builder.store(builder.fmul(total, factor) if factor else total, place, align=8)


def everywhere(builder, number):
    """A line in which all numbers are this one."""
    line = builder.insert_element(ir.Constant(NUMBERS, ir.Undefined), number, FIRST)
    return builder.shuffle_vector(line, line, SAME)


class _Array:
    """An array, and how its numbers are read."""

    def __init__(self, context, builder, kind, value):
        self.context, self.builder, self.kind = context, builder, kind
        self.array = context.make_array(kind)(context, builder, value)
        self.length = cgutils.unpack_tuple(builder, self.array.shape)[0]

    def _number(self, *index):
        return cgutils.get_item_pointer(self.context, self.builder, self.kind, self.array, index)

    def place(self, *index):
        """Place of the line that begins with this number."""
        return self.builder.bitcast(self._number(*index), NUMBERS.as_pointer())

    def line(self, *index):
        """Line that begins with this number."""
        return self.builder.load(self.place(*index), align=8)

    def everywhere(self, *index):
        """A line in which all numbers are this one."""
        return everywhere(self.builder, self.builder.load(self._number(*index)))
