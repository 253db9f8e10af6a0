//! A parametric reduced-order model, and its modes at values of its parameters.

use crate::base::lend::Lender;
use crate::kernels::dense::{at, factor, set, solve_lower_rows, solve_upper, symmetrise, transpose};
use crate::kernels::lowest::{lowest_eigen, lowest_work};
use crate::parametric::error::ParametricError;
use crate::parametric::tuned::Tuned;
use crate::parametric::write::{Planned, planned};
use vademecum_format::{File, LiveParameters, Parameter, ParameterRole, filled_len};

/// Stepped modes, unless others are asked for.
pub const STEPPED_MODES: usize = 32;

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

/// A parametric reduced-order model: a body of `r` basis vectors with matrices `K(κ) = Σ κ_q k_q` and
/// `M(ρ) = Σ ρ_q m_q` of its live regions.
///
/// At given values the lowest modes follow from one eigenproblem of `r` rows ([`Parametric::solve`]), and
/// [`Tuned::write`] gives the body at these values as the bytes of an ordinary file, in lent memory: whatever
/// takes a file takes it.
#[derive(Clone, Copy, Debug)]
pub struct Parametric<'f> {
    pub(crate) file: File<'f>,
    pub(crate) live: LiveParameters<'f>,
}

/// Values of the parameters, resolved to what matrices and step are scaled by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales<'v> {
    values: &'v [f64],
    /// Factors on the stiffness and on the density of the whole body.
    pub stiffness: f64,
    pub density: f64,
    pub alpha: f64,
    pub beta: f64,
    pub time_step: f64,
}

impl<'f> Parametric<'f> {
    /// The model of an opened file.
    ///
    /// # Errors
    /// [`ParametricError::NotParametric`], [`ParametricError::Live`].
    pub fn new(file: &File<'f>) -> Result<Self, ParametricError> {
        let live = file.live_parameters()?.ok_or(ParametricError::NotParametric)?;
        Ok(Self { file: *file, live })
    }

