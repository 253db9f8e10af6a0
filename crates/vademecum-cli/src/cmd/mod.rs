//! One file per subcommand; none knows another, and nothing is computed here.

pub mod bench;
pub mod build;
pub mod collect;
pub mod completions;
pub mod demo;
pub mod export;
pub mod frf;
pub mod help;
pub mod info;
pub mod init;
pub mod man;
pub mod mesh;
pub mod modes;
pub mod pack;
pub mod plan;
pub mod report;
pub mod run;
pub mod schema;
pub mod strip;
pub mod unpack;
pub mod verify;
pub mod view;
