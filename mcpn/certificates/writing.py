"""Writes the certificate of a check: the claims with their evidence, and those that are only trusted."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Iterable, Mapping
from io import BytesIO
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from mcpn.answers.causes.find import Causes
from mcpn.answers.claims import Claim, claims_of, claims_of_losses
from mcpn.answers.mission_names import MissionNames
from mcpn.answers.requirements import AskedRequirement
from mcpn.answers.spaces_by_engine import MissionSpaces, spaces_of
from mcpn.answers.verdicts.mission import MissionCheck
from mcpn.answers.verdicts.nominal import NominalRuns, meant_to_be_entered
from mcpn.certificates import evidence
from mcpn.certificates.certcheck import ENDS, VERSION, Limit
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.cut_set_evidence import before_the_start, can_fail, survived
from mcpn.certificates.entries import Claimed, Trusted, Uncertified, entry, supported
from mcpn.certificates.formula_entry import formula_entry
from mcpn.certificates.moments_entry import CRASHES, MomentClaims
from mcpn.certificates.net_entry import net_entry
from mcpn.certificates.sections.sectionforms import UNSHOWN
from mcpn.certificates.sections.sections_entry import OF_THE_NET, claims_by_sections
from mcpn.drawing.compose import MissionNet
from mcpn.errors import ConfluenceError, InputError, LimitError
from mcpn.logic.syntax import parse
from mcpn.spaces.algebra import Space
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.engine_names import SYMBOLIC
from mcpn.spaces.markings.graph import Mask
from mcpn.spaces.stable.alternatives import AlternativesGraph
from mcpn.steps import Doing, step

if TYPE_CHECKING:
    from mcpn.certificates.diagrams_entry import DiagramWriter

_Claims: TypeAlias = dict[str, dict[str, Any]]
_Trusted: TypeAlias = dict[str, tuple[str, str]]

MOST_LISTED = 200_000
"""Stable states up to which a certificate is written by listing them."""
MANY_SECTIONS = 50
"""Sections above which a mission is certified by their types, and not by diagrams of all its markings."""
WHEN = (1980, 1, 1, 0, 0, 0)
"""The time of each entry, so that one mission has one certificate."""
UNSAFE = "an abort by the failure of a safing objective is no safe end"
LISTED = {"safe": "safe", "bounded": "safe", "confluent": "confluent"}
"""By verdict that listing the states shows: the kind of the certificate's claim."""
PLAYED = "The net does what the mission says."
SENTENCES = {
    "safe": "No firing puts a second token in a place.",
    "confluent": "Each event has one outcome, whatever the order inside the net.",
}


class Certificate(NamedTuple):
    """A certificate: what is claimed with evidence, and what is only trusted.

    Args:
        mission: Its name.
        net: The entry ``net.json``, unless claims are proved by sections.
        claims: Those with evidence, as ``claims.json`` holds them, or ``sections.json``.
        trusted: By key of a claim without: its sentence, and why there is no evidence.
        core: The entry ``core.json``: the mission, to be played beside the net.
        further: The claims of the entry ``further.json``, which furthercheck judges.
        diagrams: The entry ``diagrams.json``, of missions whose states are too many to list.
    """

    mission: str
    net: dict[str, Any] | None
    claims: list[dict[str, Any]]
    trusted: dict[str, tuple[str, str]]
    core: dict[str, Any]
    further: tuple[dict[str, Any], ...] = ()
    diagrams: dict[str, Any] | None = None

    @property
    def listed(self) -> bool:
        """Whether its checkers list the states of a net."""
        return self.net is not None and self.diagrams is None

    @property
    def said(self) -> dict[str, Any]:
        """By claim without evidence, why it is only trusted, for programs."""
        return {"certificate": {key: why for key, (_, why) in self.trusted.items()}}

    def to_bytes(self) -> bytes:
        """The file."""
        trusted = [{"key": key, "sentence": said, "why": why} for key, (said, why) in self.trusted.items()]
        claims = {
            "format": "mcpn-certificate",
            "version": VERSION,
            "mission": self.mission,
            "claims": self.claims,
            "trusted": trusted,
        }
        further = None
        if self.further:
            further = {"format": "mcpn-certificate", "version": VERSION, "claims": self.further}
        entries: dict[str, dict[str, Any] | None] = {
            "net.json": self.net,
            "sections.json" if self.net is None else "claims.json": claims,
            "core.json": self.core,
        }
        entries |= {"further.json": further, "diagrams.json": self.diagrams}
        written = BytesIO()
        with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
            for name, document in entries.items():
                if document is None:
                    continue
                text = json.dumps(document, separators=(",", ":"))
                archive.writestr(zipfile.ZipInfo(name, WHEN), text, zipfile.ZIP_DEFLATED)
        return written.getvalue()


