"""Texts without what says where they were made: paths, process ids, hosts."""

from __future__ import annotations

import re

_PATH = re.compile(
    r"(?:\bfile://|(?<![\w./~-]))(?:~|\.{1,2})?(?:/[\w.+@%=,-]+)+/?"  # /a/x, ~/x, ../x, file URLs
    r"|\b[A-Za-z]:[\\/](?:[^\s\\/:;,'\"]+[\\/])*[^\s\\/:;,'\"]*"  # C:\Users\x
)
_PROCESS = re.compile(r"\b(pid|process|worker)(?:\s*[=:#]\s*|\s+)\d+\b", re.IGNORECASE)
_HOST = re.compile(
    r"\b(?:\d{1,3}\.){3}\d{1,3}(?::\d+)?\b|\b(?:host|hostname|node)\s*[=:]\s*[\w.-]+", re.IGNORECASE
)
_PRIVATE = frozenset(
    ("cwd", "directory", "dir", "file", "folder", "host", "hostname", "ip", "node", "out", "path",
     "paths", "pid", "process", "tmp", "user", "worker")
)  # fmt: skip


def scrubbed(text: str) -> str:
    """The text on one line, paths cut to their last part, process ids and hosts taken out."""
    text = _PATH.sub(lambda match: re.split(r"[\\/]", match[0].rstrip("\\/"))[-1], text)
    text = _PROCESS.sub(r"\1", text)
    return " ".join(_HOST.sub("host", text).split())


def is_private(key: str) -> bool:
    """Whether a key of that name holds a path, a process id or a host."""
    return key.lower() in _PRIVATE
