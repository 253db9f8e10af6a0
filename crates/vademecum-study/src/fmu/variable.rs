//! The variables of an FMU in words: names, texts, units, starts and roles.

use vademecum_eval::{Field, Quantity, RigidBody, SceneOptions};
use vademecum_fmu::variables::Variable;
use vademecum_format::{File, Metadata, Parameter};

use super::xml::Element;
use crate::contents::SI;

/// A variable, in words.
pub(super) struct VariableDescription {
    pub(crate) variable: Variable,
    /// Its value reference.
    pub(crate) reference: u32,
    pub(crate) name: String,
    text: String,
    pub(crate) unit: String,
    /// Value at the start; none for what is computed.
    pub(crate) start: Option<f64>,
    /// Smallest and largest value, where there are such.
    range: [Option<f64>; 2],
    /// Rows of an array at the start, and the reference of the structural parameter that has their number,
    /// unless it is fixed.
    rows: Option<(u32, Option<u32>)>,
}

/// Name of an SI unit in a file of these units; empty in other units.
fn unit(metadata: &Metadata<'_>, si: &str) -> String {
    if metadata.units == SI || si == "s" { si.into() } else { String::new() }
}

/// Names of what variables belong to, and what else they are described by.
pub(super) struct VariableNames<'a> {
    pub(crate) points: Vec<String>,
    pub(crate) stresses: Vec<String>,
    pub(crate) patterns: Vec<String>,
    pub(crate) probes: Vec<String>,
    pub(crate) supports: Vec<String>,
    /// `1` for a strain gauge; none where all are displacements.
    pub(crate) probe_units: Vec<String>,
    pub(crate) file: &'a File<'a>,
    /// The body of a file without supports.
    pub(crate) body: Option<RigidBody>,
    /// True of a file with exact steps.
    pub(crate) any_step: bool,
    /// Surface nodes of the arrays, and the reference of the structural parameter that has their number,
    /// unless it is fixed.
    pub(crate) surface: u32,
    pub(crate) surface_reference: Option<u32>,
}

/// Name, text, unit, start and range of a variable; `None` for a parameter that an FMU does not offer.
pub(super) fn describe(
    reference: u32,
    variable: Variable,
    named: &VariableNames<'_>,
    options: &SceneOptions,
) -> Option<VariableDescription> {
    let (start, range) = match variable {
        Variable::Parameter(index) => {
            let start = vademecum_fmu::parameter(options, named.file, index)?;
            let parameter = named.parameter(index)?;
            (Some(start), [Some(parameter.lower), Some(parameter.upper)])
        }
        Variable::Whole(index) => {
            let start = vademecum_fmu::whole(options, named.file, index)?;
            (Some(start), [Some(0.0), None])
        }
        Variable::SurfaceNodes => {
            named.surface_reference?;
            let most = Some(f64::from(named.surface));
            (most, [Some(1.0), most])
        }
        _ => (named.start(variable, options), [None; 2]),
    };
    let owner = named.owner(variable);
    let (text, unit) = (named.text(variable, &owner), named.unit(variable));
    Some(VariableDescription {
        variable,
        reference,
        name: full_name(variable, &owner),
        text,
        unit,
        start,
        range,
        rows: variable.is_array().then_some((named.surface, named.surface_reference)),
    })
}

