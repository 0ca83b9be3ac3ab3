"""Small missions that seeded faults can touch, and what is asked of each: for ``seeded_faults.py``."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from mcpn.certificates.checked_claims import GAVE_UP
from mcpn.errors import InputError, McpnError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.study import Study
from mcpn.testing.kit.corpus import MISSIONS

ULYSSE = Path(__file__).resolve().parents[1] / "ulysse" / "mission.xml"
SURVEY = """
<mission xmlns="urn:mcpn:mission:1" name="survey">
  <robot name="r">
    <hardware name="lidar" failure_rate="0.01" repair_rate="0.5"/>
    <hardware name="sonar" failure_rate="0.02"/>
    <hardware name="arm" failure_rate="0.03 .. 0.04" repair_rate="0.25"/>
    <hardware name="camera" failure_rate="0.04" repairable="false"/>
    <software name="scan"/>
    <event name="call" rate="0.1"/>
    <activity name="scanner" produces="scan">
      <alternative name="by_lidar" consumes="lidar"/><alternative name="by_sonar" consumes="sonar"/>
    </activity>
    <activity name="drive" consumes="scan"/>
    <activity name="grasp" consumes="arm"/>
    <activity name="film">
      <alternative name="whole" consumes="camera arm"/><alternative name="part" consumes="camera"/>
    </activity>
  </robot>
  <objective name="leave" activities="drive" duration="0.5" failure_probability="0.1" timeout="60">
    <on event="call" goto="home" once="true"/>
  </objective>
  <parallel name="work" failure="home">
    <objective name="pick" activities="grasp" duration="0.2" failure_probability="0.2"/>
    <objective name="look" activities="drive" duration="0.3" mandatory="false"/>
  </parallel>
  <objective name="show" activities="film" duration="0.4" failure="home"/>
  <objective name="home" activities="drive" duration="0.5" failure="abort"/>
</mission>
"""
ENDS = """
<mission xmlns="urn:mcpn:mission:1" name="ends">
  <robot name="r">
    <hardware name="a"/><hardware name="b"/>
    <event name="e"/>
    <activity name="one" consumes="a"/><activity name="two" consumes="b"/>
    <activity name="three"><alternative name="on"/></activity>
    <activity name="four"><alternative name="on"/></activity>
  </robot>
  <parallel name="outer" success="succeed" failure="after" failure_when="any">
    <objective name="nested">
      <parallel name="inner" success_when="any">
        <objective name="x" activities="one"><on event="e" goto="succeed"/></objective>
        <objective name="y" activities="three"><on event="e" goto="abort"/></objective>
      </parallel>
    </objective>
    <objective name="z" activities="two"><on event="e" goto="fail"/></objective>
  </parallel>
  <objective name="after" activities="four"/>
</mission>
"""
CLASH = """
<mission xmlns="urn:mcpn:mission:1" name="clash">
  <robot name="r">
    <hardware name="arm"/><hardware name="leg"/>
    <activity name="one">
      <alternative name="arm" consumes="arm"/><alternative name="leg" consumes="leg"/>
    </activity>
    <activity name="two">
      <alternative name="arm" consumes="arm"/><alternative name="leg" consumes="leg"/>
    </activity>
  </robot>
  <parallel name="both">
    <objective name="x" activities="one"/><objective name="y" activities="two"/>
  </parallel>
</mission>
"""
TEXTS = {"survey": SURVEY, "ends": ENDS, "clash": CLASH}


class Answered(NamedTuple):
    """What mcpn says to one question, and what the checkers say of its certificate.

    Args:
        said: The answer.
        stopped: The error that ended mcpn before an answer, or the certificate; empty where none did.
        found: By claim ``proved``, ``refuted`` or ``not checked``.
        intervals: By end, the interval that the certificate gives its probability.
    """

    said: Any = None
    stopped: str = ""
    found: Mapping[str, str] = MappingProxyType({})
    intervals: Mapping[str, tuple[str, str]] = MappingProxyType({})


def mission_of(name: str) -> Mission:
    """A mission by its name: one of the texts above, ulysse, or one of the kit's corpus."""
    if name == "ulysse":
        return read_mission(ULYSSE)
    if name in MISSIONS:
        return MISSIONS[name]
    with tempfile.NamedTemporaryFile("w", suffix=".xml") as file:
        file.write(TEXTS[name])
        file.flush()
        return read_mission(Path(file.name))


