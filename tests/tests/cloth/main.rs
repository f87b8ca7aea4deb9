//! Sheets: closed forms, bending, cuts and extremes.

mod cloth;
mod cloth_cutting;
mod cloth_hysteresis;
mod extreme_cloth;
mod extreme_presses;
mod fingertips;
mod implicit_cloth;
mod laplacian;
mod laplacian_cantilever;
mod laplacian_matrix;
mod laplacian_settings;
mod tip_impacts;
mod torn_sheets;
