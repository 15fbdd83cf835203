"""`layflat rig serve` in a process of its own, as a test tells and asks it."""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path

LAYFLAT = [sys.executable, "-c", "from layflat.cli import main; main()"]


class ServedRig:
    """A virtual rig in a process of its own."""

    def __init__(self, *words: str, cwd: Path) -> None:
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(
            [*LAYFLAT, "rig", "serve", *words], stdin=pipe, stdout=pipe, stderr=pipe, text=True, cwd=cwd
        )
        told = self.line()
        assert " at " in told, self.process.communicate()
        self.address = told.split(" at ")[1]

    def line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()

    def send(self, text: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(text + "\n")
        self.process.stdin.flush()

    def ask(self, text: str) -> str:
        self.send(text)
        return self.line()

    def vented(self) -> bool:
        """Whether no hose holds more than a tenth of a bar, in time."""
        until = time.monotonic() + 20.0
        while time.monotonic() < until:
            hoses = re.findall(r"hoses ([\d.]+) bar and ([\d.]+) bar", self.ask("state"))
            assert len(hoses) == 2
            if all(float(hose) < 0.1 for joint in hoses for hose in joint):
                return True
            time.sleep(0.1)
        return False

    def end(self, number: int = signal.SIGINT) -> int:
        self.process.send_signal(number)
        status = self.process.wait(30.0)
        self.process.communicate()
        return status
