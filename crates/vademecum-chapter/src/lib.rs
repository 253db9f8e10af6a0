//! The structure of chapter 5 as the chapter prints it, built and certified: a baseline to compare with.
//!
//! A problem asks for it with `representation = "canonical"`. [`build`] makes its file, and hands every other
//! problem to [`vademecum_build::pipeline::build`]. Files of it are stepped by the evaluator's feature
//! `chapter`.

mod certificate;
mod error;
mod map;
mod ranges;
mod report;
mod road;
mod sections;
pub mod separation;

pub use certificate::{ChapterCertificate, ChapterUnseen, certify_chapter};
pub use error::ChapterError;
pub use map::{ChapterMap, ChapterSetting, MapPart, StageMap};
pub use report::{report_of, report_of_file};
pub use road::build;
pub use sections::sections;
