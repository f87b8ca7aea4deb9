//! The axes of a tablet: their least and greatest values, and how many of them make a millimetre or a radian.

use crate::event::{ABS_DISTANCE, ABS_PRESSURE, ABS_TILT_X, ABS_TILT_Y, ABS_X, ABS_Y};

/// The values of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Axis {
    /// Least value, in the device's own units.
    pub min: i32,
    /// Greatest value, in the same units; the axis is absent where it is not above `min`.
    pub max: i32,
    /// Values for a millimetre, or for a radian of a tilt; 0 where the device does not say it.
    pub resolution: i32,
    /// Value when the device was opened; 0 where it does not say it. The kernel sends only what differs from it.
    pub value: i32,
}

impl Axis {
    /// From 0 to `max`, of unknown resolution.
    pub fn up_to(max: f64) -> Self {
        Self { min: 0, max: max as i32, resolution: 0, value: 0 }
    }

    /// Whether the device has it.
    pub fn is_present(&self) -> bool {
        self.max > self.min
    }

    /// A value as a share of the axis, 0 to 1; 0 for an absent axis.
    pub fn share(&self, value: i32) -> f64 {
        if !self.is_present() {
            return 0.0;
        }
        ((f64::from(value) - f64::from(self.min)) / self.span()).clamp(0.0, 1.0)
    }

    /// Greatest value less the least.
    pub fn span(&self) -> f64 {
        f64::from(self.max) - f64::from(self.min)
    }

    /// Length of the axis, m; `None` where the device does not say it.
    pub fn length(&self) -> Option<f64> {
        (self.resolution > 0 && self.is_present()).then(|| 1e-3 * self.span() / f64::from(self.resolution))
    }

    /// A value of a tilt as an angle, rad; without a resolution the values are degrees.
    pub fn angle(&self, value: i32) -> f64 {
        match self.resolution {
            0 => f64::from(value).to_radians(),
            resolution => f64::from(value) / f64::from(resolution),
        }
    }
}

/// The axes of a tablet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Axes {
    /// Position of the tip to the right.
    pub x: Axis,
    /// Position of the tip towards the user.
    pub y: Axis,
    /// Pressure of the tip on the tablet.
    pub pressure: Axis,
    /// Height of the tip above the tablet; absent for many.
    pub distance: Axis,
    /// Tilt of the barrel to the right.
    pub tilt_x: Axis,
    /// Tilt of the barrel towards the user.
    pub tilt_y: Axis,
}

impl Axes {
    /// Asks a device for its axes; `None` for a file that is no device.
    #[cfg(target_os = "linux")]
    pub fn of_device(file: &std::fs::File) -> Option<Self> {
        Some(Self {
            x: query::<{ request(ABS_X) }>(file)?,
            y: query::<{ request(ABS_Y) }>(file)?,
            // A device may lack the others.
            pressure: query::<{ request(ABS_PRESSURE) }>(file).unwrap_or_default(),
            distance: query::<{ request(ABS_DISTANCE) }>(file).unwrap_or_default(),
            tilt_x: query::<{ request(ABS_TILT_X) }>(file).unwrap_or_default(),
            tilt_y: query::<{ request(ABS_TILT_Y) }>(file).unwrap_or_default(),
        })
    }
}

/// `struct input_absinfo`: value, least, greatest, fuzz, flat, resolution.
#[cfg(target_os = "linux")]
type AbsInfo = [i32; 6];

/// The request `EVIOCGABS` of an axis.
#[cfg(target_os = "linux")]
const fn request(code: u16) -> rustix::ioctl::Opcode {
    rustix::ioctl::opcode::read::<AbsInfo>(b'E', 0x40 + code as u8)
}

/// Asks for one axis.
#[cfg(target_os = "linux")]
fn query<const REQUEST: rustix::ioctl::Opcode>(file: &std::fs::File) -> Option<Axis> {
    #[allow(unsafe_code, reason = "a request of the kernel is known by a number")]
    // SAFETY: `EVIOCGABS` writes one `struct input_absinfo`, six numbers of 32 bits, which is what the getter makes room for; the kernel refuses
    // it for files that are no input devices.
    let info = unsafe { rustix::ioctl::ioctl(file, rustix::ioctl::Getter::<REQUEST, AbsInfo>::new()) }.ok()?;
    let [value, min, max, _, _, resolution] = info;
    Some(Axis { min, max, resolution, value })
}

#[cfg(all(test, target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod tests {
    use super::*;

    /// The numbers that `EVIOCGABS` of `linux/input.h` comes to in C.
    #[test]
    fn requests_have_the_numbers_of_the_kernel() {
        assert_eq!([ABS_X, ABS_Y, ABS_TILT_Y].map(request), [0x8018_4540, 0x8018_4541, 0x8018_455b]);
    }
}
