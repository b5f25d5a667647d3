"""Compiled kernels on disk, found by what they were made of.

numba asks for the date of a kernel's own file and names what it keeps by a line's number. Code
that changed elsewhere, in a subroutine or a record's fields, would be taken for unchanged, and
code that only moved for new.
"""

from __future__ import annotations

import contextlib
import hashlib
import sys
import types
from collections.abc import Iterator
from typing import Any

import numpy as np
from numba.core import event
from numba.core import types as numba_types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.dispatcher import Dispatcher
from numba.core.extending import _Intrinsic

LOADED = "cavalcade:kernel-loaded"
"""The kind of numba event that tells of a kernel that was on disk; its data are the function."""


class _Files(IndexDataCacheFile):
    """An index with a stamp of the code, and data that are named by what they hold.

    numba numbers the data. Two processes that keep different signatures at once could then write
    one file for both, and one that is killed in between leave an index of other data.
    """

    def save(self, key: Any, data: Any) -> None:
        """Keep data: first they, then the index that names them."""
        digest = hashlib.sha256(repr((self._source_stamp, key)).encode()).hexdigest()[:16]
        name = self._index_name.removesuffix("nbi") + digest + ".nbc"
        self._save_data(name, data)
        self._save_index(self._load_index() | {key: name})


class _Place(CompileResultCacheImpl):
    """numba's usual places; files are named by module and function alone."""

    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        """Without the number of the line."""
        name = fullname.replace("<", "").replace(">", "")
        return f"{name}.py{sys.version_info[0]}{sys.version_info[1]}{abiflags}"


class KernelCache(FunctionCache):
    """What is kept of one kernel."""

    _impl_class = _Place

    def __init__(self, function: types.FunctionType, options: str) -> None:
        super().__init__(function)
        self._options = options
        self._cache_file = _Files(self._cache_path, self._impl.filename_base, None)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """What is kept for a signature, or None."""
        self._stamp()
        try:
            found = super().load_overload(sig, target_context)
        except Exception:
            # Kept by code that is no more: a record's module went, a class has other fields. What
            # lies there is of no use whatever the reason; compiling it anew always is.
            with contextlib.suppress(OSError):
                self._cache_file.flush()
            return None
        if found is None or found.signature.args != tuple(sig):
            return None
        event.end_event(LOADED, data=self._py_func)
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled for a signature, where that can be written."""
        self._stamp()
        with contextlib.suppress(OSError):
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
            called, options = None, ""
            if isinstance(value, Dispatcher):
                called, options = value.py_func, options_of(value)
            elif isinstance(value, _Intrinsic):
                called = value._defn
            if called is not None and called not in reached:
                reached[called] = options
                waiting.append(called)
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
    parts = [function.__module__, function.__qualname__, _text(function.__defaults__)]
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
    """A value as text that is the same in each process; of what has no say only its kind."""
    if isinstance(value, Dispatcher):
        return f"{value.py_func.__module__}.{value.py_func.__qualname__}"
    if isinstance(value, set | frozenset):
        return repr(sorted(map(_text, value)))
    if isinstance(value, tuple | list):
        return repr([_text(item) for item in value])
    if isinstance(value, int | float | complex | str | bytes | np.generic | np.dtype | None):
        return repr(value)
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
    if isinstance(value, type):
        return f"{value.__qualname__} {getattr(value, '_fields', ())}"
    return type(value).__qualname__
