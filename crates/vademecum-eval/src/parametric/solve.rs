//! Setting a parametric model to values: memory to lend, the eigenproblem, and the file.

use crate::base::lend::Lender;
use crate::kernels::dense::{factor, solve_lower_rows, solve_right, solve_upper};
use crate::kernels::lowest::{lowest_eigen, lowest_work};
use crate::parametric::error::ParametricError;
use crate::parametric::model::Parametric;
use crate::parametric::tuned::Tuned;
use crate::parametric::write::{Filler, Planned, planned, write_work};
use vademecum_format::{Certificate, File, MAX_PARAMETERS, Metadata, Parameter, encode_filled, filled_len};

/// Memory to lend for a parametric model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParametricSizes {
    /// Bytes of the file at given values.
    pub bytes: usize,
    /// Numbers that modes at given values keep.
    pub memory: usize,
    /// Numbers of work while modes are found.
    pub work: usize,
    /// Numbers of work while the file is written, or a state is carried.
    pub write_work: usize,
}

/// Numbers that modes at given values keep.
const fn memory_len(model: &Parametric<'_>, modes: usize) -> usize {
    let r = model.live.n_modes;
    let squares = if model.live.mass.is_some() { 2 } else { 1 };
    model.live.len() + modes + modes * r + squares * r * r
}

impl Parametric<'_> {
    /// Memory to lend for this number of stepped modes.
    ///
    /// # Errors
    /// [`ParametricError::Modes`], [`ParametricError::Format`].
    pub fn sizes(&self, modes: usize) -> Result<ParametricSizes, ParametricError> {
        let r = self.n_basis();
        if modes == 0 || modes > r {
            return Err(ParametricError::Modes { found: modes, most: r });
        }
        let memory = memory_len(self, modes);
        let work = r * r + if self.live.mass.is_some() { r * r } else { 0 } + lowest_work(r, modes);
        let write_work = write_work(self, modes);
        Ok(ParametricSizes { bytes: self.bytes_len(modes)?, memory, work, write_work })
    }

    fn bytes_len(&self, modes: usize) -> Result<usize, ParametricError> {
        let mut metadata = *self.file.metadata();
        metadata.n_modes = modes as u32;
        let mut room = Planned::NONE;
        let sections = planned(&self.file, modes, &mut room)?;
        Ok(filled_len(&metadata, sections)?)
    }

    /// The modes that [`Parametric::solve`] left in this memory.
    pub(crate) fn view<'m>(&self, modes: usize, memory: &'m [f64]) -> Option<Tuned<'m>> {
        let (r, mut lender) = (self.n_basis(), Lender::new(memory));
        let values = lender.take(self.n_parameters()).ok()?;
        let eigenvalues = lender.take(modes).ok()?;
        let shapes = lender.take(modes * r).ok()?;
        let lower = lender.take(r * r).ok()?;
        let mass = lender.take(if self.live.mass.is_some() { r * r } else { 0 }).ok()?;
        let density = self.scales(values).density;
        Some(Tuned { values, eigenvalues, shapes, lower, mass, density })
    }

    /// The lowest modes at values of all parameters. Lends [`ParametricSizes::memory`] and
    /// [`ParametricSizes::work`]; `work` is free again afterwards. `O(r³)`.
    ///
    /// # Errors
    /// [`ParametricError`]: values out of the box, memory that is too short, matrices that are not definite.
    pub fn solve<'m>(
        &self,
        values: &[f64],
        modes: usize,
        memory: &'m mut [f64],
        work: &mut [f64],
    ) -> Result<Tuned<'m>, ParametricError> {
        let (r, count) = (self.n_basis(), self.n_parameters());
        let sizes = self.sizes(modes)?;
        let short = |what, found, needed| ParametricError::LentMemory { what, found, needed };
        let (found, needed) = (memory.len(), sizes.memory);
        let memory = memory.get_mut(..needed).ok_or(short("numbers of memory", found, needed))?;
        let (found, needed) = (work.len(), sizes.work);
        let work = work.get_mut(..needed).ok_or(short("numbers of work", found, needed))?;
        if values.len() != count {
            return Err(ParametricError::Values { found: values.len(), needed: count });
        }
        values.iter().enumerate().try_for_each(|(index, &value)| self.check(index, value))?;
        let cut = |_| ParametricError::NoConvergence;
        let mut lender = Lender::new(memory);
        let own_values = lender.take(count).map_err(cut)?;
        own_values.copy_from_slice(values);
        let eigenvalues = lender.take(modes).map_err(cut)?;
        let shapes = lender.take(modes * r).map_err(cut)?;
        let lower = lender.take(r * r).map_err(cut)?;
        let mass = lender.take(if self.live.mass.is_some() { r * r } else { 0 }).map_err(cut)?;

        let mut lender = Lender::new(work);
        let stiffness = lender.take(r * r).map_err(cut)?;
        let mass_factor = lender.take(mass.len()).map_err(cut)?;
        let eigen = lender.rest();
        let scales = self.scales(values);
        self.combine(&scales, self.live.stiffness, false, stiffness);
        lower.copy_from_slice(stiffness);
        factor(lower, r, 0.0).map_err(|_| ParametricError::NoConvergence)?;
        if let Some(packed) = self.live.mass {
            self.combine(&scales, packed, true, mass);
            mass_factor.copy_from_slice(mass);
            factor(mass_factor, r, 0.0).map_err(|_| ParametricError::NoConvergence)?;
            solve_lower_rows(mass_factor, r, stiffness, r);
            solve_right(mass_factor, r, stiffness);
        }
        lowest_eigen(stiffness, r, eigenvalues, shapes, eigen).map_err(|_| ParametricError::NoConvergence)?;
        if self.live.mass.is_some() {
            shapes.chunks_exact_mut(r.max(1)).for_each(|shape| solve_upper(mass_factor, r, shape));
        } else {
            // `BᵀMB` is the identity times the density of the whole body.
            let scale = 1.0 / libm::sqrt(scales.density);
            shapes.iter_mut().for_each(|x| *x *= scale);
            eigenvalues.iter_mut().for_each(|value| *value /= scales.density);
        }
        if !eigenvalues.iter().all(|value| *value > 0.0 && value.is_finite()) {
            return Err(ParametricError::NoConvergence);
        }
        let density = scales.density;
        Ok(Tuned { values: own_values, eigenvalues, shapes, lower, mass, density })
    }
}

