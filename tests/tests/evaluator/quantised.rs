//! Quantised and block-coded sections: what they cost, that they are read where they lie and in part, and
//! that no bytes in them do harm.

use std::sync::OnceLock;

use vademecum_eval::{Contact, Field, Place, Scalar, SceneOptions, StructureChoice};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{
    Blocks, Codec, Decoder, Element, File, FormatError, SectionInput, SectionKind, encode_into, encoded_len,
    unpack_into, unpacked_len,
};
use vademecum_rewrite::{DECODED_LIMIT, Keep, check, pack, pack_within, read_losses, strip, unpack};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, Random, bathe};

const SPACE: [SectionKind; 3] =
    [SectionKind::SurfaceBasis, SectionKind::InteriorBasis, SectionKind::BlockLoad];

/// 1 700 nodes, so fourteen blocks of scales, the last one not full; two blocks of the codec.
fn raw() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| {
        let layout = Layout { rows: 40, load_rows: 10, columns: 40, n_interior: 100, r: 10 };
        let step = StepParameters { time_step: 1e-3, alpha: 0.5, beta: 1e-6, density: 1.0, stiffness: 1.0 };
        Body::closed(layout, 7).file(&bathe(), &step, Element::F64)
    })
}

fn packed(tolerance: f64) -> Vec<u8> {
    pack_within(raw(), 3, tolerance).expect("packed")
}

fn numbers(bytes: &[u8], kind: SectionKind) -> Vec<f64> {
    let file = File::parse(bytes).expect("a file");
    file.section(kind).expect("there").numbers().expect("numbers").iter().collect()
}

#[test]
fn rounding_keeps_its_tolerance_and_says_what_it_cost() {
    for tolerance in [1e-2, 1e-3, 1e-4] {
        let packed = packed(tolerance);
        let opened = unpack(&packed, DECODED_LIMIT).expect("unpacked");
        let file = File::parse(&opened).expect("a file");
        assert_eq!((file.minor(), File::parse(raw()).expect("a file").minor()), (1, 0));
        let losses = read_losses(&file).expect("losses");
        for kind in SPACE {
            assert!([Element::I16, Element::F32].contains(&file.section(kind).expect("there").element()));
            let loss = losses.iter().find(|(k, _)| *k == kind).expect("a loss").1;
            assert!(0.0 < loss.displacement && loss.displacement <= tolerance, "{kind:?} {loss:?}");
            assert!(loss.worst_mode <= tolerance);
        }
        // The error of a field, recomputed: without a table of modes all shares are the same.
        let [exact, rounded] = [raw(), &opened].map(|bytes| numbers(bytes, SectionKind::SurfaceBasis));
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let off: Vec<f64> = exact.iter().zip(&rounded).map(|(a, b)| a - b).collect();
        let error = (square(&off) / square(&exact)).sqrt();
        let said = losses.iter().find(|(k, _)| *k == SectionKind::SurfaceBasis).expect("a loss").1;
        // What a force at a single node does is said too where it is more.
        assert!(error <= said.displacement * (1.0 + 1e-9) && error > 0.0, "{error} {said:?}");
        // Everything a microcontroller steps with is the same to the bit.
        for kind in [SectionKind::ProbeRows, SectionKind::BlockState, SectionKind::PatternBlock] {
            assert_eq!(numbers(raw(), kind), numbers(&opened, kind));
        }
        let checked = check(&packed).expect("sound");
        assert_eq!(checked.unknown_sections, 0);
        // Packed again it is what it was: rounded sections stay, and so does what is said of them.
        assert!(pack_within(&packed, 3, tolerance).expect("packed") == packed);
        assert!(pack(&opened, 3).expect("packed") == packed);
    }
    // What 16 bits cannot keep stays exact or binary32.
    let fine = unpack(&packed(1e-6), DECODED_LIMIT).expect("unpacked");
    assert_eq!(File::parse(&fine).expect("a file").section(SPACE[0]).expect("there").element(), Element::F32);
    let exact = unpack(&packed(1e-12), DECODED_LIMIT).expect("unpacked");
    SPACE.iter().for_each(|&kind| assert!(numbers(&exact, kind) == numbers(raw(), kind)));
    for tolerance in [0.0, -1.0, 1.0, f64::NAN] {
        assert!(pack_within(raw(), 3, tolerance).is_err());
    }
}

