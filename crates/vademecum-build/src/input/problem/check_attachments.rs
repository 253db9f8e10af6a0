//! Checks of attachments, and of the keys that they exclude.

use super::check::Words;
use super::{CouplingKind, EquationNode, EquationTerm, Problem, ProblemError, Representation};
use crate::limits::MAGNITUDE;

impl Problem {
    /// True if something is attached to the body.
    pub fn has_attachments(&self) -> bool {
        let tables =
            self.reference_points.len() + self.couplings.len() + self.ties.len() + self.equations.len();
        tables + self.point_masses.len() + self.springs.len() > 0
    }

    /// True if a reference point or a spring holds the body.
    pub(super) fn is_held_by_attachments(&self) -> bool {
        let point = self.reference_points.iter().any(|point| !point.held.is_empty());
        point || self.springs.iter().any(|spring| spring.to.is_none())
    }

    /// Place of a reference point in its list.
    pub fn reference_point(&self, name: &str) -> Option<usize> {
        self.reference_points.iter().position(|point| point.name == name)
    }

    pub(super) fn check_attachments(&self) -> Result<(), ProblemError> {
        for (i, point) in self.reference_points.iter().enumerate() {
            let twice = self.reference_points[..i].iter().any(|other| other.name == point.name);
            let name = !point.name.is_empty() && !point.name.contains(['\n', ',', '"']) && !twice;
            let expected = "a name of one line without comma and quotation mark that no other point has";
            self.require(name, &format!("reference_point[{i}].name"), &point.name, expected)?;
            let finite = point.at.iter().all(|x| x.is_finite());
            self.require(finite, &format!("reference_point[{i}].at"), point.at, "finite numbers")?;
        }
        for (i, coupling) in self.couplings.iter().enumerate() {
            self.named_point(&format!("coupling[{i}].reference"), &coupling.reference)?;
            let key = format!("coupling[{i}].components");
            let rigid = coupling.kind == CouplingKind::Rigid || coupling.components.is_none();
            self.require(rigid, &key, Words("beside `kind = \"average\"`"), "none")?;
            let some = coupling.components.as_ref().is_none_or(|components| !components.is_empty());
            self.require(some, &key, Words("empty"), "at least one of \"x\", \"y\", \"z\"")?;
        }
        for (i, equation) in self.equations.iter().enumerate() {
            let key = format!("equation[{i}].terms");
            self.require(equation.terms.len() > 1, &key, equation.terms.len(), "two terms or more")?;
            for EquationTerm(node, component, coefficient) in &equation.terms {
                let most = match node {
                    EquationNode::Node(_) => 3,
                    EquationNode::Point(name) => {
                        self.named_point(&key, name)?;
                        6
                    }
                };
                let expected = "components 1 to 3 of nodes and 1 to 6 of reference points";
                self.require((1..=most).contains(component), &key, component, expected)?;
                let number = coefficient.is_finite() && *coefficient != 0.0;
                self.require(number, &key, coefficient, "coefficients that are finite and not zero")?;
            }
        }
        for (i, mass) in self.point_masses.iter().enumerate() {
            self.named_point(&format!("point_mass[{i}].reference"), &mass.reference)?;
            let [xx, yy, zz, xy, xz, yz] = mass.inertia;
            // Principal minors of a positive semidefinite tensor, to rounding.
            let size = xx.abs().max(yy.abs()).max(zz.abs());
            let minors = [xx * yy - xy * xy, xx * zz - xz * xz, yy * zz - yz * yz];
            let whole = xx * minors[2] - yy * xz * xz - zz * xy * xy - 2.0 * xy * xz * yz;
            let sound = [xx, yy, zz].iter().all(|x| *x >= 0.0)
                && minors.iter().all(|minor| *minor >= -1e-9 * size * size)
                && whole >= -1e-9 * size.powi(3);
            let expected = "moments xx, yy, zz and products xy, xz, yz of inertia of some body";
            self.require(sound, &format!("point_mass[{i}].inertia"), mass.inertia, expected)?;
        }
        for (i, spring) in self.springs.iter().enumerate() {
            self.named_point(&format!("spring[{i}].from"), &spring.from)?;
            if let Some(to) = &spring.to {
                self.named_point(&format!("spring[{i}].to"), to)?;
                let other = *to != spring.from;
                self.require(other, &format!("spring[{i}].to"), to, "another point than `from`")?;
            }
            let sound = spring.stiffness.iter().all(|k| (0.0..=MAGNITUDE.1).contains(k));
            let sound = sound && spring.stiffness.iter().any(|k| *k > 0.0);
            let expected = "numbers from 0 to 1e30, one of them above 0";
            self.require(sound, &format!("spring[{i}].stiffness"), spring.stiffness, expected)?;
            if let Some([first, second]) = spring.axes {
                let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                let (one, two) = (dot(first, first), dot(second, second));
                let square = one > 0.0 && two > 0.0 && one.is_finite() && two.is_finite();
                let right = square && dot(first, second).abs() <= 1e-6 * (one * two).sqrt();
                let expected = "two perpendicular directions";
                self.require(right, &format!("spring[{i}].axes"), [first, second], expected)?;
            }
        }
        self.check_beside_attachments()
    }

    /// Keys that attachments exclude.
    fn check_beside_attachments(&self) -> Result<(), ProblemError> {
        let found = if !self.has_attachments() {
            return Ok(());
        } else if self.mesh.matrices.is_some() {
            "beside `mesh.matrices`, which have no elements"
        } else if self.representation == Representation::Canonical {
            "beside `representation = \"chapter\"`"
        } else if self.is_large() {
            "beside `model = \"large-displacement\"`"
        } else if self.is_free() {
            "without any `[[support]]`, held reference point or spring to the ground"
        } else if self.base.moves {
            "beside `base.moves`"
        } else if self.snapshots.npy.is_some() || self.snapshots.vtu.is_some() {
            "beside snapshots of another program"
        } else if self.output.static_fields == Some(true) {
            "beside `output.static_fields = true`"
        } else if self.parameters.iter().any(|parameter| parameter.region != "*") {
            "beside a live parameter of a region"
        } else {
            return Ok(());
        };
        let tables = [
            ("coupling", self.couplings.len()),
            ("tie", self.ties.len()),
            ("equation", self.equations.len()),
            ("spring", self.springs.len()),
            ("point_mass", self.point_masses.len()),
            ("reference_point", self.reference_points.len()),
        ];
        let key = tables.iter().find(|(_, count)| *count > 0).map_or("coupling", |table| table.0);
        self.require(false, key, Words(found), "linear motion of a supported body of elements")
    }

    pub(super) fn named_point(&self, key: &str, name: &str) -> Result<(), ProblemError> {
        let names: Vec<&str> = self.reference_points.iter().map(|point| point.name.as_str()).collect();
        let expected = match names.is_empty() {
            true => "the name of a `[[reference_point]]`, and there is none".to_string(),
            false => format!("the name of a reference point: {}", names.join(", ")),
        };
        self.require(names.contains(&name), key, name, expected)
    }
}
