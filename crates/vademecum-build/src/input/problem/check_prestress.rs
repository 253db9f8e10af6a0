//! Checks of a prestress, and of the keys that it excludes.

use super::check::{Words, positive};
use super::{ParameterKind, Problem, ProblemError, Representation};
use crate::limits::MAGNITUDE;

impl Problem {
    pub(super) fn check_prestress(&self) -> Result<(), ProblemError> {
        let Some(entry) = &self.prestress else { return Ok(()) };
        let loaded = !entry.loads.is_empty() || entry.acceleration.is_some() || entry.speed.is_some();
        let expected = "`loads`, `acceleration` or `speed`";
        self.require(loaded, "prestress", Words("a table without a load"), expected)?;
        let names: Vec<&str> = self.load.patterns.iter().map(|pattern| pattern.name.as_str()).collect();
        for (name, amplitude) in &entry.loads {
            let known = names.contains(&name.as_str());
            self.require(
                known,
                "prestress.loads",
                name,
                format!("names of `[[load.pattern]]`: {}", names.join(", ")),
            )?;
            let sound = amplitude.abs() <= MAGNITUDE.1;
            self.require(sound, "prestress.loads", amplitude, "amplitudes between -1e30 and 1e30")?;
        }
        let vectors = [
            ("prestress.acceleration", entry.acceleration),
            ("prestress.axis", entry.axis),
            ("prestress.point", entry.point),
        ];
        for (key, vector) in vectors {
            let vector = vector.unwrap_or_default();
            let sound = vector.iter().all(|x| x.abs() <= MAGNITUDE.1);
            self.require(sound, key, vector, "numbers between -1e30 and 1e30")?;
        }
        let turns = entry.speed.is_some();
        let along = entry.axis.is_some_and(|axis| positive(axis.iter().map(|x| x * x).sum()));
        let found =
            Words(if turns { "`speed` without an axis of some length" } else { "an axis without `speed`" });
        let of_rotation = if turns { along } else { entry.axis.is_none() && entry.point.is_none() };
        self.require(of_rotation, "prestress.axis", found, "`speed` and `axis` together")?;
        let heavy = self.point_masses.iter().any(|mass| mass.inertia != [0.0; 6]);
        let found =
            Words("beside a `[[point_mass]]` with `inertia`, whose centrifugal moment is not computed");
        self.require(!turns || !heavy, "prestress.speed", found, "point masses without `inertia`")?;
        self.check_beside_prestress()
    }

    /// Keys that a prestress excludes.
    fn check_beside_prestress(&self) -> Result<(), ProblemError> {
        let scaled = |kind: ParameterKind| kind.is_stiffness() || kind.is_mass();
        let found = if self.mesh.matrices.is_some() {
            "beside `mesh.matrices`, which have no elements with a stress"
        } else if self.representation == Some(Representation::Canonical) {
            "beside `representation = \"chapter\"`"
        } else if self.is_large() {
            "beside `model = \"large-displacement\"`, whose motion starts from the body without load"
        } else if self.is_free() {
            "without any `[[support]]`, held reference point or spring to the ground"
        } else if self.base.moves {
            "beside `base.moves`"
        } else if self.has_local_parameters() {
            "beside live regions or attachments, whose matrices the state about which it moves does not have"
        } else if self.parameters.iter().any(|parameter| scaled(parameter.kind)) {
            "beside a live stiffness or density, which the stress of a load case does not follow"
        } else {
            return Ok(());
        };
        let expected = "linear motion of a supported body of elements whose stiffness and density are fixed";
        self.require(false, "prestress", Words(found), expected)
    }
}