impl<'a> VariableNames<'a> {
    /// Name of the point, pattern, probe, parameter, place or support that a variable belongs to; empty for
    /// one of the whole body.
    fn owner(&self, variable: Variable) -> String {
        use Variable as V;
        let at = |names: &[String], index: u32| names.get(index as usize).cloned().unwrap_or_default();
        match variable {
            V::Force(index, _) | V::Displacement(index, _) | V::Velocity(index, _) => at(&self.points, index),
            V::Pattern(index) => at(&self.patterns, index),
            V::Probe(index) | V::ProbeVelocity(index) => at(&self.probes, index),
            V::Parameter(index) => self.parameter(index).map_or_else(String::new, |found| found.name.into()),
            V::VonMises(index) => at(&self.stresses, index),
            V::ReactionForce(index, _) | V::ReactionMoment(index, _) => at(&self.supports, index),
            V::Time | V::Step | V::Energy | V::Total(_) | V::Whole(_) | V::Position(..) => String::new(),
            V::SurfaceNodes | V::SurfacePosition | V::SurfaceForce => String::new(),
            V::SurfaceDisplacement | V::SurfaceVelocity => String::new(),
            V::BodyForce(_) | V::BodyPosition(_) | V::BodyAttitude(_) => String::new(),
            V::BodyVelocity(_) | V::BodySpin(_) => String::new(),
        }
    }

    fn parameter(&self, index: u32) -> Option<Parameter<'a>> {
        self.file.parameters().nth(index as usize)
    }

    /// True of strain gauges.
    fn is_gauge(&self, probe: u32) -> bool {
        self.probe_units.get(probe as usize).is_some_and(|unit| unit == "1")
    }

    fn text(&self, variable: Variable, name: &str) -> String {
        use Variable as V;
        let in_space = if self.body.is_some() { " in space" } else { "" };
        let axis = variable.kind().1.unwrap_or_default();
        match variable {
            V::Time => "Time".into(),
            V::Step if self.any_step => "Internal step; communication steps may have any length".into(),
            V::Step => "Internal step; communication steps are multiples of it".into(),
            V::Energy => "Kinetic plus elastic energy".into(),
            V::Force(..) => format!("Force on the point {name} along {axis}{in_space}, held over a step"),
            V::Displacement(..) => format!("Displacement of the point {name} along {axis}{in_space}"),
            V::Velocity(..) => format!("Velocity of the point {name} along {axis}{in_space}"),
            V::Pattern(_) => format!("Factor on the load pattern {name}, held over a step"),
            V::Probe(probe) if self.is_gauge(probe) => format!("Strain that the gauge {name} measures"),
            V::ProbeVelocity(probe) if self.is_gauge(probe) => {
                format!("Rate of the strain that the gauge {name} measures")
            }
            V::Probe(_) => format!("Displacement along the direction of the probe {name}"),
            V::ProbeVelocity(_) => format!("Velocity along the direction of the probe {name}"),
            V::Parameter(_) => format!("Live parameter {name} of the file"),
            V::VonMises(_) => format!("Von Mises equivalent stress of the place {name}"),
            V::ReactionForce(..) => format!("Force that the support {name} exerts on the body along {axis}"),
            V::ReactionMoment(..) => {
                format!(
                    "Moment that the support {name} exerts on the body about {axis}, through its own point"
                )
            }
            V::BodyForce(_) => {
                format!("Force on the centre of the body along {axis} in space, held over a step")
            }
            V::BodyPosition(_) => format!("Position of the centre of the body in space, {axis}"),
            V::BodyAttitude(_) => {
                format!("Quaternion that turns directions of the body into those of space, {axis}")
            }
            V::BodyVelocity(_) => format!("Velocity of the centre of the body along {axis} in space"),
            V::BodySpin(_) => format!("Angular velocity of the body about {axis} in space"),
            V::Whole(0) => "Scale of the stiffness of the whole body".into(),
            V::Whole(1) => "Scale of the density of the whole body".into(),
            V::Whole(2) => "Rayleigh damping of the mass".into(),
            V::Whole(_) => "Rayleigh damping of the stiffness".into(),
            V::SurfaceNodes => "Nodes of the loadable surface in use: rows of the arrays".into(),
            V::SurfacePosition => "Positions of the surface nodes at rest".into(),
            V::SurfaceForce => format!("Forces on the surface nodes{in_space}, held over a step"),
            V::SurfaceDisplacement => format!("Displacements of the surface nodes{in_space}"),
            V::SurfaceVelocity => format!("Velocities of the surface nodes{in_space}"),
            V::Position(..) => String::new(),
            V::Total(index) => V::total(index).map_or("", Quantity::text).into(),
        }
    }

    fn unit(&self, variable: Variable) -> String {
        use Variable as V;
        let si = match variable {
            V::Parameter(index) => {
                return self.parameter(index).map_or_else(String::new, |found| found.unit.into());
            }
            V::Pattern(_) | V::BodyAttitude(_) | V::SurfaceNodes => return String::new(),
            V::Probe(probe) if self.is_gauge(probe) => return String::new(),
            V::ProbeVelocity(probe) if self.is_gauge(probe) => "1/s",
            V::Whole(0 | 1) => return String::new(),
            // Of time alone, in any units.
            V::Whole(2) => return "1/s".into(),
            V::Time | V::Step | V::Whole(_) => "s",
            V::Energy => "J",
            V::Force(..) | V::ReactionForce(..) | V::BodyForce(_) | V::SurfaceForce => "N",
            V::ReactionMoment(..) => "N.m",
            V::Displacement(..) | V::Probe(_) | V::BodyPosition(_) => "m",
            V::SurfacePosition | V::SurfaceDisplacement | V::Position(..) => "m",
            V::Velocity(..) | V::ProbeVelocity(_) | V::BodyVelocity(_) | V::SurfaceVelocity => "m/s",
            V::VonMises(_) => "Pa",
            V::BodySpin(_) => "rad/s",
            V::Total(index) => {
                V::total(index).and_then(|of| of.unit(Field::Displacement)).unwrap_or_default()
            }
        };
        unit(self.file.metadata(), si)
    }

    /// Value at the start of a variable that is no parameter.
    fn start(&self, variable: Variable, options: &SceneOptions) -> Option<f64> {
        use Variable as V;
        match variable {
            V::Step => Some(options.time_step.unwrap_or(self.file.metadata().time_step)),
            V::BodyVelocity(_) | V::BodySpin(_) => Some(0.0),
            _ if variable.is_input() => Some(0.0),
            V::BodyPosition(c) => self.body.as_ref()?.centre.get(c as usize).copied(),
            V::BodyAttitude(c) => Some(f64::from(u8::from(c == 3))),
            _ => None,
        }
    }
}

