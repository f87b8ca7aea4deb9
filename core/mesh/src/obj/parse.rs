//! Single-pass OBJ parser.
//!
//! Positive indices may refer to later lines, so their range is checked at the end; negative ones count back from their line and are checked there.

use std::collections::HashMap;

use super::cursor::Cursor;
use super::error::shorten;
use super::{Attributes, Corner, NONE, ObjProblem, Parsed, number};

/// Parses `bytes`. Returns the line, from 1, and the problem if that fails.
pub(super) fn parse(bytes: &[u8]) -> Result<Parsed, (u32, ObjProblem)> {
    if bytes.len() >= u32::MAX as usize {
        return Err((1, ObjProblem::TooLarge { bytes: bytes.len() }));
    }
    let mut cursor = Cursor::new(bytes);
    if bytes.contains(&0) {
        let at = bytes.iter().position(|&byte| byte == 0).unwrap_or(0);
        return Err((cursor.line_at(at), ObjProblem::Nul));
    }
    let mut parser = Parser::default();
    parser.out.face_start.push(0);
    while cursor.next_line() {
        let line = cursor.line();
        parser.statement(&mut cursor).map_err(|problem| (line, problem))?;
    }
    parser.finish(bytes).map_err(|(line, problem)| (line.unwrap_or(cursor.line()), problem))
}

#[derive(Default)]
struct Parser {
    out: Parsed,
    now: Attributes,
    tables: [Table; 4], // groups, objects, materials, libraries
}

/// Distinct names in the order of their first use.
#[derive(Default)]
struct Table {
    names: Vec<String>,
    index: HashMap<String, u32>,
}

impl Parser {
    fn statement(&mut self, cursor: &mut Cursor) -> Result<(), ObjProblem> {
        let start = cursor.at() as u32;
        match cursor.token() {
            b"v" => {
                let position = numbers(cursor, "v", 3)?;
                weight(cursor)?;
                self.out.positions.push(position.into());
                self.out.position_at.push(start);
            }
            b"vn" => {
                self.out.normals.push(numbers(cursor, "vn", 3)?.into());
                self.out.normal_at.push(start);
            }
            b"vt" => {
                let [u, v, _] = numbers(cursor, "vt", 1)?;
                self.out.texcoords.push([u, v]);
            }
            b"f" => self.face(cursor)?,
            b"g" => self.now.group = self.tables[0].index_of(cursor),
            b"o" => self.now.object = self.tables[1].index_of(cursor),
            b"usemtl" => self.now.material = self.tables[2].index_of(cursor),
            b"mtllib" => _ = self.tables[3].index_of(cursor),
            b"s" => self.now.smoothing = smoothing(cursor),
            [b'#', ..] => {
                cursor.skip_comment();
                return Ok(());
            }
            _ => {}
        }
        cursor.rest();
        Ok(())
    }

    fn face(&mut self, cursor: &mut Cursor) -> Result<(), ObjProblem> {
        let line = cursor.line();
        let first = self.out.corners.len();
        while cursor.skip_to_data() {
            let corner = self.corner(cursor.token())?;
            self.out.corners.push(corner);
        }
        let corners = &self.out.corners[first..];
        if corners.len() < 3 {
            return Err(ObjProblem::FewCorners { found: corners.len() });
        }
        if let Some(vertex) = repeated(corners) {
            return Err(ObjProblem::RepeatedVertex { vertex: vertex as usize + 1 });
        }
        if self.out.runs.last().is_none_or(|&(_, attributes)| attributes != self.now) {
            self.out.runs.push((self.out.face_line.len() as u32, self.now));
        }
        self.out.face_start.push(self.out.corners.len() as u32);
        self.out.face_line.push(line);
        Ok(())
    }

    fn corner(&self, token: &[u8]) -> Result<Corner, ObjProblem> {
        let counts = [self.out.positions.len(), self.out.texcoords.len(), self.out.normals.len()];
        let mut indices = [NONE; 3];
        let mut parts = token.split(|&byte| byte == b'/');
        for (kind, index) in indices.iter_mut().enumerate() {
            let part = parts.next().unwrap_or_default();
            if part.is_empty() && kind > 0 {
                continue;
            }
            let value = whole_number(part).ok_or_else(|| ObjProblem::Corner { token: shorten(token) })?;
            *index = from_zero(value, counts[kind]).ok_or_else(|| ObjProblem::Index {
                entity: ENTITIES[kind],
                token: shorten(token),
                count: counts[kind],
            })?;
        }
        if parts.next().is_some() {
            return Err(ObjProblem::Corner { token: shorten(token) });
        }
        let [v, vt, vn] = indices;
        Ok(Corner { v, vt, vn })
    }

