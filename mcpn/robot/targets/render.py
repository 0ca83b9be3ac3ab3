"""Text of generated code, from the skeletons in ``mcpn/robot/targets/skeletons``."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined


def render(skeleton: str, **values: Any) -> str:
    """A skeleton filled in.

    Args:
        skeleton: Its file's name.
        **values: What it speaks of; one that it needs and that is missing is an error.
    """
    # Code for robots is no HTML: names and texts are escaped for their language, by the target.
    environment = Environment(
        loader=PackageLoader("mcpn.robot.targets", "skeletons"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template(skeleton).render(**values)


def rows(values: Sequence[object], indent: str = "    ", width: int = 100) -> str:
    """Values with commas between them, in lines of some width."""
    text = ", ".join(map(str, values))
    return "\n".join(
        textwrap.wrap(text, width, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False)
    )
