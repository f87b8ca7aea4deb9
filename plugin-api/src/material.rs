//! The trait of a material, and its side of the wire.

use crate::abi::{self, Status};
use crate::batch::{Elements, NodeScalars, NodeVectors, Planes};
use crate::blocks::{Blocks, SingleBlocks};
use crate::fault::Fault;
use crate::info::Info;
use crate::instance::{Role, call, with_params};
use crate::normals::{NormalForces, unit_normals};
use crate::param::{Params, position};
use core::ffi::{CStr, c_char, c_void};
use core::marker::PhantomData;

/// The elements a material wants of a body, of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ElementRequest {
    /// [`abi::POINT`], [`abi::LINK`], ...
    pub kind: u32,
    /// Families of links, or 0.
    pub families: u32,
    /// [`abi::HAS_MASS`] and the like: what is asked of the material for this kind, and nothing else is.
    pub flags: u32,
    /// Doubles of rest data per element.
    pub rest_stride: u32,
    /// Doubles of history per element.
    pub history_stride: u32,
}

/// How much of each goes into the matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent {
    /// Factor of K = d2E/dx2.
    pub stiffness: f64,
    /// Factor of C = -df/dv.
    pub damping: f64,
}

/// Where the numbers behind a choice come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// Key of the parameter.
    pub param: &'static CStr,
    /// Place of the choice.
    pub choice: u32,
    /// Who measured what, and when.
    pub source: &'static CStr,
    /// What it leaves open; empty where nothing.
    pub unknown: &'static CStr,
}

