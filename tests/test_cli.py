"""The command line, as other programs and people see it."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn._kernel import MemoryLimit
from mcpn.answers.compare import measure
from mcpn.report.comparison import table
from mcpn.testing.nets import philosophers
from tests.commands import mcpn, output
from tests.conftest import ROOT, ULYSSE
from tests.mission.test_broken import BROKEN

CONTENTION = """<mission name="m" xmlns="urn:mcpn:mission:1">
<robot name="r"><hardware name="H"/><activity name="a" consumes="H"/><activity name="b" consumes="H"/></robot>
<parallel name="p"><objective name="x" activities="a"/><objective name="y" activities="b"/></parallel>
</mission>"""


def test_check_passes_on_ulysse() -> None:
    found = output("check", ULYSSE)
    assert list(found) == [
        "mission",
        "places",
        "transitions",
        "markings",
        "alternatives",
        "requirements",
        "verdicts",
        "undecided",
        "claims",
        "runs",
        "warnings",
        "witnesses",
        "ignored",
        "late",
        "nominal",
        "engine",
        "why",
        "seconds",
    ]
    assert (found["mission"], found["places"], found["transitions"]) == ("ulysse", 133, 150)
    assert found["markings"] == {"states": None, "edges": None}  # which are not listed
    assert found["alternatives"] == {"states": 260, "edges": 1332}
    assert found["verdicts"] == {
        "nominal_success": True,
        "safe": True,
        "bounded": True,
        "confluent": True,
        "deadlock_free": True,
        "success_reachable": True,
        "can_always_finish": True,
        "failure_reachable": True,
        "unselectable": False,
    }


def test_check_for_a_person_says_sizes_verdicts_runs_and_modes() -> None:
    run = mcpn("check", ULYSSE)
    assert run.returncode == 0
    for words in (
        "133 places; 150 transitions; 260 stable states, 1332 event edges",
        "can_always_finish",
        "objective transect.going_up succeeds: the mission ends in success",
        "localisation: imu_localisation",
        "all required verdicts hold",
    ):
        assert words in run.stdout


def test_a_verdict_that_fails_exits_with_1(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(CONTENTION)
    found = output("check", path, code=1)
    assert found["verdicts"]["confluent"] is False
    assert found["witnesses"]["confluent"] == [["MISSION_EV_START"]]
    inside = output("check", path, "--internal", code=1)["witnesses"]["confluent"]
    assert [run[0] for run in inside] == ["MISSION_EV_START"] * 2
    assert inside[0] != inside[1]
    assert found["alternatives"] == {"states": None, "edges": None}
    run = mcpn("check", path)
    assert run.returncode == 1
    assert "m.xml:3: a and b, both in parallel block p, both need H" in run.stderr
    assert "both in parallel block p, ask for H at the same moment" in run.stdout
    assert "internal" not in run.stdout
    assert mcpn("alternatives", path).returncode == 1
    controller = mcpn("controller", path, "-o", tmp_path / "out")
    assert controller.returncode == 1
    assert "Traceback" not in controller.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("engine", ["explicit", "symbolic"])
def test_states_of_ulysse(engine: str) -> None:
    found = output("states", ULYSSE, "--engine", engine)
    assert found.pop("seconds") > 0
    nodes, peak = found.pop("nodes"), found.pop("peak_nodes")
    assert (nodes is None, peak is None) == (engine == "explicit",) * 2
    assert engine == "explicit" or peak >= nodes > 0
    assert (found.pop("order") is None) == (engine == "explicit")
    assert found == {
        "places": 133,
        "transitions": 150,
        "states": 44299,
        "edges": 124078,
        "stable_states": 260,
        "dead_states": 0,
        "max_tokens": 25,  # the two engines share no code and agree
        "max_tokens_in_place": 1,
        "engine": engine,
        "why": None,
    }


@pytest.mark.parametrize(
    ("options", "method"),
    [
        (["--method", "direct"], "direct"),
        (["--method", "reduction"], "reduction"),
        (["--no-proof"], "direct"),
        (["--engine", "explicit"], "direct"),
        (["--engine", "symbolic"], "symbolic"),
        (["--engine", "local"], "local"),
    ],
)
def test_alternatives_of_ulysse(options: list[str], method: str) -> None:
    found = output("alternatives", ULYSSE, *options)
    assert found.pop("seconds") > 0
    engine = method if method in ("symbolic", "local") else "explicit"
    counts = {"states": 260, "edges": 1332, "events": 21}
    assert found == {**counts, "method": method, "engine": engine, "why": None}


def test_the_engine_is_chosen_and_told() -> None:
    small = "the stable states are few"
    for command in (["check"], ["alternatives"], ["causes"], ["ask", "EF success"], ["states"]):
        name, *rest = command
        found = output(name, ULYSSE, *rest)
        told = found[0] if isinstance(found, list) else found
        assert (told["engine"], told["why"]) == ("explicit", small)
        assert small in mcpn(name, ULYSSE, *rest).stdout
    for command in (["states"], ["ask", "EF success"]):
        name, *rest = command
        rest += ["--on", "markings"]
        found = output(name, ULYSSE, *rest)
        assert (found[0] if isinstance(found, list) else found)["engine"] == "symbolic"
        assert "a diagram holds all markings" in mcpn(name, ULYSSE, *rest).stdout
    limited = output("check", ULYSSE, "--max-states", 100)
    assert (limited["engine"], limited["markings"]) == ("local", {"states": None, "edges": None})
    assert limited["why"].startswith("there are more than 100 stable states")
    assert limited["alternatives"] == {"states": 260, "edges": 1332}
    assert output("check", ULYSSE, "--engine", "local")["why"] is None
    for options in (["--engine", "local", "--method", "direct"], ["--engine", "symbolic", "--no-proof"]):
        assert mcpn("alternatives", ULYSSE, *options).returncode == 2


@pytest.mark.parametrize("suffix", ["json", "graphml", "aut", "dot"])
def test_alternatives_are_written(suffix: str, tmp_path: Path) -> None:
    import networkx as nx

    path = tmp_path / f"a.{suffix}"
    assert mcpn("alternatives", ULYSSE, "-o", path).returncode == 0
    text = path.read_text()
    if suffix == "json":
        document = json.loads(text)
        assert (len(document["states"]), len(document["edges"])) == (260, 1332)
    elif suffix == "graphml":
        graph = nx.read_graphml(path, force_multigraph=True)
        assert (graph.number_of_nodes(), graph.number_of_edges()) == (260, 1332)
        keys = re.findall(r'<key id="(\w+)".* attr\.name="(\w+)"', text)
        assert sorted(keys) == [("event", "event"), ("label", "label")]  # some tools show a key's id
    elif suffix == "aut":
        assert text.splitlines()[0] == "des (0, 1332, 260)"
        assert len(text.splitlines()) == 1333
    else:
        assert text.count(" -> ") == 1332
    assert mcpn("alternatives", ULYSSE, "-o", tmp_path / "a.txt").returncode == 2


def test_the_controller_is_written(tmp_path: Path) -> None:
    run = mcpn("controller", ULYSSE, "--target", "json", "--flat", "-o", tmp_path / "out")
    assert run.returncode == 0
    document = json.loads((tmp_path / "out" / "controller.json").read_text())
    (machine,) = document["types"]
    # Of 260 stable markings 8 are before the start and 16 after the end, one for each state of the hardware.
    assert (len(machine["states"]), len(machine["entries"])) == (236, 8)
    assert len(machine["edges"]) == 1332 - 8 - 3 * 24


def test_conversions_keep_the_graph(tmp_path: Path) -> None:
    source: Path = ULYSSE
    for suffix in (".net", ".pnml", ".json"):
        target = tmp_path / f"u{suffix}"
        run = mcpn("convert", source, target)
        assert run.returncode == 0
        assert ("no priorities" in run.stderr) == (suffix == ".pnml")
        source = target
    found = output("states", source)
    assert (found["states"], found["edges"], found["stable_states"]) == (44299, 124078, 260)
    assert mcpn("convert", ULYSSE, tmp_path / "u.dot").returncode == 0
    assert (tmp_path / "u.dot").read_text().startswith("digraph")


def test_engines_are_compared(tmp_path: Path) -> None:
    lines = ["net n", *(f"pl a{i} (1)\ntr t{i} a{i} -> b{i}\ntr u{i} b{i} -> a{i}" for i in range(8))]
    (tmp_path / "n.net").write_text("\n".join(lines) + "\n")
    run = mcpn("compare", tmp_path / "n.net")
    assert run.returncode == 0
    for engine in ("explicit", "symbolic", "pyeda"):
        (row,) = [line for line in run.stdout.splitlines() if f" {engine} " in line]
        assert " 256 " in row  # 2^8 states
        assert " 2048 " in row  # 8 * 2^8 edges
    first, *_ = run.stdout.splitlines()
    assert first.split()[-3:] == ["nodes", "peak", "order"]
    told = mcpn("compare", ULYSSE, "--seconds", "0.001").stdout
    assert re.search(
        r"^pyeda: pyeda holds \d+ nodes after 0 s of CPU time: the limit is 0.001 s$", told, re.M
    )
    for engine in ("explicit", "symbolic", "local"):
        (row,) = [line for line in told.splitlines() if f" {engine} " in line]
        assert " 260 " in row  # stable states, Table 1 of the paper


CLASH = """
<mission name="clash" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="h"/>
<activity name="a"><alternative name="a1" consumes="h"/></activity>
<activity name="b"><alternative name="b1" consumes="h"/></activity></robot>
<parallel name="p">
<objective name="x" activities="a"/><objective name="y" activities="b"/>
</parallel></mission>
"""


def test_an_engine_that_cannot_answer_says_why_in_its_row(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(CLASH.strip())
    run = mcpn("compare", tmp_path / "m.xml", "--format", "csv")
    assert run.returncode == 0, run.stderr
    comment, *lines = run.stdout.splitlines()
    assert comment.startswith("# processor ")
    rows = {row["engine"]: row for row in csv.DictReader(lines)}
    assert "not confluent" in rows["local"]["reason"]
    assert len({rows[engine]["states"] for engine in ("explicit", "symbolic", "pyeda")}) == 1


def test_a_family_grows_and_an_engine_that_gave_up_is_asked_no_more(tmp_path: Path) -> None:
    arguments = ("compare", "--family", "philosophers", "2..4", "--repeat", "2", "--max-states", "100")
    found = output(*arguments)
    assert [member["size"] for member in found["members"]] == [2, 3, 4]
    by_engine = [{m["engine"]: m for m in member["engines"]} for member in found["members"]]
    # Lucas numbers: see mcpn.testing.nets.
    assert [of["symbolic"]["sizes"]["states"] for of in by_engine] == [18, 76, 322]
    assert [of["explicit"]["sizes"] is None for of in by_engine] == [False, False, True]
    assert by_engine[0]["pyeda"]["repeats"] == 2
    told = mcpn(*arguments, "--format", "latex").stdout
    assert told.count(r"\\") == 1 + 3 * 3
    assert "% philosophers-4, explicit: more than 100 " in told
    assert "; runs of each: 2;" in told.splitlines()[0]
    (heads,) = (line for line in told.splitlines() if line.startswith("name & "))
    assert "median cpu seconds" in heads
    assert heads.endswith(r"peak nodes & order \\")
    assert mcpn("compare", "--family", "philosophers", "2..2", "--seconds", "nan").returncode == 2
    for wrong in (
        ("lions", "1..2"),
        ("philosophers", "1..2"),
        ("philosophers", "5..4"),
        ("philosophers", "x"),
    ):
        assert mcpn("compare", "--family", *wrong).returncode == 2


def test_an_engine_of_one_s_own_runs_beside_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "n.net").write_text(
        "net n\n" + "".join(f"pl a{i} (1)\ntr t{i} a{i} -> b{i}\n" for i in range(4))
    )
    (tmp_path / "own_engines.py").write_text((ROOT / "tests" / "spaces" / "plain.py").read_text())
    monkeypatch.chdir(tmp_path)
    found = output("compare", "n.net", "--engine", "own_engines:PlainSets", "--engine", "own_engines:Raising")
    by_engine = {m["engine"]: m for m in found["engines"]}
    assert by_engine["own_engines:PlainSets"]["sizes"]["states"] == 16
    assert by_engine["own_engines:Raising"]["reason"] == "its code raised ZeroDivisionError: of one's own"
    wrong = mcpn("compare", "n.net", "--engine", "own_engines:Wrong")
    assert wrong.returncode == 1
    assert "the engines disagree on states, one of them is wrong" in wrong.stderr
    for name, told in (
        ("own_engines:Nothing", "cannot be loaded: AttributeError"),
        ("own_engines:Set", "found no single, moved, minus, count; expected a class with the methods"),
        ("own_engines", "found the engine 'own_engines', expected MODULE:CLASS"),
    ):
        refused = mcpn("compare", "n.net", "--engine", name)
        assert refused.returncode == 2
        assert told in refused.stderr


def test_memory_is_that_of_the_engine_and_not_of_who_asks() -> None:
    held = bytearray(300 << 20)
    found = {m.engine: m.megabytes or 0 for m in measure(philosophers(2)).engines}
    assert len(held) >> 20 == 300
    assert 5 < min(found.values()) <= max(found.values()) < 150, found


def test_an_engine_that_is_not_asked_takes_nothing() -> None:
    found = measure(philosophers(2), without={"pyeda": "gave up at size 1"})
    by_engine = {m.engine: m for m in found.engines}
    assert (by_engine["pyeda"].megabytes, by_engine["pyeda"].sizes) == (None, None)
    comment, *lines = table([found], "csv").splitlines()
    (row,) = (row for row in csv.DictReader(lines) if row["engine"] == "pyeda")
    assert (row["megabytes"], row["cpu_seconds"], row["reason"]) == ("", "", "gave up at size 1")
    told = table([found], "latex")
    assert comment.startswith("# processor ")
    assert "% philosophers-2, pyeda: gave up at size 1" in told
    assert "median" not in told  # each ran once, so that the median says nothing more


def test_engines_that_disagree_are_a_loud_error() -> None:
    from mcpn.answers.compare import SIZES, Measurement, disagreement

    one: dict[str, int | None] = {**dict.fromkeys(SIZES, 7), "states": 10}
    silent: dict[str, int | None] = {**dict.fromkeys(SIZES), "stable_states": 7}
    found = [Measurement(engine, sizes, 1.0, 1) for engine, sizes in (("explicit", one), ("local", silent))]
    assert disagreement(found) is None  # what an engine does not count is no disagreement
    found.append(Measurement("symbolic", {**one, "states": 11}, 1.0, 1))
    assert "disagree on states, one of them is wrong: explicit: 10, symbolic: 11" in str(disagreement(found))


def test_an_unbounded_net_is_told_by_the_engine_that_finds_it(tmp_path: Path) -> None:
    (tmp_path / "n.net").write_text("net n\npl p (1)\ntr t p -> p q\n")
    run = mcpn("compare", tmp_path / "n.net")
    assert run.returncode == 1
    assert "unbounded: q can hold any number of tokens" in run.stderr
    assert "Traceback" not in run.stderr


def test_foreign_nets_have_no_stable_states(tmp_path: Path) -> None:
    (tmp_path / "n.net").write_text("net n\npl p (1)\ntr t p -> q\ntr u q -> p\n")
    found = output("states", tmp_path / "n.net")
    assert (found["states"], found["edges"], found["stable_states"], found["max_tokens"]) == (2, 2, None, 1)


def test_an_unbounded_net_names_the_firings_that_can_be_repeated(tmp_path: Path) -> None:
    (tmp_path / "n.net").write_text("net n\npl p (1)\ntr t p -> p q\n")
    run = mcpn("states", tmp_path / "n.net")
    assert run.returncode == 1
    assert "q can hold any number of tokens: after 0 firings, t can be repeated for ever" in run.stderr
    assert "run 1: t" in run.stderr


@pytest.mark.parametrize("name", list(BROKEN))
def test_bad_input_exits_with_2_and_writes_nothing(name: str, tmp_path: Path) -> None:
    text, line, _ = BROKEN[name]
    path = tmp_path / "m.xml"
    path.write_text(text)
    for arguments in (["check", path], ["controller", path, "-o", tmp_path / "out"]):
        run = mcpn(*arguments)
        assert run.returncode == 2
        assert f"error: {path}:{line}: " in run.stderr
        assert "Traceback" not in run.stderr
        assert run.stdout == ""
    run = mcpn("check", path, "--json")
    assert (run.returncode, run.stdout) == (2, "")
    assert list(tmp_path.iterdir()) == [path]


def test_limits_exit_with_2() -> None:
    run = mcpn("states", ULYSSE, "--engine", "explicit", "--max-states", 1000)
    assert run.returncode == 2
    assert "more than 1000 states" in run.stderr


def test_wrong_usage_exits_with_2(tmp_path: Path) -> None:
    for arguments in (
        ["check"],
        ["fly", ULYSSE],
        ["states", tmp_path / "no.xml"],
        ["convert", ULYSSE, "x.txt"],
        ["check", ULYSSE, "--jobs", 2**31],
    ):
        run = mcpn(*arguments)
        assert run.returncode == 2
        assert run.stderr
        assert "Traceback" not in run.stderr


def test_output_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    run = mcpn("controller", ULYSSE, "-o", tmp_path / "file" / "out")
    assert run.returncode == 2
    run = mcpn("convert", ULYSSE, tmp_path / "missing" / "u.net")
    assert run.returncode == 2
    assert "cannot be written" in run.stderr


def test_help_and_version_answer() -> None:
    assert "check" in mcpn("--help").stdout
    assert mcpn("--version").stdout.startswith("mcpn, version ")


@given(st.binary(max_size=200))
def test_no_bytes_make_a_mission_crash(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    from mcpn.errors import McpnError
    from mcpn.mission.xml import read_mission

    path = tmp_path_factory.mktemp("bytes") / "m.xml"
    path.write_bytes(data)
    with pytest.raises(McpnError):
        read_mission(path)


def test_an_order_is_saved_and_read_again(tmp_path: Path) -> None:
    order = tmp_path / "ulysse.order"
    raced = mcpn("states", ULYSSE, "--engine", "symbolic", "--save-order", order, "--json")
    given = mcpn("states", ULYSSE, "--engine", "symbolic", "--order", order, "--json")
    first, second = json.loads(raced.stdout), json.loads(given.stdout)
    assert first["states"] == second["states"] == 44299
    assert first["nodes"] == second["nodes"]
    assert second["order"] == "given"
    lines = order.read_text().splitlines()
    order.write_text("\n".join([*lines[:-2], lines[1], "nowhere"]))
    wrong = mcpn("states", ULYSSE, "--engine", "symbolic", "--order", order)
    assert wrong.returncode == 2
    assert "again, after line 2" in wrong.stderr
    assert f"{order}:{len(lines)}: found 'nowhere', expected a place of the net" in wrong.stderr
    assert "places are missing" in wrong.stderr
    assert mcpn("states", ULYSSE, "--engine", "explicit", "--order", order).returncode == 2
    seeded = json.loads(mcpn("states", ULYSSE, "--engine", "symbolic", "--seed", 3, "--json").stdout)
    assert seeded["states"] == 44299


def test_formulas_are_answered(tmp_path: Path) -> None:
    scn = tmp_path / "run.scn"
    run = mcpn("ask", ULYSSE, "EF failure", "--on", "alternatives", "--scn", scn, "--json")
    (answer,) = json.loads(run.stdout)
    assert run.returncode == 0
    assert answer["holds"] is True
    assert answer["witness"]["events"][0] == "MISSION_EV_START"
    assert [line.strip("{}") for line in scn.read_text().splitlines()] == answer["witness"]["firings"]
    failing = mcpn("ask", ULYSSE, "AF (success | failure)")
    assert failing.returncode == 1
    assert "for ever: GPS_sensor_EV_OOS GPS_sensor_EV_RD" in failing.stdout
    assert mcpn("ask", ULYSSE, "AF (success | failure)", "--fair", "progress").returncode == 0
    wrong = mcpn("ask", ULYSSE, "AG EF sucess(")
    assert wrong.returncode == 2
    assert "column 7: no word is named sucess; did you mean success?" in wrong.stderr
    assert "Traceback" not in wrong.stderr
    assert mcpn("ctl", ULYSSE, "EF failure").stdout == mcpn("ask", ULYSSE, "EF failure").stdout


def test_words_are_listed_where_no_formula_is_asked(tmp_path: Path) -> None:
    told = mcpn("ask", ULYSSE).stdout
    assert "hardware: oos(x) is out of service, available(x)\n  GPS_sensor" in told
    assert "  localisation: one of gps_localisation, imu_localisation" in told
    assert "  OBJ_transect.diving_EV_OK" in told
    net = tmp_path / "net.net"
    assert mcpn("convert", ULYSSE, net).returncode == 0
    of_net = mcpn("ask", net)
    assert of_net.returncode == 2
    assert "is needed to ask about a net" in of_net.stderr


def test_property_files_are_answered_as_the_contest_does(mcc: Path) -> None:
    folder = mcc / "Eratosthenes-PT-010"
    run = mcpn(
        "ask", folder / "model.pnml", "--properties", folder / "UpperBounds.xml", "--examination", "Liveness"
    )
    assert run.returncode == 0
    *answers, last = run.stdout.splitlines()
    assert last == "FORMULA Eratosthenes-PT-010-Liveness FALSE TECHNIQUES DECISION_DIAGRAMS"
    names = [f"Eratosthenes-PT-010-UpperBounds-{number:02}" for number in range(16)]
    assert [line.split()[1] for line in answers] == names  # in the order of the file
    wrong = mcpn("ask", folder / "model.pnml", "--properties", folder / "model.pnml")
    assert wrong.returncode == 2
    assert "expected <property-set>" in wrong.stderr


def test_nets_from_elsewhere_are_checked(tmp_path: Path) -> None:
    net = tmp_path / "buffer.net"
    net.write_text("net buffer\npl ready (1)\ntr make ready -> ready full\n")
    run = mcpn("check", net)
    assert run.returncode == 0
    assert "bounded         no" in run.stdout
    assert "repeat: make" in run.stdout
    found = json.loads(mcpn("check", net, "--json").stdout)
    assert found["bounded"] is False
    assert found["unbounded_by"] == {"run": [], "repeat": ["make"]}
    net.write_text("net lamp\npl off (1)\ntr press off -> on\ntr again on -> off\n")
    structure = json.loads(mcpn("check", net, "--structure", "--json").stdout)
    assert structure["p_semiflows"] == [{"off": 1, "on": 1}]
    assert any(sentence.startswith("live") for sentence in structure["proves"])
    behaviour = json.loads(mcpn("check", net, "--json").stdout)
    assert (behaviour["live"], behaviour["reversible"], behaviour["home_markings"]) == (True, True, 2)


@pytest.mark.parametrize("engine", ["symbolic", "local"])
def test_a_mission_is_checked_by_every_engine(engine: str) -> None:
    found = json.loads(mcpn("check", ULYSSE, "--engine", engine, "--json").stdout)
    assert found["alternatives"] == {"states": 260, "edges": 1332}
    assert found["engine"] == engine


def test_a_section_with_much_hardware_is_checked_locally(tmp_path: Path) -> None:
    file = tmp_path / "ladder.xml"
    count = 24
    hardware = "".join(f'<hardware name="h{i}"/>' for i in range(count))
    ways = "".join(f'<alternative name="w{i}" consumes="h{i}"/>' for i in range(count))
    file.write_text(
        f'<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">{hardware}<activity name="a">{ways}'
        '</activity></robot><objective name="o" activities="a"/></mission>'
    )
    found = output("check", file, "--engine", "local")
    # Before and after either end all states of the hardware; inside, each with the activity refused, and each
    # with one of the resources in service held: half of them on average.
    assert found["alternatives"]["states"] == (4 + count // 2) << count
    assert all(found["verdicts"][name] for name in ("confluent", "can_always_finish", "failure_reachable"))
    assert found["witnesses"]["failure_reachable"] == [["MISSION_EV_START", "OBJ_o_EV_FAIL"]]


def test_markings_are_counted_beside_local_spaces_where_asked_for() -> None:
    local, symbolic = (
        output("states", ULYSSE, "--engine", "local"),
        output("states", ULYSSE, "--engine", "symbolic"),
    )
    asked = output("states", ULYSSE, "--engine", "local", "--on", "markings")
    counted = ("states", "edges", "dead_states", "max_tokens")
    assert {name: local[name] for name in counted} == dict.fromkeys(counted)
    assert {name: asked[name] for name in counted} == {name: symbolic[name] for name in counted}
    assert local["stable_states"] == asked["stable_states"] == symbolic["stable_states"] == 260
    for engine in ("auto", "explicit", "symbolic"):
        stable = output("states", ULYSSE, "--engine", engine, "--on", "alternatives")
        assert {name: stable[name] for name in (*counted, "stable_states")} == {
            **dict.fromkeys(counted),
            "stable_states": 260,
        }


def test_a_large_mission_is_asked_for_its_stable_states() -> None:
    """The limit stands for a mission that is large: more states than are listed without being asked for."""
    for limit, engine in ((1000, "explicit"), (100, "local")):
        found = output("states", ULYSSE, "--max-states", limit)
        assert (found["engine"], found["states"], found["stable_states"]) == (engine, None, 260)
    assert found["why"].startswith("there are more than 100 stable states")
    found = output("states", ULYSSE, "--max-states", 1000, "--on", "markings")
    assert (found["engine"], found["states"], found["stable_states"]) == ("symbolic", 44299, 260)
    (answer,) = output("ask", ULYSSE, "AG EF (success | failure)", "--max-states", 100)
    assert (answer["engine"], answer["holds"]) == ("local", True)
    (answer,) = output("ask", ULYSSE, "AG EF (success | failure)", "--engine", "local")
    assert (answer["engine"], answer["why"], answer["holds"]) == ("local", None, True)


def test_a_mission_that_is_not_confluent_has_markings(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    hardware = "".join(f'<hardware name="h{i}"/>' for i in range(17))
    path.write_text(
        f"""<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">{hardware}
