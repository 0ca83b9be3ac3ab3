"""The kit by name and in pytest: which sets are refused, and what the plugin runs."""

from __future__ import annotations

import re
from typing import Any

import pytest

from mcpn.drawing.templates import PaperTemplates
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.drawing.templates.named import templates_named
from mcpn.errors import InputError
from mcpn.testing.kit.corpus import MISSIONS
from mcpn.testing.kit.running import (
    ALL,
    BrokenProperty,
    broken,
)
from mcpn.testing.kit.subject import Violation
from mcpn.testing.kit.units import MACHINES, driven
from tests.conftest import ROOT
from tests.kit.test_kit import Forgetful


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("nothing", "found the templates 'nothing', expected paper, compact or MODULE:NAME"),
        ("mcpn.no_such:X", "cannot be loaded: ModuleNotFoundError"),
        ("mcpn.nets.petri:NoSuch", "cannot be loaded: AttributeError"),
        ("mcpn.nets.petri:PetriNet", "cannot be loaded: TypeError"),
        (
            "mcpn.nets.petri:EVENTS",
            "found no hardware, software, activity, control; expected a set",
        ),
    ],
)
def test_templates_that_are_none_are_refused(name: str, told: str) -> None:
    with pytest.raises(InputError, match=re.escape(told)):
        templates_named(name)


def test_templates_go_by_their_names() -> None:
    assert isinstance(templates_named("paper"), PaperTemplates)
    assert isinstance(templates_named("compact"), CompactTemplates)
    assert isinstance(templates_named(f"{__name__}:Forgetful"), Forgetful)


def test_the_plugin_runs_the_kit(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    pytester.makepyfile(forgetting="from tests.kit.test_kit import Forgetful as Mine\n")
    options = ["-p", "mcpn.pytest_plugin", "-p", "no:cacheprovider", "--mcpn-profile", "dev", "-k", "unit"]
    asked = ["--mcpn-templates", "forgetting:Mine", "--mcpn-templates", "paper"]
    result = pytester.runpytest_inprocess(*options, *asked)
    result.assert_outcomes(passed=1, failed=1, deselected=2 * (len(ALL) - 1 + len(MACHINES)))
    result.stdout.fnmatch_lines(["*hardware h0 does not hold one token*", "*<mission *", "*</mission>*"])
    result.stdout.no_fnmatch_line("*Traceback*")


def test_the_plugin_runs_beside_that_of_pytest_lsp(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its wrapper around the call ends before its ``yield`` where an item has no arguments."""
    pytest.importorskip("pytest_lsp", reason="needs pytest-lsp")
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    plugins = ["-p", "pytest_asyncio.plugin", "-p", "pytest_lsp", "-p", "mcpn.pytest_plugin"]
    asked = ["--mcpn-templates", "paper", "--mcpn-profile", "dev", "-k", "unit"]
    result = pytester.runpytest_subprocess(*plugins, "-p", "no:cacheprovider", *asked)
    result.assert_outcomes(passed=1, deselected=len(ALL) + len(MACHINES) - 1)


def test_the_first_example_of_the_page_passes_the_kit() -> None:
    page = (ROOT / "docs" / "templates.md").read_text()
    names: dict[str, Any] = {}
    exec(page.split("```python\n", 2)[1].partition("```")[0], names)
    assert type(names["Mine"]()) is not PaperTemplates
    assert broken(names["Mine"](), profile="dev") is None
    for machine in ("hardware", "shared hardware"):
        assert driven(names["Mine"](), profile="dev", only=machine) is None


def test_the_plugin_drives_templates_alone(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    pytester.makepyfile(forgetting="from tests.kit.test_kit import Forgetful as Mine\n")
    options = ["-p", "mcpn.pytest_plugin", "-p", "no:cacheprovider", "--mcpn-profile", "dev"]
    asked = ["--mcpn-templates", "forgetting:Mine", "-k", "alone and (software or hardware)"]
    result = pytester.runpytest_inprocess(*options, *asked)
    result.assert_outcomes(passed=1, failed=2, deselected=len(ALL) + len(MACHINES) - 3)
    result.stdout.fnmatch_lines(
        ["hardware, driven alone, breaks a promise: an interface of h holds 0 tokens*"]
    )
    result.stdout.no_fnmatch_line("*Traceback*")


def test_the_plugin_compares_sets(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    pytester.makepyfile(forgetting="from tests.kit.test_kit import Forgetful as Mine\n")
    options = ["-p", "mcpn.pytest_plugin", "-p", "no:cacheprovider", "--mcpn-profile", "dev", "-k", "behaves"]
    asked = ["--mcpn-templates", "forgetting:Mine", "--mcpn-templates", "compact", "--mcpn-like", "paper"]
    result = pytester.runpytest_inprocess(*options, *asked)
    result.assert_outcomes(passed=1, failed=1, deselected=2 * (len(ALL) - 1 + len(MACHINES)))
    result.stdout.fnmatch_lines(["*behaves_as is broken: They differ:*", "*these*paper*", "*<mission *"])
    result.stdout.no_fnmatch_line("*Traceback*")


def test_a_finding_says_all_there_is_to_know() -> None:
    told = str(BrokenProperty("one_safe", MISSIONS["retried"], Violation("twice", [("t",)])))
    assert told.startswith("one_safe is broken: twice\nrun:\n       t\n\non this mission:\n\n<mission ")