/// `kind.name.component`; a name that is no identifier stands in quotes, as the structured naming of FMI asks
/// for.
fn full_name(variable: Variable, name: &str) -> String {
    let (kind, component) = variable.kind();
    let name = plain(name);
    let parts = [kind, &name, component.unwrap_or_default()];
    let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    parts.join(".")
}

/// A name as a part of structured names: in quotes, unless it is an identifier.
pub(super) fn plain(name: &str) -> String {
    if is_identifier(name) || !can_be_quoted(name) { name.into() } else { format!("'{name}'") }
}

fn is_identifier(name: &str) -> bool {
    let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    name.is_empty() || (name.starts_with(letter) && name.chars().all(|c| letter(c) || c.is_ascii_digit()))
}

fn can_be_quoted(name: &str) -> bool {
    let quotable = |c: char| c.is_ascii_alphanumeric() || "_!#$%&()*+,-./:;<>=?@[]^{}|~ ".contains(c);
    name.chars().all(quotable)
}

/// Causality, variability, and how the start is known.
const fn roles(variable: Variable) -> (&'static str, &'static str, Option<&'static str>) {
    use Variable as V;
    match variable {
        V::Time => ("independent", "continuous", None),
        V::Step => ("local", "constant", Some("exact")),
        V::Force(..) | V::Pattern(_) | V::BodyForce(_) | V::SurfaceForce => ("input", "continuous", None),
        V::SurfaceNodes => ("structuralParameter", "fixed", Some("exact")),
        V::SurfacePosition | V::Position(..) => ("calculatedParameter", "fixed", Some("calculated")),
        V::SurfaceDisplacement | V::SurfaceVelocity => ("output", "continuous", Some("calculated")),
        V::Parameter(_) | V::Whole(_) => ("parameter", "tunable", Some("exact")),
        V::Energy | V::Displacement(..) | V::Velocity(..) | V::Probe(_) | V::ProbeVelocity(_) => {
            ("output", "continuous", Some("calculated"))
        }
        V::VonMises(_) | V::ReactionForce(..) | V::ReactionMoment(..) | V::Total(_) => {
            ("output", "continuous", Some("calculated"))
        }
        // Where a flight starts may be set.
        V::BodyPosition(_) | V::BodyAttitude(_) | V::BodyVelocity(_) | V::BodySpin(_) => {
            ("output", "continuous", Some("exact"))
        }
    }
}

