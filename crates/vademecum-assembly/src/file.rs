//! The assembly file: parts, and the joints between them (normative: `formats/assembly-1.md`).

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Deserialize;
use vademecum_build::input::toml_file::{self, TomlError};

/// The ground, in place of a port of a joint.
pub const GROUND: &str = "ground";

/// Largest distance of a quaternion from unit length.
const UNIT: f64 = 1e-6;

/// Largest size of a coordinate, a stiffness or a time.
const LARGEST: f64 = 1e30;

/// Parts, and the joints between them.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AssemblyFile {
    /// Version of this format: 1.
    pub format: u32,
    /// A line for people.
    #[serde(default)]
    pub title: String,
    /// Step of the joined body \[s\]; absent: a round number, with at least 40 steps in its first period.
    pub step: Option<f64>,
    /// Bodies.
    #[serde(rename = "part")]
    pub parts: Vec<PartEntry>,
    /// Joints between ports.
    #[serde(rename = "joint", default)]
    pub joints: Vec<JointEntry>,
    /// The text this was read from.
    #[serde(skip)]
    pub text: String,
    /// The folder that relative paths start from.
    #[serde(skip)]
    pub folder: PathBuf,
    /// The name used in messages.
    #[serde(skip)]
    pub path: String,
}

/// A body of an assembly.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartEntry {
    /// Its name.
    pub name: String,
    /// Its vademecum file; a relative path starts from the folder of the assembly file.
    pub file: PathBuf,
    /// Mesh hash of the file, as `vademecum info` prints it; another file is refused.
    pub hash: Option<String>,
    /// Place of the origin of its coordinates \[m\].
    #[serde(default)]
    pub position: [f64; 3],
    /// Its rotation as a unit quaternion, real part first.
    #[serde(default = "unturned")]
    pub rotation: [f64; 4],
}

fn unturned() -> [f64; 4] {
    [1.0, 0.0, 0.0, 0.0]
}

/// A joint between two ports, or a port and the ground.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointEntry {
    /// Its name; absent: its kind with its number.
    pub name: Option<String>,
    /// Its kind.
    pub kind: JointKind,
    /// The ports it joins, `part.port` each; the second may be `ground`.
    pub between: [String; 2],
    /// Stiffness of a bushing or a spring \[N/m, N m\].
    pub stiffness: Option<Vec<f64>>,
    /// Largest distance between the ports \[m\]; absent: a thousandth of their size.
    pub distance: Option<f64>,
}

/// Kind of a joint.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, JsonSchema, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum JointKind {
    /// All motions.
    Weld,
    /// Springs along, and of frames about, three axes.
    Bushing,
    /// A spring along the line between the origins of two frames.
    Spring,
    /// All motions but the rotation about the third axis of the first frame; small angles.
    Hinge,
    /// The displacement; small angles.
    Ball,
    /// All motions but the displacement along the third axis of the first frame; small angles.
    Slider,
}

impl JointKind {
    /// As an assembly file has it.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Weld => "weld",
            Self::Bushing => "bushing",
            Self::Spring => "spring",
            Self::Hinge => "hinge",
            Self::Ball => "ball",
            Self::Slider => "slider",
        }
    }
}

impl JointEntry {
    /// Its name, or its kind with its number.
    pub(crate) fn name(&self, index: usize) -> String {
        self.name.clone().unwrap_or_else(|| format!("{}{}", self.kind.word(), index + 1))
    }
}

impl AssemblyFile {
    /// Reads and checks an assembly file.
    ///
    /// # Errors
    /// [`TomlError`]: the file cannot be read, is no assembly, or has a value that none can have.
    pub fn read(path: &Path) -> Result<Self, TomlError> {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Self::parse(&toml_file::read(path)?, &path.display().to_string(), folder)
    }

    /// Reads and checks an assembly from its text; relative paths start from `folder`, messages name `path`.
    ///
    /// # Errors
    /// [`TomlError`], as for [`AssemblyFile::read`].
    pub fn parse(text: &str, path: &str, folder: PathBuf) -> Result<Self, TomlError> {
        let file: Self = toml_file::parse(text, path)?;
        let file = Self { text: text.into(), folder, path: path.into(), ..file };
        file.check()?;
        Ok(file)
    }

    /// The path of a part, from where the program stands.
    pub fn resolve(&self, part: &PartEntry) -> PathBuf {
        self.folder.join(&part.file)
    }

    /// Refuses the value of a key.
    pub(crate) fn refuse(&self, key: &str, found: impl ToString, expected: impl Into<String>) -> TomlError {
        TomlError::Impossible {
            path: toml_file::place(&self.path, &self.text, key),
            key: key.into(),
            found: found.to_string(),
            expected: expected.into(),
        }
    }

    fn check(&self) -> Result<(), TomlError> {
        let require = |holds: bool, key: &str, found: String, expected: &str| {
            if holds { Ok(()) } else { Err(self.refuse(key, found, expected)) }
        };
        require(self.format == 1, "format", self.format.to_string(), "1, the version of this format")?;
        require(!self.parts.is_empty(), "part", "none".into(), "at least one `[[part]]`")?;
        if let Some(step) = self.step {
            require(step > 0.0 && step <= LARGEST, "step", step.to_string(), "a time in seconds above 0")?;
        }
        for (i, part) in self.parts.iter().enumerate() {
            let key = |name: &str| format!("part[{i}].{name}");
            let twice = self.parts[..i].iter().any(|other| other.name == part.name);
            let plain = !part.name.is_empty() && !part.name.contains(['.', '\n', ',', '"']);
            let expected = "a name of one line without dot, comma and quotation mark that no other part has, and not \
                 `ground`";
            let holds = plain && !twice && part.name != GROUND;
            require(holds, &key("name"), format!("`{}`", part.name), expected)?;
            let finite = part.position.iter().all(|x| x.abs() <= LARGEST);
            require(finite, &key("position"), listed(&part.position), "finite numbers")?;
            let length = part.rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
            let expected = "a unit quaternion, real part first: four numbers whose squares sum to 1";
            let sound = (length - 1.0).abs() <= UNIT;
            require(sound, &key("rotation"), listed(&part.rotation), expected)?;
        }
        for (i, joint) in self.joints.iter().enumerate() {
            let key = |name: &str| format!("joint[{i}].{name}");
            let name = joint.name(i);
            let twice = self.joints[..i].iter().enumerate().any(|(j, other)| other.name(j) == name);
            require(!twice, &key("name"), format!("`{name}`"), "a name that no other joint has")?;
            let elastic = matches!(joint.kind, JointKind::Bushing | JointKind::Spring);
            let given = joint.stiffness.is_some();
            let found = if given { "given" } else { "absent" };
            let expected = "the stiffness of a bushing or a spring, and of no other joint";
            require(given == elastic, &key("stiffness"), found.into(), expected)?;
            let stiffness = joint.stiffness.as_deref().unwrap_or_default();
            let sound = stiffness.iter().all(|k| (0.0..=LARGEST).contains(k));
            let some = !given || stiffness.iter().any(|k| *k > 0.0);
            let expected = "numbers of 0 or more, one of them above 0";
            require(sound && some, &key("stiffness"), listed(stiffness), expected)?;
            let distance = joint.distance.is_none_or(|distance| (0.0..=LARGEST).contains(&distance));
            require(
                distance,
                &key("distance"),
                joint.distance.unwrap_or_default().to_string(),
                "a length of 0 or more",
            )?;
        }
        Ok(())
    }
}

/// Numbers as an assembly file has them.
fn listed(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", "))
}
