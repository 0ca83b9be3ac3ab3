"""Choosing a format by suffix, pictures, and writing whole or not at all."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.errors import InputError
from mcpn.files import read_bounded, write_atomically
from mcpn.nets.formats import FOREIGN, NET_FORMATS, READABLE, WRITABLE, read_net, save_net
from mcpn.nets.formats.dot import write_dot
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.nets.structure import needs
from mcpn.testing.nets import philosophers
from tests.commands import mcpn
from tests.draws import fewer
from tests.nets.nets import odd_nets, pt_nets


def test_suffixes_in_capitals_are_known(tmp_path: Path) -> None:
    net = PetriNet("n", (), ())
    save_net(net, tmp_path / "N.NET")
    assert read_net(str(tmp_path / "N.NET")) == net


@pytest.mark.parametrize("name", ["n.xml", "n", "n.dot", ".net"])
def test_reading_tells_the_formats_that_it_knows(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=re.escape(f"expected {', '.join(READABLE)}")):
        read_net(tmp_path / name)


def test_only_pnml_with_priorities_warns(tmp_path: Path) -> None:
    for priorities in (False, True):
        for suffix in WRITABLE:
            warning = save_net(PetriNet("n", (), (), priorities), tmp_path / f"n{suffix}")
            assert (warning is not None) == (priorities and suffix == ".pnml")
            assert warning is None or "standard PNML has no priorities" in warning


BOTH_WAYS = [suffix for suffix in READABLE if suffix in WRITABLE]


def effects(net: PetriNet) -> dict[str, tuple[dict[str, int], dict[str, int]]]:
    """By transition what it needs, and what its firing changes, by places' names; 0 is left out."""
    found = {}
    for number, t in enumerate(net.transitions):
        change = Counter[int]()
        change.update(dict(t.produce))
        change.subtract(dict(t.consume))
        sides = (needs(net, number), change)
        named = [{net.places[p].name: n for p, n in side.items() if n} for side in sides]
        found[t.name] = (named[0], named[1])
    return found


@pytest.mark.parametrize("suffix", BOTH_WAYS)
def test_each_format_takes_a_plain_net(suffix: str, tmp_path: Path) -> None:
    net = philosophers(3)
    save_net(net, tmp_path / f"n{suffix}")
    back = read_net(tmp_path / f"n{suffix}")
    assert (effects(back), back.initial) == (effects(net), net.initial)


@given(net=pt_nets())
def test_each_format_keeps_what_a_net_does_or_refuses_it(
    net: PetriNet, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("n")
    for suffix in BOTH_WAYS:
        file = folder / f"n{suffix}"
        try:
            save_net(net, file)
        except InputError:
            continue
        back, written = read_net(file), file.read_bytes()
        assert effects(back) == effects(net)
        assert {p.name: p.initial for p in back.places} == {p.name: p.initial for p in net.places}
        save_net(back, file)
        assert file.read_bytes() == written


def test_no_format_that_is_known_is_refused_as_foreign() -> None:
    assert FOREIGN.keys() & NET_FORMATS.keys() == set()


def test_the_command_names_each_format() -> None:
    told = " ".join(mcpn("convert", "--help").stdout.split())
    read, written = re.findall(r"\(([^()]*)\)", told)[:2]
    assert {*re.findall(r"\.\w+", read)} == {".xml", *READABLE}
    assert {*WRITABLE} <= {*re.findall(r"\.\w+", written)}


@given(net=pt_nets())
def test_pictures_have_every_node_and_arc(net: PetriNet) -> None:
    text = write_dot(net)
    arcs = sum(len(t.consume) + len(t.produce) + len(t.read) for t in net.transitions)
    assert len(re.findall(r"^  [pt]\d+ -> [pt]\d+", text, re.MULTILINE)) == arcs
    assert text.count("style=dashed") == sum(len(t.read) for t in net.transitions)
    assert text.count("shape=circle") == len(net.places)
    assert text.count("shape=box") == len(net.transitions)


@pytest.mark.skipif(shutil.which("dot") is None, reason="needs Graphviz")
@fewer(0.1)
@given(nets=st.lists(odd_nets(), min_size=10, max_size=10))
def test_graphviz_reads_pictures(nets: list[PetriNet]) -> None:
    """Ten at a time: most of what it takes is to start the program."""
    texts = "".join(map(write_dot, nets)).encode()
    run = subprocess.run(["dot", "-Tcanon"], input=texts, capture_output=True, check=True)
    assert run.stderr == b""
    assert len(re.findall(rb"^(?:strict )?digraph ", run.stdout, re.MULTILINE)) == len(nets)


def test_quotes_cannot_break_out_of_pictures() -> None:
    builder = NetBuilder('n"; evil [x="')
    builder.place('p"]; q [label="\\')
    text = write_dot(builder.build())
    assert 'digraph "n\\"; evil [x=\\"" {' in text
    assert 'xlabel="p\\"]; q [label=\\"\\\\"' in text


def test_files_are_written_whole(tmp_path: Path) -> None:
    path = tmp_path / "f"
    write_atomically(path, "é")
    assert path.read_bytes() == b"\xc3\xa9"
    write_atomically(path, b"\0new")
    assert path.read_bytes() == b"\0new"
    umask = os.umask(0)
    os.umask(umask)
    assert path.stat().st_mode & 0o777 == 0o666 & ~umask
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["missing/f", "x" * 300, "nul\0"])
def test_paths_that_cannot_be_written_are_told(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        write_atomically(tmp_path / name, "text")


def test_half_characters_are_told_and_nothing_is_lost(tmp_path: Path) -> None:
    path = tmp_path / "f"
    path.write_text("before")
    with pytest.raises(InputError, match="cannot be written"):
        write_atomically(path, "\ud800")
    assert path.read_text() == "before"


def test_reading_is_bounded(tmp_path: Path) -> None:
    path = tmp_path / "f"
    path.write_bytes(b"x" * 10)
    assert read_bounded(path, 10) == b"x" * 10
    with pytest.raises(InputError, match="larger than 9 bytes"):
        read_bounded(path, 9)
    with pytest.raises(InputError, match="found no such file"):
        read_bounded(tmp_path / "g", 9)
    with pytest.raises(InputError, match="found a directory"):
        read_bounded(tmp_path, 9)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="no regular file"):
        read_bounded(tmp_path / "pipe", 9)
