"""A mission's report as one page of HTML that needs nothing else: no network, no other file.

The page begins with whether the mission may be flown, then has the mission as drawn beside its controller,
run in the browser by a small script, then verdicts with their runs and tables. Every text of the mission is
escaped, and the page forbids itself all scripts but its own.
"""

from __future__ import annotations

import base64
import hashlib
import json
from importlib import resources
from typing import TYPE_CHECKING

from mcpn import __version__
from mcpn.report.pages.identity import identity
from mcpn.report.pages.live import live_data
from mcpn.report.pages.story import runs_of, story, verdict_of_all
from mcpn.report.pages.tables import tables
from mcpn.report.pictures.boxes import boxes
from mcpn.report.pictures.layout import lay_out
from mcpn.report.templates import environment

if TYPE_CHECKING:
    from mcpn.report.findings import Findings

SCRIPTS = ("tables.js", "losses.js", "machine.js", "film.js")
"""The parts of the script of a page; they are the body of one function."""


def page(findings: Findings) -> str:
    """The report as a page of HTML.

    Raises:
        InputError: The environment sets a date that is none.
    """
    mission_net = findings.check.mission_net
    root, keys = boxes(mission_net.mission, mission_net.graph)
    data = json.dumps(live_data(findings, keys), separators=(",", ":"))
    script = _script()
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return (
        environment()
        .get_template("report.html")
        .render(
            name=mission_net.mission.name,
            description=mission_net.mission.description,
            identity=list(identity(findings)),
            picture=lay_out(root, mission_net.mission),
            alone=False,
            verdicts=list(runs_of(findings.check)),
            verdict=verdict_of_all(findings.check),
            story=list(story(findings)),
            local=findings.local,
            undrawn=findings.undrawn,
            tables=tables(findings),
            early=int(bool(findings.fmeca)),  # the first table answers what people ask first
            notes=findings.notes,
            warnings=findings.warnings,
            controlled=findings.controller is not None,
            faulty=[h.name for h in mission_net.mission.hardware if h.faulty] if findings.causes else [],
            # Data in a script element ends at the first "<" that closes it: there is none.
            data=data.replace("<", "\\u003c"),
            script=script,
            digest=digest,
            version=__version__,
        )
    )


def _script() -> str:
    folder = resources.files("mcpn.report.templates")
    parts = (folder.joinpath(name).read_text(encoding="utf-8") for name in SCRIPTS)
    return '"use strict";\n(() => {\n' + "\n".join(parts) + "})();\n"
