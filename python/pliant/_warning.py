"""Warnings of the engine as warnings of Python."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping


class PliantWarning(UserWarning):
    """A part of a scene has no effect, or not the one it looks like; see ``docs/warnings.md``.

    Parameters
    ----------
    message : str
        What was found, and what to do.
    code : str
        See `code`.
    where : str, optional
        See `where`.

    Attributes
    ----------
    code : str
        What it is about, such as ``"cuts-nothing"``.
    where : str or None
        File with line and column, such as ``scene.toml:12:3``.
    """

    code: str
    where: str | None

    def __init__(self, message: str, code: str, where: str | None = None) -> None:
        super().__init__(message)
        self.code = code
        self.where = where

    def __str__(self) -> str:
        place = "" if self.where is None else f"{self.where}: "
        return f"[{self.code}] {place}{self.args[0]}"

    def __reduce__(self) -> tuple[object, ...]:
        """Keep `code` and `where` when the warning goes to another process."""
        return (type(self), (self.args[0], self.code, self.where))


def warn(rows: Iterable[Mapping[str, str]], stacklevel: int) -> None:
    """Warn of what the native half tells, at the line of the caller."""
    for row in rows:
        warnings.warn(PliantWarning(row["message"], row["code"], row["where"]), stacklevel=stacklevel + 1)


PliantWarning.__module__ = "pliant"
