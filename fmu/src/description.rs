//! An FMU's `modelDescription.xml` (FMI 3.0, section 2.4).

use std::fmt::Write as _;

use crate::component::{Component, Content};
use crate::variable::{Causality, UNITS, Value, Variability, Variable};

/// The step that tools suggest, s: one of the core's at 400 Hz.
const STEP_S: f64 = 2.5e-3;

/// How long a tool simulates where nobody says, s.
const STOP_S: f64 = 10.0;

/// Categories of messages, with names that the standard suggests.
const LOG_CATEGORIES: [(&str, &str); 2] =
    [("logStatusError", "what was refused, and why"), ("logStatusFatal", "a mistake in this FMU")];

/// What the description says beside the variables.
#[derive(Clone, Debug)]
pub struct Heading<'a> {
    /// What it is.
    pub content: Content,
    /// Name of the shared library and of the FMU.
    pub identifier: &'a str,
    /// The vehicle's name.
    pub vehicle: &'a str,
    /// Text of the model file.
    pub model_text: &'a str,
}

/// The whole file.
pub fn model_description(heading: &Heading<'_>, component: &Component) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let what = match heading.content {
        Content::Plant => "plant",
        Content::PlantWithImu => "plant with its IMU",
        Content::Controller => "control core",
    };
    let name = escaped(&format!("{}: {what}", heading.vehicle));
    let token = heading.content.token(heading.model_text);
    let version = env!("CARGO_PKG_VERSION");
    line(&mut xml, 0, &format!("<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{name}\""));
    line(&mut xml, 1, &format!("instantiationToken=\"{token}\" version=\"{version}\""));
    line(&mut xml, 1, "license=\"MIT OR Apache-2.0\" generationTool=\"cargo xtask fmu\"");
    line(&mut xml, 1, "variableNamingConvention=\"structured\">");
    interfaces(&mut xml, heading);
    units(&mut xml);
    line(&mut xml, 1, "<LogCategories>");
    for (category, what) in LOG_CATEGORIES {
        line(&mut xml, 2, &format!("<Category name=\"{category}\" description=\"{what}\"/>"));
    }
    line(&mut xml, 1, "</LogCategories>");
    let step = format!("<DefaultExperiment startTime=\"0\" stopTime=\"{STOP_S}\" stepSize=\"{STEP_S}\"/>");
    line(&mut xml, 1, &step);
    variables(&mut xml, component.variables());
    structure(&mut xml, component.variables());
    line(&mut xml, 0, "</fmiModelDescription>");
    xml
}

fn interfaces(xml: &mut String, heading: &Heading<'_>) {
    let identifier = heading.identifier;
    let state = "canGetAndSetFMUState=\"true\" canSerializeFMUState=\"false\"";
    if heading.content.is_for_model_exchange() {
        let model_exchange = format!("<ModelExchange modelIdentifier=\"{identifier}\" {state}");
        line(xml, 1, &model_exchange);
        line(xml, 2, "needsCompletedIntegratorStep=\"true\"/>");
    }
    line(xml, 1, &format!("<CoSimulation modelIdentifier=\"{identifier}\" {state}"));
    line(xml, 2, "canHandleVariableCommunicationStepSize=\"true\"/>");
}

fn units(xml: &mut String) {
    line(xml, 1, "<UnitDefinitions>");
    for unit in UNITS {
        let exponents: Vec<String> = unit.base.iter().map(|(base, power)| format!("{base}=\"{power}\"")).collect();
        let base = format!("<BaseUnit {}/>", exponents.join(" "));
        line(xml, 2, &format!("<Unit name=\"{}\">", unit.name));
        line(xml, 3, &base);
        if let Some((display, factor)) = unit.display {
            line(xml, 3, &format!("<DisplayUnit name=\"{display}\" factor=\"{factor}\"/>"));
        }
        line(xml, 2, "</Unit>");
    }
    line(xml, 1, "</UnitDefinitions>");
}

fn variables(xml: &mut String, variables: &[Variable]) {
    line(xml, 1, "<ModelVariables>");
    let time = "<Float64 name=\"time\" valueReference=\"0\" causality=\"independent\" variability=\"continuous\" \
                unit=\"s\"/>";
    line(xml, 2, time);
    for (place, variable) in variables.iter().enumerate() {
        line(xml, 2, &element(place, variable));
    }
    line(xml, 1, "</ModelVariables>");
}

fn element(place: usize, variable: &Variable) -> String {
    let kind = variable.start.type_name();
    let causality = match variable.causality {
        Causality::Parameter => "parameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
    };
    let variability = match variable.variability {
        Variability::Fixed => "fixed",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    };
    let (name, reference) = (escaped(&variable.name), place + 1);
    let mut element = format!("<{kind} name=\"{name}\" valueReference=\"{reference}\"");
    let _ = write!(element, " causality=\"{causality}\" variability=\"{variability}\"");
    let _ = write!(element, " description=\"{}\"", escaped(&variable.description));
    if !variable.unit.is_empty() {
        let _ = write!(element, " unit=\"{}\"", variable.unit);
    }
    if let Some(state) = variable.derivative_of {
        let _ = write!(element, " derivative=\"{}\"", state + 1);
    }
    let is_input = variable.causality == Causality::Input;
    if !is_input {
        let _ = write!(element, " initial=\"{}\"", if variable.is_calculated { "calculated" } else { "exact" });
    }
    let start = match &variable.start {
        _ if !variable.has_start() => None,
        Value::Float(number) => Some(number.to_string()),
        Value::Count(number) => Some(number.to_string()),
        Value::Boolean(is_so) => Some(is_so.to_string()),
        Value::Text(text) => return format!("{element}><Start value=\"{}\"/></{kind}>", escaped(text)),
    };
    if let Some(start) = start {
        let _ = write!(element, " start=\"{start}\"");
    }
    element + "/>"
}

/// Without dependencies: then each unknown may depend on everything.
fn structure(xml: &mut String, variables: &[Variable]) {
    let numbered = || variables.iter().enumerate().map(|(place, variable)| (place + 1, variable));
    line(xml, 1, "<ModelStructure>");
    for (reference, _) in numbered().filter(|(_, variable)| variable.causality == Causality::Output) {
        line(xml, 2, &format!("<Output valueReference=\"{reference}\"/>"));
    }
    for (reference, _) in numbered().filter(|(_, variable)| variable.derivative_of.is_some()) {
        line(xml, 2, &format!("<ContinuousStateDerivative valueReference=\"{reference}\"/>"));
    }
    for (reference, _) in numbered().filter(|(_, variable)| variable.is_calculated) {
        line(xml, 2, &format!("<InitialUnknown valueReference=\"{reference}\"/>"));
    }
    line(xml, 1, "</ModelStructure>");
}

fn line(xml: &mut String, depth: usize, text: &str) {
    let _ = writeln!(xml, "{:indent$}{text}", "", indent = 2 * depth);
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
