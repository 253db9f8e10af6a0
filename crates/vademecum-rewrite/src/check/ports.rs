//! Checks of the ports: sections that fit one another, axes, facets, symmetric compliance and inertia.

use std::collections::HashSet;

use vademecum_format::{File, PORT_COLUMNS, PORT_FACET_NODES, PortRange, SectionKind as S};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};
use super::names::lines;
use super::symmetric::{Sizes, unsymmetric};

/// Largest distance of products of axes from those of orthonormal ones.
const TOLERANCE: f64 = 1e-9;

/// Sections 95 to 105, if the file has ports.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    let needed = [S::PortNames, S::PortTable, S::PortFrames, S::PortRows, S::PortCompliance];
    let others =
        [S::PortNodes, S::PortFacets, S::PortInertia, S::PortResidual, S::PortProbes, S::PortPatterns];
    let all = needed.into_iter().chain(others);
    let Some(there) = all.into_iter().find(|kind| file.section(*kind).is_some()) else { return Ok(()) };
    if let Some(missing) = needed.into_iter().find(|kind| file.section(*kind).is_none()) {
        let reason = format!("without section {} ({missing}) it joins nothing", missing.number());
        return Err(unsound(there, Fault::Disagrees, reason));
    }
    let table = file.port_table()?;
    let (rows, nodes, facets) = ranges(table)?;
    names(file, table.len())?;
    let counted = [
        (S::PortFrames, 0, table.len()),
        (S::PortRows, 0, rows),
        (S::PortCompliance, 0, rows),
        (S::PortCompliance, 1, rows),
        (S::PortInertia, 0, rows),
        (S::PortInertia, 1, rows),
        (S::PortResidual, 0, rows),
        (S::PortProbes, 0, rows),
        (S::PortPatterns, 0, rows),
    ];
    for (kind, place, expected) in counted {
        let Some(section) = file.section(kind) else { continue };
        fits(kind, section.shape()[place], expected)?;
    }
    for (kind, expected) in [(S::PortNodes, nodes), (S::PortFacets, facets)] {
        fits(kind, file.section(kind).map_or(0, |section| section.shape()[0]), expected)?;
    }
    axes(&reals_of(file, S::PortFrames)?.unwrap_or_default())?;
    for kind in [S::PortCompliance, S::PortInertia] {
        let Some(matrix) = reals_of(file, kind)? else { continue };
        let sizes = Sizes::of(&matrix, rows);
        if let Some([i, j]) = unsymmetric(&matrix, rows, |k, l| sizes.tolerance(k, l)) {
            let reason =
                format!("entry ({i}, {j}) differs from entry ({j}, {i}); expected a symmetric matrix");
            return Err(unsound(kind, Fault::NotSymmetric, reason));
        }
        if let Some(k) = (0..rows).find(|k| matrix[k * rows + k] < -sizes.tolerance(*k, *k)) {
            let reason = format!("entry ({k}, {k}) is {}; expected 0 or more", matrix[k * rows + k]);
            return Err(unsound(kind, Fault::Negative, reason));
        }
    }
    of_facets(file, table)
}

/// Rows, nodes and facets in all, if each port begins where the one before it ends.
fn ranges(table: &[[[u8; 4]; PORT_COLUMNS]]) -> Result<(usize, usize, usize), RewriteError> {
    let mut ends = [0; 3];
    for (port, row) in table.iter().enumerate() {
        let wrong = |expected: &str| {
            let row = row.map(u32::from_le_bytes);
            unsound(S::PortTable, Fault::Disagrees, format!("port {port} is {row:?}; expected {expected}"))
        };
        let range = PortRange::of(row).ok_or_else(|| {
            wrong("kind 0 with three rows a node, or kind 1 with six rows and no nodes and facets")
        })?;
        for (end, [first, count]) in ends.iter_mut().zip([range.rows, range.nodes, range.facets]) {
            if first != *end {
                return Err(wrong("rows, nodes and facets that begin where those of the port before it end"));
            }
            *end += count;
        }
    }
    let [rows, nodes, facets] = ends;
    Ok((rows, nodes, facets))
}

fn names(file: &File<'_>, count: usize) -> Result<(), RewriteError> {
    let kind = S::PortNames;
    let Some(section) = file.section(kind) else { return Ok(()) };
    let names = lines(kind, section.text()?.as_bytes())?;
    let mut seen = HashSet::new();
    let reason = if names.len() != count {
        format!("it has {} names, section 96 counts {count}", names.len())
    } else if let Some(name) = names.into_iter().find(|&name| name.is_empty() || !seen.insert(name)) {
        format!("the name `{name}` is empty or occurs twice")
    } else {
        return Ok(());
    };
    Err(RewriteError::Names { kind, reason })
}

fn fits(kind: S, found: u64, expected: usize) -> Result<(), RewriteError> {
    if found == expected as u64 {
        return Ok(());
    }
    let reason = format!("it has {found} rows; section 96 counts {expected}");
    Err(unsound(kind, Fault::Disagrees, reason))
}

/// Axes are orthonormal, and the third is the cross product of the others.
fn axes(frames: &[f64]) -> Result<(), RewriteError> {
    for (port, frame) in frames.as_chunks::<12>().0.iter().enumerate() {
        let axis = |k: usize| [frame[3 + 3 * k], frame[4 + 3 * k], frame[5 + 3 * k]];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let ([x, y], z) = ([axis(0), axis(1)], axis(2));
        let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
        let off = [dot(x, x) - 1.0, dot(y, y) - 1.0, dot(x, y), dot(cross, z) - 1.0, dot(z, z) - 1.0];
        if off.iter().any(|off| off.abs() > TOLERANCE) {
            let reason =
                format!("the axes of port {port} are {x:?}, {y:?}, {z:?}; expected orthonormal ones");
            return Err(unsound(S::PortFrames, Fault::Disagrees, reason));
        }
    }
    Ok(())
}

/// Facets have three, four, six, eight or nine nodes of their port.
fn of_facets(file: &File<'_>, table: &[[[u8; 4]; PORT_COLUMNS]]) -> Result<(), RewriteError> {
    let Some(section) = file.section(S::PortFacets) else { return Ok(()) };
    let facets = section.u32s()?.as_chunks::<PORT_FACET_NODES>().0;
    for range in table.iter().filter_map(PortRange::of) {
        let [first, count] = range.facets;
        for (place, facet) in facets.iter().enumerate().skip(first).take(count) {
            let facet = facet.map(u32::from_le_bytes);
            let own = facet.iter().take_while(|node| **node != u32::MAX).count();
            let (nodes, rest) = facet.split_at(own);
            let sound = nodes.iter().all(|node| (*node as usize) < range.nodes[1]);
            let sound = sound && rest.iter().all(|node| *node == u32::MAX);
            if !sound || !matches!(own, 3 | 4 | 6 | 8 | 9) {
                let reason = format!(
                    "facet {place} is {facet:?}; expected 3, 4, 6, 8 or 9 of the {} nodes of its port",
                    range.nodes[1]
                );
                return Err(unsound(S::PortFacets, Fault::Disagrees, reason));
            }
        }
    }
    Ok(())
}