#[test]
fn a_stripped_file_forgets_nothing_and_keeps_its_losses() {
    let surface = strip(&packed(1e-3), Keep::Surface).expect("stripped");
    let losses = read_losses(&File::parse(&surface).expect("a file")).expect("losses");
    assert!(losses.iter().any(|(kind, _)| *kind == SectionKind::SurfaceBasis));
    let probes = strip(&packed(1e-3), Keep::Probes).expect("stripped");
    assert!(probes == strip(raw(), Keep::Probes).and_then(|bytes| pack(&bytes, 3)).expect("packed"));
}

/// Surface, nodes and points of a state with these coordinates, and the surface after a contact.
fn fields<T: Scalar>(bytes: &[u8], structure: StructureChoice) -> [Vec<f64>; 3] {
    let options = SceneOptions { structure, ..SceneOptions::default() };
    with_scene::<T, _>(bytes, &options, |scene, state, loads| {
        let (n, n_surface) = (scene.metadata().n_nodes as usize, scene.metadata().n_surface_nodes as usize);
        let zeta: Vec<f64> = (0..scene.n_modes()).map(|k| 1.0 / (1.0 + k as f64)).collect();
        scene.set(state, &zeta, &zeta, loads).expect("set");
        let mut body = vec![T::ZERO; 3 * n];
        scene.body_into(state, Field::Displacement, &mut body).expect("the body");
        let nodes = (0..n).flat_map(|i| scene.node(state, i, Field::Displacement).expect("a node")).collect();
        let contact = Contact::new(Place::triangle([3, 150, 399], [0.2, 0.5, 0.3]), [1.0, -2.0, 0.5]);
        loads.add_contact(scene, &contact).expect("a contact");
        let zero = vec![0.0; scene.n_modes()];
        scene.set(state, &zero, &zero, loads).expect("set");
        (0..50).for_each(|_| {
            scene.step(state, loads).expect("a step");
        });
        let mut surface = vec![T::ZERO; 3 * n_surface];
        scene.surface_into(state, Field::Displacement, &mut surface).expect("the surface");
        let wide = |x: Vec<T>| x.into_iter().map(T::to_f64).collect::<Vec<f64>>();
        [wide(body), nodes, wide(surface)]
    })
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    norm(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>())
}

fn reads_in_place<T: Scalar>() {
    let tolerance = 1e-3;
    let opened = unpack(&packed(tolerance), DECODED_LIMIT).expect("unpacked");
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        let [body, nodes, contact] = fields::<T>(&opened, structure);
        // The same rows three ways: row by row in f64, all at once in T. Each of r products and sums rounds
        // once or twice.
        assert!(difference(&body, &nodes) <= 64.0 * T::EPSILON * norm(&nodes));
        // Against the exact basis: no mode is off by more than the tolerance of itself, and Σ_k |ζ_k| |B_k| ≤
        // r^½ |u| if the columns are orthogonal, which those of this body are to a few per cent.
        let [exact, _, exact_contact] = fields::<f64>(raw(), structure);
        let bound = tolerance * 10.0f64.sqrt();
        let off = difference(&exact, &nodes);
        assert!(0.0 < off && off <= bound * norm(&exact), "{off}");
        // A contact takes its rows of the basis (and of the loads) rounded too.
        assert!(difference(&exact_contact, &contact) <= 3.0 * bound * norm(&exact_contact));
    }
}

#[test]
fn quantised_sections_are_read_where_they_lie_in_f64() {
    reads_in_place::<f64>();
}

#[test]
fn quantised_sections_are_read_where_they_lie_in_f32() {
    reads_in_place::<f32>();
}

