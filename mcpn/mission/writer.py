"""Writes missions as files that :mod:`mcpn.mission.xml` reads back as the same mission."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from lxml import etree

from mcpn.errors import InputError
from mcpn.files import write_atomically
from mcpn.mission.model import (
    Alternative,
    Block,
    Each,
    Handler,
    Holder,
    Mission,
    Objective,
    Parallel,
    Parameter,
    Recursive,
    Robot,
    Use,
)
from mcpn.mission.schema import NAMESPACE
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
    """The same of a mission that need not be valid, as far as a file can say it.

    Raises:
        ValueError: A text holds a character that XML cannot.
    """
    root = etree.fromstring(f'<mission xmlns="{NAMESPACE}"/>')
    _attributes(root, mission)
    for robot in mission.robots:
        _write_robot(_child(root, "robot", robot), robot)
    if mission.protocols:
        protocols = etree.SubElement(root, f"{{{NAMESPACE}}}protocols")
        for protocol in mission.protocols:
            element = _child(protocols, "protocol", protocol)
            _write_parameters(element, protocol.parameters)
            _write_blocks(element, protocol.blocks, in_parallel=False)
    _write_handlers(root, mission.handlers)
    _write_blocks(root, mission.blocks, in_parallel=False)
    return etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8")


def save_mission(mission: Mission, path: Path | str) -> None:
    """Writes a mission to a file, whole or not at all.

    Raises:
        InputError: The mission is not valid, or the file cannot be written.
    """
    write_atomically(Path(path), write_mission(mission))


def _attributes(element: etree._Element, of: Any, **more: str | float | None) -> None:
    for key, value in {"name": of.name, **more, "description": of.description}.items():
        if value is not None:
            element.set(key, str(value))


def _child(parent: etree._Element, tag: str, of: Any, **more: str | float | None) -> etree._Element:
    element = etree.SubElement(parent, f"{{{NAMESPACE}}}{tag}")
    _attributes(element, of, **more)
    return element


def _write_parameters(element: etree._Element, parameters: Iterable[Parameter]) -> None:
    for parameter in parameters:
        _child(element, "parameter", parameter, value=parameter.value, unit=parameter.unit)


def _write_handlers(element: etree._Element, handlers: Iterable[Handler]) -> None:
    for handler in handlers:
        drawn = etree.SubElement(element, f"{{{NAMESPACE}}}on", event=handler.event, goto=handler.goto)
        if handler.once:
            drawn.set("once", "true")
        if handler.description is not None:
            drawn.set("description", handler.description)


def _write_robot(element: etree._Element, robot: Robot) -> None:
    for hardware in robot.hardware:
        rates = {"failure_rate": hardware.failure_rate, "repair_rate": hardware.repair_rate}
        _child(
            element,
            "hardware",
            hardware,
            faulty=None if hardware.faulty else "false",
            shared="true" if hardware.shared else None,
            **rates,
        )
    for software in robot.software:
        _child(element, "software", software, exclusive="true" if software.exclusive else None)
    for event in robot.events:
        _child(element, "event", event, rate=event.rate)
    for activity in robot.activities:
        first = activity.alternatives[0]
        short = activity.alternatives == (Alternative(name=activity.name, consumes=first.consumes),)
        drawn = _child(
            element,
            "activity",
            activity,
            produces=" ".join(activity.produces) or None,
            switch_back="true" if activity.switch_back else None,
            consumes=(" ".join(first.consumes) or None) if short else None,
        )
        _write_parameters(drawn, activity.parameters)
        for alternative in () if short else activity.alternatives:
            consumes = " ".join(alternative.consumes) or None
            _write_parameters(
                _child(drawn, "alternative", alternative, consumes=consumes), alternative.parameters
            )


def _write_blocks(parent: etree._Element, blocks: Iterable[Block], *, in_parallel: bool) -> None:
    for block in blocks:
        routing: dict[str, str | float | None] = {"success": block.success, "failure": block.failure}
        if in_parallel and not block.mandatory:
            routing["mandatory"] = "false"
        routing |= {"retries": block.retries or None, "repeat": block.repeat}
        if isinstance(block, Objective):
            routing |= {"duration": block.duration, "failure_probability": block.failure_probability}
            element = _child(parent, "objective", block, activities=" ".join(block.activities), **routing)
            _write_parameters(element, block.parameters)
        elif isinstance(block, Use):
            element = _child(parent, "use", block, protocol=block.protocol, **routing)
            _write_parameters(element, block.parameters)
        elif isinstance(block, Recursive):
            element = _child(parent, "objective", block, **routing)
            _write_parameters(element, block.parameters)
        elif isinstance(block, Each):
            values = " ".join(block.values)
            element = _child(parent, "each", block, **{"in": values}, parameter=block.parameter, **routing)
        else:
            element = _child(parent, "parallel", block, **routing)
        _write_handlers(element, block.handlers)
        if isinstance(block, Holder):
            _write_blocks(element, block.blocks, in_parallel=isinstance(block, Parallel))
