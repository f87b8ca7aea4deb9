//! Checks of the `[[body.fibre]]` entries of a scene.

use super::check::Check;
use crate::scene::{BodyScene, FibreScene, SceneError};
use toml::Spanned;

impl Check<'_> {
    /// Checks that each entry has one way to give directions and at most one place, and that no entry replaces all before it.
    pub(super) fn fibres(&self, body: &BodyScene) -> Result<(), SceneError> {
        if let (Some(first), Some(_)) = (body.fibre.first(), &body.sheet) {
            let text = "fibres of a sheet; allowed is of a solid. A sheet has a direction of its warp: `sheet = { warp = .. }`";
            return self.wrong(first.span(), text);
        }
        for (index, spanned) in body.fibre.iter().enumerate() {
            self.fibre(spanned)?;
            if index > 0 && !has_place(spanned.get_ref()) {
                let text = "fibres of the whole body after others, which they replace; allowed is the entry without a place first";
                return self.wrong(spanned.span(), text);
            }
        }
        Ok(())
    }

    fn fibre(&self, spanned: &Spanned<FibreScene>) -> Result<(), SceneError> {
        let (fibre, span) = (spanned.get_ref(), spanned.span());
        let lines = [
            fibre.direction.as_ref().map(|_| "`direction`"),
            fibre.around.as_ref().map(|_| "`around`"),
            fibre.along.as_ref().map(|_| "`along`"),
            fibre.csv.as_ref().map(|_| "`csv`"),
        ];
        let lines: Vec<&str> = lines.into_iter().flatten().collect();
        if lines.len() != 1 {
            let found = if lines.is_empty() { "no direction".into() } else { lines.join(" and ") };
            let text = format!("`fibre` has {found}; allowed is one of `direction`, `around`, `along` and `csv`");
            return self.wrong(span, text);
        }
        let place = [
            fibre.box_.as_ref().map(|_| "`box`"),
            fibre.ball.as_ref().map(|_| "`ball`"),
            fibre.radius.as_ref().map(|_| "`radius`"),
            fibre.group.as_ref().map(|_| "`group`"),
        ];
        let place: Vec<&str> = place.into_iter().flatten().collect();
        if !matches!(place[..], [] | ["`box`"] | ["`ball`", "`radius`"] | ["`group`"]) {
            let text = format!(
                "`fibre` has {}; allowed is no place, `box`, `ball` and `radius`, or `group`",
                place.join(" and ")
            );
            return self.wrong(span, text);
        }
        self.place(fibre.box_.as_ref(), fibre.radius.as_ref(), span)
    }
}

/// Whether an entry is for a part of the body alone.
fn has_place(fibre: &FibreScene) -> bool {
    fibre.box_.is_some() || fibre.ball.is_some() || fibre.group.is_some()
}
