"""Dataclasses that are quick to make: a command line loads over a hundred of them before it answers.

The standard library compiles the source of up to six methods for each class, which is more than half of what
loading a model of frozen classes costs. Here ``__init__`` alone is compiled; what compares, hashes, shows and
protects the fields is shared by all classes, or closes over their names. :func:`dataclasses.fields`,
``replace``, ``asdict`` and pickling work as they always do.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

__all__ = ["dataclass"]

if TYPE_CHECKING:
    from dataclasses import dataclass
else:
    import dataclasses
    import operator
    from reprlib import recursive_repr

    def dataclass(cls=None, /, **words):
        """Makes a class a dataclass, as :func:`dataclasses.dataclass` does with the same words."""

        def made(cls):
            return _made(cls, **words)

        return made if cls is None else made(cls)

    def _made(cls, init=True, repr=True, eq=True, order=False, frozen=False, slots=False, kw_only=False):
        own = dict(cls.__dict__)
        cls = dataclasses.dataclass(cls, init=False, repr=False, eq=False, kw_only=kw_only)
        fields = dataclasses.fields(cls)
        if slots:
            cls = _with_slots(cls, [f.name for f in fields], frozen)
        if init and "__init__" not in own:
            cls.__init__ = _init(cls, fields, frozen, slots)
        if repr and "__repr__" not in own:
            cls.__repr__ = _repr
        compared = _values([f.name for f in fields if f.compare])
        if eq:
            if "__eq__" not in own:
                cls.__eq__ = _comparing(compared, operator.eq)
            if own.get("__hash__") is None:
                hashed = [f.name for f in fields if (f.compare if f.hash is None else f.hash)]
                cls.__hash__ = _hash(_values(hashed)) if frozen else None
        for name in ("lt", "le", "gt", "ge") if order else ():
            setattr(cls, f"__{name}__", _comparing(compared, getattr(operator, name)))
        if frozen:
            cls.__setattr__, cls.__delattr__ = _refuse_set, _refuse_delete
        return cls

    def _with_slots(cls, names, frozen):
        """The class once more, with slots in place of a dictionary for each object."""
        inherited = {slot for base in cls.__mro__[1:-1] for slot in getattr(base, "__slots__", ())}
        body = {name: value for name, value in cls.__dict__.items() if name not in names}
        body.pop("__dict__", None)
        body.pop("__weakref__", None)
        body["__slots__"] = tuple(name for name in names if name not in inherited)
        if frozen:
            body.setdefault("__getstate__", _state)
            body.setdefault("__setstate__", _set_state)
        made = type(cls)(cls.__name__, cls.__bases__, body)
        made.__qualname__ = cls.__qualname__
        return made

    def _init(cls, fields, frozen, slots):
        """The one method that is compiled: it is called for each object."""
        known = {"_set": object.__setattr__, "_FACTORY": _FACTORY}
        given, named, lines = [], [], []
        for f in fields:
            name = f.name
            if f.default is not dataclasses.MISSING:
                known[f"_default_{name}"] = f.default
                default = f"=_default_{name}"
            elif f.default_factory is not dataclasses.MISSING:
                known[f"_make_{name}"] = f.default_factory
                default = "=_FACTORY"
            else:
                default = ""
                if f.init and not f.kw_only and "=" in "".join(given):
                    raise TypeError(f"non-default argument {name!r} follows default argument")
            value = name
            if default == "=_FACTORY":
                value = f"_make_{name}() if {name} is _FACTORY else {name}" if f.init else f"_make_{name}()"
            elif not f.init:
                if not default or not slots:
                    continue
                value = f"_default_{name}"
            lines.append(f"  _set(self, {name!r}, {value})" if frozen else f"  self.{name} = {value}")
            if f.init:
                (named if f.kw_only else given).append(f"{name}{default}")
        if hasattr(cls, "__post_init__"):
            lines.append("  self.__post_init__()")
        arguments = ", ".join(["self", *given, *(["*", *named] if named else [])])
        text = f"def make({', '.join(known)}):\n def __init__({arguments}):\n"
        text += "\n".join(lines or ["  pass"]) + "\n return __init__"
        module = sys.modules.get(cls.__module__)
        made = {}
        exec(text, {} if module is None else module.__dict__, made)
        init = made["make"](**known)
        init.__qualname__ = f"{cls.__qualname__}.__init__"
        init.__annotations__ = {f.name: f.type for f in fields if f.init} | {"return": None}
        return init

    class _Factory:
        def __repr__(self):
            return "<factory>"

    _FACTORY = _Factory()

    def _values(names):
        """What gives the values of some fields of an object, as a tuple."""
        if len(names) > 1:
            return operator.attrgetter(*names)
        if not names:
            return lambda _: ()
        value = operator.attrgetter(names[0])
        return lambda of: (value(of),)

    def _comparing(values, compare):
        def compared(self, other):
            if other.__class__ is not self.__class__:
                return NotImplemented
            return compare(values(self), values(other))

        return compared

    def _hash(values):
        def hashed(self):
            return hash(values(self))

        return hashed

    @recursive_repr()
    def _repr(self):
        shown = (f"{f.name}={getattr(self, f.name)!r}" for f in dataclasses.fields(self) if f.repr)
        return f"{self.__class__.__qualname__}({', '.join(shown)})"

    def _refuse_set(self, name, value):
        if _protected(self, name):
            raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
        object.__setattr__(self, name, value)

    def _refuse_delete(self, name):
        if _protected(self, name):
            raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")
        object.__delattr__(self, name)

    def _protected(of, name):
        """Whether an attribute may not change: of a frozen class all, of one derived from it its fields."""
        cls = type(of)
        return "__dataclass_fields__" in cls.__dict__ or name in cls.__dataclass_fields__

    def _state(self):
        return [getattr(self, f.name) for f in dataclasses.fields(self)]

    def _set_state(self, state):
        for f, value in zip(dataclasses.fields(self), state, strict=True):
            object.__setattr__(self, f.name, value)
