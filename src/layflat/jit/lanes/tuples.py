"""Slots and tuples for the compiler.

Slots are lists of fixed length on the stack, so that every thread of a CUDA device can have some. `slots(items)` holds
the items of a tuple, all of one type; `slots(items, value)` holds `value` as many times. Without the compiler they are
lists. `gather` builds tuples from slots or arrays, and `each` maps a law over their items.
"""

# mypy: disable-error-code="attr-defined,import-untyped,no-untyped-call,untyped-decorator"
# The compiler's own modules are untyped.

import operator
from functools import reduce
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin, models, register_model

from layflat.jit.internals import register_typing
from layflat.jit.lanes.typing import first_leaf
from layflat.lanes import each, gather, slots, total, zero_if_finite


class SlotsType(types.Type):
    """`count` places for values of one type."""

    def __init__(self, item: types.Type, count: int) -> None:
        self.item, self.count = item, count
        super().__init__(name=f"Slots({item} x {count})")

    def __len__(self) -> int:
        return self.count


@register_model(SlotsType)
class _Pointer(models.PrimitiveModel):
    """Data model of slots: a pointer to an array of values on the stack."""

    def __init__(self, manager: Any, kind: SlotsType) -> None:
        places = ir.ArrayType(manager.lookup(kind.item).get_value_type(), kind.count)
        super().__init__(manager, kind, places.as_pointer())


def _slots_type(items: Any, *value: Any) -> Any:
    """Return the type of slots for the items of a tuple, or for as many copies of a value; None for mixed items."""
    if value:
        return SlotsType(value[0], items.count)
    return SlotsType(items.dtype, items.count) if isinstance(items, types.UniTuple) else None


def _getitem_signature(kind: Any, _: Any) -> Any:
    return kind.item(kind, types.intp) if isinstance(kind, SlotsType) else None


def _setitem_signature(kind: Any, _place: Any, _value: Any) -> Any:
    return types.none(kind, types.intp, kind.item) if isinstance(kind, SlotsType) else None


def _len_signature(kind: Any) -> Any:
    return types.intp(kind) if isinstance(kind, SlotsType) else None


register_typing([slots], _slots_type)
register_typing([operator.getitem], _getitem_signature)
register_typing([operator.setitem], _setitem_signature)
register_typing([len], _len_signature)


