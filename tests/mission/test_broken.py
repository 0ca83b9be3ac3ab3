"""Broken missions: a located message for each, never another exception, never half a result."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from mcpn.errors import InputError, LimitError
from mcpn.mission.flatten import flatten
from mcpn.mission.xml import MAX_FILE_BYTES, read_mission

NS = 'xmlns="urn:mcpn:mission:1"'
ROBOT = """<robot name="r">
<hardware name="H"/><software name="S"/>
<activity name="driver" produces="S" consumes="H"/>
<activity name="go" consumes="S"/>
<activity name="look"/>
</robot>
"""
OK = '<objective name="o" activities="go"/>'


def body(blocks: str = OK, robot: str = ROBOT) -> str:
    """A mission whose robot starts at line 2 and whose blocks start at line 8."""
    return f'<mission name="m" {NS}>\n{robot}{blocks}\n</mission>'


def robot(inside: str, blocks: str = OK) -> str:
    """A mission with more in its robot, at line 7."""
    return body(blocks, ROBOT.replace("</robot>", f"{inside}</robot>"))


PROTOCOLS = '<protocols>\n<protocol name="p">{}</protocol>\n<protocol name="q">{}</protocol></protocols>\n'

# name: (text, line, what the message says)
BROKEN: dict[str, tuple[str, int, str]] = {
    "empty file": ("", 1, "not well-formed"),
    "blank file": ("  \n ", 2, "not well-formed"),
    "truncated": (body()[:-12], 8, "not well-formed"),
    "text, not XML": ("places and transitions", 1, "not well-formed"),
    "wrong closing tag": (body("<objective name='o' activities='go'></parallel>"), 8, "not well-formed"),
    "wrong namespace": (body().replace("mission:1", "mission:2"), 1, "root element"),
    "no namespace": (body().replace(NS, ""), 1, "root element"),
    "root is a robot": (f'<robot name="r" {NS}/>', 1, "expected a mission"),
    "entity bomb": (
        '<!DOCTYPE m [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">'
        '<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;">]>' + body("&c;"),
        1,
        "DTD",
    ),
    "external entity": (
        '<!DOCTYPE m [<!ENTITY x SYSTEM "file:///etc/passwd">]>' + body("&x;"),
        1,
        "DTD",
    ),
    "parameter entity": (
        '<!DOCTYPE m [<!ENTITY % x SYSTEM "http://127.0.0.1/x.dtd"> %x;]>' + body(),
        1,
        "DTD",
    ),
    "external DTD": ('<!DOCTYPE mission SYSTEM "mission.dtd">' + body(), 1, "DTD"),
    "undeclared entity": (body("&nothing;"), 8, "not well-formed"),
    "unknown element": (body("<goal name='g'/>"), 8, "goal"),
    "unknown attribute": (body("<objective name='o' activities='go' speed='1'/>"), 8, "speed"),
    "no name": (body("<objective activities='go'/>"), 8, "name"),
    "bad name": (body("<objective name='1st' activities='go'/>"), 8, "name"),
    "name with a dot": (body("<objective name='a.b' activities='go'/>"), 8, "name"),
    "mandatory is no truth value": (
        body("<parallel name='p'>\n<objective name='o' activities='go' mandatory='maybe'/></parallel>"),
        9,
        "mandatory",
    ),
    "faulty is no truth value": (robot("<hardware name='G' faulty='often'/>"), 7, "faulty"),
    "no blocks": (body(""), 1, "mission"),
    "objective without activities": (body("<objective name='o'/>"), 8, "objective"),
    "objective with activities and blocks": (
        body("<objective name='o' activities='go'>\n<objective name='x' activities='go'/></objective>"),
        8,
        "",
    ),
    "objective with no activity named": (body("<objective name='o' activities=' '/>"), 8, "no activity"),
    "parallel in parallel": (
        body(f"<parallel name='p'>\n<parallel name='q'>\n{OK}</parallel></parallel>"),
        9,
        "parallel",
    ),
    "parameter without value": (
        body("<objective name='o' activities='go'>\n<parameter name='d'/></objective>"),
        9,
        "value",
    ),
    "activity unknown": (body("<objective name='o' activities='goo'/>"), 8, "did you mean go?"),
    "resource unknown": (robot("<activity name='a' consumes='SS'/>"), 7, "did you mean S?"),
    "product unknown": (robot("<activity name='a' produces='X'/>"), 7, "X, which is not declared"),
    "product is hardware": (robot("<activity name='a' produces='H'/>"), 7, "hardware"),
    "software without producer": (robot("<software name='T'/>"), 7, "found none"),
    "software with two producers": (robot("<activity name='a' produces='S'/>"), 3, "found driver, a"),
    "resource declared twice": (robot("<hardware name='S'/>"), 3, "resource S is declared twice"),
    "activity declared twice": (robot("<activity name='go'/>"), 7, "activity go is declared twice"),
    "alternative declared twice": (
        robot("<activity name='a'><alternative name='x'/>\n<alternative name='x'/></activity>"),
        8,
        "alternative x is declared twice",
    ),
    "objective declared twice": (body(f"{OK}\n{OK}"), 9, "block o is declared twice"),
    "parameter declared twice": (
        body(
            "<objective name='o' activities='go'>\n<parameter name='d' value='1'/>\n"
            "<parameter name='d' value='2'/></objective>"
        ),
        10,
        "parameter d is declared twice",
    ),
    "activity named twice": (body("<objective name='o' activities='go go'/>"), 8, "go 2 times"),
    "resource consumed twice": (robot("<activity name='a' consumes='S S'/>"), 7, "S 2 times"),
    "objective starts a producer": (body("<objective name='o' activities='driver'/>"), 8, "by request"),
    "block called succeed": (body("<objective name='succeed' activities='go'/>"), 8, "name of a route"),
    "route to nowhere": (body("<objective name='o' activities='go' failure='p'/>"), 8, "leads to p"),
    "route into a block": (
        body(f"<objective name='r'>\n{OK}</objective>\n<objective name='x' activities='go' failure='o'/>"),
        10,
        "leads to o",
    ),
    "route on a child of a parallel block": (
        body("<parallel name='p'>\n<objective name='o' activities='go' failure='fail'/></parallel>"),
        9,
        "failure is not allowed",
    ),
    "mandatory outside a parallel block": (
        body("<objective name='o' activities='go' mandatory='true'/>"),
        8,
        "mandatory is not allowed",
    ),
    "parallel with none mandatory": (
        body("<parallel name='p'><objective name='o' activities='go' mandatory='false'/></parallel>"),
        8,
        "no mandatory child",
    ),
    "parallel without children": (body("<parallel name='p'/>"), 8, "parallel"),
    "activities need each other": (
        robot(
            "<software name='A'/><software name='B'/>"
            "<activity name='a' produces='A' consumes='B'/><activity name='b' produces='B' consumes='A'/>"
        ),
        7,
        "a -> b -> a",
    ),
    "activity needs its own product": (
        robot("<software name='A'/><activity name='a' produces='A' consumes='A'/>"),
        7,
        "a -> a",
    ),
    "protocol unknown": (body("<use name='u' protocol='p'/>"), 8, "p, which is not declared"),
    "protocol declared twice": (
        body(PROTOCOLS.replace("'q'", "'p'").replace('"q"', '"p"').format(OK, OK) + OK),
        10,
        "protocol p is declared twice",
    ),
    "protocol uses itself": (
        body(PROTOCOLS.format('<use name="u" protocol="p"/>', OK) + OK),
        9,
        "p -> p",
    ),
    "protocols use each other": (
        body(PROTOCOLS.format('<use name="u" protocol="q"/>', '<use name="u" protocol="p"/>') + OK),
        9,
        "p -> q -> p",
    ),
    "override of no parameter": (
        body(
            PROTOCOLS.format(OK, OK)
            + '<use name="u" protocol="p">\n<parameter name="depth" value="1"/></use>'
        ),
        12,
        "does not have",
    ),
    "import of nothing": (body('<import href="no.xml"/>\n' + OK), 8, "no such file"),
    "import upwards": (body('<import href="../secret.xml"/>\n' + OK), 8, "leaves the mission's directory"),
    "import of an absolute path": (
        body('<import href="/etc/hostname"/>\n' + OK),
        8,
        "leaves the mission's directory",
    ),
    "import over the network": (
        body('<import href="http://127.0.0.1/r.xml"/>\n' + OK),
        8,
        "leaves the mission's directory",
    ),
    "import of itself": (body('<import href="m.xml"/>\n' + OK), 8, "cycle of imports"),
    "nested too deep": (
        body("<objective name='r'>" * 100 + OK + "</objective>" * 100),
        8,
        "deep",
    ),
    "nested 100,000 deep": (body("<objective name='r'>" * 100_000), 8, "not well-formed"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_mission_is_told_with_its_line(name: str, tmp_path: Path) -> None:
    text, line, message = BROKEN[name]
    path = tmp_path / "m.xml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_mission(path)
    told = [
        (p.source.line, p.message) for p in caught.value.problems if p.source and p.source.file == str(path)
    ]
    assert [m for where, m in told if where == line and message in m], caught.value


def test_there_are_at_least_40() -> None:
    assert len(BROKEN) >= 40


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("UTF-16 without a mark", body().encode("utf-16-le")),
        ("bytes that are no UTF-8", body().replace('name="m"', 'name="\u00e9"').encode("latin-1")),
        ("unknown encoding", b'<?xml version="1.0" encoding="EBCDIC-9"?>' + body().encode()),
        ("a wrong claim", b'<?xml version="1.0" encoding="UTF-16"?>' + body().encode()),
        ("zero bytes", b"\0" * 100),
        ("an executable", b"\x7fELF" + bytes(range(256))),
    ],
)
def test_wrong_encodings_are_told(name: str, data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"m\.xml:1: "):
        read_mission(path)


def test_missing_files_and_directories_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_mission(tmp_path / "m.xml")
    with pytest.raises(InputError, match="found a directory"):
        read_mission(tmp_path)


def test_huge_files_are_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    with path.open("wb") as file:
        file.truncate(MAX_FILE_BYTES + 1)
    with pytest.raises(InputError, match="larger than"):
        read_mission(path)


def test_import_cycles_through_other_files_are_told(tmp_path: Path) -> None:
    for name, other in (("a", "b"), ("b", "a")):
        (tmp_path / f"{name}.xml").write_text(
            f'<robot name="{name}" {NS}>\n<import href="{other}.xml"/></robot>'
        )
    (tmp_path / "m.xml").write_text(body('<import href="a.xml"/>' + OK))
    with pytest.raises(InputError, match=r"b\.xml:2: .*cycle of imports"):
        read_mission(tmp_path / "m.xml")


@pytest.mark.skipif(sys.platform == "win32", reason="needs symbolic links")
def test_links_do_not_lead_out_of_the_directory(tmp_path: Path) -> None:
    (tmp_path / "outside.xml").write_text(ROBOT.replace("<robot ", f"<robot {NS} "))
    inside = tmp_path / "in"
    inside.mkdir()
    (inside / "r.xml").symlink_to(tmp_path / "outside.xml")
    (inside / "m.xml").write_text(body('<import href="r.xml"/>' + OK, robot=""))
    with pytest.raises(InputError, match="leaves the mission's directory"):
        read_mission(inside / "m.xml")


def test_an_imported_mission_is_refused(tmp_path: Path) -> None:
    (tmp_path / "other.xml").write_text(body())
    (tmp_path / "m.xml").write_text(body('<import href="other.xml"/>' + OK))
    with pytest.raises(InputError, match="expected <robot> or <protocols>"):
        read_mission(tmp_path / "m.xml")


def test_all_problems_of_all_files_are_told_in_one_go(tmp_path: Path) -> None:
    (tmp_path / "r.xml").write_text(f'<robot name="q" {NS}>\n<hardware/>\n<engine name="e"/></robot>')
    (tmp_path / "s.xml").write_text(f'<robot name="q" {NS}>\n<activity/></robot>')
    text = '<import href="r.xml"/><import href="s.xml"/><import href="t.xml"/>' + OK
    (tmp_path / "m.xml").write_text(body(text))
    with pytest.raises(InputError) as caught:
        read_mission(tmp_path / "m.xml")
    files = [Path(p.source.file).name for p in caught.value.problems if p.source]
    assert set(files) == {"m.xml", "r.xml", "s.xml"}
    assert files == sorted(files)


def test_protocols_that_double_forever_hit_a_limit(tmp_path: Path) -> None:
    levels = [
        f'<protocol name="p{i}">'
        f'<use name="a" protocol="p{i + 1}"/><use name="b" protocol="p{i + 1}"/></protocol>'
        for i in range(40)
    ]
    protocols = f'<protocols>{"".join(levels)}<protocol name="p40">{OK}</protocol></protocols>'
    (tmp_path / "m.xml").write_text(body(protocols + '<use name="u" protocol="p0"/>'))
    with pytest.raises(LimitError, match="100000 objectives"):
        flatten(read_mission(tmp_path / "m.xml"))
