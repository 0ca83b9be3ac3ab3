"""Verification before a mission is run or its controller is written: one that fails is reported, no more."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import click

from mcpn.cli.exit_codes import EXIT_FAILED
from mcpn.cli.options import Question
from mcpn.cli.printed import emit_json, tell_warnings

if TYPE_CHECKING:
    from mcpn.study import Study


def require_verified(study: Study, question: Question, refused: str) -> None:
    """Verifies a mission; one that fails is reported, and the command ends with exit code 1.

    Args:
        study: The mission.
        question: The command's options.
        refused: Says of a mission that fails what is not done with it.
    """
    from mcpn.answers.verdicts.mission import required_of

    warned = [] if question.as_json else tell_warnings(study.mission_net)
    started = time.perf_counter()
    found = study.verdicts()
    if found.passed:
        return
    if question.as_json:
        required = required_of(found.mission_net)
        failed = [name for name in required if found.verdicts[name].holds is False]
        unmet = [answer.asked.name for answer in found.requirements if not answer.met]
        emit_json({"mission": found.mission_net.mission.name, "failed": failed, "unmet": unmet})
    else:
        from mcpn.report.checked import print_check

        print_check(found, time.perf_counter() - started, told=warned)
        click.echo(refused, err=True)
    click.get_current_context().exit(EXIT_FAILED)
