"""The command line: `cavalcade run`, `check`, `scenarios`, `show`, `schema`."""

from cavalcade.cli.main import main

__all__ = ["main"]
