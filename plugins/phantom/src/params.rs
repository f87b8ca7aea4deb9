//! What a scene may say of an arm, and what it needs.

use crate::driver;
use pliant_plugin_api::{Fault, Finding, Param, Params};
use std::path::{Path, PathBuf};

pub(crate) const PARAMS: &[Param] = &[
    Param::text(c"arm", c"the driver's name of the arm; its default when not given"),
    Param::text(c"second-arm", c"the driver's name of another arm, effector 1"),
    Param::path(c"library", c"the driver library; the system's libHD when not given"),
    Param::number(c"rate", c"Hz", (100.0, 4000.0), 1000.0, c"of the servo loop, if the driver has it"),
    Param::number(c"patience", c"s", (0.0, 120.0), 5.0, c"how long calibration may take, and the inkwell"),
    Param::number(c"lost-after", c"s", (0.05, 60.0), 5.0, c"without a pose after which it is lost for good"),
    Param::number(c"peak-force", c"N", (1e-3, 100.0), 3.3, c"of an arm, if it can"),
    Param::number(c"resolution", c"m", (0.0, 0.01), 5.5e-5, c"position quantum"),
    Param::choice(c"inkwell", c"rests|works", c"whether a stylus in its inkwell is left without force"),
];

#[derive(Clone)]
pub(crate) struct Settings {
    pub arm: String,
    pub second: Option<String>,
    pub library: PathBuf,
    pub rate: f64,
    pub patience: f64,
    pub lost_after: f64,
    pub peak_force: f64,
    pub resolution: f64,
    pub rests: bool,
}

/// As the system's linker finds it.
const LIBRARY: &str = if cfg!(windows) {
    "HD.dll"
} else if cfg!(target_os = "macos") {
    "libHD.dylib"
} else {
    "libHD.so"
};

const INSTALL: &str = "install the vendor's device driver and OpenHaptics, or give `library`";

impl Settings {
    pub(crate) fn read(params: &Params<'_>) -> Result<Self, Fault> {
        let text = |key: &str| params.text(key).map(str::to_owned);
        let (arm, second) = (text("arm").unwrap_or_default(), text("second-arm"));
        if second.as_ref().is_some_and(|second| *second == arm || arm.is_empty()) {
            let text = "`second-arm` needs an `arm` of another name; both are names of the vendor's set-up";
            return Err(Fault::bad_argument(text));
        }
        Ok(Self {
            arm,
            second,
            library: text("library").map_or_else(|| LIBRARY.into(), PathBuf::from),
            rate: params.number("rate"),
            patience: params.number("patience"),
            lost_after: params.number("lost-after"),
            peak_force: params.number("peak-force"),
            resolution: params.number("resolution"),
            rests: params.choice("inkwell") == 0,
        })
    }
}

pub(crate) fn probe(params: &Params<'_>) -> Vec<Finding> {
    let settings = match Settings::read(params) {
        Ok(settings) => Settings { patience: params.number("patience").min(1.0), ..settings },
        Err(fault) => return vec![Finding::missing("parameters", fault.reason, "correct them")],
    };
    let mut findings = Vec::new();
    if let Err(text) = crate::hd::Api::load(&settings.library) {
        findings.push(Finding::missing("driver library", text, INSTALL));
        return findings;
    }
    findings.push(Finding::present("driver library", settings.library.display().to_string()));
    if std::env::var_os("GTDD_HOME").is_some_and(|home| !Path::new(&home).is_dir()) {
        let text = "GTDD_HOME names a folder that is not there";
        findings.push(Finding::missing("configuration", text, "correct it, or run the vendor's set-up"));
    }
    findings.push(match driver::look(&settings) {
        Ok(found) => Finding::present("arm", found),
        Err(text) => Finding::missing("arm", text, "plug it in, switch it on, and run the vendor's set-up"),
    });
    findings
}
