//! A file of the chapter's maps for the loads of one scenario.
//!
//! The position axis lists the nodes the scenario loads and no others, and the components of a load are axes,
//! so the maps serve every direction there. Ranges are marched at full order as a build does, under unit
//! loads at some of those nodes. Note: a map for six nodes is a smaller task than the one for a
//! whole surface that a build is asked for, so the chapter is compared at its best.

use vademecum_build::basis::{Basis, SnapshotSchedule};
use vademecum_build::dynamics::FullOrder;
use vademecum_build::export::NodeOrder;
use vademecum_build::input::{ChapterEntry, Repair};
use vademecum_build::prepared::Prepared;
use vademecum_build::progress::Listener;
use vademecum_chapter::{ChapterCertificate, ChapterMap, ChapterSetting, sections};

use vademecum_study::StudyError;
use vademecum_study::parts::{Form, Study, Timed};

/// Points and size of loads.
#[derive(Clone, Debug)]
pub struct LoadSites {
    /// Mesh nodes a load can stand at.
    pub nodes: Vec<u32>,
    /// Those of them at which unit loads are marched for the ranges.
    pub marched: Vec<u32>,
    /// Largest sum of magnitudes that acts on one march \[N\].
    pub magnitude: f64,
}

impl LoadSites {
    fn entry(&self, repairs: &[Repair], max_terms: Option<usize>) -> ChapterEntry {
        ChapterEntry {
            repairs: repairs.to_vec(),
            max_terms,
            load: [0.0, self.magnitude],
            components: true,
            ..ChapterEntry::default()
        }
    }
}

/// Marches what the axes range over: unit loads in the three directions of space, held and released as
/// the snapshots' are.
///
/// # Errors
/// [`StudyError`]: a march that is stopped.
pub fn chapter_setting(
    study: &Study,
    basis: &Basis,
    sites: &LoadSites,
    listener: &dyn Listener,
) -> Result<Timed<ChapterSetting>, StudyError> {
    let Prepared { body, scheme, symbolic, .. } = study.prepared();
    let dt = study.time_step();
    let directions = (0..3).map(|c| std::array::from_fn(|k| f64::from(u8::from(k == c)))).collect();
    let runs = SnapshotSchedule { nodes: sites.marched.clone(), directions, ..study.runs().clone() };
    Timed::of(|| {
        let full = FullOrder::new(body.model.pencil(), symbolic, scheme, dt, study.prepared().rayleigh())?;
        let entry = sites.entry(&[], None);
        let setting = ChapterSetting::new(&entry, study.prepared(), basis, &full, &runs, listener)?;
        Ok(setting.at(sites.nodes.clone()))
    })
}

/// The bytes of a file of the chapter's maps on this basis, and the most terms of a stage; without a
/// limit as many as the exact map has. Its certificate says nothing of trajectories (no step marched).
///
/// # Errors
/// [`StudyError`]: a stage that does not factorise, a separation that fails.
pub fn chapter_file(
    study: &Study,
    basis: &Basis,
    sites: &LoadSites,
    setting: &ChapterSetting,
    repairs: &[Repair],
    max_terms: Option<usize>,
) -> Result<Timed<(Vec<u8>, usize)>, StudyError> {
    Timed::of(|| {
        let map = setting.with(sites.entry(repairs, max_terms)).separate(study.prepared(), basis)?;
        let certificate = ChapterCertificate::of_maps(&map);
        let terms = certificate.terms.iter().copied().max().unwrap_or_default();
        Ok((chapter_bytes(study, basis, &map, &certificate)?, terms))
    })
}

/// The bytes of a file of maps and what is known of them.
///
/// # Errors
/// [`StudyError`]: numbers a file cannot hold.
pub fn chapter_bytes(
    study: &Study,
    basis: &Basis,
    map: &ChapterMap,
    certificate: &ChapterCertificate,
) -> Result<Vec<u8>, StudyError> {
    let others = sections(map, certificate, &NodeOrder::new(&study.prepared().body));
    study.encode(basis, Form { others, ..Form::default() })
}
