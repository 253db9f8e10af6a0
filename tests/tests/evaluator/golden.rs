//! Files of released versions stay readable for ever, and the writer still writes them byte for byte.

use vademecum_eval::{Contact, Field, Place, SceneOptions, Status, StructureChoice};
use vademecum_format::{Chapter, Element, File, Section, SectionKind};
use vademecum_rewrite::check;
use vademecum_tests::golden;
use vademecum_tests::program::{fixtures, repository, vademecum};
use vademecum_tests::stage::{with_chapter, with_scene};

#[test]
fn the_writer_reproduces_every_golden_file() {
    let (known, mut made) = (fixtures("golden"), golden::all());
    made.sort();
    let names = |files: &[(String, Vec<u8>)]| files.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&known), made.iter().map(|f| f.0.to_string()).collect::<Vec<_>>());
    for ((name, known), (_, made)) in known.iter().zip(&made) {
        let first = known.iter().zip(made).position(|(a, b)| a != b);
        assert!(known == made, "{name} differs, first at byte {first:?}: read fixtures/README.md");
    }
    // What a clone of the repository carries for ever.
    assert!(known.iter().map(|f| f.1.len()).sum::<usize>() <= 256 * 1024);
}

#[test]
fn a_file_has_the_lowest_minor_version_that_has_its_sections() {
    for (name, bytes) in fixtures("golden") {
        let file = File::parse(&bytes).expect("a file");
        let later =
            ["canonical.vdm", "quantised.vdm", "repairs.vdm", "separation.vdm"].contains(&name.as_str());
        let newest = ["base.vdm", "free.vdm", "reactions.vdm", "stress.vdm"].contains(&name.as_str());
        let fitted = name == "swinging.vdm";
        let strain = fitted || name == "bent.vdm";
        let anisotropic = name == "anisotropic.vdm";
        let coupled = name == "dashpots.vdm";
        let ports = name == "ports.vdm";
        let facets = name == "quadrangles.vdm";
        let patch = name == "patch.vdm";
        let parametric = ["damped.vdm", "parametric.vdm"].contains(&name.as_str());
        let newer = ports || facets || patch || parametric;
        let exact = name == "exact-f64.vdm" || newest || strain || anisotropic || coupled || newer;
        let minor = if parametric {
            14
        } else if patch {
            13
        } else if ports {
            12
        } else if facets {
            11
        } else if coupled {
            10
        } else if anisotropic || name == "embedded.vdm" {
            9
        } else if fitted {
            7
        } else if strain {
            6
        } else if newest {
            5
        } else if exact {
            3
        } else {
            u16::from(later)
        };
        assert_eq!(file.minor(), minor, "{name}");
        let since = |s: Section<'_>| s.kind().since().max(u16::from(s.element() == Element::I16));
        assert_eq!(file.sections().map(since).max(), Some(file.minor()), "{name}");
        assert_eq!(file.metadata().scheme.is_exact(), exact, "{name}");
    }
}

#[test]
fn every_golden_file_is_sound() {
    for (name, bytes) in fixtures("golden") {
        let checked = check(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(checked.unknown_sections, 0);
        let path = repository().join("fixtures/golden").join(name);
        let ran =
            vademecum(&["verify".as_ref(), path.as_os_str(), "--file-only".as_ref(), "--json".as_ref()]);
        assert_eq!(ran.json()["numbers"], checked.numbers);
    }
}

#[test]
fn every_golden_file_steps_in_every_structure_it_has() {
    for (name, bytes) in fixtures("golden") {
        let file = File::parse(&bytes).expect("a file");
        let metadata = *file.metadata();
        let surface = file.section(SectionKind::SurfaceBasis).is_some();
        if let Some(chapter) = Chapter::read(&file).expect("sound tables") {
            steps_the_chapter(&name, &bytes, &chapter);
        }
        let stages = !metadata.scheme.is_exact();
        let present = [
            (StructureChoice::Diagonal, metadata.diagonal && stages),
            (StructureChoice::Block, metadata.block),
            (StructureChoice::Exact, metadata.diagonal),
            (StructureChoice::Strain, file.section(SectionKind::StrainSizes).is_some()),
        ];
        assert!(present.iter().any(|s| s.1) || name == "canonical.vdm", "{name}");
        for (structure, _) in present.into_iter().filter(|s| s.1) {
            let options = SceneOptions { structure, ..SceneOptions::default() };
            with_scene::<f64, _>(&bytes, &options, |scene, state, loads| {
                loads.add_pattern(scene, 0, 1.0).expect("a pattern");
                let contact = Contact::new(Place::triangle([0, 1, 3], [0.2, 0.5, 0.3]), [1.0, -2.0, 0.5]);
                assert_eq!(loads.add_contact(scene, &contact).is_ok(), surface, "{name}");
                for _ in 0..100 {
                    assert_eq!(scene.step(state, loads).expect("a step"), Status::Moving, "{name}");
                }
                let energy = scene.energy(state).expect("an energy");
                assert!(energy.is_finite() && energy > 0.0, "{name}: {energy}");
                for probe in 0..metadata.n_probes as usize {
                    let value = scene.probe(state, probe, Field::Displacement).expect("a probe");
                    assert!(value.is_finite() && value != 0.0, "{name}: {value}");
                }
            });
        }
    }
}

/// The chapter's structure takes loads in its direction at its positions.
fn steps_the_chapter(name: &str, bytes: &[u8], chapter: &Chapter<'_>) {
    with_chapter(bytes, |scene, state, loads| {
        let node = chapter.positions().next().expect("a position");
        let force = chapter.direction().expect("one direction");
        let contact = Contact::new(Place::triangle([node; 3], [1.0, 0.0, 0.0]), force);
        loads.add_contact(scene, &contact).expect("a contact");
        for _ in 0..100 {
            assert_eq!(scene.step(state, loads).expect("a step"), Status::Moving, "{name}");
        }
        assert!(scene.energy(state).expect("an energy") > 0.0, "{name}");
    });
}
