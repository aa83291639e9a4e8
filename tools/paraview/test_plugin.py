"""What the plugin does in ParaView, compared with the C interface of the library. Run by test-in-root.sh:

    pvbatch test_plugin.py PLUGIN LIBPTET GOLDEN-FOLDER WORK-FOLDER [FILE.ptet]
"""
import ctypes
import pathlib
import shutil
import sys

import numpy as np
from paraview import simple
from paraview.vtk.util.numpy_support import vtk_to_numpy

PLUGIN, LIBRARY, GOLDEN, WORK = sys.argv[1:5]
FILES = [str(pathlib.Path(GOLDEN) / "real.ptet"), str(pathlib.Path(GOLDEN) / "fields.ptet")] + sys.argv[5:6]

simple.LoadPlugin(PLUGIN, ns=globals())

# ---- The library through its C interface ----

c = ctypes.CDLL(LIBRARY)
u32, u64, i32, f64, text, handle = (ctypes.c_uint32, ctypes.c_uint64, ctypes.c_int32, ctypes.c_double, ctypes.c_char_p,
                                    ctypes.c_void_p)


class DatasetInfo(ctypes.Structure):
    _fields_ = [("struct_size", u64), ("vertices", u64), ("tets", u64), ("base_vertices", u64), ("base_tets", u64),
                ("records", u64), ("blocks", u64), ("file_bytes", u64), ("fields", u32), ("position_type", i32),
                ("box_min", f64 * 3), ("box_max", f64 * 3), ("diagonal", f64), ("max_domain_error", f64),
                ("has_input_order", i32), ("errors_are_bounds", i32)]


class FieldInfo(ctypes.Structure):
    _fields_ = [("struct_size", u64), ("name", text), ("type", i32), ("components", u32), ("governing", i32),
                ("reserved", u32), ("range", f64), ("max_error", f64), ("max_rms", f64)]


class ExtractionInfo(ctypes.Structure):
    _fields_ = [("struct_size", u64), ("vertices", u64), ("tets", u64), ("boundary_faces", u64), ("fields", u32),
                ("limited_by", i32), ("domain_error", f64), ("bytes_read", u64), ("seconds", f64),
                ("read_requests", u64), ("failures", u32), ("complete", i32)]


class Array(ctypes.Structure):
    _fields_ = [("struct_size", u64), ("name", text), ("data", handle), ("rows", u64), ("components", u32),
                ("type", i32)]


TYPES = ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"]
for name, result, arguments in [
        ("ptet_dataset_open", i32, [text, handle, ctypes.POINTER(handle), handle]),
        ("ptet_dataset_get_info", i32, [handle, handle, handle]),
        ("ptet_dataset_get_field", i32, [handle, u32, handle, handle]),
        ("ptet_request_new", handle, []),
        ("ptet_request_add_field_error", i32, [handle, text, f64, i32, handle]),
        ("ptet_request_set_domain_error", i32, [handle, f64, i32, handle]),
        ("ptet_request_set_max_tets", i32, [handle, u64, handle]),
        ("ptet_request_add_focus_box", i32, [handle, handle, handle, handle]),
        ("ptet_request_add_focus_sphere", i32, [handle, handle, f64, handle]),
        ("ptet_request_set_focus_error", i32, [handle, f64, i32, handle]),
        ("ptet_request_set_focus_falloff", i32, [handle, f64, i32, handle]),
        ("ptet_dataset_extract", i32, [handle, handle, handle, handle, ctypes.POINTER(handle), handle]),
        ("ptet_extraction_get_info", i32, [handle, handle, handle]),
        ("ptet_extraction_get_positions", i32, [handle, handle, handle]),
        ("ptet_extraction_get_field", i32, [handle, u32, handle, handle]),
        ("ptet_extraction_tets", ctypes.POINTER(u32), [handle]),
        ("ptet_extraction_vertices_in_file", ctypes.POINTER(u32), [handle]),
        ("ptet_extraction_field_error", f64, [handle, u32]),
        ("ptet_extraction_rms_error", f64, [handle, u32]),
        ("ptet_limit_name", text, [i32])]:
    getattr(c, name).restype = result
    getattr(c, name).argtypes = arguments


