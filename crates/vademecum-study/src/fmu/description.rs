//! `modelDescription.xml` of both versions.

use std::fmt::Write as _;

use vademecum_eval::{RigidBody, SceneOptions};
use vademecum_fmu::logger::Category;
use vademecum_fmu::variables::Variable;
use vademecum_format::Metadata;

use super::version::FmiVersion;

/// Units of a file whose numbers mean what FMI says they do.
const SI: &str = "SI: m, kg, s, N, Pa";

/// What a description is made of.
pub(super) struct Description<'a> {
    pub version: FmiVersion,
    pub name: &'a str,
    pub identifier: &'a str,
    pub token: &'a str,
    pub metadata: &'a Metadata<'a>,
    pub internal_step: f64,
    pub variables: &'a [Described],
}

/// A variable, in words.
pub(super) struct Described {
    pub variable: Variable,
    /// Its value reference.
    reference: u32,
    pub name: String,
    text: String,
    unit: String,
    /// Value at the start; none for what is computed.
    start: Option<f64>,
    /// Smallest and largest value.
    range: Option<[f64; 2]>,
}

/// How the unit of a kind is called in a file of these units.
fn unit(metadata: &Metadata<'_>, si: &str) -> String {
    if metadata.units == SI || si == "s" { si.into() } else { String::new() }
}

/// Names of what variables belong to, and what else they are described by.
pub(super) struct Named<'a> {
    pub points: Vec<String>,
    pub stresses: Vec<String>,
    pub patterns: Vec<String>,
    pub probes: Vec<String>,
    pub supports: Vec<String>,
    /// `1` for a strain gauge; none where all are displacements.
    pub probe_units: Vec<String>,
    pub metadata: &'a Metadata<'a>,
    /// The body of a file without supports.
    pub body: Option<RigidBody>,
}

