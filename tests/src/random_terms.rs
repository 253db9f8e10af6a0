//! A file of any number of terms, for costs.

use crate::regions::chebyshev;
use crate::synthetic::{Body, Layout, Random, bathe, encode};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{
    Axis, AxisKind, AxisRole, Element, File, MAX_REGIONS, Parameter, ParameterRole, SectionKind,
};

/// A file of two regions with `n_terms` terms of random numbers over a common axis of 17 points and a
/// contrast of 11: what a bind costs does not depend on what the numbers mean.
///
/// # Panics
/// If the writer refuses it.
#[must_use]
pub fn random_terms(r: usize, n_terms: usize, step: &StepParameters) -> Vec<u8> {
    let layout = Layout { rows: 4, load_rows: 2, columns: 4, n_interior: 4, r };
    let bytes = Body::closed(layout, 1).file(&bathe(), step, Element::F32);
    let file = File::parse(&bytes).expect("file");
    let mut m = *file.metadata();
    let exponents = |a: f64, b: f64| [a, b, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let (common, contrast) = (chebyshev(17, 1e-8, 1e-6, true), chebyshev(11, 0.5, 2.0, true));
    let axis = |name, theta, stiffness, points: &[f64]| Axis {
        name,
        unit: "",
        role: AxisRole::Monomial { theta, stiffness, density: [0.0; MAX_REGIONS] },
        kind: AxisKind::Chebyshev,
        log: true,
        lower: points[0],
        upper: points[points.len() - 1],
        n_points: points.len() as u32,
    };
    m.axes[0] = axis("common", 1.0, exponents(0.5, 0.5), &common);
    m.axes[1] = axis("contrast", 0.0, exponents(0.5, -0.5), &contrast);
    (m.n_axes, m.n_terms, m.n_regions) = (2, n_terms as u32, 2);
    let parameter = |name, region| Parameter {
        name,
        unit: "",
        role: ParameterRole::RegionStiffness { region },
        log: true,
        lower: 0.5,
        upper: 2.0,
        nominal: 1.0,
    };
    (m.parameters[0], m.parameters[1]) = (parameter("soft", 0), parameter("hard", 1));
    m.n_parameters = 2;
    let mut random = Random::new(3);
    let mut numbers = |n: usize, single: bool| -> Vec<u8> {
        let numbers = random.numbers(n).into_iter().map(|x| 1e-3 * x);
        match single {
            true => numbers.flat_map(|x| (x as f32).to_le_bytes()).collect(),
            false => numbers.flat_map(|x| x.to_le_bytes()).collect(),
        }
    };
    let n_load = m.n_load_nodes as usize;
    let points: Vec<u8> = common.iter().chain(&contrast).flat_map(|x| x.to_le_bytes()).collect();
    let replaced = [
        (SectionKind::BlockState, Element::F64, numbers(n_terms * r * r, false)),
        (SectionKind::BlockLoad, Element::F32, numbers(n_load * n_terms * 3 * r, true)),
        (SectionKind::PatternBlock, Element::F64, numbers(n_terms * r, false)),
        (SectionKind::AxisPoints, Element::F64, points),
        (SectionKind::Factors, Element::F64, numbers(n_terms * 28, false)),
        (SectionKind::RegionStiffness, Element::F64, numbers(2 * r * r, false)),
    ];
    let kept = file.sections().filter(|s| replaced.iter().all(|r| r.0 != s.kind()));
    let mut contents: Vec<_> = kept.map(|s| (s.kind(), s.element(), s.stored().to_vec())).collect();
    contents.extend(replaced);
    encode(&m, &contents)
}
