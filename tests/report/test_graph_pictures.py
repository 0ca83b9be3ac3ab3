"""Pictures of graphs: everything is in them, nothing of a mission's text is obeyed, large ones are folded."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lxml import etree

import mcpn
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import InputError, LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective
from mcpn.mission.xml import read_mission
from mcpn.nets.formats import save_net
from mcpn.nets.petri import NetBuilder
from mcpn.report.pictures import drawing as drawing_module
from mcpn.report.pictures import graph as graphs
from mcpn.report.pictures import graphviz
from mcpn.report.pictures.choice import KINDS, drawn
from mcpn.report.pictures.graph import Arrow, Cluster, Graph, Node, Placed, lay_out
from mcpn.report.pictures.machines import sections_of
from mcpn.report.pictures.objectives_graph import MOST_SECTIONS, objectives_picture
from mcpn.report.pictures.place_picture import net_picture
from mcpn.report.pictures.unit_picture import interface, units_picture
from mcpn.testing import missions
from tests.commands import mcpn as command
from tests.commands import output
from tests.conftest import ROOT, ULYSSE
from tests.nets.nets import pt_nets
from tests.report.test_pictures import hostile

pytest.importorskip("pygraphviz", reason="needs pygraphviz: the extra pictures")
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def ulysse() -> MissionNet:
    return compose(read_mission(ULYSSE))


def overlapping(placed: Placed) -> Iterator[tuple[Any, Any]]:
    frames = [*placed.nodes.values()]
    for i, a in enumerate(frames):
        for b in frames[:i]:
            apart = (
                a.x + a.width <= b.x or b.x + b.width <= a.x or a.y + a.height <= b.y or b.y + b.height <= a.y
            )
            if not apart:
                yield a, b


@settings(max_examples=50)
@given(missions())
def test_every_section_and_route_is_drawn(mission: Mission) -> None:
    net = compose(mission)
    graph = objectives_picture(net.graph, "x")
    keys = {node.key for node in graph.nodes}
    assert {section.name for section in net.graph.walk()} <= keys
    for edge in graph.edges:
        assert edge.source in keys
        assert edge.target in keys


@settings(max_examples=10)
@given(missions())
def test_boxes_stand_apart(mission: Mission) -> None:
    graph = objectives_picture(compose(mission).graph, "x")
    placed = lay_out(graph)
    assert len(placed.nodes) == len(graph.nodes)
    assert len(placed.curves) == len(graph.edges)
    assert list(overlapping(placed)) == []
    for frame in placed.nodes.values():
        assert frame.x >= 0
        assert frame.x + frame.width <= placed.width + 1
        assert frame.y >= 0
        assert frame.y + frame.height <= placed.height + 1


@settings(max_examples=15)
@given(missions())
def test_a_net_is_drawn_with_its_interface(mission: Mission) -> None:
    """Each place once; what joins units is green, and only units that share a place are joined."""
    net = compose(mission).net
    picture = net_picture(net, "x")
    assert len(picture.nodes) == len(net.places) + len(net.transitions)
    assert len(picture.edges) == sum(len(t.consume) + len(t.produce) + len(t.read) for t in net.transitions)
    green = {node.key for node in picture.nodes if "interface" in node.kind}
    assert green == {f"p{place}" for place in interface(net)}
    units = units_picture(net, "x")
    joined = set[str]().union(
        *(edge.title.removeprefix("interface places: ").split(", ") for edge in units.edges)
    )
    assert joined <= {place.name for place in net.places}
    assert {net.places[p].name for p in interface(net)} == joined - {""}


@given(st.data())
def test_units_from_elsewhere_are_framed(data: st.DataObject) -> None:
    """A place stands in its unit's frame; it is internal where each of its transitions stands there too."""
    drawn_net = data.draw(pt_nets())
    keys = data.draw(
        st.lists(st.integers(0, 2), min_size=len(drawn_net.places), max_size=len(drawn_net.places))
    )
    units = tuple(tuple(p for p, key in enumerate(keys) if key == k) for k in (1, 2))
    net = replace(drawn_net, units=units)
    picture = net_picture(net, "x")
    names = {cluster.key: cluster.name for cluster in picture.clusters}
    framed = {node.key: names.get(node.cluster or "") for node in picture.nodes}
    sizes = [len(unit) for unit in units]
    for place, key in enumerate(keys):
        assert framed[f"p{place}"] == (f"unit {key}" if key and sizes[key - 1] > 1 else None)
    joined = [(e.source, e.target) if e.source[0] == "p" else (e.target, e.source) for e in picture.edges]
    for node in picture.nodes:
        if node.key[0] == "p":
            outside = any(framed[t] != framed[p] for p, t in joined if p == node.key)
            assert ("interface" in node.kind) == outside
        elif around := {framed[p] for p, t in joined if t == node.key}:
            assert framed[node.key] == (around.pop() if len(around) == 1 else None)


