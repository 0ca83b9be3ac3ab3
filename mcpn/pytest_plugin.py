"""The kit in pytest: ``--mcpn-templates MODULE:NAME`` adds a test for each property of a set of templates.

``pytest -p mcpn.pytest_plugin`` loads it; it is no entry point, so that pytest imports nothing of mcpn
unasked. What fails is shown with the smallest mission that was found, as a file, and its run.
"""

from __future__ import annotations

from typing import Any

import pytest

_ALONE = "alone: "
"""Begins the name of a test that drives one template alone."""


class _Broken(Exception):
    """A property does not hold of the templates."""


class TemplateTest(pytest.Item):
    """One property of a set of templates."""

    templates: str
    property: str

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        self.funcargs: dict[
            str, object
        ] = {}  # none: pytest-lsp (1.0) fails every item that has no such names

    def runtest(self) -> None:
        """Looks for a mission that breaks the property."""
        from mcpn.drawing.templates.named import templates_named
        from mcpn.testing.kit.properties import behaves_as
        from mcpn.testing.kit.running import ALL, broken

        profile = self.config.getoption("--mcpn-profile")
        if self.property.startswith(_ALONE):
            from mcpn.testing.kit.units import driven

            alone = self.property.removeprefix(_ALONE)
            violation = driven(templates_named(self.templates), profile=profile, only=alone)
            if violation is not None:
                raise _Broken(f"{alone}, driven alone, breaks a promise: {violation}")
            return
        like = self.config.getoption("--mcpn-like")
        holds = ALL[self.property]
        if self.property == "behaves_as":
            holds = behaves_as(templates_named(like), name=like)
        asked = {self.property: holds}
        finding = broken(templates_named(self.templates), profile=profile, properties=asked)
        if finding is not None:
            raise _Broken(str(finding))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: None = None) -> str:  # type: ignore[override]
        """What is wrong, without a traceback."""
        from mcpn.errors import McpnError

        if isinstance(excinfo.value, _Broken | McpnError):
            return str(excinfo.value)
        return str(super().repr_failure(excinfo))

    def reportinfo(self) -> tuple[str, None, str]:
        """How the test is called in headings."""
        return self.templates, None, self.name


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds the options."""
    group = parser.getgroup("mcpn", "sets of net templates")
    group.addoption(
        "--mcpn-templates",
        action="append",
        default=[],
        metavar="MODULE:NAME",
        help="Test a set of net templates with mcpn's kit; may be given several times.",
    )
    group.addoption(
        "--mcpn-like",
        metavar="SET",
        default="paper",
        help="The set that missions are to behave as with: paper (the default), compact, or MODULE:NAME.",
    )
    group.addoption(
        "--mcpn-profile",
        default="ci",
        choices=["dev", "ci", "nightly"],
        help="How many missions are drawn for each property (default: ci).",
    )


def pytest_collection_modifyitems(
    session: pytest.Session, config: pytest.Config, items: list[pytest.Item]
) -> None:
    """Adds a test for each property of the templates asked for."""
    for templates in config.getoption("--mcpn-templates"):
        from mcpn.testing.kit.running import ALL
        from mcpn.testing.kit.units import MACHINES

        for name in (
            *ALL,
            *(f"{_ALONE}{machine}" for machine in MACHINES),
        ):
            item = TemplateTest.from_parent(session, name=f"{templates}::{name}")
            item.templates, item.property = templates, name
            items.append(item)