def certificate_of(check: MissionCheck, max_states: int | None = None) -> Certificate:
    """The certificate of a check of a mission.

    Args:
        check: The check.
        max_states: How many stable states may be listed, :data:`MOST_LISTED` by default.

    Raises:
        ConfluenceError: The mission has no alternatives graph; then nothing is certified.
        LimitError: It has more states than may be listed.
    """
    if check.alternatives is None:
        raise ConfluenceError("no certificate: the mission is not safe or not confluent")
    try:
        graph = _listed(check.spaces, check.alternatives, max_states)
    except LimitError as error:
        return _by_sections(check) or _by_diagrams(check, error)
    asked = {answer.asked.name: answer.asked for answer in check.requirements}
    return _Writer(check.mission_net, graph, asked).certificate(claims_of(check))


def _by_sections(check: MissionCheck) -> Certificate | None:
    """The certificate of a mission of many sections: of what their types prove, unless they are not apart."""
    if len(check.mission_net.graph.sections) <= MANY_SECTIONS:
        return None
    core = core_entry(check.mission_net)
    try:
        claims, trusted = claims_by_sections(core, claims_of(check), _stating(check))
    except Limit:
        return None
    return Certificate(check.mission_net.core.name, None, claims, trusted, core)


def _stating(check: MissionCheck) -> Callable[[Claim], tuple[str, dict[str, Any]]]:
    """By claim its kind in the certificate of sections, and what it states."""
    asked = {answer.asked.name: answer.asked for answer in check.requirements}
    names = MissionNames(check.mission_net)

    def of(claim: Claim) -> tuple[str, dict[str, Any]]:
        if claim.of.verdict in ("safe", "confluent", "bounded"):
            raise Uncertified(OF_THE_NET)
        if claim.kind in ENDS and "happens(" not in claim.formula:
            return claim.kind, {}
        if claim.kind == "nominal_success":
            return claim.kind, stated_nominal(check.mission_net)
        if " X " in claim.formula or " G " in claim.formula:
            raise Uncertified(UNSHOWN)  # which takes long to read where objectives are many
        return "formula", stated_formula(claim, check.mission_net, asked, names)

    return of


def _by_diagrams(check: MissionCheck, error: LimitError) -> Certificate:
    """The certificate of a mission whose states are too many to list: of what its diagrams prove.

    Raises:
        LimitError: Its diagrams are too large too.
    """
    writer, claims, trusted = _drawn(check.mission_net, check.spaces)
    for claim in claims_of(check):
        kind = LISTED.get(claim.of.verdict, claim.kind)
        if claim.key in claims or claim.key in trusted:
            continue
        if kind not in ENDS or claim.holds is None or "happens(" in claim.formula:
            trusted[claim.key] = claim.sentence, f"{error}; no diagram proves it"
            continue
        with supported(claim.sentence):
            shown = writer.evidence(kind, claim.holds)
        claims[claim.key] = entry(claim.key, kind, claim.subject, claim.holds, claim.sentence, {}, shown)
    return _certificate(writer, claims, trusted)


