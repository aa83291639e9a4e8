// A mesh as a .vtu file, for ParaView, VTK or meshio: XML, the arrays raw behind it.

const kTypeNames = {
  int8: "Int8",
  uint8: "UInt8",
  int16: "Int16",
  uint16: "UInt16",
  int32: "Int32",
  uint32: "UInt32",
  int64: "Int64",
  uint64: "UInt64",
  float32: "Float32",
  float64: "Float64",
};
const kTetrahedron = 10; // VTK_TETRA

/** Of one number: "int16" has 2. */
function bytesOf(type) {
  return Number(/\d+$/.exec(type)[0]) / 8;
}

/** As the value of an attribute. XML has no form at all for most control characters: these are replaced. */
function escaped(text) {
  return text
    .replace(/[\0-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]/g, "\ufffd")
    .replace(/[&<>"\t\n\r]/g, (c) => `&#${c.charCodeAt(0)};`);
}

/** `mesh`: { positions, arrays: { name, type, components, bytes }, tets: vertex numbers, four each }. */
export function writeVtu(mesh) {
  const tetCount = mesh.tets.length / 4;
  const blocks = [];
  let offset = 0;
  const array = (name, type, components, bytes) => {
    const text =
      `<DataArray type="${kTypeNames[type]}" Name="${escaped(name)}" NumberOfComponents="${components}" ` +
      `format="appended" offset="${offset}"/>`;
    blocks.push(new BigUint64Array([BigInt(bytes.byteLength)]), bytes);
    offset += 8 + bytes.byteLength;
    return text;
  };
  const connectivity = BigInt64Array.from(mesh.tets, BigInt);
  const offsets = BigInt64Array.from({ length: tetCount }, (_, i) => BigInt(4 * (i + 1)));
  const vertexCount = mesh.positions.bytes.length / (3 * bytesOf(mesh.positions.type));
  const text = [
    '<?xml version="1.0"?>',
    '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
    `<UnstructuredGrid><Piece NumberOfPoints="${vertexCount}" NumberOfCells="${tetCount}">`,
    "<PointData>",
    ...mesh.arrays.map((a) => array(a.name, a.type, a.components, a.bytes)),
    "</PointData>",
    "<Points>",
    array("Points", mesh.positions.type, 3, mesh.positions.bytes),
    "</Points>",
    "<Cells>",
    array("connectivity", "int64", 1, connectivity),
    array("offsets", "int64", 1, offsets),
    array("types", "uint8", 1, new Uint8Array(tetCount).fill(kTetrahedron)),
    "</Cells>",
    "</Piece></UnstructuredGrid>",
    '<AppendedData encoding="raw">_',
  ].join("\n");
  return new Blob([text, ...blocks, "\n</AppendedData>\n</VTKFile>\n"], { type: "application/octet-stream" });
}
