"""Classes made by mcpn.records beside the same ones made by the standard library."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import operator
import pickle
import re
from collections.abc import Callable
from functools import partial
from itertools import product
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn import records
from mcpn.errors import Source
from mcpn.mission.robot import Hardware
from tests.draws import fewer

NAMES = ("a", "b", "c")
WORDS = st.fixed_dictionaries(
    {
        "frozen": st.booleans(),
        "slots": st.booleans(),
        "order": st.booleans(),
        "repr": st.booleans(),
        "kw_only": st.booleans(),
    }
)
FIELD = st.fixed_dictionaries(
    {},
    optional={
        "default": st.integers(0, 2),
        "repr": st.booleans(),
        "compare": st.booleans(),
        "hash": st.none() | st.booleans(),
        "kw_only": st.booleans(),
        "init": st.booleans(),
    },
) | st.just({"default_factory": list})
VALUES = st.lists(st.integers(0, 1) | st.text("ab", max_size=1), min_size=3, max_size=3)


def tried(what: Callable[[], object]) -> object:
    """What is returned, or the type of the error and what it says."""
    try:
        return what()
    except (TypeError, AttributeError, ValueError) as error:
        return type(error), str(error)


def shown(what: Callable[[], object]) -> str:
    """How that is shown, addresses aside."""
    return re.sub(r" object at 0x\w+|<factory>", "", str(tried(lambda: repr(what()))))


def made(decorate: Any, words: dict[str, bool], each: list[dict[str, Any]], own: bool) -> Any:
    """A class with some fields, and one derived from it with a field more."""
    body: dict[str, Any] = {"__annotations__": dict.fromkeys(NAMES, "object"), "__doc__": "Drawn."}
    body |= {name: dataclasses.field(**of) for name, of in zip(NAMES, each, strict=True)}
    if own:
        body |= {"__eq__": lambda self, other: True, "__repr__": lambda self: "own"}
    base = decorate(**words)(type("Drawn", (), body))
    more = {"__annotations__": {"d": "int"}, "d": 4, "__doc__": "Derived."}
    return base, decorate(**words)(type("Derived", (base,), more))


def seen(cls: Any, values: list[list[Any]]) -> list[object]:
    """What may be seen of a class and its objects."""
    inits = [f.name for f in dataclasses.fields(cls) if f.init]
    named = [dict(zip(inits, some, strict=False)) for some in values]
    told: list[object] = [
        shown(lambda: str(inspect.signature(cls))),
        [(f.name, f.init, f.compare, f.kw_only) for f in dataclasses.fields(cls)],
        cls.__match_args__,
        cls.__hash__ is None,
        cls.__dict__.get("__slots__"),
        *(shown(partial(cls, *some)) for some in values),
        *(shown(partial(cls, **some)) for some in named),
    ]
    objects = [one for some in named if isinstance(one := tried(partial(cls, **some)), cls)]
    for one, two in product(objects, repeat=2):
        told += [shown(partial(compare, one, two)) for compare in (operator.eq, operator.lt)]
        told.append(tried(partial(hash, one)) == tried(partial(hash, two)))
    for one in objects:
        told += [shown(partial(copy.copy, one)), tried(lambda one=one: copy.copy(one) == one)]  # type: ignore[misc]
        told += [shown(partial(dataclasses.replace, one, **{name: 7})) for name in inits]
        told += [shown(partial(setattr, one, "a", 5)), shown(partial(delattr, one, "b")), shown(lambda: one)]  # noqa: B023
    return told


@fewer(0.3)
@given(
    WORDS,
    st.lists(FIELD, min_size=3, max_size=3),
    st.lists(VALUES, min_size=1, max_size=3),
    st.booleans(),
)
def test_classes_are_those_of_the_standard_library(
    words: dict[str, bool], each: list[dict[str, Any]], values: list[list[Any]], own: bool
) -> None:
    expected = tried(lambda: made(dataclasses.dataclass, words, each, own))
    found = tried(lambda: made(records.dataclass, words, each, own))
    assert isinstance(expected, tuple)
    assert isinstance(found, tuple)
    if issubclass(expected[0], Exception):
        assert found == expected
        return
    assert [seen(cls, values) for cls in found] == [seen(cls, values) for cls in expected]


def test_objects_go_through_pickle_and_are_protected() -> None:
    hardware = Hardware(name="gps", faulty=False)
    assert pickle.loads(pickle.dumps(hardware)) == hardware
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot assign to field 'name'"):
        hardware.name = "imu"  # type: ignore[misc]
    assert Source("a", 1) < Source("a", 2)
    assert not hasattr(hardware, "__dict__")
