//! `terminalsAndIcons.xml` of FMI 3: which variables are connected together.
//!
//! A terminal is a place where a force acts and motion is shown. Its force is an inflow, as a sum of forces
//! on a place is the force on it; what moves is a signal. Members match by their names (`plug`).

use vademecum_fmu::variables::Variable;

use super::variable::{VariableDescription, plain};
use super::xml::Element;

/// The text, if there is a terminal.
pub(super) fn terminals(variables: &[VariableDescription], points: &[String]) -> Option<String> {
    let mut all: Vec<String> =
        (0..).zip(points).map(|(index, name)| of_point(variables, index, name)).collect();
    let whole = [
        ("surface", "Nodes of the loadable surface", "surface_"),
        ("body", "Centre of the body in space", "body_"),
    ];
    for (name, text, start) in whole {
        let members: Vec<String> = variables
            .iter()
            .filter(|described| kind(described.variable).is_some() && is_whole(described.variable))
            .filter_map(|described| Some(member(described, described.name.strip_prefix(start)?)))
            .collect();
        if !members.is_empty() {
            all.push(terminal(name, text, &members));
        }
    }
    if all.is_empty() {
        return None;
    }
    let inside = Element::new("Terminals").around("Terminals", &all);
    let root = Element::new("fmiTerminalsAndIcons").with("fmiVersion", "3.0");
    let root = root.around("fmiTerminalsAndIcons", &[inside]);
    Some(format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{root}\n"))
}

fn of_point(variables: &[VariableDescription], index: u32, name: &str) -> String {
    let members: Vec<String> = variables
        .iter()
        .filter_map(|described| match described.variable {
            Variable::Force(at, _) | Variable::Displacement(at, _) | Variable::Velocity(at, _)
                if at == index =>
            {
                let (kind, component) = described.variable.kind();
                Some(member(described, &format!("{kind}.{}", component.unwrap_or_default())))
            }
            _ => None,
        })
        .collect();
    terminal(&format!("point.{}", plain(name)), &format!("The point {name}"), &members)
}

fn terminal(name: &str, text: &str, members: &[String]) -> String {
    let element = Element::new("Terminal").with("name", name).with("matchingRule", "plug");
    element.with("description", text).around("Terminal", members)
}

fn member(described: &VariableDescription, name: &str) -> String {
    Element::new("TerminalMemberVariable")
        .with("variableName", &described.name)
        .with("memberName", name)
        .with("variableKind", kind(described.variable).unwrap_or_default())
        .closed()
}

/// Kind of a member; `None` of what belongs to no terminal.
const fn kind(variable: Variable) -> Option<&'static str> {
    use Variable as V;
    match variable {
        V::Force(..) | V::SurfaceForce | V::BodyForce(_) => Some("inflow"),
        V::Displacement(..) | V::Velocity(..) => Some("signal"),
        V::SurfaceDisplacement | V::SurfaceVelocity => Some("signal"),
        V::BodyPosition(_) | V::BodyVelocity(_) => Some("signal"),
        _ => None,
    }
}

/// True of what belongs to the surface or to the body as a whole.
const fn is_whole(variable: Variable) -> bool {
    !matches!(variable, Variable::Force(..) | Variable::Displacement(..) | Variable::Velocity(..))
}
