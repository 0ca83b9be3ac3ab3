"""Sets of templates by name: mcpn's, or a caller's own, as ``MODULE:NAME``."""

from __future__ import annotations

import sys
from importlib import import_module

from mcpn.drawing.templates import PaperTemplates, TemplateSet
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.errors import InputError

PAPER = "paper"
NAMED = {PAPER: PaperTemplates, "compact": CompactTemplates}
METHODS = ("hardware", "software", "activity", "control")


def templates_named(name: str) -> TemplateSet:
    """A set of templates.

    Args:
        name: ``paper``, ``compact``, or ``MODULE:NAME``: an object of a module that Python finds, also in the
            current directory, or a class without arguments, of which one is made.

    Raises:
        InputError: There is no such module or name, or it is no set of templates.

    Examples:
        >>> type(templates_named("mcpn.drawing.templates:PaperTemplates")).__name__
        'PaperTemplates'
    """
    if name in NAMED:
        return NAMED[name]()
    module, colon, attribute = name.partition(":")
    if not colon or not module or not attribute:
        raise InputError.at(None, f"found the templates {name!r}, expected {', '.join(NAMED)} or MODULE:NAME")
    path = list(sys.path)
    sys.path.append("")  # a command that is installed does not look in the current directory by itself
    try:
        value = getattr(import_module(module), attribute)
        templates: TemplateSet = value() if isinstance(value, type) else value
    except Exception as error:  # whatever the caller's code raises while it is loaded
        told = f"{type(error).__name__}: {error}"
        raise InputError.at(None, f"templates {name} cannot be loaded: {told}") from error
    finally:
        sys.path[:] = path
    missing = [method for method in METHODS if not callable(getattr(templates, method, None))]
    if missing:
        expected = f"expected a set of templates, with the methods {', '.join(METHODS)}"
        raise InputError.at(None, f"templates {name}: found no {', '.join(missing)}; {expected}")
    return templates


def looks_at_no_names(templates: TemplateSet | None) -> bool:
    """Whether templates are mcpn's own: what they draw of two parts of a mission differs in names alone.

    Junctions of sections are confluent with them where the sections are (``papers/composition.md``). Of a
    caller's own, nothing is known.
    """
    return templates is None or type(templates) in NAMED.values()
