"""Programs in C++ that tests compile, by themselves or against BehaviorTree.CPP."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

LIBRARY = "BehaviorTree.CPP"
OPTIONS = ("GROOT_INTERFACE", "SQLITE_LOGGING", "EXAMPLES", "BUILD_TOOLS")
"""What of the library is not built."""


def built_once(folders: pytest.TempPathFactory, name: str, build: Callable[[Path], object]) -> Path:
    """A folder that all processes of one run of the tests share; the first that asks for it fills it.

    Args:
        folders: Of the process.
        name: Of the folder.
        build: Fills it; where that fails, the next that asks tries again.
    """
    own = folders.getbasetemp()
    run = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    with (run / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (run / f"{name}.built").exists():
            shutil.rmtree(run / name, ignore_errors=True)
            (run / name).mkdir()
            build(run / name)
            (run / f"{name}.built").touch()
    return run / name


def cpp_compiler() -> list[str]:
    """The command of a compiler of C++; without one the test is skipped."""
    found = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if found is None:
        pytest.skip("needs a compiler of C++")
    return [found]


def library_of(config: pytest.Config, folders: pytest.TempPathFactory) -> list[str]:
    """The options of a compiler for what uses the library, whose sources ``--btcpp`` names.

    They are built for the run, which takes some minutes, or once for all into the folder that
    ``MCPN_BTCPP_BUILD`` names.
    """
    given = config.getoption("--btcpp")
    if not given:
        pytest.skip("needs the sources of BehaviorTree.CPP: --btcpp")
    sources = Path(given).resolve()
    if not (sources / "CMakeLists.txt").is_file():
        pytest.skip(f"{sources} has no CMakeLists.txt of BehaviorTree.CPP")
    if shutil.which("cmake") is None:
        pytest.skip("needs cmake")
    cpp_compiler()
    beside = os.environ.get("MCPN_BTCPP_BUILD")
    build = Path(beside) if beside else folders.getbasetemp() / "btcpp"
    if not list(build.glob("libbehaviortree_cpp.*")):
        off = [f"-DBTCPP_{option}=OFF" for option in OPTIONS]
        subprocess.run(["cmake", "-S", sources, "-B", build, *off, "-DBUILD_TESTING=OFF"], check=True)
        subprocess.run(["cmake", "--build", build, "-j2"], check=True)
    linked = [f"-L{build}", "-lbehaviortree_cpp", f"-Wl,-rpath,{build}"]
    return ["-I", str(sources / "include"), *linked]


def program_of(source: str, config: pytest.Config, folders: pytest.TempPathFactory) -> Path:
    """A program of ``tests/trees`` that uses the library; skips where that is not given."""
    against = library_of(config, folders)
    written = Path(__file__).with_name("trees") / source
    program = folders.mktemp("program") / written.stem
    subprocess.run([*cpp_compiler(), "-std=c++17", written, "-o", program, *against], check=True)
    return program
