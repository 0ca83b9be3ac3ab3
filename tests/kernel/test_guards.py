"""The kernel's own rules between operations, which Python cannot break: a program in C++ tries them."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.conftest import ROOT


@pytest.mark.skipif(shutil.which("c++") is None, reason="needs a C++ compiler")
def test_operations_keep_what_their_callers_hold(tmp_path: Path) -> None:
    needed = ("store", "unions", "counting", "saturation")
    sources = [ROOT / f"kernel/src/diagrams/{name}.cpp" for name in needed]
    program, whole = tmp_path / "guards", tmp_path / "whole.cpp"
    # As one source: what all of them include is read once.
    texts = [f'#include "{source}"\n' for source in (*sources, Path(__file__).with_name("guards.cpp"))]
    whole.write_text("".join(texts))
    flags = ["-std=c++20", "-O1", "-D_GLIBCXX_ASSERTIONS", f"-I{ROOT / 'kernel/src'}"]
    subprocess.run(["c++", *flags, whole, "-o", program], check=True)
    run = subprocess.run([program], check=True, capture_output=True, text=True)
    assert run.stdout == "1 1 1\n"
