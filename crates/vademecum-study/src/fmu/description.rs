//! `modelDescription.xml` of both versions.

use vademecum_fmu::logger::Category;
use vademecum_format::Metadata;

use super::variable::{VariableDescription, quotes_match};
use super::version::FmiVersion;
use super::xml::Element;

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
    /// True of a body whose step is linear, which has derivatives.
    pub(crate) linear: bool,
    /// True of a body with large displacements, whose training has a limit.
    pub(crate) bends_far: bool,
    /// Title of the problem; may be empty.
    pub(crate) title: String,
    pub(crate) variables: &'a [VariableDescription],
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
            self.variables.iter().map(|d| if two { d.scalar_variable() } else { d.typed() }).collect();
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
            .with("canHandleVariableCommunicationStepSize", truth(self.any_step))
            .with("canBeInstantiatedOnlyOncePerProcess", "false");
        match self.version {
            FmiVersion::Two => element
                .with("canInterpolateInputs", "false")
                .with("maxOutputDerivativeOrder", "0")
                .with("canRunAsynchronuously", "false")
                .with("canNotUseMemoryManagementFunctions", "true")
                .with("canGetAndSetFMUstate", "true")
                .with("canSerializeFMUstate", "true")
                .with("providesDirectionalDerivative", truth(self.linear)),
            FmiVersion::Three => element
                .with("canGetAndSetFMUState", "true")
                .with("canSerializeFMUState", "true")
                .with("providesDirectionalDerivatives", truth(self.linear))
                .with("providesAdjointDerivatives", truth(self.linear))
                .with("maxOutputDerivativeOrder", "0")
                .with("providesIntermediateUpdate", "true")
                .with("mightReturnEarlyFromDoStep", truth(self.bends_far))
                .with("canReturnEarlyAfterIntermediateUpdate", "true")
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
        let unknown = |element: &str, (place, described): (usize, &VariableDescription)| {
            let element = Element::new(element);
            let element = match self.version {
                FmiVersion::Two => element.with("index", &(place + 1).to_string()),
                FmiVersion::Three => element.with("valueReference", &described.reference.to_string()),
            };
            element.always("dependencies", "").closed()
        };
        let all = || self.variables.iter().enumerate();
        let list = |element: &str| -> Vec<String> {
            let outputs = all().filter(|(_, described)| described.variable.is_output());
            outputs.map(|output| unknown(element, output)).collect()
        };
        let initial = |element: &str| -> Vec<String> {
            let unknowns = all().filter(|(_, described)| described.is_initial_unknown());
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

const fn truth(is_true: bool) -> &'static str {
    if is_true { "true" } else { "false" }
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
