"""Slots for the compiler: lists of fixed length without a heap, so that every thread of a CUDA device can have some.

`slots(items)` holds the items of a tuple, all of one type; `slots(items, value)` holds `value` as many times. Without
the compiler they are lists.
"""

# mypy: disable-error-code="attr-defined,import-untyped,no-untyped-call,untyped-decorator"
# The compiler's own modules are untyped.

import operator
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.extending import register_model
from numba.core.imputils import lower_builtin
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate, infer_global

from layflat.lanes import slots


class SlotsType(types.Type):
    """`count` places for values of one type."""

    def __init__(self, item: types.Type, count: int) -> None:
        self.item, self.count = item, count
        super().__init__(name=f"Slots({item} x {count})")

    def __len__(self) -> int:
        return self.count


@register_model(SlotsType)
class _Pointer(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: SlotsType) -> None:
        places = ir.ArrayType(manager.lookup(kind.item).get_value_type(), kind.count)
        super().__init__(manager, kind, places.as_pointer())


@infer_global(slots)
class _Slots(AbstractTemplate):
    key = slots

    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002  (the compiler's own interface)
        items = args[0]
        if len(args) > 1:
            return signature(SlotsType(args[1], items.count), *args)
        return signature(SlotsType(items.dtype, items.count), *args) if isinstance(items, types.UniTuple) else None


@infer_global(operator.getitem)
class _Get(AbstractTemplate):
    key = operator.getitem

    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        return signature(args[0].item, args[0], types.intp) if isinstance(args[0], SlotsType) else None


@infer_global(operator.setitem)
class _Set(AbstractTemplate):
    key = operator.setitem

    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        kind = args[0]
        return signature(types.none, kind, types.intp, kind.item) if isinstance(kind, SlotsType) else None


@lower_builtin(slots, types.UniTuple)
def _of_items(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return cgutils.alloca_once_value(builder, args[0])


@lower_builtin(slots, types.Any, types.Any)
def _of_values(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    room = cgutils.alloca_once(builder, context.get_value_type(sig.return_type).pointee)
    for place in range(sig.return_type.count):
        builder.store(args[1], cgutils.gep_inbounds(builder, room, 0, place))
    return room


@lower_builtin(operator.getitem, SlotsType, types.Integer)
def _get(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return builder.load(cgutils.gep_inbounds(builder, args[0], 0, args[1]))


@lower_builtin(operator.setitem, SlotsType, types.Integer, types.Any)
def _set(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    builder.store(args[2], cgutils.gep_inbounds(builder, args[0], 0, args[1]))
    return context.get_dummy_value()