def ok(status):
    assert status == 0, f"the library refused: {status}"


def sized(structure):
    value = structure()
    value.struct_size = ctypes.sizeof(structure)
    return value


def table(array):
    dtype = np.dtype(TYPES[array.type])
    raw = ctypes.string_at(array.data, array.rows * array.components * dtype.itemsize)
    rows = np.frombuffer(raw, dtype)
    return rows.reshape(-1, array.components) if array.components > 1 else rows


class Reference:
    """An opened file, and meshes out of it as plain arrays."""

    def __init__(self, path):
        self.data = handle()
        ok(c.ptet_dataset_open(path.encode(), None, ctypes.byref(self.data), None))
        self.info = sized(DatasetInfo)
        ok(c.ptet_dataset_get_info(self.data, ctypes.byref(self.info), None))
        self.fields = [sized(FieldInfo) for _ in range(self.info.fields)]
        for number, field in enumerate(self.fields):
            ok(c.ptet_dataset_get_field(self.data, number, ctypes.byref(field), None))

    def extract(self, *conditions):
        request, extraction = c.ptet_request_new(), handle()
        for name, *values in conditions:
            values = [(f64 * len(v))(*v) if isinstance(v, (list, tuple)) else v for v in values]
            ok(getattr(c, "ptet_request_" + name)(request, *values, None))
        ok(c.ptet_dataset_extract(self.data, request, None, None, ctypes.byref(extraction), None))
        info = sized(ExtractionInfo)
        ok(c.ptet_extraction_get_info(extraction, ctypes.byref(info), None))
        mesh = {"tets": np.ctypeslib.as_array(c.ptet_extraction_tets(extraction), (info.tets, 4)).astype("i8"),
                "ids": np.ctypeslib.as_array(c.ptet_extraction_vertices_in_file(extraction), (info.vertices,)).astype("i8"),
                "arrays": {}, "errors": {}, "rms": {}, "domain error": info.domain_error,
                "limited by": c.ptet_limit_name(info.limited_by).decode()}
        array = sized(Array)
        ok(c.ptet_extraction_get_positions(extraction, ctypes.byref(array), None))
        mesh["points"] = table(array)
        for number, field in enumerate(self.fields):
            array = sized(Array)
            ok(c.ptet_extraction_get_field(extraction, number, ctypes.byref(array), None))
            mesh["arrays"][array.name.decode()] = table(array)
            if field.governing:
                mesh["errors"][array.name.decode()] = c.ptet_extraction_field_error(extraction, number)
                mesh["rms"][array.name.decode()] = c.ptet_extraction_rms_error(extraction, number)
        return mesh


# ---- Comparison ----

def canonical(tets):
    """Corners ascending, the last two swapped where the orientation wants it; rows sorted."""
    order = np.argsort(tets, axis=1)
    odd = np.zeros(len(tets), bool)
    for i in range(4):
        for k in range(i):
            odd ^= order[:, k] > order[:, i]
    tets = np.sort(tets, axis=1)
    tets[odd, 2:] = tets[odd, :1:-1]
    return tets[np.lexsort(tets.T[::-1])]


def tets_of(grid):
    return vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)


def scalar(grid, name):
    value = grid.GetFieldData().GetAbstractArray(name).GetVariantValue(0)
    return value.ToString() if value.IsString() else value.ToDouble()


def fetch(proxy):
    simple.UpdatePipeline(proxy=proxy)
    return simple.servermanager.Fetch(proxy)


