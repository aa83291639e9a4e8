"""From arrays to a .ptet file, or to its bytes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import as_callback, as_fields, as_path, as_points, as_tets, as_text, as_whole
from ._dataset import Dataset, open as open_file
from ._errors import ArgumentError
from ._request import Bound, Count, ErrorBounds, parse_bound, parse_count, parse_field_bounds, parse_number

ProgressCallback = Callable[[str, int, int], Any]
"""Called with a stage such as "collapsing", how much of it is done, and of how much (0: unknown), some 20 times a
second at most, from the thread that called. Returning False, not 0 or None, cancels: Cancelled is raised. What it
raises comes through."""

PathLike = Union[str, bytes, "os.PathLike[str]", "os.PathLike[bytes]"]

_MAGIC = b"\x89PTET\r\n\x1a"  # what a file begins with

# What is predicted, where errors are evaluated: the names of Cignoni et al. 2000, what is compared with them, and ours.
_METHODS = {
    "exact": ("exact", "exact"),
    "LN": ("local", "none"),
    "GN": ("gradient", "none"),
    "QN": ("quadric", "none"),
    "BF": ("simulate", "vertices"),
    "BFS": ("simulate", "samples"),
    "staadt-gross": ("weighted-sum", "none"),
    "trotts": ("per-tet", "none"),
}


@dataclass(frozen=True)
class Round:
    """How far a build had come at the end of a round.

    Attributes:
        vertices: that are left.
        cost: the most that a collapse of this round might cost.
        field_error: largest recorded so far, of any field, as a fraction of its range.
        domain_error: largest recorded so far, as a fraction of the diagonal.
    """

    vertices: int
    cost: float
    field_error: float
    domain_error: float


@dataclass(frozen=True)
class BuildReport:
    """What a build did.

    Attributes:
        input_vertices, input_tets: of the original.
        base_vertices, base_tets: of the coarsest mesh, vertices in no tet left out.
        records: collapses that the file holds.
        rounds: how many there were; `walk` has one entry for each.
        depth: longest chain of records that depend on one another.
        min_quality: the floor of the shape measure, also where nobody said.
        collapses: tries by what became of them: "accepted", "link condition", ...
        stopped_by: "target", or "no candidate left" with what stands against each half-edge that is left.
        last_refusals: what stood against the half-edges that were left, and how often; empty when the target was
            reached.
        simulations, exact_evaluations: half-edges that were simulated, and measured exactly, before they were taken.
        field_error: largest recorded, by field, in its units.
        domain_error: largest recorded, mesh units.
        walk: vertices, cost and errors after each round.
        notes: what was found in the input and done about it.
        cut_dependencies: added so that the boundary of no cut crosses itself.
        file_bytes: size of the file.
        collapse_seconds, certify_seconds, total_seconds: wall time.
        pieces: that the mesh was cut in; piece_records, piece_records_dropped: collapses that were decided in them and
            made in the whole, and those no longer possible there; piece_seconds, follow_seconds: wall time of both.
        peak_memory_bytes, foreseen_memory_bytes: the most resident memory that the process had by the end of the build,
            whatever had it (0: not known), and what was foreseen of it.
    """

    input_vertices: int
    input_tets: int
    base_vertices: int
    base_tets: int
    records: int
    rounds: int
    depth: int
    min_quality: float
    collapses: dict[str, int]
    stopped_by: str
    last_refusals: dict[str, int]
    simulations: int
    exact_evaluations: int
    field_error: dict[str, float]
    domain_error: float
    walk: list[Round]
    notes: list[str]
    cut_dependencies: int
    file_bytes: int
    collapse_seconds: float
    certify_seconds: float
    total_seconds: float
    pieces: int
    piece_records: int
    piece_records_dropped: int
    piece_seconds: float
    follow_seconds: float
    peak_memory_bytes: int
    foreseen_memory_bytes: int


class Built:
    """What `build` made.

    Attributes:
        path: of the file, or None when it is in memory.
        data: the file's bytes as a read-only memoryview, or None when they are in a file.
        report: a BuildReport.
    """

    def __init__(self, path: str | None, data: memoryview | None, report: BuildReport) -> None:
        self.path = path
        self.data = data
        self.report = report

    def open(self, *, memory_limit: int = 0, background: bool = False, salvage: bool = False) -> Dataset:
        """Opens it, as ptet.open does."""
        source = self.data if self.data is not None else self.path
        assert source is not None
        return open_file(source, memory_limit=memory_limit, background=background, salvage=salvage)

    def __repr__(self) -> str:
        where = repr(self.path) if self.path is not None else "in memory"
        report = self.report
        return (f"<ptet.Built {where}: {report.input_tets} tets down to {report.base_tets}, "
                f"{report.file_bytes} bytes>")


def _choose_method(method: str, predict: str | None, evaluate: str | None) -> tuple[str, str]:
    if not isinstance(method, str) or method not in _METHODS:
        raise ArgumentError(f"method {method!r}: it is one of {', '.join(_METHODS)}")
    prediction, evaluation = _METHODS[method]
    if predict is not None:
        prediction = predict
    if evaluate is not None:
        evaluation = evaluate
    if prediction == "exact" and evaluation != "exact":
        if predict is not None:
            raise ArgumentError("predict='exact' orders collapses by errors measured everywhere: it goes with "
                                "evaluate='exact'")
        prediction = "quadric"
    return prediction, evaluation


def _as_names(govern: object) -> list[str]:
    if govern is None:
        return []
    if not isinstance(govern, Iterable):
        raise ArgumentError(f"govern: names of fields are wanted, not {govern!r}")
    return [as_text(name, "govern") for name in ([govern] if isinstance(govern, str) else govern)]


def _as_welding(weld: bool | Bound | None) -> tuple[float, bool] | None:
    """Within what points are welded; None: not at all."""
    if weld is None or isinstance(weld, (bool, np.bool_)):
        return (0.0, False) if weld else None
    return parse_bound(weld, "weld")


def _as_output(out: PathLike) -> bytes:
    """A file that may be replaced: what is no .ptet file may be somebody's mesh."""
    path = as_path(out)
    if not path.endswith(b".ptet") and os.path.isfile(path) and os.path.getsize(path) > 0:
        with open(path, "rb") as file:
            if file.read(len(_MAGIC)) != _MAGIC:
                raise ArgumentError(f"out: {os.fsdecode(path)!r} is there and is not a .ptet file; give another name, "
                                    "or remove it first")
    return path


