//! Checks of the bodies of a scene.

use super::Check;
use crate::edit::Command;
use crate::scene::{BodyScene, Extent, FieldScene, FixedScene, Length, Scene, SceneError};
use std::ops::Range;
use toml::Spanned;

impl Check<'_> {
    pub(super) fn body(&self, body: &BodyScene) -> Result<(), SceneError> {
        match (&body.mesh, &body.shape) {
            (Some(mesh), Some(_)) => return self.wrong(mesh.span(), "`mesh` and `shape`; allowed is one of them"),
            (None, None) => {
                // A default name is not in the text; the material is.
                let span = [body.name.span(), body.material.plugin.span()].into_iter().find(|s| *s != (0..0));
                let text = format!("body `{}` has no model; allowed is one of `mesh` and `shape`", body.name.get_ref());
                return self.wrong(span.unwrap_or(0..0), text);
            }
            _ => {}
        }
        if let (Some(size), Some(_)) = (&body.size, &body.scale) {
            return self.wrong(size.span(), "`size` and `scale`; allowed is one of them");
        }
        if let Some(scale) = &body.scale {
            self.above(*scale.get_ref(), scale.span(), "scale", "")?;
        }
        if let Some(size) = &body.size {
            self.above(size.get_ref().si, size.span(), "size", " m")?;
        }
        if let Some(radius) = &body.grid.get_ref().radius {
            self.above(radius.get_ref().si, radius.span(), "radius of the region", " m")?;
        }
        self.above(
            body.grid.get_ref().relaxation.get_ref().si,
            body.grid.get_ref().relaxation.span(),
            "relaxation",
            " s",
        )?;
        if body.is_tetrahedral() {
            self.tetrahedra(body)?;
        }
        let region = body.extent();
        body.field.iter().try_for_each(|field| self.field(field))?;
        self.fibres(body)?;
        body.fixed.iter().try_for_each(|fixed| self.fixed(fixed, body, region))
    }

    /// Checks that a body of tetrahedra has no keys of other bodies.
    fn tetrahedra(&self, body: &BodyScene) -> Result<(), SceneError> {
        let mesh = body.mesh.as_ref().map_or("", |mesh| mesh.get_ref());
        let others = [
            ("sheet", body.sheet.as_ref().map(Spanned::span), "a sheet is an OBJ file"),
            ("subdivide", body.subdivide.as_ref().map(Spanned::span), "refine the mesh where it was made"),
            ("weld", body.weld.as_ref().map(Spanned::span), "merge its nodes where it was made"),
            (
                "grid",
                Some(body.grid.span()).filter(|span| *span != (0..0)),
                "it is simulated as it is, as a whole and without a grid",
            ),
            (
                "stitch",
                body.stitch.first().map(|_| body.mesh.as_ref().map_or(0..0, Spanned::span)),
                "only sheets are sewn",
            ),
        ];
        match others.into_iter().find_map(|(key, span, why)| Some((key, span?, why))) {
            Some((key, span, why)) => self.wrong(
                span,
                format!("`{key}` of body `{}`, a tetrahedral mesh ({mesh}): {why}; leave it out", body.name.get_ref()),
            ),
            None => Ok(()),
        }
    }

    /// Checks that no edit cuts or stitches where there is a body of tetrahedra, which would not follow.
    pub(super) fn edits_of_tetrahedra(&self, scene: &Scene) -> Result<(), SceneError> {
        let Some(body) = scene.body.iter().find(|body| body.is_tetrahedral()) else { return Ok(()) };
        for edit in &scene.edit {
            if let Command::Tool(kind) = self.command(edit)?
                && kind.changes_topology()
            {
                let text = format!(
                    "edit kind `{}` where body `{}` is a tetrahedral mesh, which is neither cut nor stitched; allowed is another kind, or the body's surface as an OBJ file",
                    kind.name(),
                    body.name.get_ref()
                );
                return self.wrong(edit.kind.span(), text);
            }
        }
        Ok(())
    }

    /// Checks that a field has exactly one way to give its factors.
    fn field(&self, spanned: &Spanned<FieldScene>) -> Result<(), SceneError> {
        let (field, span) = (spanned.get_ref(), spanned.span());
        let given = [
            field.box_.as_ref().map(|_| "`box`"),
            field.ball.as_ref().map(|_| "`ball`"),
            field.radius.as_ref().map(|_| "`radius`"),
            field.group.as_ref().map(|_| "`group`"),
            field.colour.as_ref().map(|_| "`colour`"),
            field.csv.as_ref().map(|_| "`csv`"),
            field.texture.as_ref().map(|_| "`texture`"),
            field.data.as_ref().map(|_| "`data`"),
            field.unit.as_ref().map(|_| "`unit`"),
            field.range.as_ref().map(|_| "`range`"),
            field.factor.as_ref().map(|_| "`factor`"),
        ];
        let found: Vec<&str> = given.into_iter().flatten().collect();
        let is_one = matches!(
            found[..],
            ["`box`", "`factor`"]
                | ["`ball`", "`radius`", "`factor`"]
                | ["`group`", "`factor`"]
                | ["`colour`"]
                | ["`colour`", "`range`"]
                | ["`csv`"]
                | ["`texture`"]
                | ["`texture`", "`range`"]
                | ["`data`"]
                | ["`data`", "`unit`"]
        );
        if !is_one {
            let found = if found.is_empty() { "no place".into() } else { found.join(" and ") };
            let text = format!(
                "`field` has {found}; allowed is `factor` with `box`, with `ball` and `radius` or with `group`, or `colour` or `texture` with \
                 or without `range`, or `csv`, or `data` with or without `unit`"
            );
            return self.wrong(span, text);
        }
        self.place(field.box_.as_ref(), field.radius.as_ref(), span)
    }

    /// Checks the corners of a box and the radius of a ball.
    pub(in crate::plan) fn place(
        &self,
        corners: Option<&[[Length; 3]; 2]>,
        radius: Option<&Length>,
        span: Range<usize>,
    ) -> Result<(), SceneError> {
        if let Some([min, max]) = corners
            && let Some(axis) = (0..3).find(|&i| min[i].si > max[i].si)
        {
            let text =
                format!("`box` goes from {} m to {} m; allowed is the least corner first", min[axis].si, max[axis].si);
            return self.wrong(span, text);
        }
        radius.map_or(Ok(()), |radius| self.above(radius.si, span, "radius", " m"))
    }

    fn fixed(&self, spanned: &Spanned<FixedScene>, body: &BodyScene, region: Extent) -> Result<(), SceneError> {
        let (fixed, span) = (spanned.get_ref(), spanned.span());
        let found: Vec<&str> = [
            fixed.box_.as_ref().map(|_| "`box`"),
            fixed.ball.as_ref().map(|_| "`ball`"),
            fixed.radius.as_ref().map(|_| "`radius`"),
            fixed.group.as_ref().map(|_| "`group`"),
            fixed.nodes.as_ref().map(|_| "`nodes`"),
            fixed.colour.as_ref().map(|_| "`colour`"),
            fixed.texture.as_ref().map(|_| "`texture`"),
            fixed.above.as_ref().map(|_| "`above`"),
        ]
        .into_iter()
        .flatten()
        .collect();
        let is_one = matches!(
            found[..],
            ["`box`"]
                | ["`ball`", "`radius`"]
                | ["`group`"]
                | ["`nodes`"]
                | ["`colour`"]
                | ["`colour`", "`above`"]
                | ["`texture`"]
                | ["`texture`", "`above`"]
        );
        if !is_one {
            let found = if found.is_empty() { "no place".into() } else { found.join(" and ") };
            let text = format!(
                "`fixed` has {found}; allowed is `box`, `ball` and `radius`, `group`, `nodes`, or `colour` or `texture` with or without `above`"
            );
            return self.wrong(span, text);
        }
        if body.is_tetrahedral() && (fixed.colour.is_some() || fixed.texture.is_some()) {
            let text = format!(
                "`fixed` of body `{}` has {}, and a tetrahedral mesh has neither colours nor texture coordinates; allowed is `box`, `ball` and `radius`, `group`, \
                 or `nodes`",
                body.name.get_ref(),
                found[0]
            );
            return self.wrong(span, text);
        }
        if let Some(above) = &fixed.above
            && !(*above.get_ref() > 0.0 && *above.get_ref() <= 1.0)
        {
            let text = format!("`above` is {}; allowed is above 0 and at most 1", above.get_ref());
            return self.wrong(above.span(), text);
        }
        self.place(fixed.box_.as_ref(), fixed.radius.as_ref(), span.clone())?;
        if fixed.nodes.is_some() && region == Extent::Local {
            return self
                .wrong(span, "`nodes` of a local region have no lasting numbers; allowed is `box`, `ball`, `group`, `colour` or `texture`");
        }
        self.path(&fixed.path, "a `fixed`", span)
    }
}