def _of_check(study: Study, by: str) -> tuple[Any, Any]:
    from mcpn.answers.claims import claims_of
    from mcpn.certificates.writing import certificate_of

    check = study.verdicts()
    met = {answer.asked.name: answer.met for answer in check.requirements}
    said = [[claim.to_json() for claim in claims_of(check)], met, check.stable_sizes]
    return said, lambda: certificate_of(check)


def _of_causes(study: Study, rates: bool) -> tuple[Any, Any]:
    from mcpn.answers.causes.interval_bounds import bounds
    from mcpn.answers.causes.risk import risk
    from mcpn.answers.claims.sets import claims_of_causes
    from mcpn.certificates.writing import certificate_of_causes
    from mcpn.report.failures.objects import causes_object, risk_object

    causes = study.causes()
    said: list[Any] = [causes_object(causes, claims_of_causes(causes), runs=False)]
    if rates:
        numbers = risk_object(risk(causes.prospects))
        said = [numbers, bounds(study.causes(engine="explicit").prospects)]
        printed = {end: numbers.get(end) for end in ("success", "failure", "abort")}
        return said, lambda: certificate_of_causes(causes, chances=True, printed=printed)
    return said, lambda: certificate_of_causes(causes)


def _of_controller(study: Study, form: str) -> tuple[Any, Any]:
    from mcpn.certificates.writing import certificate_of
    from mcpn.controller.document import document
    from mcpn.controller.hierarchy import TableController
    from mcpn.controller.minimise import minimise

    made = study.controller("hierarchical" if form == "minimised" else form)  # type: ignore[arg-type]
    if form == "minimised" and isinstance(made, TableController):
        made = minimise(made)
    said = document(made, study.mission_net)
    return said, lambda: certificate_of(study.verdicts())


def answered(asked: str) -> Answered:
    """What mcpn and the checkers say to a question, given as mission, ``check`` or such, and how.

    Args:
        asked: For example ``survey causes local``.
    """
    name, what, how = asked.rsplit(" ", 2)
    study = Study(mission_of(name))
    if what != "controller":
        study = study.bound(engine=how)  # type: ignore[arg-type]
    asking: dict[str, Callable[[], tuple[Any, Any]]] = {
        "check": lambda: _of_check(study, how),
        "causes": lambda: _of_causes(study, rates=False),
        "risk": lambda: _of_causes(study, rates=True),
        "controller": lambda: _of_controller(study, how),
    }
    try:
        said, certificate = asking[what]()
        said = json.loads(json.dumps(said))
    except Exception as error:
        return Answered(stopped=_told(error))
    try:
        found, intervals = _checked(certificate(), said if what == "controller" else None)
    except Exception as error:
        return Answered(said, f"no certificate: {_told(error)}")
    return Answered(said, "", found, intervals)


def _told(error: Exception) -> str:
    known = isinstance(error, McpnError) and not isinstance(error, InputError)
    return f"{type(error).__name__}{'' if known else ', an internal error'}: {str(error)[:80]}"


def _checked(certificate: Any, controller: Any) -> tuple[dict[str, str], dict[str, tuple[str, str]]]:
    """What becomes of each claim of a certificate, and of a controller beside it."""
    from mcpn.certificates import ctlcheck
    from mcpn.certificates.checked_claims import verified

    with tempfile.TemporaryDirectory() as folder:
        file, document = Path(folder, "certificate"), Path(folder, "controller.json")
        file.write_bytes(certificate.to_bytes())
        checked = verified(certificate, file)
        found = {key: f"{how} by {_program(checked, key)}" for key, (how, _) in checked.found.items()}
        if controller is not None:
            document.write_text(json.dumps(controller))
            try:
                ((how, key, _),) = ctlcheck.checked(str(file), str(document), seconds=60)
            except GAVE_UP:
                how, key = "not checked", "controller"
            found[key] = f"{how} by ctlcheck"
    said = {each["subject"][0]: each["statement"] for each in certificate.further if each["kind"] == "chance"}
    return found, {end: (each["low"], each["high"]) for end, each in said.items()}


def _program(checked: Any, key: str) -> str:
    """The program that checks a claim."""
    said: str = checked.of(key)
    return said.partition(":")[0].rpartition(" ")[2]
