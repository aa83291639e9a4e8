"""A mesh that follows its requests, as a viewer holds it from frame to frame."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import as_callback
from ._dataset import Dataset
from ._errors import ArgumentError, Error
from ._extraction import BlockFailure, Extraction
from ._request import Bound, Budget, ErrorBounds, Region, Values, View, make_request

UNUSED = 0xFFFFFFFF
"""What unused slots hold."""

_SLICE_MS = 250.0  # so long the library changes the mesh before Python looks for Ctrl-C

Slots = npt.NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class SessionUpdate:
    """What an update did, and what mesh there is now.

    Attributes:
        changed_tets, changed_faces, changed_vertices: (k,) uint32, slots that were taken, freed, or hold something else
            now (of tets also: were made by another record, see Session.made_by); each once.
        tets, boundary_faces, vertices: of the mesh as it is now; unused slots are not counted.
        tets_added, tets_removed, vertices_added, vertices_removed: by splits and collapses. The first update adds the
            coarsest mesh as well, and so does one that starts over (see renumbered), which does not count what it
            leaves behind.
        splits, collapses: how many were made.
        field_error, rms_error, covered, domain_error, limited_by, complete, failures: as of Extraction; where it is
            not complete, the next update with the same request goes on.
        seconds: wall time of the call.
        renumbered: whether slots have other numbers than before, the first ones; those in use are all among the changed
            ones, and the arrays are shorter as a rule. So it is where of more than 4096 tet slots less than one in four
            is used once the update is complete, where damage was met or a limit of memory has dropped blocks, and after
            an update that was interrupted, of whose changes nobody was told: all slots are among the changed ones then,
            and what it did is not counted. Otherwise slots stay.
    """

    changed_tets: Slots
    changed_faces: Slots
    changed_vertices: Slots
    tets: int
    boundary_faces: int
    vertices: int
    tets_added: int
    tets_removed: int
    vertices_added: int
    vertices_removed: int
    splits: int
    collapses: int
    field_error: dict[str, float]
    rms_error: dict[str, float]
    covered: float | None
    domain_error: float
    limited_by: str
    complete: bool
    failures: list[BlockFailure]
    seconds: float
    renumbered: bool


class _Table:
    """Rows by slots, kept like the library's by what changes; it grows by halves again."""

    def __init__(self, fetch: Callable[[Slots | None], npt.NDArray[Any]]) -> None:
        self._fetch = fetch
        self.renew()

    def renew(self) -> None:
        self._rows = self._fetch(None)
        self._count = len(self._rows)

    def follow(self, changed: Slots, count: int) -> None:
        if count > len(self._rows):
            grown = np.empty((count + count // 2, *self._rows.shape[1:]), self._rows.dtype)
            grown[:self._count] = self._rows[:self._count]
            self._rows = grown
        self._count = count
        changed = changed[changed < count]
        self._rows[changed] = self._fetch(changed)

    def view(self) -> npt.NDArray[Any]:
        rows = self._rows[:self._count]
        rows.flags.writeable = False
        return rows


_SUMS = ("tets_added", "tets_removed", "vertices_added", "vertices_removed", "splits", "collapses", "seconds")
_CHANGED = ("changed_tets", "changed_faces", "changed_vertices")


class Session:
    """One viewer's mesh. An update makes the mesh that `Dataset.extract` gives for the same request, by splitting and
    collapsing what differs from the last one.

    Tets, boundary faces and vertices keep their slots while they stay, so that a copy elsewhere, as on a graphics card,
    needs only the changed slots. The arrays are read-only, and go on with the session: an array taken before an update
    shows the mesh after it, or, when the mesh has outgrown it, what there was before. Take them anew after each update.

    Any number of sessions may share a dataset. Each is for one thread at a time: a call while another thread updates
    raises Error.
    """

    def __init__(self, dataset: Dataset) -> None:
        if not isinstance(dataset, Dataset):
            raise ArgumentError(f"a Dataset is wanted, not {dataset!r}")
        self._dataset = dataset
        self._core = _core.OpenSession(dataset._core)
        self._lock = threading.Lock()
        core = self._core
        self._tets = _Table(core.tets)
        self._made_by: _Table | None = None
        self._faces = _Table(core.boundary_faces)
        self._vertices = _Table(core.vertices)
        self._points = _Table(core.points)
        self._fields = {field.name: _Table(lambda slots, i=i: core.field(i, slots))  # type: ignore[misc]
                        for i, field in enumerate(dataset.info.fields)}
        self._is_behind = False  # the tables, and who was told of the changes: an update did not end
        self._is_untold = False  # the tables have caught up since

    def update(self, *, error: ErrorBounds | None = None, domain_error: Bound | None = None,
               focus: Region | Iterable[Region] | None = None, values: Values | Iterable[Values] | None = None,
               view: View | None = None, budget: Budget | int | None = None, origins: bool = False,
               progress: Optional[Callable[[str, int, int], Any]] = None) -> SessionUpdate:
        """Makes the mesh that answers the request; arguments as of Dataset.extract. With `origins` there is `made_by`
        until the next update without, kept up like the tets. What does not fit Budget.milliseconds is left to the next
        update. Blocks that cannot be had do not raise here: `complete`, `limited_by` and `failures` tell.
        `progress` is called as of `build`: first, four times a second, and while blocks are read or waited for;
        returning False, not 0 or None, raises Cancelled.

        Raises:
            ArgumentError; the mesh is then as it was. Error: another thread updates. After Cancelled, and
            KeyboardInterrupt by Ctrl-C, the mesh is between the last one and what was asked, the next update goes on
            from there, and is `renumbered`.
        """
        as_callback(progress)
        info = self._dataset.info
        request = make_request(info.vertices, info.tets, error=error, domain_error=domain_error, focus=focus,
                               values=values, view=view, budget=budget, origins=origins)
        with self._alone():
            self._catch_up()
            self._is_behind = True
            try:
                summary = self._summary(self._in_slices(request, progress))
            except ArgumentError:
                self._is_behind = progress is not None  # which may have raised it, after some slices
                raise
            self._is_behind = self._is_untold = False
            return summary

    @property
    def tets(self) -> npt.NDArray[np.uint32]:
        """(slots, 4) uint32: vertex slots, positively oriented; unused slots are UNUSED throughout."""
        return self._shown(self._tets)

    @property
    def made_by(self) -> npt.NDArray[np.uint32] | None:
        """(slots,) uint32: the record that made each tet, UNUSED for original ones and for unused slots; None unless the
        last update asked for `origins`. Dataset.origin_values tells errors and levels by it."""
        with self._alone():
            self._catch_up()
            return None if self._made_by is None else self._made_by.view()

    @property
    def boundary_faces(self) -> npt.NDArray[np.uint32]:
        """(slots, 3) uint32: vertex slots, counter-clockwise seen from outside; unused slots are UNUSED throughout."""
        return self._shown(self._faces)

    @property
    def vertex_ids(self) -> npt.NDArray[np.uint32]:
        """(slots,) uint32: the vertices' numbers in the file; UNUSED for unused slots."""
        return self._shown(self._vertices)

    @property
    def points(self) -> npt.NDArray[Any]:
        """(slots, 3), mesh units; rows of unused slots mean nothing."""
        return self._shown(self._points)

    @property
    def fields(self) -> dict[str, npt.NDArray[Any]]:
        """By name (slots,) or (slots, components); rows of unused slots mean nothing."""
        return {name: self._shown(table) for name, table in self._fields.items()}

    def extraction(self) -> Extraction:
        """The mesh without slots, as Dataset.extract gives it."""
        with self._alone():
            return Extraction(self._core.extraction(), self._dataset.info, origins=self._core.has_origins)

    def __reduce_ex__(self, _: object) -> Any:
        raise TypeError("a Session is neither copied nor pickled: make another one, Dataset.session()")

    def __repr__(self) -> str:
        return f"<ptet.Session of {self._dataset!r}>"

    def _alone(self) -> _Alone:
        return _Alone(self._lock)

    def _shown(self, table: _Table) -> npt.NDArray[Any]:
        with self._alone():
            self._catch_up()
            return table.view()

    def _catch_up(self) -> None:
        """After an update that was interrupted."""
        if not self._is_behind:
            return
        self._is_untold = True
        for table in (self._tets, self._faces, self._vertices, self._points, *self._fields.values()):
            table.renew()
        self._follow_origins(None)
        self._is_behind = False

    def _follow_origins(self, changed: Slots | None) -> None:
        """Of all tets where nothing is known of them."""
        if not self._core.has_origins:
            self._made_by = None
        elif self._made_by is None or changed is None:
            self._made_by = _Table(self._core.made_by)
        else:
            self._made_by.follow(changed, self._core.slots[0])

    def _in_slices(self, request: _core.Request,
                   progress: Optional[Callable[[str, int, int], Any]]) -> list[dict[str, Any]]:
        """What the library says of each; the tables follow."""
        allowed_ms = request.max_milliseconds
        steps: list[dict[str, Any]] = []
        begin = time.monotonic()
        while True:
            left_ms = math.inf if allowed_ms is None else allowed_ms
            if steps:
                left_ms -= 1e3 * (time.monotonic() - begin)
                if left_ms <= 0:
                    return steps
            request.max_milliseconds = min(left_ms, _SLICE_MS)
            step = self._core.update(request, progress)
            self._follow(step)
            steps.append(step)
            if step["limited_by"] != "time":
                return steps

    def _follow(self, step: dict[str, Any]) -> None:
        tet_slots, face_slots, vertex_slots = self._core.slots
        self._tets.follow(step["changed_tets"], tet_slots)
        self._follow_origins(step["changed_tets"])
        self._faces.follow(step["changed_faces"], face_slots)
        for table in (self._vertices, self._points, *self._fields.values()):
            table.follow(step["changed_vertices"], vertex_slots)

    def _summary(self, steps: list[dict[str, Any]]) -> SessionUpdate:
        summary = dict(steps[-1])
        if len(steps) > 1:
            for name in _SUMS:
                summary[name] = sum(step[name] for step in steps)
            for name, count in zip(_CHANGED, self._core.slots):
                changed = np.unique(np.concatenate([step[name] for step in steps]))
                summary[name] = changed[changed < count]
            summary["renumbered"] = any(step["renumbered"] for step in steps)
        if self._is_untold:
            for name, count in zip(_CHANGED, self._core.slots):
                summary[name] = np.arange(count, dtype=np.uint32)
            summary["renumbered"] = True
        names = self._dataset.info.governing
        for name in ("field_error", "rms_error"):
            summary[name] = dict(zip(names, summary[name]))
        summary["failures"] = [BlockFailure(*failure) for failure in summary["failures"]]
        return SessionUpdate(**summary)


class _Alone:
    """Holds a session for one thread; waiting could be for ever, as the thread that updates may wait for this one."""

    def __init__(self, lock: threading.Lock) -> None:
        self._lock = lock

    def __enter__(self) -> None:
        if not self._lock.acquire(blocking=False):
            raise Error("the session is in use by another thread")

    def __exit__(self, *_: object) -> None:
        self._lock.release()