#[test]
fn a_packed_file_is_unpacked_in_part_into_lent_memory() {
    let packed = packed(1e-3);
    let file = File::parse(&packed).expect("a file");
    let whole = unpack(&packed, DECODED_LIMIT).expect("unpacked");
    let mut memory = vec![0xAA; unpacked_len(&file, |_| true).expect("a length")];
    assert!(unpack_into(&file, |_| true, &mut memory).expect("unpacked").bytes() == whole);

    let wanted = |kind| Keep::Surface.keeps(kind);
    let needed = unpacked_len(&file, wanted).expect("a length");
    assert!(needed < whole.len() && needed == strip(&whole, Keep::Surface).expect("stripped").len());
    let mut memory = vec![0xAA; needed + 5];
    let surface = unpack_into(&file, wanted, &mut memory).expect("unpacked");
    assert!(surface.section(SectionKind::InteriorBasis).is_none());
    assert!(surface.bytes() == strip(&whole, Keep::Surface).expect("stripped"));
    let short = unpack_into(&file, wanted, &mut vec![0; needed - 1]).expect_err("too short");
    assert!(matches!(short, FormatError::LentMemory { needed: n, .. } if n == needed as u64), "{short}");
    let none = unpack_into(&file, |_| false, &mut memory).expect_err("nothing to step with");
    assert!(matches!(none, FormatError::Missing { .. }), "{none}");

    // What is not wanted is not read: damage there goes unseen until it is.
    let interior = file.section(SectionKind::InteriorBasis).expect("there").stored();
    let place = interior.as_ptr() as usize - packed.as_ptr() as usize + interior.len() / 2;
    let mut damaged = packed.clone();
    damaged[place] ^= 1;
    let file = File::parse(&damaged).expect("a file");
    unpack_into(&file, wanted, &mut memory).expect("the surface is whole");
    let mut all = vec![0; whole.len()];
    let found = unpack_into(&file, |_| true, &mut all).expect_err("damage");
    assert!(matches!(found, FormatError::SectionChecksum { kind: 7, .. }), "{found}");
}

