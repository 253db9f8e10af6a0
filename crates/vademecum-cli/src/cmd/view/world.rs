//! The page of a world: bodies of an assembly file that move, touch and turn.

use std::path::Path;

use vademecum_assembly::{AssemblyError, AssemblyFile, WorldRunError, WorldScene, world_scene};
use vademecum_build::progress::Listener;

use super::inside::{STYLE, encoded, import_map};
use crate::assets::{evaluator, world};
use crate::failure::Failure;
use crate::html::escaped;

const PAGE: &str = include_str!("../../../assets/page/world.html");

macro_rules! modules {
    ($($name:literal),*) => {
        [$(($name, include_str!(concat!("../../../assets/page/", $name, ".js")))),*]
    };
}

/// The modules of this page.
pub(super) const MODULES: [(&str, &str); 24] = modules!(
    "body",
    "camera",
    "chart",
    "colors",
    "crowd",
    "elements",
    "evaluator",
    "flight",
    "marks",
    "overlay",
    "player",
    "pulling",
    "record",
    "render",
    "ring",
    "ringer",
    "share",
    "skin",
    "sound",
    "stage",
    "striking",
    "vectors",
    "views",
    "world"
);

/// A world that was set up, for its page.
pub(super) struct WorldPage {
    scene: WorldScene,
    title: String,
}

impl WorldPage {
    /// Sets the world of an assembly file up; failures name its file.
    pub fn new(file: &AssemblyFile, path: &Path, listener: &dyn Listener) -> Result<Self, Failure> {
        let scene = world_scene(file, listener).map_err(|error| match error {
            // It names file and line.
            error @ WorldRunError::Assembly(AssemblyError::File(_)) => error.into(),
            error => Failure::from(error).within(path),
        })?;
        let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let title = if scene.title.is_empty() { name } else { scene.title.clone() };
        Ok(Self { scene, title })
    }

    /// The files of the parts with the paths that the served page fetches them from.
    pub fn served(&self) -> Vec<(String, &[u8])> {
        let each = self.scene.files.iter().enumerate();
        each.map(|(i, bytes)| (format!("/part-{i}.vdm"), bytes.as_slice())).collect()
    }

    /// The page, with the files inside or fetched from where they are served.
    pub fn filled(&self, inside: bool) -> String {
        let file = |(i, bytes): (usize, &Vec<u8>)| {
            let (source, text) = if inside {
                (String::new(), encoded(bytes))
            } else {
                (format!("part-{i}.vdm"), String::new())
            };
            format!("<script data-file=\"{i}\" data-src=\"{source}\" type=\"text/plain\">{text}</script>")
        };
        let files: Vec<String> = self.scene.files.iter().enumerate().map(file).collect();
        // An end of a script within a name of a part.
        let plan = serde_json::to_string(&self.scene).expect("numbers and names").replace('<', "\\u003c");
        PAGE.replace("{{title}}", &escaped(&self.title))
            .replace("{{style}}", STYLE)
            .replace("{{modules}}", &import_map(&MODULES))
            .replace("{{wasm}}", &encoded(&world()))
            .replace("{{ringing}}", &encoded(&evaluator()))
            .replace("{{files}}", &files.join("\n"))
            .replace("{{plan}}", &plan)
    }
}
