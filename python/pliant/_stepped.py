"""What a session and a batch of sessions share: steps, the names of their parts, tools, and errors of materials."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._error import PliantError
from ._hyperelastic import Hyperelastic
from ._scene import Scene


class _Native(Protocol):
    """The native half of either."""

    @property
    def tools(self) -> list[str]: ...
    @property
    def bodies(self) -> list[str]: ...
    def step(self, count: int) -> None: ...
    def tool(self, tool: str) -> dict[str, Any]: ...


class _Tool(Protocol):
    """A tool at the end of a step."""

    @property
    def force(self) -> NDArray[np.float64]: ...


_N = TypeVar("_N", bound=_Native)
_T = TypeVar("_T", bound=_Tool)


class Stepped(ABC, Generic[_N, _T]):
    """A scene that was opened once or many times, and is stepped by the caller."""

    _native: _N
    _materials: tuple[Hyperelastic, ...]

    @property
    def tools(self) -> list[str]:
        """Names of the tools in use."""
        return self._native.tools

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies, those that move first."""
        return self._native.bodies

    def step(self, count: int = 1) -> None:
        """Take steps, a batch with every instance.

        Ctrl-C ends the step under way of a session (on Linux). A batch, and a session elsewhere, stops between two steps.

        Parameters
        ----------
        count : int
            How many.
        """
        if count < 0:
            raise PliantError(f"step({count}); allowed is 0 or more")
        self._native.step(count)
        self._raise_errors()

    def tool(self, tool: str | None = None) -> _T:
        """Read a tool at the end of the last step.

        Parameters
        ----------
        tool : str, optional
            Its name; the first tool by default.

        Returns
        -------
        ToolState or BatchTools
            Of a session, or of every instance of a batch.
        """
        return self._tool_state(self._native.tool(self._tool(tool)))

    def force(self, tool: str | None = None) -> NDArray[np.float64]:
        """Read the force on a hand.

        Parameters
        ----------
        tool : str, optional
            Name of its tool; the first tool by default.

        Returns
        -------
        ndarray
            N (3) of a session, or (n x 3) of a batch, in the scene.
        """
        return self.tool(tool).force

    @abstractmethod
    def _tool_state(self, given: dict[str, Any]) -> _T:
        """A tool of what the native half gives."""

    @contextmanager
    def _opening(self, scene: Scene) -> Iterator[None]:
        """Open a scene inside: exceptions of its materials come before those of the native half."""
        self._materials = tuple(scene._materials)
        try:
            yield
        finally:
            self._raise_errors()

    def _raise_errors(self) -> None:
        for material in self._materials:
            material._raise_error()

    def _body(self, body: str | None) -> str:
        """The name of a body; the first one by default."""
        return body if body is not None else _first(self.bodies, "the scene has no body")

    def _tool(self, tool: str | None) -> str:
        """The name of a tool; the first one by default."""
        return tool if tool is not None else _first(self.tools, "no edit of the scene uses a tool")


def _first(names: list[str], otherwise: str) -> str:
    if not names:
        raise PliantError(otherwise)
    return names[0]
