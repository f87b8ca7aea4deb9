//! Arguments of the program.

use crate::opening::OpenRequest;
use pliant_editor::{DeviceRequest, LengthUnit};
use std::path::PathBuf;
use std::time::Instant;

/// How the program is called.
pub const USAGE: &str = "\
usage: pliant edit [MODEL.obj | SCENE.toml] [options]

  --plugin-path DIR    folder with plugins that is searched first; may be given more than once
  --allow-plugins DIR  folder from which scenes may name libraries by path, which runs their code; may be given more than once
  --threads N          threads of the simulation; 0 uses all processors
  --unit UNIT          length of a unit of the file: m, cm, mm or in; guessed from the size by default
  --level N            level of the grid in a solid: 2^(N - 1) cells along its longest edge; 6 by default
  --subdivide          divide large faces of a model until a touch shows; the saved model has the divided faces
  --device NAME        device that has the hand in the place of the pointer, as `pliant device list` names it
  --device-set K=V     parameter of the device, as library=libHD.so; may be given more than once
  --antialias N        samples of a pixel: 0, 2, 4 or 8; 4 by default, 0 is faster without a graphics card
  --autosave DIR       where shapes are kept after each stroke; by default with the user's other state
  --log FILE           write what happens in the window, a line of JSON for each event
  --measure SECONDS    press and stroke the model for that long, print the times of the loops as JSON, and end
  --without-window     with --measure: the same strokes without a window, to compare with
  --timings            print on the standard error how long the start took, and how soon the picture shows what the pointer does
  --renderer           print which renderer of OpenGL a window gets here, and end
  --help               print this";

/// What the program is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Arguments {
    /// Model or scene to open.
    pub path: Option<PathBuf>,
    /// Folders with plugins.
    pub plugin_path: Vec<PathBuf>,
    /// Folders from which scenes may name libraries by path.
    pub allow_plugins: Vec<PathBuf>,
    /// Threads of the simulation; 0 for all processors.
    pub threads: usize,
    /// Unit of the model; `None`: guess it.
    pub unit: Option<LengthUnit>,
    /// Level of the grid.
    pub level: u32,
    /// Whether large faces of a model are divided.
    pub subdivide: bool,
    /// Device that has the hand.
    pub device: Option<DeviceRequest>,
    /// Samples of a pixel.
    pub antialias: u16,
    /// Where shapes are kept after each stroke; `None`: with the user's other state.
    pub autosave: Option<PathBuf>,
    /// Where events are written.
    pub log: Option<PathBuf>,
    /// s, how long to measure
    pub measure: Option<f64>,
    /// Whether to measure without a window.
    pub without_window: bool,
    /// Whether times of the start and of strokes are printed.
    pub timings: bool,
    /// Whether to say which renderer a window would get, and open none.
    pub renderer: bool,
    /// When the program began.
    pub began: Instant,
    /// Whether help was asked for.
    pub help: bool,
}

impl Default for Arguments {
    fn default() -> Self {
        Self {
            path: None,
            plugin_path: Vec::new(),
            allow_plugins: Vec::new(),
            threads: 0,
            unit: None,
            level: 6,
            subdivide: false,
            device: None,
            antialias: 4,
            autosave: None,
            log: None,
            measure: None,
            without_window: false,
            timings: false,
            renderer: false,
            began: Instant::now(),
            help: false,
        }
    }
}

impl Arguments {
    /// What is to be opened.
    pub fn request(&self) -> OpenRequest {
        OpenRequest {
            plugin_path: self.plugin_path.clone(),
            allow_plugins: self.allow_plugins.clone(),
            threads: self.threads,
            unit: self.unit,
            level: self.level,
            subdivide: self.subdivide,
            autosave: self.autosave.clone(),
            device: self.device.clone(),
            ..OpenRequest::new(self.path.clone().unwrap_or_default())
        }
    }

