"""Compiled kernels on disk, found by what they were made of.

numba asks for the date of a kernel's own file. Code that changed elsewhere, in a subroutine or a
record's fields, would be taken for unchanged, and code that only moved for new.
"""

from __future__ import annotations

import hashlib
import types
from collections.abc import Iterator
from typing import Any

import numpy as np
from numba.core import event
from numba.core import types as numba_types
from numba.core.caching import FunctionCache
from numba.core.dispatcher import Dispatcher

LOADED = "cavalcade:kernel-loaded"
"""The kind of numba event that tells of a kernel that was on disk; its data are the function."""


class KernelCache(FunctionCache):
    """numba's cache in its usual places, with a stamp of the code in place of a file's date."""

    def __init__(self, function: types.FunctionType, options: str) -> None:
        super().__init__(function)
        self._options = options

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """What is kept for a signature, or None."""
        self._stamp()
        try:
            found = super().load_overload(sig, target_context)
        except Exception:
            # Kept by code that is no more: a record's module went, a class has other fields. What
            # lies there is of no use whatever the reason; compiling it anew always is.
            self._cache_file.flush()
            return None
        if found is not None:
            event.end_event(LOADED, data=self._py_func)
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled for a signature."""
        self._stamp()
        super().save_overload(sig, data)

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        # numba takes records for equal whose fields have other names but the same types.
        return super()._index_key(sig, codegen), _fields(sig)

    def _stamp(self) -> None:
        self._cache_file._source_stamp = fingerprint(self._py_func, self._options)


def fingerprint(function: types.FunctionType, options: str) -> str:
    """A digest of a function's byte code and compiler options, of all compiled functions that it
    reaches, and of the constants and record types that these name.
    """
    digest = hashlib.sha256(options.encode())
    reached = reached_from(function)
    for part in sorted(_own(function) + said for function, said in reached.items()):
        digest.update(part.encode())
    return digest.hexdigest()


def reached_from(function: types.FunctionType) -> dict[types.FunctionType, str]:
    """A function and all compiled ones that it calls, at whatever depth, with their options."""
    reached = {function: ""}
    waiting = [function]
    while waiting:
        for value in _named(waiting.pop()):
            if isinstance(value, Dispatcher) and value.py_func not in reached:
                reached[value.py_func] = options_of(value)
                waiting.append(value.py_func)
    return reached


def options_of(dispatcher: Dispatcher) -> str:
    """The compiler options of a compiled function, as text in one order."""
    return repr(sorted((key, _text(value)) for key, value in dispatcher.targetoptions.items()))


def code_objects(function: types.FunctionType) -> Iterator[types.CodeType]:
    """A function's code and that of all functions inside it."""
    waiting = [function.__code__]
    while waiting:
        code = waiting.pop()
        yield code
        waiting += [value for value in code.co_consts if isinstance(value, types.CodeType)]


def _own(function: types.FunctionType) -> str:
    """A function's byte code and the values that it names, as text."""
    parts = [function.__module__, function.__qualname__]
    for code in code_objects(function):
        parts.append(code.co_code.hex())
        parts += [_text(value) for value in code.co_consts]
        parts += [*code.co_names, *code.co_varnames]
    parts += [_text(value) for value in _named(function)]
    return "\n".join(parts)


def _named(function: types.FunctionType) -> Iterator[object]:
    """The values of the names in a function: globals, what it closes over, what modules hold."""
    names = [name for code in code_objects(function) for name in code.co_names]
    found = [function.__globals__[name] for name in names if name in function.__globals__]
    found += [cell.cell_contents for cell in function.__closure__ or ()]
    for value in found:
        if isinstance(value, types.ModuleType):
            if value.__name__.partition(".")[0] == function.__module__.partition(".")[0]:
                yield from (getattr(value, name) for name in names if hasattr(value, name))
        else:
            yield value


def _fields(kind: Any) -> str:
    """The names of all fields of records in a type, or in several."""
    if isinstance(kind, numba_types.BaseNamedTuple):
        return f"{kind.fields}{[_fields(part) for part in kind]}"
    if isinstance(kind, tuple | numba_types.BaseTuple):
        return "".join(_fields(part) for part in kind)
    return ""


def _text(value: object) -> str:
    """A value as text that is the same in each process, or nothing where it has no say."""
    if isinstance(value, set | frozenset):
        return repr(sorted(map(repr, value)))
    if isinstance(value, tuple):
        return repr([_text(item) for item in value])
    if isinstance(value, int | float | complex | str | bytes | np.generic | np.dtype | None):
        return repr(value)
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
    if isinstance(value, type):
        return f"{value.__qualname__} {getattr(value, '_fields', ())}"
    return ""
