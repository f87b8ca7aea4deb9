//! The parameters of cloth, and their resolution: a number the scene gives goes before the fabric's.

use crate::bending::Rigidity;
use crate::elasticity::ElasticityTensor;
use crate::fabric::{CHOICES, FABRICS, FROM_FILE, Fabric, MembraneModuli};
use crate::fabric_file::FabricFile;
use crate::frame::FrameRule;
use crate::friction::YarnFriction;
use crate::membrane::{Membrane, StrainMeasure};
use crate::vector::Vec3;
use pliant_plugin_api::{Fault, Param, Params};
use std::ops::RangeInclusive;

/// Range of stiffnesses, N/m; 0: not given.
const STIFFNESS: RangeInclusive<f64> = 0.0..=1e12;
/// Range of bending rigidities, N m; 0: not given.
const BENDING: RangeInclusive<f64> = 0.0..=1e3;
/// Value of `bending-hysteresis` that takes the fabric's.
const FABRIC_HYSTERESIS: f64 = -1.0;
/// Value of `poisson` that takes the fabric's.
const FABRIC_POISSON: f64 = -1.0;

pub(crate) const PARAMS: &[Param] = &[
    Param::choice(c"fabric", CHOICES, c"preset of measured numbers for what is not given; none: an assumed light cloth"),
    Param::path(c"fabric-file", c"in the place of `fabric`: a TOML file with your own numbers and their `source`"),
    Param::number(c"density", c"kg/m^2", 0.0..=1e4, 0.0, c"mass per area; 0: the fabric's"),
    Param::number(c"young-warp", c"N/m", STIFFNESS, 0.0, c"Young's modulus along warp; 0: the fabric's"),
    Param::number(c"young-weft", c"N/m", STIFFNESS, 0.0, c"Young's modulus along weft; 0: as warp, else the fabric's"),
    Param::number(
        c"poisson",
        c"1",
        FABRIC_POISSON..=10.0,
        FABRIC_POISSON,
        c"contraction of the weft over the stretch of the warp; -1: the fabric's",
    ),
    Param::number(c"shear", c"N/m", STIFFNESS, 0.0, c"shear stiffness; 0: the fabric's; with fabric none that of an isotropic sheet"),
    Param::number(c"c11", c"N/m", STIFFNESS, 0.0, c"elasticity tensor: c11, c12 and c22 in the place of moduli and ratio; 0: not given"),
    Param::number(c"c12", c"N/m", -1e12..=1e12, 0.0, c"see c11"),
    Param::number(c"c22", c"N/m", STIFFNESS, 0.0, c"see c11"),
    Param::number(
        c"compression",
        c"1",
        0.0..=1.0,
        1.0,
        c"share of compressive stress that stays; below 1 for a sheet that wrinkles below the mesh",
    ),
    Param::number(c"damping-time", c"s", 0.0..=10.0, 1e-4, c"viscosity over stiffness, in the plane and of hinges"),
    Param::choice(c"frame", c"polar|edge|green", c"strain measure: in the polar frame, in the frame of the first edge, or Green's"),
    Param::choice(c"tangent", c"projected|exact", c"membrane matrix: made positive semi-definite, or exact"),
    Param::choice(
        c"bending",
        c"coupled|hinge|none|projected-laplacian",
        c"hinges coupled by triangles (converges on any mesh), each hinge by itself, none, or triangles against vertex normals (flat sheets)",
    ),
    Param::number(c"bending-warp", c"N m", BENDING, 0.0, c"bending rigidity along warp; 0: the fabric's"),
    Param::number(c"bending-weft", c"N m", BENDING, 0.0, c"bending rigidity along weft; 0: as warp, else the fabric's"),
    Param::number(
        c"bending-bias",
        c"N m",
        BENDING,
        0.0,
        c"bending rigidity at 45 degrees; 0: the fabric's, else from warp and weft",
    ),
    Param::number(
        c"bending-hysteresis",
        c"N",
        FABRIC_HYSTERESIS..=1e3,
        0.0,
        c"width of the hysteresis loop of the bending moment, 2HB; 0: none, -1: the fabric's",
    ),
    Param::number(
        c"slip-curvature",
        c"1/m",
        1e-3..=1e6,
        10.0,
        c"curvature at which yarns begin to slide, with bending-hysteresis; the default is an assumption",
    ),
    Param::number(
        c"young",
        c"1",
        1e-3..=1e3,
        1.0,
        c"factor of all stiffnesses, in the plane and in bending: for a field, as a coating makes it",
    )
    .field(),
    Param::number(
        c"thickness",
        c"1",
        1e-2..=1e2,
        1.0,
        c"thickness over the fabric's: stiffness in the plane and mass grow with it, bending with its cube; for a field",
    )
    .field(),
    Param::table(c"warp", c"x|y|z", c"direction of the warp in space, for bending = hinge: one row; default: x"),
];