def test_units_of_a_file_are_drawn(tmp_path: Path) -> None:
    builder = NetBuilder("two")
    for name in "abcd":
        builder.place(name, initial=int(name in "ac"))
    builder.transition("t", consume=["a"], produce=["b"])
    builder.transition("u", consume=["b", "c"], produce=["a", "d"])
    builder.unit(["a", "b"])
    builder.unit(["c", "d"])
    source, target = tmp_path / "n.json", tmp_path / "n.svg"
    save_net(builder.build(), source)
    assert command("convert", source, target, "--draw", "net").returncode == 0
    text = target.read_text()
    assert all(f">{unit}</text>" in text for unit in ("unit 1", "unit 2"))


def test_places_of_a_resource_have_the_colours_of_the_paper(ulysse: MissionNet) -> None:
    """Paper, 6.1: free and busy red, failing orange, the interface green."""
    text = drawn(ulysse, "net", "transect.diving").svg
    titles = {
        rect.findtext(f"{SVG}title"): rect.get("class")
        for rect in etree.fromstring(text.encode()).iter(f"{SVG}rect")
    }
    for part, kind in (
        ("busy", "internal"),
        ("failing", "temporary"),
        *((part, "interface") for part in ("available", "take", "answer", "release", "error")),
    ):
        found = [kind for title, kind in titles.items() if title and f"GPS_sensor_{part} " in title]
        assert len(found) == 1
        assert kind in (found[0] or "")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("section", [None, "transect.diving"])
def test_each_kind_of_picture_of_ulysse_is_drawn_or_refused(
    ulysse: MissionNet, kind: str, section: str | None, tmp_path: Path
) -> None:
    if section and kind in ("mission", "objectives", "run"):
        with pytest.raises(InputError, match="expected one of a section"):
            drawn(ulysse, kind, section)
        return
    picture = drawn(ulysse, kind, section)
    root = etree.fromstring(picture._repr_svg_().encode())
    assert "diving" in str(root.xpath("string()"))
    assert len(repr(picture)) < 200


def test_the_local_graph_answers_what_happens_when_the_gps_fails(ulysse: MissionNet) -> None:
    """During the dive, the IMU takes over; when it fails too, there is no way."""
    from mcpn.report.pictures.machines import local_drawing

    assert ">GPS_sensor out<" in local_drawing(spaces_of(ulysse), "transect.diving").svg
    merged = local_drawing(spaces_of(ulysse), "transect.diving", merged=True)
    lines = [str(t.text) for t in etree.fromstring(merged.svg.encode()).iter(f"{SVG}text")]
    assert [line for line in lines if line.split(":")[0] in ("localisation", "no way")] == [
        "localisation: gps_localisation",
        "localisation: imu_localisation",
        "no way: diving",
    ]