/// True of names in the structured naming convention: all but identifiers are quoted.
pub(super) fn quotes_match(name: &str) -> bool {
    let mut parts = name.split('\'');
    let outside = parts.next().unwrap_or_default();
    let letters = |text: &str| text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '.');
    match (parts.next(), parts.next(), parts.next()) {
        (None, ..) => letters(outside),
        (Some(_), Some(behind), None) => letters(outside) && letters(behind),
        _ => false,
    }
}

impl VariableDescription {
    /// Attributes common to both versions.
    fn common(&self, element: &str) -> Element {
        let (causality, variability, initial) = roles(self.variable);
        Element::new(element)
            .with("name", &self.name)
            .with("valueReference", &self.reference.to_string())
            .with("description", &self.text)
            .with("causality", causality)
            .with("variability", variability)
            .with("initial", initial.unwrap_or_default())
    }

    fn numbers(&self, element: Element) -> Element {
        let [least, most] = self.range;
        let element = element.with("unit", &self.unit);
        element.number("min", least).number("max", most).number("start", self.start)
    }

    pub(crate) fn scalar_variable(&self) -> String {
        let real = self.numbers(Element::new("Real")).closed();
        self.common("ScalarVariable").around("ScalarVariable", &[real])
    }

    /// The element of FMI 3.
    pub(crate) fn typed(&self) -> String {
        let is_count = self.variable == Variable::SurfaceNodes;
        let element = self.common(if is_count { "UInt64" } else { "Float64" });
        // What may be read within a step.
        let element = element.with("intermediateUpdate", if self.variable.is_output() { "true" } else { "" });
        let Some((rows, reference)) = self.rows else { return self.numbers(element).closed() };
        // Every element has a start value of its own.
        let start = self.start.map(|start| vec![start.to_string(); 3 * rows as usize].join(" "));
        let element = element.with("unit", &self.unit).with("start", &start.unwrap_or_default());
        let dimension = |name, value: u32| Element::new("Dimension").with(name, &value.to_string()).closed();
        let first = match reference {
            Some(reference) => dimension("valueReference", reference),
            None => dimension("start", rows),
        };
        element.around("Float64", &[first, dimension("start", 3)])
    }

    /// True of what has no value before the initialization, and is listed as unknown there.
    pub(crate) fn is_initial_unknown(&self) -> bool {
        let (causality, ..) = roles(self.variable);
        causality == "calculatedParameter" || self.variable.is_output() && self.start.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::{full_name, quotes_match};
    use vademecum_fmu::variables::Variable;

    #[test]
    fn names_are_structured_where_they_can_be() {
        let name = |name| full_name(Variable::Force(0, 2), name);
        assert_eq!(name("tip"), "force.tip.z");
        assert_eq!(name("left tip"), "force.'left tip'.z");
        assert_eq!(name("2"), "force.'2'.z");
        assert_eq!(name("Spitze ü"), "force.Spitze ü.z");
        assert!(quotes_match(&name("tip")) && quotes_match(&name("left tip")));
        assert!(!quotes_match("force.it's.z") && !quotes_match("force.Spitze a.z"));
        assert_eq!(full_name(Variable::Energy, ""), "energy");
    }
}
