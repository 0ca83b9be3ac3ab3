"""The language as XML Schema: it accepts and refuses what the RELAX NG schema does."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from lxml import etree

from mcpn.errors import InputError
from mcpn.mission.language.forms import NAMESPACE, language
from mcpn.mission.misfits import SCHEMA
from mcpn.mission.model import Objective, Parallel
from mcpn.mission.validate import find_errors
from mcpn.mission.xml import read_mission
from tests import small
from tests.conftest import ROOT

NG = "{http://relaxng.org/ns/structure/1.0}"


XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="urn:mcpn:mission:1 m.xsd"'


LEG = f"""<mission name="m" xmlns="{NAMESPACE}" {XSI}><robot name="r"><hardware name="h"/>
<activity name="a"><alternative name="x" consumes="h"/><parameter name="p" value="1"/></activity></robot>
<objective name="o" activities="a"><parameter name="q" value="2"/></objective></mission>"""


def begins(pattern: etree._Element) -> set[str]:
    """The elements with which what a pattern matches may begin."""
    if pattern.tag == f"{NG}ref":
        name = str(pattern.get("name"))
        return {name} if name in language() else set()
    if pattern.tag == f"{NG}attribute":
        return set()
    found = set[str]()
    for part in pattern:
        first = begins(part)
        found |= first
        in_turn = pattern.tag in (f"{NG}group", f"{NG}oneOrMore")
        if in_turn and first and part.tag not in (f"{NG}optional", f"{NG}zeroOrMore"):
            break
    return found


def test_what_comes_first_tells_the_way() -> None:
    """Unique Particle Attribution, which XML Schema asks: no two ways of a choice begin alike."""
    schema = etree.parse(SCHEMA)
    assert next(schema.iter(f"{NG}interleave"), None) is None
    for choice in schema.iter(f"{NG}choice"):
        ways = [begins(way) for way in choice]
        assert sum(map(len, ways)) == len(set().union(*ways)), etree.tostring(choice)


def test_trang_makes_an_xsd_that_xerces_takes(tmp_path: Path) -> None:
    if shutil.which("trang") is None or shutil.which("jing") is None:
        pytest.skip("needs trang and jing (apt-get install trang jing)")
    xsd = tmp_path / "mission.xsd"
    subprocess.run(["trang", SCHEMA, xsd], check=True, capture_output=True)
    (tmp_path / "leg.xml").write_text(LEG)
    fitting = [tmp_path / "leg.xml", *sorted((ROOT / "experiments").glob("*/mission.xml"))]
    found = subprocess.run(["jing", xsd, *fitting], capture_output=True, text=True, check=False)
    assert (found.returncode, found.stdout) == (0, "")
    (tmp_path / "leg.xml").write_text(LEG.replace("parameter", "parametre"))
    found = subprocess.run(["jing", xsd, tmp_path / "leg.xml"], capture_output=True, text=True, check=False)
    assert found.returncode == 1


def test_a_root_may_say_where_an_xsd_is(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(LEG)
    assert read_mission(path).name == "m"
    path.write_text(LEG.replace(f" {XSI}", "").replace('<robot name="r"', f'<robot name="r" {XSI}'))
    with pytest.raises(InputError, match=r"found the attribute .*schemaLocation on <robot>"):
        read_mission(path)


def test_a_digit_that_is_no_number_is_refused() -> None:
    """Of a superscript ``isdigit`` is true, and ``int`` has no value."""
    children = (Objective(name="o", activities=("a",)),)
    of = small.mission(
        small.robot((), small.activity("a", ())), Parallel(name="p", blocks=children, success_when="²")
    )
    assert [each.message for each in find_errors(of)] == [
        "success_when of p is ², expected any, all or a whole number above 0"
    ]
