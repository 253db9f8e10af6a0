//! The record of a comparison at large displacements.

use std::path::Path;

use vademecum_build::store::{Kind, Outputs};
use vademecum_lab::{LARGE_COLUMNS, LargeBenchTable};

use super::output::{csv, table_of, write_texts};
use super::pareto;
use vademecum_cli::Failure;
use vademecum_cli::front::json;

/// Files written.
pub const FILES: [(&str, Kind); 4] = [
    ("bench.json", Kind::Json),
    ("bench.csv", Kind::Csv),
    ("bench.md", Kind::Text),
    ("pareto.svg", Kind::Svg),
];

/// Writes bench.json, bench.csv, bench.md and the picture.
pub fn write(outputs: &Outputs, folder: &Path, table: &LargeBenchTable) -> Result<(), Failure> {
    let texts = [json(table), csv(&LARGE_COLUMNS, &table.methods), markdown(table)];
    write_texts(outputs, folder, &texts)?;
    pareto::draw_large(outputs, folder, table)
}

/// The conditions and the table.
pub fn markdown(table: &LargeBenchTable) -> String {
    format!(
        "{}: {} dofs, {} coordinates, {} strain rows, {} steps of {} s, {:.1} steps per first period.\n\
         The surface moves by up to {:.3e} m; the least stretch of an element is {:.2}.\n\
         Errors are measured from a march at full order by Bathe's method with {} steps in a step, which is \
         {:.1e} from one with half as many; of a smooth motion its own error is about a third of that.\n\
         Steps of the file timed in bursts of {}, {} rounds by turns; clock and loop {:.2} ns per step, not taken \
         off; medians of the rounds {:.1} % apart. What marches over all elements is timed step by step along \
         the scenario.\n\n{}",
        table.title,
        table.dofs,
        table.coordinates,
        table.strain_rows,
        table.steps,
        table.time_step,
        table.steps_per_first_period,
        table.displacement,
        table.least_stretch,
        table.truth_parts,
        table.truth_error,
        table.burst,
        table.rounds,
        table.clock_ns_per_step,
        100.0 * table.noise,
        table_of(&LARGE_COLUMNS, &table.methods)
    )
}
