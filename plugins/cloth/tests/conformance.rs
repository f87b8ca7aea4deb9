//! The conformance suite on cloth with its default bending and with the projected Laplacian, which uses the extension for normals.

use pliant_cloth::Cloth;
use pliant_plugin_api::kit::{self, CountingAllocator};
use pliant_plugin_api::{
    AsMaterial, Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, NormalForces,
    Params, Planes, TangentScale,
};

#[global_allocator]
static COUNTING: CountingAllocator = CountingAllocator;

#[test]
fn conformance() {
    kit::check::<AsMaterial<Cloth>>();
}

/// Cloth that bends by the projected Laplacian: of its parameters only `tangent` and its fields have an effect.
struct Laplacian(Cloth);

impl Material for Laplacian {
    const INFO: Info = Cloth::INFO;

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let field = |key| (key, params.number(key));
        let tangent = ("tangent", params.choice("tangent") as f64);
        kit::material(&[("bending", 3.0), tangent, field("young"), field("thickness")]).map(Self)
    }

    fn elements(&self) -> Vec<ElementRequest> {
        self.0.elements()
    }

    fn rest(&self, at: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        self.0.rest(at, out)
    }

    fn mass(&self, at: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        self.0.mass(at, out)
    }

    fn energy(&self, at: &Elements<'_>) -> Result<f64, Fault> {
        self.0.energy(at)
    }

    fn forces(&self, at: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        self.0.forces(at, out)
    }

    fn tangent(&self, at: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        self.0.tangent(at, scale, out)
    }

    fn normals_energy(&self, at: &Elements<'_>, normals: &[[f64; 3]]) -> Result<f64, Fault> {
        self.0.normals_energy(at, normals)
    }

    fn normals_forces(&self, at: &Elements<'_>, normals: &[[f64; 3]], out: &mut NormalForces<'_>) -> Result<(), Fault> {
        self.0.normals_forces(at, normals, out)
    }

    fn tilt(&self, at: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        self.0.tilt(at, out)
    }
}

#[test]
fn conformance_of_the_projected_laplacian() {
    kit::check::<AsMaterial<Laplacian>>();
}
