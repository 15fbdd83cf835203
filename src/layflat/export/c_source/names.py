"""Names in C: none that C keeps for itself, none twice in a function."""

from collections.abc import Iterator
from contextlib import contextmanager

from layflat.export.layout import c_name

C_LIBRARY = frozenset(
    [
        "abort", "abs", "acos", "acosh", "alloca", "asin", "asinh", "assert", "atan", "atan2", "atanh", "atof", "bcmp",
        "calloc", "cbrt", "ceil", "clog", "copysign", "cos", "cosh", "cpow", "csqrt", "div", "drem", "erf", "erfc",
        "exit", "exp", "exp2", "expm1", "fabs", "fdim", "floor", "fma", "fmax", "fmin", "fmod", "free", "frexp",
        "gamma", "hypot", "ilogb", "index", "isfinite", "isinf", "isnan", "isnormal", "j0", "j1", "jn", "labs",
        "ldexp", "lgamma", "log", "log10", "log1p", "log2", "logb", "lrint", "lround", "main", "malloc", "memcpy",
        "memmove", "memset", "modf", "nan", "nearbyint", "pow", "printf", "puts", "remainder", "remquo", "rindex",
        "rint", "round", "scalb", "signbit", "significand", "sin", "sincos", "sinh", "sqrt", "strlen", "tan", "tanh",
        "tgamma", "trunc", "y0", "y1", "yn", "INFINITY", "NAN", "min_real", "max_real", "floor_divide", "floor_modulo",
        "min_int", "max_int",
    ]
)  # fmt: skip
"""Names of C's library and of compilers' own functions, and those that the program defines for itself."""

COUNTER_NAMES = ("i", "j", "k", "m", "n")


def usable_name(name: str) -> str:
    """Return a name as one that C and its library leave free."""
    plain = c_name(name.strip("_") or "unnamed")
    return f"{plain}_" if plain in C_LIBRARY else plain


class Names:
    """Names of the variables of a function."""

    def __init__(self) -> None:
        self.taken = set[str]()

    def fresh(self, name: str) -> str:
        """Return a name that is not taken yet: this one, or with a number behind it."""
        plain, number = usable_name(name), 1
        found = plain
        while found in self.taken:
            number += 1
            found = f"{plain}_{number}"
        self.taken.add(found)
        return found

    @contextmanager
    def counter(self, name: str = "") -> Iterator[str]:
        """Yield the name of a loop's counter, which is free again after the loop."""
        free = [one for one in ((usable_name(name),) if name else COUNTER_NAMES) if one not in self.taken]
        counter = free[0] if free else self.fresh(name or "i")
        self.taken.add(counter)
        yield counter
        self.taken.discard(counter)
