//! The parameters of the arms in a scene, and the checks of `pliant device doctor`.

use crate::setup;
use pliant_plugin_api::{Fault, Finding, Param, Params};
use std::path::{Path, PathBuf};
use std::time::Duration;

pub(crate) const PARAMS: &[Param] = &[
    Param::text(c"arm", c"the driver's name of the arm; its default arm when not given"),
    Param::text(c"second-arm", c"the driver's name of another arm, effector 1"),
    Param::path(c"library", c"the driver library; the system's libHD when not given"),
    Param::number(c"rate", c"Hz", 100.0..=4000.0, 1000.0, c"rate of the servo loop, if the driver has it"),
    Param::number(c"patience", c"s", 0.0..=120.0, 5.0, c"how long the calibration may take, inkwell included"),
    Param::number(c"lost-after", c"s", 0.05..=60.0, 5.0, c"time without a pose after which it counts as lost"),
    Param::number(c"peak-force", c"N", 1e-3..=100.0, 3.3, c"largest force of an arm; the driver's if that is less"),
    Param::number(c"resolution", c"m", 0.0..=0.01, 5.5e-5, c"smallest position step it senses"),
    Param::choice(c"inkwell", c"rests|works", c"whether an arm with its stylus in the inkwell gets no force"),
];

/// The parameters, checked.
#[derive(Clone)]
pub(crate) struct Settings {
    /// The driver's name of the first arm; empty for its default arm.
    pub arm: String,
    /// The driver's name of the second arm.
    pub second_arm: Option<String>,
    /// File name or path of the driver library.
    pub library: PathBuf,
    /// Rate of the servo loop, Hz.
    pub rate: f64,
    /// Largest time of the calibration.
    pub calibration_timeout: Duration,
    /// Time without a pose after which the device counts as lost.
    pub loss_limit: Duration,
    /// Largest force, N.
    pub peak_force: f64,
    /// Smallest step of the position that the device senses, m.
    pub resolution: f64,
    /// Whether the force is zero while the stylus is in the inkwell.
    pub inkwell_disables_force: bool,
}

/// Name of the driver library for the system's search.
const LIBRARY: &str = if cfg!(windows) {
    "HD.dll"
} else if cfg!(target_os = "macos") {
    "libHD.dylib"
} else {
    "libHD.so"
};

impl Settings {
    pub(crate) fn read(params: &Params<'_>) -> Result<Self, Fault> {
        let text = |key: &str| params.text(key).map(str::to_owned);
        let (arm, second_arm) = (text("arm").unwrap_or_default(), text("second-arm"));
        if second_arm.as_ref().is_some_and(|second| *second == arm || arm.is_empty()) {
            let text = "`second-arm` needs an `arm` of another name; both are names of the vendor's set-up";
            return Err(Fault::bad_argument(text));
        }
        Ok(Self {
            arm,
            second_arm,
            library: text("library").map_or_else(|| LIBRARY.into(), PathBuf::from),
            rate: params.number("rate"),
            calibration_timeout: Duration::from_secs_f64(params.number("patience")),
            loss_limit: Duration::from_secs_f64(params.number("lost-after")),
            peak_force: params.number("peak-force"),
            resolution: params.number("resolution"),
            inkwell_disables_force: params.choice("inkwell") == 0,
        })
    }
}

/// Checks parameters, driver library, configuration and the first arm, in this order.
pub(crate) fn probe(params: &Params<'_>) -> Vec<Finding> {
    let mut settings = match Settings::read(params) {
        Ok(settings) => settings,
        Err(fault) => return vec![Finding::missing("parameters", fault.reason, "correct them")],
    };
    settings.calibration_timeout = settings.calibration_timeout.min(Duration::from_secs(1));
    if let Err(text) = crate::hd::Api::load(&settings.library) {
        let remedy = "install the vendor's device driver and OpenHaptics, or give `library`";
        return vec![Finding::missing("driver library", text, remedy)];
    }
    let mut findings = vec![Finding::present("driver library", settings.library.display().to_string())];
    if let Some(home) = std::env::var_os("GTDD_HOME").filter(|home| !Path::new(home).is_dir()) {
        let text = format!("GTDD_HOME names no folder: {}", Path::new(&home).display());
        findings.push(Finding::missing("configuration", text, "correct it, or run the vendor's set-up"));
    }
    findings.push(match setup::probe_arm(&settings) {
        Ok(text) => Finding::present("arm", text),
        Err(text) => Finding::missing("arm", text, "plug it in, switch it on, and run the vendor's set-up"),
    });
    findings
}
