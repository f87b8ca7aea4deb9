//! Levels, ids, parents and children, and the surface points in cells.

use super::host::{Host, WHOLE};
use super::shapes::{Mesh, cuboid, sheet, sphere};
use crate::OctreeGrid;
use pliant_mesh::testing::models;
use pliant_plugin_api::Grid;
use pliant_plugin_api::abi::{CELL_EMPTY, CELL_INSIDE, CELL_SURFACE, Cell, NO_CELL, STRUCTURAL};

/// All cells of a level.
fn all_cells(grid: &OctreeGrid, level: u32) -> Vec<Cell> {
    let m = u64::from(grid.level(level).unwrap().cells_per_axis);
    (0..m * m * m).map(|id| grid.cell(level, id).unwrap()).collect()
}

#[test]
fn parents_and_children_agree_at_every_level() {
    let grid = sphere(0.3, 3).and(cuboid([0.2; 3])).grid(6);
    for level in 1..=6 {
        let info = grid.level(level).unwrap();
        let cells = all_cells(&grid, level);
        let count = |state| cells.iter().filter(|c| c.state == state).count() as u64;
        assert_eq!((count(CELL_SURFACE), count(CELL_INSIDE)), (info.surface_cells, info.inside_cells));
        for (id, cell) in cells.iter().enumerate() {
            let m = u64::from(info.cells_per_axis);
            let [i, j, k] = cell.index.map(u64::from);
            assert_eq!((cell.id, cell.id), (id as u64, i + m * (j + m * k)), "ids are linear, x fastest");
            for axis in 0..3 {
                let low = info.origin[axis] + info.edge * f64::from(cell.index[axis]);
                assert!((cell.reference[axis] - low).abs() < 1e-15 && cell.edge == info.edge);
                assert!((cell.centre[axis] - low - 0.5 * info.edge).abs() < 1e-15);
            }
            if level > 1 {
                let parent = cell.index.map(|i| i / 2);
                let up = grid.locate(level - 1, cell.centre).unwrap().cell;
                assert_eq!(grid.cell(level - 1, up).unwrap().index, parent);
                let has_parent = grid.cell(level - 1, up).unwrap().state != CELL_EMPTY;
                assert_eq!(cell.parent, if has_parent { up } else { NO_CELL });
                assert!(has_parent || cell.state == CELL_EMPTY, "an occupied cell has a parent");
            } else {
                assert_eq!(cell.parent, NO_CELL);
            }
            if level == 6 {
                assert_eq!(cell.children, [NO_CELL; 8]);
                continue;
            }
            let children: Vec<Cell> = (0..8_u32)
                .map(|c| {
                    let centre =
                        [0, 1, 2].map(|axis| cell.centre[axis] + info.edge * (f64::from(c >> axis & 1) - 0.5) / 2.0);
                    grid.cell(level + 1, grid.locate(level + 1, centre).unwrap().cell).unwrap()
                })
                .collect();
            let ids = children.iter().map(|c| if c.state == CELL_EMPTY { NO_CELL } else { c.id });
            assert_eq!(
                cell.children.to_vec(),
                ids.collect::<Vec<_>>(),
                "child c lies in the direction of the bits of c"
            );
            let same = children.iter().all(|c| c.state == children[0].state);
            assert_eq!(cell.state, if same { children[0].state } else { CELL_SURFACE });
        }
    }
}

#[test]
fn one_list_of_points_serves_every_level() {
    let mesh = sphere(0.3, 4).moved([5.0, -3.0, 0.1]);
    let grid = mesh.grid(7);
    for level in 1..=7 {
        let points = grid.points(level).unwrap();
        let mut seen = vec![0; mesh.points.len()];
        for cell in all_cells(&grid, level) {
            let range = cell.point_begin..cell.point_end;
            assert!(cell.state != CELL_EMPTY || range.is_empty(), "an empty cell has no points");
            for &point in &points[range] {
                seen[point as usize] += 1;
                assert_eq!(grid.locate(level, mesh.points[point as usize]).unwrap().cell, cell.id);
            }
        }
        assert!(seen.iter().all(|&times| times == 1), "every point is in one cell of level {level}");
    }
}

