"""Scenes: from a file, from a dict, or built in code."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._error import PliantError
from ._hyperelastic import Hyperelastic
from .catalogue import Fabric, Material


class Scene:
    """What there is, what a hand does to it, and what is measured.

    Every key a scene file may have can be given here, with ``_`` for ``-``; ``docs/scenes.md`` describes them. Quantities are numbers in SI
    units or texts with a unit, such as ``"5 mm"``. What a scene cannot say raises :class:`PliantError` of kind ``"scene"``, in the words of the
    program, when it is checked, run or opened.

    Parameters
    ----------
    source : path or mapping, optional
        A scene file in TOML, or what one would say as a dict. Without it the scene is empty.
    folder : path, optional
        The folder that paths in a dict are relative to; the current one by default.

    Examples
    --------
    >>> import pliant
    >>> scene = pliant.Scene()
    >>> scene.body("cube", mesh=[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], faces=[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    ...     scale=0.1, material=pliant.Material("mass-spring", young="20 kPa"))
    >>> scene.hand("hand")
    >>> scene.tool("finger", hand="hand", radius="5 mm")
    >>> scene.edit("touch", tool="finger")
    >>> scene.check()
    """

    def __init__(
        self,
        source: str | os.PathLike[str] | Mapping[str, Any] | None = None,
        *,
        folder: str | os.PathLike[str] | None = None,
    ) -> None:
        self._text: str | None = None
        self._data: dict[str, Any] = {"format": 1}
        self._meshes: dict[str, str] = {}
        self._factors: dict[str, list[float]] = {}
        self._driven: list[str] = []
        # Kept alive, for the scene names them by number.
        self._materials: list[Hyperelastic] = []
        self._path = Path(folder or ".") / "<scene>"
        if isinstance(source, Mapping):
            self._data = _copied(source)
        elif source is not None:
            self._path = Path(source)
            try:
                self._text = self._path.read_text(encoding="utf-8-sig")
            except (OSError, UnicodeDecodeError) as error:
                raise PliantError(f"{self._path}: cannot be read: {error}", "scene", str(self._path)) from None

    @classmethod
    def from_toml(cls, text: str, *, folder: str | os.PathLike[str] | None = None) -> Scene:
        """Take the text of a scene file.

        Parameters
        ----------
        text : str
            TOML.
        folder : path, optional
            The folder that paths in it are relative to; the current one by default.

        Returns
        -------
        Scene
        """
        scene = cls(folder=folder)
        scene._text = text
        return scene

    def body(
        self,
        name: str = "body",
        *,
        mesh: str | os.PathLike[str] | ArrayLike | None = None,
        faces: ArrayLike | Sequence[Sequence[int]] | None = None,
        texture: ArrayLike | None = None,
        material: Material | Fabric | Hyperelastic | Mapping[str, Any] | str | None = None,
        fields: Mapping[str, ArrayLike] | None = None,
        **keys: Any,
    ) -> None:
        """Add a body.

        Parameters
        ----------
        name : str
            What other parts of the scene call it.
        mesh : path or array_like, optional
            An OBJ file, or vertices (n x 3) in metres (or units of `scale`). A body without a mesh needs a `shape`.
        faces : array_like or sequence of sequences, optional
            Vertices of the faces, counter-clockwise seen from outside, from 0: (m x 3), (m x 4), or lists of different lengths. Needed where
            `mesh` are vertices.
        texture : array_like, optional
            Texture coordinates (c x 2) of all corners, face after face.
        material : Material, Fabric, Hyperelastic, mapping or str
            What it is made of. A fabric makes the body a sheet.
        fields : mapping of str to array_like, optional
            Factors of parameters of the material that differ from place to place, by the parameter's key: one for each vertex (n), 0.1 to 10,
            geometric between vertices. ``_`` stands for ``-``. Inside of a solid the nearest place of the surface counts.
        **keys
            Other keys of ``[[body]]``: ``shape``, ``size``, ``scale``, ``position``, ``rotation``, ``grid``, ``sheet``, ``fixed``, ``field``, ``fibre``,
            ``subdivide``, ``weld``. Vertices given as an array stay apart unless ``weld`` joins those of borders that lie together; of a file these
            are joined.

        Examples
        --------
        Stiffness that doubles from the left to the right, and is three times as high in a ball:

        >>> import numpy as np, pliant
        >>> vertices, faces = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
        >>> scene = pliant.Scene()
        >>> scene.body("cube", mesh=vertices, faces=faces, scale=0.1, material=pliant.Material("mass-spring", young="20 kPa"),
        ...     fields={"young": 2.0 ** vertices[:, 0]}, field=[{"param": "young", "ball": [0, 0, 0], "radius": 0.05, "factor": 3.0}])
        >>> scene.check()
        """
        body: dict[str, Any] = {"name": name}
        if isinstance(mesh, (str, os.PathLike)):
            body["mesh"] = os.fspath(mesh)
        elif mesh is not None:
            if faces is None:
                raise PliantError(f"body `{name}`: vertices without `faces`; allowed are both, or a file")
            file = f"{name}.obj"
            self._meshes[file] = _obj_text(name, mesh, faces, texture)
            body["mesh"] = file
            if not keys.keys() & {"size", "scale"}:
                # Said, so that nothing doubts the unit.
                body["scale"] = 1.0
        if material is not None:
            if isinstance(material, Fabric):
                body.setdefault("sheet", {})
            if isinstance(material, Hyperelastic):
                self._materials.append(material)
            body["material"] = material.to_dict() if isinstance(material, (Material, Fabric, Hyperelastic)) else (
                {"plugin": material} if isinstance(material, str) else dict(material)
            )
        keys = _kebab(keys)
        if fields:
            count = None if faces is None or mesh is None else len(np.asarray(mesh))
            keys["field"] = [*keys.get("field", []), *self._field_entries(name, fields, count)]
        self._append("body", body | keys)

    def obstacle(
        self,
        name: str,
        *,
        mesh: str | os.PathLike[str] | ArrayLike | None = None,
        faces: ArrayLike | Sequence[Sequence[int]] | None = None,
        **keys: Any,
    ) -> None:
        """Add an obstacle: a rigid thing that bodies meet and that feels nothing. Tools pass through it.

        Parameters
        ----------
        name : str
            Its name, for messages and :attr:`Result.probes`.
        mesh : path or array_like, optional
            An OBJ file, or vertices (n x 3) in metres (or units of `scale`). An obstacle without a mesh needs a `shape`.
        faces : array_like or sequence of sequences, optional
            Vertices of the faces, as of :meth:`body`. Needed where `mesh` are vertices.
        **keys
            Other keys of ``[[obstacle]]``: ``shape``, ``size``, ``scale``, ``thickness``, ``position``, ``rotation``, ``friction``, ``path``. A
            mesh that is not closed needs a ``thickness``.

        Examples
        --------
        A floor:

        >>> import pliant
        >>> scene = pliant.Scene()
        >>> scene.body("cube", shape={"kind": "box", "size": [0.1, 0.1, 0.1]}, position=[0, 0, 0.06], material="mass-spring")
        >>> scene.obstacle("floor", shape={"kind": "plane"}, friction=[0.6, 0.5])
        >>> scene.check()
        """
        obstacle: dict[str, Any] = {"name": name}
        if isinstance(mesh, (str, os.PathLike)):
            obstacle["mesh"] = os.fspath(mesh)
        elif mesh is not None:
            if faces is None:
                raise PliantError(f"obstacle `{name}`: vertices without `faces`; allowed are both, or a file")
            file = f"obstacle-{name}.obj"
            self._meshes[file] = _obj_text(name, mesh, faces, None)
            obstacle["mesh"] = file
        self._append("obstacle", obstacle | _kebab(keys))

    def hand(
        self,
        name: str = "hand",
        *,
        path: ArrayLike | None = None,
        buttons: ArrayLike | None = None,
        peak_force: float | str = 3.3,
        stiffness: float | str = 700.0,
        **keys: Any,
    ) -> None:
        """Add a hand: one that follows a path, or one that :meth:`Session.hand` moves.

        Parameters
        ----------
        name : str
            What tools call it.
        path : array_like, optional
            Keyframes (k x 4): time in s, position in m. Without one, the hand is not there until it is moved.
        buttons : array_like, optional
            Pressed buttons from each time on (k x 2): time in s, and a number of which bit i is button i.
        peak_force : float or str
            Largest force it can bear, N.
        stiffness : float or str
            Largest stiffness it renders stably, N/m.
        **keys
            Other keys of ``[[device]]``: ``frame``, and more ``params``.
        """
        keys = _kebab(keys)
        params = {"peak-force": peak_force, "stiffness": stiffness} | keys.pop("params", {})
        if path is None:
            self._driven.append(name)
            # Somewhere, for a run without anybody to move it.
            params.setdefault("path", [[0.0, 0.0, 0.0, 0.0]])
        else:
            params["path"] = np.asarray(path, dtype=float).tolist()
        if buttons is not None:
            params["buttons"] = np.asarray(buttons, dtype=float).tolist()
        self._append("device", {"name": name, "plugin": "scripted", "params": params} | keys)

    def device(self, name: str, plugin: str | None = None, **keys: Any) -> None:
        """Add a device, such as a force-feedback arm.

        Parameters
        ----------
        name : str
            What tools call it.
        plugin : str, optional
            Its plugin, see :func:`plugins`; none if ``recording`` names a file whose hand it repeats.
        **keys
            Other keys of ``[[device]]``: ``params``, ``frame``, ``recording``, ...
        """
        self._append("device", {"name": name, "plugin": plugin} | _kebab(keys))

    def tool(self, name: str, *, hand: str = "hand", radius: float | str | None = None, **keys: Any) -> None:
        """Add a tool.

        Parameters
        ----------
        name : str
            What edits and :class:`Session` call it.
        hand : str
            The hand or device that moves it.
        radius : float or str, optional
            Radius of a tip that is a ball, m; none if ``shape`` gives another one.
        **keys
            Other keys of ``[[tool]]``: ``shape``, ``stiffness``, ``damping``, ``friction``, ``mass``, ``speed``, ``slew``, ``blade``, ...
        """
        self._append("tool", {"name": name, "device": hand, "radius": radius} | _kebab(keys))

    def edit(self, kind: str, *, tool: str | None = None, **keys: Any) -> None:
        """Add what is done with a tool.

        Parameters
        ----------
        kind : str
            One of :func:`edit_kinds`.
        tool : str, optional
            The tool; none for ``undo`` and ``redo``.
        **keys
            Other keys of ``[[edit]]``: ``start``, ``end``, ``button``, ``release``, ``limit``, ...
        """
        self._append("edit", {"kind": kind, "tool": tool} | _kebab(keys))

    def probe(self, name: str, quantity: str, **keys: Any) -> None:
        """Add something that is measured.

        Parameters
        ----------
        name : str
            Its name in :attr:`Result.probes`.
        quantity : str
            One of :func:`quantities`.
        **keys
            Other keys of ``[[probe]]``: ``of``, ``at``, ``time``, ``greatest``, ``expected``, ``tolerance``, ``source``.
        """
        self._append("probe", {"name": name, "quantity": quantity} | _kebab(keys))

    def time(self, **keys: Any) -> None:
        """Set keys of ``[time]``: ``duration``, ``dt``, ``integrator``, ``substeps``, ...

        Parameters
        ----------
        **keys
            Values by key.
        """
        self._table("time", keys)

    def solver(self, **keys: Any) -> None:
        """Set keys of ``[solver]``: ``tolerance``, ``iterations``, ``newton``, ...

        Parameters
        ----------
        **keys
            Values by key.
        """
        self._table("solver", keys)

    def output(self, **keys: Any) -> None:
        """Set keys of ``[output]``: ``energy``, ``frames``, ...

        Parameters
        ----------
        **keys
            Values by key.
        """
        self._table("output", keys)

    def gravity(self, x: float, y: float, z: float) -> None:
        """Set gravity.

        Parameters
        ----------
        x, y, z : float
            m/s^2.
        """
        self._dict()["gravity"] = [x, y, z]

    def check(self) -> None:
        """Raise what is wrong with the scene, without opening models or plugins.

        Raises
        ------
        PliantError
            Of kind ``"scene"``, with the line in `where`.
        """
        _native.check(self._given({}))

    def to_dict(self) -> dict[str, Any]:
        """Give the scene as a dict.

        Returns
        -------
        dict
            A copy, as :func:`tomllib.load` would read it.
        """
        return tomllib.loads(self.to_toml())

    def to_toml(self) -> str:
        """Give the scene as TOML, for a file that ``pliant run`` reads.

        Returns
        -------
        str
            The text. Bodies and fields made of arrays name files that :meth:`save` writes.
        """
        return self._text if self._text is not None else _native.to_toml(self._data)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the scene as a file, and its meshes and fields made of arrays beside it.

        Parameters
        ----------
        path : path
            The file. Paths of other meshes in the scene are relative to its folder.
        """
        if self._materials:
            raise PliantError("a material written in Python cannot be saved; allowed are plugins, see `pliant plugin new`")
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        for name, text in self._meshes.items():
            (path.parent / name).write_text(text, encoding="utf-8")
        for name, factors in self._factors.items():
            # Each number in the fewest digits that give it back.
            (path.parent / name).write_text("".join(f"{factor!r}\n" for factor in factors), encoding="utf-8")
        path.write_text(self._text if self._text is not None else _native.to_toml(self._saved()), encoding="utf-8")

    def _saved(self) -> dict[str, Any]:
        """The scene with what holds for arrays said for files: their borders stay apart, where it does not say that they are joined."""
        bodies = [
            {"weld": False} | body if body.get("mesh") in self._meshes and not body.get("stitch") else body
            for body in self._data.get("body", [])
        ]
        return self._data | {"body": bodies} if bodies else self._data

    def __repr__(self) -> str:
        return f"<scene {self._path}>"

    def _given(self, settings: Mapping[str, Any]) -> dict[str, Any]:
        """The scene as the native half takes it, with `settings` in the place of what it says."""
        pairs = [(path, _toml_value(value)) for path, value in settings.items()]
        return {
            "text": self.to_toml(),
            "path": self._path,
            "documents": self._meshes,
            "factors": self._factors,
            "set": pairs,
        }

    def _field_entries(self, body: str, fields: Mapping[str, ArrayLike], count: int | None) -> list[dict[str, str]]:
        """Entries of ``[[body.field]]`` for factors of vertices, which are kept; `count` is the number of vertices, where it is known."""
        entries = []
        for param, values in _kebab(fields).items():
            try:
                factors = np.ascontiguousarray(values, dtype=np.float64)
            except (TypeError, ValueError) as error:
                raise PliantError(f"body `{body}`: field of `{param}`: {error}; allowed are numbers") from None
            if np.ndim(values) != 1 or count not in (None, len(factors)):
                allowed = "(n)" if count is None else f"({count},)"
                shape = np.shape(values)
                raise PliantError(
                    f"body `{body}`: field of `{param}` has the shape {shape}; allowed is {allowed}, a factor for each vertex"
                )
            file = f"{body}-{param}.csv"
            self._factors[file] = factors.tolist()
            entries.append({"param": param, "csv": file})
        return entries

    def _dict(self) -> dict[str, Any]:
        if self._text is not None:
            try:
                self._data = tomllib.loads(self._text)
            except tomllib.TOMLDecodeError:
                self.check()  # says it with the line
                raise
            self._text = None
        return self._data

    def _append(self, section: str, entry: dict[str, Any]) -> None:
        self._dict().setdefault(section, []).append(entry)

    def _table(self, section: str, keys: Mapping[str, Any]) -> None:
        self._dict().setdefault(section, {}).update(_kebab(keys))


def as_scene(scene: Scene | str | os.PathLike[str] | Mapping[str, Any]) -> Scene:
    """A scene of whatever stands for one."""
    return scene if isinstance(scene, Scene) else Scene(scene)


def _kebab(keys: Mapping[str, Any]) -> dict[str, Any]:
    """Keys as scenes write them; those inside of values are left as they are."""
    return {key.replace("_", "-"): value for key, value in keys.items()}


def _copied(data: Mapping[str, Any]) -> dict[str, Any]:
    """A copy that a later change of `data` does not reach."""

    def copy(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {key: copy(below) for key, below in value.items()}
        if isinstance(value, (list, tuple)):
            return [copy(below) for below in value]
        return value

    return {key: copy(value) for key, value in data.items()}


def _toml_value(value: Any) -> str:
    """A value as ``--set`` takes it."""
    text = _native.to_toml({"value": value})
    if not text.startswith("value = "):
        raise PliantError(f"{value!r}: allowed are texts, numbers, booleans and lists")
    return text.removeprefix("value = ").strip()


def _obj_text(name: str, mesh: ArrayLike, faces: ArrayLike | Iterable[Sequence[int]], texture: ArrayLike | None) -> str:
    try:
        vertices = np.ascontiguousarray(mesh, dtype=np.float64)
        if isinstance(faces, np.ndarray) and faces.ndim == 2:
            counts = np.full(len(faces), faces.shape[1], dtype=np.int64)
            corners = np.ascontiguousarray(faces, dtype=np.int64).reshape(-1)
        else:
            rows: list[Any] = list(faces)  # type: ignore[arg-type]
            counts = np.fromiter(map(len, rows), dtype=np.int64, count=len(rows))
            corners = np.fromiter(chain.from_iterable(rows), dtype=np.int64, count=int(counts.sum()))
        coordinates = None if texture is None else np.ascontiguousarray(texture, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise PliantError(f"mesh `{name}`: {error}; allowed are vertices (n x 3) and faces of vertex numbers") from None
    if vertices.ndim != 2:
        raise PliantError(f"mesh `{name}`: vertices have the shape {vertices.shape}; allowed is (n x 3)")
    return _native.obj_text(name, vertices, corners, counts, coordinates)


Scene.__module__ = "pliant"
