"""Records do what dataclasses do, and compile a method as it is first called."""

from __future__ import annotations

import copy
import inspect
import pickle
from collections.abc import Callable
from dataclasses import FrozenInstanceError, dataclass, field, fields, replace
from typing import Any

import pytest

from mcpn.records import FEW, record


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
    for _ in range(FEW + 2):  # at first, and by the compiled method
        with pytest.raises(TypeError, match=said):
            kind(**given)


@pytest.mark.parametrize(
    ("args", "given", "said"),
    [((1, [], 3), {}, "takes from 2 to 3 positional"), ((1,), {"wheels": ()}, "multiple values")],
)
def test_wrong_places_are_refused(args: tuple[Any, ...], given: dict[str, Any], said: str) -> None:
    @record(frozen=True)
    class Fresh:
        """Of this test alone."""

        wheels: tuple[int, ...]
        load: list[str] = field(default_factory=list)

    kind: Any = Fresh
    for _ in range(FEW + 2):
        with pytest.raises(TypeError, match=said):
            kind(*args, **given)


def test_the_first_records_are_as_those_after_them() -> None:
    @record(frozen=True, slots=True)
    class Fresh:
        """Of this test alone."""

        name: str
        size: int = 1
        load: list[str] = field(default_factory=list, kw_only=True)

    made = [Fresh("a", load=["x"]) for _ in range(2 * FEW)] + [Fresh("a", 1, load=["x"])]
    assert all(one == made[0] and repr(one) == repr(made[0]) for one in made)
    assert [Fresh("a").load for _ in range(2)] == [[], []]


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
    assert compiled() == set()
    assert [Fresh("a") for _ in range(FEW)]
    assert compiled() == {"__init__"}
    assert one == Fresh("a")
    assert compiled() == {"__init__", "__eq__"}
    assert {one}
    assert compiled() == {"__init__", "__eq__", "__hash__"}


def test_a_record_that_is_not_frozen_changes_and_has_no_hash() -> None:
    @record(slots=True)
    class Open:
        """Of this test alone."""

        name: str
        seen: list[str] = field(default_factory=list)

    one = Open("a")
    one.name = "b"
    assert one == Open("b") != Open("a")
    assert copy.copy(one) == one
    with pytest.raises(TypeError, match="unhashable"):
        hash(one)


def test_fields_that_nobody_gives_have_their_defaults_or_wait() -> None:
    @record(frozen=True, slots=True)
    class Fresh:
        """Of this test alone."""

        name: str
        wheels: int = field(default=4, init=False)
        load: list[str] = field(default_factory=list, init=False)
        towed: str = field(init=False)
        colour: str = "red"

    kind: Any = Fresh
    assert [*inspect.signature(kind).parameters] == ["name", "colour"]
    for _ in range(FEW + 2):
        one = kind("a", "blue")
        assert (one.wheels, one.load, one.colour) == (4, [], "blue")
        assert not hasattr(one, "towed")
        assert replace(one, name="b").wheels == 4
        with pytest.raises(TypeError, match="unexpected keyword argument 'wheels'"):
            kind("a", wheels=3)
        with pytest.raises(TypeError, match="takes from 2 to 3 positional"):
            kind("a", "blue", 3)
