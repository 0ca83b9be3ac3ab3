"""Dataclasses whose methods are compiled as they are first called, not as modules are imported.

The standard library compiles each method of each dataclass as the class is made: of some hundred classes that
takes longer than many a mission takes to be checked, and most of the methods are never called.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, Field, FrozenInstanceError, dataclass, fields
from typing import TYPE_CHECKING, Any

__all__ = ["record"]

FEW = 20
"""Records of a class that take less time without a compiled ``__init__`` than it takes to be compiled."""

if TYPE_CHECKING:
    from dataclasses import dataclass as record
else:

    def record(
        *,
        frozen: bool = False,
        slots: bool = False,
        kw_only: bool = False,
        eq: bool = True,
        repr: bool = True,
    ) -> Callable[[type], type]:
        """Makes a class a dataclass, as ``dataclass`` of the standard library does.

        Records extend records alone: to the standard library they are dataclasses that are not frozen.

        Args:
            frozen: Whether fields are set once.
            slots: Whether fields are slots.
            kw_only: Whether fields are given by their names.
            eq: Whether records that say the same are equal; frozen ones have one hash then, others have none.
            repr: Whether records show their fields.
        """

        def made(declared: type) -> type:
            own = set(vars(declared))
            cls = dataclass(init=False, repr=False, eq=False, slots=slots, kw_only=kw_only)(declared)
            methods: dict[str, Any] = {"__init__": _filled_at_first(cls)}
            if frozen:
                methods |= {"__setattr__": _not_set, "__delattr__": _not_deleted}
            if "__init__" not in own:
                methods |= {"__signature__": _Signature()}
            if frozen and slots:
                methods |= {"__getstate__": _state, "__setstate__": _restore}
            if repr:
                methods |= {"__repr__": _shown}
            if eq and "__eq__" not in own:
                methods |= {"__eq__": _compiled_later(cls, "__eq__", _eq)}
            if eq and ("__hash__" not in own or vars(declared)["__hash__"] is None):
                methods |= {"__hash__": _compiled_later(cls, "__hash__", _hash) if frozen else None}
            for name, method in methods.items():
                if name not in own or name == "__hash__":
                    setattr(cls, name, method)
            return cls

        return made


def _compiled_later(cls: type, name: str, text: Callable[[type], tuple[str, dict[str, Any]]]) -> Any:
    """A method that puts the compiled one in its place as it is called."""

    def first(self: object, *args: Any, **given: Any) -> Any:
        said, known = text(cls)
        exec(said, known)
        method = known[name]
        method.__qualname__, method.__module__ = f"{cls.__qualname__}.{name}", cls.__module__
        setattr(cls, name, method)
        return method(self, *args, **given)

    first.__name__, first.__qualname__ = name, f"{cls.__qualname__}.{name}"
    return first


def _filled_at_first(cls: type) -> Any:
    """``__init__``, which is compiled where more than a few records of a class are made."""
    compiled = _compiled_later(cls, "__init__", _init)
    left = FEW

    def first(self: object, *args: Any, **given: Any) -> None:
        nonlocal left
        left -= 1
        if left < 0 or not _filled(self, cls, args, given):
            compiled(self, *args, **given)

    first.__name__, first.__qualname__ = "__init__", f"{cls.__qualname__}.__init__"
    return first


def _filled(made: Any, cls: Any, args: tuple[Any, ...], given: dict[str, Any]) -> bool:
    """Sets the fields of a record; whether what is given fits them, as the compiled method says more of."""
    by_place = (each.name for each in fields(cls) if each.init and not each.kw_only)
    values = {**dict(zip(by_place, args, strict=False)), **given}
    if len(values) < len(args) + len(given):  # some twice, or too many
        return False
    for each in fields(cls):
        if each.init and each.name in values:
            value = values.pop(each.name)
        elif each.default is not MISSING:
            value = each.default
        elif each.default_factory is not MISSING:
            value = each.default_factory()
        elif each.init:
            return False
        else:
            continue
        object.__setattr__(made, each.name, value)
    if values:
        return False
    if hasattr(cls, "__post_init__"):
        made.__post_init__()
    return True


def _init(cls: type) -> tuple[str, dict[str, Any]]:
    """The text of ``__init__``, and what it knows: how fields are set, and their defaults."""
    known: dict[str, Any] = {"_set": object.__setattr__, "_none": MISSING}
    body: list[str] = []
    for each in fields(cls):
        value = each.name
        if each.default_factory is not MISSING:
            known[f"_of_{each.name}"] = each.default_factory
            value = f"_of_{each.name}()"
            if each.init:
                value += f" if {each.name} is _none else {each.name}"
        elif each.default is not MISSING:
            known[f"_of_{each.name}"] = each.default
            if not each.init:
                value = f"_of_{each.name}"
        elif not each.init:
            continue
        slot = getattr(vars(cls).get(each.name), "__set__", None)
        if slot is not None:
            known[f"_set_{each.name}"] = slot
            body.append(f"  _set_{each.name}(self, {value})")
        else:
            body.append(f"  _set(self, {each.name!r}, {value})")
    if hasattr(cls, "__post_init__"):
        body.append("  self.__post_init__()")
    given = [each for each in fields(cls) if each.init]
    by_place = [_parameter(each) for each in given if not each.kw_only]
    by_name = [_parameter(each) for each in given if each.kw_only]
    parameters = ", ".join(["self", *by_place, *(["*", *by_name] if by_name else [])])
    return "\n".join([f"def __init__({parameters}):", *(body or ["  pass"])]), known


def _parameter(each: Field[Any]) -> str:
    if each.default_factory is not MISSING:
        return f"{each.name}=_none"
    return each.name if each.default is MISSING else f"{each.name}=_of_{each.name}"


def _eq(cls: type) -> tuple[str, dict[str, Any]]:
    compared = [each.name for each in fields(cls) if each.compare]
    mine, others = (_values(of, compared) for of in ("self", "other"))
    alike = "other.__class__ is self.__class__"
    return f"def __eq__(self, other):\n  return {mine} == {others} if {alike} else NotImplemented", {}


def _hash(cls: type) -> tuple[str, dict[str, Any]]:
    hashed = [each.name for each in fields(cls) if (each.compare if each.hash is None else each.hash)]
    return f"def __hash__(self):\n  return hash({_values('self', hashed)})", {}


def _values(of: str, names: list[str]) -> str:
    return f"({''.join(f'{of}.{name}, ' for name in names)})"


def _shown(self: Any) -> str:
    values = ", ".join(f"{each.name}={getattr(self, each.name)!r}" for each in fields(self) if each.repr)
    return f"{type(self).__qualname__}({values})"


def _not_set(_self: object, name: str, _value: object) -> None:
    raise FrozenInstanceError(f"cannot assign to field {name!r}")


def _not_deleted(_self: object, name: str) -> None:
    raise FrozenInstanceError(f"cannot delete field {name!r}")


def _state(self: Any) -> list[Any]:
    return [getattr(self, each.name) for each in fields(self)]


def _restore(self: Any, state: list[Any]) -> None:
    for each, value in zip(fields(self), state, strict=True):
        object.__setattr__(self, each.name, value)


class _Signature:
    """What ``inspect.signature`` and ``help`` say of how a record is made."""

    def __get__(self, _record: object, cls: Any) -> Any:
        from inspect import Parameter, Signature

        kinds = {True: Parameter.KEYWORD_ONLY, False: Parameter.POSITIONAL_OR_KEYWORD}
        given = [each for each in fields(cls) if each.init]
        parameters = [Parameter(each.name, kinds[bool(each.kw_only)], annotation=each.type) for each in given]
        for number, each in enumerate(given):
            default = each.default if each.default_factory is MISSING else each.default_factory
            if default is not MISSING:
                parameters[number] = parameters[number].replace(default=default)
        return Signature(sorted(parameters, key=lambda each: each.kind))
