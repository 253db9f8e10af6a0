//! The assembly file: parts, and the joints between them (normative: `formats/assembly-1.md`).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Deserialize;
use vademecum_build::input::toml_file::{self, TomlError};

use crate::entries::{
    ContactEntry, LARGEST, OutputEntry, Refused, RigidEntry, ShakeEntry, WorldEntry, listed,
};
use crate::names::{ANY, MAX_PARTS, means};

/// The ground, in place of a port of a joint.
pub const GROUND: &str = "ground";

/// Largest distance of a quaternion from unit length.
const UNIT: f64 = 1e-6;

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
    /// A world; absent of parts that are joined to one body.
    pub world: Option<WorldEntry>,
    /// Pairs of parts that may touch in a world.
    #[serde(rename = "contact", default)]
    pub contacts: Vec<ContactEntry>,
    /// Columns of the table of a world.
    #[serde(rename = "output", default)]
    pub outputs: Vec<OutputEntry>,
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
    #[serde(default, skip_serializing_if = "nameless")]
    pub file: PathBuf,
    /// A rigid body of a world, in place of a file.
    pub rigid: Option<RigidEntry>,
    /// Mesh hash of the file, as `vademecum info` prints it; another file is refused.
    pub hash: Option<String>,
    /// Values of live parameters of its file by name, of a parametric model; others are as built.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
    /// Place of the origin of its coordinates \[m\].
    #[serde(default)]
    pub position: [f64; 3],
    /// Its rotation as a unit quaternion, real part first.
    #[serde(default = "unturned")]
    pub rotation: [f64; 4],
    /// Velocity of its centre of mass in space \[m/s\], of a part of a world that moves freely.
    pub velocity: Option<[f64; 3]>,
    /// Angular velocity in space \[rad/s\], of a part of a world that moves freely.
    pub spin: Option<[f64; 3]>,
    /// Numbers of copies along x, y and z, of a part of a world; they are `name1`, `name2`, …, along x first.
    pub copies: Option<[usize; 3]>,
    /// Distance of the copies along x, y and z \[m\].
    pub spacing: Option<[f64; 3]>,
    /// Stops of a held part, or of a rigid body without density: time \[s\] and displacement \[m\].
    pub path: Option<Vec<[f64; 4]>>,
    /// Shake of such a part.
    pub shake: Option<ShakeEntry>,
    /// Number of its `[[part]]`.
    #[serde(skip)]
    pub entry: usize,
}

fn nameless(path: &Path) -> bool {
    path.as_os_str().is_empty()
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
    /// The ports it joins, `part.port` each; the second may be `ground`. A rigid body goes by its name alone.
    pub between: [String; 2],
    /// Stiffness of a bushing or a spring, or of a cable, which is one number \[N/m, N m\].
    pub stiffness: Option<Vec<f64>>,
    /// Rotations of any size, of a ball joint, a hinge or a slider between frames in a world.
    #[serde(default)]
    pub turns: bool,
    /// Length of a cable \[m\]; absent: the distance at the start.
    pub length: Option<f64>,
    /// Point in space at the start \[m\] of a side that is `ground` or a rigid body; absent: the port of the
    /// other side.
    pub at: Option<[f64; 3]>,
    /// Largest distance between the ports \[m\]; absent: a thousandth of their size.
    pub distance: Option<f64>,
    /// Size of its force \[N\] above which it breaks, of a joint of a world; absent: it does not.
    pub breaks_at: Option<f64>,
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
    /// Two points are no farther apart than a length; in a world only.
    Cable,
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
            Self::Cable => "cable",
        }
    }
}

impl JointEntry {
    /// True of a joint that a world closes in its step.
    pub(crate) fn is_of_step(&self) -> bool {
        self.turns || self.kind == JointKind::Cable
    }

    /// Its name, or its kind with its number.
    #[must_use]
    pub fn name(&self, index: usize) -> String {
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
        let mut file = Self { text: text.into(), folder, path: path.into(), ..file };
        file.check_copies()?;
        file.copy_parts();
        file.check()?;
        file.name_pairs();
        Ok(file)
    }

    /// A world that no file describes; messages name it `path`.
    ///
    /// # Errors
    /// [`TomlError`], as for [`AssemblyFile::read`].
    pub fn of_world(
        path: &str,
        world: WorldEntry,
        parts: Vec<PartEntry>,
        (joints, contacts): (Vec<JointEntry>, Vec<ContactEntry>),
    ) -> Result<Self, TomlError> {
        let file = Self {
            format: 1,
            title: String::new(),
            step: None,
            parts,
            joints,
            world: Some(world),
            contacts,
            outputs: vec![],
            text: String::new(),
            folder: PathBuf::new(),
            path: path.into(),
        };
        file.check()?;
        Ok(file)
    }

