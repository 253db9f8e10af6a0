//! Stress of a run: columns of the table of probes, a table of all points, and fields.

use vademecum_eval::Tensor;
use vademecum_format::{File, SectionKind};

use crate::contents::{indices, numbers};
use crate::error::{FileError, StudyError};
use crate::near::FAR;
use crate::scenario::{StressEntry, StressQuantity};

/// Points of a file with stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct StressPlace {
    /// Node, in the order of the file.
    pub node: usize,
    /// Its id in the mesh file.
    pub id: u64,
    /// Region of the mesh, counted from 0.
    pub region: u32,
}

/// The largest equivalent stress of a run.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct LargestStress {
    /// Von Mises' equivalent stress \[Pa\].
    pub von_mises: f64,
    /// Point.
    #[serde(flatten)]
    pub place: StressPlace,
    /// Time \[s\].
    pub time: f64,
}

/// The points of a file with a stress; none if it has none.
///
/// # Errors
/// As [`indices`].
pub(crate) fn stress_places(file: &File<'_>) -> Result<Vec<StressPlace>, FileError> {
    let points = indices(file, SectionKind::StressPoints)?;
    if points.is_empty() {
        return Ok(vec![]);
    }
    let ids = indices(file, SectionKind::NodeIds)?;
    let place = |&[node, region]: &[u64; 2]| {
        // A stripped file has no ids.
        let id = ids.get(node as usize).copied().unwrap_or(node);
        StressPlace { node: node as usize, id, region: region as u32 }
    };
    Ok(points.as_chunks().0.iter().map(place).collect())
}

/// Points of a run with stress.
pub(crate) struct Stresses {
    /// All points.
    pub(crate) places: Vec<StressPlace>,
    columns: Vec<Column>,
}

/// A column of the table: the points of one node, and what of their stress is reported.
struct Column {
    points: Vec<usize>,
    quantity: StressQuantity,
}

impl Stresses {
    /// Places the columns that a scenario asks for at the nearest nodes with a stress, and says what is to
    /// tell of them.
    ///
    /// # Errors
    /// [`StudyError::ProbeTwice`]; [`StudyError::NoStress`]: a file without stress.
    pub(crate) fn place(
        file: &File<'_>,
        entries: &[StressEntry],
        known: &mut Vec<String>,
    ) -> Result<(Self, Vec<String>), StudyError> {
        let mut own = Self { places: stress_places(file)?, columns: vec![] };
        let mut notes = vec![];
        if entries.is_empty() {
            return Ok((own, notes));
        }
        if own.places.is_empty() {
            return Err(StudyError::NoStress);
        }
        let kind = SectionKind::NodeCoordinates;
        file.section(kind).ok_or(FileError::Missing { kind })?;
        let coordinates = numbers(file, kind)?;
        let nodes = coordinates.as_chunks::<3>().0;
        for entry in entries {
            if known.contains(&entry.name) {
                return Err(StudyError::ProbeTwice { name: entry.name.clone() });
            }
            known.push(entry.name.clone());
            let square = |place: &StressPlace| -> f64 {
                let at = nodes.get(place.node).copied().unwrap_or([f64::INFINITY; 3]);
                (0..3).map(|c| (at[c] - entry.point[c]).powi(2)).sum()
            };
            let nearest = own.places.iter().min_by(|a, b| square(a).total_cmp(&square(b)));
            let nearest = *nearest.ok_or(StudyError::NoStress)?;
            let [x, y, z] = nodes.get(nearest.node).copied().unwrap_or_default();
            let size = [x, y, z].iter().fold(0.0, |size: f64, x| size.max(x.abs()));
            let distance = square(&nearest).sqrt();
            if distance > FAR * size {
                notes.push(format!(
                    "stress `{}` is that of the nearest node with one, ({x:.6}, {y:.6}, {z:.6}), {distance:.3e} away \
                     from the point given",
                    entry.name
                ));
            }
            let of_node =
                |(point, place): (usize, &StressPlace)| (place.node == nearest.node).then_some(point);
            let points = own.places.iter().enumerate().filter_map(of_node).collect();
            own.columns.push(Column { points, quantity: entry.quantity });
        }
        Ok((own, notes))
    }

    /// Number of columns.
    pub(crate) fn n_columns(&self) -> usize {
        self.columns.len()
    }

    /// A column, of the stresses of all points: between two regions the value of the larger size.
    pub(crate) fn column(&self, column: usize, stresses: &[Tensor]) -> f64 {
        let Column { points, quantity } = &self.columns[column];
        let values = points.iter().map(|&point| quantity.of(&stresses[point]));
        values.fold(0.0, |most: f64, value| if value.abs() > most.abs() { value } else { most })
    }

    /// The largest equivalent stress of all points.
    pub(crate) fn largest(&self, stresses: &[Tensor], time: f64) -> Option<LargestStress> {
        let all = stresses.iter().map(Tensor::von_mises).zip(&self.places);
        let (von_mises, &place) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(LargestStress { von_mises, place, time })
    }

    /// Stress and equivalent stress of each of so many nodes, shape (nodes, 6) and (nodes); NaN where it is
    /// not known, and between two regions that of the larger equivalent stress.
    pub(crate) fn fields(&self, stresses: &[Tensor], stress: &mut [f64], von_mises: &mut [f64]) {
        stress.fill(f64::NAN);
        von_mises.fill(f64::NAN);
        let rows = stress.as_chunks_mut::<6>().0;
        for (place, value) in self.places.iter().zip(stresses) {
            if let (Some(row), Some(known)) = (rows.get_mut(place.node), von_mises.get_mut(place.node)) {
                let found = value.von_mises();
                if known.is_nan() || found > *known {
                    (*row, *known) = (value.0, found);
                }
            }
        }
    }
}

impl StressQuantity {
    /// Value of a stress \[Pa\].
    fn of(self, stress: &Tensor) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = stress.0;
        let [first, second, third] = stress.principal();
        match self {
            Self::VonMises => stress.von_mises(),
            Self::SignedMaximum => stress.signed_maximum(),
            Self::First => first,
            Self::Second => second,
            Self::Third => third,
            Self::Xx => xx,
            Self::Yy => yy,
            Self::Zz => zz,
            Self::Xy => xy,
            Self::Yz => yz,
            Self::Zx => zx,
        }
    }
}
