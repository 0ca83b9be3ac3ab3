"""Names, texts and sizes of numbers in generated C, whatever a mission calls its elements."""

from __future__ import annotations

import json
import re
from pathlib import Path

from hypothesis import example, given
from hypothesis import strategies as st

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot
from mcpn.robot.targets import files
from mcpn.robot.targets.c import Array
from mcpn.robot.targets.identifiers import C_KEYWORDS, C_SIGNIFICANT, c_string, comment, identifiers
from tests.controller.test_c import build


@given(st.lists(st.text(max_size=80), unique=True), st.integers(6, 70))
def test_identifiers_are_such_and_differ(names: list[str], longest: int) -> None:
    found = identifiers(names, keywords=C_KEYWORDS, longest=longest, taken=["X_Y"])
    assert list(found) == names
    assert len({text.lower() for text in found.values()}) == len(names)
    for text in found.values():
        assert text.isascii()
        assert text.isidentifier()
        assert len(text) <= longest
        assert text not in C_KEYWORDS
        assert text.lower() != "x_y"
    assert identifiers(names, keywords=C_KEYWORDS, longest=longest, taken=["X_Y"]) == found


def named(name: str) -> dict[str, str]:
    """The files of a small mission of some name."""
    activity = Activity(name="a", alternatives=(Alternative(name="w", consumes=("h",)),))
    robot = Robot(name="r", hardware=(Hardware(name="h"),), activities=(activity,))
    blocks = (Objective(name="o", activities=("a",), timeout=1.0),)
    mission_net = compose(Mission(name=name, robots=(robot,), blocks=blocks))
    return files(document(generate(mission_net), mission_net), "c")


def test_no_mission_s_name_makes_a_name_of_the_templates(tmp_path: Path) -> None:
    text = "\n".join(named("zz").values())
    interface = set(re.findall(r"\bzz_(\w+)", text))
    words = {word for word in re.findall(r"\b[a-z]\w*\b", text) if not word.startswith("zz")}
    clashing = {w[: -len(i) - 1] for w in words for i in interface if w.endswith(f"_{i}")}
    assert {"local", "move"} <= clashing
    headers = set(re.findall(r"#include <(\w+)\.h>", text))
    assert {"stdint", "string"} <= headers
    for name in clashing | headers:
        assert f"{name}.h" not in named(name)
    for name in ("local", "string", "int", "a_b"):
        build(named(name), tmp_path / name, "-I", str(tmp_path / name))


def test_collisions_and_keywords() -> None:
    assert identifiers(["a.b", "a_b", "A_B", "int", "1", ""], keywords=C_KEYWORDS) == {
        "a.b": "a_b",
        "a_b": "a_b_2",
        "A_B": "A_B_3",
        "int": "int_2",
        "1": "x_1",
        "": "x_",
    }
    long = ["x" * 200 + "a", "x" * 200 + "b"]
    assert len(set(identifiers(long, longest=C_SIGNIFICANT).values())) == 2


@example("*\\")
@example("/\\*/*/")
@given(st.text(max_size=40) | st.text('*/\\?\n"', max_size=8))
def test_strings_end_where_they_should(text: str) -> None:
    literal = c_string(text)
    assert literal.isascii()
    assert literal[0] == literal[-1] == '"'
    inner = literal[1:-1]
    assert '"' not in inner
    assert "?" not in inner
    read = json.loads('"' + inner.replace("\\", "\\\\") + '"') if inner.isascii() else ""
    out, i = bytearray(), 0
    while i < len(read):
        if read[i] == "\\":
            out.append(int(read[i + 1 : i + 4], 8))
            i += 4
        else:
            out += read[i].encode()
            i += 1
    assert bytes(out) == text.encode("utf-8", "replace")
    assert "*/" not in comment(text)
    assert "\n" not in comment(text)


def test_arrays_are_as_small_as_their_numbers() -> None:
    assert [Array("a", v, "").bytes for v in ([], [255, 0], [256], [65536])] == [1, 2, 2, 4]
