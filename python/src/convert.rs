//! Python values to TOML, and arrays to OBJ text.

use super::failure::Failure;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use std::fmt::Write;
use toml::{Table, Value};

/// The TOML text of a dict of texts, numbers, booleans, lists and dicts; arrays and numbers of numpy are taken as lists and numbers.
/// Entries of the value `None` are left out.
#[pyfunction]
pub fn to_toml(scene: &Bound<'_, PyDict>) -> PyResult<String> {
    let table = table(scene, "")?;
    Ok(toml::to_string(&table).map_err(Failure::argument)?)
}

fn table(dict: &Bound<'_, PyDict>, path: &str) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, value) in dict {
        let Ok(key) = key.cast::<PyString>() else {
            return Err(Failure::argument(format!("key {key} of `{path}`: allowed is a text")).into());
        };
        if value.is_none() {
            continue;
        }
        let key = key.to_str()?;
        let below = if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
        table.insert(key.to_owned(), toml_value(&value, &below)?);
    }
    Ok(table)
}

fn toml_value(value: &Bound<'_, PyAny>, path: &str) -> PyResult<Value> {
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::String(text.to_str()?.to_owned()));
    }
    if let Ok(truth) = value.cast::<PyBool>() {
        return Ok(Value::Boolean(truth.is_true()));
    }
    if value.cast::<PyInt>().is_ok() {
        let number: i64 =
            value.extract().map_err(|_| Failure::argument(format!("`{path}`: {value} is over 64 bits")))?;
        return Ok(Value::Integer(number));
    }
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(Value::Float(number.value()));
    }
    if let Ok(dict) = value.cast::<PyDict>() {
        return Ok(Value::Table(table(dict, path)?));
    }
    if value.cast::<PyList>().is_ok() || value.cast::<PyTuple>().is_ok() {
        let items = value.try_iter()?.enumerate();
        let items = items.map(|(index, item)| toml_value(&item?, &format!("{path}.{index}")));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    // Arrays and numbers of numpy, and what looks like them.
    if let Ok(list) = value.call_method0("tolist") {
        return toml_value(&list, path);
    }
    // Paths.
    if let Ok(text) = value.call_method0("__fspath__") {
        return toml_value(&text, path);
    }
    let kind = value.get_type();
    let text = format!(
        "`{path}` is a {}; allowed are texts, numbers, booleans, arrays, lists and dicts",
        kind.name().map_or_else(|_| "value".into(), |name| name.to_string())
    );
    Err(Failure::argument(text).into())
}

/// The OBJ text of a mesh: `vertices` (n x 3), the corners of all faces one after the other, `counts` corners of each face (f), and
/// where given a texture coordinate for each corner (c x 2) and the name of each face's material by index.
#[pyfunction]
#[pyo3(signature = (name, vertices, corners, counts, texture=None))]
pub fn obj_text(
    name: &str,
    vertices: PyReadonlyArray2<'_, f64>,
    corners: PyReadonlyArray1<'_, i64>,
    counts: PyReadonlyArray1<'_, i64>,
    texture: Option<PyReadonlyArray2<'_, f64>>,
) -> PyResult<String> {
    let (vertices, corners, counts) = (vertices.as_array(), corners.as_array(), counts.as_array());
    let texture = texture.as_ref().map(|texture| texture.as_array());
    let wrong = |text: String| Err(Failure::argument(format!("mesh `{name}`: {text}")).into());
    if vertices.ncols() != 3 {
        return wrong(format!("vertices are (n x {}); allowed is (n x 3)", vertices.ncols()));
    }
    let (count, sum) = (vertices.nrows() as i64, counts.iter().sum::<i64>());
    if sum != corners.len() as i64 || counts.iter().any(|n| *n < 0) {
        return wrong(format!("{} corners for faces of {sum}; allowed is as many as the faces have", corners.len()));
    }
    if let Some(place) = corners.iter().position(|v| !(0..count).contains(v)) {
        let text = format!("corner {place} is vertex {}; allowed is 0 to {}", corners[place], count - 1);
        return wrong(text);
    }
    if let Some(place) = vertices.rows().into_iter().position(|row| row.iter().any(|c| !c.is_finite())) {
        return wrong(format!("vertex {place} is {}; allowed are finite numbers", vertices.row(place)));
    }
    if let Some(texture) = &texture
        && (texture.nrows() != corners.len() || texture.ncols() != 2)
    {
        let shape = texture.shape();
        let text =
            format!("texture coordinates are {shape:?}; allowed is ({} x 2), one for each corner", corners.len());
        return wrong(text);
    }
    // Each number in the fewest digits that give it back.
    let mut text = format!("o {}\n", name.replace(char::is_whitespace, "_"));
    for row in vertices.rows() {
        let _ = writeln!(text, "v {} {} {}", row[0], row[1], row[2]);
    }
    if let Some(texture) = &texture {
        for row in texture.rows() {
            let _ = writeln!(text, "vt {} {}", row[0], row[1]);
        }
    }
    let mut next = 0;
    for count in counts {
        text.push('f');
        for place in next..next + *count as usize {
            let vertex = corners[place] + 1;
            let _ = match texture {
                Some(_) => write!(text, " {vertex}/{}", place + 1),
                None => write!(text, " {vertex}"),
            };
        }
        next += *count as usize;
        text.push('\n');
    }
    Ok(text)
}
