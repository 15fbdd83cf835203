"""`each` for the compiler: a call of a law for each item of some tuples, or one call for all of them.

In code that is to be small (see `inlining`), single numbers lie abreast in lanes, so that the law's instructions are
there once. The numbers are the same to the bit.
"""

# mypy: disable-error-code="attr-defined,import-untyped,no-untyped-call,untyped-decorator"
# The compiler's own modules are untyped.

from typing import Any, NamedTuple

from llvmlite import ir
from numba import NumbaError, types
from numba.core import cgutils
from numba.extending import lower_builtin

from layflat.jit.inlining import LAWS_INLINED
from layflat.jit.internals import register_typing
from layflat.jit.lanes.typing import INDEX_TYPE, LanesType, abreast_type, register_lanes, tuple_like
from layflat.lanes import abreast, each


class _Call(NamedTuple):
    """Call of a law: its signature, the number of items, and whether it gets all of them at once."""

    signature: Any
    number: int
    together: bool


def _is_plain_tuple(kind: Any) -> bool:
    return isinstance(kind, types.BaseTuple) and not isinstance(kind, types.BaseNamedTuple)


def _has_single_numbers(kind: Any) -> bool:
    """Return whether all leaves of a nested tuple are single numbers."""
    if isinstance(kind, types.BaseTuple):
        return all(_has_single_numbers(item) for item in kind.types)
    return bool(kind == types.float64)


def _each_call(context: Any, law: Any, args: Any) -> _Call:
    """Return the call of a law for the items of plain tuples, whose first ones represent all, and other arguments."""
    tuples = [arg for arg in args if _is_plain_tuple(arg)]
    count = len(tuples[0])
    alike = all(isinstance(arg, types.UniTuple) and _has_single_numbers(arg) for arg in tuples)
    if alike and count > 1 and not LAWS_INLINED.get():
        kinds = [
            abreast_type(arg.dtype, count) if _is_plain_tuple(arg) else _broadcast_type(arg, count) for arg in args
        ]
        try:
            return _Call(law.get_call_type(context, tuple(kinds), {}), count, True)
        except NumbaError:  # a law from outside need not take lanes
            pass
    firsts = tuple(arg.types[0] if _is_plain_tuple(arg) else arg for arg in args)
    return _Call(law.get_call_type(context, firsts, {}), count, False)


def _broadcast_type(kind: Any, count: int) -> Any:
    """Return a type whose single numbers are lanes beside `count` items that lie abreast."""
    if isinstance(kind, types.BaseTuple):
        return tuple_like(kind, [_broadcast_type(item, count) for item in kind.types])
    return LanesType(kind, register_lanes(count)) if kind == types.float64 else kind


def _broadcast(context: Any, builder: Any, kind: Any, lanes: Any, value: Any) -> Any:
    """Emit a value of `_broadcast_type`."""
    if isinstance(kind, types.BaseTuple):
        items = zip(kind.types, lanes.types, cgutils.unpack_tuple(builder, value), strict=True)
        return context.make_tuple(builder, lanes, [_broadcast(context, builder, *item) for item in items])
    return value if kind == lanes else context.cast(builder, value, kind, lanes)


def _item_type(kind: Any) -> Any:
    """Return the type of an item of lanes, leaf by leaf."""
    if isinstance(kind, types.BaseTuple):
        return tuple_like(kind, [_item_type(leaf) for leaf in kind.types])
    return kind.leaf if isinstance(kind, LanesType) else kind


def _item(context: Any, builder: Any, kind: Any, value: Any, i: int) -> Any:
    """Emit item number `i` of lanes, leaf by leaf; what is no lanes is the same in all items."""
    if isinstance(kind, types.BaseTuple):
        leaves = zip(kind.types, cgutils.unpack_tuple(builder, value), strict=True)
        items = [_item(context, builder, leaf, inner, i) for leaf, inner in leaves]
        return context.make_tuple(builder, _item_type(kind), items)
    return builder.extract_element(value, ir.Constant(INDEX_TYPE, i)) if isinstance(kind, LanesType) else value


def _each_type(context: Any, law: Any, *args: Any) -> Any:
    """Return the type of `each`: a tuple of the law's results, or for a law with several results a tuple of each."""
    call = _each_call(context, law, args)
    result = _item_type(call.signature.return_type) if call.together else call.signature.return_type
    if _is_plain_tuple(result):
        return types.Tuple([types.UniTuple(item, call.number) for item in result.types])
    return types.UniTuple(result, call.number)


register_typing([each], _each_type, in_context=True)


@lower_builtin(each, types.Any, types.VarArg(types.Any))
def _each(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Emit `each`: calls of a law with the items of all tuples; other arguments are the same in all."""
    law, *others = sig.args
    call = _each_call(context.typing_context, law, others)
    run = context.get_function(law, call.signature)
    context.add_linking_libs(getattr(run, "libs", ()))
    kind, values = call.signature.return_type, list(zip(others, args[1:], strict=True))
    if call.together:
        passed = [
            context.get_function(abreast, lanes(own))(builder, [value])
            if _is_plain_tuple(own)
            else _broadcast(context, builder, own, lanes, value)
            for lanes, (own, value) in zip(call.signature.args, values, strict=True)
        ]
        result = run(builder, passed)
        results = [_item(context, builder, kind, result, i) for i in range(call.number)]
    else:
        columns = [cgutils.unpack_tuple(builder, value) if _is_plain_tuple(own) else value for own, value in values]
        rows = [[one[i] if isinstance(one, list) else one for one in columns] for i in range(call.number)]
        results = [run(builder, row) for row in rows]
    if _is_plain_tuple(kind):
        parts = zip(*(cgutils.unpack_tuple(builder, value) for value in results), strict=True)
        tuples = [context.make_tuple(builder, kind, part) for kind, part in zip(sig.return_type, parts, strict=True)]
        return context.make_tuple(builder, sig.return_type, tuples)
    return context.make_tuple(builder, sig.return_type, results)
