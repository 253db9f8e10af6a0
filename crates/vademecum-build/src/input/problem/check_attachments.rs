//! Checks of attachments, and of the keys that they exclude.

use super::check::{Words, perpendicular};
use super::{
    BasisKind, CouplingKind, EquationEntry, EquationNode, EquationTerm, FoundationEntry, ParameterEntry,
    ParameterKind, Problem, ProblemError, ReferencePointEntry, Representation,
};
use crate::dynamics::SchemeKind;
use crate::limits::MAGNITUDE;
use crate::linalg::{from_upper, symmetric_eigen};
use crate::suggest::did_you_mean;

/// True if a symmetric matrix, given by its upper triangle, has no eigenvalue below zero but for rounding.
fn semidefinite(triangle: &[f64], n: usize) -> bool {
    /// Share of the largest eigenvalue.
    const ROUNDING: f64 = 1e-9;
    let values = symmetric_eigen(from_upper(triangle, n).as_ref()).map(|found| found.0);
    values.is_ok_and(|values| values[0] >= -ROUNDING * values[n - 1] && values[n - 1] > 0.0)
}

impl Problem {
    /// True if something is attached to the body.
    pub fn has_attachments(&self) -> bool {
        self.attachment_tables().iter().any(|(_, count)| *count > 0)
    }

    /// Number of entries of each table.
    fn attachment_tables(&self) -> [(&'static str, usize); 8] {
        [
            ("coupling", self.couplings.len()),
            ("tie", self.ties.len()),
            ("foundation", self.foundations.len()),
            ("equation", self.equations.len()),
            ("spring", self.springs.len()),
            ("dashpot", self.dashpots.len()),
            ("point_mass", self.point_masses.len()),
            ("reference_point", self.reference_points.len()),
        ]
    }

    /// True if a reference point, a spring, a foundation, or an equation of one node holds the body.
    pub(super) fn is_held_by_attachments(&self) -> bool {
        let point = |point: &ReferencePointEntry| !point.held.is_empty() && self.is_joined(&point.name);
        let point = self.reference_points.iter().any(point);
        let of_one = |entry: &EquationEntry| {
            let node = |term: &EquationTerm| match term.0 {
                EquationNode::Node(id) => Some(id),
                EquationNode::Point(_) => None,
            };
            let first = entry.terms.first().and_then(node);
            first.is_some() && entry.terms.iter().all(|term| node(term) == first)
        };
        let spring = self.springs.iter().any(|spring| spring.to.is_none());
        let ground = self.foundations.iter().any(|ground| ground.normal > 0.0 || ground.tangential > 0.0);
        point || spring || ground || self.equations.iter().any(of_one)
    }

    /// Place of a reference point in its list.
    pub fn reference_point(&self, name: &str) -> Option<usize> {
        self.reference_points.iter().position(|point| point.name == name)
    }

    /// Places of the reference points.
    pub(crate) fn reference_places(&self) -> Vec<[f64; 3]> {
        self.reference_points.iter().map(|point| point.at).collect()
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
            let one = coupling.on.is_some() != coupling.weights.is_some();
            let found = Words(if coupling.on.is_some() { "`on` and `weights`" } else { "no nodes" });
            self.require(one, &format!("coupling[{i}].on"), found, "nodes by `on` or by `weights`")?;
            if let Some(weights) = &coupling.weights {
                let key = format!("coupling[{i}].weights");
                let sound = weights.iter().all(|(_, weight)| (0.0..=MAGNITUDE.1).contains(weight));
                let sound = sound && weights.iter().any(|(_, weight)| *weight > 0.0);
                let average = coupling.kind == CouplingKind::Average;
                self.require(average, &key, Words("beside `kind = \"rigid\"`"), "none")?;
                self.require(sound, &key, Words("a list"), "weights of 0 or more, one of them above 0")?;
            }
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
            let one = spring.stiffness.is_some() != spring.matrix.is_some();
            let found = Words(if one { "" } else { "not one of `stiffness` and `matrix`" });
            self.require(one, &format!("spring[{i}]"), found, "`stiffness` or `matrix`")?;
            if let Some(stiffness) = spring.stiffness {
                let sound = stiffness.iter().all(|k| (0.0..=MAGNITUDE.1).contains(k));
                let sound = sound && stiffness.iter().any(|k| *k > 0.0);
                let expected = "numbers from 0 to 1e30, one of them above 0";
                self.require(sound, &format!("spring[{i}].stiffness"), stiffness, expected)?;
            }
            if let Some(matrix) = &spring.matrix {
                let key = format!("spring[{i}].matrix");
                let count = if spring.to.is_some() { 78 } else { 21 };
                let right = matrix.len() == count && matrix.iter().all(|k| k.abs() <= MAGNITUDE.1);
                let expected = "78 finite numbers, or 21 of a spring to the ground";
                self.require(right, &key, format_args!("a list of {}", matrix.len()), expected)?;
                let definite = semidefinite(matrix, if count == 78 { 12 } else { 6 });
                let expected = "a matrix under which no motion gives energy back";
                self.require(definite, &key, Words("not positive semidefinite"), expected)?;
                let key = format!("spring[{i}].axes");
                self.require(spring.axes.is_none(), &key, Words("beside `matrix`"), "none")?;
            }
            if let Some(axes) = spring.axes {
                let expected = "two perpendicular directions";
                self.require(perpendicular(axes), &format!("spring[{i}].axes"), axes, expected)?;
            }
        }
        self.check_dampers()?;
        self.check_beside_attachments()
    }

