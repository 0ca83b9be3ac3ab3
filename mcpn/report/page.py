"""A mission's report as one page of HTML that needs nothing else: no network, no other file.

The page begins with whether the mission may go, then has the mission as drawn beside its controller,
run in the browser by a small script, then verdicts with their runs and tables. Every text of the mission is
escaped, and the page forbids itself all scripts but its own.

Its printed head says where it comes from: tool, date, engine, proof, digest of the sources.
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import time
from collections.abc import Iterator, Sequence
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from mcpn.answers.claims.of_check import of_verdict
from mcpn.errors import InputError
from mcpn.mission.model import Mission
from mcpn.report.assets import environment
from mcpn.report.certificates import NONE_CHECKED
from mcpn.report.pages.live import live_data
from mcpn.report.pages.preflight import preflight
from mcpn.report.pages.result_tables import tables
from mcpn.report.pages.story import headline, runs_of, story
from mcpn.report.pages.token_game import MOST_MARKINGS
from mcpn.report.pictures.boxes import boxes
from mcpn.report.pictures.layout import lay_out
from mcpn.report.pictures.local_graphs import LocalPictures, local_pictures
from mcpn.version import VERSION

if TYPE_CHECKING:
    from mcpn.answers.verdicts.mission import MissionCheck
    from mcpn.certificates.checked_claims import Verified
    from mcpn.errors import Problem, Source
    from mcpn.findings import Findings
    from mcpn.mission.model import Mission


EPOCH = "SOURCE_DATE_EPOCH"
"""Environment variable: seconds since 1970 that pages say in place of the time now, so that they can be made
again byte by byte (reproducible-builds.org)."""

MOST_DIGITS = 16
"""Digits of the digest that a page shows; the tooltip has all of them."""


def identity(findings: Findings) -> Iterator[tuple[str, str, str]]:
    """The lines of the head of a page: name, value, and the text of the tooltip."""
    check = findings.check
    yield "made", f"{date()} by mcpn {VERSION}", ""
    yield "engine", findings.engine, check.choice.why or "it was named"
    confluent = check.verdicts["confluent"]
    if confluent.holds:
        yield "proof", confluent.explanation, ""
    digest, files = digest_of(check.mission_net.mission)
    if files:
        shown = f"SHA-256 {digest[:MOST_DIGITS]} of {', '.join(Path(file).name for file in files)}"
        yield "sources", shown, f"{digest}: cat {' '.join(files)} | sha256sum"


def how_known(check: MissionCheck, verified: Verified) -> dict[str, str]:
    """By name of a verdict or requirement: whether certcheck has checked it, or why it is trusted."""
    keys = {name: of_verdict(verdict).key for name, verdict in check.verdicts.items()}
    keys |= {each.asked.name: f"requirement: {each.asked.name}" for each in check.requirements}
    return {name: verified.of(key) for name, key in keys.items()}


def date() -> str:
    """The day and time of a page, of the world's clock (UTC).

    Raises:
        InputError: The environment variable that sets it is no number of seconds.
    """
    said = os.environ.get(EPOCH)
    if not said:
        return time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())
    try:
        return time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime(int(said)))
    except (ValueError, OverflowError, OSError) as error:
        message = f"found {EPOCH}={said[:40]!r} in the environment, expected seconds since 1970"
        raise InputError.at(None, message) from error


def digest_of(mission: Mission) -> tuple[str, list[str]]:
    """The SHA-256 of the files of a mission one after the other, and their names; none where one is gone."""
    found, files = hashlib.sha256(), [*mission.files]
    try:
        for file in files:
            found.update(Path(file).read_bytes())
    except OSError:
        return "", []
    return (found.hexdigest(), files) if files else ("", [])


SCRIPTS = (
    *("start.js", "tables.js", "drawings.js", "paper.js", "losses.js"),
    *("served.js", "game.js", "machine.js", "film.js", "robot.js"),
)
"""The parts of the script of a page; they are the body of one function."""

AROUND, MOST_OF_LINE = 2, 200
"""Lines that are shown before and after one that is wrong, and characters of each."""


def page(
    findings: Findings,
    *,
    local: LocalPictures | None = None,
    served: int = 0,
    robot: bool = False,
    verified: Verified | None = None,
) -> str:
    """The report as a page of HTML.

    Args:
        findings: What was found of the mission.
        local: Pictures of its local graphs, where they are drawn already.
        served: The number of this version of the page, where a server makes a new one after each change of
            the mission's files; 0 for a page without a server.
        robot: Whether the page shows what a robot does, which a server sends.
        verified: What certcheck says of the mission's certificate, where one has been written.

    Raises:
        InputError: The environment sets a date that is none.
    """
    mission_net = findings.check.mission_net
    root, keys = boxes(mission_net.mission, mission_net.graph)
    live = live_data(findings, keys, asks=bool(served))
    data = json.dumps(live, separators=(",", ":"))
    pictures, undrawn = local_pictures(findings.local) if local is None else local
    script, digest = _script()
    known = {} if verified is None else how_known(findings.check, verified)
    return (
        environment()
        .get_template("report.html")
        .render(
            name=mission_net.mission.name,
            description=mission_net.mission.description,
            identity=list(identity(findings)),
            foot=f"mission {mission_net.mission.name}, made {date()} by mcpn {VERSION}",
            picture=lay_out(root, mission_net.mission),
            alone=False,
            served=served,
            robot=robot,
            ways=list(_ways(mission_net.mission)) if served else [],
            played="net" in live,
            most_markings=MOST_MARKINGS,
            file=next((Path(file).name for file in mission_net.mission.files), "MISSION"),
            verdicts=[{**each, "known": known.get(each["name"], "")} for each in runs_of(findings.check)],
            trusted=NONE_CHECKED if verified is None else verified.summary,
            verdict=headline(findings),
            preflight=list(preflight(findings)),
            story=list(story(findings)),
            local=pictures,
            undrawn=[*findings.unlisted, *undrawn],
            tables=tables(findings),
            early=int(bool(findings.fmeca)),  # the first table answers what people ask first
            notes=findings.notes,
            warnings=findings.warnings,
            controlled=findings.controller is not None,
            faulty=[h.name for h in mission_net.core.hardware if h.faulty] if findings.causes else [],
            # Data in a script element ends at the first "<" that closes it: there is none.
            data=data.replace("<", "\\u003c"),
            script=script,
            digest=digest,
            version=VERSION,
        )
    )


def _ways(mission: Mission) -> Iterator[tuple[str, list[str]]]:
    """Activities with several alternatives, and these."""
    for robot in mission.robots:
        for activity in robot.activities:
            if len(activity.alternatives) > 1:
                yield activity.name, [way.name for way in activity.alternatives]


def failed_page(file: Path, problems: Sequence[Problem], number: int) -> str:
    """The page of a mission that cannot be verified: what is wrong, with the lines around it.

    Args:
        file: The mission.
        problems: What is wrong.
        number: Of the page.
    """
    script, digest = _script()
    rows = [(str(p.source or file), p.message, list(_lines_around(p.source))) for p in problems]
    template = environment().get_template("failed.html")
    return template.render(file=file.name, number=number, problems=rows, script=script, digest=digest)


def _lines_around(source: Source | None) -> Iterator[tuple[int, str, bool]]:
    """The lines around a problem: number, text, and whether the problem is on this line."""
    if source is None or source.line is None:
        return
    try:
        lines = Path(source.file).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return
    for number in range(max(1, source.line - AROUND), min(len(lines), source.line + AROUND) + 1):
        yield number, lines[number - 1][:MOST_OF_LINE], number == source.line


def _script() -> tuple[str, str]:
    """The script of a page, and the digest by which the page allows it."""
    folder = resources.files("mcpn.report.assets")
    parts = (folder.joinpath(name).read_text(encoding="utf-8") for name in SCRIPTS)
    script = '"use strict";\n(() => {\n' + "\n".join(parts) + "})();\n"
    return script, base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