@lower_builtin(slots, types.UniTuple)
def _store_items(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return cgutils.alloca_once_value(builder, args[0])


@lower_builtin(slots, types.Any, types.Any)
def _fill_slots(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit slots that all hold one value."""
    places = cgutils.alloca_once(builder, context.get_value_type(sig.return_type).pointee)
    for place in range(sig.return_type.count):
        builder.store(args[1], cgutils.gep_inbounds(builder, places, 0, place))
    return places


@lower_builtin(operator.getitem, SlotsType, types.Integer)
def _load_item(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return builder.load(cgutils.gep_inbounds(builder, args[0], 0, args[1]))


@lower_builtin(len, SlotsType)
def _slot_count(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return context.get_constant(types.intp, sig.args[0].count)


@lower_builtin(operator.setitem, SlotsType, types.Integer, types.Any)
def _store_item(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    """Emit the storing of a value in the slot of an index, without a check of its range."""
    builder.store(args[2], cgutils.gep_inbounds(builder, args[0], 0, args[1]))
    return context.get_dummy_value()


def _gather_type(like: Any, items: Any) -> Any:
    """Return the type of `gather`: a tuple as long as `like`; floats get the precision of its first item."""
    item = items.item if isinstance(items, SlotsType) else items.dtype
    first = like.types[0] if isinstance(like, types.BaseTuple) else item
    both = isinstance(item, types.Float) and isinstance(first, types.Float)
    return types.UniTuple(first if both else item, len(like))


register_typing([gather], _gather_type)


@lower_builtin(gather, types.BaseTuple, SlotsType)
@lower_builtin(gather, SlotsType, SlotsType)
def _gather_slots(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit a tuple of the first items of slots, as many as the first argument has."""
    items = [builder.load(cgutils.gep_inbounds(builder, args[1], 0, i)) for i in range(len(sig.return_type))]
    return context.make_tuple(builder, sig.return_type, items)


@lower_builtin(gather, types.BaseTuple, types.Array)
def _gather_array(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit a tuple of the first elements of an array, as many as the tuple has."""
    array = context.make_array(sig.args[1])(context, builder, args[1])
    places = [[context.get_constant(types.intp, i)] for i in range(len(sig.return_type))]
    items = [builder.load(cgutils.get_item_pointer(context, builder, sig.args[1], array, place)) for place in places]
    items = [context.cast(builder, item, sig.args[1].dtype, sig.return_type.dtype) for item in items]
    return context.make_tuple(builder, sig.return_type, items)


register_typing([total], lambda numbers: numbers.types[0])
register_typing([zero_if_finite], first_leaf)


@lower_builtin(total, types.BaseTuple)
def _total(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    return reduce(builder.fadd, cgutils.unpack_tuple(builder, args[0]))


@lower_builtin(zero_if_finite, types.BaseTuple)
def _zero_if_finite(context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG001
    """Emit the sum of x - x over all leaves x: 0, or NaN if one is not finite."""
    leaves = _leaves(builder, sig.args[0], args[0])
    return reduce(builder.fadd, [builder.fsub(leaf, leaf) for leaf in leaves])


def _leaves(builder: Any, kind: Any, value: Any) -> list[Any]:
    """Return the values of all leaves of a nested tuple, in order."""
    if not isinstance(kind, types.BaseTuple):
        return [value]
    items = zip(kind.types, cgutils.unpack_tuple(builder, value), strict=True)
    return [leaf for item, inner in items for leaf in _leaves(builder, item, inner)]


def _is_plain_tuple(kind: Any) -> bool:
    return isinstance(kind, types.BaseTuple) and not isinstance(kind, types.BaseNamedTuple)


def _call_signature(law: Any, args: Any, context: Any) -> Any:
    """Return the signature of a law for the first items of plain tuples, which represent all, and other arguments."""
    return law.get_call_type(context, tuple(arg.types[0] if _is_plain_tuple(arg) else arg for arg in args), {})


def _each_type(context: Any, law: Any, *args: Any) -> Any:
    """Return the type of `each`: a tuple of the law's results, or for a law with several results a tuple of each."""
    result = _call_signature(law, args, context).return_type
    count = next(len(arg) for arg in args if _is_plain_tuple(arg))
    if _is_plain_tuple(result):
        return types.Tuple([types.UniTuple(item, count) for item in result.types])
    return types.UniTuple(result, count)


register_typing([each], _each_type, in_context=True)


@lower_builtin(each, types.Any, types.VarArg(types.Any))
def _each(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit `each`: calls of a law with the items of all tuples at each index; other arguments are the same in all."""
    law, *others = sig.args
    called = _call_signature(law, others, context.typing_context)
    run = context.get_function(law, called)
    context.add_linking_libs(getattr(run, "libs", ()))
    several, count = _is_plain_tuple(called.return_type), 0
    columns = []
    for kind, value in zip(others, args[1:], strict=True):
        columns.append(cgutils.unpack_tuple(builder, value) if _is_plain_tuple(kind) else value)
        count = len(kind) if _is_plain_tuple(kind) else count
    results = [
        run(builder, [column[i] if isinstance(column, list) else column for column in columns]) for i in range(count)
    ]
    if several:
        parts = zip(*(cgutils.unpack_tuple(builder, value) for value in results), strict=True)
        tuples = [context.make_tuple(builder, kind, part) for kind, part in zip(sig.return_type, parts, strict=True)]
        return context.make_tuple(builder, sig.return_type, tuples)
    return context.make_tuple(builder, sig.return_type, results)
