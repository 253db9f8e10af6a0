//! Files of the canonical structure made of numbers: the exact one-axis terms of a closed body, which must
//! step as its diagonal structure does.

use vademecum_format::scheme::{SchemeTable, StageCoefficients, StepParameters};
use vademecum_format::{
    Axis, ChapterAxis, ChapterRole, Codec, Element, File, MAX_AXES, SectionInput, SectionKind, encode_into,
    encoded_len,
};

use crate::synthetic::Body;

/// How the terms are arranged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Terms {
    /// State and load apart.
    Apart,
    /// All of them over all axes, as the chapter has them.
    Together,
}

/// Ends of every state axis, and of the load's magnitude.
pub const REACH: f64 = 0.1;
/// Largest magnitude \[N\].
pub const LOAD: f64 = 10.0;
/// Points of a state axis.
const POINTS: usize = 3;

/// A term: its values at the points of the axes it depends on, and `ΠF`.
struct Term {
    on: Vec<(usize, Vec<f64>)>,
    space: Vec<f64>,
}

/// The file of an undamped closed body with loads along z at `positions`.
///
/// # Panics
/// If the writer refuses it, or the basis is not closed.
#[must_use]
pub fn file(
    body: &Body,
    scheme: &SchemeTable,
    step: &StepParameters,
    positions: &[u32],
    terms: Terms,
) -> Vec<u8> {
    assert!(body.omega2.is_empty(), "the oracle is of closed bases");
    let base = body.file(scheme, step, Element::F64);
    let base = File::parse(&base).expect("a file");
    let (mut parts, mut axes, mut factors, mut space): (Vec<u32>, Vec<f64>, Vec<f64>, Vec<f64>) =
        Default::default();
    for stage in 0..scheme.active().len() {
        let (table, n_state, all) = stage_terms(body, scheme, step, positions, stage);
        let n_state_terms = n_state;
        let groups = match terms {
            Terms::Together => vec![(0..table.len(), 0..all.len())],
            Terms::Apart => {
                vec![(0..n_state, 0..n_state_terms), (n_state..table.len(), n_state_terms..all.len())]
            }
        };
        for (on, which) in groups {
            let own = &all[which];
            parts.extend([stage as u32, on.len() as u32, own.len() as u32]);
            for a in on {
                axes.extend(table[a].row());
                for point in 0..table[a].points {
                    factors.extend(own.iter().map(|term| {
                        term.on.iter().find(|(axis, _)| *axis == a).map_or(1.0, |(_, values)| values[point])
                    }));
                }
            }
            space.extend(own.iter().flat_map(|term| &term.space));
        }
    }
    let r = body.layout.r;
    let f64s = |numbers: &[f64]| -> Vec<u8> { numbers.iter().flat_map(|x| x.to_le_bytes()).collect() };
    let u32s = |numbers: &[u32]| -> Vec<u8> { numbers.iter().flat_map(|x| x.to_le_bytes()).collect() };
    let certificate = vec![f64::NAN; 8 + 3 * scheme.active().len()];
    use SectionKind as S;
    let own = [
        (S::CanonicalParts, Element::U32, [parts.len() / 3, 3], u32s(&parts)),
        (S::CanonicalAxes, Element::F64, [axes.len() / 6, 6], f64s(&axes)),
        (S::CanonicalFactors, Element::F64, [factors.len(), 1], f64s(&factors)),
        (S::CanonicalTerms, Element::F64, [space.len() / r, r], f64s(&space)),
        (S::CanonicalPositions, Element::U32, [positions.len(), 1], u32s(positions)),
        (S::CanonicalDirection, Element::F64, [3, 1], f64s(&[0.0, 0.0, 1.0])),
        (S::CanonicalCertificate, Element::F64, [certificate.len(), 1], f64s(&certificate)),
    ];
    let block = [S::BlockState, S::BlockLoad, S::PatternBlock, S::AxisPoints, S::Factors];
    let kept = base
        .sections()
        .filter(|s| !block.contains(&s.kind()))
        .map(|s| SectionInput { codec: Codec::Raw, ..s.into() });
    let added = own.iter().map(|(kind, element, shape, bytes)| SectionInput {
        kind: *kind,
        element: *element,
        codec: Codec::Raw,
        required: true,
        shape: [shape[0] as u64, shape[1] as u64, 1],
        decoded_length: bytes.len() as u64,
        stored: bytes,
    });
    let sections: Vec<SectionInput<'_>> = kept.chain(added).collect();
    let mut metadata = *base.metadata();
    (metadata.diagonal, metadata.block, metadata.n_axes, metadata.n_terms) = (false, false, 0, 0);
    metadata.axes = [Axis::UNUSED; MAX_AXES];
    let mut out = vec![0; encoded_len(&metadata, &sections).expect("a length")];
    encode_into(&metadata, &sections, &mut out).expect("the writer takes it");
    out
}

/// Axes of a stage, how many are of the state (as many as its terms of the state), and its terms: one per
/// right-hand side.
fn stage_terms(
    body: &Body,
    scheme: &SchemeTable,
    step: &StepParameters,
    positions: &[u32],
    stage: usize,
) -> (Vec<ChapterAxis>, usize, Vec<Term>) {
    let r = body.layout.r;
    let own = StageCoefficients::new(scheme, step, stage).expect("a stage");
    let response: Vec<f64> = body.lambda.iter().map(|lambda| 1.0 / (1.0 + own.theta * lambda)).collect();
    let (mut axes, mut terms) = (vec![], vec![]);
    for (family, weight) in scheme.active()[stage].mass_history.iter().enumerate().filter(|(_, w)| **w != 0.0)
    {
        for mode in 0..r {
            let role = ChapterRole::State { family, mode };
            let on = vec![(axes.len(), vec![-REACH, 0.0, REACH])];
            axes.push(ChapterAxis { role, lower: -REACH, upper: REACH, points: POINTS, factor: 1.0 });
            let mut space = vec![0.0; r];
            space[mode] = weight / own.mass * response[mode];
            terms.push(Term { on, space });
        }
    }
    let n_state = axes.len();
    let upper = positions.len() as f64 - 1.0;
    axes.push(ChapterAxis { role: ChapterRole::Magnitude, lower: 0.0, upper: LOAD, points: 2, factor: 1.0 });
    axes.push(ChapterAxis {
        role: ChapterRole::Position,
        lower: 0.0,
        upper,
        points: positions.len(),
        factor: 1.0,
    });
    for (place, &node) in positions.iter().enumerate() {
        let at: Vec<f64> = (0..positions.len()).map(|p| f64::from(u8::from(p == place))).collect();
        let row = &body.basis[(3 * node as usize + 2) * r..][..r];
        let space = row.iter().zip(&response).map(|(b, c)| own.load * b * c).collect();
        terms.push(Term { on: vec![(n_state, vec![0.0, LOAD]), (n_state + 1, at)], space });
    }
    (axes, n_state, terms)
}
