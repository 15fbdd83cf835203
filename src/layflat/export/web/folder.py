"""Folder of a machine for browsers and Node.js, as npm takes it."""

import json
import re
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

from layflat import __version__
from layflat.export.web.module import WebMachine, check_precision, web_module
from layflat.export.web.page import has_page, simulator_page
from layflat.export.web.typescript import type_declarations
from layflat.files import whole_file, write_text
from layflat.machine import Machine

PACKAGE_SCRIPTS = ("index.js", "runtime.js", "structs.js")
PAGE_NAME = "simulator.html"


def write_folder(machine: Machine, folder: Path, *, target: str, precision: str) -> Iterator[Path]:
    """Write the module of a machine's plant and control laws, the package around it, and a page that runs it.

    Args:
        machine: the machine.
        folder: the folder.
        target: "wasm" or "wasm-plain", without SIMD.
        precision: "double".

    Yields:
        The files.

    Raises:
        InputError: the precision is another.
        KindError: the control law is plain Python.
    """
    check_precision(precision)
    web = WebMachine(machine)
    module = web_module(web, target)
    name = web.machine.name
    with whole_file(folder / f"{name}.wasm") as path:
        path.write_bytes(module)
    yield folder / f"{name}.wasm"
    texts = {script: package_text(script) for script in PACKAGE_SCRIPTS}
    texts |= {
        "machine.js": f"export const description = {json.dumps(web.description())};\n",
        "index.d.ts": type_declarations(web),
        "package.json": json.dumps(_package(name), indent=2) + "\n",
        "README.md": _readme(web, len(module), target),
    }
    if has_page(machine):
        texts[PAGE_NAME] = simulator_page([web], [module], title=f"{name}: simulator")
    for file, text in texts.items():
        yield write_text(folder / file, text)


def package_text(name: str) -> str:
    """Return the text of a file that packages of all machines have."""
    return files(__package__).joinpath(f"package/{name}").read_text(encoding="utf-8")


def package_name(name: str) -> str:
    """Return npm's name of a machine's package, a part of an address."""
    return f"layflat-{re.sub('[^a-z0-9._-]+', '-', name.lower()).strip('-')}"


def _package(name: str) -> dict[str, Any]:
    return {
        "name": package_name(name),
        "version": __version__,
        "description": f"Plant and control laws of {name}, exported by layflat",
        "type": "module",
        "exports": {".": {"types": "./index.d.ts", "default": "./index.js"}, f"./{name}.wasm": f"./{name}.wasm"},
        "types": "./index.d.ts",
        "files": ["*.js", "*.d.ts", "*.wasm"],
        "private": True,
    }


def _readme(web: WebMachine, size: int, target: str) -> str:
    text = package_text("README.md")
    page = f"\n`{PAGE_NAME}` shows the machine at work; it needs no server and no other file.\n"
    texts = {
        "@NAME@": web.machine.name,
        "@TITLE@": web.machine.title,
        "@LAWS@": " and ".join(f'`"{name}"`' for name in web.laws),
        "@SIZE@": f"{size / 1000:.0f} kB",
        "@ENGINES@": "WebAssembly" if target == "wasm-plain" else "WebAssembly with SIMD (browsers since 2023)",
        "@CYCLE@": f"{1000 * web.machine.cycle:g} ms",
        "@PAGE@": page if has_page(web.machine) else "",
    }
    for mark, value in texts.items():
        text = text.replace(mark, value)
    return text