#[cfg(feature = "alloc")]
impl Parametric<'_> {
    /// Bytes of the body at values of all parameters, an ordinary file of so many modes:
    /// [`Parametric::solve`] and [`Tuned::write`] in memory of its own.
    ///
    /// # Errors
    /// [`ParametricError`].
    pub fn body_at(&self, values: &[f64], modes: usize) -> Result<alloc::vec::Vec<u8>, ParametricError> {
        let sizes = self.sizes(modes)?;
        let mut memory = alloc::vec![0.0; sizes.memory];
        let mut work = alloc::vec![0.0; sizes.work.max(sizes.write_work)];
        let tuned = self.solve(values, modes, &mut memory, &mut work)?;
        let mut bytes = alloc::vec![0; sizes.bytes];
        let length = tuned.write(self, &mut bytes, &mut work)?.bytes().len();
        bytes.truncate(length);
        Ok(bytes)
    }
}

impl Tuned<'_> {
    /// Writes the body at these values as an ordinary file and opens it. Lends [`ParametricSizes::bytes`] and
    /// [`ParametricSizes::write_work`](crate::ParametricSizes::write_work). `O(rows r m)`, and with residual
    /// flexibility `O(nodes r²)`.
    ///
    /// [`ParametricSizes::bytes`]: crate::ParametricSizes::bytes
    ///
    /// # Errors
    /// [`ParametricError::LentMemory`], [`ParametricError::Format`]: sections that are compressed.
    pub fn write<'b>(
        &self,
        model: &Parametric<'_>,
        bytes: &'b mut [u8],
        work: &mut [f64],
    ) -> Result<File<'b>, ParametricError> {
        let modes = self.eigenvalues.len();
        let sizes = model.sizes(modes)?;
        let short = |what, found, needed| ParametricError::LentMemory { what, found, needed };
        if bytes.len() < sizes.bytes {
            return Err(short("bytes of the file", bytes.len(), sizes.bytes));
        }
        if work.len() < sizes.write_work {
            return Err(short("numbers of work", work.len(), sizes.write_work));
        }
        let scales = model.scales(self.values);
        let mut room = Planned::NONE;
        let sections = planned(&model.file, modes, &mut room)?;
        let metadata = Metadata {
            n_modes: modes as u32,
            time_step: scales.time_step,
            alpha: scales.alpha,
            beta: scales.beta,
            n_parameters: 0,
            parameters: [Parameter::UNUSED; MAX_PARAMETERS],
            certificate: Certificate::default(),
            ..*model.file.metadata()
        };
        let mut filler = Filler::new(model, self, &scales, work)?;
        let fill = |kind, place: &mut [u8]| filler.fill(kind, place);
        let length = encode_filled(&metadata, sections, fill, bytes)?;
        let bytes: &'b [u8] = bytes;
        Ok(File::parse(bytes.get(..length).unwrap_or_default())?)
    }
}
