//! Safe calls into a material's energy of vertex normals.

use super::error::HostError;
use super::material::{Call, Material};
use pliant_plugin_api::abi;

#[allow(unsafe_code, reason = "calls the material's functions")]
impl Material {
    /// Takes the table where a request asks for normals.
    pub(super) fn read_normals(&mut self) -> Result<(), HostError> {
        let wants = |kind: u32| self.requests.iter().any(|r| r.kind == kind && r.flags & abi::WANTS_NORMALS != 0);
        let (triangles, hinges) = (wants(abi::TRIANGLE), wants(abi::HINGE));
        if triangles != hinges {
            return Err(self.instance.error("elements", "triangles and hinges want normals together"));
        }
        if triangles {
            let found = self.instance.other_table(abi::NORMALS, size_of::<abi::Normals>());
            // SAFETY: at least as large as the table, and lives as long as the library.
            let table = found.map(|table| unsafe { &*table.cast::<abi::Normals>() });
            self.normals = table.filter(|t| t.energy.is_some() && t.forces.is_some() && t.tilt.is_some());
            if self.normals.is_none() {
                return Err(self.instance.error("extension", "normals without `pliant.normals/1`"));
            }
        }
        Ok(())
    }

    fn normals(&self) -> &'static abi::Normals {
        self.normals.expect("checked when it was opened")
    }

    /// Energy of the call's triangles with these unit normals (n x 3), J. `[sim]`
    ///
    /// # Errors
    /// What the material says, or a value that is not finite.
    pub fn normals_energy(&self, call: &Call<'_>, normals: &[[f64; 3]]) -> Result<f64, HostError> {
        assert_eq!(normals.len(), call.x.len());
        let (energy, mut sum) = (self.normals().energy.expect("checked"), 0.0);
        // SAFETY: [sim & active]; a normal for each node; `sum` is ours.
        let status = unsafe { energy(self.instance.plugin(), &call.batch(), normals.as_ptr().cast(), &mut sum) };
        self.instance.done("normals_energy", status)?;
        let why = || self.instance.error("normals_energy", &format!("the result is {sum} J"));
        if sum.is_finite() { Ok(sum) } else { Err(why()) }
    }

    /// Adds forces at fixed normals, N, and slopes in them, J, into `out`, the window of the call (w x 6). `[sim]`
    ///
    /// # Errors
    /// What the material says.
    pub fn normals_forces(&self, call: &Call<'_>, normals: &[[f64; 3]], out: &mut [[f64; 6]]) -> Result<(), HostError> {
        assert_eq!((normals.len(), out.len()), (call.x.len(), call.window.len()));
        let (forces, base) =
            (self.normals().forces.expect("checked"), out.as_mut_ptr().wrapping_sub(call.window.start));
        // SAFETY: [sim & active]; a normal for each node; the window behind `base` is `out`, all ours.
        let status = unsafe { forces(self.instance.plugin(), &call.batch(), normals.as_ptr().cast(), base.cast()) };
        self.instance.done("normals_forces", status)
    }

    /// Writes how stiffly normals tilt across the sides of the call's triangles, N m, into `planes` (3 x m). `[sim]`
    ///
    /// # Errors
    /// What the material says.
    pub fn tilt(&self, call: &Call<'_>, planes: &mut [f64]) -> Result<(), HostError> {
        let tilt = self.normals().tilt.expect("checked");
        // SAFETY: [sim & active]; `planes` holds the planes of all elements.
        self.instance.done("tilt", unsafe { tilt(self.instance.plugin(), &call.batch(), planes.as_mut_ptr()) })
    }
}