    /// The file.
    #[must_use]
    pub const fn file(&self) -> &File<'f> {
        &self.file
    }

    /// Number of basis vectors, `r`.
    #[must_use]
    pub const fn n_basis(&self) -> usize {
        self.live.n_modes
    }

    /// Number of live parameters.
    #[must_use]
    pub const fn n_parameters(&self) -> usize {
        self.live.len()
    }

    /// The live parameters, in the order of their numbers.
    pub fn parameters(&self) -> impl Iterator<Item = Parameter<'f>> + use<'f> {
        self.live.iter()
    }

    /// Number of the parameter of this name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<usize> {
        self.live.find(name)
    }

    /// As many modes as a step takes unless asked otherwise: 32, or all of fewer.
    #[must_use]
    pub const fn usual_modes(&self) -> usize {
        if self.live.n_modes < STEPPED_MODES { self.live.n_modes } else { STEPPED_MODES }
    }

    /// Sets some of `values` and leaves the others.
    ///
    /// # Errors
    /// [`ParametricError::Index`], [`ParametricError::Twice`], [`ParametricError::Range`]; nothing is changed
    /// then.
    pub fn set(&self, values: &mut [f64], settings: &[(usize, f64)]) -> Result<(), ParametricError> {
        let count = self.live.len();
        for (place, &(index, found)) in settings.iter().enumerate() {
            let parameter = self.live.get(index).filter(|_| index < values.len());
            let Parameter { lower, upper, .. } = parameter.ok_or(ParametricError::Index { index, count })?;
            if settings.iter().take(place).any(|earlier| earlier.0 == index) {
                return Err(ParametricError::Twice { index });
            }
            if !(lower..=upper).contains(&found) {
                return Err(ParametricError::Range { index, found, lower, upper });
            }
        }
        settings.iter().for_each(|&(index, value)| set(values, index, value));
        Ok(())
    }

    /// The values as built.
    pub fn nominal_into(&self, values: &mut [f64]) {
        values.iter_mut().zip(self.parameters()).for_each(|(value, own)| *value = own.nominal);
    }

    /// Memory to lend for this number of stepped modes.
    ///
    /// # Errors
    /// [`ParametricError::Modes`], [`ParametricError::Format`].
    pub fn sizes(&self, modes: usize) -> Result<ParametricSizes, ParametricError> {
        let r = self.n_basis();
        if modes == 0 || modes > r {
            return Err(ParametricError::Modes { found: modes, most: r });
        }
        let memory = Tuned::memory_len(self, modes);
        let work = r * r + if self.live.mass.is_some() { r * r } else { 0 } + lowest_work(r, modes);
        let write_work = Tuned::write_work(self, modes);
        Ok(ParametricSizes { bytes: self.bytes_len(modes)?, memory, work, write_work })
    }

    fn bytes_len(&self, modes: usize) -> Result<usize, ParametricError> {
        let mut metadata = *self.file.metadata();
        metadata.n_modes = modes as u32;
        let mut room = Planned::NONE;
        let sections = planned(&self.file, modes, &mut room)?;
        Ok(filled_len(&metadata, sections)?)
    }

    /// Scales of these values.
    pub(crate) fn scales<'v>(&self, values: &'v [f64]) -> Scales<'v> {
        let metadata = self.file.metadata();
        let mut scales = Scales {
            values,
            stiffness: 1.0,
            density: 1.0,
            alpha: metadata.alpha,
            beta: metadata.beta,
            time_step: metadata.time_step,
        };
        for (parameter, &value) in self.parameters().zip(values) {
            match parameter.role {
                ParameterRole::Stiffness => scales.stiffness = value,
                ParameterRole::Density => scales.density = value,
                ParameterRole::Alpha => scales.alpha = value,
                ParameterRole::Beta => scales.beta = value,
                ParameterRole::TimeStep => scales.time_step = value,
                _ => {}
            }
        }
        scales
    }

    /// Factor of the stiffness (or of the density) of live region `region`, counted from 1; 0 is what is not
    /// live.
    pub(crate) fn scale_of(&self, scales: &Scales<'_>, region: usize, density: bool) -> f64 {
        let whole = if density { scales.density } else { scales.stiffness };
        let Some(region) = region.checked_sub(1) else { return whole };
        let fits = |role| match role {
            ParameterRole::RegionStiffness { region: own } => !density && own as usize == region,
            ParameterRole::RegionDensity { region: own } => density && own as usize == region,
            _ => false,
        };
        let own = self.parameters().zip(scales.values).find(|own| fits(own.0.role));
        whole * own.map_or(1.0, |own| *own.1)
    }

    /// `Σ scale_q a_q` as a full matrix; scales are of the stiffness, or of the density.
    fn combine(&self, scales: &Scales<'_>, packed: &[[u8; 8]], density: bool, out: &mut [f64]) {
        let r = self.n_basis();
        out.fill(0.0);
        for (region, own) in packed.chunks_exact((r * (r + 1) / 2).max(1)).enumerate() {
            let scale = self.scale_of(scales, region, density);
            let mut rest = own;
            for (i, row) in out.chunks_exact_mut(r.max(1)).enumerate() {
                let Some((of_row, next)) = rest.split_at_checked(i + 1) else { break };
                row.iter_mut().zip(of_row).for_each(|(out, &own)| *out += scale * f64::from_le_bytes(own));
                rest = next;
            }
        }
        for i in 0..r {
            for j in 0..i {
                set(out, j * r + i, at(out, i * r + j));
            }
        }
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
            return Err(ParametricError::Index { index: values.len(), count });
        }
        for (index, (parameter, &found)) in self.parameters().zip(values).enumerate() {
            let Parameter { lower, upper, .. } = parameter;
            if !(lower..=upper).contains(&found) {
                return Err(ParametricError::Range { index, found, lower, upper });
            }
        }
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
            transpose(stiffness, r);
            solve_lower_rows(mass_factor, r, stiffness, r);
            symmetrise(stiffness, r);
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
