"""Files as studies: what ``mcpn.open`` calls."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mcpn.errors import InputError, Source
from mcpn.nets.petri import PetriNet
from mcpn.study import Study

if TYPE_CHECKING:
    from mcpn.drawing.compose import MissionNet
    from mcpn.drawing.templates import TemplateSet
    from mcpn.mission.model import Mission


def open_study(
    subject: str | Path | Mission | MissionNet | PetriNet,
    *,
    import_root: str | Path | None = None,
    templates: TemplateSet | None = None,
) -> Study:
    """Opens a mission or a net to ask questions about it; ``mcpn.open`` is its name for users.

    Args:
        subject: The file of a mission or a net (``.net``, ``.pnml``, ``.json``), or what is read already.
        import_root: The directory that imports of a mission must stay in; by default the mission's own.
        templates: What draws the net of a mission; the paper's by default.

    Raises:
        InputError: No valid mission, or no net, with every problem and its line; or templates for a net.

    Examples:
        >>> study = open_study("experiments/ulysse/mission.xml")
        >>> study
        <study of the mission ulysse>
        >>> study.states().states, study.check().stable_sizes
        (44299, (260, 1332))
    """
    file = Path(subject) if isinstance(subject, (str, Path)) else None
    root = None if import_root is None else Path(import_root)
    found = _read(Path(subject), root) if isinstance(subject, (str, Path)) else subject
    if isinstance(found, PetriNet) and templates is not None:
        source = None if file is None else Source(str(file))
        raise InputError.at(source, "found a net, expected a mission: templates draw missions")
    return Study(found, templates=templates, file=file)


def _read(file: Path, root: Path | None) -> Mission | PetriNet:
    from mcpn.nets.formats import READABLE, read_net

    if file.suffix.lower() in READABLE:
        return read_net(file)
    from mcpn.mission.xml import read_mission  # which a question about a net does not load

    try:
        return read_mission(file, import_root=root)
    except InputError as error:
        from mcpn.answers.drafts import with_formulas

        raise with_formulas(error) from None
