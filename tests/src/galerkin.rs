//! A file whose stages share their modes: two symmetric positive matrices of random numbers stand for mass
//! and stiffness of a lifted basis.

use crate::regions::solve;
use crate::synthetic::{Body, Layout, Random, bathe, encode};
use vademecum_format::scheme::{StepParameters, theta};
use vademecum_format::{Element, File, SectionKind};

/// `G Gᵀ` of a diagonally dominant `G`, its diagonal spread over `decades`.
fn positive(r: usize, decades: f64, size: f64, random: &mut Random) -> Vec<f64> {
    let scale = |i: usize| size * 10f64.powf(0.5 * decades * i as f64 / r as f64);
    let g: Vec<f64> = (0..r * r)
        .map(|ij| {
            scale(ij / r)
                * (0.5 / (r as f64).sqrt() * random.number() + f64::from(u8::from(ij / r == ij % r)))
        })
        .collect();
    (0..r * r).map(|ij| (0..r).map(|k| g[ij / r * r + k] * g[ij % r * r + k]).sum()).collect()
}

/// A file whose stages are Galerkin in one pencil, as those of live regions: `E_i = −(M̃ + θ_i K̃)⁻¹ θ_i K̃`.
/// One term a stage; load rows and patterns are those of a closed body of other modes.
///
/// # Panics
/// If the writer refuses it.
#[must_use]
pub fn galerkin_file(r: usize, step: &StepParameters) -> Vec<u8> {
    let layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 3, r };
    let bytes = Body::closed(layout, 1).file(&bathe(), step, Element::F64);
    let mut random = Random::new(5);
    let (mass, stiffness) = (positive(r, 0.0, 1.0, &mut random), positive(r, 4.0, 30.0, &mut random));
    let mut state = Vec::new();
    for stage in 0..2 {
        let theta = theta(&bathe(), step, stage).expect("scheme");
        let sum = mass.iter().zip(&stiffness).map(|(m, k)| m + theta * k).collect();
        state.extend(solve(sum, stiffness.iter().map(|k| -theta * k).collect(), r));
    }
    let file = File::parse(&bytes).expect("a file");
    let contents: Vec<_> = file
        .sections()
        .map(|section| {
            let stored = match section.kind() {
                SectionKind::BlockState => state.iter().flat_map(|x| x.to_le_bytes()).collect(),
                _ => section.stored().to_vec(),
            };
            (section.kind(), section.element(), stored)
        })
        .collect();
    encode(file.metadata(), &contents)
}
