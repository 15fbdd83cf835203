import subprocess
import sys

import pytest

from layflat import memory
from layflat.errors import InputError
from layflat.memory import GIB, check_memory, free_memory


def test_some_memory_is_free() -> None:
    assert 0.05 * GIB < free_memory() < 1e5 * GIB


def test_what_does_not_fit_is_refused_with_the_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "free_memory", lambda: 2.0 * GIB)
    check_memory(1.7 * GIB, "a run", "duration", str)
    with pytest.raises(InputError) as caught:
        check_memory(18.0 * GIB, "a run", "duration", lambda part: f"give {part:g} of it")
    assert str(caught.value) == "duration: a run needs about 18 GiB of memory, and 2 GiB are free; give 0.1 of it"


@pytest.mark.skipif(sys.platform != "linux", reason="address space is limited there")
def test_a_limit_on_the_process_counts() -> None:
    script = (
        "import resource; resource.setrlimit(resource.RLIMIT_AS, (2**31, 2**31));"
        "from layflat.memory import free_memory; print(free_memory())"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert 0.0 < float(done.stdout) < 2.0**31
