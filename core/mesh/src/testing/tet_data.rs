//! Files of tetrahedral boxes with numbers at nodes and elements, and in the XML format of VTK.

use super::tetrahedra::{TetBox, TetFormat};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::fmt::Write as _;
use std::io::Write;

/// Numbers at the nodes and elements of a box.
#[derive(Clone, Debug, Default)]
pub struct TetData {
    /// One at each node, named `at nodes`.
    pub nodes: Vec<f64>,
    /// One at each element, named `E`.
    pub elements: Vec<f64>,
}

/// How a `.vtu` has its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VtuFormat {
    /// Where they are, and as what.
    pub encoding: VtuEncoding,
    /// Whether they are compressed in blocks; not of text.
    pub is_compressed: bool,
    /// Whether the most significant byte is first.
    pub is_big_endian: bool,
    /// Whether sizes have 8 bytes.
    pub has_long_sizes: bool,
}

/// Where a `.vtu` has its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VtuEncoding {
    /// In the elements as text.
    Text,
    /// In the elements as base64.
    Base64,
    /// After the elements as base64.
    AppendedBase64,
    /// After the elements as they are.
    AppendedRaw,
}

impl VtuFormat {
    /// All that there are.
    pub fn all() -> impl Iterator<Item = Self> {
        let encodings = [VtuEncoding::Text, VtuEncoding::Base64, VtuEncoding::AppendedBase64, VtuEncoding::AppendedRaw];
        let made = move |bits: u32| {
            let encoding = encodings[(bits >> 3) as usize];
            let [is_compressed, is_big_endian, has_long_sizes] = [0, 1, 2].map(|bit| bits >> bit & 1 == 1);
            Self { encoding, is_compressed, is_big_endian, has_long_sizes }
        };
        (0..32).map(made).filter(|format| format.encoding != VtuEncoding::Text || !format.is_compressed)
    }

    /// A size before numbers.
    fn size(self, size: usize) -> Vec<u8> {
        match (self.has_long_sizes, self.is_big_endian) {
            (true, true) => (size as u64).to_be_bytes().to_vec(),
            (true, false) => (size as u64).to_le_bytes().to_vec(),
            (false, true) => (size as u32).to_be_bytes().to_vec(),
            (false, false) => (size as u32).to_le_bytes().to_vec(),
        }
    }

    /// The streams of an array: sizes and bytes together, or of blocks one after the other.
    fn streams(self, bytes: &[u8]) -> Vec<Vec<u8>> {
        if !self.is_compressed {
            return vec![[self.size(bytes.len()), bytes.to_vec()].concat()];
        }
        const BLOCK: usize = 200;
        let packed: Vec<Vec<u8>> = bytes.chunks(BLOCK).map(pack).collect();
        let last = bytes.len() % BLOCK;
        let mut header = [self.size(packed.len()), self.size(BLOCK), self.size(last)].concat();
        packed.iter().for_each(|block| header.extend(self.size(block.len())));
        vec![header, packed.concat()]
    }
}