/// The bending model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bending {
    /// Hinges coupled by the compliance of triangles.
    Coupled,
    /// Each hinge by itself.
    Hinge,
    /// No bending stiffness.
    None,
    /// Triangles against vertex normals.
    Laplacian,
}

/// The parameters, resolved.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// Mass per area, kg/m^2.
    pub(crate) density: f64,
    pub(crate) membrane: Membrane,
    pub(crate) bending: Bending,
    pub(crate) rigidity: Rigidity,
    pub(crate) friction: Option<YarnFriction>,
    /// Direction of the warp in space, of any length.
    pub(crate) warp: Vec3,
}

impl Settings {
    /// Resolves parameters, fabric and fabric file; refuses what none of them gives, and combinations that contradict each other.
    pub(crate) fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let file = params.text("fabric-file").map(FabricFile::read).transpose()?;
        let fabric = match (&file, params.choice("fabric")) {
            (None, choice) => &FABRICS[choice],
            (Some(_), 0) => &FROM_FILE,
            (Some(_), _) => return Err(Fault::bad_argument("`fabric` and `fabric-file`; allowed is one of them")),
        };
        let from_file = |key: &str| file.as_ref().and_then(|file| file.number(key));
        let given = |key: &str| Some(params.number(key)).filter(|value| *value > 0.0).or(from_file(key));
        let name = file.as_ref().map_or(fabric.name, |file| &file.path);
        let unknown = |what: &str, key: &str| {
            Fault::bad_argument(format!("the {what} of fabric `{name}` is not known: give `{key}`"))
        };
        let strain = [
            StrainMeasure::Corotated(FrameRule::Polar),
            StrainMeasure::Corotated(FrameRule::Edge),
            StrainMeasure::Green,
        ][params.choice("frame")];
        let bending = [Bending::Coupled, Bending::Hinge, Bending::None, Bending::Laplacian][params.choice("bending")];
        let rigidity = match (bending, rigidity(fabric, given)) {
            (_, Some(rigidity)) => rigidity?,
            (Bending::None, None) => Rigidity { warp: 1.0, weft: 1.0, twist: 1.0 },
            (Bending::Coupled | Bending::Hinge | Bending::Laplacian, None) => {
                return Err(unknown("bending", "bending-warp"));
            }
        };
        let hysteresis = match params.number("bending-hysteresis") {
            width if width >= 0.0 => width,
            _ => from_file("bending-hysteresis")
                .or(fabric.hysteresis)
                .ok_or_else(|| unknown("hysteresis", "bending-hysteresis"))?,
        };
        if bending == Bending::Laplacian {
            let refused = [
                (hysteresis > 0.0, "bending-hysteresis", "it has no friction"),
                (params.number("bending-bias") > 0.0, "bending-bias", "it has rigidities along warp and weft only"),
            ];
            if let Some((_, key, why)) = refused.iter().find(|(given, ..)| *given) {
                let text = format!("`{key}` with bending = projected-laplacian: {why}; allowed is coupled or hinge");
                return Err(Fault::bad_argument(text));
            }
        }
        let friction = YarnFriction { moment: 0.5 * hysteresis, curvature: params.number("slip-curvature") };
        if params.choice("tangent") == 1 && params.number("compression") < 1.0 {
            return Err(Fault::bad_argument("tangent = exact needs compression = 1"));
        }
        let shear = given("shear").or(fabric.shear);
        let elasticity = if given("c11").is_some() || given("c22").is_some() {
            let shear = shear.ok_or_else(|| {
                Fault::bad_argument(
                    "c11, c12 and c22 do not determine the shear: give `shear`, or a fabric that has it",
                )
            })?;
            let c12 = Some(params.number("c12")).filter(|c| *c != 0.0).or(from_file("c12"));
            ElasticityTensor::new(given("c11").unwrap_or(0.0), c12.unwrap_or(0.0), given("c22").unwrap_or(0.0), shear)?
        } else {
            if file.is_some() && given("young-warp").is_none() {
                return Err(unknown("stretch", "young-warp"));
            }
            let poisson =
                Some(params.number("poisson")).filter(|ratio| *ratio > FABRIC_POISSON).or(from_file("poisson"));
            let moduli = Moduli::new(fabric, poisson, given);
            let isotropic = (fabric.name == "none").then(|| moduli.isotropic_shear());
            let shear = shear.or(isotropic).ok_or_else(|| unknown("shear", "shear"))?;
            ElasticityTensor::from_moduli(moduli.warp, moduli.weft, moduli.poisson, shear)?
        };
        let (young, thickness) = (params.number("young"), params.number("thickness"));
        let (elasticity, rigidity) = (elasticity.scaled(young * thickness), rigidity.scaled(young * thickness.powi(3)));
        Ok(Self {
            density: thickness * given("density").or(fabric.density).ok_or_else(|| unknown("weight", "density"))?,
            membrane: Membrane {
                strain,
                elasticity,
                damping_time: params.number("damping-time"),
                compression: params.number("compression"),
                project: params.choice("tangent") == 0,
            },
            bending,
            rigidity,
            friction: (hysteresis > 0.0 && bending != Bending::None).then_some(friction),
            warp: warp_direction(params)?,
        })
    }
}

