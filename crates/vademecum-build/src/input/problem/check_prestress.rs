//! Checks of a prestress, and of the keys that it excludes.

use super::check::{Words, positive};
use super::{ParameterKind, Problem, ProblemError, Representation};
use crate::limits::MAGNITUDE;
use crate::suggest::did_you_mean;

impl Problem {
    pub(super) fn check_prestress(&self) -> Result<(), ProblemError> {
        let Some(entry) = &self.prestress else { return Ok(()) };
        let loaded = !entry.loads.is_empty() || entry.acceleration.is_some() || entry.rotation.is_some();
        let expected = "`loads`, `acceleration` or `rotation`";
        self.require(loaded, "prestress", Words("a table without a load"), expected)?;
        let names = || self.load.patterns.iter().map(|pattern| pattern.name.as_str());
        for (i, load) in entry.loads.iter().enumerate() {
            let key = format!("prestress.loads[{i}]");
            let once = !entry.loads[..i].iter().any(|other| other.0 == load.0);
            let known = names().any(|name| name == load.0) && once;
            let expected = || format!("a `[[load.pattern]]`, each once{}", did_you_mean(&load.0, names()));
            self.require(known, &key, &load.0, expected())?;
            let sound = load.1.abs() <= MAGNITUDE.1;
            self.require(sound, &key, load.1, "an amplitude between -1e30 and 1e30")?;
        }
        let sound = entry.acceleration.iter().flatten().all(|a| a.abs() <= MAGNITUDE.1);
        let found = entry.acceleration.unwrap_or_default();
        self.require(sound, "prestress.acceleration", found, "finite numbers")?;
        if let Some(rotation) = &entry.rotation {
            let length = positive(rotation.axis.iter().map(|x| x * x).sum());
            self.require(length, "prestress.rotation.axis", rotation.axis, "a vector of some length")?;
            let finite = rotation.point.iter().all(|x| x.abs() <= MAGNITUDE.1);
            self.require(finite, "prestress.rotation.point", rotation.point, "finite numbers")?;
            let heavy = self.point_masses.iter().any(|mass| mass.inertia != [0.0; 6]);
            let found =
                Words("beside a `[[point_mass]]` with `inertia`, whose centrifugal moment is not computed");
            self.require(
                !heavy,
                "prestress.rotation",
                found,
                "point masses without `inertia`, or no rotation",
            )?;
        }
        self.check_beside_prestress()
    }

    /// Keys that a prestress excludes.
    fn check_beside_prestress(&self) -> Result<(), ProblemError> {
        let scaled = |kind| matches!(kind, ParameterKind::Stiffness | ParameterKind::Density);
        let found = if self.mesh.matrices.is_some() {
            "beside `mesh.matrices`, which have no elements with a stress"
        } else if self.representation == Representation::Canonical {
            "beside `representation = \"chapter\"`"
        } else if self.is_large() {
            "beside `model = \"large-displacement\"`, whose motion starts from the body without load"
        } else if self.is_free() {
            "without any `[[support]]`, held reference point or spring to the ground"
        } else if self.base.moves {
            "beside `base.moves`"
        } else if self.parameters.iter().any(|parameter| scaled(parameter.kind)) {
            "beside a live stiffness or density, which the stress of a load case does not follow"
        } else {
            return Ok(());
        };
        let expected = "linear motion of a supported body of elements whose stiffness and density are fixed";
        self.require(false, "prestress", Words(found), expected)
    }
}
