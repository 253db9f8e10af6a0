//! Modes and frequency responses of a file as datasets.

use std::collections::BTreeSet;

use vademecum_eval::SceneOptions;
use vademecum_format::{File, SectionKind};

use super::error::UffError;
use super::write::{Datasets, Dof, Function};
use crate::contents::{Geometry, indices, numbers};
use crate::error::{FileError, StudyError};
use crate::frf::{
    Channel, Quantity, ResponsePoint, ResponseRequest, Side, at_probe, frequency_response, place,
};
use crate::modal::ModalModel;

/// Largest label of a node: ten columns.
const LARGEST_LABEL: u64 = 9_999_999_999;

/// Frequency responses of a request; none if there are no inputs.
#[derive(Clone, Debug)]
pub struct UffRequest {
    /// Points of forces, and load patterns.
    pub inputs: Vec<Channel>,
    /// Outputs.
    pub outputs: Vec<Channel>,
    /// Frequencies \[Hz\].
    pub frequencies: Vec<f64>,
    /// Displacement, velocity or acceleration.
    pub quantity: Quantity,
}

/// A universal file, as text.
#[derive(Debug)]
pub struct UffExport {
    /// Its text.
    pub text: String,
    /// Nodes of dataset 15.
    pub nodes: usize,
    /// Modes, datasets 55.
    pub modes: usize,
    /// Functions, datasets 58.
    pub functions: usize,
    /// Channels at other places than asked for, in sentences.
    pub notes: Vec<String>,
}

impl UffExport {
    /// Units, nodes and lines of the surface, modes, and the frequency responses of a request.
    ///
    /// # Errors
    /// [`StudyError`]; [`StudyError::Uff`]: a channel along no axis, a label of too many digits.
    pub fn new(file: &File<'_>, options: &SceneOptions, request: &UffRequest) -> Result<Self, StudyError> {
        let geometry = Geometry::of(file)?;
        let count = file.metadata().n_surface_nodes as usize;
        let mut labels = indices(file, SectionKind::NodeIds)?;
        if labels.is_empty() {
            labels = (1..=geometry.nodes.len() as u64).collect();
        }
        labels.truncate(count);
        if let Some(&node) = labels.iter().find(|label| **label > LARGEST_LABEL) {
            return Err(UffError::Label { node }.into());
        }
        let title = "vademecum";
        let mut sets = Datasets::default();
        sets.units();
        let nodes: Vec<(u64, [f64; 3])> =
            labels.iter().copied().zip(geometry.nodes.iter().copied()).collect();
        sets.nodes(&nodes);
        let edges: BTreeSet<[u32; 2]> = geometry
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]))
            .collect();
        let pairs: Vec<[u64; 2]> =
            edges.into_iter().map(|pair| pair.map(|node| labels[node as usize])).collect();
        sets.lines("edges of the surface", &pairs);
        let reduced = ModalModel::of(file, options)?;
        let (shapes, modes) = reduced.normal_modes();
        let basis = numbers(file, SectionKind::SurfaceBasis)?;
        let r = file.metadata().n_modes as usize;
        if basis.len() < 3 * count * r {
            return Err(FileError::Missing { kind: SectionKind::SurfaceBasis }.into());
        }
        for (k, [omega, sigma]) in modes.iter().enumerate() {
            let of_dof = |dof: usize| -> f64 {
                basis[dof * r..(dof + 1) * r].iter().enumerate().map(|(i, b)| b * shapes[(i, k)]).sum()
            };
            let shape = labels.iter().enumerate();
            let shape = shape.map(|(node, &label)| (label, [0, 1, 2].map(|c| of_dof(3 * node + c))));
            let ratio = if *omega > 0.0 { sigma / omega } else { 0.0 };
            sets.mode(title, k + 1, [omega / std::f64::consts::TAU, ratio], shape);
        }
        let mut own =
            Self { text: String::new(), nodes: nodes.len(), modes: modes.len(), functions: 0, notes: vec![] };
        own.functions(file, options, request, (&nodes, &mut sets))?;
        own.text = sets.0;
        Ok(own)
    }

    fn functions(
        &mut self,
        file: &File<'_>,
        options: &SceneOptions,
        request: &UffRequest,
        (nodes, sets): (&[(u64, [f64; 3])], &mut Datasets),
    ) -> Result<(), StudyError> {
        let outputs = request.outputs.iter().map(|channel| at_node(file, channel, Side::Output, nodes));
        let outputs: Vec<(Channel, Dof)> = outputs.collect::<Result<_, _>>()?;
        let kind = match request.quantity {
            Quantity::Displacement => 8,
            Quantity::Velocity => 11,
            Quantity::Acceleration => 12,
        };
        for channel in &request.inputs {
            let (input, reference) = at_node(file, channel, Side::Input, nodes)?;
            let asked = ResponseRequest {
                input,
                outputs: outputs.iter().map(|(channel, _)| channel.clone()).collect(),
                frequencies: request.frequencies.clone(),
                quantity: request.quantity,
            };
            let found = frequency_response(file, options, &asked)?;
            self.notes.extend(found.notes);
            for output in found.by_modes_alone {
                self.notes.push(format!(
                    "`{}` under `{}` is by the modes alone: name a probe there in the problem file, or build it \
                     with `static_fields = true`",
                    outputs[output].1.name, reference.name
                ));
            }
            for ((_, response), values) in outputs.iter().zip(&found.values) {
                self.functions += 1;
                let function = Function {
                    number: self.functions,
                    response,
                    reference: &reference,
                    kind,
                    reference_kind: if found.by_pattern { 1 } else { 13 },
                    frequencies: &request.frequencies,
                    values,
                };
                sets.function("frequency response of a vademecum file", &function);
            }
        }
        Ok(())
    }
}

/// The channel at the nearest node along an axis, and what dataset 58 calls it. A probe keeps its own row of
/// the file; one that is at no loadable node or along no axis has node 0, and so has a load pattern.
fn at_node(
    file: &File<'_>,
    channel: &Channel,
    side: Side,
    nodes: &[(u64, [f64; 3])],
) -> Result<(Channel, Dof), StudyError> {
    let name = channel.to_string();
    let placed = match (place(file, channel, side)?, channel, side) {
        (ResponsePoint::Named(_), Channel::Named(probe), Side::Output) => at_probe(file, probe)?,
        (placed, ..) => Some(placed),
    };
    let none = Dof { name: name.clone(), node: 0, direction: 0 };
    let Some(ResponsePoint::Point(at, direction)) = placed else { return Ok((channel.clone(), none)) };
    let Some(axis) = direction.iter().position(|x| x.abs() == 1.0) else {
        if let Channel::Named(_) = channel {
            return Ok((channel.clone(), none));
        }
        let [x, y, z] = direction;
        return Err(UffError::Direction { channel: name, direction: format!("({x} {y} {z})") }.into());
    };
    let heaviest = at.place.entries().max_by(|a, b| a.1.total_cmp(&b.1));
    let node = heaviest.map_or(0, |(node, _)| node as usize);
    let (label, position) = nodes[node.min(nodes.len().saturating_sub(1))];
    let sign = if direction[axis] < 0.0 { -1 } else { 1 };
    let dof = Dof { name, node: label, direction: sign * (axis as i32 + 1) };
    let channel = match channel {
        Channel::Named(_) => channel.clone(),
        Channel::Point(..) => Channel::Point(position, direction),
    };
    Ok((channel, dof))
}