def test_a_hostile_mission_is_only_text(tmp_path: Path) -> None:
    """In every picture, of the whole and of its sections, there are no elements but those of pictures."""
    net = compose(hostile())
    first = net.graph.sections[0].name
    for kind in KINDS:
        for section in (None, first):
            try:
                text = drawn(net, kind, section).svg
            except InputError:
                continue
            root = etree.fromstring(text.encode())
            known = {"svg", "style", "rect", "defs", "marker", "path", "title", "text", "polyline"}
            assert {etree.QName(element).localname for element in root.iter("*")} <= known
            assert not any(
                str(name).startswith("on") for element in root.iter("*") for name in element.attrib
            )
            assert max(len(t.text or "") for t in root.iter(f"{SVG}text")) <= graphs.MOST_IN_NODE


def test_texts_that_graphviz_would_read() -> None:
    """Backslashes, references of HTML, quotes and braces are text."""
    evil = 'a\\N "b" <B>c</B> &amp; {d|e} \\l ☃ \u202e'
    nodes = [Node("x", (evil,), "node", cluster="c"), Node("y", (evil,), "node")]
    graph = Graph(evil, nodes, [Arrow("x", "y", "arc", (evil,))], [Cluster("c", evil)])
    root = etree.fromstring(graphs.drawing(graph).svg.encode())
    assert [text.text for text in root.iter(f"{SVG}text")].count(evil) == 4


def test_a_long_mission_is_drawn_by_its_blocks() -> None:
    base = hostile()
    many = tuple(Objective(name=f"o{i}", activities=("b",)) for i in range(500))
    from dataclasses import replace

    net = compose(replace(base, blocks=many))
    graph = objectives_picture(net.graph, "long")
    assert len(graph.nodes) <= MOST_SECTIONS + 3
    told = [node.lines for node in graph.nodes if "sections" in node.lines[-1]]
    assert sum(int(lines[-1].split()[0]) for lines in told) == 500


def test_too_large_a_picture_names_its_limit(tmp_path: Path) -> None:
    builder = NetBuilder("wide")  # a limit is checked before the layout
    for i in range(graphs.MOST_NODES + 1):
        builder.place(f"p{i}")
    with pytest.raises(
        LimitError, match=f"301 boxes, the limit of what one drawing shows is {graphs.MOST_NODES}"
    ):
        mcpn.open(builder.build()).picture().save(tmp_path / "x.svg")
    assert not (tmp_path / "x.svg").exists()


