"""What tests of pages share: a browser, and what is found of Ulysse."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from typing import Any

import pytest

from mcpn.drawing.compose import compose
from mcpn.findings import Findings, findings
from mcpn.mission.xml import read_mission
from tests.conftest import ULYSSE

CHROMIUM = next(
    filter(
        None,
        # The first has no windows, and a page costs a third.
        map(shutil.which, ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")),
    ),
    None,
)


@pytest.fixture(scope="module")
def ulysse_findings() -> Findings:
    return findings(compose(read_mission(ULYSSE)))


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    api = pytest.importorskip("playwright.sync_api", reason="needs playwright")
    if CHROMIUM is None:
        pytest.skip("needs Chromium: chromium, chromium-browser or google-chrome on the path")
    with api.sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture
def browser(chromium: Any) -> Iterator[Any]:
    """Pages that a test leaves open would go on playing."""
    yield chromium
    for context in chromium.contexts:
        context.close()
