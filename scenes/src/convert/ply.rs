//! Stanford PLY (Turk 1994): ASCII and both binary orders, through `ply-rs-bw`.
//!
//! That crate allocates memory only as elements arrive. What it does not check is checked here before the payload is
//! read: counts that the file is too short for, and elements without properties, which take no bytes, so that a header
//! may declare any number of them.

use super::{Assembly, ConvertError, Corner, linear};
use crate::Scene;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    BeginList, ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

/// Reads the PLY file `bytes`; `name` is used in messages and as the scene's name.
///
/// Reads a vertex's `x y z`, `nx ny nz`, `red green blue` (sRGB; integers from 0 to the type's maximum, floats from 0
/// to 1) and `s t`, `u v` or `texture_u texture_v`, and a face's `vertex_indices` or `vertex_index`. Everything else is
/// ignored.
///
/// # Errors
/// A header or an element that cannot be read, more elements than the file can hold, a vertex index out of range, a
/// face with fewer than three vertices, a vertex that is not finite, no faces.
pub fn ply(name: &str, bytes: &[u8]) -> Result<Scene, ConvertError> {
    let mut reader = Reader::new(bytes);
    let parse = |e: ParseError| file_error(name, one_line(&e));
    let header = Parser::<Vertex>::new().read_header(&mut reader).map_err(parse)?;
    check_header(name, &header, reader.get_ref().len())?;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (_, element) in &header.elements {
        match element.name.as_str() {
            "vertex" => {
                vertices =
                    Parser::<Vertex>::new().read_payload_for_element(&mut reader, element, &header).map_err(parse)?;
            }
            "face" => {
                faces = Parser::<Face>::new().read_payload_for_element(&mut reader, element, &header).map_err(parse)?;
            }
            _ => {
                Parser::<Skipped>::new().read_payload_for_element(&mut reader, element, &header).map_err(parse)?;
            }
        }
    }
    let mut assembly = Assembly::new(name);
    let mut corners = Vec::new();
    for (index, face) in faces.iter().enumerate() {
        let error = |problem| ConvertError::Element { file: name.to_owned(), element: "face", index, problem };
        corners.clear();
        for vertex in face.vertices() {
            let found = usize::try_from(vertex).ok().and_then(|v| vertices.get(v)).ok_or_else(|| {
                error(format!("names vertex {vertex}, but there are {}, counted from 0", vertices.len()))
            })?;
            if !found.position.iter().all(|v| v.is_finite()) {
                return Err(error(format!("has corner {vertex}, whose position is not finite in 32 bits")));
            }
            corners.push(found.corner());
        }
        if corners.len() < 3 {
            return Err(error(format!("has {} corners, but needs at least 3", corners.len())));
        }
        assembly.polygon(&corners);
    }
    Ok(assembly.scene)
}

fn file_error(name: &str, problem: String) -> ConvertError {
    ConvertError::File { file: name.to_owned(), problem }
}

/// The parser's message without line breaks, shortened since it may quote a whole line of the file.
fn one_line(e: &ParseError) -> String {
    let text = e.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    match text.char_indices().nth(200) {
        Some((end, _)) => format!("{} …", &text[..end]),
        None => text,
    }
}

fn check_header(name: &str, header: &Header, payload: usize) -> Result<(), ConvertError> {
    let has = |element: &str, property: &[&str]| {
        let found = header.elements.iter().find(|(_, e)| e.name == element);
        found.is_some_and(|(_, e)| e.count > 0 && property.iter().any(|&p| e.properties.iter().any(|(k, _)| k == p)))
    };
    for axis in ["x", "y", "z"] {
        if !has("vertex", &[axis]) {
            return Err(file_error(name, format!("there are no vertices with a property '{axis}'")));
        }
    }
    if !has("face", &["vertex_indices", "vertex_index"]) {
        let problem = "there are no faces with a property 'vertex_indices'; points and strips cannot be traced";
        return Err(file_error(name, problem.to_owned()));
    }
    let mut least = 0u128;
    for (_, e) in &header.elements {
        if e.properties.is_empty() && e.count > 0 {
            return Err(file_error(name, format!("element '{}' has {} entries but no property", e.name, e.count)));
        }
        least += e.count as u128 * bytes_at_least(e, &header.encoding);
    }
    if least > payload as u128 + 1 {
        let problem = format!("the header promises at least {least} bytes of elements, but only {payload} follow it");
        return Err(file_error(name, problem));
    }
    Ok(())
}

