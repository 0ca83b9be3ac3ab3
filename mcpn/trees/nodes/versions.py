"""Libraries of behaviour trees with their versions, and what people write for them: ``nav2=1.5``."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from types import MappingProxyType

from mcpn.errors import InputError

BTCPP, NAV2, PLANSYS2, PY_TREES = "btcpp", "nav2", "plansys2", "py_trees"
NAMES = MappingProxyType(
    {BTCPP: "BehaviorTree.CPP", NAV2: "Nav2", PLANSYS2: "PlanSys2", PY_TREES: "py_trees"}
)
"""Each library as people call it, by what is written for it."""
VERSIONS = MappingProxyType(
    {
        BTCPP: ("3.0", "3.1", "3.5", "3.6", "3.7", "3.8", *(f"4.{minor}" for minor in range(11))),
        NAV2: ("1.1", "1.2", "1.3", "1.4", "1.5"),
        PLANSYS2: ("2.0", "3.0"),
        PY_TREES: ("2.6",),
    }
)
"""The versions of each library that the table of nodes tells apart, the oldest first, without repairs.

Nav2 1.1 is that of ROS Humble, 1.2 of Iron, 1.3 of Jazzy, 1.4 of Kilted. py_trees reads XML since 2.6.
"""
BUILT_ON = MappingProxyType(
    {
        NAV2: {
            "1.1": ("3.8", "3.8"),
            "1.2": ("3.8", "3.8"),
            "1.3": ("4.5", ""),
            "1.4": ("4.5", ""),
            "1.5": ("4.5", ""),
        }
    }
)
"""The versions of BehaviorTree.CPP with which one of Nav2 is built: the first, the last if there is one."""

Allowed = dict[str, frozenset[str]]
"""By library, the versions that a tree may be for."""


def between(library: str, first: str = "", last: str = "") -> frozenset[str]:
    """The versions of a library from one to another, both included; by default from the first to the last."""
    known = VERSIONS[library]
    begin = known.index(first) if first else 0
    end = known.index(last) if last else len(known) - 1
    return frozenset(known[begin : end + 1])


def asked(written: Iterable[str]) -> Allowed:
    """What people ask for: ``nav2=1.5``, ``btcpp=4.8.2``, ``py_trees``.

    Raises:
        InputError: No such library, or a version that the table does not know.
    """
    found: Allowed = {}
    for text in written:
        name, _, version = text.strip().partition("=")
        library = name.strip().lower()
        if library not in NAMES:
            known = ", ".join(f"{each}={VERSIONS[each][-1]}" for each in NAMES)
            raise InputError.at(None, f"--library {text!r}: no library {name!r}, expected one like {known}")
        short = ".".join(version.strip().split(".")[:2])
        matching = frozenset(v for v in VERSIONS[library] if short in ("", v) or v.partition(".")[0] == short)
        if not matching:
            known = ", ".join(VERSIONS[library])
            raise InputError.at(
                None,
                f"--library {text!r}: no version {version!r} of {NAMES[library]}, expected one of {known}",
            )
        found[library] = found.get(library, matching) & matching
    return found


def told(library: str, versions: Collection[str]) -> str:
    """Some versions of a library, as people read them: Nav2 1.1 to 1.4."""
    known = VERSIONS[library]
    runs: list[list[str]] = []
    for version in (each for each in known if each in versions):
        if runs and known.index(runs[-1][-1]) + 1 == known.index(version):
            runs[-1].append(version)
        else:
            runs.append([version])
    said = " and ".join(run[0] if len(run) == 1 else f"{run[0]} to {run[-1]}" for run in runs)
    return f"{NAMES[library]} {said}"


def built_together(allowed: Mapping[str, frozenset[str]]) -> Allowed:
    """What is left of versions where one library is built on some of another's alone."""
    found = dict(allowed)
    for library, on in BUILT_ON.items():
        below = {version: between(BTCPP, *on[version]) for version in found[library]}
        found[library] = frozenset(v for v, these in below.items() if these & found[BTCPP])
        found[BTCPP] &= frozenset().union(*(below[v] for v in found[library]))
    return found
