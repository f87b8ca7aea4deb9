//! The C table: buffers that are too small, and a failing build.

use super::host::{ALL, Host, Region, WHOLE};
use super::shapes::{cuboid, sphere};
use pliant_plugin_api::abi::{Ball, Status};

#[test]
fn too_small_buffers_are_counted_and_filled_as_far_as_they_reach() {
    let host = Host::with(&sphere(1.0, 3), 4);
    let balls = [Ball { centre: [1.0, 0.0, 0.0], radius: 0.4 }];
    let full = host.region(4, ALL, &balls, &[]).unwrap();
    let needed = [full.node_id.len(), full.cell_id.len(), full.link_nodes.len()];
    assert!(needed.iter().all(|&n| n > 10));
    for short in 0..4 {
        let mut room = needed;
        if short < 3 {
            room[short] -= 7;
        }
        let mut region = Region::default();
        region.resize(room[0], room[1], room[2]);
        let (status, counts) = host.fill(4, ALL, &balls, &[], &mut region);
        assert_eq!(counts, needed);
        assert_eq!(status, if short < 3 { Status::TOO_SMALL } else { Status::OK });
        assert_eq!(region.node_id, full.node_id[..room[0]], "what fits is written");
        assert_eq!(region.cell_corners, full.cell_corners[..room[1]]);
        assert_eq!(region.link_nodes, full.link_nodes[..room[2]]);
    }
}

#[test]
fn a_failing_build_keeps_the_previous_one() {
    let host = Host::with(&cuboid([1.0; 3]), 3);
    let before = host.region(3, ALL, &[WHOLE], &[]).unwrap();
    let mut broken = cuboid([2.0; 3]);
    broken.points[5][1] = f64::NAN;
    let fault = host.build(&broken.view(), 4).unwrap_err();
    assert_eq!(fault.status, Status::BAD_ARGUMENT);
    assert_eq!(fault.reason, "point 5 is not finite: [2.0, NaN, 2.0]");
    assert_eq!(host.region(3, ALL, &[WHOLE], &[]).unwrap(), before);
    assert!(host.region(4, ALL, &[WHOLE], &[]).is_err());
}
