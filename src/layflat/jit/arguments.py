"""Arguments of laws: the form in which a law gets a named tuple.

A law that kernels inline gets the whole tuple as a value. In code that is to be small (see `inlining`) it gets the
address of the tuple's numbers: as values, the hundreds of numbers of a model would be copied at every call.
"""

# mypy: disable-error-code="no-untyped-call"
# The compiler's own modules are untyped.

from collections.abc import Iterator
from typing import Any

from llvmlite import ir
from numba import types

from layflat.jit.forwarding import TUPLE_NAME
from layflat.jit.inlining import LAWS_INLINED
from layflat.jit.internals import ArgPacker

Indices = tuple[int, ...]


class _WholeTuple:
    """Argument model of a named tuple that is not flattened."""

    def __init__(self, model: Any) -> None:
        self.get_argument_type = model.get_value_type

    def as_argument(self, builder: Any, value: Any) -> Any:  # noqa: ARG002
        return value

    from_argument = as_argument


class _TupleInMemory:
    """Argument model of a named tuple whose numbers are passed by their address."""

    def __init__(self, model: Any) -> None:
        self._kind = model.get_value_type()
        self.get_argument_type = self._kind.as_pointer

    def as_argument(self, builder: Any, value: Any) -> Any:
        with builder.goto_entry_block():
            address = builder.alloca(self._kind, name=TUPLE_NAME)
        for indices in _indices(self._kind):
            builder.store(builder.extract_value(value, indices), _address(builder, address, indices))
        return address

    def from_argument(self, builder: Any, address: Any) -> Any:
        address.add_attribute("noalias")  # nobody writes it during the call
        value = ir.Constant(self._kind, ir.Undefined)
        for indices in _indices(self._kind):
            value = builder.insert_value(value, builder.load(_address(builder, address, indices)), indices)
        return value


def _indices(kind: Any) -> Iterator[Indices]:
    """Yield the indices of each number in a type of nested tuples."""
    if isinstance(kind, ir.ArrayType):
        items = [kind.element] * kind.count
    elif isinstance(kind, ir.LiteralStructType):
        items = [*kind.elements]
    else:
        yield ()
        return
    for i, item in enumerate(items):
        yield from ((i, *rest) for rest in _indices(item))


def _address(builder: Any, tuple_address: Any, indices: Indices) -> Any:
    return builder.gep(tuple_address, [ir.Constant(ir.IntType(32), i) for i in (0, *indices)])


class _ArgumentModels:
    """Data models of a law's arguments, by their types."""

    def __init__(self, models: Any) -> None:
        self._models = models

    def lookup(self, kind: Any) -> Any:
        model = self._models.lookup(kind)
        if not isinstance(kind, types.BaseNamedTuple):
            return model
        return _WholeTuple(model) if LAWS_INLINED.get() else _TupleInMemory(model)


def argument_packer(models: Any, kinds: Any) -> Any:
    """Return numba's packer of the arguments of a law.

    Args:
        models: numba's data models.
        kinds: types of the arguments.
    """
    return ArgPacker(_ArgumentModels(models), kinds)
