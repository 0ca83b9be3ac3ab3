"""A picture as a file: SVG, or PNG rendered from the SVG."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from mcpn.errors import InputError, LimitError, Source
from mcpn.files import write_atomically
from mcpn.report.assets import environment

KNOWN = (".svg", ".png")

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
            LimitError: The extra ``pictures`` or a font is missing.
        """
        resvg = needed("resvg_py", "a PNG file")
        text = _on_paper(self.svg)
        if not _has_font(resvg):
            raise LimitError("a PNG file needs a font, and this machine has none: install one (fonts-dejavu)")
        width, height = (int(n) for n in _SIZE.findall(text)[:2])
        zoom = min(2.0, (MOST_PIXELS / (width * height)) ** 0.5)
        return bytes(resvg.svg_to_bytes(svg_string=text, zoom=zoom, font_family="DejaVu Sans"))

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
_STYLE = re.compile(r"<style>(.*?)</style>", re.DOTALL)
_MEDIA = re.compile(r"@media[^{]*\{(?:[^{}]*\{[^{}]*\})*[^{}]*\}")


def _on_paper(svg: str) -> str:
    """The SVG without variables in its style and without dark mode, which not every program supports."""

    def resolved(style: re.Match[str]) -> str:
        text = _MEDIA.sub("", style[1])
        values = dict(_VARIABLE.findall(text))
        return f"<style>{_USED.sub(lambda used: values[used[1]], _VARIABLE.sub('', text))}</style>"

    return _STYLE.sub(resolved, svg, count=1)


def _has_font(resvg: Any) -> bool:
    """Whether any font is installed: then the picture of a letter is not empty."""
    frame = '<svg xmlns="http://www.w3.org/2000/svg" width="20" height="20">{}</svg>'
    letter = '<text x="2" y="16">M</text>'
    drawn = [resvg.svg_to_bytes(svg_string=frame.format(text)) for text in ("", letter)]
    return bool(drawn[0] != drawn[1])


def rendered(template: str, **values: object) -> str:
    """A template of a picture, filled in as a text that stands alone."""
    return environment().get_template(template).render(alone=True, prefix="", **values)
