"""Writes missions as files that :mod:`mcpn.mission.xml` reads back as the same mission."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lxml import etree

from mcpn.errors import InputError
from mcpn.files import write_atomically
from mcpn.mission.language.forms import NAMESPACE, Field, form_of
from mcpn.mission.model import Mission
from mcpn.mission.robot import Described
from mcpn.mission.validate import valid


def write_mission(mission: Mission) -> bytes:
    """A mission as one file that reads back as the same mission.

    Args:
        mission: The mission.

    Returns:
        UTF-8 XML with robots and protocols as children of the mission, before its blocks.

    Raises:
        InputError: The mission is not valid, with every problem, or a text holds a character that XML cannot.
    """
    try:
        return written(valid(mission))
    except ValueError as error:
        raise InputError.at(mission.source, f"mission {mission.name} cannot be written: {error}") from error


def written(mission: Mission) -> bytes:
    """The file of a mission, which is not checked: it may be invalid, as far as a file can write it.

    Raises:
        ValueError: A text holds a character that XML cannot.
    """
    return etree.tostring(element_of(mission), pretty_print=True, xml_declaration=True, encoding="UTF-8")


def element_of(described: Described) -> etree._Element:
    """The element of a file that says a mission, a robot or protocols, which are not checked.

    Raises:
        ValueError: A text holds a character that XML cannot.
    """
    root = etree.fromstring(f'<{described.TAG} xmlns="{NAMESPACE}"/>')
    _write(root, described)
    return root


def save_mission(mission: Mission, path: Path | str) -> None:
    """Writes a mission to a file, whole or not at all.

    Raises:
        InputError: The mission is not valid, or the file cannot be written.
    """
    write_atomically(Path(path), write_mission(mission))


def _write(element: etree._Element, described: Any) -> None:
    """Writes what an element of a mission says and what it holds."""
    form = form_of(type(described))
    for attribute in form.said():
        _say(element, attribute, getattr(described, attribute.name))
    for content in form.held():
        members = getattr(described, content.name)
        if around := content.children.inside:
            members = (around(**{content.name: members}),) if members else ()
        if (brief := content.short) and len(members) == 1:
            value = getattr(members[0], brief.name)
            if members[0] == type(members[0])(**{"name": described.name, brief.name: value}):
                _say(element, brief, value)
                continue
        for member in members:
            _write(etree.SubElement(element, f"{{{NAMESPACE}}}{member.TAG}"), member)


def _say(element: etree._Element, attribute: Field, value: Any) -> None:
    if value is not None and value != attribute.default:
        element.set(attribute.tag, attribute.datatype.write(value))
