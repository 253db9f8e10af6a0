//! Strain maps made of numbers, files of them, and what they mean written out densely: the oracle of the
//! strain structure.

use crate::synthetic::{Body, Layout, Random, bathe};
use vademecum_format::scheme::{SchemeTable, StepParameters};
use vademecum_format::{
    Axis, Codec, Element, File, Parameter, SectionInput, SectionKind, StrainSizes, encode_into, encoded_len,
};

/// A strain map, with the matrices as built.
#[derive(Clone)]
pub struct Strained {
    /// Its sizes.
    pub sizes: StrainSizes,
    /// `L` of the first `r` rows, `(r, n + n₁)`.
    pub linear: Vec<f64>,
    /// Tail frequencies.
    pub tail: Vec<f64>,
    /// `Q`, `(m, pairs)`.
    pub quadratic: Vec<f64>,
    /// Natural frequencies of natural modes, 0 of other coordinates; empty in a file without that section.
    pub modes: Vec<f64>,
    /// `W`, `(r, r)`.
    pub training: Vec<f64>,
    /// Largest distance and energy of the training.
    pub limits: [f64; 2],
}

impl Strained {
    /// Random numbers: frequencies from 30 rad/s over two decades, rows of `L` that are not orthogonal, and
    /// `Q` so large that at coordinates of size 1 both parts of a row are about equal. Every second
    /// coordinate is called a natural mode.
    #[must_use]
    pub fn random([n, coupled, r, rows]: [usize; 4], seed: u64) -> Self {
        let mut random = Random::new(seed);
        let sizes = StrainSizes { interacting: n, coupled, rows, coordinates: r, substeps: 1 };
        let (leading, pairs) = (sizes.leading(), sizes.pairs());
        let omega: Vec<f64> = (0..r).map(|k| 30.0 * 100f64.powf(k as f64 / r as f64)).collect();
        let mut linear = vec![0.0; r * leading];
        for (k, row) in linear.chunks_exact_mut(leading).enumerate() {
            for (j, out) in row.iter_mut().enumerate() {
                // A tail row is coupled to the others, too.
                let own = if k == j { 1.0 } else { 0.0 };
                *out = omega[j.min(k)] * (own + 0.1 * random.number());
            }
        }
        let size = 30.0 / (pairs as f64).sqrt();
        Self {
            sizes,
            linear,
            tail: omega[leading..].to_vec(),
            quadratic: random.numbers(rows * pairs).iter().map(|x| size * x).collect(),
            modes: omega.iter().enumerate().map(|(k, w)| if k % 2 == 0 { *w } else { 0.0 }).collect(),
            training: (0..r * r).map(|i| f64::from(u8::from(i / r == i % r))).collect(),
            limits: [1.0, 1e3],
        }
    }

    /// The sections 60 to 66.
    fn sections(&self) -> Vec<(SectionKind, Element, [u64; 3], Vec<u8>)> {
        use Element::{F64, U32};
        use SectionKind as S;
        let StrainSizes { interacting, coupled, rows, coordinates, substeps } = self.sizes;
        let little = |values: &[f64]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let counts = [interacting, coupled, rows, substeps];
        let counts = counts.iter().flat_map(|&n| (n as u32).to_le_bytes()).collect();
        let [r, leading, tail] = [coordinates, self.sizes.leading(), self.sizes.tail()].map(|n| n as u64);
        let mut sections = vec![
            (S::StrainSizes, U32, [4, 1, 1], counts),
            (S::StrainLinear, F64, [r, leading, 1], little(&self.linear)),
        ];
        if tail > 0 {
            sections.push((S::StrainTail, F64, [tail, 1, 1], little(&self.tail)));
        }
        let shape = [rows as u64, self.sizes.pairs() as u64, 1];
        sections.push((S::StrainQuadratic, F64, shape, little(&self.quadratic)));
        sections.push((S::StrainBox, F64, [r, r, 1], little(&self.training)));
        sections.push((S::StrainLimits, F64, [2, 1, 1], little(&self.limits)));
        if !self.modes.is_empty() {
            sections.push((S::StrainModes, F64, [r, 1, 1], little(&self.modes)));
        }
        sections
    }

