//! The parameters, and what they come to: a fabric's numbers, with what is given in their place.

use crate::bending::Rigidity;
use crate::fabric::{CHOICES, FABRICS, Fabric, OWN, Stretch};
use crate::file::FabricFile;
use crate::frame::Rule;
use crate::membrane::{Membrane, Strain};
use crate::slip::Slip;
use crate::tensor::Tensor;
use pliant_plugin_api::{Fault, Param, Params};

/// Range of stiffnesses, N/m; 0 is what is not given.
const STIFFNESS: (f64, f64) = (0.0, 1e12);
/// Range of bending rigidities, N m; 0 is what is not given.
const BENDING: (f64, f64) = (0.0, 1e3);
/// Hysteresis that is the fabric's.
const NOT_OURS: f64 = -1.0;
/// Poisson's ratio that is not given.
const NO_RATIO: f64 = -1.0;

pub(crate) const PARAMS: &[Param] = &[
    Param::choice(c"fabric", CHOICES, c"measured numbers for all that is not given; none: a light cloth's"),
    Param::path(c"fabric-file", c"instead of `fabric`: a TOML file with numbers of your own, and their `source`"),
    Param::number(c"density", c"kg/m^2", (0.0, 1e4), 0.0, c"mass per area; 0: the fabric's"),
    Param::number(c"young-warp", c"N/m", STIFFNESS, 0.0, c"Young's modulus along warp; 0: the fabric's"),
    Param::number(c"young-weft", c"N/m", STIFFNESS, 0.0, c"Young's modulus along weft; 0: as warp, else the fabric's"),
    Param::number(
        c"poisson",
        c"1",
        (NO_RATIO, 10.0),
        NO_RATIO,
        c"how much the weft shortens when the warp is stretched; -1: the fabric's",
    ),
    Param::number(c"shear", c"N/m", STIFFNESS, 0.0, c"shear stiffness; 0: the fabric's, with none as isotropic"),
    Param::number(c"c11", c"N/m", STIFFNESS, 0.0, c"with c22 and c12, in place of moduli and ratio; 0: not given"),
    Param::number(c"c12", c"N/m", (-1e12, 1e12), 0.0, c"see c11"),
    Param::number(c"c22", c"N/m", STIFFNESS, 0.0, c"see c11"),
    Param::number(
        c"compression",
        c"1",
        (0.0, 1.0),
        1.0,
        c"share of compressive stress that stays; less where the sheet wrinkles below the mesh",
    ),
    Param::number(c"damping-time", c"s", (0.0, 10.0), 1e-4, c"viscosity over stiffness, in the plane and of hinges"),
    Param::choice(c"frame", c"polar|edge|green", c"strain: in the polar frame, in the first edge's, or Green's"),
    Param::choice(c"tangent", c"projected|exact", c"the membrane's matrix: without its negative part, or exact"),
    Param::choice(
        c"bending",
        c"coupled|hinge|none|projected-laplacian",
        c"edges act on each other and any mesh is right, edges alone, none, or triangles against vertex normals (flat sheets)",
    ),
    Param::number(c"bending-warp", c"N m", BENDING, 0.0, c"rigidity against curvature along warp; 0: the fabric's"),
    Param::number(c"bending-weft", c"N m", BENDING, 0.0, c"the same along weft; 0: as warp, else the fabric's"),
    Param::number(
        c"bending-bias",
        c"N m",
        BENDING,
        0.0,
        c"the same at 45 degrees; 0: from the others, or the fabric's",
    ),
    Param::number(
        c"bending-hysteresis",
        c"N",
        (NOT_OURS, 1e3),
        0.0,
        c"width of the moment's loop between bending to and fro, 2HB; 0: none, -1: the fabric's",
    ),
    Param::number(
        c"slip-curvature",
        c"1/m",
        (1e-3, 1e6),
        10.0,
        c"how far yarns bend before they slide, with bending-hysteresis; the default is an assumption",
    ),
    Param::table(c"warp", c"x|y|z", c"where the warp points in space, for bending = hinge: one row; none: along x"),
];

/// How edges bend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bending {
    Coupled,
    Hinge,
    None,
    Laplacian,
}

/// The parameters, resolved.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// kg/m^2
    pub(crate) density: f64,
    pub(crate) membrane: Membrane,
    pub(crate) bending: Bending,
    pub(crate) rigidity: Rigidity,
    pub(crate) slip: Option<Slip>,
    pub(crate) warp: [f64; 3],
}

