"""Level of detail for tetrahedral meshes, with field errors that hold at every point.

    import ptet

    built = ptet.build(points, tets, {"t": temperature})        # arrays in; out="fire.ptet" writes a file
    data = ptet.open("fire.ptet")                               # or built.open()
    cut = data.extract(error="2%", focus=ptet.Sphere((0.3, 1.7, 0.3), 0.5))
    cut.points, cut.tets, cut.fields["t"], cut.field_error      # numpy arrays, without copies
    grid = cut.to_vtk()

Errors are numbers in the units of the field (of the mesh, for the domain), or percentages such as "2%" of the field's
range (of the bounding box's diagonal). Other Python threads run while the library works, Ctrl-C stops it, and every
exception of the library is an Error. A Dataset may be used by any number of threads at a time, a Session by one.
"""

import atexit as _atexit

from . import _core
from ._build import (
    BuildReport,
    Built,
    FieldSummary,
    Finding,
    MeshReport,
    ProgressCallback,
    Round,
    build,
    validate,
)
from ._dataset import ByteSource, Dataset, DatasetInfo, FieldInfo, open
from ._errors import (ArgumentError, Cancelled, Error, FileError, FormatError, InputError, LimitError,
                      MissingFileError, UnmetWarning)
from ._exchange import from_meshio, from_vtk
from ._extraction import BlockFailure, Extraction, PartErrors
from ._request import (
    Bound,
    Box,
    Budget,
    Count,
    HalfSpace,
    OrientedBox,
    Region,
    Sphere,
    Values,
    View,
)
from ._session import UNUSED, Session, SessionUpdate

__version__: str = _core.version

__all__ = [
    "ArgumentError", "BlockFailure", "Bound", "Box", "Budget", "BuildReport", "Built", "ByteSource", "Cancelled",
    "Count", "Dataset", "DatasetInfo", "Error", "Extraction", "FieldInfo", "FieldSummary", "FileError", "Finding",
    "FormatError", "HalfSpace", "InputError", "LimitError", "MeshReport", "MissingFileError", "OrientedBox",
    "PartErrors", "ProgressCallback", "Region", "Round", "Session", "SessionUpdate", "Sphere", "UNUSED",
    "UnmetWarning", "Values", "View", "build", "from_meshio", "from_vtk", "open", "validate",
]

# A thread in the library must not come back to Python, nor read through it, once Python has ended.
_atexit.register(_core.end)
