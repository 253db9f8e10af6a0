//! The program as users call it: commands, problems, scenarios, messages, pages.

mod assembly;
mod attachments;
mod bench;
mod calculix;
mod calibrate;
mod commands;
mod craig_bampton;
mod deck_materials;
mod decks;
mod element_kinds;
mod export;
mod first_hour;
mod first_use;
mod frf;
mod heat;
mod hostile_problems;
mod indices;
mod init;
#[cfg(target_os = "linux")]
mod inputs;
mod json_page;
mod mesh_error;
mod modal_test;
#[cfg(unix)]
mod outputs;
mod page_commands;
mod pages;
mod prestress;
mod problem_files;
mod program_files;
mod run_folder;
mod scenarios;
mod schema;
mod sets_of_bodies;
#[cfg(unix)]
mod soak;
mod state_space;
mod surfaces;
mod sweep;
mod tutorial;
