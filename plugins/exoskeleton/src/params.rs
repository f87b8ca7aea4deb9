//! The parameters of the device in a scene, and the checks of `pliant device doctor`.

use crate::key::{Key, require_key};
use crate::link::{CommandKind, DEFAULT_PEER, Link};
use crate::wire::{EFFECTOR_COUNT, MAX_TAXELS, TaxelLayout};
use pliant_plugin_api::abi::DeviceInfo;
use pliant_plugin_api::{Fault, Finding, Param, Params};
use std::net::{SocketAddr, ToSocketAddrs};
use std::time::Duration;

pub(crate) const PARAMS: &[Param] = &[
    Param::text(c"peer", c"address and port of the device; 127.0.0.1:48620 when not given"),
    Param::path(
        c"key",
        c"a file with 32 hexadecimal digits that the device knows too, for its owner alone; not needed on loopback",
    ),
    Param::number(c"patience", c"s", 0.0..=60.0, 1.0, c"how long it may take to answer when opened"),
    Param::number(c"lost-after", c"s", 0.05..=60.0, 2.0, c"silence after which it counts as lost"),
    Param::number(c"rate", c"Hz", 10.0..=4000.0, 1000.0, c"how often it is read and written"),
    Param::number(c"peak-force", c"N", 1e-3..=100.0, 5.0, c"largest force on a fingertip, assumed"),
    Param::number(c"continuous-force", c"N", 1e-3..=100.0, 2.5, c"largest lasting force on a fingertip, assumed"),
    Param::number(c"stiffness", c"N/m", 1.0..=1e5, 400.0, c"largest stiffness it renders stably, assumed"),
    Param::number(c"damping", c"N*s/m", 0.0..=1e3, 2.0, c"largest damping it renders stably, assumed"),
    Param::number(c"resolution", c"m", 0.0..=0.01, 5e-5, c"smallest position step it senses, assumed"),
    Param::number(c"reach", c"m", 0.01..=2.0, 0.3, c"half the edge length of its cubic workspace, assumed"),
    Param::number(c"taxel-rows", c"1", 0.0..=40.0, 5.0, c"taxels of each array along the finger"),
    Param::number(c"taxel-columns", c"1", 0.0..=40.0, 6.0, c"taxels of each array across the finger"),
    Param::number(c"taxel-pitch", c"m", 1e-4..=0.05, 2.5e-3, c"distance of two neighbouring pins, assumed"),
    Param::number(c"taxel-force", c"N", 1e-4..=10.0, 0.073, c"largest force of one pin"),
];

/// What to do if the device does not answer; ends a message.
pub(crate) const NO_ANSWER_REMEDY: &str = "switch it on, or start a twin: pliant device emulate exoskeleton";

/// The parameters, checked.
pub(crate) struct Settings {
    /// Address of the device.
    pub peer: SocketAddr,
    /// Path of the key file.
    pub key: Option<String>,
    /// Size of the tactile arrays.
    pub layout: TaxelLayout,
    /// Largest time to the first answer when the device is opened.
    pub connect_timeout: Duration,
    /// Silence after which the device counts as lost.
    pub silence_limit: Duration,
    /// Limits of the device.
    pub info: DeviceInfo,
}

impl Settings {
    /// Reads and checks the parameters.
    ///
    /// # Errors
    /// The first value that is not allowed.
    pub(crate) fn read(params: &Params<'_>) -> Result<Self, Fault> {
        let whole_number = |key: &str| {
            let value = params.number(key);
            let fault = || Fault::bad_argument(format!("`{key}` is {value}; allowed is a whole number"));
            if value.fract() == 0.0 { Ok(value as u8) } else { Err(fault()) }
        };
        let layout = TaxelLayout { rows: whole_number("taxel-rows")?, columns: whole_number("taxel-columns")? };
        if layout.taxel_count() > MAX_TAXELS {
            return Err(Fault::bad_argument(format!(
                "`taxel-rows` x `taxel-columns` is {}; allowed is up to {MAX_TAXELS}",
                layout.taxel_count()
            )));
        }
        let address = params.text("peer").unwrap_or(DEFAULT_PEER);
        let peer = address.to_socket_addrs().ok().and_then(|mut all| all.next()).ok_or_else(|| {
            Fault::bad_argument(format!("`peer` is `{address}`; allowed is ADDRESS:PORT, as in {DEFAULT_PEER}"))
        })?;
        let (peak_force, continuous_force) = (params.number("peak-force"), params.number("continuous-force"));
        if continuous_force > peak_force {
            return Err(Fault::bad_argument(format!(
                "`continuous-force` is {continuous_force} N; allowed is up to `peak-force`, {peak_force} N"
            )));
        }
        let reach = params.number("reach");
        Ok(Self {
            peer,
            key: params.text("key").map(str::to_owned),
            layout,
            connect_timeout: Duration::from_secs_f64(params.number("patience")),
            silence_limit: Duration::from_secs_f64(params.number("lost-after")),
            info: DeviceInfo {
                size: size_of::<DeviceInfo>(),
                effectors: EFFECTOR_COUNT as u32,
                buttons: 0,
                driven_axes: 3,
                taxel_rows: u32::from(layout.rows),
                taxel_columns: u32::from(layout.columns),
                rate: params.number("rate"),
                peak_force,
                continuous_force,
                stiffness: params.number("stiffness"),
                damping: params.number("damping"),
                resolution: params.number("resolution"),
                workspace: [-reach, -reach, -reach, reach, reach, reach],
                taxel_pitch: params.number("taxel-pitch"),
                taxel_force: params.number("taxel-force"),
                peak_torque: 0.0,
            },
        })
    }
}

/// Checks parameters, key and device, in this order; stops at the first parameter or key that cannot be used.
pub(crate) fn probe(params: &Params<'_>) -> Vec<Finding> {
    let settings = match Settings::read(params) {
        Ok(settings) => settings,
        Err(fault) => return vec![Finding::missing("parameters", fault.reason, "correct them")],
    };
    let key = match settings.key.as_deref().map(Key::from_file).transpose() {
        Ok(key) => key,
        Err(reason) => {
            return vec![Finding::missing(
                "key",
                reason,
                "write 32 hexadecimal digits into it, on both sides, and let nobody else read it",
            )];
        }
    };
    if let Err(reason) = require_key(settings.peer.ip(), key.as_ref()) {
        return vec![Finding::missing(
            "key",
            reason,
            "give `key`: without one anyone on the network can move the hand",
        )];
    }
    let connected = Link::new(settings.peer, settings.layout, key)
        .map_err(|e| e.to_string())
        .and_then(|link| link.connect(settings.connect_timeout).map(|()| link));
    vec![match connected {
        Ok(link) => {
            link.send(&Default::default(), 0, CommandKind::Goodbye);
            Finding::present("device", format!("answers at {}", settings.peer))
        }
        Err(text) => Finding::missing("device", text, NO_ANSWER_REMEDY),
    }]
}