    /// The path of a part, from where the program stands.
    pub fn resolve(&self, part: &PartEntry) -> PathBuf {
        self.folder.join(&part.file)
    }

    /// The files that the parts are read from: vademecum files, and surfaces of rigid bodies.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let of_part = |part: &PartEntry| match &part.rigid {
            None => Some(self.resolve(part)),
            Some(rigid) => rigid.surface.as_ref().map(|surface| self.folder.join(surface)),
        };
        self.parts.iter().filter_map(of_part).collect()
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
        self.require(self.format == 1, "format", self.format, "1, the version of this format")?;
        self.require(!self.parts.is_empty(), "part", "none", "at least one `[[part]]`")?;
        if let Some(step) = self.step {
            self.require(step > 0.0 && step <= LARGEST, "step", step, "a time in seconds above 0")?;
        }
        (0..self.parts.len()).try_for_each(|i| self.check_part(i))?;
        (0..self.joints.len()).try_for_each(|i| self.check_joint(i))?;
        match &self.world {
            Some(world) => self.check_world(world),
            None => self.check_joined(),
        }
    }

    fn require(
        &self,
        holds: bool,
        key: &str,
        found: impl ToString,
        expected: impl Into<String>,
    ) -> Result<(), TomlError> {
        if holds { Ok(()) } else { Err(self.refuse(key, found, expected)) }
    }

    /// Refuses the fault of an entry.
    fn sound(&self, entry: &str, fault: Option<Refused>) -> Result<(), TomlError> {
        fault.map_or(Ok(()), |(key, found, expected)| {
            Err(self.refuse(&format!("{entry}.{key}"), found, expected))
        })
    }

    /// Refuses copies before they are made.
    fn check_copies(&self) -> Result<(), TomlError> {
        let mut sum = 0;
        for (i, part) in self.parts.iter().enumerate() {
            let key = |name: &str| format!("part[{i}].{name}");
            let count = part.count().filter(|count| (1..=MAX_PARTS).contains(count)).unwrap_or(MAX_PARTS + 1);
            sum += count;
            let expected = "three numbers of 1 or more, and at most 10000 parts in all";
            let found = listed(&part.copies.unwrap_or([1; 3]).map(|count| count as f64));
            self.require(sum <= MAX_PARTS, &key("copies"), found, expected)?;
            let spacing = part.spacing.unwrap_or_default();
            let sound = spacing.iter().all(|x| x.abs() <= LARGEST);
            self.require(sound, &key("spacing"), listed(&spacing), "finite numbers")?;
            let alone = part.copies.is_none() && part.spacing.is_some();
            self.require(!alone, &key("spacing"), "given without `copies`", "the numbers of `copies`, too")?;
        }
        Ok(())
    }

    fn check_way(&self, part: &PartEntry) -> Result<(), TomlError> {
        let key = |name: &str| format!("part[{}].{name}", part.entry);
        let moves = part.rigid.as_ref().is_some_and(|rigid| rigid.density.is_some());
        for (name, given) in [("path", part.path.is_some()), ("shake", part.shake.is_some())] {
            let expected = "a part that its supports hold, or a rigid body without `density`";
            self.require(!given || !moves, &key(name), "given", expected)?;
        }
        if let Some(path) = &part.path {
            let finite = path.as_flattened().iter().all(|x| x.abs() <= LARGEST);
            let ascending = path.windows(2).all(|pair| pair[0][0] < pair[1][0]);
            let expected =
                "at least one stop, of a time and three displacements, in ascending order of the times";
            let found = path.iter().map(|stop| listed(stop)).collect::<Vec<_>>().join(", ");
            self.require(
                finite && ascending && !path.is_empty(),
                &key("path"),
                format!("[{found}]"),
                expected,
            )?;
        }
        self.sound(&format!("part[{}]", part.entry), part.shake.as_ref().and_then(ShakeEntry::fault))
    }

    fn check_part(&self, i: usize) -> Result<(), TomlError> {
        let part = &self.parts[i];
        let key = |name: &str| format!("part[{}].{name}", part.entry);
        let twice = self.parts[..i].iter().any(|other| other.name == part.name);
        let plain = !part.name.is_empty() && !part.name.contains(['.', '\n', ',', '"', ANY]);
        let expected = "a name of one line without dot, comma, quotation mark and `*` that no other part has, and not \
                        `ground`";
        let holds = plain && !twice && part.name != GROUND;
        self.require(holds, &key("name"), format!("`{}`", part.name), expected)?;
        let has_file = !nameless(&part.file);
        let found = if has_file { "given beside `rigid`" } else { "absent" };
        let expected = "the vademecum file of the part, or `rigid` in its place";
        let at = if has_file { key("file") } else { key("name") };
        self.require(has_file != part.rigid.is_some(), &at, format!("`file` {found}"), expected)?;
        self.sound(&format!("part[{}]", part.entry), part.rigid.as_ref().and_then(RigidEntry::fault))?;
        self.check_way(part)?;
        let hash = part.hash.as_deref().filter(|_| !has_file);
        self.require(hash.is_none(), &key("hash"), "given", "no hash: a rigid body has none")?;
        let set = part.parameters.keys().next().filter(|_| !has_file);
        self.require(
            set.is_none(),
            &key("parameters"),
            "given",
            "none: a rigid body has no live parameters",
        )?;
        let finite = |numbers: &[f64; 3]| numbers.iter().all(|x| x.abs() <= LARGEST);
        self.require(finite(&part.position), &key("position"), listed(&part.position), "finite numbers")?;
        let length = part.rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
        let expected = "a unit quaternion, real part first: four numbers whose squares sum to 1";
        let unit = (length - 1.0).abs() <= UNIT;
        self.require(unit, &key("rotation"), listed(&part.rotation), expected)?;
        let fixed = part.rigid.as_ref().is_some_and(|rigid| rigid.density.is_none());
        for (name, value) in [("velocity", part.velocity), ("spin", part.spin)] {
            let Some(value) = value else { continue };
            self.require(finite(&value), &key(name), listed(&value), "finite numbers")?;
            let expected = "a rigid body with a `density`: one without stands still";
            self.require(!fixed, &key(name), listed(&value), expected)?;
        }
        Ok(())
    }

    fn check_joint(&self, i: usize) -> Result<(), TomlError> {
        let joint = &self.joints[i];
        let key = |name: &str| format!("joint[{i}].{name}");
        let name = joint.name(i);
        let twice = self.joints[..i].iter().enumerate().any(|(j, other)| other.name(j) == name);
        self.require(!twice, &key("name"), format!("`{name}`"), "a name that no other joint has")?;
        let elastic = matches!(joint.kind, JointKind::Bushing | JointKind::Spring);
        let cable = joint.kind == JointKind::Cable;
        let given = joint.stiffness.is_some();
        let found = if given { "given" } else { "absent" };
        let expected = "the stiffness of a bushing or a spring, or of a cable, and of no other joint";
        self.require(given == elastic || cable, &key("stiffness"), found, expected)?;
        let stiffness = joint.stiffness.as_deref().unwrap_or_default();
        let sound = stiffness.iter().all(|k| (0.0..=LARGEST).contains(k));
        let some = !given || stiffness.iter().any(|k| *k > 0.0);
        let expected = "numbers of 0 or more, one of them above 0";
        self.require(sound && some, &key("stiffness"), listed(stiffness), expected)?;
        let one = !cable || stiffness.len() <= 1;
        self.require(one, &key("stiffness"), listed(stiffness), "one number of a cable")?;
        let bears = joint.breaks_at.unwrap_or(1.0);
        let sound = bears > 0.0 && bears <= LARGEST;
        self.require(sound, &key("breaks_at"), bears, "a force in newtons above 0")?;
        let positive = |value: Option<f64>| value.is_none_or(|value| (0.0..=LARGEST).contains(&value));
        for (name, value) in [("distance", joint.distance), ("length", joint.length)] {
            self.require(positive(value), &key(name), value.unwrap_or_default(), "a length of 0 or more")?;
        }
        let turning = matches!(joint.kind, JointKind::Hinge | JointKind::Ball | JointKind::Slider);
        let expected = "`false`: balls, hinges and sliders turn far, and cables always do";
        self.require(!joint.turns || turning, &key("turns"), joint.turns, expected)?;
        let length = joint.length.filter(|_| !cable);
        self.require(
            length.is_none(),
            &key("length"),
            "given",
            "the length of a cable, and of no other joint",
        )?;
        let at = joint.at.unwrap_or_default();
        self.require(at.iter().all(|x| x.abs() <= LARGEST), &key("at"), listed(&at), "finite numbers")
    }

    /// Refuses keys of a world in an assembly without one.
    fn check_joined(&self) -> Result<(), TomlError> {
        let refuse = |key: String, found: String| {
            let expected = "`[world]` with its `time`: this key is that of bodies that move in a world";
            Err(self.refuse(&key, found, expected))
        };
        for part in &self.parts {
            let keys = [
                ("rigid", part.rigid.is_some()),
                ("velocity", part.velocity.is_some()),
                ("spin", part.spin.is_some()),
                ("copies", part.copies.is_some()),
                ("path", part.path.is_some()),
                ("shake", part.shake.is_some()),
            ];
            if let Some((key, _)) = keys.into_iter().find(|(_, given)| *given) {
                return refuse(format!("part[{}].{key}", part.entry), "given".into());
            }
        }
        for (i, joint) in self.joints.iter().enumerate() {
            if joint.is_of_step() {
                let key = if joint.turns { "turns" } else { "kind" };
                let found = if joint.turns { "true" } else { "`cable`" };
                return refuse(format!("joint[{i}].{key}"), found.into());
            }
            for (key, given) in [("at", joint.at.is_some()), ("breaks_at", joint.breaks_at.is_some())] {
                if given {
                    return refuse(format!("joint[{i}].{key}"), "given".into());
                }
            }
        }
        if let Some(contact) = self.contacts.first() {
            return refuse("contact[0].between".into(), pair(&contact.between));
        }
        match self.outputs.first() {
            Some(output) => refuse("output[0].part".into(), format!("`{}`", output.part)),
            None => Ok(()),
        }
    }

    fn check_world(&self, world: &WorldEntry) -> Result<(), TomlError> {
        self.sound("world", world.fault())?;
        let twice = self.step.is_some() && world.step.is_some();
        self.require(!twice, "world.step", "given beside `step`", "one of the two")?;
        for (i, joint) in self.joints.iter().enumerate() {
            let found = format!("`{}` without `turns = true`", joint.kind.word());
            let expected = "joints that a step closes: `turns = true`, or a cable; join welded parts with `vademecum \
                            assemble` first, and name the joined file as a part";
            self.require(joint.is_of_step(), &format!("joint[{i}].kind"), found, expected)?;
        }
        let names = || self.parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>().join(", ");
        for (i, contact) in self.contacts.iter().enumerate() {
            let key = format!("contact[{i}].between");
            let found = pair(&contact.between);
            let meant = |name: &String| self.parts.iter().any(|part| means(name, &part.name));
            let known = contact.between.iter().all(meant);
            self.require(known, &key, &found, format!("two parts of {}", names()))?;
            let [a, b] = &contact.between;
            self.require(a != b || a.ends_with(ANY), &key, &found, "two different parts")?;
            let [pair, turned] = [[a, b], [b, a]];
            let same = |other: &ContactEntry| [pair, turned].contains(&other.between.each_ref());
            let twice = self.contacts[..i].iter().any(same);
            self.require(!twice, &key, &found, "a pair that is named once")?;
            let rigid = |name: &str| self.part(name).is_some_and(|part| self.parts[part].rigid.is_some());
            self.require(!rigid(a) || !rigid(b), &key, &found, "a pair of which one part has a `file`")?;
            self.sound(&format!("contact[{i}]"), contact.fault())?;
        }
        for (i, output) in self.outputs.iter().enumerate() {
            let key = |name: &str| format!("output[{i}].{name}");
            let found = format!("`{}`", output.part);
            self.require(
                self.part(&output.part).is_some(),
                &key("part"),
                found,
                format!("one of {}", names()),
            )?;
            let twice = self.outputs[..i].iter().any(|other| other.name() == output.name());
            let plain = !output.name().is_empty() && !output.name().contains(['\n', ',', '"']);
            let expected = "a name of one line without comma and quotation mark that no other output has";
            let at = if output.name.is_some() { key("name") } else { key("part") };
            self.require(plain && !twice, &at, format!("`{}`", output.name()), expected)?;
            let point = output.point.unwrap_or_default();
            let finite = point.iter().all(|x| x.abs() <= LARGEST);
            self.require(finite, &key("point"), listed(&point), "finite numbers")?;
        }
        Ok(())
    }

    /// Refuses a world, which is no one body.
    pub(crate) fn refuse_world(&self) -> Result<(), TomlError> {
        let expected = "an assembly without `[world]`: parts that touch or turn are not one body; `vademecum run` \
                        marches them";
        self.require(self.world.is_none(), "world", "given", expected)
    }

    /// Number of a part.
    pub(crate) fn part(&self, name: &str) -> Option<usize> {
        self.parts.iter().position(|part| part.name == name)
    }
}

/// Two names as an assembly file has them.
fn pair([a, b]: &[String; 2]) -> String {
    format!("`{a}` and `{b}`")
}