/// Minimum size of an element, with empty lists. The last line of a text file may lack its newline.
fn bytes_at_least(element: &ElementDef, encoding: &Encoding) -> u128 {
    let size = |t: &ScalarType| match t {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let properties = element.properties.iter().map(|(_, p)| match (encoding, &p.data_type) {
        (Encoding::Ascii, _) => 2,
        (_, PropertyType::Scalar(t) | PropertyType::List(t, _)) => size(t),
    });
    properties.sum()
}

#[derive(Default)]
struct Vertex {
    position: [f32; 3],
    normal: Option<[f32; 3]>,
    texcoord: Option<[f32; 2]>,
    color: Option<[f32; 3]>,
}

impl Vertex {
    fn corner(&self) -> Corner {
        let color = self.color.map(|c| c.map(linear));
        Corner { position: self.position, normal: self.normal, texcoord: self.texcoord, color }
    }

    /// `full` is the value that stands for 1 in a colour of this type.
    fn set(&mut self, name: &str, value: f32, full: f32) -> PropertyAccessResult {
        match name {
            "x" => self.position[0] = value,
            "y" => self.position[1] = value,
            "z" => self.position[2] = value,
            "nx" => self.normal.get_or_insert_default()[0] = value,
            "ny" => self.normal.get_or_insert_default()[1] = value,
            "nz" => self.normal.get_or_insert_default()[2] = value,
            "red" | "diffuse_red" => self.color.get_or_insert_default()[0] = value / full,
            "green" | "diffuse_green" => self.color.get_or_insert_default()[1] = value / full,
            "blue" | "diffuse_blue" => self.color.get_or_insert_default()[2] = value / full,
            "s" | "u" | "texture_u" => self.texcoord.get_or_insert_default()[0] = value,
            // PLY, like OBJ, starts v at the bottom of the image.
            "t" | "v" | "texture_v" => self.texcoord.get_or_insert_default()[1] = 1.0 - value,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match property {
            Property::Char(v) => self.set(name, v.into(), i8::MAX.into()),
            Property::UChar(v) => self.set(name, v.into(), u8::MAX.into()),
            Property::Short(v) => self.set(name, v.into(), i16::MAX.into()),
            Property::UShort(v) => self.set(name, v.into(), u16::MAX.into()),
            Property::Int(v) => self.set(name, v as f32, i32::MAX as f32),
            Property::UInt(v) => self.set(name, v as f32, u32::MAX as f32),
            Property::Float(v) => self.set(name, v, 1.0),
            Property::Double(v) => self.set(name, v as f32, 1.0),
            _ if matches!(name, "x" | "y" | "z") => PropertyAccessResult::UnsupportedType,
            _ => PropertyAccessResult::Ignored,
        }
    }
}

/// The vertex indices of a face, as a list of the file's type.
#[derive(Default)]
struct Face {
    signed: Vec<i32>,
    unsigned: Vec<u32>,
}

impl Face {
    fn vertices(&self) -> impl Iterator<Item = i64> {
        self.signed.iter().copied().map(i64::from).chain(self.unsigned.iter().copied().map(i64::from))
    }
}

fn is_corners(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn begin_list_int(&mut self, name: &str, _len: usize) -> BeginList<'_, i32> {
        if is_corners(name) { BeginList::Fill(&mut self.signed) } else { BeginList::UseSetter }
    }

    fn begin_list_uint(&mut self, name: &str, _len: usize) -> BeginList<'_, u32> {
        if is_corners(name) { BeginList::Fill(&mut self.unsigned) } else { BeginList::UseSetter }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !is_corners(name) {
            return PropertyAccessResult::Ignored;
        }
        self.signed = match property {
            Property::ListChar(v) => v.into_iter().map(i32::from).collect(),
            Property::ListUChar(v) => v.into_iter().map(i32::from).collect(),
            Property::ListShort(v) => v.into_iter().map(i32::from).collect(),
            Property::ListUShort(v) => v.into_iter().map(i32::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element that is ignored.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