def _drawn(mission_net: MissionNet, spaces: MissionSpaces) -> tuple[DiagramWriter, _Claims, _Trusted]:
    """The writer of diagrams of a mission, the claims that they always prove, and what they do not."""
    from mcpn.certificates.diagrams_entry import DiagramWriter

    writer = DiagramWriter(mission_net, spaces.symbolic(), spaces.space(SYMBOLIC))
    claims = _Claims()
    for name, sentence in SENTENCES.items():
        with supported(sentence):
            claims[name] = entry(name, name, (), True, sentence, {}, writer.evidence(name, True))
    return writer, claims, {"net": (PLAYED, "corecheck lists the states, and they are too many")}


def _certificate(writer: DiagramWriter, claims: _Claims, trusted: _Trusted) -> Certificate:
    """The certificate of claims that diagrams prove."""
    mission_net, name = writer.mission_net, writer.mission_net.core.name
    net, core = net_entry(mission_net, diagrams=True), core_entry(mission_net)
    return Certificate(name, net, [], trusted, core, (), writer.document(claims.values()))


def _causes_by_diagrams(causes: Causes, error: LimitError) -> Certificate:
    """The certificate of causes of a mission whose states are too many to list: of its minimal cut sets.

    Raises:
        LimitError: Its diagrams are too large too.
    """
    mission_net = causes.mission_net
    writer, claims, trusted = _drawn(mission_net, spaces_of(mission_net))
    for claim in claims_of_losses(causes.prospects):
        if claim.key not in claims:
            trusted.setdefault(claim.key, (claim.sentence, f"{error}; no diagram proves it"))
    asked, unasked = _asked_cut_sets(causes)
    for key, sentence, said in asked:
        try:
            with supported(sentence):
                shown = writer.cut_sets(said["ends"], said["hardware"], said["cuts"])
        except LimitError as why:
            trusted[key] = sentence, str(why)
        else:
            claims[key] = entry(key, "cut_sets", (), True, sentence, said, shown)
    trusted |= {each.key: (each.sentence, each.why) for each in unasked}
    return _certificate(writer, claims, trusted)


def _asked_cut_sets(causes: Causes) -> tuple[list[tuple[str, str, dict[str, Any]]], list[Trusted]]:
    """The claims on what is lost before the start, each as key, sentence and statement; and those without."""
    mission_net = causes.mission_net
    found, trusted = list[tuple[str, str, dict[str, Any]]](), list[Trusted]()
    asked = [(causes.mission.cut_sets, "success")]
    if causes.safety is not None and not causes.unsafe_aborts:
        asked.append((causes.safety.cut_sets, "success or abort"))
    elif causes.safety is not None:
        trusted.append(Trusted("cut_sets: success or abort", "All minimal cut sets of a safe end.", UNSAFE))
    for cut_sets, ends in asked:
        key = f"cut_sets: {ends}"
        sentence = f"All minimal cut sets: lost before the start, each leaves no way to {ends}."
        if mission_net.core.crashes:
            trusted.append(Trusted(key, sentence, CRASHES))
            continue
        cuts = sorted(sorted(names) for names in cut_sets)
        said = {"ends": ends.split(" or "), "hardware": can_fail(mission_net), "cuts": cuts}
        found.append((key, sentence, said))
    return found, trusted


