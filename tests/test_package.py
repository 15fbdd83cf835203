import ast
import subprocess
import sys
from pathlib import Path

import grimp
import numpy as np
from scipy.sparse.csgraph import connected_components

import layflat

UNREAD = {
    "jit/libraries.py: _finalized",  # of a class of the compiler, which reads it
    "jit/libraries.py: _shared_module",  # likewise
    "jit/portable.py: _finalized",  # likewise
    "rig/safety/faults.py: _value_",  # of enumerations, read by Python
    "sim/plant.py: _like",
}
"""Private attributes that no line of their module reads."""


def test_a_rollout_waits_for_nothing_that_it_does_not_need() -> None:
    code = "import sys, layflat.sim; print(sorted({'scipy.interpolate', 'numba', 'xarray'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Also lazily or for types alone; of rooms a contract says so, which does not see a package's own `__init__`."""
    graph = grimp.build_graph("layflat", exclude_type_checking_imports=False, cache_dir=None)
    names = sorted(graph.modules)
    imports = [[name in graph.find_modules_directly_imported_by(importer) for name in names] for importer in names]
    _, circle = connected_components(np.array(imports), connection="strong")
    together = [[name for name, of in zip(names, circle, strict=True) if of == one] for one in set(circle)]
    assert [names for names in together if len(names) > 1] == []


def test_import_contracts_see_every_module() -> None:
    """They see none of a folder without an `__init__`."""
    folders = {path.parent for path in Path(layflat.__file__).parent.rglob("*.py")}
    assert [folder for folder in folders if not (folder / "__init__.py").exists()] == []


def test_no_submodule_takes_the_place_of_a_name_that_its_package_offers() -> None:
    """A module that is first imported later on becomes an attribute of its package, over a function of that name."""
    source, hidden = Path(layflat.__file__).parents[1], []
    for init in source.rglob("__init__.py"):
        package = ".".join(init.parent.relative_to(source).parts)
        modules = {
            path.stem for path in init.parent.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()
        }
        for node in ast.walk(ast.parse(init.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                offered = {alias.asname or alias.name for alias in node.names}
                hidden += [
                    f"{package}.{name}"
                    for name in offered & modules
                    if node.module not in {package, f"{package}.{name}"}
                ]
    assert hidden == []


def test_every_private_attribute_that_an_object_sets_is_read() -> None:
    folder, unread = Path(layflat.__file__).parent, []
    for path in sorted(folder.rglob("*.py")):
        nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        attributes = [node for node in nodes if isinstance(node, ast.Attribute) and node.attr.startswith("_")]
        read = {node.attr for node in attributes if not isinstance(node.ctx, ast.Store)}
        own = {node.attr for node in attributes if isinstance(node.value, ast.Name) and node.value.id == "self"}
        unread += [f"{path.relative_to(folder).as_posix()}: {name}" for name in sorted(own - read)]
    assert sorted(set(unread) - UNREAD) == []
