"""What no table declares is refused at every place of every format of nets, or listed as without meaning."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from mcpn.declared import Declared, name_of
from mcpn.errors import InputError, McpnError
from mcpn.events import Event
from mcpn.logic.contest import KNOWN as OF_PROPERTIES
from mcpn.logic.contest import read_properties
from mcpn.nets.formats import read_net
from mcpn.nets.formats.json import write_json
from mcpn.nets.formats.pnml import KNOWN as OF_PNML
from mcpn.nets.formats.pnml import REMARKS
from mcpn.nets.formats.pnml_writer import write_pnml
from mcpn.nets.formats.tina import write_tina
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.formula_names import Names
from tests.draws import fewer
from tests.nets.formats.test_other_tools import EPNK, PIPE, PM4PY, TAPAAL, WOPED

NAMES = st.from_regex(r"[a-z][a-zA-Z]{2,9}", fullmatch=True)


def small() -> PetriNet:
    builder = NetBuilder("a net", priorities=True)
    builder.place("p q", initial=2, label="stock")
    builder.place("r")
    builder.transition("t", consume={"p q": 2}, produce=["r"], read=["r"], rank=1)
    builder.label("t", "take")
    builder.transition("u", event=Event.parse("go"))
    return builder.build()


PNML = [PM4PY, WOPED, PIPE, EPNK, TAPAAL, write_pnml(small()).decode()]
QUERY = """<property-set xmlns="http://tapaal.net/"><property><id>a</id><description>words</description>
<tags><expected-result><unknown/></expected-result></tags><formula><all-paths><until><before><conjunction>
<integer-ge><integer-sum><tokens-count><place>r</place></tokens-count><integer-constant>1</integer-constant>
</integer-sum><integer-constant>0</integer-constant></integer-ge><negation><deadlock/></negation></conjunction>
</before><reach><is-fireable><transition>t</transition></is-fireable></reach></until></all-paths></formula>
</property><property><id>b</id><formula><place-bound><place>r</place></place-bound></formula></property>
</property-set>"""


def without_meaning(element: etree._Element, table: dict[str, Declared]) -> bool:
    """Whether an element stands in one that its table lists so."""
    while (parent := element.getparent()) is not None:
        if f"-{name_of(element)}" in table.get(name_of(parent), Declared()).inside.split():
            return True
        element = parent
    return False


def spoiled(text: str, data: st.DataObject, table: dict[str, Declared]) -> tuple[str, bool, str]:
    """A document with something unknown; whether that stands where nothing has a meaning; its name."""
    root = etree.fromstring(text.encode())
    of_mcpn = [each for each in root.iter("{*}toolspecific") if each.get("tool") == "mcpn"]
    places = [each for each in root.iter() if isinstance(each.tag, str)]
    element = data.draw(st.sampled_from(places))
    ours = any(each in of_mcpn for each in (element, *element.iterancestors()))
    row = (REMARKS if ours else table).get(name_of(element), Declared())
    words = f"{row.attributes} {row.inside}".replace("-", " ").replace("=", " ").split()
    name = data.draw(NAMES.filter(lambda name: name not in words))
    if data.draw(st.booleans()):
        element.set(name, data.draw(st.sampled_from(["0", "1", "inhibitor"])))
    else:
        element.insert(data.draw(st.integers(0, len(element))), element.makeelement(_beside(element, name)))
    return etree.tostring(root).decode(), not ours and without_meaning(element, table), name


def _beside(element: etree._Element, name: str) -> str:
    space = etree.QName(element).namespace
    return name if space is None else f"{{{space}}}{name}"


@fewer(3)
@pytest.mark.parametrize("number", range(len(PNML)))
@given(data=st.data())
def test_pnml(number: int, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    folder = tmp_path_factory.mktemp("unknown")

    def read(text: str) -> PetriNet:
        (folder / "n.pnml").write_text(text)
        return read_net(folder / "n.pnml")

    text, ignored, name = spoiled(PNML[number], data, OF_PNML)
    if ignored:
        assert read(text) == read(PNML[number])
        return
    with pytest.raises(InputError, match=rf"n\.pnml:\d+: found .*{name}.* expected"):
        read(text)


@fewer(3)
@given(data=st.data())
def test_property_files(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    path = tmp_path_factory.mktemp("unknown") / "q.xml"
    text, ignored, name = spoiled(QUERY, data, OF_PROPERTIES)
    path.write_text(text)
    if ignored:
        assert [each.name for each in read_properties(path, Names(small()))] == ["a", "b"]
        return
    with pytest.raises(InputError, match=rf"q\.xml:\d+: .*found .*{name}.* expected"):
        read_properties(path, Names(small()))


def objects(value: Any) -> list[dict[str, Any]]:
    """Each object of a document, but for those that map places to weights."""
    if isinstance(value, list):
        return [found for item in value for found in objects(item)]
    if not isinstance(value, dict):
        return []
    inside = [each for key, each in value.items() if key not in ("consume", "produce", "read")]
    return [value, *objects(inside)]


@given(data=st.data())
def test_json(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    document = json.loads(write_json(small()))
    document["places"][0]["from"] = {"kind": "mission", "name": "m"}
    known = {"file", "line"} | {key for each in objects(document) for key in each}
    name = data.draw(NAMES.filter(lambda name: name not in known))
    data.draw(st.sampled_from(objects(document)))[name] = data.draw(st.sampled_from([0, None, {"r": 1}]))
    path = tmp_path_factory.mktemp("unknown") / "n.json"
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match=f'found "{name}", expected one of the keys '):
        read_net(path)


@fewer(2)
@given(data=st.data())
def test_tina_has_no_other_declarations(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """A word that is no keyword: refused where no arcs stand before it, of which it would be one."""
    lines = write_tina(small()).splitlines()
    name = data.draw(NAMES.filter(lambda name: name not in ("net",)))
    after = data.draw(st.sampled_from([" x", " x (1)", " (1)", " x : y", " [0,1]", " 1 {text}"]))
    lines.insert(data.draw(st.integers(0, 1)), name + after)
    path = tmp_path_factory.mktemp("unknown") / "n.net"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=rf"n\.net:\d: column 1: found '{name}'"):
        read_net(path)


def test_every_element_of_a_table_has_a_row_or_is_without_meaning() -> None:
    for table in (OF_PNML, OF_PROPERTIES):
        named = {
            word.partition("=")[0] for row in table.values() for word in row.inside.split() if word[0] != "-"
        }
        assert named <= table.keys()


@pytest.mark.parametrize("read", [read_net, lambda path: read_properties(path, Names(small()))])
def test_no_word_of_the_parser_reaches_a_person(read: Callable[[Path], object], tmp_path: Path) -> None:
    texts = ["", "x", "<a>", "<a></b>", "<a b></a>", "<a b='<'/>", "<a>&&</a>", "<a>&b;</a>", "<a>\1</a>"]
    texts += [
        "<a b='1' b='2'/>",
        "<a/><b/>",
        "<x:a/>",
        "<a>" * 300,
        "<1/>",
        "<a",
        "<!-- ",
        "<a><![CDATA[",
        "&#0;",
    ]
    for text in texts:
        (tmp_path / "n.pnml").write_text(text)
        with pytest.raises(McpnError) as caught:
            read(tmp_path / "n.pnml")
        said = str(caught.value)
        assert "n.pnml:1: not well-formed XML" in said
        for word in ("xml", "Start tag", "Entity", "AttValue", "PCDATA", "Premature", "mandates", "HUGE"):
            assert word not in said.partition("XML")[2], said
