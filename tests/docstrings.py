"""Examples in docstrings: run as they stand, and compared with what they show as the output on pages is."""

import doctest
from io import StringIO
from typing import Any

from tests.docs.comparing import find_difference


class TolerantChecker(doctest.OutputChecker):
    """Checker to which numbers that are nearly the same are the same."""

    def check_output(self, want: str, got: str, optionflags: int) -> bool:
        """Return whether the output is as shown."""
        return super().check_output(want, got, optionflags) or find_difference(want, got) is None


def example_of(public: Any) -> doctest.DocTest:
    """Return the example in the docstring of a module, a class or a function; it may have no lines."""
    return doctest.DocTestParser().get_doctest(public.__doc__ or "", {}, public.__name__, None, 0)


def run_example(example: doctest.DocTest) -> str:
    """Run an example and return what differs from what it shows."""
    told = StringIO()
    doctest.DocTestRunner(TolerantChecker(), verbose=False).run(example, out=told.write)
    return told.getvalue()
