"""Options that commands share, and what they make of their values: the study of a file, its workers."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import fields
from functools import wraps
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn.errors import InputError, Source
from mcpn.records import record
from mcpn.spaces.engine_names import SPACE_ENGINES

if TYPE_CHECKING:
    from mcpn.drawing.templates import TemplateSet
    from mcpn.spaces.engine_names import Asked
    from mcpn.study import Study
    from mcpn.trees.options import TreeOptions

FILE = click.Path(path_type=Path)


class FiniteRange(click.FloatRange):
    """Numbers of a range; ``nan``, which no bound keeps out, and infinity are refused."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number, where it is one."""
        number: float = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(f"found {value}, expected a finite number", param, ctx)
        return number


_JSON = "mcpn.json"


def _remember_json(ctx: click.Context, _option: click.Parameter, asked: bool) -> bool:
    ctx.meta[_JSON] = asked
    return asked


def json_asked(ctx: click.Context) -> bool:
    """Whether the command under way is to answer in JSON."""
    return bool(ctx.meta.get(_JSON))


json_option = click.option(
    "--json",
    "as_json",
    is_flag=True,
    callback=_remember_json,
    help="Print one JSON value and nothing else.",
)


_limit = click.option(
    "--max-states",
    type=click.IntRange(1, (1 << 63) - 1),
    help="List at most this many states one by one. Decision diagrams, which the symbolic engine and most of "
    "the local one use, are limited by memory instead.",
)


_import = click.option(
    "--import-root",
    type=FILE,
    help="Directory that imports and includes must stay in (default: that of the file).",
)


TREE_OPTIONS = {
    "library": click.option(
        "--library",
        multiple=True,
        metavar="NAME=VERSION",
        help="Of a behaviour tree: what it is for: nav2=1.5, btcpp=4.8, plansys2=2.0, py_trees; "
        "may be repeated.",
    ),
    "main": click.option("--main", metavar="ID", help="Of a behaviour tree: the tree to execute."),
    "nodes": click.option(
        "--nodes",
        type=FILE,
        multiple=True,
        help="Of a behaviour tree: a file with a TreeNodesModel; may be repeated.",
    ),
    "faulty_leaves": click.option(
        "--faulty-leaves",
        is_flag=True,
        help="Of a behaviour tree: leaves may crash, so that cut sets name them.",
    ),
}
"""What people may say of a behaviour tree, by key of :class:`mcpn.trees.options.TreeOptions`."""


def tree_options(command: Callable[..., None]) -> Callable[..., None]:
    """Gives a command the options of trees, and their values as its argument ``of_tree``."""

    @wraps(command)
    def asked(*args: Any, **given: Any) -> None:
        of_tree = {name: given.pop(name) for name in TREE_OPTIONS}
        command(*args, of_tree=of_tree, **given)

    for option in reversed(TREE_OPTIONS.values()):
        asked = option(asked)
    return asked


def templates_of(_ctx: click.Context, _option: click.Parameter, name: str | None) -> TemplateSet | None:
    """The set of templates that is named; none where it is the paper's."""
    if name is None:
        return None
    from mcpn.drawing.templates.named import PAPER, templates_named

    return None if name == PAPER else templates_named(name)


_templates = click.option(
    "--templates",
    metavar="SET",
    callback=templates_of,
    help="Templates to draw the mission's net with: paper (the default), compact, or MODULE:NAME.",
)


MOST_JOBS = 1024
"""No machine has more processes for this, and the queue between them has room for few more."""


_jobs = click.option(
    "--jobs",
    type=click.IntRange(1, MOST_JOBS),
    default=1,
    show_default=True,
    help="Processes for local graphs.",
)


_scheduler = click.option(
    "--scheduler", metavar="ADDRESS", help="Build local graphs on a dask cluster (needs mcpn[distributed])."
)


