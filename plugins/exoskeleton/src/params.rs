//! What a scene may say of an exoskeleton, and what it needs.

use crate::key::Key;
use crate::link::{DEFAULT_PEER, Link};
use crate::wire::{EFFECTORS, Layout, MOST_TAXELS};
use pliant_plugin_api::abi::DeviceInfo;
use pliant_plugin_api::{Fault, Finding, Param, Params};
use std::net::{SocketAddr, ToSocketAddrs};
use std::time::Duration;

pub(crate) const PARAMS: &[Param] = &[
    Param::text(c"peer", c"address and port of the device; 127.0.0.1:48620 when not given"),
    Param::path(c"key", c"a file with 32 hexadecimal digits the device knows too"),
    Param::number(c"patience", c"s", (0.0, 60.0), 1.0, c"how long it may take to answer at first"),
    Param::number(c"lost-after", c"s", (0.05, 60.0), 2.0, c"silence after which it is lost for good"),
    Param::number(c"rate", c"Hz", (10.0, 4000.0), 1000.0, c"how often it is read and written"),
    Param::number(c"peak-force", c"N", (1e-3, 100.0), 5.0, c"on a fingertip, assumed"),
    Param::number(c"continuous-force", c"N", (1e-3, 100.0), 2.5, c"on a fingertip, assumed"),
    Param::number(c"stiffness", c"N/m", (1.0, 1e5), 400.0, c"the most it renders stably, assumed"),
    Param::number(c"damping", c"N*s/m", (0.0, 1e3), 2.0, c"the most it renders stably, assumed"),
    Param::number(c"resolution", c"m", (0.0, 0.01), 5e-5, c"position quantum, assumed"),
    Param::number(c"reach", c"m", (0.01, 2.0), 0.3, c"half an edge of its workspace, assumed"),
    Param::number(c"taxel-rows", c"1", (0.0, 40.0), 5.0, c"of each array, along the finger"),
    Param::number(c"taxel-columns", c"1", (0.0, 40.0), 6.0, c"of each array, across the finger"),
    Param::number(c"taxel-pitch", c"m", (1e-4, 0.05), 2.5e-3, c"between two pins, assumed"),
    Param::number(c"taxel-force", c"N", (1e-4, 10.0), 0.073, c"most of one pin"),
];

pub(crate) const REMEDY: &str = "switch it on, or start a twin: pliant device emulate exoskeleton";

pub(crate) struct Settings {
    pub peer: SocketAddr,
    pub key: Option<String>,
    pub layout: Layout,
    pub patience: f64,
    pub lost_after: f64,
    pub facts: DeviceInfo,
}

impl Settings {
    pub(crate) fn read(params: &Params<'_>) -> Result<Self, Fault> {
        let whole = |key: &str| {
            let value = params.number(key);
            let text = || Fault::bad_argument(format!("`{key}` is {value}; allowed is a whole number"));
            if value.fract() == 0.0 { Ok(value as u8) } else { Err(text()) }
        };
        let layout = Layout { rows: whole("taxel-rows")?, columns: whole("taxel-columns")? };
        if layout.taxels() > MOST_TAXELS {
            let text = format!("`taxel-rows` x `taxel-columns` is {}; allowed is up to {MOST_TAXELS}", layout.taxels());
            return Err(Fault::bad_argument(text));
        }
        let given = params.text("peer").unwrap_or(DEFAULT_PEER);
        let found = given.to_socket_addrs().ok().and_then(|mut all| all.next());
        let wrong = || Fault::bad_argument(format!("`peer` is `{given}`; allowed is ADDRESS:PORT, as {DEFAULT_PEER}"));
        let (peak, continuous) = (params.number("peak-force"), params.number("continuous-force"));
        if continuous > peak {
            return Err(Fault::bad_argument(format!(
                "`continuous-force` is {continuous} N, above `peak-force`, {peak} N"
            )));
        }
        let reach = params.number("reach");
        Ok(Self {
            peer: found.ok_or_else(wrong)?,
            key: params.text("key").map(str::to_owned),
            layout,
            patience: params.number("patience"),
            lost_after: params.number("lost-after"),
            facts: DeviceInfo {
                size: size_of::<DeviceInfo>(),
                effectors: EFFECTORS as u32,
                buttons: 0,
                driven_axes: 3,
                taxel_rows: u32::from(layout.rows),
                taxel_columns: u32::from(layout.columns),
                rate: params.number("rate"),
                peak_force: peak,
                continuous_force: continuous,
                stiffness: params.number("stiffness"),
                damping: params.number("damping"),
                resolution: params.number("resolution"),
                workspace: [-reach, -reach, -reach, reach, reach, reach],
                taxel_pitch: params.number("taxel-pitch"),
                taxel_force: params.number("taxel-force"),
            },
        })
    }
}

pub(crate) fn probe(params: &Params<'_>) -> Vec<Finding> {
    let settings = match Settings::read(params) {
        Ok(settings) => settings,
        Err(fault) => return vec![Finding::missing("parameters", fault.reason, "correct them")],
    };
    let mut findings = Vec::new();
    let key = match settings.key.as_deref().map(Key::from_file).transpose() {
        Ok(key) => key,
        Err(reason) => {
            return vec![Finding::missing("key", reason, "write 32 hexadecimal digits into it, on both sides")];
        }
    };
    if key.is_none() && !settings.peer.ip().is_loopback() {
        let text = format!("{} is on a network and there is no key", settings.peer);
        findings.push(Finding::degraded("key", text, "give `key`, or anyone there can move the hand"));
    }
    let met = Link::new(settings.peer, settings.layout, key)
        .map_err(|e| e.to_string())
        .and_then(|link| link.meet(Duration::from_secs_f64(settings.patience)).map(|()| link));
    findings.push(match met {
        Ok(link) => {
            link.send(&Default::default(), 0, crate::link::Say::Goodbye);
            Finding::present("device", format!("answers at {}", settings.peer))
        }
        Err(text) => Finding::missing("device", text, REMEDY),
    });
    findings
}
