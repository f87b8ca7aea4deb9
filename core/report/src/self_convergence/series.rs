//! Refinement series of a scene.

use super::front::{Front, Settings};
use pliant_engine::scene::{IntegratorChoice, Scene};
use pliant_engine::session::Session;
use pliant_solver::Scheme;

/// Path of the step size in a scene.
pub(super) const STEP: &str = "time.dt";
/// Path of the integrator in a scene.
pub(super) const INTEGRATOR: &str = "time.integrator";
/// Path of the linear solver's tolerance in a scene.
pub(super) const TOLERANCE: &str = "solver.tolerance";
/// Path of the grid level of the first body in a scene.
pub(super) const LEVEL: &str = "body.0.grid.level";

/// Relative residuals of the linear solver in a refinement series.
const TOLERANCES: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6];
/// Relative residual of the linear solver of the reference.
const REFERENCE_TOLERANCE: f64 = 1e-10;
/// Schemes whose steps a full report refines, whichever the scene has.
const COMMON_SCHEMES: [Scheme; 3] = [Scheme::SymplecticEuler, Scheme::BackwardEuler, Scheme::Bdf2];
/// Scheme of the reference of a scene with inertia: of second order in positions and velocities, and stable at any step.
const REFERENCE_SCHEME: Scheme = Scheme::Bdf2;

/// Steps of a series over the scene's step, from coarse to fine.
const STEP_FACTORS: [f64; 5] = [8.0, 4.0, 2.0, 1.0, 0.5];
/// Step of the reference over the scene's step.
const REFERENCE_STEP: f64 = 0.125;
/// The same of a quick report.
const QUICK_STEP_FACTORS: [f64; 3] = [4.0, 2.0, 1.0];
const QUICK_REFERENCE_STEP: f64 = 0.25;

/// Runs that differ in one refined setting.
pub(super) struct RefinementSeries {
    /// Name, for rows: integrator and what is refined.
    pub(super) name: String,
    /// Name and unit of the refined quantity.
    pub(super) axis: &'static str,
    /// Settings of all of its runs.
    pub(super) settings: Settings,
    /// Path of the refined setting: [`STEP`], [`TOLERANCE`] or [`LEVEL`].
    pub(super) path: &'static str,
    /// Values from coarse to fine, all of them coarser than that of the front's reference.
    pub(super) values: Vec<f64>,
    /// The value that the scene itself has; `None` in a series of another integrator.
    pub(super) own: Option<f64>,
}

/// The fronts of a scene: the step of each integrator and the tolerance of the solver if there is one, which compute the motion of the scene's own grid; and
/// the level of the first body's grid if it has one.
pub(super) fn fronts(scene: &Scene, session: &Session, quick: bool) -> Vec<Front> {
    let mut all = vec![own_grid(scene, session, quick)];
    all.extend(levels(scene, session, quick));
    all
}

/// Runs on the scene's own grid.
fn own_grid(scene: &Scene, session: &Session, quick: bool) -> Front {
    let mut series = step_series(scene, session, quick);
    let (dt, own) = (scene.time.dt.get_ref().si, session.choices.integrator);
    if Scheme::from_name(own).is_none_or(Scheme::is_implicit) {
        let tolerance = *scene.solver.tolerance.get_ref();
        series.push(RefinementSeries {
            name: format!("{own}, solver"),
            axis: "relative residual of the solver (1)",
            settings: vec![],
            path: TOLERANCE,
            values: tolerances_with(tolerance),
            own: Some(tolerance),
        });
    }
    let (coarsest, finest) =
        if quick { (QUICK_STEP_FACTORS[0], QUICK_REFERENCE_STEP) } else { (STEP_FACTORS[0], REFERENCE_STEP) };
    // The scene's own integrator takes over where the reference's does not open or converge.
    let has_inertia = Scheme::from_name(own).is_none_or(Scheme::has_inertia);
    let integrators = has_inertia.then_some(REFERENCE_SCHEME.name()).into_iter().chain([own]);
    let reference = |integrator: &str| -> Settings {
        let mut settings = vec![(STEP.to_owned(), (finest * dt).to_string())];
        if has_inertia {
            settings.insert(0, (INTEGRATOR.to_owned(), integrator.to_owned()));
        }
        if Scheme::from_name(integrator).is_none_or(Scheme::is_implicit) {
            settings
                .push((TOLERANCE.to_owned(), REFERENCE_TOLERANCE.min(*scene.solver.tolerance.get_ref()).to_string()));
        }
        settings
    };
    let mut references: Vec<Settings> = integrators.map(reference).collect();
    references.dedup();
    Front {
        name: "",
        why: "All of these runs compute the same motion, that of the scene's own grid, so one run is the reference of all of them: the integrator of the highest \
              order with the finest step and the smallest residual of the solver. Runs of other integrators are not exact at their finest step: what \
              is left there is their error.",
        references,
        // The runs have the multiples of the coarsest step in common.
        sample_period: coarsest * dt,
        series,
    }
}

/// Runs on grids of other levels.
fn levels(scene: &Scene, session: &Session, quick: bool) -> Option<Front> {
    let lattice = session.bodies.first().and_then(|body| body.discretization.lattice());
    let level = lattice.map(|lattice| f64::from(lattice.settings.level)).filter(|level| *level > 3.0)?;
    // A radius in cells would shrink with them: all levels get the radius of the scene's own, m.
    let radius = session.bodies.first().map(|b| b.discretization.radius()).filter(|r| r.is_finite());
    let settings: Settings = radius.map(|r| ("body.0.grid.radius".to_owned(), r.to_string())).into_iter().collect();
    let coarser = if quick { &[1.0][..] } else { &[2.0, 1.0] };
    let finest = [settings.clone(), vec![(LEVEL.to_owned(), (level + 1.0).to_string())]].concat();
    let series = RefinementSeries {
        name: format!("{}, grid", session.choices.integrator),
        axis: "level of the grid (1)",
        settings,
        path: LEVEL,
        values: coarser.iter().map(|below| level - below).chain([level]).collect(),
        own: Some(level),
    };
    Some(Front {
        name: ", other grids",
        why: "Grids of other levels are other discrete bodies, whose motion tends to that of the continuum. They have the scene's own step, and the finest of them \
              is the reference. These errors are not those of the step and the solver, and add to them.",
        references: vec![finest],
        sample_period: scene.time.dt.get_ref().si,
        series: vec![series],
    })
}

/// [`TOLERANCES`], with the scene's own among them if it is coarser than the reference.
fn tolerances_with(own: f64) -> Vec<f64> {
    let mut all = TOLERANCES.to_vec();
    if own > REFERENCE_TOLERANCE && !all.contains(&own) {
        all.push(own);
        all.sort_by(|a, b| b.total_cmp(a));
    }
    all
}

/// A series over the step for the scene's own integrator and, in a full report, for the other common ones.
fn step_series(scene: &Scene, session: &Session, quick: bool) -> Vec<RefinementSeries> {
    let (dt, own) = (scene.time.dt.get_ref().si, session.choices.integrator);
    let factors = if quick { &QUICK_STEP_FACTORS[..] } else { &STEP_FACTORS };
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
        series(name_in_rows, vec![(INTEGRATOR.into(), name.into())], name == own)
    };
    integrators.map(of).collect()
}
