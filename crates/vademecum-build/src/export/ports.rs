//! Sections of the ports.

use faer::MatRef;
use vademecum_format::{PORT_FACET_NODES, PortKind, SectionKind as S};

use super::{Draft, NodeOrder};
use crate::input::Precision;
use crate::prepared::{Body, Port};
use crate::residual::PortFlexibility;

/// Sections 95 to 106.
pub(crate) fn port_sections(
    body: &Body,
    order: &NodeOrder,
    vectors: MatRef<'_, f64>,
    found: &PortFlexibility,
    precision: Precision,
) -> Vec<Draft> {
    let (ports, r) = (&body.ports, vectors.ncols());
    let m = found.surface.len();
    let (mut table, mut nodes, mut facets) = (vec![], vec![], vec![]);
    let mut row = 0;
    for port in ports {
        let kind = if port.nodes.is_empty() { PortKind::Frame } else { PortKind::Patch };
        let place = |node: &u32| port.nodes.binary_search(node).map_or(u32::MAX, |place| place as u32);
        table.extend([kind as u32, row, port.rows.len() as u32]);
        table.extend([nodes.len() as u32, port.nodes.len() as u32]);
        table.extend([(facets.len() / PORT_FACET_NODES) as u32, port.facets.len() as u32]);
        nodes.extend(port.nodes.iter().map(|&node| order.file_node[node as usize]));
        for facet in &port.facets {
            let own = facet.nodes().iter().map(place);
            facets.extend(own.chain(std::iter::repeat(u32::MAX)).take(PORT_FACET_NODES));
        }
        row += port.rows.len() as u32;
    }
    let value = |row: &[(u32, f64)], k: usize| -> f64 {
        row.iter().map(|&(free, weight)| weight * vectors[(free as usize, k)]).sum()
    };
    let rows = ports.iter().flat_map(|port| &port.rows);
    let rows = rows.flat_map(|row| (0..r).map(move |k| value(row, k)));
    let frame = |port: &Port| port.origin.into_iter().chain(port.axes.into_iter().flatten());
    let surface = found.surface.concat();
    let mut drafts = vec![
        Draft::names(S::PortNames, ports.iter().map(|port| port.name.as_str())),
        Draft::u32s(S::PortTable, [ports.len(), 7, 1], table),
        Draft::f64s(S::PortFrames, [ports.len(), 12, 1], ports.iter().flat_map(frame)),
        Draft::f64s(S::PortRows, [m, r, 1], rows),
        Draft::f64s(S::PortCompliance, [m, m, 1], found.compliance.iter().copied()),
        Draft::f64s(S::PortInertia, [m, m, 1], found.inertia.iter().copied()),
    ];
    if !nodes.is_empty() {
        drafts.push(Draft::u32s(S::PortNodes, [nodes.len(), 1, 1], nodes));
        let count = facets.len() / PORT_FACET_NODES;
        drafts.push(Draft::u32s(S::PortFacets, [count, PORT_FACET_NODES, 1], facets));
    }
    if order.n_surface > 0 {
        let shape = [m, order.n_surface, 3];
        drafts.push(Draft::fitting(S::PortResidual, precision, shape, surface.as_flattened()));
    }
    if !body.probes.is_empty() {
        drafts.push(Draft::f64s(S::PortProbes, [m, body.probes.len(), 1], found.probes.concat()));
        if let Some(rigid) = body.model.pencil().rigid() {
            let places = &body.model.mesh().nodes;
            let motions = body.probes.iter().flat_map(|probe| {
                (0..6).map(|motion| {
                    let of_node = |&(node, weights): &(u32, [f64; 3])| -> f64 {
                        (0..3).map(|c| weights[c] * rigid.row(places, node as usize, c)[motion]).sum()
                    };
                    probe.nodes.iter().map(of_node).sum()
                })
            });
            drafts.push(Draft::f64s(S::ProbeMotions, [body.probes.len(), 6, 1], motions));
        }
    }
    if !body.patterns.is_empty() {
        drafts.push(Draft::f64s(S::PortPatterns, [m, body.patterns.len(), 1], found.patterns.concat()));
    }
    drafts
}