/// The packed file with its sections changed.
fn edited(
    bytes: &[u8],
    mut edit: impl FnMut(&mut SectionInput<'_>, &mut Vec<u8>),
) -> Result<Vec<u8>, FormatError> {
    let file = File::parse(bytes).expect("a file");
    let parts: Vec<_> = file.sections().map(|s| (s, s.stored().to_vec())).collect();
    let mut made = vec![];
    for (s, mut stored) in parts {
        let mut input = SectionInput { required: false, stored: &[], ..s.into() };
        edit(&mut input, &mut stored);
        made.push((input, stored));
    }
    let inputs: Vec<SectionInput<'_>> =
        made.iter().map(|(input, stored)| SectionInput { stored, ..*input }).collect();
    let mut out = vec![0; encoded_len(file.metadata(), &inputs)?];
    encode_into(file.metadata(), &inputs, &mut out)?;
    Ok(out)
}

#[test]
fn any_block_can_be_decoded_alone() {
    let mut seen = 0;
    for packed in [pack(raw(), 3).expect("packed"), packed(1e-2)] {
        let whole = unpack(&packed, DECODED_LIMIT).expect("unpacked");
        let (file, raw) = (File::parse(&packed).expect("a file"), File::parse(&whole).expect("a file"));
        let mut decoder = Decoder::new().expect("a decoder");
        for section in file.sections() {
            let Ok(blocks) = Blocks::new(&section) else { continue };
            let decoded = raw.section(section.kind()).expect("there").stored();
            for index in (0..blocks.len()).rev() {
                let range = blocks.decoded(index);
                let mut block = vec![0; (range.end - range.start) as usize];
                decoder.block_into(&section, &blocks, index, &mut block).expect("a block");
                assert!(block == decoded[range.start as usize..range.end as usize]);
                seen += 1;
            }
            assert!(blocks.frame(blocks.len()).is_err());
        }
    }
    assert!(seen > 5, "{seen} blocks");
}

#[test]
fn a_wrong_table_or_frame_is_refused_by_number() {
    let packed = pack(raw(), 3).expect("packed");
    let kind = SectionKind::SurfaceBasis;
    let refusal = |change: &dyn Fn(&mut Vec<u8>)| {
        let hostile = edited(&packed, |input, stored| {
            if input.kind == kind {
                assert_eq!(input.codec, Codec::Shuffled);
                change(stored);
            }
        });
        let hostile = hostile.expect("the structure is sound");
        let file = File::parse(&hostile).expect("a file");
        let mut memory = vec![0; unpacked_len(&file, |_| true).expect("a length")];
        let found = unpack_into(&file, |_| true, &mut memory).expect_err("refused");
        assert!(unpack(&hostile, DECODED_LIMIT).is_err());
        found
    };
    let number = |place: usize, value: u64| {
        move |b: &mut Vec<u8>| b[8 * place..8 * place + 8].copy_from_slice(&value.to_le_bytes())
    };
    let table = |found| assert!(matches!(found, FormatError::BlockTable { kind: 6, .. }), "{found}");
    for length in [0, 4, (1 << 20) + 8, u64::MAX, u64::MAX - 7, 8] {
        table(refusal(&number(0, length)));
    }
    for end in [0, u64::MAX, 1 << 40] {
        // The first frame, or the last one, ends there.
        let found = refusal(&number(1, end));
        assert!(matches!(found, FormatError::BlockTable { .. } | FormatError::Frame { .. }), "{found}");
        let last = |b: &mut Vec<u8>| {
            let count =
                (3 * 1600 * 10 * 8usize).div_ceil(u64::from_le_bytes(b[..8].try_into().expect("8")) as usize);
            b[8 * count..8 * count + 8].copy_from_slice(&end.to_le_bytes());
        };
        table(refusal(&last));
    }
    table(refusal(&|b| b.truncate(7)));
    table(refusal(&|b| b.truncate(20)));
    table(refusal(&|b| b.push(0)));
    let frame = |found| assert!(matches!(found, FormatError::Frame { kind: 6, .. }), "{found}");
    frame(refusal(&|b| {
        let at = b.len() - 8;
        b[at..].fill(0xFF);
    }));
    // Twice the block length: half as many entries are read as ends, and what lies there is no frame of that
    // length.
    let found = refusal(&|b| {
        let length = u64::from_le_bytes(b[..8].try_into().expect("8"));
        b[..8].copy_from_slice(&(2 * length).to_le_bytes());
    });
    assert!(matches!(found, FormatError::BlockTable { .. } | FormatError::Frame { .. }), "{found}");
    // Differences are for 16-bit numbers.
    let wrong = edited(&packed, |input, _| {
        if input.kind == kind {
            input.codec = Codec::Delta;
        }
    });
    assert_eq!(wrong.expect_err("refused"), FormatError::Codec { kind: 6, found: 3 });
}

/// Flips, cuts and splices within the stored bytes of sections, with checksums made right again.
#[test]
fn damaged_sections_do_no_harm() {
    let files = [packed(1e-2), unpack(&packed(1e-2), DECODED_LIMIT).expect("unpacked")];
    let mut random = Random::new(11);
    let mut below = |n: usize| ((random.number() + 1.0) * 0.5 * n as f64) as usize;
    let mut memory = vec![0; files[1].len()];
    let (mut opened, mut refused) = (0, 0);
    for round in 0..400 {
        let source = &files[round % 2];
        let target = SPACE[round / 2 % 3];
        let damaged = edited(source, |input, stored| {
            if input.kind != target || stored.is_empty() {
                return;
            }
            match below(4) {
                0 => stored.truncate(below(stored.len())),
                1 => {
                    let (from, to, n) = (below(stored.len()), below(stored.len()), below(100));
                    let piece: Vec<u8> = stored[from..].iter().take(n).copied().collect();
                    stored.splice(to..to, piece);
                }
                _ => {
                    // Now and then in the table, where it hurts most.
                    let reach = if below(2) == 0 { stored.len().min(64) } else { stored.len() };
                    stored[below(reach)] ^= 1 << below(8);
                }
            }
        });
        let Ok(damaged) = damaged else {
            refused += 1;
            continue;
        };
        let file = File::parse(&damaged).expect("what was written opens");
        match (unpack_into(&file, |_| true, &mut memory), unpack(&damaged, DECODED_LIMIT)) {
            (Ok(raw), Ok(other)) => {
                assert!(raw.bytes() == other);
                let _ = check(raw.bytes());
                // Numbers may be anything now; stepping and showing them must hold up.
                with_scene::<f32, _>(raw.bytes(), &SceneOptions::default(), |scene, state, loads| {
                    let contact = Contact::new(Place::triangle([0, 1, 2], [0.2, 0.3, 0.5]), [1.0; 3]);
                    let _ = loads.add_contact(scene, &contact);
                    let _ = scene.step(state, loads);
                    let mut body = vec![0.0; 3 * scene.metadata().n_nodes as usize];
                    let _ = scene.body_into(state, Field::Displacement, &mut body);
                    let _ = scene.node(state, 5, Field::Velocity);
                });
                opened += 1;
            }
            (Err(_), Err(_)) => refused += 1,
            (a, b) => panic!("the two decoders disagree: {:?} {:?}", a.err(), b.err()),
        }
    }
    assert!(opened > 20 && refused > 20, "{opened} opened, {refused} refused");
}
