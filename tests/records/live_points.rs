//! Errors of a file with live regions at random points and corners of its box, which no build has seen.
//!
//! ```text
//! cargo run --release -p vademecum-tests --example live_points -- PROBLEM FILE
//!     [--random N] [--corners N] [--seed N] [--modes N]
//! ```
//!
//! Each point has one push at a random loadable node in a random direction, over one period of the first
//! natural frequency there, and 200 steps of a fortieth of that period. Errors are relative to the motion of
//! the full model that is exact in time: over all unknowns and steps, of the projection of that motion on the
//! stepped modes, and of the displacement under the push.

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_format::File;
use vademecum_tests::live_point::LivePoint;
use vademecum_tests::synthetic::Random;

fn main() {
    let (mut paths, mut random, mut corners, mut seed, mut modes) = (vec![], 64, 16, 1, 32);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().and_then(|text| text.parse().ok()).expect("a number");
        match argument.as_str() {
            "--random" => random = value(),
            "--corners" => corners = value(),
            "--seed" => seed = value(),
            "--modes" => modes = value() as usize,
            _ => paths.push(PathBuf::from(argument)),
        }
    }
    let [problem, bytes] = &paths[..] else { panic!("expected PROBLEM FILE") };
    let problem = Problem::read(problem).expect("a problem");
    let bytes = std::fs::read(bytes).expect("a file");
    let file = File::parse(&bytes).expect("a file");
    let mut dice = Random::new(seed);
    for (kind, count) in [("interior", random), ("corner", corners)] {
        let mut errors = [vec![], vec![], vec![]];
        for number in 0..count {
            let point = LivePoint::draw(&problem, &file, kind == "corner", &mut dice);
            let found = point.errors(&problem, &file, modes);
            let [all, projection, push] = found;
            eprintln!(
                "{kind} {}: {all:.2e}, projection {projection:.2e}, under the push {push:.2e}",
                number + 1
            );
            errors.iter_mut().zip(found).for_each(|(all, own)| all.push(own));
        }
        for (what, mut errors) in
            ["all unknowns", "projection on the basis", "under the push"].into_iter().zip(errors)
        {
            errors.sort_by(f64::total_cmp);
            if let [.., worst] = errors[..] {
                let median = errors[errors.len() / 2];
                println!("{count} points, {kind}, {what}: median {median:.2e}, worst {worst:.2e}");
            }
        }
    }
}
