//! Fields given by an array of a tetrahedral mesh file, at its nodes or elements.

use super::check_factor;
use crate::body::Layer;
use crate::scene::{SceneError, Source, parse_quantity};
use crate::session::shared::SharedModel;
use pliant_host::{ParamKind, ParamSettings, ParamValue, PluginInfo};
use pliant_mesh::TetMesh;
use pliant_mesh::tetrahedra::{DataPlace, MeshData, PARTS};
use toml::Spanned;

/// An entry of a scene that names an array of the mesh.
pub(super) struct ArrayField<'a> {
    /// Name of the array.
    pub(super) data: &'a Spanned<String>,
    /// Unit of its values; `None` where they are factors.
    pub(super) unit: Option<&'a Spanned<String>>,
    /// Key of the parameter.
    pub(super) key: &'a str,
    pub(super) source: &'a Source,
    pub(super) shared: &'a SharedModel,
}

impl ArrayField<'_> {
    /// The layer of the factors of the array.
    ///
    /// # Errors
    /// The body is not a tetrahedral mesh; the file has no array of this name, or several; the unit does not measure the parameter; or a value is missing
    /// or gives a factor out of range (with file, line, and node or element).
    pub(super) fn layer(&self, info: &PluginInfo, settings: &ParamSettings) -> Result<Layer, SceneError> {
        let Some(cells) = &self.shared.model.tetrahedra else {
            let text = "`data` is of the file of a tetrahedral mesh, and the model is a surface; allowed is `csv`, `colour` or `texture`";
            return Err(self.source.error(self.data.span(), text));
        };
        let mesh = cells.mesh();
        let array = self.array(mesh)?;
        let scale = self.scale(info, settings)?;
        let factor = |index| self.factor(mesh, array, index, scale);
        let factors: Vec<f64> = (0..array.values.len()).map(factor).collect::<Result<_, _>>()?;
        Ok(match array.place {
            DataPlace::Nodes => Layer::Nodes(factors),
            DataPlace::Elements if mesh.quadratic.is_empty() => Layer::Cells(factors),
            DataPlace::Elements => {
                Layer::Cells(factors.into_iter().flat_map(|factor| std::iter::repeat_n(factor, PARTS)).collect())
            }
        })
    }

    /// The only array of this name.
    fn array<'m>(&self, mesh: &'m TetMesh) -> Result<&'m MeshData, SceneError> {
        let (name, file) = (self.data.get_ref(), mesh.name().display());
        let wrong = |text| Err(self.source.error(self.data.span(), text));
        let mut found = mesh.data.iter().filter(|data| data.name == *name);
        match (found.next(), found.next()) {
            (None, _) => {
                wrong(format!("{file}: no array `{name}` of one number each; allowed is {}", mesh.list_data()))
            }
            (Some(first), Some(second)) => wrong(format!(
                "{file}: array `{name}` is in line {} (at {}) and in line {} (at {}); allowed is one, as of one time step",
                first.line, first.place, second.line, second.place
            )),
            (Some(array), None) => Ok(array),
        }
    }

    /// Multiplier from values to factors: 1 without a unit, otherwise the unit in SI over the value of the parameter.
    fn scale(&self, info: &PluginInfo, settings: &ParamSettings) -> Result<f64, SceneError> {
        let Some(unit) = self.unit else { return Ok(1.0) };
        let wrong = |text: String| self.source.error(unit.span(), text);
        let found = info.params.iter().enumerate().find(|(_, param)| param.key == self.key);
        let Some((index, param)) = found else { return Ok(1.0) };
        let ParamKind::Number { default, .. } = param.kind else { return Ok(1.0) };
        let size = parse_quantity(&format!("1 {}", unit.get_ref()), &param.unit)
            .map_err(|error| wrong(format!("unit `{}` of `{}`: {error}", unit.get_ref(), self.key)))?;
        let given = settings.iter().find(|(i, _)| *i == index).map(|(_, value)| value);
        match if let Some(ParamValue::Number(value)) = given { *value } else { default } {
            0.0 => Err(wrong(format!(
                "parameter `{}` is 0, and no value is a multiple of it; allowed is another one",
                self.key
            ))),
            value => Ok(size / value),
        }
    }

    /// The factor of the node or element `index`.
    fn factor(&self, mesh: &TetMesh, array: &MeshData, index: usize, scale: f64) -> Result<f64, SceneError> {
        let value = array.values[index];
        let factor = value * scale;
        let Err(allowed) = check_factor(factor) else { return Ok(factor) };
        let (entity, number) = match array.place {
            DataPlace::Nodes => ("node", mesh.node_number[index]),
            DataPlace::Elements => ("element", mesh.element_number[index]),
        };
        let found = match self.unit {
            _ if value.is_nan() => "no number".into(),
            Some(unit) => format!("{value} {}, {factor} times the parameter `{}`", unit.get_ref(), self.key),
            None => format!("factor {value}"),
        };
        let (file, line, name) = (mesh.name().display(), array.line, &array.name);
        let text =
            format!("{file}:{line}: array `{name}`: {entity} {number} has {found}; {allowed} times the parameter");
        Err(self.source.error(self.data.span(), text))
    }
}