def build(points: npt.ArrayLike, tets: npt.ArrayLike, fields: Mapping[str, npt.ArrayLike] | None = None, *,
          out: PathLike | None = None, govern: str | Iterable[str] | None = None, method: str = "exact",
          predict: str | None = None, evaluate: str | None = None, objective: str = "both",
          max_field_error: ErrorBounds | None = None, max_domain_error: Bound = "2%",
          target_vertices: Count | float = 0.01, min_quality: float | None = None, max_star: int = 64,
          round_fraction: float = 0.3, threads: int = 0, memory_limit: int = 0, pieces: int = 1,
          weld: bool | Bound = False, keep_order: bool = False, source_name: str = "", source_hash: str = "",
          progress: Optional[ProgressCallback] = None) -> Built:
    """Simplifies a mesh, and keeps all its levels in one file.

    Arrays of any memory layout and byte order are taken; they are copied, and their numbers come back bit for bit.

    Args:
        points: (n, 3), any of the types int8 to float64; mesh units.
        tets: (m, 4) rows of `points`, any type of whole numbers, in any orientation.
        fields: by name (n,) or (n, components), any of the types int8 to float64.
        out: the file to write, whole or not at all; one that is there is replaced if it is a .ptet file, or its name
            says so. None: the bytes stay in memory.
        govern: names of the fields whose errors are kept small and stated; None: every floating-point field.
        method: "exact", or one of the paper's "LN", "GN", "QN", "BF", "BFS", or "staadt-gross", "trotts".
        predict: what orders the collapses instead of the method's: "exact", "local", "gradient", "quadric", "simulate",
            "weighted-sum", "per-tet".
        evaluate: where the errors that the file states are measured, instead of the method's: "exact" (everywhere, so
            that they are bounds), "samples", "vertices", "none". Another one than "exact" has method "exact" order
            collapses by quadrics.
        objective: the field error that is kept small where collapses are simulated: "max", "rms", "both".
        max_field_error: no collapse may have a larger one; field units or "2%", one for all or by field.
        max_domain_error: no collapse may have a larger one; mesh units or "2%" of the diagonal.
        target_vertices: how far down to go: a number of vertices, "1%" of them, or such a fraction below 1.
        min_quality: floor of the shape measure 6 sqrt(2) V / Lmax^3, 0 flat to 1 regular; None: 1e-3, or, where
            that is less, a twentieth of what all tets of the mesh have but the flattest twentieth (of a thousandth of
            their median where that is more).
        max_star: cap on the tets and boundary faces around a vertex, 8 to 4096.
        round_fraction: the best part of the candidates that a round may take, in (0, 1]. Less has somewhat
            smaller errors, and takes longer.
        threads: worker threads; 0: as many as the machine has. The bytes do not depend on it.
        memory_limit: the most resident memory, in bytes, that the process may come to; 0: no limit. A build that would
            take more is refused before it takes it (LimitError).
        pieces: the mesh is cut in so many pieces, which are collapsed one after the other before the whole; 1: it is
            one. The bytes depend on it, with the same guarantees. 1 to 65536.
        weld: first make one point of those that have the same place and the same values in every field, bit for bit: of
            the points that parts of a mesh share. A distance, in mesh units or "1e-7%" of the diagonal, 0.1% at most:
            also what rounding has set apart at the boundary, no farther apart than that, with values that differ by no
            larger a part of their field's range; 0: the first alone, as with True.
        keep_order: also keep in what order points, tets and their corners stand, so that they come back in it where
            that is asked for: `Dataset.extract(input_order=True)`. Takes some 2 bytes a point and up to 3 a tet, 4 of
            very large meshes.
        source_name, source_hash: where the mesh comes from, kept in the file as they are.
        progress: see ProgressCallback.

    Returns:
        Built, which `open()`s.

    Raises:
        ArgumentError (arrays, options), InputError (the mesh, with the first thing wrong), LimitError, FileError,
        Cancelled. Ctrl-C raises KeyboardInterrupt, soon; nothing is left behind.

    Other Python threads run meanwhile. Arrays may be changed once the first progress is told.
    """
    point_rows = as_points(points)
    vertices = len(point_rows)
    prediction, evaluation = _choose_method(method, predict, evaluate)
    if isinstance(target_vertices, (float, np.floating)) and 0 <= target_vertices < 1:
        target = float(target_vertices)
    else:
        target = float(parse_count(target_vertices, vertices, "target_vertices"))  # type: ignore[arg-type]
        if isinstance(target_vertices, str) and target_vertices.endswith("%"):
            # Of how many vertices, the build knows: those that tets use, once they are welded.
            share = parse_bound(target_vertices, "target_vertices")[0]
            target = share if share < 1 else target
    names = _as_names(govern)
    for text, what in ((prediction, "predict"), (evaluation, "evaluate"), (objective, "objective"),
                       (source_name, "source_name"), (source_hash, "source_hash")):
        as_text(text, what)
    path = None if out is None else _as_output(out)
    bounds = [(name, value, relative) for name, (value, relative) in
              parse_field_bounds(max_field_error, "max_field_error")]
    as_callback(progress)
    data, report = _core.build(
        point_rows, as_tets(tets, vertices), as_fields(fields, vertices), path,
        names, bounds, parse_bound(max_domain_error, "max_domain_error"), target,
        None if min_quality is None else parse_number(min_quality, "min_quality"), prediction,
        evaluation, objective, as_whole(max_star, 8, 4096, "max_star"),
        parse_number(round_fraction, "round_fraction"),
        as_whole(threads, 0, 1024, "threads"), as_whole(memory_limit, 0, 2**64 - 1, "memory_limit"),
        as_whole(pieces, 1, 65536, "pieces"), _as_welding(weld), bool(keep_order), source_name, source_hash,
        progress)
    report["walk"] = [Round(*step) for step in report["walk"]]
    return Built(None if path is None else os.fsdecode(path), None if data is None else memoryview(data), BuildReport(**report))


