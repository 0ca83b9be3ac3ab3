"""A controller's file is what was generated, or it is refused when it is loaded."""

from __future__ import annotations

import hashlib
import json
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import pytest

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller, ControllerFileError, SnapshotError
from mcpn.robot.runtime.restoring import snapshot_text
from mcpn.robot.targets.json import write_json
from tests.runtime.damage import bytes_changed, runs, signed, text_of, value_changed

WATCH = Path(__file__).parents[1] / "controller" / "watch.xml"
FORMS: tuple[Literal["hierarchical", "modular"], ...] = ("hierarchical", "modular")


@pytest.fixture(scope="module")
def watch() -> MissionNet:
    return compose(read_mission(WATCH))


@pytest.fixture(scope="module", params=FORMS)
def found(request: pytest.FixtureRequest, watch: MissionNet) -> dict[str, Any]:
    return document(generate(watch, request.param), watch)


def damaged(found: dict[str, Any], path: Path, times: int) -> None:
    """Damages a file in many ways; refused, or it says the same as before."""
    rng = random.Random(7)
    whole = json.dumps(found).encode()
    same = 0
    for number in range(times):
        text = bytes_changed(whole, rng) if number % 2 else json.dumps(value_changed(found, rng)).encode()
        path.write_bytes(text)
        try:
            Controller.load(path)
        except ControllerFileError:
            continue
        assert text_of(json.loads(text)) == text_of(found)
        same += 1
    assert same < times / 10


def test_a_damaged_file_is_refused(found: dict[str, Any], tmp_path: Path) -> None:
    damaged(found, tmp_path / "controller.json", 100)


def test_one_that_is_signed_again_is_refused_or_runs(found: dict[str, Any]) -> None:
    rng = random.Random(8)
    loaded = sum(runs(signed(value_changed(found, rng)), rng, 20) for _ in range(100))
    assert 0 < loaded < 50  # a name that is another, a state that is another: no schema knows


@pytest.mark.slow
def test_ten_thousand_damaged_files(found: dict[str, Any], tmp_path: Path) -> None:
    damaged(found, tmp_path / "controller.json", 10_000)


@pytest.mark.slow
def test_ten_thousand_that_are_signed_again(found: dict[str, Any]) -> None:
    rng = random.Random(9)
    loaded = sum(runs(signed(value_changed(found, rng)), rng, 100) for _ in range(10_000))
    print(f"{found['form']}: {loaded} of 10000 loaded")  # noqa: T201


