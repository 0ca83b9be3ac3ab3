"""Plots: every point and bar is drawn, texts are texts, nothing is measured for a plot that cannot be."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
from lxml import etree

from mcpn.answers.compare import Measured, Measurement, exponents
from mcpn.cli.line import run
from mcpn.errors import InputError, LimitError
from mcpn.report.pictures.plots import Bars, Curves, plotted, save_engines, save_plot
from tests.commands import mcpn

NET = "net n\npl p (1)\ntr t p -> q\ntr u q -> p\n"
SVG = "{http://www.w3.org/2000/svg}"
HOSTILE = "<script>$x^2$ & \x1b[31m\u202e"


def texts(picture: etree._Element) -> list[str]:
    return ["".join(map(str, text.itertext())) for text in picture.iter(f"{SVG}text")]


def test_every_point_and_every_bar_is_drawn() -> None:
    pytest.importorskip("matplotlib", reason="needs matplotlib: the extra experiments")
    curves = {"one": [(1, 0.5), (2, 0.7), (5, 0.2)], "other": [(1, 30.0)], "none": []}
    plots: list[Curves | Bars] = [
        Curves(HOSTILE, "sizes", "seconds", curves),
        Bars("megabytes", {"first": 12.5, "second": 1234}),
    ]
    found = plotted(plots, HOSTILE)
    assert found == plotted(plots, HOSTILE)
    picture = etree.fromstring(found)
    inside = [use for use in picture.iter(f"{SVG}use") if use.getparent().get("clip-path")]  # type: ignore[union-attr]
    assert len(inside) == 4
    told = texts(picture)
    assert {"sizes", "seconds", "megabytes", "one", "other", "first", "second", "12.5", "1,234"} <= {*told}
    assert "none" not in told
    assert told.count("<script>$x^2$ & \\x1b[31m\\u202e") == 2
    assert not [*picture.iter(f"{SVG}script")]


@pytest.mark.parametrize("suffix", [".svg", ".png"])
def test_engines_are_plotted(suffix: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="needs matplotlib: the extra experiments")
    (tmp_path / "n.net").write_text(NET)
    plot = tmp_path / f"n{suffix}"
    assert mcpn("compare", tmp_path / "n.net", "--plot", plot).returncode == 0
    if suffix == ".png":
        assert plot.read_bytes().startswith(b"\x89PNG")
        return
    told = texts(etree.parse(plot).getroot())
    assert {"explicit", "symbolic", "pyeda", "CPU seconds", "megabytes", "Engines on n"} <= {*told}


def test_nodes_are_plotted_with_their_order(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="needs matplotlib: the extra experiments")
    sizes = {"states": 7, "nodes": 41, "peak_nodes": 1234}
    ran = Measurement("symbolic", sizes, 1.0, 20, order="force")
    gave_up = Measurement("pyeda", None, 0.0, 20, "too large")
    save_engines(tmp_path / "p.svg", [Measured("n", 1, 1, 1, [ran, gave_up])])
    told = texts(etree.parse(tmp_path / "p.svg").getroot())
    assert {"nodes, symbolic, order force", "in the end", "41", "at the peak", "1,234"} <= {*told}
    assert "pyeda" not in told


def test_without_matplotlib_nothing_is_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "matplotlib.figure", raising=False)
    with pytest.raises(LimitError, match=r"a plot needs matplotlib: pip install 'mcpn\[experiments\]'"):
        save_plot(tmp_path / "p.svg", [Bars("seconds", {"one": 1})])
    (tmp_path / "n.net").write_text(NET)
    monkeypatch.setattr("mcpn.answers.compare.measure", lambda *_, **__: pytest.fail("measured"))
    assert run(["compare", str(tmp_path / "n.net"), "--plot", str(tmp_path / "n.svg")]) == 2
    assert "a plot needs matplotlib" in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["n.net"]


def test_other_suffixes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"found the suffix '.pdf', expected .svg or .png"):
        save_plot(tmp_path / "p.pdf", [Bars("seconds", {"one": 1})])
    assert [*tmp_path.iterdir()] == []


def member(size: int, **engines: tuple[float, int, int | None]) -> Measured:
    """A member of a family: by engine, seconds of the median run, megabytes and the peak of nodes."""
    ran = [
        Measurement(
            engine,
            {"states": 2**size, "nodes": nodes, "peak_nodes": nodes},
            seconds,
            megabytes,
            cpu_seconds=seconds / 2,
            median_cpu_seconds=seconds,
            most_cpu_seconds=2 * seconds,
            repeats=3,
        )
        for engine, (seconds, megabytes, nodes) in engines.items()
    ]
    return Measured(f"family-{size}", 1, 1, 1, ran, size)


SQUARES = [
    member(size, one=(size**2, 10 * size**3, size), other=(0.001 * size, 20, None)) for size in (4, 8, 16, 32)
]


def test_what_grows_has_the_exponent_that_it_was_made_with() -> None:
    found = exponents(SQUARES)
    assert found.keys() == {"one"}  # the other one's times are those of the clock, its memory the interpreter
    assert found["one"] == {
        k: pytest.approx(v) for k, v in (("cpu_seconds", 2), ("megabytes", 3), ("peak_nodes", 1))
    }


def test_exponents_need_three_sizes() -> None:
    assert exponents(SQUARES[:2]) == {}
    assert exponents(SQUARES[:3])["one"].keys() == {"cpu_seconds", "peak_nodes"}  # memory: two are left


def test_each_plot_of_a_family_names_its_own_exponents(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="needs matplotlib: the extra experiments")
    save_engines(tmp_path / "p.svg", SQUARES)
    picture = etree.parse(tmp_path / "p.svg").getroot()
    told = texts(picture)
    assert {"one (size^2.00)", "one (size^3.00)", "one (size^1.00)", "other"} <= {*told}
    assert {"4", "8", "16", "32"} <= {*told}  # the sizes are named, where powers of ten have no member


def test_error_bars_go_from_the_least_to_the_longest_run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    axes = pytest.importorskip("matplotlib.axes", reason="needs matplotlib: the extra experiments")
    drawn = list[tuple[Any, Any, Any]]()
    plain = axes.Axes.errorbar

    def errorbar(self: object, x: object, y: object, **how: object) -> object:
        drawn.append((x, y, how.get("yerr")))
        return plain(self, x, y, **how)

    monkeypatch.setattr(axes.Axes, "errorbar", errorbar)
    save_engines(tmp_path / "p.svg", SQUARES)
    sizes, medians, (below, above) = drawn[0]
    assert sizes == (4, 8, 16, 32)
    assert medians == (16, 64, 256, 1024)
    assert below == (8, 32, 128, 512)  # the least is half the median, the most is twice
    assert above == (16, 64, 256, 1024)
    assert all(bars is None for _, _, bars in drawn[2:])  # memory, nodes and markings have none