    /// Checks dashpots and foundations, and what damping by them excludes.
    fn check_dampers(&self) -> Result<(), ProblemError> {
        for (i, dashpot) in self.dashpots.iter().enumerate() {
            let key = |name: &str| format!("dashpot[{i}].{name}");
            self.named_point(&key("from"), &dashpot.from)?;
            if let Some(to) = &dashpot.to {
                self.named_point(&key("to"), to)?;
                let other = *to != dashpot.from;
                self.require(other, &key("to"), to, "another point than `from`")?;
            }
            for (name, point) in [("from", Some(&dashpot.from)), ("to", dashpot.to.as_ref())] {
                let Some(point) = point else { continue };
                let expected =
                    "a point that a coupling, an equation, a spring, a mass or `held` moves or holds";
                self.require(self.moves(point), &key(name), point, expected)?;
            }
            let sound = dashpot.damping.iter().all(|c| (0.0..=MAGNITUDE.1).contains(c));
            let sound = sound && dashpot.damping.iter().any(|c| *c > 0.0);
            let expected = "numbers from 0 to 1e30, one of them above 0";
            self.require(sound, &key("damping"), dashpot.damping, expected)?;
            if let Some(axes) = dashpot.axes {
                let expected = "two perpendicular directions";
                self.require(perpendicular(axes), &key("axes"), axes, expected)?;
            }
        }
        for (i, ground) in self.foundations.iter().enumerate() {
            let numbers =
                [ground.normal, ground.tangential, ground.damping_normal, ground.damping_tangential];
            let some = numbers.iter().any(|number| *number > 0.0);
            let found = Words("no stiffness and no damping");
            self.require(some, &format!("foundation[{i}]"), found, "a number above 0")?;
        }
        let damped =
            |ground: &FoundationEntry| ground.damping_normal > 0.0 || ground.damping_tangential > 0.0;
        let damped = self.foundations.iter().position(damped).map(|i| format!("foundation[{i}]"));
        let Some(key) = (!self.dashpots.is_empty()).then(|| "dashpot".into()).or(damped) else {
            return Ok(());
        };
        let Some(found) = self.without_exact_modes() else { return Ok(()) };
        self.require(false, &key, Words(found), "natural modes that are moved exactly")
    }

