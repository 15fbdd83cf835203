from __future__ import annotations

import sys

import pytest

from layflat import load
from layflat.errors import InputError
from layflat.rig.driver import DriverError
from layflat.rig.drivers import create_driver

ARM = load("paper-arm")


@pytest.mark.parametrize(
    ("address", "endpoint"),
    [
        ("modbus://127.0.0.1:5020", "modbus://127.0.0.1:5020"),
        ("modbus://rig.local", "modbus://rig.local:502"),
        ("modbus://127.0.0.1:5020/", "modbus://127.0.0.1:5020"),
        ("serial:///dev/null", "serial:///dev/null"),
    ],
)
def test_addresses(address: str, endpoint: str) -> None:
    assert create_driver(address, ARM).endpoint == endpoint  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("address", "what"),
    [
        ("modbus://127.0.0.1:99999", "has no valid port"),
        ("modbus://127.0.0.1:port", "has no valid port"),
        ("modbus://", "names no station"),
        ("modbus://host:502/unit/3", "names no station"),
        ("serial://ttyACM0", "names no device"),
        ("serial://", "names no device"),
        ("serial:///", "names no device"),
        ("/dev/ttyACM0", "is not a driver's address"),
        ("can://0", "is not a driver's address"),
        ("", "is not a driver's address"),
    ],
)
def test_what_is_no_address(address: str, what: str) -> None:
    with pytest.raises(DriverError, match=what) as error:
        create_driver(address, ARM)
    assert "give" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("address", "package"), [("modbus://h", "pymodbus"), ("serial:///dev/x", "pyserial")])
def test_what_is_not_installed_is_named(address: str, package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    imported = package.removeprefix("py") if package == "pyserial" else package
    for name in [
        name for name in sys.modules if name.startswith(("layflat.rig.drivers.modbus", "layflat.rig.drivers.serial"))
    ]:
        monkeypatch.delitem(sys.modules, name)
    for name in [name for name in sys.modules if name.split(".")[0] == imported]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, imported, None)
    with pytest.raises(InputError, match=rf"needs {package}.*pip install 'layflat\[rig\]'"):
        create_driver(address, ARM)
