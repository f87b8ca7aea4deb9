//! Checks of the obstacles of a scene, and of the friction and restitution of all that is met.

use super::Check;
use crate::scene::{ObstacleScene, Scene, SceneError};
use pliant_mesh::TetMesh;
use std::ops::Range;
use toml::Spanned;

impl Check<'_> {
    /// Checks that the rows of a path are finite and in the order of time.
    pub(super) fn path(&self, path: &[[f64; 4]], of: &str, span: Range<usize>) -> Result<(), SceneError> {
        let wrong = |(i, row): (usize, &[f64; 4])| {
            let rises = i == 0 || path[i - 1][0] < row[0];
            !(rises && row.iter().all(|c| c.is_finite()))
        };
        match path.iter().enumerate().find(|row| wrong(*row)) {
            Some((i, row)) => self.wrong(
                span,
                format!("row {} of the path of {of} is {row:?}; allowed is finite numbers, times rising", i + 1),
            ),
            None => Ok(()),
        }
    }

    pub(super) fn obstacle(&self, obstacle: &ObstacleScene, scene: &Scene) -> Result<(), SceneError> {
        let (name, span) = (obstacle.name.get_ref(), obstacle.name.span());
        if let Some(mesh) = obstacle.mesh.as_ref().filter(|mesh| TetMesh::is_name(mesh.get_ref())) {
            let text =
                format!("obstacle `{name}` of a tetrahedral mesh; allowed is an OBJ file: an obstacle is a surface");
            return self.wrong(mesh.span(), text);
        }
        match (&obstacle.mesh, &obstacle.shape) {
            (Some(mesh), Some(_)) => return self.wrong(mesh.span(), "`mesh` and `shape`; allowed is one of them"),
            (None, None) => {
                let text = format!("obstacle `{name}` has no surface; allowed is one of `mesh` and `shape`");
                return self.wrong(span, text);
            }
            (None, Some(_)) => {
                let of_mesh = [
                    ("size", obstacle.size.as_ref().map(Spanned::span)),
                    ("scale", obstacle.scale.as_ref().map(Spanned::span)),
                ];
                if let Some((key, Some(span))) = of_mesh.into_iter().find(|(_, span)| span.is_some()) {
                    return self
                        .wrong(span, format!("`{key}` of obstacle `{name}` is for a `mesh`, and it has a `shape`"));
                }
            }
            (Some(_), None) => {}
        }
        if let (Some(size), Some(_)) = (&obstacle.size, &obstacle.scale) {
            return self.wrong(size.span(), "`size` and `scale`; allowed is one of them");
        }
        if let Some(scale) = &obstacle.scale {
            self.above(*scale.get_ref(), scale.span(), "scale", "")?;
        }
        for (what, length) in [("size", &obstacle.size), ("thickness", &obstacle.thickness)] {
            if let Some(length) = length {
                self.above(length.get_ref().si, length.span(), what, " m")?;
            }
        }
        self.friction(&obstacle.friction)?;
        self.path(obstacle.path.get_ref(), &format!("obstacle `{name}`"), obstacle.path.span())?;
        let turns = &obstacle.rotation_path;
        self.path(turns.get_ref(), &format!("the rotation of obstacle `{name}`"), turns.span())?;
        self.restitution(obstacle.restitution.as_ref())?;
        if let Some(scheme) = scene.time.integrator.scheme().filter(|scheme| !scheme.has_inertia()) {
            let text = format!(
                "obstacle `{name}` with `integrator = \"{}\"`; allowed is an integrator with inertia, as `backward-euler`: an equilibrium \
                 without contact need not exist",
                scheme.name()
            );
            return self.wrong(span, text);
        }
        Ok(())
    }

    pub(super) fn friction(&self, friction: &Spanned<[f64; 2]>) -> Result<(), SceneError> {
        let [fixed, sliding] = *friction.get_ref();
        if fixed >= sliding && sliding >= 0.0 && fixed.is_finite() {
            return Ok(());
        }
        let text = format!(
            "friction [{fixed}, {sliding}]; allowed is [to start, while sliding], 0 or more, the first not lower"
        );
        self.wrong(friction.span(), text)
    }

    pub(super) fn restitution(&self, restitution: Option<&Spanned<f64>>) -> Result<(), SceneError> {
        match restitution.filter(|e| !(0.0..=1.0).contains(e.get_ref())) {
            Some(e) => self.wrong(e.span(), format!("restitution {}; allowed is 0 to 1", e.get_ref())),
            None => Ok(()),
        }
    }
}
