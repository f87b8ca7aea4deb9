//! What a run is given and what it leaves: models, scenes, the command line, files and messages.

mod atomic;
mod bad_obj;
mod bad_scene;
mod cli;
mod cli_models;
mod cloth_files;
mod file_faults;
mod model_defects;
mod plan_json;
mod results;
mod run_paths;
mod scenes;
mod terminal;
mod trust;
mod warnings;