    /// The key, if any, by which the step is not that of natural modes that are moved exactly and stay modes.
    pub(super) fn without_exact_modes(&self) -> Option<&'static str> {
        let scaled = |kind: ParameterKind| kind.is_stiffness() || kind.is_mass();
        if self.scheme() != (SchemeKind::Exact {}) {
            Some("beside a `time.scheme` that is not exact")
        } else if self.basis_kind() != BasisKind::Modes {
            Some("beside a basis that is not of natural modes")
        } else if self.parameters.iter().any(|parameter| scaled(parameter.kind)) && !self.is_parametric() {
            Some("beside a live stiffness or density of the whole body alone")
        } else {
            None
        }
    }

    /// Attachments that a live parameter of this kind scales by name, in words, and the names there are.
    fn attachment_names(&self, kind: ParameterKind) -> Option<(&'static str, Vec<&str>)> {
        let grounds = |of: fn(&FoundationEntry) -> bool| {
            self.foundations.iter().filter(move |ground| of(ground)).filter_map(|one| one.name.as_deref())
        };
        Some(match kind {
            ParameterKind::Stiffness => {
                let springs = self.springs.iter().filter_map(|one| one.name.as_deref());
                let stiff = grounds(|ground| ground.normal > 0.0 || ground.tangential > 0.0);
                ("`[[spring]]` or stiff `[[foundation]]`", springs.chain(stiff).collect())
            }
            ParameterKind::Mass => {
                ("`[[point_mass]]`", self.point_masses.iter().filter_map(|one| one.name.as_deref()).collect())
            }
            ParameterKind::Damping => {
                let dashpots = self.dashpots.iter().filter_map(|one| one.name.as_deref());
                let damped = grounds(|ground| ground.damping_normal > 0.0 || ground.damping_tangential > 0.0);
                ("`[[dashpot]]` or damped `[[foundation]]`", dashpots.chain(damped).collect())
            }
            _ => return None,
        })
    }

    /// Attachments that a live parameter scales.
    pub(super) fn check_live_attachment(&self, i: usize, entry: &ParameterEntry) -> Result<(), ProblemError> {
        let key = format!("parameter[{i}].attachment");
        let Some(name) = &entry.attachment else {
            let alone = !matches!(entry.kind, ParameterKind::Mass | ParameterKind::Damping);
            let found = || format!("none beside `kind = \"{}\"`", entry.kind.name());
            let expected = "the name of a `[[point_mass]]` (mass) or of a `[[dashpot]]` (damping)";
            return self.require_with(alone, &key, found, expected);
        };
        let found = || format!("beside `kind = \"{}\"`, region \"{}\"", entry.kind.name(), entry.region);
        let known = self.attachment_names(entry.kind).filter(|_| entry.region == "*");
        let expected = "`kind = \"stiffness\"`, `\"mass\"` or `\"damping\"`, and no `region`";
        self.require_with(known.is_some(), &key, found, expected)?;
        let (what, names) = known.unwrap_or_default();
        self.require_with(
            names.contains(&name.as_str()),
            &key,
            || format!("\"{name}\""),
            format!("the `name` of a {what}{}", did_you_mean(name, names.iter().copied())),
        )
    }

    /// Names of attachments that live parameters scale, each once.
    pub(crate) fn live_attachments(&self) -> Vec<&str> {
        let mut names: Vec<&str> = vec![];
        for name in self.parameters.iter().filter_map(|entry| entry.attachment.as_deref()) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// True if something beside dashpots has a part in the motion of a reference point.
    pub(super) fn moves(&self, name: &str) -> bool {
        let point = self.reference_point(name).map(|place| &self.reference_points[place]);
        point.is_some_and(|point| !point.held.is_empty()) || self.is_joined(name)
    }

    /// True if a coupling, a mass, a spring or an equation names a reference point.
    fn is_joined(&self, name: &str) -> bool {
        let in_equation = |entry: &EquationEntry| {
            entry.terms.iter().any(|term| matches!(&term.0, EquationNode::Point(point) if point == name))
        };
        self.couplings.iter().any(|coupling| coupling.reference == name)
            || self.point_masses.iter().any(|mass| mass.reference == name)
            || self.springs.iter().any(|spring| spring.from == name || spring.to.as_deref() == Some(name))
            || self.equations.iter().any(in_equation)
    }

    /// Keys that attachments exclude.
    fn check_beside_attachments(&self) -> Result<(), ProblemError> {
        let found = if !self.has_attachments() {
            return Ok(());
        } else if self.mesh.matrices.is_some() {
            "beside `mesh.matrices`, which have no elements"
        } else if self.representation == Some(Representation::Canonical) {
            "beside `representation = \"chapter\"`"
        } else if self.is_large() {
            "beside `model = \"large-displacement\"`"
        } else if self.base.moves {
            "beside `base.moves`"
        } else if self.snapshots.npy.is_some() || self.snapshots.vtu.is_some() {
            "beside snapshots of another program"
        } else if self.output.static_fields == Some(true) {
            "beside `output.static_fields = true`"
        } else if self.has_local_parameters() && !self.is_parametric() {
            "beside live regions by a separated step"
        } else {
            return Ok(());
        };
        let tables = self.attachment_tables();
        let key = tables.iter().find(|(_, count)| *count > 0).map_or("coupling", |table| table.0);
        self.require(false, key, Words(found), "linear motion of a body of elements")
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
