"""Announcing the vendor's messages to robots so that their older DDS survives it.

A Go2 has Cyclone DDS 0.10.2. Later versions describe bytes as `uint8` of XTypes 1.3 where 0.10.2
knows only `byte`: told of a sequence of them, as every request has one, a process with 0.10.2 ends
with a segmentation fault, and on a robot that is the service that keeps it on its legs. On the
wire both are the same, so all are announced as `byte` here, which every version understands.
"""

from __future__ import annotations

import importlib
from typing import Any, get_args


def announce_as_octets(kind: Any) -> None:
    """Have a message type, and those in it, describe their bytes as `byte`.

    Has to be done before the first topic of the type is made.
    """
    from cyclonedds.idl import types

    pending, done = [kind], set()
    while pending:
        message = pending.pop()
        if message in done:
            continue
        done.add(message)
        for name, hint in message.__annotations__.items():
            message.__annotations__[name] = _with_bytes(hint, types)
            pending += _messages_in(hint)


def _with_bytes(hint: Any, types: Any) -> Any:
    """The annotation with `byte` in the place of `uint8`."""
    if hint == types.uint8:
        return types.byte
    kind = _container(hint)
    if kind is None or kind.subtype != types.uint8:
        return hint
    if isinstance(kind, types.array):
        return types.array[types.byte, kind.length]
    return (
        types.sequence[types.byte, kind.max_length]
        if kind.max_length
        else types.sequence[types.byte]
    )


def _messages_in(hint: Any) -> list[Any]:
    """The message types that an annotation names."""
    kind = _container(hint)
    inner = hint if kind is None else kind.subtype
    name = getattr(inner, "__forward_arg__", inner)
    if isinstance(name, str):
        module, _, message = name.rpartition(".")
        return [getattr(importlib.import_module(module), message)]
    return [inner] if hasattr(inner, "__idl__") else []


def _container(hint: Any) -> Any:
    """The array or sequence that an annotation stands for, None if it is neither."""
    parts = get_args(hint)[1:]
    return parts[0] if parts and hasattr(parts[0], "subtype") else None
