"""Slots and tuples for the compiler.

Slots are lists of fixed length without a heap, so that every thread of a CUDA device can have some. `slots(items)`
holds the items of a tuple, all of one type; `slots(items, value)` holds `value` as many times. Without the compiler
they are lists. Tuples are made of slots or arrays (`gather`), and gone through item by item with a law (`each`).
"""

# mypy: disable-error-code="attr-defined,import-untyped,no-untyped-call,untyped-decorator"
# The compiler's own modules are untyped.

import operator
from functools import reduce
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.extending import register_model
from numba.core.imputils import lower_builtin
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.np.arrayobj import make_array

from layflat.lanes import each, gather, slots, total, zero_if_finite
from layflat.lanes.typing import first_leaf


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


@infer_global(gather)
class _Gather(AbstractTemplate):
    key = gather

    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002  (the compiler's own interface)
        like, items = args
        item = items.item if isinstance(items, SlotsType) else items.dtype
        return signature(types.UniTuple(item, len(like)), like, items)


@lower_builtin(gather, types.BaseTuple, SlotsType)
@lower_builtin(gather, SlotsType, SlotsType)
def _gather_slots(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    found = [builder.load(cgutils.gep_inbounds(builder, args[1], 0, i)) for i in range(len(sig.return_type))]
    return context.make_tuple(builder, sig.return_type, found)


@lower_builtin(gather, types.BaseTuple, types.Array)
def _gather_array(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    array = make_array(sig.args[1])(context, builder, args[1])
    places = [[context.get_constant(types.intp, i)] for i in range(len(sig.return_type))]
    found = [builder.load(cgutils.get_item_pointer(context, builder, sig.args[1], array, place)) for place in places]
    return context.make_tuple(builder, sig.return_type, found)


@infer_global(total)
class _Total(AbstractTemplate):
    key = total

    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        return signature(args[0].types[0], args[0])


@lower_builtin(total, types.BaseTuple)
def _total(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return reduce(builder.fadd, cgutils.unpack_tuple(builder, args[0]))


@infer_global(zero_if_finite)
class _ZeroIfFinite(AbstractTemplate):
    key = zero_if_finite

    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        return signature(first_leaf(args[0]), args[0])


@lower_builtin(zero_if_finite, types.BaseTuple)
def _zero_if_finite(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    leaves = _leaves(builder, sig.args[0], args[0])
    return reduce(builder.fadd, [builder.fsub(leaf, leaf) for leaf in leaves])


def _leaves(builder: Any, kind: Any, value: Any) -> list[Any]:
    if not isinstance(kind, types.BaseTuple):
        return [value]
    items = zip(kind.types, cgutils.unpack_tuple(builder, value), strict=True)
    return [leaf for item, inner in items for leaf in _leaves(builder, item, inner)]


def _plain(kind: Any) -> bool:
    return isinstance(kind, types.BaseTuple) and not isinstance(kind, types.BaseNamedTuple)


def _called(law: Any, args: Any, context: Any) -> Any:
    """Signature of a law for the first items of plain tuples, which stand for all, and for what is none."""
    return law.get_call_type(context, tuple(arg.types[0] if _plain(arg) else arg for arg in args), {})


@infer_global(each)
class _Each(AbstractTemplate):
    key = each

    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        law, *others = args
        found = _called(law, others, self.context).return_type
        count = next(len(arg) for arg in others if _plain(arg))
        if _plain(found):
            return signature(types.Tuple([types.UniTuple(item, count) for item in found.types]), *args)
        return signature(types.UniTuple(found, count), *args)


@lower_builtin(each, types.Any, types.VarArg(types.Any))
def _each(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    law, *others = sig.args
    called = _called(law, others, context.typing_context)
    run = context.get_function(law, called)
    context.add_linking_libs(getattr(run, "libs", ()))
    several, count = _plain(called.return_type), 0
    columns = []
    for kind, value in zip(others, args[1:], strict=True):
        columns.append(cgutils.unpack_tuple(builder, value) if _plain(kind) else value)
        count = len(kind) if _plain(kind) else count
    found = [
        run(builder, [column[i] if isinstance(column, list) else column for column in columns]) for i in range(count)
    ]
    if several:
        parts = zip(*(cgutils.unpack_tuple(builder, value) for value in found), strict=True)
        made = [context.make_tuple(builder, kind, part) for kind, part in zip(sig.return_type, parts, strict=True)]
        return context.make_tuple(builder, sig.return_type, made)
    return context.make_tuple(builder, sig.return_type, found)
