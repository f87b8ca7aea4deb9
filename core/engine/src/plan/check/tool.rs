//! Checks of the devices and tools of a scene.

use super::Check;
use crate::scene::{BladeScene, DeviceScene, SceneError, SheetContact, ToolScene};
use toml::Spanned;

impl Check<'_> {
    pub(super) fn device(&self, device: &DeviceScene) -> Result<(), SceneError> {
        match (&device.recording, &device.recorded) {
            (None, Some(recorded)) => {
                self.wrong(recorded.span(), "`recorded` names a device of a `recording`, and there is none")
            }
            (Some(recording), _) if device.plugin.span() != (0..0) || !device.params.is_empty() => {
                let text = "`recording` and a plugin with `params`; allowed is one of them";
                self.wrong(recording.span(), text)
            }
            _ => Ok(()),
        }
    }

    pub(super) fn tool(&self, tool: &ToolScene) -> Result<(), SceneError> {
        if let Some(radius) = &tool.radius {
            self.above(radius.get_ref().si, radius.span(), "radius", " m")?;
        }
        self.above(tool.speed.get_ref().si, tool.speed.span(), "speed", " m/s")?;
        self.above(tool.slew.get_ref().si, tool.slew.span(), "slew", " N/s")?;
        if let Some(mass) = &tool.mass {
            self.above(mass.get_ref().si, mass.span(), "mass", " kg")?;
        }
        if let Some(k) = &tool.stiffness {
            self.above(k.get_ref().si, k.span(), "stiffness", " N/m")?;
        }
        if let Some(b) = tool.damping.as_ref().filter(|b| b.get_ref().si < 0.0) {
            let text = format!("damping is {} N s/m; allowed is 0 or more", b.get_ref().si);
            return self.wrong(b.span(), text);
        }
        if let Some(blade) = &tool.blade {
            self.blade(blade.get_ref())?;
        }
        self.friction(&tool.friction)?;
        self.restitution(tool.restitution.as_ref())?;
        self.contact_law(tool)
    }

    /// Checks that keys that a contact law takes the place of are not given beside one.
    fn contact_law(&self, tool: &ToolScene) -> Result<(), SceneError> {
        let Some(law) = &tool.contact_law else { return Ok(()) };
        let law = law.get_ref().plugin.get_ref();
        let friction = Some(tool.friction.span()).filter(|span| *span != (0..0));
        let replaced = [("friction", friction), ("restitution", tool.restitution.as_ref().map(Spanned::span))];
        if let Some((key, Some(span))) = replaced.into_iter().find(|(_, span)| span.is_some()) {
            let text =
                format!("`{key}` of a tool with the contact law `{law}`, which has its own; allowed is one of them");
            return self.wrong(span, text);
        }
        match tool.sheets.as_ref().filter(|sheets| *sheets.get_ref() != SheetContact::Penalty) {
            Some(sheets) => {
                let text = format!(
                    "`sheets` of a tool with the contact law `{law}`; allowed is \"penalty\", or no `sheets`: a law gives forces, and the other methods \
                     are constraints and multipliers"
                );
                self.wrong(sheets.span(), text)
            }
            None => Ok(()),
        }
    }

    fn blade(&self, blade: &BladeScene) -> Result<(), SceneError> {
        self.above(blade.length.get_ref().si, blade.length.span(), "length of the blade", " m")?;
        for (value, span, what) in [
            (blade.toughness.get_ref().si, blade.toughness.span(), "toughness is {} J/m^2"),
            (blade.tear.get_ref().si, blade.tear.span(), "tear is {} N"),
        ] {
            if value < 0.0 {
                let text = format!("{}; allowed is 0 or more", what.replace("{}", &value.to_string()));
                return self.wrong(span, text);
            }
        }
        let direction = blade.direction.get_ref();
        if !(direction.iter().all(|c| c.is_finite()) && direction.iter().any(|c| *c != 0.0)) {
            let text = format!("direction of the blade is {direction:?}; allowed is finite numbers, not all 0");
            return self.wrong(blade.direction.span(), text);
        }
        let material = blade.material.get_ref();
        if material.is_empty() || material.contains(|c: char| c.is_whitespace() || c.is_control()) {
            return self
                .wrong(blade.material.span(), format!("material {material:?}; allowed is a name without spaces"));
        }
        Ok(())
    }
}