fn pack(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // A Vec takes everything.
    _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

/// The arrays of a file, and those after its elements.
struct Arrays {
    format: VtuFormat,
    appended: Vec<u8>,
}

impl Arrays {
    /// A `DataArray` of numbers of a type with these bytes, the most significant last, and this text of them.
    fn array(&mut self, attributes: &str, of: &str, width: usize, bytes: &[u8], text: &str) -> String {
        let mut bytes = bytes.to_vec();
        if self.format.is_big_endian {
            bytes.chunks_exact_mut(width).for_each(<[u8]>::reverse);
        }
        let streams = self.format.streams(&bytes);
        let encoded = || streams.iter().map(|stream| STANDARD.encode(stream)).collect::<String>();
        let head = format!("<DataArray type=\"{of}\" {attributes}");
        let before = self.appended.len();
        match self.format.encoding {
            VtuEncoding::Text => format!("{head} format=\"ascii\">\n{text}\n</DataArray>\n"),
            VtuEncoding::Base64 => format!("{head} format=\"binary\">\n  {}\n</DataArray>\n", encoded()),
            VtuEncoding::AppendedBase64 => {
                self.appended.extend(encoded().into_bytes());
                format!("{head} format=\"appended\" offset=\"{before}\"/>\n")
            }
            VtuEncoding::AppendedRaw => {
                self.appended.extend(streams.concat());
                format!("{head} format=\"appended\" offset=\"{before}\"/>\n")
            }
        }
    }

    fn reals(&mut self, attributes: &str, numbers: &[f64]) -> String {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let text: Vec<String> = numbers.iter().map(|number| format!("{number:?}")).collect();
        self.array(attributes, "Float64", 8, &bytes, &text.join(" "))
    }

    fn sizes(&mut self, attributes: &str, numbers: &[u64]) -> String {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let text: Vec<String> = numbers.iter().map(u64::to_string).collect();
        self.array(attributes, "Int64", 8, &bytes, &text.join(" "))
    }
}

impl TetBox {
    /// The bytes of a file of the mesh with numbers.
    pub fn bytes_with(&self, format: TetFormat, data: &TetData) -> Vec<u8> {
        let mut out = self.bytes(format);
        match format {
            TetFormat::Vtk | TetFormat::VtkBinary | TetFormat::Vtk5 => vtk_data(format, data, &mut out),
            TetFormat::Msh2 | TetFormat::Msh2Binary | TetFormat::Msh4 | TetFormat::Msh4Binary => {
                msh_data("NodeData", "at nodes", 1, &data.nodes, format, &mut out);
                msh_data("ElementData", "E", self.first_tetrahedron(), &data.elements, format, &mut out);
            }
        }
        out
    }

    /// Number of the first tetrahedron in a Gmsh file.
    fn first_tetrahedron(&self) -> u64 {
        let text = String::from_utf8(self.bytes(TetFormat::Msh2)).unwrap_or_default();
        let after = text.split("$Elements\n").nth(1).unwrap_or_default();
        let count: usize = after.lines().next().and_then(|line| line.parse().ok()).unwrap_or_default();
        (count - self.tetrahedra.len()) as u64 + 1
    }

    /// The bytes of a `.vtu` of the mesh with numbers.
    pub fn vtu_bytes(&self, format: VtuFormat, data: &TetData) -> Vec<u8> {
        let mut arrays = Arrays { format, appended: Vec::new() };
        let elements: Vec<Vec<u64>> = match self.quadratic.is_empty() {
            true => self.tetrahedra.iter().map(|t| t.iter().map(|n| u64::from(*n)).collect()).collect(),
            false => self.quadratic.iter().map(|t| t.iter().map(|n| u64::from(*n)).collect()).collect(),
        };
        let each = elements.first().map_or(4, Vec::len) as u64;
        let (nodes, cells) = (self.points.len(), elements.len());
        let coordinates: Vec<f64> = self.points.iter().flat_map(|point| [point.x, point.y, point.z]).collect();
        let ends: Vec<u64> = (1..=cells as u64).map(|cell| each * cell).collect();
        let kinds = vec![if each == 4 { 10_u8 } else { 24 }; cells];
        let kinds_text = kinds.iter().map(u8::to_string).collect::<Vec<_>>().join(" ");
        let mut text = String::from("<?xml version=\"1.0\"?>\n<!-- a box -->\n");
        let order = if format.is_big_endian { "BigEndian" } else { "LittleEndian" };
        let size = if format.has_long_sizes { "UInt64" } else { "UInt32" };
        let compressor = if format.is_compressed { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
        _ = writeln!(
            text,
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{order}\" header_type=\"{size}\"{compressor}>\n<UnstructuredGrid>\n<Piece \
             NumberOfPoints=\"{nodes}\" NumberOfCells=\"{cells}\">"
        );
        let velocities = vec![0.25; 3 * nodes];
        text += "<PointData Scalars=\"at nodes\">\n";
        text += &arrays.reals("Name=\"at nodes\"", &data.nodes);
        text += &arrays.reals("Name=\"velocity\" NumberOfComponents=\"3\"", &velocities);
        text += "</PointData>\n<CellData>\n";
        text += &arrays.reals("Name=\"E\" NumberOfComponents=\"1\"", &data.elements);
        text += "</CellData>\n<Points>\n";
        text += &arrays.reals("Name=\"Points\" NumberOfComponents=\"3\"", &coordinates);
        text += "</Points>\n<Cells>\n";
        text += &arrays.sizes("Name=\"connectivity\"", &elements.concat());
        text += &arrays.sizes("Name=\"offsets\"", &ends);
        text += &arrays.array("Name=\"types\"", "UInt8", 1, &kinds, &kinds_text);
        text += "</Cells>\n</Piece>\n</UnstructuredGrid>\n";
        let mut out = text.into_bytes();
        let encoding = match format.encoding {
            VtuEncoding::AppendedBase64 => "base64",
            VtuEncoding::AppendedRaw => "raw",
            VtuEncoding::Text | VtuEncoding::Base64 => {
                out.extend_from_slice(b"</VTKFile>\n");
                return out;
            }
        };
        out.extend(format!("<AppendedData encoding=\"{encoding}\">\n _").into_bytes());
        out.extend(arrays.appended);
        out.extend_from_slice(b"\n</AppendedData>\n</VTKFile>\n");
        out
    }
}

/// A section of numbers of a Gmsh file; `first` is the number of the first node or element.
fn msh_data(section: &str, name: &str, first: u64, values: &[f64], format: TetFormat, out: &mut Vec<u8>) {
    let is_binary = matches!(format, TetFormat::Msh2Binary | TetFormat::Msh4Binary);
    out.extend(format!("${section}\n1\n\"{name}\"\n1\n0.0\n3\n0\n1\n{}\n", values.len()).into_bytes());
    for (number, value) in (first..).zip(values) {
        if is_binary {
            out.extend((number as i32).to_le_bytes());
            out.extend(value.to_le_bytes());
        } else {
            out.extend(format!("{number} {value:?}\n").into_bytes());
        }
    }
    out.extend(format!("\n$End{section}\n").into_bytes());
}

/// Numbers after the `POINT_DATA n` that ends a file, with others that nobody reads between them.
fn vtk_data(format: TetFormat, data: &TetData, out: &mut Vec<u8>) {
    let is_binary = format == TetFormat::VtkBinary;
    let numbers = |values: &[f64], out: &mut Vec<u8>| {
        for value in values {
            if is_binary { out.extend(value.to_be_bytes()) } else { out.extend(format!("{value:?} ").into_bytes()) }
        }
        out.push(b'\n');
    };
    out.extend_from_slice(b"VECTORS velocity double\n");
    numbers(&vec![0.25; 3 * data.nodes.len()], out);
    out.extend_from_slice(b"SCALARS at%20nodes double 1\nLOOKUP_TABLE default\n");
    numbers(&data.nodes, out);
    let cells = data.elements.len();
    out.extend(format!("CELL_DATA {cells}\nFIELD FieldData 2\npair 2 {cells} double\n").into_bytes());
    numbers(&vec![0.5; 2 * cells], out);
    out.extend(format!("E 1 {cells} double\n").into_bytes());
    numbers(&data.elements, out);
}
