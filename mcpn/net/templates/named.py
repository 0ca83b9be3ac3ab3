"""Sets of templates by name: the paper's, or a caller's own, as ``MODULE:NAME``."""

from __future__ import annotations

import sys
from importlib import import_module

from mcpn.errors import InputError
from mcpn.net.templates import PaperTemplates, TemplateSet

PAPER = "paper"
METHODS = ("hardware", "software", "activity", "control")


def templates_named(name: str) -> TemplateSet:
    """A set of templates.

    Args:
        name: ``paper``, or ``MODULE:NAME``: an object of a module that Python finds, also in the current
            directory, or a class without arguments, of which one is made.

    Raises:
        InputError: There is no such module or name, or it is no set of templates.

    Examples:
        >>> type(templates_named("mcpn.net.templates:PaperTemplates")).__name__
        'PaperTemplates'
    """
    if name == PAPER:
        return PaperTemplates()
    module, colon, attribute = name.partition(":")
    if not colon or not module or not attribute:
        raise InputError.at(None, f"found the templates {name!r}, expected {PAPER} or MODULE:NAME")
    path = list(sys.path)
    sys.path.append("")  # a command that is installed does not look in the current directory by itself
    try:
        found = getattr(import_module(module), attribute)
        templates: TemplateSet = found() if isinstance(found, type) else found
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
