import shutil
import socket
import subprocess
from pathlib import Path

import pytest

from layflat.errors import InputError
from layflat.pages.server import Endpoint, serve
from tests.programs import skip_without


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A certificate and its key."""
    return certificate(tmp_path_factory.mktemp("tls"))


def certificate(folder: Path) -> tuple[Path, Path]:
    if shutil.which("openssl") is None:
        skip_without("openssl")
    made, key = folder / "certificate.pem", folder / "key.pem"
    kind = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2"]
    name = ["-subj", "/CN=layflat", "-addext", "subjectAltName=IP:127.0.0.1"]
    command = ["openssl", "req", "-x509", *kind, *name, "-keyout", str(key), "-out", str(made)]
    subprocess.run(command, check=True, capture_output=True)
    return made, key


@pytest.mark.parametrize("host", ["127.0.0.1", "127.1.2.3", "::1", "localhost", "LOCALHOST"])
def test_this_computer_alone_needs_no_certificate(host: str) -> None:
    assert Endpoint(host).is_loopback


@pytest.mark.parametrize("host", ["192.168.1.5", "robot.local", "0.0.0.0", "::", "", "127.0.0.1.evil.example"])
def test_others_are_served_under_a_certificate_only(host: str) -> None:
    with pytest.raises(InputError, match="can be reached from other computers; give a certificate and its key") as told:
        Endpoint(host)
    assert told.value.where == "host"
    assert "\n" not in str(told.value)


def test_with_a_certificate_others_are_served(files: tuple[Path, Path]) -> None:
    place = Endpoint("Robot.local", 8443, *files)
    assert place.address(8443) == "https://robot.local:8443"
    assert place.hosts(8443) == {"robot.local:8443"}
    assert place.hosts(443) == {"robot.local:443", "robot.local"}


@pytest.mark.parametrize("host", ["0.0.0.0", "::", ""])
def test_an_address_that_no_browser_can_open_is_refused(host: str, files: tuple[Path, Path]) -> None:
    with pytest.raises(InputError, match="not an address that a browser can open; give the address or name"):
        Endpoint(host, 8443, *files)


def test_certificate_and_key_come_together_and_are_there(files: tuple[Path, Path], tmp_path: Path) -> None:
    certificate, key = files
    with pytest.raises(InputError, match="key: is missing; give both"):
        Endpoint(certificate=certificate)
    with pytest.raises(InputError, match="certificate: is missing; give both"):
        Endpoint(key=key)
    with pytest.raises(InputError, match=r"none\.pem: no such file; give the path of the key"):
        Endpoint(certificate=certificate, key=tmp_path / "none.pem")
    with pytest.raises(InputError, match="no such file; give the path of the certificate"):
        Endpoint(certificate=tmp_path, key=key)


def test_files_of_another_kind_are_refused(files: tuple[Path, Path], tmp_path: Path) -> None:
    certificate, key = files
    (tmp_path / "words.pem").write_text("not a key")
    locked = tmp_path / "locked.pem"
    command = ["openssl", "ec", "-in", str(key), "-aes128", "-passout", "pass:secret", "-out", str(locked)]
    subprocess.run(command, check=True, capture_output=True)
    for pair in ((key, certificate), (certificate, tmp_path / "words.pem"), (certificate, locked)):
        with pytest.raises(InputError, match="can't be used with the key") as told:
            Endpoint("192.168.1.5", 8443, *pair)
        assert "\n" not in str(told.value)


def test_addresses_are_as_browsers_write_them() -> None:
    assert Endpoint("localhost").address(8080) == "http://127.0.0.1:8080"
    assert Endpoint("0:0::1").address(8080) == "http://[::1]:8080"
    assert Endpoint("127.1.2.3").hosts(8080) == {
        f"{name}:8080" for name in ("127.1.2.3", "127.0.0.1", "localhost", "[::1]")
    }


def test_a_place_that_is_not_here_is_refused(files: tuple[Path, Path]) -> None:
    for host in ("192.0.2.1", f"{64 * 'x'}.local"):
        with pytest.raises(InputError, match=rf"host: '{host}' can't be had \(.*\); give an address of this computer"):
            Endpoint(host, 8443, *files).listen()


def test_a_port_in_use_is_told_before_anything_starts() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        told = rf"port: port {port} can't be had \(Address already in use\); give another, or 0 for any that is free"
        with pytest.raises(InputError, match=told):
            serve(lambda: None, Endpoint(port=port), title="none", ready=print, stopped=lambda: True)
    with pytest.raises(InputError, match="port: port 99999 can't be had"):
        Endpoint(port=99999).listen()


def test_only_the_address_that_was_given_listens() -> None:
    with Endpoint(port=0).listen() as listener, socket.socket() as other:
        assert listener.getsockname()[0] == "127.0.0.1"
        assert other.connect_ex(("127.0.0.2", listener.getsockname()[1])) != 0