    /// Checks the whole file. A line of `None` in the error means the last line.
    fn finish(mut self, bytes: &[u8]) -> Result<Parsed, (Option<u32>, ObjProblem)> {
        let out = &mut self.out;
        [out.groups, out.objects, out.materials, out.libraries] = self.tables.map(|table| table.names);
        if out.positions.is_empty() {
            let nothing = bytes.iter().all(u8::is_ascii_whitespace);
            return Err((None, if nothing { ObjProblem::Empty } else { ObjProblem::NoVertices }));
        }
        if out.face_line.is_empty() {
            return Err((None, ObjProblem::NoFaces { vertices: out.positions.len() }));
        }
        let counts = [out.positions.len(), out.texcoords.len(), out.normals.len()];
        let outside = |corner: &Corner| {
            let parts = [corner.v, corner.vt, corner.vn];
            (0..3).find(|&part| parts[part] as usize >= counts[part] && (part == 0 || parts[part] != NONE))
        };
        if let Some(at) = out.corners.iter().position(|corner| outside(corner).is_some()) {
            let face = out.face_start.partition_point(|&start| start as usize <= at) - 1;
            let corner = out.corners[at];
            let part = outside(&corner).unwrap_or(0);
            let token = (u64::from([corner.v, corner.vt, corner.vn][part]) + 1).to_string();
            let problem = ObjProblem::Index { entity: ENTITIES[part], token, count: counts[part] };
            return Err((Some(out.face_line[face]), problem));
        }
        Ok(self.out)
    }
}

const ENTITIES: [&str; 3] = ["v", "vt", "vn"];

impl Table {
    /// Index of the name in the rest of the line; `None` if it is empty.
    fn index_of(&mut self, cursor: &mut Cursor) -> Option<u32> {
        let name = text(cursor.rest());
        if name.is_empty() {
            return None;
        }
        let next = self.names.len() as u32;
        Some(*self.index.entry(name).or_insert_with_key(|name| {
            self.names.push(name.clone());
            next
        }))
    }
}

/// Decodes UTF-8, or otherwise Latin-1, which old exporters write and which accepts every byte.
fn text(bytes: &[u8]) -> String {
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    };
    text.replace("\\\r\n", " ").replace("\\\n", " ").trim().to_owned()
}

/// Reads `least` to 3 numbers; missing ones are 0.
#[inline]
fn numbers(cursor: &mut Cursor, entity: &'static str, least: usize) -> Result<[f64; 3], ObjProblem> {
    let mut values = [0.0; 3];
    for (found, value) in values.iter_mut().enumerate() {
        if !cursor.skip_to_data() {
            if found < least {
                return Err(ObjProblem::TooFew { entity, found, expected: least });
            }
            break;
        }
        *value = cursor.number().map_err(|token| ObjProblem::Number { entity, token: shorten(token) })?;
    }
    Ok(values)
}

/// Checks a single fourth number, which is a weight. More numbers are a colour and ignored.
#[inline]
fn weight(cursor: &mut Cursor) -> Result<(), ObjProblem> {
    if !cursor.skip_to_data() {
        return Ok(());
    }
    let token = cursor.token();
    if cursor.skip_to_data() {
        return Ok(());
    }
    match number::parse(token) {
        None => Err(ObjProblem::Number { entity: "v", token: shorten(token) }),
        Some(0.0) => Err(ObjProblem::ZeroWeight { token: shorten(token) }),
        Some(_) => Ok(()),
    }
}

/// Number of the smoothing group; `on` is 1, and any other text, such as `off`, is 0.
fn smoothing(cursor: &mut Cursor) -> u32 {
    cursor.skip_to_data();
    match cursor.token() {
        b"on" => 1,
        token => whole_number(token).and_then(|value| value.try_into().ok()).unwrap_or(0),
    }
}

#[inline]
fn whole_number(text: &[u8]) -> Option<i64> {
    let (negative, digits) = match text {
        [b'-', digits @ ..] => (true, digits),
        digits => (false, digits),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0_i64;
    for byte in digits {
        if !byte.is_ascii_digit() {
            return None;
        }
        value = value.saturating_mul(10).saturating_add(i64::from(byte - b'0'));
    }
    Some(if negative { -value } else { value })
}

/// Converts the index `value` of the file to one from 0, after `count` rows have been read.
#[inline]
fn from_zero(value: i64, count: usize) -> Option<u32> {
    let index = match value {
        0 => return None,
        1.. => value - 1,
        _ => count as i64 + value,
    };
    u32::try_from(index).ok().filter(|&index| index != NONE)
}

/// A vertex that occurs twice among the corners.
#[inline]
fn repeated(corners: &[Corner]) -> Option<u32> {
    if let [a, b, c] = corners {
        return if a.v == b.v || a.v == c.v { Some(a.v) } else { (b.v == c.v).then_some(b.v) };
    }
    let mut vertices: Vec<u32> = corners.iter().map(|corner| corner.v).collect();
    vertices.sort_unstable();
    vertices.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
}
