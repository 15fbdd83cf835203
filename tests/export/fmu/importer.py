"""A small importer of FMUs over ctypes, of FMI 2.0 and 3.0 alike; other importers are in test_importers.py."""

import ctypes
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

OK, ERROR = 0, 3

LOGGER_2 = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, *[ctypes.c_char_p] * 3])
LOGGER_3 = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)


class Callbacks(ctypes.Structure):
    """Callback functions of FMI 2.0."""

    _fields_ = [(name, ctypes.c_void_p) for name in ("logger", "allocate", "free", "finished", "environment")]


class Fmu:
    """An unpacked FMU: its variables and its library."""

    def __init__(self, path: Path, folder: Path, system: Sequence[str], mode: int = ctypes.DEFAULT_MODE) -> None:
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        root = ET.parse(folder / "modelDescription.xml").getroot()
        self.third = root.attrib["fmiVersion"] == "3.0"
        self.token = root.attrib["instantiationToken" if self.third else "guid"]
        self.identifier = root.find("CoSimulation").attrib["modelIdentifier"]  # type: ignore[union-attr]
        variables = root.find("ModelVariables")
        assert variables is not None
        self.references = {one.attrib["name"]: int(one.attrib["valueReference"]) for one in variables}
        (self.file,) = (folder / "binaries" / system[self.third]).iterdir()
        self.library = ctypes.CDLL(str(self.file), mode)


class Instance:
    """An instance of an FMU; `messages` are what it reports."""

    def __init__(self, fmu: Fmu, name: str = "one", token: str | None = None, **options: Any) -> None:
        self.fmu, self.third, self.messages = fmu, fmu.third, list[str]()
        self._library, token = fmu.library, fmu.token if token is None else token
        made = (self._make_third if self.third else self._make_second)(name.encode(), token.encode(), options)
        self.pointer = ctypes.c_void_p(made) if made else None

    def _make_second(self, name: bytes, token: bytes, options: dict[str, Any]) -> Any:
        self._logger: Any = LOGGER_2(lambda _e, _n, _s, _c, form, text: self._log(form, text))
        self._callbacks = Callbacks(ctypes.cast(self._logger, ctypes.c_void_p).value)
        make = self._library.fmi2Instantiate
        make.restype = ctypes.c_void_p
        callbacks = ctypes.byref(self._callbacks) if options.get("logger", True) else None
        return make(name, options.get("kind", 1), token, None, callbacks, 0, 0)

    def _make_third(self, name: bytes, token: bytes, options: dict[str, Any]) -> Any:
        self._logger = LOGGER_3(lambda _e, _s, _c, text: self._log(b"%s", text))
        make = self._library.fmi3InstantiateModelExchange if not options.get("kind", 1) else None
        passed: list[Any] = [name, token, None, False, False]
        if make is None:
            make, passed = self._library.fmi3InstantiateCoSimulation, [*passed, False, False, None, ctypes.c_size_t(0)]
        make.restype = ctypes.c_void_p
        return make(*passed, None, self._logger if options.get("logger", True) else None, None)

    def _log(self, form: bytes, text: bytes) -> None:
        assert form == b"%s"
        self.messages.append(text.decode())

    def call(self, name: str, *args: Any) -> int:
        """Call a function of either version by its name without prefix; return its status."""
        function = getattr(self._library, f"fmi{3 if self.third else 2}{name}")
        return int(function(self.pointer, *args))

    def begin(self, start: float = 0.0) -> "Instance":
        """Bring it to its steps."""
        assert self.initialize(start) == OK, self.messages
        assert self.call("ExitInitializationMode") == OK, self.messages
        return self

    def initialize(self, start: float = 0.0) -> int:
        """Enter initialization."""
        time, no = ctypes.c_double(start), ctypes.c_double(0.0)
        if self.third:
            return self.call("EnterInitializationMode", False, no, time, False, no)
        assert self.call("SetupExperiment", 0, no, time, 0, no) == OK
        return self.call("EnterInitializationMode")

    def step(self, time: float, size: float) -> int:
        """Do a step."""
        passed = [ctypes.c_double(time), ctypes.c_double(size), ctypes.c_int(1)]
        if not self.third:
            return self.call("DoStep", *passed)
        flags, reached = [ctypes.c_bool() for _ in range(3)], ctypes.c_double()
        return self.call("DoStep", *passed, *map(ctypes.byref, flags), ctypes.byref(reached))

    def set(self, values: dict[str, float]) -> int:
        """Set variables of real numbers."""
        numbers = (ctypes.c_double * len(values))(*values.values())
        return self._pass("SetFloat64" if self.third else "SetReal", list(values), numbers)

    def set_noise(self, seed: int, noisy: bool) -> None:
        """Set the parameters of the sensors' noise."""
        assert self._pass("SetInt32" if self.third else "SetInteger", ["seed"], (ctypes.c_int * 1)(seed)) == OK
        kind = ctypes.c_bool if self.third else ctypes.c_int
        assert self._pass("SetBoolean", ["noise"], (kind * 1)(noisy)) == OK

    def get(self, names: list[str]) -> list[float]:
        """Return variables of real numbers."""
        numbers = (ctypes.c_double * len(names))()
        assert self._pass("GetFloat64" if self.third else "GetReal", names, numbers) == OK, self.messages
        return list(numbers)

    def _pass(self, function: str, names: list[str], numbers: Any) -> int:
        references = (ctypes.c_uint * len(names))(*[self.fmu.references[name] for name in names])
        count = ctypes.c_size_t(len(names))
        return self.call(function, references, count, numbers, *([count] if self.third else []))

    def keep(self) -> ctypes.c_void_p:
        """Return a state."""
        state = ctypes.c_void_p()
        assert self.call("GetFMUState" if self.third else "GetFMUstate", ctypes.byref(state)) == OK
        return state

    def restore(self, state: ctypes.c_void_p) -> int:
        """Restore a state."""
        return self.call("SetFMUState" if self.third else "SetFMUstate", state)

    def release(self, state: ctypes.c_void_p) -> None:
        """Free a state."""
        assert self.call("FreeFMUState" if self.third else "FreeFMUstate", ctypes.byref(state)) == OK
        assert state.value is None

    def serialize(self, state: ctypes.c_void_p) -> bytes:
        """Return a state as bytes."""
        size = ctypes.c_size_t()
        name = "FMUState" if self.third else "FMUstate"
        assert self.call(f"Serialized{name}Size", state, ctypes.byref(size)) == OK
        buffer = ctypes.create_string_buffer(size.value)
        assert self.call(f"Serialize{name}", state, buffer, size) == OK
        return buffer.raw

    def deserialize(self, content: bytes) -> tuple[int, ctypes.c_void_p]:
        """Return the status, and the state of bytes."""
        state, name = ctypes.c_void_p(), "DeserializeFMUState" if self.third else "DeSerializeFMUstate"
        return self.call(name, content, ctypes.c_size_t(len(content)), ctypes.byref(state)), state

    def free(self) -> None:
        """Free it."""
        function = self._library.fmi3FreeInstance if self.third else self._library.fmi2FreeInstance
        function.restype = None
        function(self.pointer)
        self.pointer = None
