//! One file per subcommand; none knows another, and nothing is computed here.

pub(crate) mod assemble;
pub(crate) mod bench;
pub(crate) mod build;
pub(crate) mod calibrate;
pub(crate) mod collect;
pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod export;
pub(crate) mod frf;
pub(crate) mod help;
pub(crate) mod info;
pub(crate) mod init;
pub(crate) mod man;
pub(crate) mod mesh;
pub(crate) mod modes;
pub(crate) mod pack;
pub(crate) mod plan;
pub(crate) mod report;
pub(crate) mod run;
pub(crate) mod schema;
pub(crate) mod sensors;
pub(crate) mod statics;
pub(crate) mod strip;
pub(crate) mod unpack;
pub(crate) mod verify;
pub(crate) mod view;
