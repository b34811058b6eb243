"""P -= W W' with a tile of P in the registers of the processor: the one place where instructions are chosen by hand.

A compiler makes vectors of inner loops, but keeps no block of the result in registers while it sums. Here that counts:
for 203 states and 20 rows of W' plain loops need 30 us, BLAS 24 us, tiles 16 us, and the arithmetic alone 15 us.
"""

from llvmlite import ir
from llvmlite.binding import get_host_cpu_features
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..ekf.stochastic_map import LINE as ROWS  # storage is whole lines of the cache, so tiles never leave it

COLUMNS = 8 if get_host_cpu_features().get("avx512f") else 4  # for which there are registers

NUMBERS = ir.VectorType(ir.DoubleType(), ROWS)
SAME = ir.Constant(ir.VectorType(ir.IntType(32), ROWS), [0] * ROWS)
ONCE = ("contract",)  # a - b c may be rounded once


@intrinsic
def subtract_tile(typing, P, i, j, Wt):
    """P[i : i + ROWS, j : j + COLUMNS] -= W[i : i + ROWS] W[j : j + COLUMNS]'; nobody looks whether that is inside.

    P is column-major, and W' row-major.
    """
    return types.void(P, types.intp, types.intp, Wt), _instructions


def _instructions(context, builder, signature, arguments):
    P_type, _, _, Wt_type = signature.args
    P, i, j, Wt = arguments
    P, Wt = context.make_array(P_type)(context, builder, P), context.make_array(Wt_type)(context, builder, Wt)
    js = [builder.add(j, ir.Constant(j.type, c)) for c in range(COLUMNS)]

    def number_at(kind, array, *index):
        return cgutils.get_item_pointer(context, builder, kind, array, index)

    def line_at(kind, array, *index):
        return builder.bitcast(number_at(kind, array, *index), NUMBERS.as_pointer())

    places = [line_at(P_type, P, i, j) for j in js]
    tile = [cgutils.alloca_once_value(builder, builder.load(place, align=8)) for place in places]
    with cgutils.for_range(builder, cgutils.unpack_tuple(builder, Wt.shape)[0]) as k:
        w_i = builder.load(line_at(Wt_type, Wt, k.index, i), align=8)
        for column, j in zip(tile, js, strict=True):
            w_j = builder.load(number_at(Wt_type, Wt, k.index, j))
            w_j = builder.insert_element(ir.Constant(NUMBERS, ir.Undefined), w_j, ir.Constant(j.type, 0))
            product = builder.fmul(w_i, builder.shuffle_vector(w_j, w_j, SAME), flags=ONCE)
            builder.store(builder.fsub(builder.load(column), product, flags=ONCE), column)
    for place, column in zip(places, tile, strict=True):
        builder.store(builder.load(column), place, align=8)
    return context.get_dummy_value()