def engine_option(*more: str) -> Callable[[Any], Any]:
    """``--engine``, the same for every command that asks one.

    Args:
        more: Engines that this command knows besides.
    """
    known = click.Choice(["auto", *SPACE_ENGINES, *more])
    told = "The engine that answers; auto chooses by the mission, and tries another if one gives up."
    return click.option("--engine", type=known, default="auto", show_default=True, help=told)


def _refuse_tree(file: Path) -> None:
    """Refuses a behaviour tree, for a command that takes missions."""
    from mcpn.trees.reading import is_tree

    if is_tree(file):
        said = "found a behaviour tree, expected a mission"
        raise InputError.at(
            Source(str(file), 1), f"{said}: mcpn init NAME --from {file} writes it as one"
        ) from None


@record(frozen=True)
class Question:
    """What the options say that commands which ask a question share.

    Args:
        max_states: States that are listed at most; ``None`` for the limit of each engine.
        import_root: Where imports must stay; ``None`` for the directory of the mission.
        of_tree: How a behaviour tree is read; ``None`` where none is taken.
        templates: What draws the net of a mission; ``None`` for the paper's.
        as_json: Whether to answer in JSON.
        jobs: Processes that build local graphs.
        scheduler: The address of a cluster that builds them.
    """

    max_states: int | None = None
    import_root: Path | None = None
    of_tree: TreeOptions | None = None
    templates: TemplateSet | None = None
    as_json: bool = False
    jobs: int = 1
    scheduler: str | None = None

    def study(self, file: Path, engine: Asked = "auto") -> Study:
        """The study of a file, which is read, and asked of an engine, as the options say."""
        return self._opened(file).bound(engine=engine, max_states=self.max_states)

    def _opened(self, file: Path) -> Study:
        from mcpn.study import open_study

        if self.of_tree is not None:
            return open_study(file, import_root=self.import_root, templates=self.templates, **self.of_tree)
        try:
            found = open_study(file, import_root=self.import_root, templates=self.templates)
        except InputError:
            _refuse_tree(file)
            raise
        if found.ledger is not None:
            _refuse_tree(file)
        return found

    def keep_apart(self, file: Path, study: Study, *written: Path | None, made: Path | None = None) -> None:
        """Refuses to write over the files of a study, two things into one file, or where no file can be."""
        from mcpn.files import keep_apart

        if any(written):
            keep_apart(written, [file] if study.is_net else [file, *study.mission.files], made)

    def progress(self) -> AbstractContextManager[None]:
        """Shows how far the work is, unless the answer is JSON."""
        from mcpn.report.progress import progress_on_terminal

        return progress_on_terminal(self.as_json)

    @contextmanager
    def workers(self) -> Iterator[None]:
        """Shares the work with the processes that the options name."""
        from mcpn.workers import workers_of

        with workers_of(self.jobs, self.scheduler):
            yield

    @contextmanager
    def work(self) -> Iterator[None]:
        """Shows how far the work is, and shares it."""
        with self.progress(), self.workers():
            yield


def question(
    *, workers: bool = False, templates: bool = True, trees: bool = True, as_json: bool = True
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Gives a command the options that questions share, and their values as its first argument.

    Args:
        workers: Whether processes may share the work.
        templates: Whether the command knows ``--templates``.
        trees: Whether it takes behaviour trees as they are, with their options.
        as_json: Whether it knows ``--json``.
    """
    options = [*([_jobs, _scheduler] if workers else ()), _limit, _import]
    options += [*([tree_options] if trees else ()), *([_templates] if templates else ())]
    options += [json_option] if as_json else []
    shared = [field.name for field in fields(Question)]

    def given_options(command: Callable[..., None]) -> Callable[..., None]:
        @wraps(command)
        def asked(**given: Any) -> None:
            # Else numpy starts threads for its linear algebra; small products only wait for them.
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
            said = {name: given.pop(name) for name in shared if name in given}
            command(Question(**said), **given)

        for option in reversed(options):
            asked = option(asked)
        return asked

    return given_options
