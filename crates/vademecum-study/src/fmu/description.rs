//! `modelDescription.xml` of both versions.

use std::fmt::Write as _;

use vademecum_eval::{Field, Quantity, RigidBody, SceneOptions};
use vademecum_fmu::logger::Category;
use vademecum_fmu::variables::Variable;
use vademecum_format::{File, Metadata, Parameter};

use super::version::FmiVersion;
use crate::contents::SI;

/// Internal steps of the default experiment.
const STEPS: f64 = 1000.0;

/// Contents of a description.
pub(super) struct Description<'a> {
    pub(crate) version: FmiVersion,
    pub(crate) name: &'a str,
    pub(crate) identifier: &'a str,
    pub(crate) token: &'a str,
    pub(crate) metadata: &'a Metadata<'a>,
    pub(crate) internal_step: f64,
    /// True of a file with exact steps, which takes communication steps of any length.
    pub(crate) any_step: bool,
    /// Title of the problem; may be empty.
    pub(crate) title: String,
    pub(crate) variables: &'a [VariableDescription],
}

/// A variable, in words.
pub(super) struct VariableDescription {
    pub(crate) variable: Variable,
    /// Its value reference.
    reference: u32,
    pub(crate) name: String,
    text: String,
    unit: String,
    /// Value at the start; none for what is computed.
    start: Option<f64>,
    /// Smallest and largest value, where there are such.
    range: [Option<f64>; 2],
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
            V::Time | V::Step | V::Energy | V::Total(_) | V::Whole(_) => String::new(),
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
            V::Total(index) => V::total(index).map_or("", Quantity::text).into(),
        }
    }

    fn unit(&self, variable: Variable) -> String {
        use Variable as V;
        let si = match variable {
            V::Parameter(index) => {
                return self.parameter(index).map_or_else(String::new, |found| found.unit.into());
            }
            V::Pattern(_) | V::BodyAttitude(_) => return String::new(),
            V::Probe(probe) if self.is_gauge(probe) => return String::new(),
            V::ProbeVelocity(probe) if self.is_gauge(probe) => "1/s",
            V::Whole(0 | 1) => return String::new(),
            // Of time alone, in any units.
            V::Whole(2) => return "1/s".into(),
            V::Time | V::Step | V::Whole(_) => "s",
            V::Energy => "J",
            V::Force(..) | V::ReactionForce(..) | V::BodyForce(_) => "N",
            V::ReactionMoment(..) => "N.m",
            V::Displacement(..) | V::Probe(_) | V::BodyPosition(_) => "m",
            V::Velocity(..) | V::ProbeVelocity(_) | V::BodyVelocity(_) => "m/s",
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
            V::Force(..) | V::Pattern(_) | V::BodyForce(_) | V::BodyVelocity(_) | V::BodySpin(_) => Some(0.0),
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
    let name = if is_identifier(name) || !can_be_quoted(name) { name.into() } else { format!("'{name}'") };
    let parts = [kind, &name, component.unwrap_or_default()];
    let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    parts.join(".")
}

fn is_identifier(name: &str) -> bool {
    let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    name.is_empty() || (name.starts_with(letter) && name.chars().all(|c| letter(c) || c.is_ascii_digit()))
}

fn can_be_quoted(name: &str) -> bool {
    let quotable = |c: char| c.is_ascii_alphanumeric() || "_!#$%&()*+,-./:;<>=?@[]^{}|~ ".contains(c);
    name.chars().all(quotable)
}

/// True of outputs.
pub(super) fn is_output(variable: Variable) -> bool {
    matches!(roles(variable), ("output", ..))
}

/// Causality, variability, and how the start is known.
const fn roles(variable: Variable) -> (&'static str, &'static str, Option<&'static str>) {
    use Variable as V;
    match variable {
        V::Time => ("independent", "continuous", None),
        V::Step => ("local", "constant", Some("exact")),
        V::Force(..) | V::Pattern(_) | V::BodyForce(_) => ("input", "continuous", None),
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

/// One element with its attributes; empty ones are left out.
struct Element(String);

impl Element {
    fn new(name: &str) -> Self {
        Self(format!("<{name}"))
    }

    fn with(mut self, name: &str, value: &str) -> Self {
        if !value.is_empty() {
            self = self.always(name, value);
        }
        self
    }

    fn always(mut self, name: &str, value: &str) -> Self {
        write!(self.0, " {name}=\"{}\"", escaped(value)).expect("writing to a string cannot fail");
        self
    }

    fn number(self, name: &str, value: Option<f64>) -> Self {
        // The digits that are read back as the same number.
        self.with(name, &value.map_or_else(String::new, |value| value.to_string()))
    }

    fn closed(self) -> String {
        self.0 + "/>"
    }

    fn around(self, name: &str, inside: &[String]) -> String {
        let lines: String = inside.join("\n").lines().map(|line| format!("  {line}\n")).collect();
        format!("{}>\n{lines}</{name}>", self.0)
    }
}

fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // What XML has no characters for.
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

impl Description<'_> {
    /// The text of `modelDescription.xml`.
    pub(crate) fn xml(&self) -> String {
        let two = self.version == FmiVersion::Two;
        let (number, token) = if two { ("2.0", "guid") } else { ("3.0", "instantiationToken") };
        let plain_title = "An elastic body under forces at named points, by proper generalized decomposition";
        let plain =
            self.variables.iter().all(|described| described.name.is_ascii() && quotes_match(&described.name));
        let root = Element::new("fmiModelDescription")
            .with("fmiVersion", number)
            .with("modelName", self.name)
            .with(token, self.token)
            .with("description", if self.title.is_empty() { plain_title } else { &self.title })
            .with("generationTool", self.metadata.program)
            .with("variableNamingConvention", if plain { "structured" } else { "flat" });
        let variables: Vec<String> =
            self.variables.iter().map(|d| if two { d.scalar_variable() } else { d.float64() }).collect();
        let parts = [
            self.co_simulation(),
            self.units(),
            categories(),
            self.experiment(),
            Element::new("ModelVariables").around("ModelVariables", &variables),
            self.structure(),
        ];
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}\n",
            root.around("fmiModelDescription", &parts)
        )
    }

    fn co_simulation(&self) -> String {
        let element = Element::new("CoSimulation")
            .with("modelIdentifier", self.identifier)
            .with("canHandleVariableCommunicationStepSize", if self.any_step { "true" } else { "false" })
            .with("canBeInstantiatedOnlyOncePerProcess", "false");
        match self.version {
            FmiVersion::Two => element
                .with("canInterpolateInputs", "false")
                .with("maxOutputDerivativeOrder", "0")
                .with("canRunAsynchronuously", "false")
                .with("canNotUseMemoryManagementFunctions", "true")
                .with("canGetAndSetFMUstate", "true")
                .with("canSerializeFMUstate", "true")
                .with("providesDirectionalDerivative", "false"),
            FmiVersion::Three => element
                .with("canGetAndSetFMUState", "true")
                .with("canSerializeFMUState", "true")
                .with("maxOutputDerivativeOrder", "0")
                .with("providesIntermediateUpdate", "false")
                .with("hasEventMode", "false")
                .number("fixedInternalStepSize", (!self.any_step).then_some(self.internal_step)),
        }
        .closed()
    }

    /// Each unit that is used, in terms of SI where it is known.
    fn units(&self) -> String {
        let mut names: Vec<&str> = self.variables.iter().map(|described| described.unit.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        let unit = |name: &&str| {
            let element = Element::new("Unit").with("name", name);
            let exponents: &[(&str, &str)] = match *name {
                "s" => &[("s", "1")],
                "1/s" => &[("s", "-1")],
                "m" => &[("m", "1")],
                "m/s" => &[("m", "1"), ("s", "-1")],
                "N" => &[("kg", "1"), ("m", "1"), ("s", "-2")],
                "N.m" => &[("kg", "1"), ("m", "2"), ("s", "-2")],
                "Pa" => &[("kg", "1"), ("m", "-1"), ("s", "-2")],
                "rad/s" => &[("s", "-1"), ("rad", "1")],
                "J" => &[("kg", "1"), ("m", "2"), ("s", "-2")],
                _ => return element.closed(),
            };
            let base = Element::new("BaseUnit");
            let base = exponents.iter().fold(base, |base, (unit, exponent)| base.with(unit, exponent));
            element.around("Unit", &[base.closed()])
        };
        let units: Vec<String> = names.iter().filter(|name| !name.is_empty()).map(unit).collect();
        Element::new("UnitDefinitions").around("UnitDefinitions", &units)
    }

    fn experiment(&self) -> String {
        let element = Element::new("DefaultExperiment").number("startTime", Some(0.0));
        let element = element.number("stopTime", Some(STEPS * self.internal_step));
        element.number("stepSize", Some(self.internal_step)).closed()
    }

    /// No output depends on an input of the same instant: what acts shows after the next step.
    fn structure(&self) -> String {
        let outputs = || {
            let all = self.variables.iter().enumerate();
            all.filter(|(_, described)| is_output(described.variable))
        };
        let unknown = |element: &str, (place, described): (usize, &VariableDescription)| {
            let element = Element::new(element);
            let element = match self.version {
                FmiVersion::Two => element.with("index", &(place + 1).to_string()),
                FmiVersion::Three => element.with("valueReference", &described.reference.to_string()),
            };
            element.always("dependencies", "").closed()
        };
        let known = |described: &VariableDescription| described.start.is_some();
        let list =
            |element: &str| -> Vec<String> { outputs().map(|output| unknown(element, output)).collect() };
        let initial = |element: &str| -> Vec<String> {
            let unknowns = outputs().filter(|(_, described)| !known(described));
            unknowns.map(|output| unknown(element, output)).collect()
        };
        let parts = match self.version {
            FmiVersion::Two => vec![
                Element::new("Outputs").around("Outputs", &list("Unknown")),
                Element::new("InitialUnknowns").around("InitialUnknowns", &initial("Unknown")),
            ],
            FmiVersion::Three => [list("Output"), initial("InitialUnknown")].concat(),
        };
        Element::new("ModelStructure").around("ModelStructure", &parts)
    }
}

fn categories() -> String {
    let category = |category: Category| {
        let text = match category {
            Category::Error => "Refused calls; they are logged in any case",
            Category::Event => "What an instance has opened",
        };
        let name = category.name().to_str().unwrap_or_default();
        Element::new("Category").with("name", name).with("description", text).closed()
    };
    Element::new("LogCategories").around("LogCategories", &Category::ALL.map(category))
}

/// True of names in the structured naming convention: all but identifiers are quoted.
fn quotes_match(name: &str) -> bool {
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

    fn scalar_variable(&self) -> String {
        let real = self.numbers(Element::new("Real")).closed();
        self.common("ScalarVariable").around("ScalarVariable", &[real])
    }

    fn float64(&self) -> String {
        self.numbers(self.common("Float64")).closed()
    }
}

#[cfg(test)]
mod tests {
    use super::{escaped, full_name, quotes_match};
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
        assert_eq!(escaped("a<b & \"c\"\n"), "a&lt;b &amp; &quot;c&quot; ");
    }
}
