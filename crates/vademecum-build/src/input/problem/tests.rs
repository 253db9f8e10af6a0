//! A problem is read as it stands, or refused by key.

use super::*;

const SMALL: &str = r#"
    [mesh]
    block = { lengths = [1.0, 0.1, 0.1], divisions = [4, 1, 1] }
    [[material]]
    young = 2e11
    poisson = 0.3
    density = 7800.0
    [[support]]
    on = { group = "x_min" }
    [load]
    [time]
    step = 1e-3
"#;

fn parse(text: &str) -> Result<Problem, ProblemError> {
    Problem::parse(text, "p.toml", PathBuf::new())
}

#[test]
fn the_smallest_problem_has_the_documented_defaults() {
    let p = parse(SMALL).unwrap();
    assert_eq!((p.scheme(), p.basis_kind()), (SchemeKind::Exact {}, BasisKind::Modes));
    assert_eq!(p.basis.oversampling, 4);
    assert_eq!(p.snapshots.positions, 12);
}

#[test]
fn a_list_that_is_longer_than_its_key_takes_is_refused_with_its_line() {
    let axes = SMALL.replace("density", "axes = [[1, 0, 0, 5], [0, 1, 0]]\n    density");
    let three = SMALL.replace("[4, 1, 1]", "[4, 1, 1, 9]");
    for (text, place, key, found) in [
        (axes, "p.toml:7", "`material[0].axes[0]`", "a list of 4; expected a list of 3"),
        (three, "p.toml:3", "`mesh.block.divisions`", "a list of 4; expected a list of 3"),
    ] {
        let message = parse(&text).unwrap_err().to_string();
        assert!([place, key, found].iter().all(|part| message.contains(part)), "{message}");
    }
}

#[test]
fn an_unknown_key_is_refused_with_its_line() {
    let text = SMALL.replace("poisson = 0.3", "poison = 0.3");
    let message = parse(&text).unwrap_err().to_string();
    assert!(message.contains("line 6") && message.contains("poison"), "{message}");
}

#[test]
fn schemes_and_damping_out_of_range_are_named_with_their_line() {
    for (scheme, part) in [
        ("{ name = \"bathe\", rho_infinity = 0.5 }", "unknown field"),
        ("\"bathe\"", "a table with the scheme's name"),
        ("{ name = \"newmark\", beta = 0.1, gamma = 0.5 }", "p.toml:13: `time.scheme`"),
        ("{ name = \"bathe\" }\n[damping]\nratios = [[0.5, 5.0], [0.001, 80.0]]", "p.toml:14: `damping`"),
    ] {
        let text = SMALL.replace("step = 1e-3", &format!("step = 1e-3\nscheme = {scheme}"));
        let message = parse(&text).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn impossible_values_are_named_by_key() {
    for (from, to, key) in [
        ("young = 2e11", "young = -1.0", "material[0].young"),
        ("poisson = 0.3", "poisson = 0.5", "material[0].poisson"),
        ("step = 1e-3", "step = 0.0", "time.step"),
        ("divisions = [4, 1, 1]", "divisions = [4, 0, 1]", "mesh.block.divisions"),
        ("[load]", "[damping]\nalpha = -1.0\n[load]", "damping.alpha"),
        ("[load]", "[basis]\nmodes = 0\n[load]", "basis.modes"),
        ("[load]", "[load]\n[[load.pattern]]\nname = \"g\"\nacceleration = [nan, 0, 0]", "load.pattern[0]"),
        (
            "[load]",
            "[[output.probe]]\nname = \"p\"\npoint = [inf, 0, 0]\ndirection = [0, 0, 1]\n[load]",
            "output.probe[0].point",
        ),
        ("\"x_min\" }", "\"x_min\" }\ncomponents = []", "support[0].components"),
    ] {
        match parse(&SMALL.replace(from, to)).unwrap_err() {
            ProblemError::Toml(TomlError::Impossible { key: found, .. }) => assert_eq!(found, key),
            other => panic!("{other}"),
        }
    }
}
