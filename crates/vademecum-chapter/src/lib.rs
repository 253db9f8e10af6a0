//! The structure of chapter 5 as the chapter prints it, built, certified and stepped: a baseline to compare
//! with.
//!
//! A problem asks for it with `representation = "chapter"` (or `"canonical"`, the older word for the same).
//! [`build`] makes its file, and hands every other problem to [`vademecum_build::pipeline::build`].
//! [`ChapterScene`] binds such a file and steps it; the evaluator does not know it.
//!
//! ```
//! use vademecum_chapter::{ChapterLoads, ChapterScene, ChapterState};
//! use vademecum_eval::format::{Chapter, File};
//! use vademecum_eval::{Contact, Field, Place, SceneOptions};
//!
//! /// Displacement \[m\] of a load position after `steps` steps under 1 N in the direction of the file.
//! fn push(bytes: &[u8], steps: usize) -> Result<[f64; 3], Box<dyn std::error::Error>> {
//!     let file = File::parse(bytes)?;
//!     let scene = ChapterScene::bind(&file, &SceneOptions::default())?;
//!     let (mut state, mut loads) = (ChapterState::new(&scene), ChapterLoads::new(&scene));
//!     let chapter = Chapter::read(&file)?.ok_or("another structure")?;
//!     let (node, direction) = (chapter.positions().next(), chapter.direction());
//!     let place = Place::node(node.ok_or("no load position")?);
//!     loads.add_contact(&scene, &Contact::new(place, direction.ok_or("any direction")?))?;
//!     for _ in 0..steps {
//!         scene.step(&mut state, &loads)?;
//!     }
//!     Ok(scene.point(&state, &place, Field::Displacement)?)
//! }
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! #     let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/canonical.vdm");
//! #     assert!(push(&std::fs::read(golden)?, 10)?[2] > 0.0);
//! #     Ok(())
//! # }
//! ```

mod certificate;
mod error;
mod map;
mod online;
mod ranges;
mod report;
mod road;
mod sections;
pub mod separation;

pub use certificate::{ChapterCertificate, ChapterUnseen, certify_chapter};
pub use error::ChapterError;
pub use map::{ChapterMap, ChapterSetting, MapPart, StageMap};
pub use online::{
    ChapterBindError, ChapterLoadError, ChapterLoads, ChapterScene, ChapterState, ChapterStepError,
};
pub use report::{report_of, report_of_file};
pub use road::build;
pub use sections::sections;
