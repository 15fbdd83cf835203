"""Hook of the build of wheels: one for a platform carries prebuilt machine code, and the pure one none.

`LAYFLAT_WHEEL` names the platform, a key of `PLATFORMS`. Without it, the wheel is pure: its kernels are compiled where
it runs.
"""

import os
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PLATFORMS = {
    "x86_64": ("manylinux_2_17_x86_64", ("linux-x86-64-v2", "linux-x86-64-v3", "linux-x86-64-v4")),
    "aarch64": ("manylinux_2_17_aarch64", ("linux-aarch64",)),
}
"""Tag of each platform, and the folders of machine code for it, all of which have to be there."""


class PrebuiltHook(BuildHookInterface[Any]):
    """Hook that adds machine code to the wheel of a platform."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002  (hatchling's own interface)
        """Set the tag of the wheel, and add its machine code.

        Raises:
            ValueError: the platform is unknown, or its machine code was not built.
        """
        platform = os.environ.get("LAYFLAT_WHEEL", "")
        if not platform:
            return
        if platform not in PLATFORMS:
            raise ValueError(f"LAYFLAT_WHEEL: {platform!r} is no platform; give {' or '.join(PLATFORMS)}")
        tag, levels = PLATFORMS[platform]
        folder = Path(self.root, "src", "layflat", "prebuilt")
        for name in (*levels, "sources"):
            if not any((folder / name).glob("*")):
                raise ValueError(f"{folder / name} holds nothing: run `python -m wheels.prebuilt` first")
            build_data["force_include"][str(folder / name)] = f"layflat/prebuilt/{name}"
        build_data["tag"], build_data["pure_python"] = f"py3-none-{tag}", False
