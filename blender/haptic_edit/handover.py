"""Strokes that are under way when a file is saved or closed, or when the extension is disabled.

What a stroke has done reaches Blender's data when the stroke ends. So it is ended first: a file that is saved in mid-stroke has what the hand has
done until then, and no session outlives its file.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING
from weakref import WeakSet

import bpy
from bpy.app.handlers import persistent

if TYPE_CHECKING:
    from .object_editing import Editing

# Whether the extension is enabled: a mode that is under way when it is disabled must not open a device again.
_is_enabled = False
# Meshes whose sessions are open.
_open: WeakSet[Editing] = WeakSet()


def watch(editing: Editing) -> None:
    """Have the strokes of a mesh ended in time, until it is forgotten."""
    _open.add(editing)


def forget(editing: Editing) -> None:
    """The session of a mesh is closed."""
    _open.discard(editing)


def finish_strokes() -> list[str]:
    """End every stroke that is under way and write what it did; return what went wrong, which the next warnings of its mesh say too."""
    errors = []
    for editing in [editing for editing in _open if editing.is_under_way]:
        try:
            is_stroke = editing.end()
        except Exception as error:  # noqa: BLE001 - the other strokes, and Blender, go on
            errors.append(str(error))
            editing.warn(str(error))
            continue
        if is_stroke and bpy.ops.ed.undo_push.poll():
            bpy.ops.ed.undo_push(message="Haptic stroke")
    return errors


def close_sessions() -> list[str]:
    """End the native threads of all sessions; return what went wrong."""
    errors = []
    for editing in list(_open):
        try:
            editing.close()
        except Exception as error:  # noqa: BLE001 - the other sessions are closed all the same
            errors.append(str(error))
    return errors


def _finish_and_close() -> None:
    """End strokes and sessions. No mesh is left to warn of errors, so they are printed."""
    for error in finish_strokes() + close_sessions():
        print(f"Haptic Edit: {error}", file=sys.stderr)


@persistent
def _before_save(*_args: object) -> None:
    finish_strokes()


@persistent
def _before_load(*_args: object) -> None:
    _finish_and_close()


@persistent
def _after_undo(*_args: object) -> None:
    for editing in _open:
        editing.is_stale = True


def _handlers() -> list[tuple[list, object]]:
    """Blender's lists of handlers, with what each is to call."""
    handlers = bpy.app.handlers
    undone = [(handlers.undo_post, _after_undo), (handlers.redo_post, _after_undo)]
    return [(handlers.save_pre, _before_save), (handlers.load_pre, _before_load), *undone]


def is_enabled() -> bool:
    """Whether the extension is enabled."""
    return _is_enabled


def register() -> None:
    """Have Blender tell of what ends a stroke."""
    global _is_enabled
    _is_enabled = True
    for handlers, handler in _handlers():
        handlers.append(handler)


def unregister() -> None:
    """End what is under way, and take the handlers from Blender's lists."""
    global _is_enabled
    _is_enabled = False
    _finish_and_close()
    for handlers, handler in _handlers():
        if handler in handlers:
            handlers.remove(handler)