    /// The file of a linear body with these sections in place of its structures.
    ///
    /// # Panics
    /// If the writer refuses it.
    #[must_use]
    pub fn into_file(&self, bytes: &[u8]) -> Vec<u8> {
        use SectionKind as S;
        let own = self.sections();
        let file = File::parse(bytes).expect("a file");
        let linear = [
            S::BlockState,
            S::BlockLoad,
            S::PatternBlock,
            S::AxisPoints,
            S::Factors,
            S::Eigenvalues,
            S::ReducedStiffness,
        ];
        let kept = file.sections().filter(|s| !linear.contains(&s.kind())).map(SectionInput::from);
        let added = own.iter().map(|(kind, element, shape, stored)| SectionInput {
            kind: *kind,
            element: *element,
            codec: Codec::Raw,
            required: kind.is_strain(),
            shape: *shape,
            decoded_length: stored.len() as u64,
            stored,
        });
        let inputs: Vec<SectionInput<'_>> = kept.chain(added).collect();
        let mut metadata = *file.metadata();
        (metadata.scheme_name, metadata.scheme) = ("polarised strain", SchemeTable::EXACT);
        (metadata.block, metadata.n_terms, metadata.n_axes, metadata.axes[0]) = (false, 0, 0, Axis::UNUSED);
        (metadata.diagonal, metadata.n_parameters) = (false, 0);
        metadata.parameters = [Parameter::UNUSED; vademecum_format::MAX_PARAMETERS];
        let mut out = vec![0; encoded_len(&metadata, &inputs).expect("a length")];
        encode_into(&metadata, &inputs, &mut out).expect("written");
        out
    }

    /// A file of this map over a body of four nodes with a random basis; patterns and probes are those of
    /// [`Body::file`].
    #[must_use]
    pub fn file(&self, step: &StepParameters) -> Vec<u8> {
        let r = self.sizes.coordinates;
        let layout = Layout { rows: 2, load_rows: 2, columns: 2, n_interior: 0, r };
        self.into_file(&Body::closed(layout, 1).file(&bathe(), step, Element::F64))
    }

    /// The linear part of row `k` at `q`.
    fn linear_of(&self, k: usize, q: &[f64]) -> f64 {
        let leading = self.sizes.leading();
        if k >= self.sizes.coordinates {
            return 0.0;
        }
        let row = &self.linear[k * leading..(k + 1) * leading];
        let own = if k >= leading { self.tail[k - leading] * q[k] } else { 0.0 };
        row.iter().zip(q).map(|(l, q)| l * q).sum::<f64>() + own
    }

    /// `z(q, p) = L (q + p)/2 + Q(q, p)`, symmetric; `z(q, q)` is the strain.
    #[must_use]
    pub fn strain(&self, q: &[f64], p: &[f64]) -> Vec<f64> {
        let pairs = self.sizes.pairs();
        let row = |k: usize| {
            let products = self.sizes.pair_list().map(|(a, b)| 0.5 * (q[a] * p[b] + q[b] * p[a]));
            let quadratic = self.quadratic[k * pairs..(k + 1) * pairs].iter();
            let quadratic: f64 = quadratic.zip(products).map(|(c, x)| c * x).sum();
            0.5 * (self.linear_of(k, q) + self.linear_of(k, p)) + quadratic
        };
        (0..self.sizes.rows).map(row).collect()
    }

    /// `G(q) = L + 2 Q(q, ·)`, `(m, r)`.
    #[must_use]
    pub fn gradient(&self, q: &[f64]) -> Vec<f64> {
        let r = self.sizes.coordinates;
        let zero = vec![0.0; r];
        let mut out = vec![0.0; self.sizes.rows * r];
        for j in 0..r {
            let mut unit = zero.clone();
            unit[j] = 1.0;
            // z(q, u) − z(q, 0) is linear in u.
            let (with, without) = (self.strain(q, &unit), self.strain(q, &zero));
            for (k, (a, b)) in with.iter().zip(&without).enumerate() {
                out[k * r + j] = 2.0 * (a - b);
            }
        }
        out
    }

    /// `m_j`, the inertia of each coordinate in a step: that with which a natural mode swings with its own
    /// frequency, if it has four steps in a period.
    #[must_use]
    pub fn inertia(&self, by: &StepParameters) -> Vec<f64> {
        let half_turn = |omega: f64| 0.5 * by.time_step * (by.stiffness / by.density).sqrt() * omega;
        let of = |j: usize| match half_turn(self.modes.get(j).copied().unwrap_or(0.0)) {
            x if x > 0.0 && 4.0 * x <= std::f64::consts::PI => (x / x.tan()).powi(2),
            _ => 1.0,
        };
        (0..self.sizes.coordinates).map(of).collect()
    }

