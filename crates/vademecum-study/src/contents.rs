//! Contents of a file that need no stepping: names, numbers, the geometry.
//!
//! Sections may be compressed; each is decoded where it is asked for.

use serde::Serialize;
use vademecum_build::certificate::FileFigures;
use vademecum_build::dynamics::ModeRow;
use vademecum_build::mesh_error::RefinedValue;
use vademecum_format::{Element, File, Section, SectionKind};
use vademecum_rewrite::{decode, default_limit};

use crate::error::FileError;

/// Units of a file whose numbers are m, s, N, J and Pa.
pub(crate) const SI: &str = "SI: m, kg, s, N, Pa";

/// True of a file in SI units.
#[must_use]
pub fn is_si(file: &File<'_>) -> bool {
    file.metadata().units == SI
}

/// Limit on the decoded size of a section. A caller who allows more hands over a file that is raw already.
fn limit(file: &File<'_>) -> u64 {
    default_limit(file.bytes().len())
}

/// Lines of a text section, such as names; none if the file does not have it.
///
/// # Errors
/// [`FileError::Rewrite`]: a section that cannot be decoded, or is no text.
pub fn lines(file: &File<'_>, kind: SectionKind) -> Result<Vec<String>, FileError> {
    let Some(section) = file.section(kind) else { return Ok(vec![]) };
    let raw = decode(&section, limit(file))?;
    Ok(vademecum_rewrite::lines(kind, &raw)?.into_iter().map(str::to_string).collect())
}

/// Real numbers of a section; none if the file does not have it.
///
/// # Errors
/// [`FileError::Rewrite`]: a section that cannot be decoded.
pub fn numbers(file: &File<'_>, kind: SectionKind) -> Result<Vec<f64>, FileError> {
    let Some(section) = file.section(kind) else { return Ok(vec![]) };
    Ok(vademecum_rewrite::numbers(&section, &decode(&section, limit(file))?)?)
}

/// Damping ratios of the modes, if the file has them; those by dashpots included, which couple modes besides.
///
/// # Errors
/// As [`numbers`].
pub fn damping_ratios(file: &File<'_>) -> Result<Vec<f64>, FileError> {
    let rows = numbers(file, SectionKind::DampingRows)?;
    let mut ratios = numbers(file, SectionKind::DampingRatios)?;
    if rows.is_empty() {
        return Ok(ratios);
    }
    let values = numbers(file, SectionKind::Eigenvalues)?;
    ratios.resize(values.len(), 0.0);
    for row in rows.chunks_exact(values.len().max(1)) {
        for ((ratio, d), value) in ratios.iter_mut().zip(row).zip(&values) {
            *ratio += 0.5 * d * d / value.sqrt();
        }
    }
    Ok(ratios)
}

/// Whole numbers of a section, each of 4 or 8 bytes; none if the file does not have it.
///
/// # Errors
/// As [`numbers`]; [`FileError::Format`]: an index that is not below what it counts.
pub(crate) fn indices(file: &File<'_>, kind: SectionKind) -> Result<Vec<u64>, FileError> {
    let Some(section) = file.section(kind) else { return Ok(vec![]) };
    let raw = decode(&section, limit(file))?;
    if section.element() == Element::U64 {
        return Ok(raw.as_chunks().0.iter().map(|&bytes| u64::from_le_bytes(bytes)).collect());
    }
    let indices = raw.as_chunks().0;
    file.check_indices(kind, indices)?;
    Ok(indices.iter().map(|&bytes| u64::from(u32::from_le_bytes(bytes))).collect())
}

/// Figures of each structure beside its certificate; `None` if the file does not have them.
///
/// # Errors
/// As [`numbers`].
pub fn figures(file: &File<'_>) -> Result<FileFigures, FileError> {
    Ok(FileFigures::from_numbers(&numbers(file, SectionKind::StructureFigures)?))
}

