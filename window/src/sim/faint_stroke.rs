//! Strokes of a pressure under which the surface hardly gave way, so that nothing is seen of them.

use pliant_engine::session::ToolFrame;

/// Share of the tool's radius by which the surface has to move for a stroke to be seen: three pixels of a model that fills a window.
const VISIBLE: f64 = 0.1;
/// Unit of the strength of strokes that are watched: others move the surface by themselves.
const UNIT: &str = "Pa";

/// Watches the strokes of a tool.
#[derive(Default)]
pub(super) struct FaintStroke {
    /// Largest displacement of the surface in the stroke under way, m; `None` where there is none that has met a body.
    most: Option<f64>,
}

impl FaintStroke {
    /// Takes in the tool, of this radius (m), at the end of a step. Gives whether a stroke has ended that moved the surface too little to be seen.
    pub(super) fn update(&mut self, tool: &ToolFrame, radius: f64) -> bool {
        let presses = tool.edit.and_then(|kind| kind.strength()).is_some_and(|strength| strength.unit == UNIT);
        if presses {
            if tool.contact.is_some() {
                self.most = Some(self.most.unwrap_or(0.0).max(tool.depth));
            }
            return false;
        }
        self.most.take().is_some_and(|most| most < VISIBLE * radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_engine::edit::KINDS;

    #[test]
    fn a_stroke_is_faint_if_the_surface_hardly_moved_at_any_time() {
        let tool = |name: &str, contact, depth| {
            let edit = KINDS.iter().copied().find(|kind| kind.name() == name);
            ToolFrame { edit, contact, depth, ..ToolFrame::default() }
        };
        let faint = |name: &str, steps: &[(Option<u32>, f64)]| {
            let mut stroke = FaintStroke::default();
            let under_way = steps.iter().any(|(contact, depth)| stroke.update(&tool(name, *contact, *depth), 1.0));
            assert!(!under_way, "it has not ended");
            let ended = stroke.update(&tool("", None, 0.0), 1.0);
            assert!(!stroke.update(&tool("", None, 0.0), 1.0), "it ends once");
            ended
        };
        assert!(faint("inflate", &[(None, 0.0), (Some(0), 0.01), (Some(0), 0.05)]));
        assert!(faint("deflate", &[(Some(0), 0.01)]));
        assert!(!faint("inflate", &[(Some(0), 0.2), (Some(0), 0.01)]), "it was seen");
        assert!(!faint("inflate", &[(None, 0.0)]), "it has met nothing, which is another message");
        assert!(!faint("touch", &[(Some(0), 0.01)]), "it goes as deep as it is pressed");
    }
}
