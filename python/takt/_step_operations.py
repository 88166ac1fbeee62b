"""The operations as steps of a program tree, from the tables of the core. Types: _step_operations.pyi, printed by
`python3 -m takt.stubs`."""
from __future__ import annotations

from typing import Any, Callable

from ._errors import refuse
from ._operations import Specification, plain, python_name, specifications
from ._tree import Step


def _maker(spec: Specification) -> Callable[..., Step]:
    positional = spec.positional()

    def make(*arguments: Any, **keywords: Any) -> Step:
        if len(arguments) > len(positional):
            raise refuse("usage", "", f"{spec.name}() accepts {len(positional)} arguments without a keyword",
                         "Name the others: KEY=VALUE")
        row: dict[str, Any] = {"do": spec.name}
        for one, value in zip(positional, arguments):
            row[one["key"]] = plain(value, "/" + one["key"])
        for name, value in keywords.items():
            key = spec.by_python.get(name, name)
            if key in row:
                raise refuse("duplicate", "/" + key, f"{spec.name}() got '{key}' twice", "Give it once")
            if value is not None:
                row[key] = plain(value, "/" + key)
        return Step(row)
    make.__name__ = make.__qualname__ = python_name(spec.name)
    make.__doc__ = spec.docstring()
    return make


__all__ = [python_name(one.name) for one in specifications().values()]
globals().update({python_name(one.name): _maker(one) for one in specifications().values()})
