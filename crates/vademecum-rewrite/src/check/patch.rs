//! Checks of the residual flexibility between contacts near each other: sections that go together, ascending
//! pairs with each node among them, blocks of single nodes that store energy.

use vademecum_format::{File, SectionKind as S};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};
use super::residual::ROUNDED;
use super::symmetric::negative_pivot;

/// Sections 107 to 110, if the file has any of them.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    let needed = [S::ContactPatch, S::PatchPairs, S::PatchResidual];
    let mut all = needed.into_iter().chain([S::ContactModes]);
    let Some(there) = all.find(|kind| file.section(*kind).is_some()) else { return Ok(()) };
    if let Some(missing) =
        needed.into_iter().chain([S::ContactResidual]).find(|kind| file.section(*kind).is_none())
    {
        let reason = format!("without section {} ({missing}) no contact is answered", missing.number());
        return Err(unsound(there, Fault::Disagrees, reason));
    }
    if !file.metadata().diagonal {
        let reason = "it belongs to the diagonal structure, which the file does not have";
        return Err(unsound(there, Fault::Disagrees, reason.into()));
    }
    let Some(patch) = file.contact_patch()? else { return Ok(()) };
    if patch.distance.is_nan() || patch.distance <= 0.0 {
        let reason = format!("the distance is {}; expected a number above 0", patch.distance);
        return Err(unsound(S::ContactPatch, Fault::Negative, reason));
    }
    let rows = file.section(S::PatchResidual).map_or(0, |section| section.shape()[0]);
    if rows != patch.pairs.len() as u64 {
        let reason = format!("{} pairs, and {rows} blocks in section 109", patch.pairs.len());
        return Err(unsound(S::PatchPairs, Fault::Disagrees, reason));
    }
    pairs(patch.pairs, file.metadata().n_load_nodes)?;
    let blocks = reals_of(file, S::PatchResidual)?.unwrap_or_default();
    for (pair, block) in patch.pairs.iter().zip(blocks.as_chunks::<9>().0) {
        let [node, other] = pair.map(u32::from_le_bytes);
        if node == other {
            own(node, *block)?;
        }
    }
    Ok(())
}

/// Pairs ascend, the first at most the second, and each loadable node is one with itself.
fn pairs(pairs: &[[[u8; 4]; 2]], nodes: u32) -> Result<(), RewriteError> {
    let mut before = None;
    let mut own = 0;
    for (place, pair) in pairs.iter().enumerate() {
        let [first, second] = pair.map(u32::from_le_bytes);
        if first > second || before.is_some_and(|before| before >= [first, second]) {
            let reason = format!(
                "pair {place} is ({first}, {second}); the first is at most the second, and pairs ascend"
            );
            return Err(unsound(S::PatchPairs, Fault::Twice, reason));
        }
        own += u32::from(first == second);
        before = Some([first, second]);
    }
    if own == nodes {
        return Ok(());
    }
    let reason = format!("{own} of its pairs are a node with itself; the file has {nodes} loadable nodes");
    Err(unsound(S::PatchPairs, Fault::Disagrees, reason))
}

/// The block of a node with itself is symmetric and takes no negative value.
fn own(node: u32, block: [f64; 9]) -> Result<(), RewriteError> {
    let largest = block.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let off = [(1, 3), (2, 6), (5, 7)].map(|(i, j)| (block[i] - block[j]).abs());
    if off.iter().any(|off| *off > ROUNDED * largest) {
        let reason = format!("the block of node {node} with itself is {block:?}; expected a symmetric one");
        return Err(unsound(S::PatchResidual, Fault::NotSymmetric, reason));
    }
    let mut eliminated = block;
    if negative_pivot(&mut eliminated, 3, |_| ROUNDED * largest).is_some() {
        let reason = format!(
            "the block of node {node} with itself is {block:?}, which takes a negative value; it is positive \
             semidefinite"
        );
        return Err(unsound(S::PatchResidual, Fault::Negative, reason));
    }
    Ok(())
}