def test_the_digest_is_that_of_the_plain_text(watch: MissionNet) -> None:
    said = json.loads(write_json(document(generate(watch), watch)))
    digest = said.pop("digest")
    text = json.dumps(said, sort_keys=True, ensure_ascii=False, separators=(",", ":"))
    assert digest == hashlib.sha256(text.encode()).hexdigest()


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda said: said["types"][0]["edges"][3].update(to=10**6), r"types\[0\]\.edges\[3\]\.to: found 1"),
        (lambda said: said.pop("hardware"), "expected the key hardware"),
        (lambda said: said["sections"][1].update(type="0"), r"sections\[1\]\.type: found \"0\""),
        (lambda said: said.update(initial="nowhere"), "initial: found 'nowhere'"),
        (lambda said: said["sections"][0]["routes"].update(success="nowhere"), r"sections\[0\]\.routes"),
        (lambda said: said.update(version=True), "version True found"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_its_place(change: Any, where: str, watch: MissionNet) -> None:
    said = json.loads(write_json(document(generate(watch), watch)))
    change(said)
    with pytest.raises(ControllerFileError, match=where):
        Controller.from_document(signed(said))


TIMED = """<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">
<activity name="a"/><activity name="b"/></robot>
<parallel name="block" timeout="9"><objective name="one" activities="a" timeout="5"/>
<objective name="other" activities="b"/></parallel></mission>"""


@pytest.mark.parametrize(("table", "name"), [("objectives", "one"), ("blocks", "block")])
def test_a_timeout_is_greater_than_zero(table: str, name: str, tmp_path: Path) -> None:
    """A timer of no time would be over before it runs."""
    (file := tmp_path / "mission.xml").write_text(TIMED)
    net = compose(read_mission(file))
    said = json.loads(write_json(document(generate(net), net)))
    for seconds in (0, 0.0, -1):
        said[table][name]["timeout"] = seconds
        with pytest.raises(ControllerFileError, match=rf"{table}.*{name}.*timeout: found .*greater than 0"):
            Controller.from_document(signed(said))
    said[table][name]["timeout"] = 1e-9
    Controller.from_document(signed(said))


def numbers_in(value: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Where numbers stand in a value."""
    if type(value) is int:
        yield path
    for key, inner in (
        value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    ):
        yield from numbers_in(inner, (*path, key))


def test_each_number_of_a_table_is_of_something_that_is_there(found: dict[str, Any]) -> None:
    """Of each kind of number the first: one that is far too large is refused, and the place is said."""
    kinds = dict[tuple[str, ...], tuple[str | int, ...]]()
    for table in ("types", "sections"):
        for path in numbers_in(found[table], (table,)):
            kinds.setdefault(tuple(key for key in path if isinstance(key, str)), path)
    assert len(kinds) >= 5
    for path in kinds.values():
        changed = json.loads(json.dumps(found))
        holder = changed
        for key in path[:-1]:
            holder = holder[key]
        holder[path[-1]] = 10**7
        with pytest.raises(ControllerFileError, match=r"(types|sections)\[\d+\].*found "):
            Controller.from_document(signed(changed))


@pytest.mark.parametrize("key", ["out_of_service", "happened"])
def test_a_snapshot_names_what_the_controller_has(key: str, found: dict[str, Any]) -> None:
    controller = Controller.from_document(found)
    snapshot = json.loads(controller.snapshot())
    controller.restore(snapshot_text(snapshot))
    with pytest.raises(SnapshotError, match="what cannot be"):
        controller.restore(snapshot_text({**snapshot, key: [*snapshot[key], "nobody"]}))


@pytest.mark.parametrize("text", ["[]", "null", "7", '"format"'])
def test_a_file_is_an_object(text: str, tmp_path: Path) -> None:
    (tmp_path / "controller.json").write_text(text)
    with pytest.raises(ControllerFileError, match=r"found .*, expected a JSON object"):
        Controller.load(tmp_path / "controller.json")


LIGHT = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <fact name="light" values="red amber green"/>
    <event name="switch"><sets fact="light" to="green"/></event>
    <event name="warn"><sets fact="light" to="amber"/></event>
    <activity name="go" requires="light=green"/>
  </robot>
  <objective name="cross" activities="go"/>
</mission>"""

LATE = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="h" detected="late"/><activity name="go" consumes="h"/></robot>
  <objective name="cross" activities="go"/>
</mission>"""


@pytest.mark.parametrize("form", FORMS)
def test_a_fact_has_one_value_in_files_and_snapshots(
    form: Literal["hierarchical", "modular"], tmp_path: Path
) -> None:
    """Each set of its flags that is not of one of its values is refused, and so are flags of no fact."""
    (tmp_path / "m.xml").write_text(LIGHT)
    net = compose(read_mission(tmp_path / "m.xml"))
    said = json.loads(write_json(document(generate(net, form), net)))
    of_values = {value: frozenset(flags) for value, flags in said["facts"]["light"].items()}
    every = sorted(frozenset().union(*of_values.values()))
    controller = Controller.from_document(said)
    snapshot = json.loads(controller.snapshot())
    for bits in range(1 << len(every)):
        true = frozenset(flag for i, flag in enumerate(every) if bits >> i & 1)
        text = snapshot_text({**snapshot, "happened": sorted(true)})
        if true in of_values.values():
            controller.restore(text)
            assert of_values[controller.facts["light"]] == true
        else:
            with pytest.raises(SnapshotError, match="what cannot be"):
                controller.restore(text)
    said["changing"]["switch"]["true"].append("light=blue")
    with pytest.raises(ControllerFileError, match=r"changing\.switch: found 'light=blue'"):
        Controller.from_document(signed(said))


def test_only_a_loss_that_has_come_is_known(tmp_path: Path) -> None:
    """Hardware in service of which a snapshot says that its loss is known, before the mission starts."""
    (tmp_path / "m.xml").write_text(LATE)
    net = compose(read_mission(tmp_path / "m.xml"))
    said = json.loads(write_json(document(generate(net, "hierarchical"), net)))
    controller = Controller.from_document(said)
    snapshot = json.loads(controller.snapshot())
    (flag,) = said["late"].values()
    for gone, known, whole in (([], [], True), (["h"], [], True), (["h"], [flag], True), ([], [flag], False)):
        text = snapshot_text({**snapshot, "out_of_service": gone, "happened": known})
        if whole:
            controller.restore(text)
            assert controller.out_of_service == {*gone}
            assert controller.unnoticed == ({*gone} if not known else set())
        else:
            with pytest.raises(SnapshotError, match="what cannot be"):
                controller.restore(text)
