import gc
import sys
import threading
from contextlib import nullcontext
from typing import Any

import pytest
from numba.core import event
from numba.core.errors import TypingError

from layflat.jit import law, libraries
from layflat.jit.compiler import compile_cached
from layflat.registers import interpreted


@pytest.mark.skipif(interpreted(), reason="nothing is compiled")
@pytest.mark.parametrize("fails", [False, True])
def test_garbage_is_collected_and_threads_take_turns_as_usual_after_a_compilation(fails: bool) -> None:
    """Also after one that failed, and where a kernel compiles a law."""
    seen = []

    class Seen(event.Listener):
        def on_start(self, _: Any) -> None:
            seen.append((gc.get_threshold()[0], -sys.getswitchinterval()))

        def on_end(self, _: Any) -> None:
            """Only the beginning counts."""

    @law
    def doubled(x: float) -> float:
        return 2.0 * x

    def twice(x: float) -> Any:
        return doubled(doubled(x)) + ("" if fails else 0.0)

    usual = gc.get_threshold()[0], -sys.getswitchinterval()
    with event.install_listener("numba:compile", Seen()), pytest.raises(TypingError) if fails else nullcontext():
        assert compile_cached(twice, None)(3.0) == 12.0
    assert (gc.get_threshold()[0], -sys.getswitchinterval()) == usual
    assert len(seen) > 1
    assert all(rare > usual[0] and often > usual[1] for rare, often in seen[1:])


@pytest.mark.skipif(interpreted(), reason="nothing is compiled")
def test_laws_are_of_use_after_a_kernel_that_failed() -> None:
    """LLVM may be at work on them when it does."""

    @law
    def doubled(x: float) -> Any:
        return 2.0 * x

    @law
    def quadrupled(x: float) -> Any:
        return doubled(doubled(x))

    def failing(x: float) -> Any:
        return quadrupled(x) + ""

    with pytest.raises(TypingError):
        compile_cached(failing, None)(1.0)
    assert len(quadrupled.dispatcher.overloads) == 1  # type: ignore[attr-defined]
    assert compile_cached(lambda x: quadrupled(quadrupled(x)), None)(1.0) == 16.0


@pytest.mark.skipif(interpreted(), reason="nothing is compiled")
def test_llvm_works_on_laws_in_another_thread_and_its_failures_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    threads = []
    parsed = libraries._parse_module

    def watched(name: str, text: str) -> Any:
        threads.append(threading.get_ident())
        if "broken" in name:
            raise RuntimeError("LLVM can't")
        return parsed(name, text)

    monkeypatch.setattr(libraries, "_parse_module", watched)

    @law
    def halved(x: float) -> Any:
        return 0.5 * x

    @law
    def broken(x: float) -> Any:
        return halved(x)

    @law
    def around(x: float) -> Any:
        return halved(broken(x))

    assert compile_cached(lambda x: 1.0 + halved(x), None)(3.0) == 2.5
    assert len(threads) == 1
    assert threads[0] != threading.get_ident()
    with pytest.raises(RuntimeError, match="LLVM can't"):
        compile_cached(lambda x: 1.0 + around(x), None)(3.0)