    /// Reads the arguments, without the name of the program.
    ///
    /// # Errors
    /// A sentence on an option that does not exist, or has no or another value than is allowed.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut parsed = Self::default();
        let mut settings = Vec::new();
        while let Some(argument) = arguments.next() {
            let mut next = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
            match argument.as_str() {
                "--help" | "-h" => parsed.help = true,
                "--plugin-path" => parsed.plugin_path.push(next()?.into()),
                "--allow-plugins" => parsed.allow_plugins.push(next()?.into()),
                "--threads" => parsed.threads = number(&argument, &next()?, 0..=1024)?,
                "--unit" => parsed.unit = Some(unit(&next()?)?),
                "--level" => parsed.level = number(&argument, &next()?, 2..=10)?,
                "--subdivide" => parsed.subdivide = true,
                "--device" => parsed.device = Some(DeviceRequest { plugin: next()?, ..DeviceRequest::default() }),
                "--device-set" => settings.push(setting(&next()?)?),
                "--antialias" => parsed.antialias = antialias(&next()?)?,
                "--autosave" => parsed.autosave = Some(next()?.into()),
                "--log" => parsed.log = Some(next()?.into()),
                "--measure" => parsed.measure = Some(number(&argument, &next()?, 1..=3600)?.into()),
                "--timings" => parsed.timings = true,
                "--renderer" => parsed.renderer = true,
                "--without-window" => parsed.without_window = true,
                option if option.starts_with("--") => return Err(format!("there is no option {option}")),
                path if parsed.path.is_none() => parsed.path = Some(path.into()),
                path => return Err(format!("one model at a time; there is already another beside `{path}`")),
            }
        }
        match &mut parsed.device {
            Some(device) => device.settings = settings,
            None if !settings.is_empty() => return Err("--device-set is for --device".into()),
            None => {}
        }
        if parsed.without_window && parsed.measure.is_none() {
            return Err("--without-window is for --measure".into());
        }
        if parsed.measure.is_some() && parsed.path.is_none() {
            return Err("--measure needs a model".into());
        }
        Ok(parsed)
    }
}

/// A number within `allowed`.
fn number<N>(option: &str, text: &str, allowed: std::ops::RangeInclusive<N>) -> Result<N, String>
where
    N: std::str::FromStr + PartialOrd + std::fmt::Display,
{
    let parsed = text.parse().ok().filter(|number| allowed.contains(number));
    parsed.ok_or_else(|| format!("{option} {text}; allowed is {} to {}", allowed.start(), allowed.end()))
}

/// A parameter and its value.
fn setting(text: &str) -> Result<(String, String), String> {
    let parts = text.split_once('=').filter(|(key, _)| !key.is_empty());
    let (key, value) = parts.ok_or_else(|| format!("--device-set {text}; allowed is KEY=VALUE"))?;
    Ok((key.to_owned(), value.to_owned()))
}

fn unit(text: &str) -> Result<LengthUnit, String> {
    match text {
        "m" => Ok(LengthUnit::Metre),
        "cm" => Ok(LengthUnit::Centimetre),
        "mm" => Ok(LengthUnit::Millimetre),
        "in" => Ok(LengthUnit::Inch),
        other => Err(format!("--unit {other}; allowed is m, cm, mm or in")),
    }
}

fn antialias(text: &str) -> Result<u16, String> {
    match text {
        "0" => Ok(0),
        "2" => Ok(2),
        "4" => Ok(4),
        "8" => Ok(8),
        other => Err(format!("--antialias {other}; allowed is 0, 2, 4 or 8")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Arguments, String> {
        Arguments::parse(text.split_whitespace().map(str::to_owned))
    }

    #[test]
    fn arguments_are_read_and_wrong_ones_are_named() {
        let all = parse("a.obj --unit mm --level 5 --threads 2 --plugin-path p --allow-plugins q --log l").unwrap();
        assert_eq!((all.path, all.unit, all.level), (Some("a.obj".into()), Some(LengthUnit::Millimetre), 5));
        assert_eq!((all.threads, all.plugin_path, all.log), (2, vec!["p".into()], Some("l".into())));
        assert_eq!(all.allow_plugins, ["q"].map(PathBuf::from));
        let device = parse("--device-set a=1 --device phantom --device-set b=c=d").unwrap().device.unwrap();
        let settings = [("a", "1"), ("b", "c=d")].map(|(key, value)| (key.to_owned(), value.to_owned()));
        assert_eq!((device.plugin.as_str(), &device.settings[..]), ("phantom", &settings[..]));
        for (text, named) in [
            ("--unit ft", "ft"),
            ("--level 99", "2 to 10"),
            ("--wat", "--wat"),
            ("a.obj b.obj", "b.obj"),
            ("--log", "needs a value"),
            ("--measure 5", "needs a model"),
            ("a.obj --without-window", "--measure"),
            ("a.obj --device-set x=1", "--device"),
            ("a.obj --device d --device-set x", "KEY=VALUE"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(named), "{text}: {error}");
        }
    }
}