#[test]
fn nodes_are_the_corners_of_occupied_cells() {
    let grid = sheet(7, |x, y| x * y).grid(7);
    for level in 1..=7 {
        let info = grid.level(level).unwrap();
        let n = info.cells_per_axis as usize + 1;
        let mut nodes = vec![false; n * n * n];
        for cell in all_cells(&grid, level).iter().filter(|c| c.state != CELL_EMPTY) {
            let [i, j, k] = cell.index.map(|i| i as usize);
            (0..8).for_each(|c| nodes[i + (c & 1) + n * (j + (c >> 1 & 1) + n * (k + (c >> 2)))] = true);
        }
        assert_eq!(info.nodes, nodes.iter().filter(|n| **n).count() as u64);
    }
}

#[test]
fn points_on_the_greatest_faces_belong_to_the_last_cells() {
    let grid = cuboid([1.0, 0.7, 1.0]).moved([10.0, 0.0, -4.0]).grid(5);
    let locate = |point: [f64; 3]| grid.locate(5, point).unwrap();
    let index = |point| grid.cell(5, locate(point).cell).unwrap().index;
    assert_eq!(index([11.0, 0.35, -3.0]), [15, 8, 15]);
    assert_eq!(index([10.0, 0.35, -4.0]), [0, 8, 0]);
    assert!(locate([11.0, 0.35, -3.0]).local.iter().all(|p| (0.0..=1.0).contains(p)));
    let outside = locate([99.0, -99.0, -3.5]);
    assert_eq!(grid.cell(5, outside.cell).unwrap().index[..2], [15, 0], "clamped to the grid");
    assert_eq!(outside.local[..2], [1.0, 0.0]);
}

#[test]
fn a_flat_sheet_touches_the_two_layers_around_it() {
    let mesh = sheet(9, |_, _| 0.0);
    let grid = mesh.grid(6);
    let info = grid.level(6).unwrap();
    assert_eq!((info.surface_cells, info.inside_cells), (2 * 32 * 32, 0));
    assert_eq!((info.origin[2] + 0.5 * 32.0 * info.edge).abs(), 0.0, "the surface is in the middle of the box");
    let count = mesh.points.len();
    let (mut cells, mut weights) = (vec![0; count], vec![[0.0; 8]; count]);
    grid.weights(6, &mesh.points, &mut cells, &mut weights).unwrap();
}

#[test]
fn a_single_triangle_at_the_root_level() {
    let mesh = Mesh { points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], triangles: vec![[0, 1, 2]] };
    let grid = mesh.grid(1);
    let info = grid.level(1).unwrap();
    assert_eq!((info.cells_per_axis, info.surface_cells, info.inside_cells, info.nodes), (1, 1, 0, 8));
    assert_eq!(grid.points(1).unwrap(), [0, 1, 2]);
    assert_eq!(mesh.grid(8).level(8).unwrap().inside_cells, 0);
}

#[test]
fn level_nine_of_a_small_sphere() {
    let mesh = sphere(1e-4, 2).moved([0.2, 0.0, 0.0]);
    let grid = mesh.grid(9);
    let info = grid.level(9).unwrap();
    assert_eq!(info.cells_per_axis, 256);
    let cells = (info.surface_cells + info.inside_cells) as f64;
    // The octahedron subdivided twice has 0.85 of the volume of its sphere; surface cells add a layer half a cell thick.
    let volume = cells * (info.edge / 1e-4).powi(3) / (4.0 / 3.0 * std::f64::consts::PI);
    assert!((0.9..0.95).contains(&volume), "{volume}");
    let whole = Host::with(&mesh, 9).region(9, STRUCTURAL, &[WHOLE], &[]).unwrap();
    assert_eq!((whole.cell_id.len() as f64, whole.node_id.len() as u64), (cells, info.nodes));
}

#[test]
fn points_without_triangles_are_left_out() {
    let mut mesh = sphere(1.0, 2);
    let used = mesh.points.len();
    mesh.points.push([77.0, 0.0, 0.0]);
    let grid = mesh.grid(3);
    assert_eq!(grid.points(3).unwrap().len(), used);
    assert!(grid.level(1).unwrap().edge < 2.1);
}

#[test]
fn the_same_surface_gives_the_same_grid() {
    for model in models(6, 1) {
        let mesh = Mesh::of(&model.document());
        let (a, b) = (mesh.grid(6), mesh.grid(6));
        assert_eq!((all_cells(&a, 6), a.points(6)), (all_cells(&b, 6), b.points(6)), "{}", model.name);
    }
}