def test_graphviz_may_fail(ulysse: MissionNet, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where its process dies with curves there are straight lines; where it always dies, an error."""
    asked = []
    answers = graphviz._answers

    def dies(questions: Sequence[dict[str, Any]], *when: str) -> list[dict[str, Any]] | str:
        asked.append([question["splines"] for question in questions])
        return "it dies" if asked[-1][0] in when else answers(questions)

    monkeypatch.setattr(graphviz, "_answers", lambda questions: dies(questions, "true"))
    assert "transect.diving" in drawn(ulysse, "objectives").svg
    assert asked == [["true"], ["true"], ["line"]]
    monkeypatch.setattr(graphviz, "_answers", lambda questions: dies(questions, "true", "line"))
    no_layout = "Objectives graph of the mission ulysse: Graphviz finds no layout: it dies"
    with pytest.raises(LimitError, match=no_layout):
        _ = drawn(ulysse, "objectives").svg


def test_why_there_is_no_layout_is_said_as_it_is(ulysse: MissionNet, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that fails at once did not take a minute, and one that takes long did not fail."""
    told = graphviz._answers([{"splines": "true", "nodes": "none"}])
    assert told == "its process ended with KeyError: 'sideways'"
    monkeypatch.setattr(sys, "executable", shutil.which("false"))
    with pytest.raises(LimitError, match="finds no layout: its process ended with exit code 1"):
        _ = drawn(ulysse, "objectives").svg
    monkeypatch.undo()
    monkeypatch.setattr(graphviz, "SECONDS", 0.01)
    with pytest.raises(LimitError, match=r"finds no layout: it takes longer than 0\.01 seconds"):
        _ = drawn(ulysse, "objectives").svg


def test_without_the_extra_an_error_says_what_to_install(
    ulysse: MissionNet, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def absent(name: str) -> object:
        raise ImportError(name)

    monkeypatch.setattr(drawing_module, "import_module", absent)
    with pytest.raises(LimitError, match=r"pygraphviz: pip install 'mcpn\[pictures\]'"):
        drawn(ulysse, "objectives").save(tmp_path / "x.svg")
    with pytest.raises(LimitError, match=r"resvg_py: pip install 'mcpn\[pictures\]'"):
        drawn(ulysse).save(tmp_path / "x.png")


def test_png(ulysse: MissionNet, tmp_path: Path) -> None:
    """A picture of the right size, in the colours of paper."""
    pytest.importorskip("resvg_py", reason="needs resvg-py: the extra pictures")
    picture = drawn(ulysse, "controller")
    data = picture.png
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = (int.from_bytes(data[16 + 4 * i : 20 + 4 * i], "big") for i in (0, 1))
    root = etree.fromstring(picture.svg.encode())
    assert (width, height) == (2 * int(root.get("width", "0")), 2 * int(root.get("height", "0")))


def test_the_machine_of_a_section_is_as_wide_as_a_poster_at_most(ulysse: MissionNet) -> None:
    """With many ways to run, the same objectives are one box, and orders are in titles."""
    drone = compose(read_mission(ROOT / "experiments" / "drone" / "mission.xml"))
    for mission_net, section, small in (
        (drone, "stock_A1.along", False),
        (ulysse, "coral_head.manual_moving", True),
    ):
        root = etree.fromstring(drawn(mission_net, "controller", section).svg.encode())
        assert int(root.get("width", "0")) < 4_000
        texts, titles = (
            [element.text or "" for element in root.iter(f"{{*}}{tag}")] for tag in ("text", "title")
        )
        assert any(text.startswith("stop ") for text in texts) == small
        assert any(": stop " in title for title in titles)


def by_resvg(svg: str) -> bytes:
    """The picture by the resvg library."""
    resvg = pytest.importorskip("resvg_py", reason="needs resvg-py: the extra pictures")
    return bytes(resvg.svg_to_bytes(svg_string=svg, font_family=drawing_module.FAMILY))


def by_librsvg(svg: str) -> bytes:
    """The picture by librsvg, as file managers, Wikipedia and LaTeX tool chains draw it."""
    if shutil.which("rsvg-convert") is None:
        pytest.skip("needs rsvg-convert (apt-get install librsvg2-bin)")
    return subprocess.run(["rsvg-convert"], input=svg.encode(), capture_output=True, check=True).stdout


def by_cairosvg(svg: str) -> bytes:
    """The picture by CairoSVG."""
    cairosvg = pytest.importorskip("cairosvg", reason="needs CairoSVG (pip install cairosvg)")
    return bytes(cairosvg.svg2png(bytestring=svg.encode()))


@pytest.mark.parametrize("render", [by_resvg, by_librsvg, by_cairosvg])
def test_each_kind_of_picture_has_its_colours_everywhere(
    ulysse: MissionNet, render: Callable[[str], bytes]
) -> None:
    """Paper, ink, and the colours of success and failure, where a program knows only what SVG has."""
    image = pytest.importorskip("PIL.Image", reason="needs Pillow: the extra test-all")
    section = "transect.diving"
    asked = [
        *((kind, None) for kind in KINDS),
        *((kind, section) for kind in ("net", "alternatives", "controller")),
    ]
    for kind, inside in asked:
        svg = drawn(ulysse, kind, inside).svg
        assert "var(" not in svg
        assert "@media" not in svg
        picture = image.open(BytesIO(render(svg))).convert("RGB")
        colours = [colour for _, colour in picture.getcolors(picture.width * picture.height) or ()]
        assert max(map(sum, colours)) > 3 * 250, f"{kind}: no paper"
        assert min(map(sum, colours)) < 3 * 60, f"{kind}: no ink"
        assert any(max(colour) - min(colour) > 60 for colour in colours), f"{kind}: neither blue nor red"


LETTERS = """
import json, sys
from mcpn.report.pictures.drawing import Drawing
frame = '<svg xmlns="http://www.w3.org/2000/svg" width="40" height="40"><style>{}</style>{}</svg>'
style = 'text { font: 20px system-ui, "DejaVu Sans", sans-serif; } .bold { font-weight: 600; }'
def drawn(letter, kind):
    text = f'<text x="4" y="28" class="{kind}">{letter}</text>'
    return Drawing(letter, lambda: frame.format(style, text)).png.hex()
print(json.dumps([[drawn(letter, kind) for kind in ("plain", "bold")] for letter in json.load(sys.stdin)]))
"""


def test_png_has_its_letters_on_a_machine_without_a_font(tmp_path: Path) -> None:
    """Each sign that pictures use is drawn, regular and bold, and is not the box of an unknown one."""
    pytest.importorskip("resvg_py", reason="needs resvg-py: the extra pictures")
    assets = Path(drawing_module.__file__).parents[1]
    texts = [path.read_text() for kind in ("pictures/*.py", "assets/*.svg") for path in assets.glob(kind)]
    signs = sorted({letter for letter in "".join(texts) if not letter.isascii()} | set("MÉΩЖ"))
    assert {"✓", "✗"} <= {*signs}
    config = tmp_path / "fonts.conf"
    config.write_text(f"<fontconfig><dir>{tmp_path}</dir></fontconfig>")
    command = [sys.executable, "-c", LETTERS]
    asked = json.dumps([" ", "\ue000", *signs])
    run = subprocess.run(
        command,
        input=asked,
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "FONTCONFIG_FILE": str(config)},
    )
    nothing, unknown, *found = json.loads(run.stdout)
    for letter, pictures in zip(signs, found, strict=True):
        assert not {*pictures} & {*nothing, *unknown}, letter
        assert pictures[0] != pictures[1] or letter not in "MÉΩЖ"


def test_the_commands(tmp_path: Path) -> None:
    target = tmp_path / "a.svg"
    told = output("alternatives", ULYSSE, "--section", "transect.diving", "-o", target)
    assert told["states"] == 36
    assert "Local graph of the section transect.diving" in target.read_text()
    output("convert", ULYSSE, target, "--draw", "objectives")
    assert "Objectives graph" in target.read_text()
    wrong = command("convert", ULYSSE, target, "--section", "no")
    assert wrong.returncode == 2
    assert "found the section 'no', expected one of coral_head.manual_moving" in wrong.stderr
    wrong = command("convert", ULYSSE, tmp_path / "x.net", "--draw", "net")
    assert wrong.returncode == 2
    assert "expected .svg or .png" in wrong.stderr


@settings(max_examples=6)
@given(missions())
def test_any_mission_is_drawn(mission: Mission) -> None:
    """Every kind of picture of every mission is made, or an error says why it cannot be."""
    net = compose(mission)
    for kind in ("alternatives", "controller"):
        for section in (None, net.graph.sections[0].name):
            try:
                etree.fromstring(drawn(net, kind, section).svg.encode())
            except (LimitError, SemanticsError):
                continue


@settings(max_examples=50)
@given(missions())
def test_whatever_a_marking_says_of_objectives_has_a_section(mission: Mission) -> None:
    net = compose(mission)
    places = sections_of(net.graph)
    said = {name for kind, name in net.roles.values() if kind in ("objective", "pending", "done")}
    assert said <= set(places)
    assert set(places.values()) == {section.name for section in net.graph.sections}


def test_a_branch_of_an_inner_block_that_is_tried_again_stands_in_the_outer_one(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(
        """<mission xmlns="urn:mcpn:mission:1" name="m">
          <robot name="r">
            <hardware name="h"/>
            <activity name="a" consumes="h"/><activity name="b"/><activity name="c"/>
          </robot>
          <parallel name="outer">
            <objective name="first">
              <parallel name="inner">
                <objective name="again" activities="a" retries="1"/>
                <objective name="beside" activities="b"/>
              </parallel>
            </objective>
            <objective name="last" activities="c"/>
          </parallel>
        </mission>"""
    )
    found = sections_of(compose(read_mission(path)).graph)
    assert set(found.values()) == {"outer"}
    assert found["again"] == "outer"