/// What a variable is called and what it means; `None` for a parameter that an FMU does not offer.
pub(super) fn describe(
    reference: u32,
    variable: Variable,
    named: &Named<'_>,
    options: &SceneOptions,
) -> Option<Described> {
    use Variable as V;
    let Named { points, stresses, patterns, probes, supports, probe_units, metadata, body } = named;
    let metadata: &Metadata<'_> = metadata;
    let at = |names: &[String], index: u32| names.get(index as usize).cloned().unwrap_or_default();
    let point = |index: u32| at(points, index);
    let in_space = if body.is_some() { " in space" } else { "" };
    let (mut start, mut range) = (None, None);
    let (name, text, unit) = match variable {
        V::Time => (String::new(), "Time".into(), "s".into()),
        V::Step => {
            start = Some(options.time_step.unwrap_or(metadata.time_step));
            let text = "Internal step; communication steps are multiples of it".into();
            (String::new(), text, "s".into())
        }
        V::Energy => (String::new(), "Kinetic plus elastic energy".into(), unit(metadata, "J")),
        V::Force(index, _) => {
            start = Some(0.0);
            let name = point(index);
            let text = format!("Force on the point {name}{in_space}, held over a step");
            (name, text, unit(metadata, "N"))
        }
        V::Displacement(index, _) => {
            let name = point(index);
            let text = format!("Displacement of the point {name}{in_space}");
            (name, text, unit(metadata, "m"))
        }
        V::Velocity(index, _) => {
            let name = point(index);
            let text = format!("Velocity of the point {name}{in_space}");
            (name, text, unit(metadata, "m/s"))
        }
        V::Pattern(index) => {
            start = Some(0.0);
            let name = at(patterns, index);
            let text = format!("Factor on the load pattern {name}, held over a step");
            (name, text, String::new())
        }
        V::Probe(index) if at(probe_units, index) == "1" => {
            let name = at(probes, index);
            let text = format!("Strain that the gauge {name} measures");
            (name, text, String::new())
        }
        V::ProbeVelocity(index) if at(probe_units, index) == "1" => {
            let name = at(probes, index);
            let text = format!("Rate of the strain that the gauge {name} measures");
            (name, text, unit(metadata, "1/s"))
        }
        V::Probe(index) => {
            let name = at(probes, index);
            let text = format!("Displacement along the direction of the probe {name}");
            (name, text, unit(metadata, "m"))
        }
        V::ProbeVelocity(index) => {
            let name = at(probes, index);
            let text = format!("Velocity along the direction of the probe {name}");
            (name, text, unit(metadata, "m/s"))
        }
        V::Parameter(index) => {
            start = Some(vademecum_fmu::parameter(options, metadata, index)?);
            let parameter = metadata.active_parameters().get(index as usize)?;
            range = Some([parameter.lower, parameter.upper]);
            let text = format!("Live parameter {} of the file", parameter.name);
            (parameter.name.to_string(), text, parameter.unit.to_string())
        }
        V::VonMises(index) => {
            let name = at(stresses, index);
            let text = format!("Von Mises equivalent stress of the place {name}");
            (name, text, unit(metadata, "Pa"))
        }
        V::ReactionForce(index, _) => {
            let name = at(supports, index);
            let text = format!("Force that the support {name} exerts on the body");
            (name, text, unit(metadata, "N"))
        }
        V::ReactionMoment(index, _) => {
            let name = at(supports, index);
            let text = format!("Moment that the support {name} exerts on the body, about its own point");
            (name, text, unit(metadata, "N.m"))
        }
        V::BodyForce(_) => {
            start = Some(0.0);
            let text = "Force on the centre of the body in space, held over a step".into();
            (String::new(), text, unit(metadata, "N"))
        }
        V::BodyPosition(c) => {
            start = body.and_then(|body| body.centre.get(c as usize).copied());
            (String::new(), "Where the centre of the body is in space".into(), unit(metadata, "m"))
        }
        V::BodyAttitude(c) => {
            start = Some(f64::from(u8::from(c == 3)));
            let text = "Quaternion that turns directions of the body into those of space".into();
            (String::new(), text, String::new())
        }
        V::BodyVelocity(_) => {
            start = Some(0.0);
            (String::new(), "Velocity of the centre of the body".into(), unit(metadata, "m/s"))
        }
        V::BodySpin(_) => {
            start = Some(0.0);
            (String::new(), "Angular velocity of the body in space".into(), unit(metadata, "rad/s"))
        }
    };
    let name = full_name(variable, &name);
    Some(Described { variable, reference, name, text, unit, start, range })
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

/// Whether a variable is an output.
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
        V::Parameter(_) => ("parameter", "tunable", Some("exact")),
        V::Energy | V::Displacement(..) | V::Velocity(..) | V::Probe(_) | V::ProbeVelocity(_) => {
            ("output", "continuous", Some("calculated"))
        }
        V::VonMises(_) | V::ReactionForce(..) | V::ReactionMoment(..) => {
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
    pub fn xml(&self) -> String {
        let two = self.version == FmiVersion::Two;
        let (number, token) = if two { ("2.0", "guid") } else { ("3.0", "instantiationToken") };
        let title = "An elastic body under forces at named points, by proper generalized decomposition";
        let plain =
            self.variables.iter().all(|described| described.name.is_ascii() && quotes_match(&described.name));
        let root = Element::new("fmiModelDescription")
            .with("fmiVersion", number)
            .with("modelName", self.name)
            .with(token, self.token)
            .with("description", title)
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
            .with("canHandleVariableCommunicationStepSize", "true")
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
                .number("fixedInternalStepSize", Some(self.internal_step)),
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
        element.number("stepSize", Some(self.internal_step)).closed()
    }

    /// No output depends on an input of the same instant: what acts shows after the next step.
    fn structure(&self) -> String {
        let outputs = || {
            let all = self.variables.iter().enumerate();
            all.filter(|(_, described)| is_output(described.variable))
        };
        let unknown = |element: &str, (place, described): (usize, &Described)| {
            let element = Element::new(element);
            let element = match self.version {
                FmiVersion::Two => element.with("index", &(place + 1).to_string()),
                FmiVersion::Three => element.with("valueReference", &described.reference.to_string()),
            };
            element.always("dependencies", "").closed()
        };
        let known = |described: &Described| described.start.is_some();
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
            Category::Error => "Refused calls; they are told in any case",
            Category::Event => "What an instance has opened",
        };
        let name = category.name().to_str().unwrap_or_default();
        Element::new("Category").with("name", name).with("description", text).closed()
    };
    Element::new("LogCategories").around("LogCategories", &Category::ALL.map(category))
}

/// Whether a name is one of the structured naming: what is no identifier is quoted.
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

impl Described {
    /// What both versions say in the same words.
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
        let range = self.range.map_or([None; 2], |range| range.map(Some));
        let element = element.with("unit", &self.unit);
        element.number("min", range[0]).number("max", range[1]).number("start", self.start)
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
