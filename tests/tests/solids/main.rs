//! Solids in grids and of tetrahedra: closed forms, levels and surfaces.

mod level_choice;
mod quadratic_tets;
mod rounded;
mod smooth_surface;
mod solids;
mod subdivide;
mod tet_meshes;
mod tetrahedra;
mod vertex_order;
