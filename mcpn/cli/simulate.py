"""Playing a mission event by event or a net transition by transition: at a prompt, from a file, at random."""

from __future__ import annotations

import random
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.options import FILE, Question, question
from mcpn.cli.printed import emit_json

if TYPE_CHECKING:
    from mcpn.study import Study


@click.command()
@click.argument("file", type=FILE)
@click.option(
    "--events",
    type=FILE,
    help="Replay a file: what check and causes print as a run, JSON, or a journal of the runtime.",
)
@click.option(
    "--nominal", is_flag=True, help="Take the run on which nothing fails: after the start objectives succeed."
)
@click.option("--tokens", is_flag=True, help="Fire the transitions of the net one by one, internal ones too.")
@click.option(
    "--random",
    "steps",
    type=click.IntRange(min=0),
    help="Take this number of steps at random: events by the rates of the mission, successes ten times as "
    "often as failures where it gives none.",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Of the steps at random.")
@question()
def simulate(
    question: Question,
    file: Path,
    events: Path | None,
    nominal: bool,
    tokens: bool,
    steps: int | None,
    seed: int,
) -> None:
    """Play FILE: a mission event by event, or a net (of a mission, with --tokens) firing by firing.

    What is shown of a mission is computed by its net, not by its controller. What happens is read from
    standard input, unless a file, a number of random steps or --nominal is given.
    """
    study = question.study(file)
    rng = random.Random(seed)
    if nominal and (events is not None or steps is not None):
        raise click.UsageError("--nominal takes a run of its own: no --events and no --random")
    if tokens or study.is_net:
        if events is not None or nominal:
            option = "--nominal is" if nominal else "--events are"
            raise click.UsageError(f"{option} of a mission that is played without --tokens")
        _play_tokens(study, steps, rng, question.as_json)
    else:
        _play_events(study, events, nominal, steps, rng, question.as_json)


def _play_tokens(study: Study, steps: int | None, rng: random.Random, as_json: bool) -> None:
    from mcpn.cli.play.tokens import TokenSession
    from mcpn.nets.game import TokenGame

    session = TokenSession(TokenGame(study.net), quiet=as_json)
    for _ in range(steps or 0):
        if not (enabled := session.game.enabled):
            break
        session.fire(rng.choice(enabled))
    if steps is None:
        session.prompt()
    elif not as_json:
        session.show()
    if as_json:
        from mcpn.report.nets import game_object

        emit_json(game_object(session.game))


def _play_events(
    study: Study,
    events: Path | None,
    nominal: bool,
    steps: int | None,
    rng: random.Random,
    as_json: bool,
) -> None:
    from mcpn.cli.play.events import EventSession
    from mcpn.controller.likelihood import drawn_event, likelihood
    from mcpn.controller.simulator import MAX_VISITED, Simulation

    simulation = Simulation(study.mission_net, study.spaces.max_states or MAX_VISITED)
    weight = likelihood(study.mission_net)
    session = EventSession(simulation, quiet=as_json)
    if events is not None:
        session.replay(events)
    if nominal:
        session.play_nominal()
    for _ in range(steps or 0):
        possible = simulation.possible
        if not possible or simulation.situation.outcome:
            break
        session.take(drawn_event(possible, weight, rng))
    if events is None and steps is None and not nominal:
        session.prompt()
    elif not as_json:
        session.show()
    if as_json:
        from mcpn.report.simulation import change_object

        name = simulation.mission_net.mission.name
        emit_json(
            {
                "steps": [change_object(change, name) for change in session.taken],
                "possible": [str(event) for event in simulation.possible],
                "outcome": simulation.situation.outcome,
            }
        )
