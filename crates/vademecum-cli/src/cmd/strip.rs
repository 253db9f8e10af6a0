//! `vademecum strip`: a file without what its target does not need.

use std::path::PathBuf;

use vademecum_format::{File, SectionKind};
use vademecum_rewrite::{Keep, RewriteError, TermReduction, drop_terms_limited, strip};
use vademecum_study::scenario::Scenario;
use vademecum_study::target::check_target;

use crate::arguments::{Limit, OutputArguments, rounding};
use crate::failure::Failure;
use crate::files::{RewriteOutput, open_pair, write_file};
use crate::print::print_json;

/// Drops the parts of a file a target does not need.
#[derive(clap::Args)]
#[command(after_help = "Example:
  vademecum strip body.vdm --keep probes -o probe.vdm
  vademecum strip body.vdm --keep surface --for push.toml -o game.vdm
  vademecum strip body.vdm --terms-for 1e-4 -o fast.vdm
What is dropped is named; a scene that asks for it is refused by name.")]
pub(crate) struct Strip {
    /// The vademecum file.
    file: PathBuf,
    /// Uses that the new file keeps.
    #[arg(long, value_enum, default_value_t = KeepArgument::All, required_unless_present = "terms_for")]
    keep: KeepArgument,
    /// Drop terms of the separated solution while its maps stay within this relative error, such as 1e-4.
    #[arg(long, value_name = "TOLERANCE", value_parser = rounding)]
    terms_for: Option<f64>,
    /// A scenario (TOML) the new file must still be able to play and show.
    #[arg(long = "for", value_name = "SCENARIO")]
    target: Option<PathBuf>,
    /// The new file.
    #[arg(short, long)]
    output: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
    #[command(flatten)]
    limit: Limit,
}

/// Uses that a stripped file keeps, as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum KeepArgument {
    /// Stepping under load patterns, and the probes.
    Probes,
    /// Stepping, contacts, and fields on the surface.
    Surface,
    /// Everything.
    All,
}

impl Strip {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let keep = match self.keep {
            KeepArgument::Probes => Keep::Probes,
            KeepArgument::Surface => Keep::Surface,
            KeepArgument::All => Keep::All,
        };
        let failed = |error: RewriteError| Failure::file(&self.file, error);
        let (outputs, bytes) = open_pair(&self.outputs, &self.file, &[self.target.as_deref()], &self.output)?;
        let mut stripped = strip(&bytes, keep).map_err(failed)?;
        let mut dropped_terms = None;
        if let Some(tolerance) = self.terms_for {
            let (fewer, dropped) =
                drop_terms_limited(&stripped, tolerance, self.limit.of(bytes.len())).map_err(failed)?;
            stripped = fewer;
            dropped_terms = Some(dropped);
        }
        if let Some(scenario) = &self.target {
            check_target(&stripped, &Scenario::read(scenario)?)
                .map_err(|error| Failure::file(&self.file, error))?;
        }
        let file = File::parse(&bytes).map_err(|error| Failure::file(&self.file, error))?;
        let written = write_file(&outputs, &self.output, &stripped, bytes.len())?;
        let dropped: Vec<SectionKind> =
            file.sections().map(|s| s.kind()).filter(|&kind| !keep.keeps(kind)).collect();
        let lost = LOST.iter().filter(|(kind, _)| dropped.contains(kind));
        let without =
            lost.map(|&(section, lost)| LostSection { section: section.to_string(), lost }).collect();
        let stripped = StripOutput { written, terms: dropped_terms, without };
        if self.json {
            print_json(&stripped);
        } else {
            stripped.print();
        }
        Ok(())
    }
}

/// Report of a stripped file.
#[derive(serde::Serialize)]
struct StripOutput {
    #[serde(flatten)]
    written: RewriteOutput,
    /// With `--terms-for`.
    terms: Option<TermReduction>,
    without: Vec<LostSection>,
}

#[derive(serde::Serialize)]
struct LostSection {
    section: String,
    lost: &'static str,
}

impl StripOutput {
    fn print(&self) {
        self.written.print(false);
        if let Some(terms) = &self.terms {
            println!(
                "{} of {} terms left; error of the maps {:.1e} (rms), {:.1e} (largest); march it with \
                 `verify`",
                terms.left, terms.before, terms.error_rms, terms.error_max
            );
        }
        self.without.iter().for_each(|gone| println!("without {}: {}", gone.section, gone.lost));
    }
}

/// Lost uses without a section.
const LOST: [(SectionKind, &str); 17] = [
    (SectionKind::NodeIds, "no way back to the mesh, so `verify` cannot compare with it"),
    (SectionKind::NodeCoordinates, "no geometry"),
    (SectionKind::Triangles, "no surface to show"),
    (SectionKind::SurfaceBasis, "no contacts and no fields on the surface"),
    (SectionKind::InteriorBasis, "no fields inside the body"),
    (SectionKind::SingularValues, "no singular values to report"),
    (SectionKind::ModeTable, "no table of modes to report"),
    (SectionKind::EnrichmentHistory, "no history of the enrichment to report"),
    (SectionKind::RadiusSamples, "no spectral radius over the parameters to report"),
    (SectionKind::Repairs, "no word of what the build repaired"),
    (SectionKind::MeshError, "no word of the discretisation error"),
    (SectionKind::StructureFigures, "no word of how reciprocal the structures are"),
    (SectionKind::ContactResidual, "no residual flexibility under a contact"),
    (SectionKind::ProbeResidual, "no residual flexibility of a contact at the probes"),
    (SectionKind::FactorValues, "no static answer in whole fields"),
    (SectionKind::EmbeddedTriangles, "no embedded surface to draw"),
    (SectionKind::BoundMap, "no map of the bound over the surface"),
];
