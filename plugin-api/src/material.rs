//! The trait of a material, and the C functions behind its tables.

use crate::abi::{self, Status};
use crate::batch::{Elements, NodeScalars, NodeVectors, Planes, Strides};
use crate::blocks::{Blocks, SingleBlocks};
use crate::fault::Fault;
use crate::info::Info;
use crate::instance::{Role, call, warn, with_params};
use crate::normals::{NormalForces, unit_normals};
use crate::param::{Param, Params, position};
use core::ffi::{CStr, c_char, c_void};
use core::marker::PhantomData;

/// A kind of element a material works on, and what it offers for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ElementRequest {
    /// [`abi::POINT`], [`abi::LINK`], ...
    pub kind: u32,
    /// Families of links ([`abi::STRUCTURAL`], ...), or 0 for other kinds.
    pub families: u32,
    /// [`abi::HAS_MASS`], [`abi::HAS_FORCES`], ...: the host calls the material for these only.
    pub flags: u32,
    /// Doubles of rest data per element, written by [`Material::rest`].
    pub rest_stride: u32,
    /// Doubles of history per element; zero at the start, and again where the present shape is made the one at rest.
    pub history_stride: u32,
}

impl ElementRequest {
    /// Number of corners of its kind of element.
    ///
    /// # Panics
    /// On an unknown kind, which the host refuses when it opens a material.
    pub fn corners(&self) -> usize {
        corners(self.kind)
    }
}

/// Number of corners of an element kind ([`abi::POINT`], ...).
///
/// # Panics
/// On an unknown kind.
pub fn corners(kind: u32) -> usize {
    match kind {
        abi::POINT => 1,
        abi::LINK => 2,
        abi::TRIANGLE => 3,
        abi::HINGE | abi::TETRAHEDRON => 4,
        _ => panic!("no element kind {kind}"),
    }
}

/// Factors of stiffness and damping in a matrix `stiffness K + damping C`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentScale {
    /// Factor of K = d2E/dx2 (N/m).
    pub stiffness: f64,
    /// Factor of C = -df/dv (N s/m).
    pub damping: f64,
}

/// The source of the numbers behind a choice, printed by `pliant plugin info`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// Key of the parameter, one of kind [`abi::PARAM_CHOICE`].
    pub param: &'static CStr,
    /// Index of the choice.
    pub choice: u32,
    /// Who measured what, and when.
    pub citation: &'static CStr,
    /// What was not measured or is doubtful; empty where nothing is.
    pub limitations: &'static CStr,
}