def check(what, reader, expected):
    grid = fetch(reader)
    ids = vtk_to_numpy(grid.GetPointData().GetGlobalIds())
    order = np.argsort(expected["ids"])
    assert np.array_equal(ids, expected["ids"][order]), what
    assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), expected["points"][order]), what
    assert np.array_equal(canonical(ids[tets_of(grid)]), canonical(expected["ids"][expected["tets"]])), what
    for name, values in expected["arrays"].items():
        given = vtk_to_numpy(grid.GetPointData().GetArray(name))
        assert given.dtype == values.dtype and np.array_equal(given, values[order], equal_nan=given.dtype.kind == "f"), (what, name)
    for name, error in expected["errors"].items():
        assert scalar(grid, "error of " + name) == error, (what, name)
        if not np.isnan(expected["rms"][name]):
            assert abs(scalar(grid, "RMS error of " + name) - expected["rms"][name]) <= 1e-9 * expected["rms"][name], what
    assert scalar(grid, "domain error") == expected["domain error"], what
    assert scalar(grid, "limited by") == expected["limited by"] and scalar(grid, "complete") == 1, what
    print(f"  {what}: {grid.GetNumberOfCells()} tets as the library gives")
    return grid


def events(proxy, name):
    """What the reader's VTK object tells from now on."""
    heard = []
    proxy.GetClientSideObject().AddObserver(name, lambda *_: heard.append(name))
    return heard


