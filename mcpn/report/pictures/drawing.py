"""A picture as a file: SVG, or PNG rendered from the SVG."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Any

from mcpn.errors import InputError, LimitError, Source
from mcpn.files import write_atomically
from mcpn.report.assets import environment

KNOWN = (".svg", ".png")

FAMILY = "DejaVu Sans"
"""What PNG files are drawn with, from files of the package, ticks and crosses in it. Of a family that the
machine lacks resvg draws no letter, without an error; letters that this one lacks come from the machine's."""

MOST_PIXELS = 40_000_000
"""Pixels of a PNG file: where a picture would have more at twice its size, it is made smaller."""


def needed(module: str, purpose: str, extra: str = "pictures") -> Any:
    """A module of an extra.

    Raises:
        LimitError: It is not installed.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise LimitError(f"{purpose} needs {module.split('.')[0]}: pip install 'mcpn[{extra}]'") from error


class Drawing:
    """A picture; a notebook shows it by itself.

    Args:
        name: What it shows.
        make: Draws it as an SVG text that stands alone; called when it is needed, once.
    """

    def __init__(self, name: str, make: Callable[[], str]) -> None:
        self.name = name
        self._make = make
        self._svg: str | None = None

    @property
    def svg(self) -> str:
        """The picture as an SVG text that stands alone."""
        if self._svg is None:
            self._svg = self._make()
        return self._svg

    @property
    def png(self) -> bytes:
        """The picture as a PNG file, in the colours of paper.

        Raises:
            LimitError: The extra ``pictures`` is missing.
        """
        resvg = needed("resvg_py", "a PNG file")
        width, height = (int(n) for n in _SIZE.findall(self.svg)[:2])
        zoom = min(2.0, (MOST_PIXELS / (width * height)) ** 0.5)
        fonts = {"font_family": FAMILY, "font_files": _fonts()}
        return bytes(resvg.svg_to_bytes(svg_string=self.svg, zoom=zoom, **fonts))

    def save(self, path: Path | str) -> None:
        """Writes the picture, whole or not at all.

        Raises:
            InputError: The suffix is neither ``.svg`` nor ``.png``, or the file cannot be written.
            LimitError: The extra ``pictures`` is missing.
        """
        path = Path(path)
        suffix = path.suffix.lower()
        if suffix not in KNOWN:
            expected = " or ".join(KNOWN)
            raise InputError.at(Source(str(path)), f"found the suffix {path.suffix!r}, expected {expected}")
        write_atomically(path, self.svg if suffix == ".svg" else self.png)

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"<picture of {self.name}>"


_SIZE = re.compile(r'(?:width|height)="(\d+)"')
_VARIABLE = re.compile(r"(?<![\w-])(--[\w-]+):\s*([^:;{}]+);")
_USED = re.compile(r"var\((--[\w-]+)\)")
_MEDIA = re.compile(r"@media[^{]*\{(?:[^{}]*\{[^{}]*\})*[^{}]*\}")


def on_paper(style: str) -> str:
    """A style sheet with its colours in place of custom properties, and without dark mode.

    SVG itself knows neither: librsvg, CairoSVG and Inkscape drop what uses them, and all is black.
    """
    text = _MEDIA.sub("", style)
    values = dict(_VARIABLE.findall(text))
    return _USED.sub(lambda used: values[used[1]], _VARIABLE.sub("", text))


def _fonts() -> list[str]:
    """The files of :data:`FAMILY`, regular and bold."""
    folder = files("mcpn.report") / "assets" / "fonts"
    return [str(folder / f"DejaVuSans{style}.ttf") for style in ("", "-Bold")]


def rendered(template: str, **values: object) -> str:
    """A template of a picture, filled in as a text that stands alone, in the colours of paper."""
    found = environment()
    style = on_paper(found.get_template("picture.css").render())
    return found.get_template(template).render(alone=True, style=style, prefix="", **values)
