//! Refinement series of a scene.

use pliant_engine::scene::{IntegratorChoice, Scene};
use pliant_engine::session::Session;
use pliant_solver::Scheme;

/// Path of the step size in a scene.
pub(super) const STEP: &str = "time.dt";
/// Path of the linear solver's tolerance in a scene.
pub(super) const TOLERANCE: &str = "solver.tolerance";
/// Path of the grid level of the first body in a scene.
pub(super) const LEVEL: &str = "body.0.grid.level";

/// Relative residuals of the linear solver in a refinement series; the last is the reference.
const TOLERANCES: [f64; 6] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-10];
/// Schemes whose steps a full report refines, whichever the scene has.
const COMMON_SCHEMES: [Scheme; 3] = [Scheme::SymplecticEuler, Scheme::BackwardEuler, Scheme::Bdf2];

/// Runs that differ in one refined setting.
pub(super) struct RefinementSeries {
    /// Name, for rows: integrator and what is refined.
    pub(super) name: String,
    /// Name and unit of the refined quantity.
    pub(super) axis: &'static str,
    /// Settings of all of its runs.
    pub(super) settings: Vec<(String, String)>,
    /// Path of the refined setting: [`STEP`], [`TOLERANCE`] or [`LEVEL`].
    pub(super) path: &'static str,
    /// Values from coarse to fine. The last is the reference.
    pub(super) values: Vec<f64>,
    /// The value that the scene itself has; `None` in a series of another integrator.
    pub(super) own: Option<f64>,
}

/// The series of a scene: the step of each integrator, the tolerance of the solver if there is one, and the level of the first body's
/// grid if it has one.
pub(super) fn refinement_series(scene: &Scene, session: &Session, quick: bool) -> Vec<RefinementSeries> {
    let mut all = step_series(scene, session, quick);
    let own = session.choices.integrator;
    if Scheme::from_name(own).is_none_or(Scheme::is_implicit) {
        let tolerance = *scene.solver.tolerance.get_ref();
        all.push(RefinementSeries {
            name: format!("{own}, solver"),
            axis: "relative residual of the solver (1)",
            settings: vec![],
            path: TOLERANCE,
            values: tolerances_with(tolerance),
            own: Some(tolerance),
        });
    }
    let lattice = session.bodies.first().and_then(|body| body.discretization.lattice());
    if let Some(lattice) = lattice.filter(|lattice| lattice.settings.level > 3) {
        let level = f64::from(lattice.settings.level);
        // A radius in cells would shrink with them: all levels get the radius of the scene's own, m.
        let radius = session.bodies.first().map(|b| b.discretization.radius()).filter(|r| r.is_finite());
        let settings = radius.map(|r| ("body.0.grid.radius".to_owned(), r.to_string())).into_iter().collect();
        let coarser = if quick { &[1.0][..] } else { &[2.0, 1.0] };
        let values = coarser.iter().map(|below| level - below).chain([level, level + 1.0]).collect();
        let (name, axis) = (format!("{own}, grid"), "level of the grid (1)");
        all.push(RefinementSeries { name, axis, settings, path: LEVEL, values, own: Some(level) });
    }
    all
}

/// [`TOLERANCES`], with the scene's own among them if it is coarser than the reference.
fn tolerances_with(own: f64) -> Vec<f64> {
    let [.., finest] = TOLERANCES;
    let mut all = TOLERANCES.to_vec();
    if own > finest && !all.contains(&own) {
        all.push(own);
        all.sort_by(|a, b| b.total_cmp(a));
    }
    all
}

/// A series over the step for the scene's own integrator and, in a full report, for the other common ones.
fn step_series(scene: &Scene, session: &Session, quick: bool) -> Vec<RefinementSeries> {
    let (dt, own) = (scene.time.dt.get_ref().si, session.choices.integrator);
    let factors = if quick { &[4.0, 2.0, 1.0, 0.25][..] } else { &[8.0, 4.0, 2.0, 1.0, 0.5, 0.125] };
    let values: Vec<f64> = factors.iter().map(|f| f * dt).collect();
    let series = |name: String, settings, is_own: bool| RefinementSeries {
        name,
        axis: "step (s)",
        settings,
        path: STEP,
        values: values.clone(),
        own: is_own.then_some(dt),
    };
    if Scheme::from_name(own).is_some_and(|scheme| !scheme.has_inertia()) {
        return vec![series(own.into(), vec![], true)];
    }
    let integrators = COMMON_SCHEMES.map(Scheme::name).into_iter().filter(|name| *name == own || !quick);
    let of = |name: &str| {
        let chosen = scene.time.integrator == IntegratorChoice::Auto && name == own;
        let name_in_rows = if chosen { format!("{name}, chosen") } else { name.to_owned() };
        series(name_in_rows, vec![("time.integrator".into(), name.into())], name == own)
    };
    integrators.map(of).collect()
}