def certificate_of_causes(
    causes: Causes,
    max_states: int | None = None,
    *,
    chances: bool = False,
    printed: Mapping[str, float | None] = MappingProxyType({}),
) -> Certificate:
    """The certificate of the minimal cut sets of a mission, and of what single losses do.

    Args:
        causes: What makes it fail.
        max_states: As of :func:`certificate_of`.
        chances: Whether it says how probable the ends are too.
        printed: By end the probability that is told beside the certificate.

    Raises:
        EvidenceError: A probability that is told lies outside of what is proved of it.
        LimitError: As there; or there are too many sets that the mission survives.
    """
    mission_net = causes.mission_net
    try:
        graph = _listed(spaces_of(mission_net), causes.prospects.space, max_states)
    except LimitError as error:
        return _causes_by_diagrams(causes, error)
    made = _Writer(mission_net, graph, {}).certificate(claims_of_losses(causes.prospects))
    asked, trusted = _asked_cut_sets(causes)
    claims, further = list(made.claims), list[dict[str, Any]]()
    for key, sentence, said in asked:
        with supported(sentence):
            losing = before_the_start(graph, mission_net, said["ends"])
            shown = {"survived": survived(graph, mission_net, said["cuts"], losing)}
        claims.append(entry(key, "cut_sets", (), True, sentence, said, shown))
    moments = MomentClaims(causes, graph)
    every: list[Claimed | Trusted] = [*moments.all()]
    if chances:
        from mcpn.certificates.chances_entry import chance_claims  # needs numpy

        every += chance_claims(causes, graph, moments, printed)
    for each in every:
        if isinstance(each, Trusted):
            trusted.append(each)
        else:
            further.append(each)
    known = made.trusted | {each.key: (each.sentence, each.why) for each in trusted}
    return made._replace(claims=claims, trusted=known, further=tuple(further))


def _listed(spaces: MissionSpaces, space: Space[Any], max_states: int | None) -> AlternativesGraph:
    """The stable states of a mission one by one, numbered as the checker numbers them."""
    step(Doing.EXPLAINING)
    most, size = MOST_LISTED if max_states is None else max_states, space.everything.count()
    if size > most:
        raise LimitError(f"no certificate: it would list {size} stable states, and {most} are the limit")
    # That every order ends alike has been proved by the check, and is what the checker looks at first.
    graph = spaces.unproved(most).graph
    assert isinstance(graph, AlternativesGraph), "of stable states"
    return graph


