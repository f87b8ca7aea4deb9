//! Parameters: the values of a fabric, values given beside a fabric, and incomplete values.

use pliant_cloth::Cloth;
use pliant_plugin_api::kit::{self, Body};

/// Warp modulus (N/m), weft modulus (N/m) and mass (kg) of a square metre with these parameters: the moduli from the energies of a sheet
/// that is stretched by 1 % along one axis. Or the reason of the fault.
fn measure(numbers: &[(&str, f64)]) -> Result<[f64; 3], String> {
    let unbent = [numbers, &[("bending", 2.0)]].concat();
    let material: Cloth = kit::material(&unbent).map_err(|fault| fault.reason.into_owned())?;
    let sheet = kit::sheet([1, 1], 1.0);
    let mut body = Body::new(&material, sheet.rest.clone(), |r| sheet.elements(r.kind)).unwrap();
    let mut modulus = |stretch: [f64; 2]| {
        body.x = sheet.rest.iter().map(|x| [stretch[0] * x[0], stretch[1] * x[1], 0.0]).collect();
        // The energy of 1 m^2 is C strain^2 / 2.
        2e4 * body.energy(&material).unwrap()
    };
    let (warp, weft) = (modulus([1.01, 1.0]), modulus([1.0, 1.01]));
    Ok([warp, weft, body.mass(&material).unwrap().iter().sum()])
}

fn assert_close(measured: [f64; 3], expected: [f64; 3]) {
    for i in 0..3 {
        assert!((measured[i] / expected[i] - 1.0).abs() < 1e-9, "{measured:?} {expected:?}");
    }
}

#[test]
fn a_fabric_sets_moduli_and_density() {
    assert_close(measure(&[("fabric", 7.0)]).unwrap(), [410.7, 2027.8, 0.324]);
    assert_close(measure(&[("fabric", 5.0)]).unwrap(), [62.3, 88.1, 0.284]);
    // The default is isotropic with Poisson's ratio 0.3: C11 = E / (1 - nu^2).
    let c11 = 500.0 / (1.0 - 0.09);
    assert_close(measure(&[]).unwrap(), [c11, c11, 0.15]);
}

#[test]
fn parameters_override_the_fabric() {
    assert_close(measure(&[("fabric", 7.0), ("density", 0.5)]).unwrap(), [410.7, 2027.8, 0.5]);
    let own = [("fabric", 7.0), ("young-warp", 100.0), ("young-weft", 50.0), ("poisson", 0.0)];
    assert_close(measure(&own).unwrap(), [100.0, 50.0, 0.324]);
    let own = [("fabric", 7.0), ("c11", 90.0), ("c12", 5.0), ("c22", 40.0)];
    assert_close(measure(&own).unwrap(), [90.0, 40.0, 0.324]);
    assert_close(measure(&[("young-warp", 80.0), ("poisson", 0.0)]).unwrap(), [80.0, 80.0, 0.15]);
}

#[test]
fn values_that_were_not_measured_must_be_given() {
    let reason = |numbers: &[(&str, f64)]| measure(numbers).unwrap_err();
    assert!(reason(&[("fabric", 11.0)]).contains("give `density`"));
    assert!(measure(&[("fabric", 11.0), ("density", 0.3)]).is_ok());
    assert!(reason(&[("fabric", 18.0)]).contains("give `shear`"));
    let wool = [("fabric", 18.0), ("shear", 30.0)];
    assert!(measure(&wool).is_ok());
    let with_bending: Result<Cloth, _> = kit::material(&wool);
    assert!(with_bending.map(drop).unwrap_err().reason.contains("give `bending-warp`"));
    assert!(kit::material::<Cloth>(&[&wool[..], &[("bending-warp", 15e-6)]].concat()).is_ok());
    assert!(reason(&[("c11", 100.0), ("c22", 100.0)]).contains("shear"));
    assert!(reason(&[("c11", 100.0), ("shear", 10.0)]).contains("C22 0"));
}

#[test]
fn completely_measured_fabrics_need_no_other_parameter() {
    for fabric in 0..=10 {
        kit::material::<Cloth>(&[("fabric", f64::from(fabric))]).map(drop).unwrap();
    }
}
