"""The command line: the one room that sees all others.

Heavy modules are imported inside the commands, so that ``mcpn --help`` answers at once. Exit codes: 0 all
required verdicts hold, 1 some verdict fails, 2 bad input or a limit hit, 130 interrupted.
"""

from __future__ import annotations

import os
import sys

import click

from mcpn import __version__
from mcpn.cli import causes, check, ctl, outputs, spaces
from mcpn.cli.shared import EXIT_BAD_INPUT, EXIT_FAILED, EXIT_INTERRUPTED
from mcpn.errors import InputError, McpnError, SemanticsError


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mcpn")
def command_line() -> None:
    """Verify robot missions and generate their controllers."""


def main() -> None:
    """Runs the command line; mcpn's errors, Ctrl-C and a closed pipe become messages and exit codes."""
    try:
        command_line.main(standalone_mode=False)
    except click.ClickException as error:
        error.show()
        sys.exit(EXIT_BAD_INPUT)
    except McpnError as error:
        sys.exit(_tell(error))
    except MemoryError as error:  # of a diagram store, whose limit it names, or of this process
        click.echo(f"error: out of memory: {error or 'this process has no more'}", err=True)
        sys.exit(EXIT_BAD_INPUT)
    except (KeyboardInterrupt, click.Abort):
        click.echo("interrupted", err=True)
        sys.exit(EXIT_INTERRUPTED)
    except BrokenPipeError:
        # The reader has gone: keep the interpreter from flushing into the closed pipe at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(EXIT_FAILED)


def _tell(error: McpnError) -> int:
    """Prints an error and says the exit code that goes with it."""
    problems = error.problems if isinstance(error, InputError) else (error,)
    for problem in problems:
        click.echo(f"error: {problem}", err=True)
    if isinstance(error, SemanticsError):
        for number, run in enumerate(error.runs, 1):
            click.echo(f"  run {number}: {' '.join(run)}", err=True)
        return EXIT_FAILED
    return EXIT_BAD_INPUT


for command in (
    check.check,
    causes.causes,
    spaces.states,
    spaces.alternatives,
    ctl.ctl,
    outputs.controller,
    outputs.convert,
    spaces.compare,
):
    command_line.add_command(command)