impl Settings {
    pub(crate) fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let file = params.text("fabric-file").map(FabricFile::read).transpose()?;
        let fabric = match (&file, params.choice("fabric")) {
            (None, choice) => &FABRICS[choice],
            (Some(_), 0) => &OWN,
            _ => return Err(Fault::bad_argument("`fabric` and `fabric-file`; allowed is one of them")),
        };
        let of_file = |key: &str| file.as_ref().and_then(|file| file.number(key));
        let given = |key: &str| Some(params.number(key)).filter(|value| *value > 0.0).or(of_file(key));
        let name = file.as_ref().map_or(fabric.name, |file| &file.path);
        let unknown = |what: &str, key: &str| {
            Fault::bad_argument(format!("the {what} of fabric `{name}` is not known: give `{key}`"))
        };
        let strain = [Strain::Frame(Rule::Polar), Strain::Frame(Rule::Edge), Strain::Green][params.choice("frame")];
        let bending = [Bending::Coupled, Bending::Hinge, Bending::None, Bending::Laplacian][params.choice("bending")];
        let rigidity = match (bending, rigidity(fabric, given)) {
            (_, Some(rigidity)) => rigidity?,
            (Bending::None, None) => Rigidity { warp: 1.0, weft: 1.0, twist: 1.0 },
            (_, None) => return Err(unknown("bending", "bending-warp")),
        };
        let loops = match params.number("bending-hysteresis") {
            width if width >= 0.0 => width,
            _ => of_file("bending-hysteresis")
                .or(fabric.hysteresis)
                .ok_or_else(|| unknown("hysteresis", "bending-hysteresis"))?,
        };
        if bending == Bending::Laplacian {
            let refused = [
                (loops > 0.0, "bending-hysteresis", "its triangles have no edges that could rub"),
                (params.number("bending-bias") > 0.0, "bending-bias", "it knows warp and weft alone"),
            ];
            if let Some((_, key, why)) = refused.iter().find(|(given, ..)| *given) {
                let text = format!("`{key}` with bending = projected-laplacian: {why}; allowed is coupled or hinge");
                return Err(Fault::bad_argument(text));
            }
        }
        let slip = Slip { moment: 0.5 * loops, curvature: params.number("slip-curvature") };
        if params.choice("tangent") == 1 && params.number("compression") < 1.0 {
            return Err(Fault::bad_argument("tangent = exact wants compression = 1"));
        }
        let shear = given("shear").or(fabric.shear);
        let tensor = if given("c11").is_some() || given("c22").is_some() {
            let shear = shear.ok_or_else(|| {
                Fault::bad_argument("c11, c12 and c22 leave the shear open: give `shear`, or a fabric that has it")
            })?;
            let c12 = Some(params.number("c12")).filter(|c| *c != 0.0).or(of_file("c12"));
            Tensor::new(given("c11").unwrap_or(0.0), c12.unwrap_or(0.0), given("c22").unwrap_or(0.0), shear)?
        } else {
            if file.is_some() && given("young-warp").is_none() {
                return Err(unknown("stretch", "young-warp"));
            }
            let poisson = Some(params.number("poisson")).filter(|ratio| *ratio > NO_RATIO).or(of_file("poisson"));
            let (warp, weft, ratio) = moduli(fabric, poisson, given);
            let isotropic = (fabric.name == "none").then(|| isotropic(warp, weft, ratio));
            let shear = shear.or(isotropic).ok_or_else(|| unknown("shear", "shear"))?;
            Tensor::from_moduli(warp, weft, ratio, shear)?
        };
        Ok(Self {
            density: given("density").or(fabric.density).ok_or_else(|| unknown("weight", "density"))?,
            membrane: Membrane {
                strain,
                tensor,
                damping: params.number("damping-time"),
                compression: params.number("compression"),
                project: params.choice("tangent") == 0,
            },
            bending,
            rigidity,
            slip: (loops > 0.0 && bending != Bending::None).then_some(slip),
            warp: direction(params)?,
        })
    }
}

/// Young's moduli, N/m, and Poisson's ratio.
fn moduli(fabric: &Fabric, poisson: Option<f64>, given: impl Fn(&str) -> Option<f64>) -> (f64, f64, f64) {
    let (warp, weft, ratio) = match fabric.membrane {
        Stretch::Moduli(young, ratio) => (young, young, ratio),
        Stretch::Tensor(c11, c12, c22) => (c11 - c12 * c12 / c22, c22 - c12 * c12 / c11, c12 / c22),
    };
    let (w, f) = (given("young-warp"), given("young-weft"));
    (w.unwrap_or(warp), f.or(w).unwrap_or(weft), poisson.unwrap_or(ratio))
}

/// N/m, the shear an isotropic sheet has, with the means of an orthotropic one (Huber 1923).
fn isotropic(warp: f64, weft: f64, ratio: f64) -> f64 {
    (warp * weft).sqrt() / (2.0 * (1.0 + ratio * (weft / warp).sqrt()))
}

/// `None` where the fabric has none and none is given. The fabric's bias goes with its own warp and weft only.
fn rigidity(fabric: &Fabric, given: impl Fn(&str) -> Option<f64>) -> Option<Result<Rigidity, Fault>> {
    let (warp, weft) = (given("bending-warp"), given("bending-weft"));
    let theirs = fabric.bending.map(|(_, bias, _)| bias).filter(|_| warp.is_none() && weft.is_none());
    let bias = given("bending-bias").or(theirs.flatten());
    let first = warp.or(fabric.bending.map(|b| b.0)).or(weft)?;
    let second = weft.or(warp).or(fabric.bending.map(|b| b.2))?;
    Some(Rigidity::new(first, second, bias))
}

fn direction(params: &Params<'_>) -> Result<[f64; 3], Fault> {
    let Some(table) = params.table("warp") else { return Ok([1.0, 0.0, 0.0]) };
    let mut rows = table.rows();
    match (rows.next(), rows.next()) {
        (Some(&[x, y, z]), None) if x * x + y * y + z * z > 0.0 => Ok([x, y, z]),
        _ => Err(Fault::bad_argument("`warp` is one row of three numbers that are not all 0")),
    }
}