def check_requests(path):
    print(path)
    library = Reference(path)
    low, high, diagonal = list(library.info.box_min), list(library.info.box_max), library.info.diagonal
    reader = simple.OpenDataFile(path)
    assert reader.GetXMLName() == "PtetReader"
    reader.PointIdsoftheFile = 1

    # What the interface offers at first: a box of half the size in the middle, a sphere that fits.
    assert np.allclose(reader.Position, [a + (b - a) / 4 for a, b in zip(low, high)])
    assert np.allclose(reader.Length, [(b - a) / 2 for a, b in zip(low, high)])
    assert np.allclose(reader.Center, [(a + b) / 2 for a, b in zip(low, high)])
    assert np.isclose(reader.Radius, min(b - a for a, b in zip(low, high)) / 4)

    progress = events(reader, "ProgressEvent")
    check("all", reader, library.extract(("set_max_tets", 200000)))
    assert progress, "no progress was told"
    reader.LimitTetrahedra = 0
    whole = check("the original", reader, library.extract())
    names = [field.name.decode() for field in library.fields if field.governing]
    reader.BoundFieldErrors, reader.FieldError = 1, 3
    check("field error 3%", reader, library.extract(("add_field_error", b"", 0.03, 1)))
    reader.BoundDomainError, reader.DomainError = 1, 0.5
    check("and domain error 0.5%", reader,
          library.extract(("add_field_error", b"", 0.03, 1), ("set_domain_error", 0.005, 1)))
    reader.BoundFieldErrors = reader.BoundDomainError = 0
    reader.FieldErrorsbyName = [names[0], "8"]
    check(f"error of {names[0]} 8%", reader, library.extract(("add_field_error", names[0].encode(), 0.08, 1)))
    reader.FieldErrorsbyName = []
    reader.LimitTetrahedra, reader.Tetrahedra = 1, library.info.tets // 5
    check("a fifth of the tets", reader, library.extract(("set_max_tets", library.info.tets // 5)))
    reader.Tetrahedra, reader.Focus = 0, "Sphere"
    few = ("set_max_tets", 0)
    check("focus sphere", reader,
          library.extract(few, ("add_focus_sphere", list(reader.Center), reader.Radius)))
    reader.Focus = "Box"
    box = ("add_focus_box", list(reader.Position), [a + b for a, b in zip(reader.Position, reader.Length)])
    check("focus box", reader, library.extract(few, box))
    reader.ErrorinFocus = 2
    check("focus box within 2%", reader, library.extract(few, box, ("set_focus_error", 0.02, 1)))
    reader.ErrorinFocus, reader.LimitTetrahedra = 0, 0
    reader.BoundErrorsbyDistance, reader.Falloff = 1, 50
    check("focus box with falloff", reader, library.extract(box, ("set_focus_falloff", 0.5, 1)))
    reader.BoundErrorsbyDistance, reader.LimitTetrahedra = 0, 1

    # A turned box is the same region to the reader as to ParaView's own clip.
    reader.Rotation = [20, -35, 50]
    reader.Position = [(a + b) / 2 for a, b in zip(low, high)]
    reader.Length = [diagonal / 5, diagonal / 9, diagonal / 7]
    turned = fetch(reader)
    original = simple.TrivialProducer()
    original.GetClientSideObject().SetOutput(whole)
    inside = []
    for source in (reader, original):
        clip = simple.Clip(Input=source, ClipType="Box", Crinkleclip=1, Invert=1)
        clip.ClipType.Position, clip.ClipType.Rotation, clip.ClipType.Length = reader.Position, reader.Rotation, reader.Length
        grid = fetch(clip)
        ids = vtk_to_numpy(grid.GetPointData().GetArray("vertex in file"))
        inside.append(canonical(ids[tets_of(grid)]))
        simple.Delete(clip)
    simple.Delete(original)
    assert len(inside[0]) > 0 and np.array_equal(*inside)
    print(f"  turned focus box: {len(inside[0])} original tets inside, {turned.GetNumberOfCells()} in all")

    # Arrays
    everything = list(reader.PointArrays.Available)
    assert everything == [field.name.decode() for field in library.fields]
    reader.PointArrays = everything[1:]
    grid = fetch(reader)
    assert grid.GetPointData().GetArray(everything[0]) is None
    assert all(grid.GetPointData().GetArray(name) for name in everything[1:])
    reader.PointArrays = everything

    # A state holds it all.
    state = str(pathlib.Path(WORK) / "state.pvsm")
    simple.SaveState(state)
    before = tets_of(fetch(reader)).copy()
    simple.ResetSession()
    simple.LoadState(state)
    again = [proxy for proxy in simple.GetSources().values() if proxy.GetXMLName() == "PtetReader"]
    assert len(again) == 1 and np.array_equal(tets_of(fetch(again[0])), before)
    simple.ResetSession()
    return library


def check_abort():
    path = FILES[0]
    library = Reference(path)
    reader = simple.OpenDataFile(path)
    reader.PointIdsoftheFile = 1
    vtk_object = reader.GetClientSideObject()
    tag = vtk_object.AddObserver("ProgressEvent", lambda *_: vtk_object.SetAbortExecute(1))
    grid = fetch(reader)
    assert grid.GetNumberOfCells() == library.info.base_tets and scalar(grid, "complete") == 0
    vtk_object.RemoveObserver(tag)
    vtk_object.SetAbortExecute(0)
    reader.MarkModified(reader.SMProxy)
    check("after an abort", reader, library.extract())


def check_faults():
    damaged = str(pathlib.Path(WORK) / "damaged.ptet")
    shutil.copy(FILES[0], damaged)
    with open(damaged, "r+b") as file:
        file.seek(pathlib.Path(damaged).stat().st_size // 2)
        file.write(bytes(64))
    for path, is_there in ((damaged, True), (str(pathlib.Path(WORK) / "missing.ptet"), False),
                           (str(pathlib.Path(__file__).resolve()), False)):
        reader = simple.ptetReader(FileName=path)
        errors = events(reader, "ErrorEvent")
        cells = fetch(reader).GetNumberOfCells()
        assert errors, path + ": no error was told"
        assert 0 < cells < Reference(FILES[0]).info.tets if is_there else cells == 0, path
        print(f"  {path}: an error, {cells} tets")
    simple.ResetSession()


for file in FILES:
    check_requests(file)
print("abort")
check_abort()
print("faults (the errors that follow are meant to be there)")
check_faults()
print("The plugin does what the library does.")