@dataclass(frozen=True)
class Finding:
    """One kind of defect.

    Attributes:
        code: stable, for programs: "inverted-tets".
        severity: "note", "warning" or "error": a mesh with an error cannot be built from.
        count: how often it occurs.
        message: one sentence, with what is done about it.
        first_ids: up to 8 ids of tets or vertices, whichever the message names.
    """

    code: str
    severity: str
    count: int
    message: str
    first_ids: list[int]


@dataclass(frozen=True)
class FieldSummary:
    """A field's name, type, components, and least and largest finite value (for vectors: of the length), NaN where there
    is none.

    Attributes:
        governs_by_default: whether a build takes it that is told of no field: the floating-point ones, or all where
            there are none.
        can_govern: whether errors of it can be measured: every value is finite, the range is, and 64-bit integers span
            less than 2^53. A build refuses to be governed by others.
    """

    name: str
    dtype: str
    components: int
    min: float
    max: float
    governs_by_default: bool
    can_govern: bool


@dataclass(frozen=True)
class MeshReport:
    """What a mesh is.

    Attributes:
        vertices, tets, boundary_faces, boundary_vertices: counts.
        components: of tets joined by faces; boundary_components: of boundary faces joined by edges.
        euler_characteristic, boundary_euler_characteristic: of the vertices in use.
        volume: mesh units cubed; boundary_area: mesh units squared.
        box_min, box_max: corners of the bounding box, mesh units.
        fields: a FieldSummary each.
        findings: every kind of defect there is.
    """

    vertices: int
    tets: int
    boundary_faces: int
    boundary_vertices: int
    components: int
    boundary_components: int
    euler_characteristic: int
    boundary_euler_characteristic: int
    volume: float
    boundary_area: float
    box_min: tuple[float, float, float]
    box_max: tuple[float, float, float]
    fields: list[FieldSummary]
    findings: list[Finding]


def validate(points: npt.ArrayLike, tets: npt.ArrayLike, fields: Mapping[str, npt.ArrayLike] | None = None, *,
             progress: Optional[ProgressCallback] = None) -> MeshReport:
    """Examines a mesh: counts, topology, and all that is wrong with it. Arguments as of `build`.

    Raises:
        ArgumentError (arrays), InputError (ids out of range), LimitError, Cancelled.
    """
    point_rows = as_points(points)
    vertices = len(point_rows)
    report = _core.validate(point_rows, as_tets(tets, vertices), as_fields(fields, vertices),
                            as_callback(progress))
    report["fields"] = [FieldSummary(*field) for field in report["fields"]]
    report["findings"] = [Finding(*finding) for finding in report["findings"]]
    return MeshReport(**report)
