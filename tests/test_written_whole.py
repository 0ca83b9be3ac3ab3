"""Files and folders are written as a whole or not at all, whatever ends the process."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

import mcpn.files as mcpn_files
from mcpn.errors import InputError
from mcpn.files import write_atomically, write_folder
from tests.conftest import interruptible
from tests.drivers.test_records import LOOP


def test_what_a_killed_process_has_left_is_swept(tmp_path: Path) -> None:
    program = (
        "import os, signal, sys; from pathlib import Path; import mcpn.files as f\n"
        "f.os.replace = lambda *_: os.kill(os.getpid(), signal.SIGKILL)\n"
        "f.write_atomically(Path('one.txt'), 'x')\n"
    )
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, check=False)
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(".one.txt.")
    write_atomically(tmp_path / "one.txt", "y", durable=True)
    assert [path.name for path in tmp_path.iterdir()] == ["one.txt"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1])
@pytest.mark.parametrize("when", ["before", "after"])
def test_a_signal_at_the_renaming_leaves_nothing_beside(number: int, when: str, tmp_path: Path) -> None:
    program = (
        "import os, sys, mcpn.files as f\n"
        "from mcpn.cli import main\n"
        "replace = os.replace\n"
        "def renamed(*of):\n"
        f"    if {when!r} == 'before': os.kill(os.getpid(), {int(number)})\n"
        "    replace(*of)\n"
        f"    os.kill(os.getpid(), {int(number)})\n"
        "f.os.replace = renamed\n"
        "sys.argv = ['mcpn', 'convert', 'mission.xml', 'net.pnml']\n"
        "main()\n"
    )
    (tmp_path / "mission.xml").write_text(LOOP.format(requirement=""))
    ran = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, preexec_fn=interruptible, check=False)
    assert ran.returncode == 128 + number
    assert {path.name for path in tmp_path.iterdir()} - {"net.pnml"} == {"mission.xml"}
    assert (tmp_path / "net.pnml").exists() == (when == "after")


def test_a_folder_of_files_is_replaced_at_once(tmp_path: Path) -> None:
    """Killed at any call of the system that writes, all files are the old ones, or all the new ones."""
    (tmp_path / "probe").mkdir()
    (tmp_path / "other").mkdir()
    if not mcpn_files._exchanged(tmp_path / "probe", tmp_path / "other"):
        pytest.skip("this file system cannot exchange two folders")
    folder = tmp_path / "build"
    old, new = ({name: f"{name} {age}" for name in "abc"} for age in ("old", "new"))
    program = (
        "import os, signal, sys; from pathlib import Path; import mcpn.files as f\n"
        "left = int(sys.argv[1])\n"
        "def counted(call):\n"
        "    def called(*of, **how):\n"
        "        global left\n"
        "        left -= 1\n"
        "        if left == 0: os.kill(os.getpid(), signal.SIGKILL)\n"
        "        return call(*of, **how)\n"
        "    return called\n"
        "for name in ('_write', '_exchanged', '_remove', '_place'):\n"
        "    setattr(f, name, counted(getattr(f, name)))\n"
        f"f.write_folder(Path('build'), {new!r})\n"
    )
    seen = []
    for at in range(1, 20):
        write_folder(folder, old)
        ran = subprocess.run([sys.executable, "-c", program, str(at)], cwd=tmp_path, check=False)
        found = {path.name: path.read_text() for path in folder.iterdir()}
        assert found in (old, new)
        seen.append(found == new)
        if ran.returncode == 0:
            break
    assert seen == sorted(seen)
    assert (seen.count(False) >= 4, seen.count(True)) == (True, 2)  # three files, the exchange; removed, done
    assert {path.name for path in tmp_path.iterdir()} == {"build", "probe", "other"}  # the rest was swept


def test_a_folder_that_somebody_stands_in_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor is one replaced that is a link, or has more in it."""
    monkeypatch.chdir(tmp_path)
    write_folder(tmp_path, {"a": "1"})
    number = tmp_path.stat().st_ino
    for folder in (tmp_path, Path(), Path("../") / tmp_path.name):
        write_folder(folder, {"a": "2"})
        assert (tmp_path.stat().st_ino, (tmp_path / "a").read_text()) == (number, "2")
    (tmp_path / "link").symlink_to(tmp_path / "far")
    (tmp_path / "far").mkdir()
    write_folder(tmp_path / "link", {"a": "3"})
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "far" / "a").read_text() == "3"


@pytest.mark.parametrize("there", [False, True])
def test_a_folder_is_written_as_a_whole_or_not_at_all(there: bool, tmp_path: Path) -> None:
    folder = tmp_path / "new" / "build"
    if there:
        folder.mkdir(parents=True)
        (folder / "a").write_text("before")
        (folder / "other").write_text("stays")
    with pytest.raises(Exception, match="cannot be"):
        write_folder(folder, {"a": "1", "b\0": "2"})
    assert {path.name for path in folder.iterdir()} == {"a", "other"} if there else not folder.parent.exists()
    assert not there or (folder / "a").read_text() == "before"
    write_folder(folder, {"a": "1", "b": "2"})
    assert {path.name for path in folder.iterdir()} == {"a", "b"} | ({"other"} if there else set())
    assert (folder / "a").read_text() == "1"


def test_a_long_text_is_written_part_by_part_and_half_a_character_in_it_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its bytes are not in memory beside it; what cannot be encoded is found behind what was written."""
    monkeypatch.setattr(mcpn_files, "AT_A_TIME", 4)
    text = "añ𝄞" * 9
    write_atomically(tmp_path / "one", text)
    write_folder(tmp_path / "folder", {"two": text, "three": text.encode()})
    read = [path.read_text(encoding="utf-8") for path in sorted(tmp_path.rglob("[ot]*"))]
    assert read == [text] * 3
    with pytest.raises(InputError, match="cannot be written"):
        write_atomically(tmp_path / "one", "new text \ud800")
    with pytest.raises(InputError, match="cannot be written"):
        write_folder(tmp_path / "folder", {"two": "new text \ud800"})
    with pytest.raises(InputError, match="cannot be written"):
        write_folder(tmp_path / "fresh", {"two": "new text \ud800"})
    assert {path.name for path in tmp_path.rglob("*")} == {"one", "folder", "two", "three"}
    assert (tmp_path / "one").read_text(encoding="utf-8") == text