    /// The places half a step before and after displacement and velocity.
    fn early_and_late(&self, (zeta, rate): (&[f64], &[f64]), by: &StepParameters) -> [Vec<f64>; 2] {
        let way = self.inertia(by).into_iter().zip(rate).map(|(m, v)| 0.5 * by.time_step * v / m.sqrt());
        let way: Vec<f64> = way.collect();
        [-1.0, 1.0].map(|sign| zeta.iter().zip(&way).map(|(z, w)| z + sign * w).collect())
    }

    /// `σ_k` of each row.
    #[must_use]
    pub fn damped_frequencies(&self) -> Vec<f64> {
        let (leading, r) = (self.sizes.leading(), self.sizes.coordinates);
        let frequency = |k: usize| match k {
            k if k < leading => {
                let row = &self.linear[k * leading..(k + 1) * leading];
                row.iter().map(|x| x * x).sum::<f64>().sqrt()
            }
            k if k < r => self.tail[k - leading],
            _ => 0.0,
        };
        (0..self.sizes.rows).map(frequency).collect()
    }

    /// One sub-step by the formulas of the theory, with a dense solve over all coordinates: from displacement
    /// and velocity to those at its end, under the reduced force at its middle.
    #[must_use]
    pub fn dense_step(
        &self,
        (zeta, rate): (&[f64], &[f64]),
        force: &[f64],
        by: &StepParameters,
        viscosity: f64,
    ) -> (Vec<f64>, Vec<f64>) {
        let (r, k) = (self.sizes.coordinates, by.time_step);
        let ratio = by.stiffness / by.density;
        let inertia = self.inertia(by);
        let [early, late] = self.early_and_late((zeta, rate), by);
        let (z, g) = (self.strain(&late, &early), self.gradient(&late));
        let mut matrix = vec![0.0; r * r];
        let push = |(i, v): (usize, &f64)| inertia[i].sqrt() * k * v + 0.5 * k * k * force[i] / by.density;
        let mut right: Vec<f64> = rate.iter().enumerate().map(push).collect();
        for i in 0..r {
            matrix[i * r + i] = (1.0 + 0.5 * k * by.alpha) * inertia[i];
        }
        for (row, (z, sigma)) in g.chunks_exact(r).zip(z.iter().zip(self.damped_frequencies())) {
            let square = 0.25 * k * k * ratio * sigma * sigma;
            let weight = 0.25 * k * k * ratio * (1.0 + 2.0 * by.beta / k + viscosity * square);
            for i in 0..r {
                right[i] -= 0.5 * k * k * ratio * row[i] * z;
                for j in 0..r {
                    matrix[i * r + j] += weight * row[i] * row[j];
                }
            }
        }
        let d = eliminate(&mut matrix, right);
        let moved = zeta.iter().zip(&d).map(|(z, d)| z + d).collect();
        (moved, (0..r).map(|i| 2.0 * inertia[i].sqrt() * d[i] / k - rate[i]).collect())
    }

    /// `½ s_ρ |v|² + ½ s_K |z|²` of displacement and velocity, with the strain of the scheme.
    #[must_use]
    pub fn energy(&self, (zeta, rate): (&[f64], &[f64]), by: &StepParameters) -> f64 {
        let [early, late] = self.early_and_late((zeta, rate), by);
        let elastic: f64 = self.strain(&late, &early).iter().map(|z| z * z).sum();
        0.5 * by.density * rate.iter().map(|v| v * v).sum::<f64>() + 0.5 * by.stiffness * elastic
    }
}

/// Solves by Gauss with partial pivoting.
fn eliminate(a: &mut [f64], mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for j in 0..n {
        let pivot = (j..n).max_by(|&x, &y| a[x * n + j].abs().total_cmp(&a[y * n + j].abs())).expect("a row");
        (0..n).for_each(|i| a.swap(j * n + i, pivot * n + i));
        b.swap(j, pivot);
        for i in j + 1..n {
            let share = a[i * n + j] / a[j * n + j];
            (j..n).for_each(|k| a[i * n + k] -= share * a[j * n + k]);
            b[i] -= share * b[j];
        }
    }
    for j in (0..n).rev() {
        let known: f64 = (j + 1..n).map(|k| a[j * n + k] * b[k]).sum();
        b[j] = (b[j] - known) / a[j * n + j];
    }
    b
}
