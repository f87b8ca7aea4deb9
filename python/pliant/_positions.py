"""Positions of a body, seen where the engine has them."""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._error import PliantError

if TYPE_CHECKING:
    from . import _native


class Positions(np.lib.mixins.NDArrayOperatorsMixin):
    """Positions of a body's vertices after the last step (n x 3), m: a read-only view without a copy.

    It is used like an array: indexed, in arithmetic, in functions of numpy, and as ``numpy.asarray(positions)``. After the next step, or
    whatever else moves the body, using it raises :class:`PliantError` of kind ``"stale"``; take the positions anew.

    An array made of it, by ``numpy.asarray`` or by slicing, shows the engine's own memory. If it is still held when the session goes on, it
    keeps the positions it was made with, and the engine copies the body's positions once; drop it before the next step and nothing
    is copied.
    """

    __slots__ = ("_body", "_session", "_version")

    def __init__(self, session: _native.Session, body: str) -> None:
        self._session = weakref.ref(session)
        self._body = body
        # The first look brings the surface up to date.
        session.positions(body)
        self._version = session.version

    @property
    def is_valid(self) -> bool:
        """Whether the session has not gone on since."""
        session = self._session()
        return session is not None and not session.closed and session.version == self._version

    @property
    def shape(self) -> tuple[int, int]:
        """Vertices and 3."""
        rows, columns = self._array().shape
        return rows, columns

    @property
    def dtype(self) -> np.dtype[np.float64]:
        """float64."""
        return np.dtype(np.float64)

    @property
    def ndim(self) -> int:
        """2."""
        return 2

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self._array().size

    def copy(self) -> NDArray[np.float64]:
        """Copy the positions.

        Returns
        -------
        ndarray
            Positions (n x 3), m, that stay as they are.
        """
        return self._array().copy()

    def _array(self) -> NDArray[np.float64]:
        session = self._session()
        if session is None or session.closed:
            raise PliantError(f"positions of body `{self._body}`: their session is closed", "closed")
        if session.version != self._version:
            raise PliantError(
                f"positions of body `{self._body}` are those before the last step; allowed is to take them anew with "
                "`positions(...)`, or to keep `positions(...).copy()`",
                "stale",
            )
        return session.positions(self._body)

    def __len__(self) -> int:
        return len(self._array())

    def __getitem__(self, index: Any) -> Any:
        return self._array()[index]

    def __iter__(self) -> Iterator[NDArray[np.float64]]:
        return iter(self._array())

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        array = self._array()
        if dtype is not None and np.dtype(dtype) != array.dtype:
            if copy is False:
                raise ValueError(f"positions are {array.dtype}; as {np.dtype(dtype)} they must be copied")
            return array.astype(dtype)
        return array.copy() if copy else array

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **kwargs: Any) -> Any:
        inputs = tuple(value._array() if isinstance(value, Positions) else value for value in inputs)
        return getattr(ufunc, method)(*inputs, **kwargs)

    def __repr__(self) -> str:
        if not self.is_valid:
            return f"<positions of body `{self._body}`, no longer valid>"
        return f"<positions of body `{self._body}`, {len(self)} x 3>"


Positions.__module__ = "pliant"
