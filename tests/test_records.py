"""Records do what frozen dataclasses do, and compile a method as it is first called."""

from __future__ import annotations

import copy
import inspect
import pickle
from collections.abc import Callable
from dataclasses import FrozenInstanceError, dataclass, field, fields, replace
from typing import Any

import pytest

from mcpn.records import record


@record(frozen=True, slots=True, kw_only=True)
class Part:
    """With slots, its fields given by name."""

    name: str
    size: int = 1
    where: str | None = field(default=None, compare=False)


@record(frozen=True, slots=True, kw_only=True)
class Wheel(Part):
    """Extends another record."""

    spokes: tuple[int, ...] = ()


@record(frozen=True)
class Cart:
    """With positions, a factory and a word of its own."""

    wheels: tuple[Wheel, ...]
    load: list[str] = field(default_factory=list, repr=False, hash=False)

    def __str__(self) -> str:
        return f"a cart of {len(self.wheels)}"


@record(frozen=True, eq=False)
class Self:
    """Equal to itself alone."""

    name: str


class Standard:
    """The same by the standard library."""

    @dataclass(frozen=True, slots=True, kw_only=True)
    class Part:
        """As above."""

        name: str
        size: int = 1
        where: str | None = field(default=None, compare=False)

    @dataclass(frozen=True)
    class Cart:
        """As above."""

        wheels: tuple[Any, ...]
        load: list[str] = field(default_factory=list, repr=False, hash=False)


def test_a_record_is_made_shown_compared_and_replaced_as_a_dataclass() -> None:
    for made, others in ((Part, Standard.Part), (Cart, Standard.Cart)):
        kind: Any = made
        other: Any = others
        named = {"wheels": (3,), "load": ["x"]} if kind is Cart else {"name": "a", "where": "here"}
        one, two = kind(**named), other(**named)
        assert [each.name for each in fields(one)] == [each.name for each in fields(two)]
        assert repr(one) == repr(two).removeprefix("Standard.")
        assert hash(one) == hash(two)
        assert one == kind(**named) != two
        changed = {"size": 2} if kind is Part else {"wheels": ()}
        assert repr(replace(one, **changed)) == repr(replace(two, **changed)).removeprefix("Standard.")
        assert replace(one, **changed) != one
        mine, its = (list(inspect.signature(each).parameters.values()) for each in (kind, other))
        assert [(p.name, p.kind) for p in mine] == [(p.name, p.kind) for p in its]
        assert [p.default is p.empty for p in mine] == [p.default is p.empty for p in its]


def test_fields_that_are_not_compared_count_neither_for_equality_nor_for_hashes() -> None:
    assert Part(name="a", where="x") == Part(name="a", where="y")
    assert len({Part(name="a", where="x"), Part(name="a", where="y"), Part(name="b")}) == 2
    assert Wheel(name="a") != Part(name="a")
    assert Self("a") != Self("a")


def test_each_record_has_a_list_of_its_own() -> None:
    one, two = Cart(()), Cart((), ["x"])
    one.load.append("y")
    assert (Cart(()).load, one.load, two.load) == ([], ["y"], ["x"])
    assert str(one) == "a cart of 0"


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
@pytest.mark.parametrize("one", [Wheel(name="w", where="x", spokes=(1, 2)), Cart((), ["x"])])
def test_records_are_copied_with_all_that_they_hold(one: Any, copied: Callable[[Any], Any]) -> None:
    assert copied(one) == one
    assert repr(copied(one)) == repr(one)


@pytest.mark.parametrize("name", ["name", "other"])
def test_a_record_is_not_changed(name: str) -> None:
    one = Part(name="a")
    with pytest.raises(FrozenInstanceError):
        setattr(one, name, "b")
    with pytest.raises(FrozenInstanceError):
        delattr(one, name)
    assert one.name == "a"


@pytest.mark.parametrize(
    ("given", "said"),
    [({}, "missing 1 required"), ({"name": "a", "age": 3}, "unexpected keyword argument 'age'")],
)
def test_wrong_fields_are_refused(given: dict[str, Any], said: str) -> None:
    kind: Any = Part
    with pytest.raises(TypeError, match=said):
        kind(**given)


def test_a_method_is_compiled_as_it_is_first_called() -> None:
    @record(frozen=True)
    class Fresh:
        """Of this test alone."""

        name: str

    kind: Any = Fresh

    def compiled() -> set[str]:
        of_fields = {"__init__", "__eq__", "__hash__"}
        return {each for each in of_fields if vars(kind)[each].__code__.co_filename == "<string>"}

    assert compiled() == set()
    one = Fresh("a")
    assert compiled() == {"__init__"}
    assert one == Fresh("a")
    assert compiled() == {"__init__", "__eq__"}
    assert {one}
    assert compiled() == {"__init__", "__eq__", "__hash__"}


def test_a_record_is_frozen() -> None:
    kind: Any = record
    with pytest.raises(TypeError, match="frozen"):
        kind(frozen=False)
