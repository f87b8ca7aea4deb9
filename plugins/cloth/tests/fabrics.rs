//! Parameters: what a fabric gives, what is given in its place, and what is refused.

use pliant_cloth::Cloth;
use pliant_plugin_api::kit::{self, Body};

/// Warp and weft energy of a square metre stretched by 1 % each way alone, mass, of parameters; or what is wrong.
fn measure(numbers: &[(&str, f64)]) -> Result<[f64; 3], String> {
    let still = [numbers, &[("bending", 2.0)]].concat();
    let material: Cloth = kit::material(&still).map_err(|fault| fault.reason.into_owned())?;
    let sheet = kit::sheet([1, 1], 1.0);
    let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    let mut energy = |f: [f64; 2]| {
        body.x = sheet.rest.iter().map(|x| [f[0] * x[0], f[1] * x[1], 0.0]).collect();
        2e4 * body.energy(&material).unwrap()
    };
    let (warp, weft) = (energy([1.01, 1.0]), energy([1.0, 1.01]));
    Ok([warp, weft, body.mass(&material).unwrap().iter().sum()])
}

fn assert_close(found: [f64; 3], wanted: [f64; 3]) {
    for i in 0..3 {
        assert!((found[i] / wanted[i] - 1.0).abs() < 1e-9, "{found:?} {wanted:?}");
    }
}

#[test]
fn a_fabric_gives_its_numbers() {
    assert_close(measure(&[("fabric", 7.0)]).unwrap(), [410.7, 2027.8, 0.324]);
    assert_close(measure(&[("fabric", 5.0)]).unwrap(), [62.3, 88.1, 0.284]);
    let share = 1.0 / (1.0 - 0.09);
    assert_close(measure(&[]).unwrap(), [500.0 * share, 500.0 * share, 0.15]);
}

#[test]
fn what_is_given_goes_before_the_fabric() {
    assert_close(measure(&[("fabric", 7.0), ("density", 0.5)]).unwrap(), [410.7, 2027.8, 0.5]);
    let own = [("fabric", 7.0), ("young-warp", 100.0), ("young-weft", 50.0), ("poisson", 0.0)];
    assert_close(measure(&own).unwrap(), [100.0, 50.0, 0.324]);
    let own = [("fabric", 7.0), ("c11", 90.0), ("c12", 5.0), ("c22", 40.0)];
    assert_close(measure(&own).unwrap(), [90.0, 40.0, 0.324]);
    assert_close(measure(&[("young-warp", 80.0), ("poisson", 0.0)]).unwrap(), [80.0, 80.0, 0.15]);
}

#[test]
fn what_is_not_known_has_to_be_given() {
    let named = |numbers: &[(&str, f64)]| measure(numbers).unwrap_err();
    assert!(named(&[("fabric", 11.0)]).contains("give `density`"));
    assert!(measure(&[("fabric", 11.0), ("density", 0.3)]).is_ok());
    assert!(named(&[("fabric", 18.0)]).contains("give `shear`"));
    let wool = [("fabric", 18.0), ("shear", 30.0)];
    assert!(measure(&wool).is_ok());
    let bent: Result<Cloth, _> = kit::material(&wool);
    assert!(bent.map(drop).unwrap_err().reason.contains("give `bending-warp`"));
    assert!(kit::material::<Cloth>(&[&wool[..], &[("bending-warp", 15e-6)]].concat()).is_ok());
    assert!(named(&[("c11", 100.0), ("c22", 100.0)]).contains("shear"));
    assert!(named(&[("c11", 100.0), ("shear", 10.0)]).contains("C22 0"));
}

#[test]
fn every_measured_fabric_with_all_numbers_opens_alone() {
    for fabric in 0..=10 {
        kit::material::<Cloth>(&[("fabric", f64::from(fabric))]).map(drop).unwrap();
    }
}