<activity name="a" consumes="h0"/><activity name="b" consumes="h0"/></robot>
<parallel name="p"><objective name="x" activities="a"/><objective name="y" activities="b"/></parallel>
</mission>"""
    )
    found = output("states", path)
    assert found["engine"] == "symbolic"
    assert "local gives no answer: not confluent" in found["why"]
    assert found["states"] > found["stable_states"] > 2**17
    assert output("states", path, "--on", "alternatives", code=1)["error"] == "nonconfluent"
    assert output("ask", path, "EF success", code=1)["error"] == "nonconfluent"
    assert output("ask", path, "EF success", "--on", "markings")[0]["holds"]


def test_memory_that_runs_out_is_an_error_that_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing_left(*_: object, **__: object) -> None:
        raise MemoryLimit("the store's memory limit of 1 bytes was hit at 0 nodes")

    monkeypatch.setattr("mcpn.spaces.sizes.summarise", nothing_left)
    run = mcpn("states", ULYSSE)
    assert run.returncode == 2
    assert run.stderr.startswith("error: out of memory: the store's memory limit of 1 bytes")


def test_a_controller_in_two_levels_is_the_default(tmp_path: Path) -> None:
    run = mcpn("controller", ULYSSE, "-o", tmp_path)
    assert "5 sections of 2 types" in run.stdout
    document = json.loads((tmp_path / "controller.json").read_text())
    assert (document["format"], document["version"]) == ("mcpn-controller", 1)
    assert (len(document["sections"]), len(document["types"])) == (5, 2)


def test_a_controller_that_is_too_large_is_told_by_its_size(tmp_path: Path) -> None:
    run = mcpn("controller", ULYSSE, "--hierarchical", "-o", tmp_path / "out", "--max-states", 10)
    assert run.returncode == 2
    assert "section coral_head.manual_moving has 36 states" in run.stderr  # 12 inside, 8 before, 16 after
    assert not (tmp_path / "out").exists()
    run = mcpn("controller", ULYSSE, "--flat", "-o", tmp_path / "out", "--max-states", 7)
    assert "2^3 states" in run.stderr