/// Energy, force and stiffness of a deformed body.
///
/// A material is a function of its arguments: the host owns positions, velocities, rest data and history, calls several
/// ranges at once, and moves the body. *Real time*: everything but [`Material::new`] and [`Material::elements`] runs
/// inside a step and must not allocate, lock or do I/O.
pub trait Material: Send + Sync + Sized + 'static {
    /// Facts for the descriptor.
    const INFO: Info;

    /// Where the numbers behind choices come from, for whoever reads `pliant plugin info`.
    const SOURCES: &'static [Source] = &[];

    /// Takes the parameters.
    ///
    /// # Errors
    /// A combination of parameters that ranges could not exclude.
    fn new(params: &Params<'_>) -> Result<Self, Fault>;

    /// The kinds of elements wanted, given the parameters.
    fn elements(&self) -> Vec<ElementRequest>;

    /// Writes the rest data, from rest positions and measures alone; asked only of kinds with a rest stride.
    ///
    /// # Errors
    /// An element whose rest shape cannot be used.
    fn rest(&self, at: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault>;

    /// Adds the elements' masses, kg.
    ///
    /// # Errors
    /// As for [`Material::rest`].
    fn mass(&self, at: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault>;

    /// The elements' energy, J.
    ///
    /// # Errors
    /// A value that is not finite.
    fn energy(&self, at: &Elements<'_>) -> Result<f64, Fault>;

    /// Adds -dE/dx - C v, N.
    ///
    /// # Errors
    /// A value that is not finite.
    fn forces(&self, at: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault>;

    /// Adds `scale.stiffness` K + `scale.damping` C. K may be a positive semi-definite stand-in for the exact Hessian.
    ///
    /// # Errors
    /// A value that is not finite.
    fn tangent(&self, at: &Elements<'_>, scale: Tangent, out: &mut Blocks<'_>) -> Result<(), Fault>;

    /// The same in single precision, of kinds with [`abi::HAS_SINGLE`], and only the blocks (a, b), a < b. Such an element resists no
    /// motion of all of its corners alike: the host finds the blocks of the diagonal as what the others of a row leave.
    ///
    /// # Errors
    /// As for [`Material::tangent`].
    fn single_tangent(&self, _at: &Elements<'_>, _scale: Tangent, _out: &mut SingleBlocks<'_>) -> Result<(), Fault> {
        Err(Fault::unsupported("no stiffness in single precision"))
    }

    /// Brings the history of an accepted step up to date; asked only of kinds with [`abi::HAS_HISTORY`].
    ///
    /// # Errors
    /// A value that is not finite.
    fn advance(&self, _at: &Elements<'_>, _history: &mut Planes<'_>) -> Result<(), Fault> {
        Ok(())
    }

    /// Of hinges with [`abi::IS_COUPLED`]: plane 0 the strain s, m; planes 1 to 12 its gradient, by corner and axis. The
    /// host solves G m = s, G the sum of [`Material::compliance`], and applies the forces -m ds/dx; the energy is s . m / 2
    /// (Hellan 1967, Herrmann 1967, Johnson 1973).
    ///
    /// # Errors
    /// A value that is not finite.
    fn strain(&self, _at: &Elements<'_>, _out: &mut Planes<'_>) -> Result<(), Fault> {
        Err(Fault::unsupported("no coupled hinges"))
    }

    /// Of triangles with [`abi::IS_COUPLED`], from rest positions alone, m/N: compliance between the sides 01, 12 and 20, in
    /// six planes (0,0) (0,1) (0,2) (1,1) (1,2) (2,2); positive definite.
    ///
    /// # Errors
    /// An element whose rest shape cannot be used.
    fn compliance(&self, _at: &Elements<'_>, _out: &mut Planes<'_>) -> Result<(), Fault> {
        Err(Fault::unsupported("no coupled hinges"))
    }

    /// Of triangles with [`abi::WANTS_NORMALS`], the energy E(x, n) that depends on the sheet's unit normals, J. `normals` are
    /// those of all nodes (n x 3), sums of the area vectors around each over their lengths.
    ///
    /// # Errors
    /// A value that is not finite.
    fn normals_energy(&self, _at: &Elements<'_>, _normals: &[[f64; 3]]) -> Result<f64, Fault> {
        Err(Fault::unsupported("no energy of normals"))
    }

    /// Adds its -dE/dx at fixed normals, N, and dE/dn, J. The host adds what the normals do to the force as they turn.
    ///
    /// # Errors
    /// A value that is not finite.
    fn normals_forces(
        &self,
        _at: &Elements<'_>,
        _normals: &[[f64; 3]],
        _out: &mut NormalForces<'_>,
    ) -> Result<(), Fault> {
        Err(Fault::unsupported("no energy of normals"))
    }

    /// From rest positions alone, in three planes, N m: d2E/dn2 of a corner's normal that tilts across the side 01, 12 and 20
    /// of its triangle, at the stiffest corner. The host makes the matrix of hinges from it that stands for E.
    ///
    /// # Errors
    /// An element whose rest shape cannot be used.
    fn tilt(&self, _at: &Elements<'_>, _out: &mut Planes<'_>) -> Result<(), Fault> {
        Err(Fault::unsupported("no energy of normals"))
    }
}

/// A [`Material`] as [`crate::export_plugins`] hands it over.
pub struct AsMaterial<T>(PhantomData<T>);

impl<T: Material> Role for AsMaterial<T> {
    type Object = T;
    const INFO: Info = T::INFO;
    const KIND: u32 = abi::KIND_MATERIAL;
    const EXTENSION: &'static CStr = abi::MATERIAL;

    fn table() -> *const c_void {
        (&raw const *Self::TABLE).cast()
    }

    fn other_table(id: &CStr) -> *const c_void {
        match id {
            _ if id == abi::COUPLED => (&raw const *Self::COUPLED).cast(),
            _ if id == abi::SINGLE => (&raw const *Self::SINGLE).cast(),
            _ if id == abi::NORMALS => (&raw const *Self::NORMALS).cast(),
            _ if id == abi::SOURCES && !T::SOURCES.is_empty() => (&raw const *Self::CITED).cast(),
            _ => core::ptr::null(),
        }
    }

    fn open(params: &Params<'_>, _limits: &abi::Limits) -> Result<T, Fault> {
        T::new(params)
    }
}

#[allow(unsafe_code, reason = "the functions behind the table")]
impl<T: Material> AsMaterial<T> {
    const TABLE: &'static abi::Material = &abi::Material {
        size: size_of::<abi::Material>(),
        elements: Some(Self::elements),
        rest: Some(Self::rest),
        mass: Some(Self::mass),
        energy: Some(Self::energy),
        forces: Some(Self::forces),
        tangent: Some(Self::tangent),
        product: None,
        advance: Some(Self::advance),
    };

    const COUPLED: &'static abi::Coupled = &abi::Coupled {
        size: size_of::<abi::Coupled>(),
        strain: Some(Self::strain),
        compliance: Some(Self::compliance),
    };

    const SINGLE: &'static abi::Single =
        &abi::Single { size: size_of::<abi::Single>(), tangent: Some(Self::single_tangent) };

    const NORMALS: &'static abi::Normals = &abi::Normals {
        size: size_of::<abi::Normals>(),
        energy: Some(Self::normals_energy),
        forces: Some(Self::normals_forces),
        tilt: Some(Self::tilt),
    };

    const CITED: &'static abi::Sources = &abi::Sources { size: size_of::<abi::Sources>(), source: Some(Self::source) };

    unsafe extern "C" fn source(
        plugin: *const abi::Plugin,
        index: u32,
        param: *mut u32,
        choice: *mut u32,
        source: *mut *const c_char,
        unknown: *mut *const c_char,
    ) -> Status {
        // SAFETY: a live instance of this role on [main]; the host's to fill.
        unsafe {
            with_params::<Self, _>(plugin, |_| {
                let found = T::SOURCES.get(index as usize).ok_or(Fault::unsupported(""))?;
                let key = found.param.to_str().unwrap_or_default();
                let place = position(T::INFO.params, key).ok_or(Fault::bad_argument("no such parameter"))?;
                (*param, *choice) = (place as u32, found.choice);
                (*source, *unknown) = (found.source.as_ptr(), found.unknown.as_ptr());
                Ok(())
            })
        }
    }

    unsafe extern "C" fn strain(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |material| material.strain(&Elements(&*batch), &mut Planes::new(&*batch, out)))
        }
    }

    unsafe extern "C" fn compliance(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |material| material.compliance(&Elements(&*batch), &mut Planes::new(&*batch, out)))
        }
    }

    unsafe extern "C" fn normals_energy(
        plugin: *const abi::Plugin,
        batch: *const abi::Batch,
        normals: *const f64,
        energy: *mut f64,
    ) -> Status {
        // SAFETY: as in `rest`; a normal for each node of the batch.
        unsafe {
            call::<Self, _>(plugin, |material| {
                *energy += material.normals_energy(&Elements(&*batch), unit_normals(&*batch, normals))?;
                Ok(())
            })
        }
    }

    unsafe extern "C" fn normals_forces(
        plugin: *const abi::Plugin,
        batch: *const abi::Batch,
        normals: *const f64,
        out: *mut f64,
    ) -> Status {
        // SAFETY: as in `rest`; a normal for each node of the batch, and six doubles for each of its window.
        unsafe {
            call::<Self, _>(plugin, |material| {
                let normals = unit_normals(&*batch, normals);
                material.normals_forces(&Elements(&*batch), normals, &mut NormalForces::new(&*batch, out))
            })
        }
    }

    unsafe extern "C" fn tilt(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe { call::<Self, _>(plugin, |material| material.tilt(&Elements(&*batch), &mut Planes::new(&*batch, out))) }
    }

    unsafe extern "C" fn elements(plugin: *const abi::Plugin, index: u32, out: *mut abi::ElementRequest) -> Status {
        // SAFETY: the host calls with an instance of this role, and `out` is its own to fill.
        unsafe {
            call::<Self, _>(plugin, |material| {
                let wanted = material.elements();
                let Some(request) = wanted.get(index as usize) else {
                    return Err(Fault::unsupported(""));
                };
                *out = abi::ElementRequest {
                    size: size_of::<abi::ElementRequest>(),
                    kind: request.kind,
                    families: request.families,
                    flags: request.flags,
                    rest_stride: request.rest_stride,
                    history_stride: request.history_stride,
                };
                Ok(())
            })
        }
    }

    unsafe extern "C" fn rest(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: the host's promises of the header: a live instance, a batch borrowed for the call, planes of its range.
        unsafe { call::<Self, _>(plugin, |material| material.rest(&Elements(&*batch), &mut Planes::new(&*batch, out))) }
    }

    unsafe extern "C" fn mass(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |material| material.mass(&Elements(&*batch), &mut NodeScalars::new(&*batch, out)))
        }
    }

    unsafe extern "C" fn energy(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |material| {
                *out += material.energy(&Elements(&*batch))?;
                Ok(())
            })
        }
    }

    unsafe extern "C" fn forces(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |material| material.forces(&Elements(&*batch), &mut NodeVectors::new(&*batch, out)))
        }
    }

    unsafe extern "C" fn tangent(
        plugin: *const abi::Plugin,
        batch: *const abi::Batch,
        stiffness: f64,
        damping: f64,
        blocks: *const abi::Blocks,
    ) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |material| {
                let mut blocks = Blocks::new(&*batch, &*blocks);
                material.tangent(&Elements(&*batch), Tangent { stiffness, damping }, &mut blocks)
            })
        }
    }

    unsafe extern "C" fn single_tangent(
        plugin: *const abi::Plugin,
        batch: *const abi::Batch,
        stiffness: f64,
        damping: f64,
        blocks: *const abi::SingleBlocks,
    ) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |material| {
                let mut blocks = SingleBlocks::single(&*batch, &*blocks);
                material.single_tangent(&Elements(&*batch), Tangent { stiffness, damping }, &mut blocks)
            })
        }
    }

    unsafe extern "C" fn advance(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |material| material.advance(&Elements(&*batch), &mut Planes::new(&*batch, out)))
        }
    }
}
