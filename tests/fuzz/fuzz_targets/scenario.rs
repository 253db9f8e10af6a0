//! Any text as a scenario, bound to golden files and marched for a while: no panic, and no number that is not
//! finite but as an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vademecum_build::progress::Silent;
use vademecum_format::File;
use vademecum_study::StudyError;
use vademecum_study::player::PlayOptions;
use vademecum_study::run::{Moment, Run};
use vademecum_study::scenario::Scenario;

/// Both structures, live parameters, the chapter's structure.
const FILES: [&[u8]; 3] = [
    include_bytes!("../../../fixtures/golden/fixed-f64.vdm"),
    include_bytes!("../../../fixtures/golden/parameters.vdm"),
    include_bytes!("../../../fixtures/golden/canonical.vdm"),
];

/// Steps of a march.
const STEPS: f64 = 200.0;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(mut scenario) = Scenario::parse(text, "scenario.toml") else { return };
    for bytes in FILES {
        let file = File::parse(bytes).expect("a golden file");
        // Asked for as it is, a scenario is bound or refused; marched, it is cut short.
        let _ = Run::bind(&file, PlayOptions::default(), &scenario, &Silent);
        scenario.duration = scenario.duration.min(STEPS * file.metadata().time_step);
        let Ok(run) = Run::bind(&file, PlayOptions::default(), &scenario, &Silent) else { continue };
        // A file without its surface has no fields to show, and says so.
        if run.geometry().is_err() {
            continue;
        }
        let _ = run.play(&Silent, |moment: &Moment<'_>| -> Result<(), StudyError> {
            assert!(moment.time.is_finite());
            if let Some(probed) = &moment.probes {
                assert!(probed.energy.is_finite() && probed.values.iter().all(|x| x.is_finite()));
            }
            if let Some(fields) = &moment.fields {
                assert!(fields.displacement.iter().chain(fields.velocity).all(|x| x.is_finite()));
            }
            Ok(())
        });
    }
});
