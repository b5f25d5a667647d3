"""How far compilation is: work done and to be done, counted in byte code.

How long numba takes over a function grows with the length of its byte code, near enough for an
estimate. A kernel's work is that of all subroutines that it reaches, each counted once.
"""

from __future__ import annotations

import importlib
import pkgutil
import time as clock
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import FunctionType

from numba.core import event
from numba.core.dispatcher import Dispatcher

from cavalcade.kernels.cache import LOADED, KernelCache, code_objects, reached_from

_RATE = 0.6e-3
"""What a byte of code takes before anything is known of the machine, s."""

_TRUST = 0.1
"""The share of all work for which that guess counts as if it had been measured."""


class Compilation:
    """What is compiled and loaded while it is watched.

    Args:
        modules: Modules and packages with the kernels that are going to be used,
        unused: but for these functions, by module and name, and those that these modules define.
        tell: Called whenever a function is begun or done.

    Attributes:
        kernels: How many functions have been compiled so far; 0 where all were on disk.
    """

    def __init__(
        self,
        modules: Iterable[str],
        unused: Iterable[str],
        tell: Callable[[Compilation], None],
    ) -> None:
        self._modules, self._unused = tuple(modules), frozenset(unused)
        self._tell = tell
        self._left: dict[FunctionType, int] | None = None
        self._total = 0
        self._ready: set[FunctionType] = set()
        self._began = 0.0
        self.kernels = 0

    @property
    def share(self) -> float:
        """Of all work, how much is done."""
        left = sum((self._left or {}).values())
        return 1.0 - left / self._total if self._total else 0.0

    @property
    def seconds_left(self) -> float:
        """An estimate by what the work so far has taken, s."""
        done = self.share * self._total
        guess = _TRUST * self._total
        spent = clock.perf_counter() - self._began + guess * _RATE
        return spent / (done + guess) * (self._total - done)

    def begin(self) -> None:
        """Something has to be compiled: find out how much there is."""
        if self._left is not None:
            return
        self._began = clock.perf_counter()
        kernels = {
            kernel
            for kernel in _kernels_in(self._modules)
            if self._unused.isdisjoint(_names(kernel.py_func))
        }
        functions = {reached for kernel in kernels for reached in reached_from(kernel.py_func)}
        self._left = {each: _length(each) for each in functions - self._ready}
        self._total = sum(self._left.values())

    def compiled(self, function: FunctionType) -> None:
        """A function is done; others may have called it."""
        self.kernels += 1
        self.ready({function})

    def ready(self, functions: Iterable[FunctionType]) -> None:
        """These need no more work: compiled, or loaded with a kernel that was on disk."""
        self._ready.update(functions)
        for function in functions:
            if self._left is not None:
                self._left.pop(function, None)
        if self._left is not None:
            self._tell(self)


@contextmanager
def watched(compilation: Compilation) -> Iterator[Compilation]:
    """While kernels are compiled or loaded."""
    with (
        event.install_listener("numba:compile", _Compiled(compilation)),
        event.install_listener(LOADED, _Loaded(compilation)),
    ):
        yield compilation


class _Compiled(event.Listener):
    """Listens to numba's compiler."""

    def __init__(self, compilation: Compilation) -> None:
        self._compilation = compilation

    def on_start(self, event: event.Event) -> None:
        if _is_ours(event.data["dispatcher"]):
            self._compilation.begin()

    def on_end(self, event: event.Event) -> None:
        if _is_ours(event.data["dispatcher"]):
            self._compilation.compiled(event.data["dispatcher"].py_func)


class _Loaded(event.Listener):
    """Listens to kernels that were on disk."""

    def __init__(self, compilation: Compilation) -> None:
        self._compilation = compilation

    def on_start(self, event: event.Event) -> None:
        pass

    def on_end(self, event: event.Event) -> None:
        self._compilation.ready(reached_from(event.data))


def _is_ours(dispatcher: Dispatcher) -> bool:
    return dispatcher.py_func.__module__.startswith("cavalcade.")


def _kernels_in(names: Iterable[str]) -> set[Dispatcher]:
    """All kernels that modules, or those of packages, define or use."""
    found = set()
    for name in names:
        package = importlib.import_module(name)
        inside = pkgutil.iter_modules(getattr(package, "__path__", ()), f"{name}.")
        for module in (package, *(importlib.import_module(each.name) for each in inside)):
            for value in vars(module).values():
                if isinstance(value, Dispatcher) and isinstance(value._cache, KernelCache):
                    found.add(value)
    return found


def _names(function: FunctionType) -> tuple[str, str]:
    return function.__module__, f"{function.__module__}.{function.__qualname__}"


def _length(function: FunctionType) -> int:
    return sum(len(code.co_code) for code in code_objects(function))