class _Writer:
    """Claims with their evidence in the listed states."""

    def __init__(
        self, mission_net: MissionNet, graph: AlternativesGraph, asked: Mapping[str, AskedRequirement]
    ) -> None:
        self.mission_net, self.graph, self.asked = mission_net, graph, asked
        self.names = MissionNames(mission_net)

    def certificate(self, made: Iterable[Claim]) -> Certificate:
        """All claims, those without evidence apart."""
        claims, trusted = dict[str, dict[str, Any]](), dict[str, tuple[str, str]]()
        for name, sentence in SENTENCES.items():
            claims[name] = entry(name, name, (), True, sentence, {}, {})
        for claim in made:
            if claim.key in claims or claim.key in trusted:
                continue
            try:
                with supported(claim.sentence):
                    said, shown = self.evidence(claim)
            except Uncertified as why:
                trusted[claim.key] = claim.sentence, str(why)
            else:
                assert claim.holds is not None, "evidence refuses what is not known"
                claims[claim.key] = entry(
                    claim.key,
                    _kind(claim, said),
                    claim.subject,
                    claim.holds,
                    claim.sentence,
                    said,
                    shown,
                )
        net, core = net_entry(self.mission_net), core_entry(self.mission_net)
        return Certificate(self.mission_net.core.name, net, list(claims.values()), trusted, core)

    def evidence(self, claim: Claim) -> tuple[dict[str, Any], dict[str, Any]]:
        """What a claim states beside its kind, and its evidence.

        Raises:
            Uncertified: There is none.
        """
        if claim.holds is None:
            raise Uncertified("whether it holds is not known")
        if claim.of.verdict in LISTED and claim.holds:
            return {}, {}
        match claim.kind:
            case "can_succeed" | "can_fail" | "can_be_aborted":
                end = {"can_succeed": "success", "can_fail": "failure", "can_be_aborted": "abort"}[claim.kind]
                return {}, {"run": self.run(self.ended(end))} if claim.holds else {}
            case "can_always_end" | "can_always_end_safely" if "happens(" not in claim.formula:
                ends = (
                    ("success", "abort") if claim.kind.endswith("safely") else ("success", "failure", "abort")
                )
                return {}, self.can_always(self.ended(*ends), claim.holds)
            case "can_always_go_on":
                stuck = self.graph.dead & ~self.ended("success", "failure", "abort")
                return {}, {} if claim.holds else {"run": self.run(stuck)}
            case "nominal_success":
                return self.nominal(claim.holds)
        return stated_formula(claim, self.mission_net, self.asked, self.names), {}

    def ended(self, *ends: str) -> Mask:
        """The states in which the mission has ended so."""
        known = self.mission_net.ends
        return evidence.marking(self.graph, [known[end] for end in ends if end in known])

    def run(self, goal: Mask) -> list[int]:
        """A run from the start into a goal that some run leads to."""
        found = evidence.run(self.graph, goal)
        assert found is not None, "the check has found one"
        return found

    def can_always(self, goal: Mask, holds: bool) -> dict[str, Any]:
        """Numbers that fall on the way to a goal; or a run to where there is no such way."""
        far = evidence.distances(self.graph, goal)
        return {"numbers": far.tolist()} if holds else {"run": self.run(far < 0)}

    def nominal(self, holds: bool) -> tuple[dict[str, Any], dict[str, Any]]:
        """What a nominal run is in this mission, and numbers that fall along these."""
        if not holds:
            raise Uncertified("a failure of nominal runs is not certified")
        mission_net, graph = self.mission_net, self.graph
        runs = NominalRuns(mission_net, ArraySpace(graph), settles=True)
        said = stated_nominal(mission_net)
        endless = said["endless"]
        stays = [place for place, name in mission_net.saying("objective").items() if name in endless]
        within = runs.reached.mask & ~self.ended("success") & ~evidence.marking(graph, stays)
        numbers = evidence.falling(graph, evidence.carrying(graph, runs.transitions), within)
        assert numbers is not None, "nominal runs end but in what is meant to be endless"
        return said, {"numbers": numbers.tolist()}


def stated_nominal(mission_net: MissionNet) -> dict[str, list[str]]:
    """What a nominal run is in a mission."""
    copies, hardware = mission_net.graph.copies, mission_net.core.hardware
    optional = copies.meant_as("optional")
    return {
        "fails": sorted(copies.meant_as("fails")),
        "endless": sorted(copies.meant_as("endless")),
        "meant": [name for name in meant_to_be_entered(mission_net) if name not in optional],
        "repaired": [h.name for h in hardware if h.initial == "oos" and h.repairable],
    }


def stated_formula(
    claim: Claim, mission_net: MissionNet, asked: Mapping[str, AskedRequirement], names: MissionNames
) -> dict[str, Any]:
    """The formula of a claim, as text and as it is understood.

    Raises:
        Uncertified: The certificate's formulas do not say it.
    """
    if claim.kind == "requirement":
        one = asked[claim.subject[0]]
        if one.requirement.fair:
            raise Uncertified("fair requirements speak of some runs alone")
        as_asked = one.requirement.expected == "holds"
        text, formula = (
            one.text if as_asked else f"not so: {one.text}",
            one.formula if as_asked else ~one.formula,
        )
    elif not claim.formula:
        raise Uncertified("no formula of the certificate says it")
    else:
        text = claim.formula
        try:
            formula = parse(text, names)
        except InputError as error:  # it is too long to read
            raise Uncertified(str(error)) from error
    try:
        return {"text": text, "formula": formula_entry(formula, mission_net)}
    except InputError as error:
        raise Uncertified(str(error)) from error


def _kind(claim: Claim, said: dict[str, Any]) -> str:
    """The kind of a claim in the certificate: of a formula where an abort may be no safe end."""
    kind = LISTED.get(claim.of.verdict, claim.kind)
    return "formula" if kind in ENDS and "formula" in said else kind
