//! A parametric reduced-order model, and its modes at values of its parameters.

use crate::base::error::ParameterError;
use crate::kernels::dense::{at, set};
use crate::parametric::error::ParametricError;
use vademecum_format::{File, LiveParameters, Parameter, ParameterRole};

/// Stepped modes, unless others are asked for.
pub const STEPPED_MODES: usize = 32;

/// A parametric reduced-order model: a body of `r` basis vectors with matrices `K(κ) = Σ κ_q k_q` and
/// `M(ρ) = Σ ρ_q m_q` of its live regions.
///
/// At given values the lowest modes follow from one eigenproblem of `r` rows ([`Parametric::solve`]), and
/// [`Tuned::write`](crate::Tuned::write) gives the body at these values as the bytes of an ordinary file, in
/// lent memory: whatever takes a file takes it.
#[derive(Clone, Copy, Debug)]
pub struct Parametric<'f> {
    pub(crate) file: File<'f>,
    pub(crate) live: LiveParameters<'f>,
}

/// Values of the parameters, resolved to what matrices and step are scaled by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales<'v> {
    pub values: &'v [f64],
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
    /// [`ParameterError`]; nothing is changed then.
    pub fn set(&self, values: &mut [f64], settings: &[(usize, f64)]) -> Result<(), ParameterError> {
        for (place, &(index, found)) in settings.iter().enumerate() {
            if index >= values.len() {
                return Err(ParameterError::Unknown { index });
            }
            if settings.iter().take(place).any(|earlier| earlier.0 == index) {
                return Err(ParameterError::Twice { parameter: index });
            }
            self.check(index, found)?;
        }
        settings.iter().for_each(|&(index, value)| set(values, index, value));
        Ok(())
    }

    /// Refuses a value that a parameter cannot have.
    pub(crate) fn check(&self, index: usize, value: f64) -> Result<(), ParameterError> {
        let parameter = self.live.get(index).ok_or(ParameterError::Unknown { index })?;
        let Parameter { lower, upper, .. } = parameter;
        if (lower..=upper).contains(&value) {
            return Ok(());
        }
        Err(ParameterError::OutsideRange { parameter: index, value, lower, upper })
    }

    /// The values as built.
    pub fn nominal_into(&self, values: &mut [f64]) {
        values.iter_mut().zip(self.parameters()).for_each(|(value, own)| *value = own.nominal);
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
    pub(crate) fn combine(&self, scales: &Scales<'_>, packed: &[[u8; 8]], density: bool, out: &mut [f64]) {
        self.combine_by(|region| self.scale_of(scales, region, density), packed, out);
    }

    /// The same with a scale for each live region, 0 being what is not live.
    pub(crate) fn combine_by(&self, scale: impl Fn(usize) -> f64, packed: &[[u8; 8]], out: &mut [f64]) {
        let r = self.n_basis();
        out.fill(0.0);
        for (region, own) in packed.chunks_exact((r * (r + 1) / 2).max(1)).enumerate() {
            let scale = scale(region);
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
}
