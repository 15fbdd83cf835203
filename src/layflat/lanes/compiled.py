"""Teach the compiler lanes: importing this registers their types, instructions, slots, and the way out to Python.

Here stands how lanes come out to Python, and how the structure of a tuple comes in.
"""

# mypy: disable-error-code="no-untyped-call,import-untyped,untyped-decorator"
# The compiler's own modules are untyped.

from typing import Any

from llvmlite import ir
from numba.core.extending import NativeValue, box, unbox

import layflat.lanes.lowering
import layflat.lanes.tuples  # noqa: F401
from layflat.lanes import Lanes
from layflat.lanes.typing import LanesType, LikeType


@box(LanesType)
def _lanes(kind: Any, value: Any, c: Any) -> Any:
    places = [ir.Constant(ir.IntType(32), i) for i in range(kind.count)]
    numbers = [c.box(kind.leaf, c.builder.extract_element(value, place)) for place in places]
    together = c.pyapi.tuple_pack(numbers)
    made_by = c.pyapi.unserialize(c.pyapi.serialize_object(Lanes))
    lanes = c.pyapi.call_function_objargs(made_by, [together])
    for used in (*numbers, together, made_by):
        c.pyapi.decref(used)
    return lanes


@unbox(LikeType)
def _like(kind: Any, value: Any, c: Any) -> Any:  # noqa: ARG001  (the compiler's own interface)
    return NativeValue(c.context.get_dummy_value())