/// A constitutive law: energy, force and stiffness of a deformed body.
///
/// A material is a function of its arguments: the host owns positions, velocities, rest data and history, may call several ranges
/// of elements at once, and integrates the motion. *Real time*: every method but [`Material::new`] and [`Material::elements`]
/// runs inside a step and must not allocate, lock or do I/O. Write to the nodes of the call's elements only.
pub trait Material: Send + Sync + Sized + 'static {
    /// The plugin's descriptor.
    const INFO: Info;

    /// Sources of the numbers behind choices.
    const SOURCES: &'static [Source] = &[];

    /// Whether each call is to have all elements of its kind, with one call of an instance at a time: for a law whose calls have a cost of their own, as
    /// on a GPU. Elements cannot fail then, and results must not depend on ranges: older hosts divide the list.
    const WANTS_WHOLE_LISTS: bool = false;

    /// A material with these parameters. Its last chance to allocate.
    ///
    /// # Errors
    /// A combination of parameters that their ranges cannot exclude.
    fn new(params: &Params<'_>) -> Result<Self, Fault>;

    /// The kinds of elements the material works on, given its parameters.
    fn elements(&self) -> Vec<ElementRequest>;

    /// Writes the rest data, from rest positions, measures, fields and, with [`abi::WANTS_DIRECTIONS`], fibre directions alone
    /// ([`Elements::direction`]). Called for kinds with a rest stride above 0.
    ///
    /// # Errors
    /// An element whose rest shape cannot be used.
    fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault>;

    /// What is doubtful about elements whose rest data was just written, in one line of at most 255 bytes for people: the host shows it as a warning. It may
    /// allocate where it has something to say.
    fn rest_warning(&self, _elements: &Elements<'_>) -> Option<String> {
        None
    }

    /// Adds the elements' lumped masses to their nodes, kg.
    ///
    /// # Errors
    /// As for [`Material::rest`].
    fn mass(&self, elements: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault>;

    /// Elastic energy of the elements, J.
    ///
    /// # Errors
    /// A value that is not finite.
    fn energy(&self, elements: &Elements<'_>) -> Result<f64, Fault>;

    /// Adds the nodal forces -dE/dx - C v, N, with the velocities of the call. The host calls with velocities of zero where it takes C v from the matrix of
    /// [`Material::tangent`], as in the first iteration of a step of backward Euler: so C may depend on positions and not on velocities.
    ///
    /// # Errors
    /// A value that is not finite.
    fn forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault>;

    /// Adds `scale.stiffness` K + `scale.damping` C, N/m. K may be a positive semi-definite approximation of the exact Hessian.
    ///
    /// # Errors
    /// A value that is not finite.
    fn tangent(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault>;

    /// As [`Material::tangent`], in single precision and for the off-diagonal blocks (a, b), a < b, alone. Called for kinds with
    /// [`abi::HAS_SINGLE`]. Such an element resists no translation, so the host computes a diagonal block as minus the sum of the
    /// others of its row.
    ///
    /// # Errors
    /// As for [`Material::tangent`].
    fn single_tangent(
        &self,
        _elements: &Elements<'_>,
        _scale: TangentScale,
        _out: &mut SingleBlocks<'_>,
    ) -> Result<(), Fault> {
        Err(Fault::unsupported("no stiffness in single precision"))
    }

    /// Updates the history, which holds its present values, after an accepted step, in the state the step ended in. At fixed positions an
    /// update must not add elastic energy. Called for kinds with [`abi::HAS_HISTORY`].
    ///
    /// # Errors
    /// A value that is not finite.
    fn advance(&self, _elements: &Elements<'_>, _history: &mut Planes<'_>) -> Result<(), Fault> {
        Ok(())
    }

    /// Whether element `e` of the call has failed, such as a torn triangle or an open link, by history, rest data, measure and fields alone; never
    /// while its history is zero. Called for kinds with [`abi::CAN_FAIL`] after [`Material::advance`], and where the host has put histories back.
    /// The host then calls the material for the other elements only; masses and the history of what has failed stay.
    fn has_failed(&self, _elements: &Elements<'_>, _e: usize) -> bool {
        false
    }

    /// For hinges with [`abi::IS_COUPLED`]: writes plane 0, the strain s of each hinge, m, and planes 1 to 12, its gradient by corner
    /// and axis. The host solves G m = s for the bending moments m (N), with G the sum of [`Material::compliance`], and applies the
    /// forces -m ds/dx; the energy is s . m / 2 (Hellan 1967, Herrmann 1967, Johnson 1973).
    ///
    /// # Errors
    /// A value that is not finite.
    fn strain(&self, _elements: &Elements<'_>, _out: &mut Planes<'_>) -> Result<(), Fault> {
        Err(Fault::unsupported("no coupled hinges"))
    }

    /// For triangles with [`abi::IS_COUPLED`], from rest positions alone: writes the compliance between the sides 01, 12 and 20, m/N,
    /// in six planes (0,0) (0,1) (0,2) (1,1) (1,2) (2,2). It must be positive definite.
    ///
    /// # Errors
    /// An element whose rest shape cannot be used.
    fn compliance(&self, _elements: &Elements<'_>, _out: &mut Planes<'_>) -> Result<(), Fault> {
        Err(Fault::unsupported("no coupled hinges"))
    }

    /// For triangles with [`abi::WANTS_NORMALS`]: the energy E(x, n) that depends on the sheet's unit normals, J. `normals` (n x 3)
    /// are those of all nodes, the normalised sums of the area vectors of the triangles around each.
    ///
    /// # Errors
    /// A value that is not finite.
    fn normals_energy(&self, _elements: &Elements<'_>, _normals: &[[f64; 3]]) -> Result<f64, Fault> {
        Err(Fault::unsupported("no energy of normals"))
    }

    /// For triangles with [`abi::WANTS_NORMALS`]: adds -dE/dx at fixed normals, N, and dE/dn, J. The host applies the chain rule
    /// through n(x).
    ///
    /// # Errors
    /// A value that is not finite.
    fn normals_forces(
        &self,
        _elements: &Elements<'_>,
        _normals: &[[f64; 3]],
        _out: &mut NormalForces<'_>,
    ) -> Result<(), Fault> {
        Err(Fault::unsupported("no energy of normals"))
    }

    /// For triangles with [`abi::WANTS_NORMALS`], from rest positions alone: writes three planes, N m, the second derivative of E by
    /// the angle at which a corner's normal tilts across the side 01, 12 and 20, the largest over the corners. In the matrix, the host
    /// approximates E by a spring against folding of each hinge with this stiffness.
    ///
    /// # Errors
    /// An element whose rest shape cannot be used.
    fn tilt(&self, _elements: &Elements<'_>, _out: &mut Planes<'_>) -> Result<(), Fault> {
        Err(Fault::unsupported("no energy of normals"))
    }
}

/// Adapter: a [`Material`] as a plugin, for [`crate::export_plugins`].
pub struct AsMaterial<T>(PhantomData<T>);

/// An active material and the elements it has asked for, which stay as they were then.
pub struct ActiveMaterial<T> {
    material: T,
    requests: Vec<ElementRequest>,
    declared: &'static [Param],
}

impl<T> ActiveMaterial<T> {
    /// The elements of a batch.
    fn elements<'a>(&self, batch: &'a abi::Batch) -> Elements<'a> {
        Elements(batch, self.strides(batch), self.declared, core::ptr::null())
    }

    /// The planes of data of a batch.
    fn strides(&self, batch: &abi::Batch) -> Strides {
        Strides::of(&self.requests, batch.kind)
    }
}

impl<T: Material> Role for AsMaterial<T> {
    type Object = ActiveMaterial<T>;
    const INFO: Info = T::INFO;
    const KIND: u32 = abi::KIND_MATERIAL;
    const FLAGS: u32 = if T::WANTS_WHOLE_LISTS { abi::FLAG_WHOLE_LISTS } else { 0 };
    const EXTENSION: &'static CStr = abi::MATERIAL;

    fn table() -> *const c_void {
        (&raw const *Self::TABLE).cast()
    }

    fn optional_table(id: &CStr) -> *const c_void {
        match id {
            _ if id == abi::COUPLED => (&raw const *Self::COUPLED).cast(),
            _ if id == abi::SINGLE => (&raw const *Self::SINGLE).cast(),
            _ if id == abi::NORMALS => (&raw const *Self::NORMALS).cast(),
            _ if id == abi::FAILURE => (&raw const *Self::FAILURE).cast(),
            _ if id == abi::DIRECTIONS => (&raw const *Self::DIRECTIONS).cast(),
            _ if id == abi::SOURCES && !T::SOURCES.is_empty() => (&raw const *Self::SOURCES).cast(),
            _ => core::ptr::null(),
        }
    }

    fn activate(params: &Params<'_>) -> Result<ActiveMaterial<T>, Fault> {
        let material = T::new(params)?;
        let requests = material.elements();
        Ok(ActiveMaterial { material, requests, declared: T::INFO.params })
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

    const FAILURE: &'static abi::Failure =
        &abi::Failure { size: size_of::<abi::Failure>(), failed: Some(Self::failed) };

    const DIRECTIONS: &'static abi::Directions =
        &abi::Directions { size: size_of::<abi::Directions>(), rest: Some(Self::directed_rest) };

    const SOURCES: &'static abi::Sources =
        &abi::Sources { size: size_of::<abi::Sources>(), source: Some(Self::source) };

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
                let declared = position(T::INFO.params, key).ok_or(Fault::bad_argument("no such parameter"))?;
                (*param, *choice) = (declared as u32, found.choice);
                (*source, *unknown) = (found.citation.as_ptr(), found.limitations.as_ptr());
                Ok(())
            })
        }
    }

    unsafe extern "C" fn strain(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |active| {
                active.material.strain(&active.elements(&*batch), &mut Planes::new(&*batch, out, 13))
            })
        }
    }

    unsafe extern "C" fn compliance(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |active| {
                active.material.compliance(&active.elements(&*batch), &mut Planes::new(&*batch, out, 6))
            })
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
            call::<Self, _>(plugin, |active| {
                *energy += active.material.normals_energy(&active.elements(&*batch), unit_normals(&*batch, normals))?;
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
            call::<Self, _>(plugin, |active| {
                let normals = unit_normals(&*batch, normals);
                active.material.normals_forces(&active.elements(&*batch), normals, &mut NormalForces::new(&*batch, out))
            })
        }
    }

    unsafe extern "C" fn tilt(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |active| {
                active.material.tilt(&active.elements(&*batch), &mut Planes::new(&*batch, out, 3))
            })
        }
    }

    unsafe extern "C" fn elements(plugin: *const abi::Plugin, index: u32, out: *mut abi::ElementRequest) -> Status {
        // SAFETY: the host calls with an instance of this role, and `out` is its own to fill.
        unsafe {
            call::<Self, _>(plugin, |active| {
                let Some(request) = active.requests.get(index as usize) else {
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
        unsafe {
            call::<Self, _>(plugin, |active| {
                let elements = active.elements(&*batch);
                active.material.rest(&elements, &mut Planes::new(&*batch, out, active.strides(&*batch).rest))?;
                active.material.rest_warning(&elements).into_iter().for_each(|text| warn::<Self>(plugin, &text));
                Ok(())
            })
        }
    }

    unsafe extern "C" fn directed_rest(
        plugin: *const abi::Plugin,
        batch: *const abi::Batch,
        directions: *const f64,
        out: *mut f64,
    ) -> Status {
        // SAFETY: as in `rest`; `directions` holds three doubles for each element, borrowed for the call.
        unsafe {
            call::<Self, _>(plugin, |active| {
                let mut elements = active.elements(&*batch);
                elements.3 = directions;
                active.material.rest(&elements, &mut Planes::new(&*batch, out, active.strides(&*batch).rest))?;
                active.material.rest_warning(&elements).into_iter().for_each(|text| warn::<Self>(plugin, &text));
                Ok(())
            })
        }
    }

    unsafe extern "C" fn mass(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |active| {
                active.material.mass(&active.elements(&*batch), &mut NodeScalars::new(&*batch, out))
            })
        }
    }

    unsafe extern "C" fn energy(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |active| {
                *out += active.material.energy(&active.elements(&*batch))?;
                Ok(())
            })
        }
    }

    unsafe extern "C" fn forces(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |active| {
                active.material.forces(&active.elements(&*batch), &mut NodeVectors::new(&*batch, out))
            })
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
            call::<Self, _>(plugin, |active| {
                let mut blocks = Blocks::new(&*batch, &*blocks);
                active.material.tangent(&active.elements(&*batch), TangentScale { stiffness, damping }, &mut blocks)
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
            call::<Self, _>(plugin, |active| {
                let mut blocks = SingleBlocks::new_single(&*batch, &*blocks);
                active.material.single_tangent(
                    &active.elements(&*batch),
                    TangentScale { stiffness, damping },
                    &mut blocks,
                )
            })
        }
    }

    unsafe extern "C" fn failed(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut u8) -> Status {
        // SAFETY: as in `rest`; `out` holds a byte for each element, and those of the call's range are ours.
        unsafe {
            call::<Self, _>(plugin, |active| {
                let elements = active.elements(&*batch);
                let first = elements.first_index();
                (0..elements.len())
                    .for_each(|e| *out.add(first + e) = u8::from(active.material.has_failed(&elements, e)));
                Ok(())
            })
        }
    }

    unsafe extern "C" fn advance(plugin: *const abi::Plugin, batch: *const abi::Batch, out: *mut f64) -> Status {
        // SAFETY: as in `rest`.
        unsafe {
            call::<Self, _>(plugin, |active| {
                active
                    .material
                    .advance(&active.elements(&*batch), &mut Planes::new(&*batch, out, active.strides(&*batch).history))
            })
        }
    }
}
