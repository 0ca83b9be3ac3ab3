"""Stands in for the kernel where it is not in this folder: loads the installed one, or says what to do.

In a checkout Python imports the folder ``mcpn`` beside a script before the package that ``pip install .`` has
put into the environment, and the kernel is built into that one alone. Where the kernel is in this folder,
Python takes it and not this file.
"""

import sys
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader, FileFinder, ModuleSpec
from importlib.util import module_from_spec
from pathlib import Path

from mcpn.errors import LimitError

_HERE = Path(__file__).resolve().parent


def _installed() -> ModuleSpec:
    """The kernel of an installed mcpn with the same interface as this one.

    Raises:
        LimitError: There is none.
    """
    why = "which is not built there"
    for entry in sys.path:
        folder = Path(entry, "mcpn").resolve()
        found = FileFinder(str(folder), (ExtensionFileLoader, EXTENSION_SUFFIXES)).find_spec(__name__)
        if folder == _HERE or found is None:
            continue
        if (folder / "_kernel.pyi").read_bytes() == (_HERE / "_kernel.pyi").read_bytes():
            return found
        why = f"and the one that is installed in {folder} is of another version"
    raise LimitError(
        f"{_HERE} needs the compiled kernel, {why}: run pip install . in {_HERE.parent}, "
        f"with the Python that runs this ({sys.executable})"
    )


_spec = _installed()
sys.modules[__name__] = module_from_spec(_spec)
assert _spec.loader is not None
_spec.loader.exec_module(sys.modules[__name__])