/// The largest share of a static answer that the modes leave out, over loadable nodes and directions; mass
/// norm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// At the worst node, in its worst direction.
    pub worst: f64,
    /// Median over nodes and directions.
    pub median: f64,
    /// 95th percentile of the same.
    pub p95: f64,
    /// `bound`: it holds at every instant after a jump of the load; `estimate`: it does not have to.
    pub kind: &'static str,
}

/// Truncation error of static responses; `None` if the file does not have it.
///
/// # Errors
/// As [`numbers`].
pub fn bound(file: &File<'_>) -> Result<Option<Bound>, FileError> {
    let found = numbers(file, SectionKind::StaticBound)?;
    Ok(found.first_chunk().map(|&[rigorous, worst, median, p95]| Bound {
        worst,
        median,
        p95,
        kind: if rigorous == 1.0 { "bound" } else { "estimate" },
    }))
}

/// Discretisation error of the lowest natural frequencies, as the build estimated it; empty if the file does
/// not have it.
///
/// # Errors
/// As [`numbers`].
pub fn mesh_errors(file: &File<'_>) -> Result<Vec<RefinedValue>, FileError> {
    let rows = numbers(file, SectionKind::MeshError)?;
    let value = |&[mesh, refined, bound]: &[f64; 3]| RefinedValue::of_mesh(mesh, refined, bound);
    Ok(rows.as_chunks().0.iter().map(value).collect())
}

/// The largest such share of each loadable node, in its worst direction; none if the file does not keep it.
///
/// # Errors
/// As [`numbers`].
pub fn bound_map(file: &File<'_>) -> Result<Vec<f64>, FileError> {
    let rows = numbers(file, SectionKind::BoundMap)?;
    Ok(rows.as_chunks::<7>().0.iter().map(|&[.., bound]| bound).collect())
}

/// A section that a study cannot do without.
pub(crate) fn section<'a>(file: &File<'a>, kind: SectionKind) -> Result<Section<'a>, FileError> {
    file.section(kind).ok_or(FileError::Missing { kind })
}

/// Nodes and surface triangles.
pub struct Geometry {
    /// Coordinates of all nodes \[m\], in the order of the file: those of the surface first.
    pub nodes: Vec<[f64; 3]>,
    /// Corners of the surface's triangles.
    pub triangles: Vec<[u32; 3]>,
}

impl Geometry {
    /// The geometry of a file.
    ///
    /// # Errors
    /// [`FileError::Missing`]: a file stripped of it; [`FileError::Format`], [`FileError::Rewrite`].
    pub fn of(file: &File<'_>) -> Result<Self, FileError> {
        section(file, SectionKind::NodeCoordinates)?;
        let nodes = numbers(file, SectionKind::NodeCoordinates)?.as_chunks().0.to_vec();
        section(file, SectionKind::Triangles)?;
        let corners = indices(file, SectionKind::Triangles)?;
        let triangles = corners.as_chunks::<3>().0.iter().map(|t| t.map(|node| node as u32)).collect();
        Ok(Self { nodes, triangles })
    }

    /// Positions of the surface's nodes that no mode moves.
    ///
    /// # Errors
    /// As [`numbers`].
    pub fn held(&self, file: &File<'_>) -> Result<Vec<[f64; 3]>, FileError> {
        let basis = numbers(file, SectionKind::SurfaceBasis)?;
        let rows = basis.chunks_exact(3 * file.metadata().n_modes as usize);
        let held = rows.zip(&self.nodes).filter(|(row, _)| row.iter().all(|&x| x == 0.0));
        Ok(held.map(|(_, &node)| node).collect())
    }
}

/// The table of modes; empty if the file does not keep it.
///
/// # Errors
/// As [`numbers`].
pub fn mode_table(file: &File<'_>) -> Result<Vec<ModeRow>, FileError> {
    let row = |&[frequency_hz, rayleigh_quotient, energy, physical, numerical, period_elongation]: &[f64;
                    6]| ModeRow {
        frequency_hz,
        rayleigh_quotient,
        energy,
        physical_damping: physical,
        numerical_damping: numerical,
        period_elongation,
    };
    Ok(numbers(file, SectionKind::ModeTable)?.as_chunks().0.iter().map(row).collect())
}
