"""Plots of measurements, drawn by matplotlib: curves that grow, bars side by side.

Curves differ by marker as well as by colour; a scale with far-apart numbers is logarithmic. Texts stay texts:
a name is neither markup nor a formula, and a reader of the file finds it.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcpn.errors import InputError, Source
from mcpn.files import write_atomically
from mcpn.report.pictures.drawing import KNOWN, needed
from mcpn.report.terminal import plain

if TYPE_CHECKING:
    from mcpn.answers.compare import Measured

FAR_APART = 20
"""Ratio of the largest to the smallest number from which on a scale is logarithmic."""

_WIDTH, _HEIGHT = 4.8, 3.8
_PER_ROW = 3
_MOST_LABELS = 8
_MOST_TICKS = 5
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")  # Okabe and Ito
_MARKERS = "osD^vPX"
_STYLE = {"svg.fonttype": "none", "svg.hashsalt": "mcpn"}


@dataclass(frozen=True)
class Curves:
    """A plot of curves.

    Args:
        title: What it shows.
        across: What its horizontal axis says, with the unit.
        up: The same of its vertical axis.
        curves: Points by the name of the curve; one without points is left out.
        bars: By the name of the curve, error bars: for each point, the least and the most.
        logarithmic: Whether both scales are, whatever the numbers: a power of the size is a line there.
    """

    title: str
    across: str
    up: str
    curves: Mapping[str, Sequence[tuple[float, float]]]
    bars: Mapping[str, Sequence[tuple[float, float]]] = field(default_factory=dict)
    logarithmic: bool = False


@dataclass(frozen=True)
class Bars:
    """A plot of bars, each with its number beside it.

    Args:
        title: What it shows, with the unit.
        bars: Numbers by the name of the bar, from the top down.
    """

    title: str
    bars: Mapping[str, float]


def ready(path: Path) -> None:
    """Sees that a plot can be drawn, before long work for it begins.

    Raises:
        InputError: The suffix is neither ``.svg`` nor ``.png``.
        LimitError: matplotlib is not installed.
    """
    if path.suffix.lower() not in KNOWN:
        expected = " or ".join(KNOWN)
        raise InputError.at(Source(str(path)), f"found the suffix {path.suffix!r}, expected {expected}")
    _matplotlib()


def save_plot(path: Path, plots: Sequence[Curves | Bars], title: str = "") -> None:
    """Writes plots to one file, whole or not at all.

    Args:
        path: Where, ``.svg`` or ``.png``.
        plots: At least one.
        title: Stands above them.

    Raises:
        InputError: The suffix is another, or the file cannot be written.
        LimitError: matplotlib is not installed.
    """
    ready(path)
    write_atomically(path, plotted(plots, title, path.suffix.lower().removeprefix(".")))


def save_engines(path: Path, members: Sequence[Measured]) -> None:
    """Plots engines side by side: seconds, memory, and the nodes of diagrams with their order of places.

    Args:
        path: Where, ``.svg`` or ``.png``.
        members: One subject, whose engines are bars; or a family, whose engines are curves over its sizes,
            the median of CPU time with error bars from the least to the longest run, and the fitted exponent
            of each curve in its legend. Engines that gave up are left out.

    Raises:
        InputError: The suffix is another, or the file cannot be written.
        LimitError: matplotlib is not installed.
    """
    if len(members) > 1:
        save_plot(path, _growth(members), f"Engines on {members[0].name} to {members[-1].name}")
        return
    (member,) = members
    ran = {m.engine: m for m in member.engines if m.sizes is not None}
    bars = [
        Bars("CPU seconds", {engine: m.cpu_seconds for engine, m in ran.items()}),
        Bars("megabytes", {engine: m.megabytes for engine, m in ran.items() if m.megabytes is not None}),
    ]
    for engine, m in ran.items():
        nodes, peak = ((m.sizes or {}).get(name) for name in ("nodes", "peak_nodes"))
        if nodes is not None and peak is not None:
            bars.append(Bars(f"nodes, {engine}, order {m.order}", {"in the end": nodes, "at the peak": peak}))
    save_plot(path, bars, f"Engines on {member.name}")


def _growth(members: Sequence[Measured]) -> list[Curves]:
    from mcpn.answers.compare import GROWING, exponents, grows

    slopes = exponents(members)
    engines = dict.fromkeys(m.engine for member in members for m in member.engines)
    ran = {
        engine: [
            (member.size or 0, m)
            for member in members
            for m in member.engines
            if m.engine == engine and m.sizes
        ]
        for engine in engines
    }

    def named(engine: str, what: str) -> str:
        slope = slopes.get(engine, {}).get(what)
        return engine if slope is None else f"{engine} (size^{slope:.2f})"

    def grown(what: str, title: str, unit: str, bars: bool = False) -> Curves:
        curves, spans = dict[str, list[tuple[float, float]]](), dict[str, list[tuple[float, float]]]()
        for engine, runs in ran.items():
            name = named(engine, what)
            curves[name] = [(size, took[what]) for size, m in runs if what in (took := grows(m))]
            spans[name] = [(m.cpu_seconds, m.most_cpu_seconds) for _, m in runs if bars]
        return Curves(title, "size", unit, curves, spans, logarithmic=True)

    # Engines agree on markings, so that one curve is enough.
    counted = {
        size: states for runs in ran.values() for size, m in runs if (states := (m.sizes or {}).get("states"))
    }
    return [
        grown("cpu_seconds", f"{GROWING['cpu_seconds']}, median; bars: least to most", "seconds", bars=True),
        grown("megabytes", GROWING["megabytes"], "megabytes"),
        grown("peak_nodes", GROWING["peak_nodes"], "nodes"),
        Curves("markings", "size", "markings", {"markings": sorted(counted.items())}, logarithmic=True),
    ]


def plotted(plots: Sequence[Curves | Bars], title: str = "", form: str = "svg") -> bytes:
    """Plots as the bytes of a file, the same for the same numbers.

    Raises:
        LimitError: matplotlib is not installed.
    """
    matplotlib = _matplotlib()
    columns = 2 if len(plots) == 4 else min(len(plots), _PER_ROW)
    rows = -(-len(plots) // columns)
    file = BytesIO()
    with matplotlib.rc_context(_STYLE), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a letter that its font lacks: the reader's has it
        figure = matplotlib.figure.Figure(figsize=(_WIDTH * columns, _HEIGHT * rows), layout="constrained")
        if title:
            figure.suptitle(plain(title), parse_math=False)
        for number, plot in enumerate(plots):
            axes = figure.add_subplot(rows, columns, number + 1)
            axes.set_title(plain(plot.title), parse_math=False, fontsize="medium")
            if isinstance(plot, Curves):
                _draw_curves(axes, plot)
            else:
                _draw_bars(axes, plot)
        figure.savefig(file, format=form, metadata={"Date": None} if form == "svg" else None)
    return file.getvalue()


def _matplotlib() -> Any:
    needed("matplotlib.figure", "a plot", "experiments")
    return needed("matplotlib", "a plot", "experiments")


def _draw_curves(axes: Any, plot: Curves) -> None:
    for number, (name, points) in enumerate(plot.curves.items()):  # of the same look in each plot
        if not points:
            continue
        across, up = zip(*points, strict=True)
        spans = [(y - low, high - y) for y, (low, high) in zip(up, plot.bars.get(name, ()), strict=False)]
        axes.errorbar(
            across,
            up,
            yerr=list(zip(*spans, strict=True)) or None,
            capsize=3,
            marker=_MARKERS[number % len(_MARKERS)],
            color=_COLOURS[number % len(_COLOURS)],
            label=plain(name),
        )
    every = [point for points in plot.curves.values() for point in points]
    if plot.logarithmic and every and min(min(point) for point in every) > 0:
        axes.set_xscale("log")
        axes.set_yscale("log")
        _label_sizes(axes, sorted({x for x, _ in every}))
        if max(y for _, y in every) < 10 * min(y for _, y in every):  # no power of ten to read it by
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_formatter("{x:g}")
    elif _far_apart(x for x, _ in every):
        axes.set_xscale("log")
    elif all(isinstance(x, int) for x, _ in every):
        axes.xaxis.get_major_locator().set_params(integer=True)
    if not plot.logarithmic and _far_apart(y for _, y in every):
        axes.set_yscale("log")
    axes.set_xlabel(plain(plot.across), parse_math=False)
    axes.set_ylabel(plain(plot.up), parse_math=False)
    axes.grid(alpha=0.3)
    if every:
        axes.legend()


def _label_sizes(axes: Any, sizes: Sequence[float]) -> None:
    """Labels sizes themselves, not powers of ten, of which few members may have one.

    The first, the last, and those between that stand apart on the logarithmic scale.
    """
    apart = (sizes[-1] / sizes[0]) ** (1 / _MOST_LABELS)
    shown = [sizes[0]]
    shown += [s for s in sizes[1:-1] if s >= shown[-1] * apart and s * apart <= sizes[-1]]
    shown += sizes[-1:] if len(sizes) > 1 else []
    axes.set_xticks(shown, labels=[f"{size:g}" for size in shown])
    axes.tick_params(axis="x", which="minor", bottom=False, labelbottom=False)


def _draw_bars(axes: Any, plot: Bars) -> None:
    values = list(plot.bars.values())
    bars = axes.barh([plain(name) for name in plot.bars], values, color=_COLOURS[0])
    axes.bar_label(bars, [f"{value:.3g}" if value < 100 else f"{value:,.0f}" for value in values], padding=3)
    if _far_apart(values):
        axes.set_xscale("log")
    else:
        axes.xaxis.get_major_locator().set_params(nbins=_MOST_TICKS)
    axes.margins(x=0.2)
    axes.invert_yaxis()


def _far_apart(values: Iterable[float]) -> bool:
    rest = list(values)
    return bool(rest) and min(rest) > 0 and max(rest) > FAR_APART * min(rest)
