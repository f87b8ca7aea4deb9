"""The one exception."""

from __future__ import annotations


class PliantError(Exception):
    """Whatever goes wrong, said so that it can be mended: what happened, where, the value, and what is allowed.

    Parameters
    ----------
    message : str
        What is wrong.
    kind : str
        See `kind`.
    where : str, optional
        See `where`.

    Attributes
    ----------
    kind : str
        ``"scene"``: a scene says something it cannot. ``"model"``: a mesh cannot be read or used. ``"plugin"``: a plugin or device
        failed. ``"file"``: a file cannot be read or written. ``"argument"``: an argument makes no sense. ``"stale"``: positions
        were used after the step they are of. ``"busy"``: another thread is using the session. ``"closed"``: the session
        is closed, or belongs to another process. ``"panic"``: a fault of pliant itself.
    where : str or None
        File with line and column, such as ``scene.toml:12:3``, where there is one.
    """

    kind: str
    where: str | None

    def __init__(self, message: str, kind: str = "argument", where: str | None = None) -> None:
        super().__init__(message)
        self.kind = kind
        self.where = where

    def __reduce__(self) -> tuple[object, ...]:
        """Keep `kind` and `where` when the exception goes to another process."""
        return (type(self), (str(self), self.kind, self.where))


PliantError.__module__ = "pliant"
