//! One run of a stability map.

use super::catalogue::{MapPoint, StabilityMap};
use super::graded_mesh::graded_mesh_path;
use super::task::{Inputs, is_explicit, scene_run};
use crate::context::ReportContext;
use crate::scene_run::SceneRun;
use crate::settings::{Setting, merge, setting};

/// A point of a map.
#[derive(Clone, Copy)]
pub(super) struct MapRun<'a> {
    pub(super) inputs: Inputs<'a>,
    pub(super) map: &'a StabilityMap,
    pub(super) point: &'a MapPoint,
}

impl<'a> MapRun<'a> {
    /// The run of so many steps of `dt` (s); `None` where the map's scene does not exist. Explicit integrators are forced beyond their
    /// step limit.
    pub(super) fn scene_run<'r>(
        &self,
        integrator: &str,
        dt: f64,
        step_count: u32,
        context: &'r ReportContext<'_>,
    ) -> Option<SceneRun<'r>>
    where
        'a: 'r,
    {
        let settings = self.settings(integrator, dt, step_count);
        scene_run(self.inputs.scenes, &self.map.scene, settings, context)
    }

    /// The settings of a run.
    fn settings(&self, integrator: &str, dt: f64, step_count: u32) -> Vec<Setting> {
        let mut all = merge([&self.point.settings]);
        if self.map.graded {
            let path = graded_mesh_path(self.inputs.mesh_folder, self.point.value);
            all.push(setting("body.0.mesh", path.display()));
        }
        all.extend([
            setting("time.integrator", integrator),
            setting("time.dt", dt),
            setting("time.duration", dt * f64::from(step_count)),
            setting("time.substeps", 1),
            setting("time.force-unstable", is_explicit(integrator)),
        ]);
        all
    }
}
