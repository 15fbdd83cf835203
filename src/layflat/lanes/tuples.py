"""Tuples for the compiler: made of slots or arrays (`gather`), and gone through item by item with a law (`each`)."""

# mypy: disable-error-code="attr-defined,import-untyped,no-untyped-call,untyped-decorator"
# The compiler's own modules are untyped.

from __future__ import annotations

from typing import Any

from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.np.arrayobj import make_array

from layflat.lanes.interpreted import each, gather
from layflat.lanes.slotting import SlotsType


@infer_global(gather)
class _Gather(AbstractTemplate):
    key = gather

    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002  (the compiler's own interface)
        like, items = args
        item = items.item if isinstance(items, SlotsType) else items.dtype
        return signature(types.UniTuple(item, len(like)), like, items)


@lower_builtin(gather, types.BaseTuple, SlotsType)
def _gather_slots(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    found = [builder.load(cgutils.gep_inbounds(builder, args[1], 0, i)) for i in range(len(sig.return_type))]
    return context.make_tuple(builder, sig.return_type, found)


@lower_builtin(gather, types.BaseTuple, types.Array)
def _gather_array(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    array = make_array(sig.args[1])(context, builder, args[1])
    places = [[context.get_constant(types.intp, i)] for i in range(len(sig.return_type))]
    found = [builder.load(cgutils.get_item_pointer(context, builder, sig.args[1], array, place)) for place in places]
    return context.make_tuple(builder, sig.return_type, found)


def _columns(law: Any, tuples: Any, context: Any) -> Any:
    """Signature of a law for the first items of tuples; the types of all items of a tuple are one."""
    return law.get_call_type(context, tuple(column.types[0] for column in tuples), {})


@infer_global(each)
class _Each(AbstractTemplate):
    key = each

    def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        law, *tuples = args
        found, count = _columns(law, tuples, self.context).return_type, len(tuples[0])
        if isinstance(found, types.BaseTuple) and not isinstance(found, types.BaseNamedTuple):
            several = types.Tuple([types.UniTuple(item, count) for item in found.types])
            return signature(several, *args)
        return signature(types.UniTuple(found, count), *args)


@lower_builtin(each, types.Any, types.VarArg(types.Any))
def _each(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    law, *tuples = sig.args
    called = _columns(law, tuples, context.typing_context)
    run = context.get_function(law, called)
    context.add_linking_libs(getattr(run, "libs", ()))
    columns = [cgutils.unpack_tuple(builder, value) for value in args[1:]]
    found = [run(builder, items) for items in zip(*columns, strict=True)]
    if isinstance(called.return_type, types.BaseTuple) and not isinstance(called.return_type, types.BaseNamedTuple):
        parts = zip(*(cgutils.unpack_tuple(builder, value) for value in found), strict=True)
        made = [
            context.make_tuple(builder, kind, list(part)) for kind, part in zip(sig.return_type, parts, strict=True)
        ]
        return context.make_tuple(builder, sig.return_type, made)
    return context.make_tuple(builder, sig.return_type, found)
