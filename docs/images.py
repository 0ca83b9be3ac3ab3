"""Makes the pictures of the README and of docs/.

Run: ``python docs/images.py``, where mcpn[pictures,test-all] and Chromium are installed.

``objectives.svg`` is what ``mcpn convert mission.xml objectives.svg --draw objectives`` writes for Ulysse;
``report.png`` is the report of the same mission in a browser, after the GPS has failed during the dive.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

IMAGES = Path(__file__).parent / "images"
ULYSSE = Path(__file__).parents[1] / "experiments" / "ulysse" / "mission.xml"
CHROMIUMS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
EVENTS = (
    "MISSION_EV_START",
    "OBJ_coral_head.manual_moving_EV_OK",
    "OBJ_coral_head.isopheric_observation_EV_OK",
    "GPS_sensor_EV_OOS",
)


def mcpn(*arguments: str | Path) -> None:
    """Runs a command."""
    subprocess.run([sys.executable, "-m", "mcpn.cli", *map(str, arguments)], check=True)


def main() -> None:
    """Makes them all."""
    IMAGES.mkdir(exist_ok=True)
    mcpn("convert", ULYSSE, IMAGES / "objectives.svg", "--draw", "objectives")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        page = Path(folder) / "report.html"
        mcpn("report", ULYSSE, "-o", page)
        chromium = next(filter(None, map(shutil.which, CHROMIUMS)), None)
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": 1180, "height": 1300})
        tab.goto(page.as_uri())
        for event in EVENTS:
            tab.locator(f'#events button[data-event="{event}"]').click()
        tab.evaluate("() => { document.activeElement.blur(); window.scrollTo(0, 0); }")
        tab.screenshot(path=IMAGES / "report.png")
        browser.close()


if __name__ == "__main__":
    main()