/// Engineering constants of the sheet.
struct Moduli {
    /// Young's modulus along warp, N/m.
    warp: f64,
    /// Young's modulus along weft, N/m.
    weft: f64,
    /// Contraction of the weft under stretch of the warp.
    poisson: f64,
}

impl Moduli {
    /// The constants of the fabric, with those that are given in their place; the weft is as the warp where only the warp is given.
    fn new(fabric: &Fabric, poisson: Option<f64>, given: impl Fn(&str) -> Option<f64>) -> Self {
        let base = match fabric.membrane {
            MembraneModuli::EqualModuli { young, poisson } => Self { warp: young, weft: young, poisson },
            MembraneModuli::Tensor { c11, c12, c22 } => {
                Self { warp: c11 - c12 * c12 / c22, weft: c22 - c12 * c12 / c11, poisson: c12 / c22 }
            }
        };
        let (warp, weft) = (given("young-warp"), given("young-weft"));
        Self {
            warp: warp.unwrap_or(base.warp),
            weft: weft.or(warp).unwrap_or(base.weft),
            poisson: poisson.unwrap_or(base.poisson),
        }
    }

    /// Shear modulus of an isotropic sheet, N/m, with the geometric means of an orthotropic one (Huber 1923).
    fn isotropic_shear(&self) -> f64 {
        (self.warp * self.weft).sqrt() / (2.0 * (1.0 + self.poisson * (self.weft / self.warp).sqrt()))
    }
}

/// Bending rigidity; `None` where neither the fabric nor the scene gives one. The fabric's bias is used only with its own warp and weft.
fn rigidity(fabric: &Fabric, given: impl Fn(&str) -> Option<f64>) -> Option<Result<Rigidity, Fault>> {
    let (warp, weft) = (given("bending-warp"), given("bending-weft"));
    let fabric_bias = fabric.bending.and_then(|b| b.bias).filter(|_| warp.is_none() && weft.is_none());
    let bias = given("bending-bias").or(fabric_bias);
    let along_warp = warp.or(fabric.bending.map(|b| b.warp)).or(weft)?;
    let along_weft = weft.or(warp).or(fabric.bending.map(|b| b.weft))?;
    Some(Rigidity::new(along_warp, along_weft, bias))
}

/// The parameter `warp`, or x where it is not given.
fn warp_direction(params: &Params<'_>) -> Result<Vec3, Fault> {
    let Some(table) = params.table("warp") else { return Ok(Vec3([1.0, 0.0, 0.0])) };
    let mut rows = table.rows();
    match (rows.next(), rows.next()) {
        (Some(&[x, y, z]), None) if x * x + y * y + z * z > 0.0 => Ok(Vec3([x, y, z])),
        _ => Err(Fault::bad_argument("`warp` needs one row of three numbers that are not all 0")),
    }
}
