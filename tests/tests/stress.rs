//! The reduced form of the stress matrix: every cell ends as the table says (`docs/benchmarks/stability.md`
//! is the full form).

use vademecum_tests::stress::{Form, cells, row};

#[test]
fn every_cell_ends_as_the_table_says() {
    let missed: Vec<String> = cells()
        .iter()
        .filter_map(|cell| {
            let outcome = cell.run(Form::Reduced);
            let line = row(cell, &outcome);
            print!("{line}");
            let held = outcome.verdict().is(cell.expected);
            (!held).then(|| format!("expected {:?}:\n{line}", cell.expected))
        })
        .collect();
    assert!(missed.is_empty(), "{} cells:\n{}", missed.len(), missed.join("\n"));
}
