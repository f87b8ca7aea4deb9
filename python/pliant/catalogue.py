"""What there is to choose from: plugins, materials, fabrics, edit kinds, quantities."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import _native
from ._error import PliantError

_PLUGINS = Path(__file__).resolve().parent / "plugins"


@dataclass(frozen=True)
class Param:
    """A parameter of a plugin.

    Attributes
    ----------
    key : str
        Its name in scenes.
    type : str
        ``"number"``, ``"choice"``, ``"text"``, ``"path"`` or ``"table"``.
    unit : str
        SI unit of a number, ``"1"`` without one.
    summary : str
        What it is.
    default : float or str or None
        Its value where a scene gives none.
    range : tuple of float or None
        Least and greatest value of a number.
    choices : tuple of str
        Of a choice.
    sources : dict
        Where the values behind a choice come from, by choice.
    columns : tuple of str
        Of a table.
    """

    key: str
    type: str
    unit: str
    summary: str
    default: float | str | None = None
    range: tuple[float, float] | None = None
    choices: tuple[str, ...] = ()
    sources: dict[str, str] = field(default_factory=dict)
    columns: tuple[str, ...] = ()


@dataclass(frozen=True)
class Plugin:
    """A plugin that was found.

    Attributes
    ----------
    kind : str
        ``"material"``, ``"grid"`` or ``"device"``; ``"unusable"`` for a library that cannot be opened.
    id : str
        What scenes call it.
    name : str
        For people.
    version : str
        Its version.
    summary : str
        What it is, or why it is unusable.
    path : str
        Its file.
    params : tuple of Param
        What it takes.
    """

    kind: str
    id: str
    name: str
    version: str
    summary: str
    path: str
    params: tuple[Param, ...] = ()

    def param(self, key: str) -> Param:
        """Find a parameter.

        Parameters
        ----------
        key : str
            Its name in scenes.

        Returns
        -------
        Param
        """
        for param in self.params:
            if param.key == key:
                return param
        known = ", ".join(param.key for param in self.params) or "none"
        raise PliantError(f"{self.kind} `{self.id}`: no parameter `{key}`; allowed is {known}")


@dataclass(frozen=True)
class Preset:
    """A solid material.

    Attributes
    ----------
    young : float
        Pa, Young's modulus of small strains.
    poisson : float
        Poisson's ratio of small strains.
    density : float
        kg/m^3.
    damping_time : float
        s, damping stress over stiffness.
    source : str
        Where the numbers come from.
    flow : tuple of float or None
        Yield strain, hardening and flow time (s) of a material that flows, as clay does; None: it is elastic.
    """

    young: float
    poisson: float
    density: float
    damping_time: float
    source: str
    flow: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Strength:
    """What the strength of an edit kind is.

    Attributes
    ----------
    unit : str
        SI unit; empty for a factor.
    default : float
        Its value where a scene gives none.
    """

    unit: str
    default: float


def plugins(kind: str | None = None, *, plugin_path: Iterable[str | os.PathLike[str]] = ()) -> list[Plugin]:
    """List the plugins there are.

    Parameters
    ----------
    kind : str, optional
        ``"material"``, ``"grid"`` or ``"device"``: only these.
    plugin_path : iterable of path
        Folders that are searched first.

    Returns
    -------
    list of Plugin
        Sorted by kind and id.
    """
    rows = json.loads(_native.plugins(open_options(plugin_path=plugin_path)))
    found = [_plugin(row) for row in rows]
    return sorted((p for p in found if kind in (None, p.kind)), key=lambda p: (p.kind, p.id))


def devices(*, plugin_path: Iterable[str | os.PathLike[str]] = ()) -> list[Plugin]:
    """List the devices that can have a hand; see :meth:`Hand.follow`.

    Parameters
    ----------
    plugin_path : iterable of path
        Folders that are searched first.

    Returns
    -------
    list of Plugin
        With their parameters, sorted by id. ``scripted``, which follows a path, is not among them and may be named all the same.
    """
    folders = list(plugin_path)
    names = set(_native.devices(open_options(plugin_path=folders)))
    return [plugin for plugin in plugins("device", plugin_path=folders) if plugin.id in names]


def opposite_kind(kind: str) -> str | None:
    """Find what takes back what an edit kind does, as ``"deflate"`` does to ``"inflate"``.

    Parameters
    ----------
    kind : str
        One of :func:`edit_kinds`.

    Returns
    -------
    str or None
        None if there is no such kind.
    """
    return _native.opposite_kind(kind)


def edit_kinds() -> dict[str, str]:
    """List what can be done with a tool.

    Returns
    -------
    dict
        A sentence by the name of each edit kind.
    """
    return dict(_native.edit_kinds())


def edit_strengths() -> dict[str, Strength]:
    """List the edit kinds that have a strength: a pressure, a rate, or the factor that ``"paint"`` reaches.

    Returns
    -------
    dict of str to Strength
        By the name of the edit kind.
    """
    return {kind: Strength(unit, default) for kind, unit, default in _native.edit_strengths()}


def quantities() -> dict[str, str]:
    """List what a probe can measure.

    Returns
    -------
    dict
        A sentence with the unit by the name of each quantity.
    """
    return dict(_native.quantities())


class Material:
    """What a body is made of: a material plugin and values of its parameters.

    Parameters
    ----------
    plugin : str
        One of ``plugins("material")``.
    **params
        Its parameters, with ``_`` for ``-``: numbers in SI units, or texts with a unit such as ``"20 kPa"``.

    Examples
    --------
    >>> import pliant
    >>> pliant.Material("neo-hookean", young="20 kPa", density=1000).to_dict()
    {'plugin': 'neo-hookean', 'params': {'young': '20 kPa', 'density': 1000}}
    """

    def __init__(self, plugin: str, **params: Any) -> None:
        self.plugin = plugin
        self.params = {key.replace("_", "-"): value for key, value in params.items()}

    @staticmethod
    def list() -> list[Plugin]:
        """List the material plugins.

        Returns
        -------
        list of Plugin
        """
        return plugins("material")

    @staticmethod
    def presets() -> dict[str, Preset]:
        """List solid materials by name, soft to stiff.

        Returns
        -------
        dict of str to Preset
        """
        return {row[0]: Preset(*row[1:]) for row in _native.solids()}

    @classmethod
    def preset(cls, name: str, plugin: str | None = None) -> Material:
        """Take a solid material by its name.

        Parameters
        ----------
        name : str
            One of :meth:`presets`.
        plugin : str, optional
            The material plugin; it gets those of the numbers that it takes. By default ``"mass-spring"``, and ``"neo-hookean"`` for a
            material that flows.

        Returns
        -------
        Material
        """
        known = cls.presets()
        if name not in known:
            raise PliantError(f"no material preset `{name}`; allowed is {', '.join(known)}")
        preset = known[name]
        plugin = plugin or ("neo-hookean" if preset.flow else "mass-spring")
        taken = {param.key for found in plugins("material") if found.id == plugin for param in found.params}
        numbers = {"young": preset.young, "poisson": preset.poisson, "density": preset.density}
        numbers["damping-time"] = preset.damping_time
        if preset.flow:
            numbers["yield-strain"], numbers["hardening"], numbers["flow-time"] = preset.flow
        return cls(plugin, **{key: value for key, value in numbers.items() if key in taken})

    def to_dict(self) -> dict[str, Any]:
        """Give it as a scene writes it.

        Returns
        -------
        dict
        """
        return {"plugin": self.plugin, "params": dict(self.params)}

    def __repr__(self) -> str:
        params = "".join(f", {key}={value!r}" for key, value in self.params.items())
        return f"Material({self.plugin!r}{params})"


class Fabric:
    """A measured fabric, for a body that is a sheet.

    Parameters
    ----------
    name : str
        One of :meth:`presets`.
    plugin : str
        The material plugin that knows it.
    **params
        Other parameters of that plugin.
    """

    def __init__(self, name: str, *, plugin: str = "cloth", **params: Any) -> None:
        self.name = name
        self.material = Material(plugin, fabric=name, **params)

    def to_dict(self) -> dict[str, Any]:
        """Give it as a scene writes it.

        Returns
        -------
        dict
        """
        return self.material.to_dict()

    def __repr__(self) -> str:
        return f"Fabric({self.name!r})"

    @staticmethod
    def presets(plugin: str = "cloth") -> dict[str, str]:
        """List the fabrics.

        Parameters
        ----------
        plugin : str
            The material plugin that knows them.

        Returns
        -------
        dict
            Where its numbers come from, by the name of each fabric.
        """
        for found in plugins("material"):
            if found.id == plugin:
                param = found.param("fabric")
                return {choice: param.sources.get(choice, "") for choice in param.choices}
        raise PliantError(f"no material `{plugin}`; allowed is one of pliant.plugins('material')")


def open_options(
    *,
    threads: int = 0,
    plugin_path: Iterable[str | os.PathLike[str]] = (),
    allow_plugins: Iterable[str | os.PathLike[str]] = (),
    mesh: str | os.PathLike[str] | None = None,
    hands: Iterable[str] = (),
    history: bool = False,
) -> dict[str, Any]:
    """How a session is opened, as the native half takes it."""
    if threads < 0:
        raise PliantError(f"threads is {threads}; allowed is 0 for what the machine has, or more")
    options = {
        "threads": threads,
        "plugin_path": [Path(folder) for folder in plugin_path],
        # Scenes name the library of materials written in Python by path: it is this package's own module.
        "allow_plugins": [*map(Path, allow_plugins), _PLUGINS.parent],
        "package_plugins": _PLUGINS,
        "mesh": None if mesh is None else Path(mesh),
        "hands": list(hands),
        "history": history,
    }
    for text in _native.skipped_plugin_folders(options):
        warnings.warn(text, stacklevel=3)
    return options


def _plugin(row: dict[str, Any]) -> Plugin:
    path = row["path"]
    if "error" in row:
        return Plugin("unusable", Path(path).stem, Path(path).name, "-", row["error"], path)
    params = tuple(_param(param) for param in row["params"])
    return Plugin(row["kind"], row["id"], row["name"], row["version"], row["summary"], path, params)


def _param(row: dict[str, Any]) -> Param:
    limits = (row["min"], row["max"]) if row["type"] == "number" else None
    return Param(
        key=row["key"],
        type=row["type"],
        unit=row["unit"],
        summary=row["summary"],
        default=row.get("default"),
        range=limits,
        choices=tuple(row.get("choices", ())),
        sources=row.get("sources", {}),
        columns=tuple(row.get("columns", ())),
    )


for _public in (Param, Plugin, Preset, Material, Fabric, plugins, devices, edit_kinds, opposite_kind, quantities):
    _public.__module__ = "pliant"
