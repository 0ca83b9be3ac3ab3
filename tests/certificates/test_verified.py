"""Terminal, JSON and page say of each claim whether certcheck has checked it, or why it is trusted."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mcpn.certificates.checked_claims import verified
from mcpn.certificates.writing import certificate_of
from mcpn.findings import findings
from mcpn.mission.xml import read_mission
from mcpn.report.certificates import NONE_CHECKED
from mcpn.report.page import page
from mcpn.study import Study
from tests.certificates.files import entries_of, rewritten
from tests.commands import mcpn, output
from tests.conftest import ULYSSE


def test_the_terminal_says_what_is_checked_and_what_is_trusted(tmp_path: Path) -> None:
    out = tmp_path / "cert"
    done = mcpn("check", ULYSSE, "--certificate", out)
    claims = entries_of(out.read_bytes())["claims.json"]
    proved, trusted = len(claims["claims"]) + 1, len(claims["trusted"])
    assert done.returncode == 0
    said = done.stdout
    assert (
        f"{proved} of {proved + trusted} claims are checked; still trusted: the reader (that the net" in said
    )
    assert "trusted, without evidence: requirement: transect.goes_on_without_GPS" in said
    both = ("certcheck", "corecheck")
    assert [line for line in said.splitlines() if "elsewhere" in line] == [
        f"check it elsewhere: {'; '.join(f'python -m mcpn.certificates.{p} {out}' for p in both)}"
    ]
    assert NONE_CHECKED not in said
    assert NONE_CHECKED in mcpn("check", ULYSSE).stdout


def test_programs_read_what_is_checked(tmp_path: Path) -> None:
    out = tmp_path / "cert"
    found = output("check", ULYSSE, "--certificate", out)
    assert set(found["checked"].values()) == {"proved"}
    assert not found["checked"].keys() & found["certificate"].keys()
    assert {claim["key"] for claim in found["claims"]} <= found["checked"].keys() | found[
        "certificate"
    ].keys()


def test_a_claim_that_is_refuted_fails_the_check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from mcpn.certificates import writing

    def turned(document: dict[str, object]) -> None:
        claim = next(c for c in document["claims"] if c["kind"] == "can_always_end")  # type: ignore[attr-defined]
        claim["evidence"]["numbers"][-1] = -1

    certificate = certificate_of(Study(read_mission(ULYSSE)).verdicts())
    with rewritten(certificate.to_bytes(), change=turned) as path:
        found = verified(certificate, Path(path))
        data = Path(path).read_bytes()
    assert found.keys("refuted") == ["can_always_end"]
    assert found.of("can_always_end").startswith("refuted by certcheck: the number of state")
    assert found.of("safe") == "checked by certcheck"
    assert found.of("net") == "checked by corecheck"
    assert found.of("something_unused").startswith("trusted, without evidence: ")
    monkeypatch.setattr(writing.Certificate, "to_bytes", lambda certificate: data)
    done = mcpn("check", ULYSSE, "--certificate", tmp_path / "cert")
    assert done.returncode == 1
    assert "  refuted: can_always_end: the number of state" in done.stdout


def test_what_takes_too_long_is_not_checked(tmp_path: Path) -> None:
    certificate = certificate_of(Study(read_mission(ULYSSE)).verdicts())
    out = tmp_path / "cert"
    out.write_bytes(certificate.to_bytes())
    found = verified(certificate, out, seconds=0)
    assert found.keys("not checked") == [*(claim["key"] for claim in certificate.claims), "net"]
    assert found.of("safe") == "not checked by certcheck: the time is over (--seconds)"


def test_the_page_says_it_under_each_verdict_and_below(tmp_path: Path) -> None:
    found = findings(Study(read_mission(ULYSSE)).mission_net)
    assert f"Evidence: {NONE_CHECKED}." in page(found)
    assert "checked by certcheck</p>" not in page(found)
    certificate, out = certificate_of(found.check), tmp_path / "cert"
    out.write_bytes(certificate.to_bytes())
    text = page(found, verified=verified(certificate, out))
    said = re.findall(r'<details class="verdict .*?</details>', text, re.DOTALL)
    assert len(said) == len(found.check.verdicts) + len(found.check.requirements)
    assert all("checked by certcheck" in each or "trusted, without" in each for each in said)
    fair = [each for each in said if "<code>transect.comes_up</code>" in each]
    assert "trusted, without evidence: fair requirements" in fair[0]
    assert "claims are checked; still trusted: the reader" in text.partition("<footer>")[2]
