//! The chapter's vademecum in the comparison: its maps for the nodes a scenario loads, and how they march it.
//!
//! A map of the chapter (state and load in the same terms) stands under one load at one node. A contact is up
//! to three of those, so the chapter's answer is a superposition: one march from rest per loaded node, all
//! with the same maps, summed. With state and load apart, which is one of the repairs, loads add up within
//! one march.
//!
//! Note: a coordinate that leaves its range ends the march. Such a row has no error, and says where
//! it ended.

mod map;
mod play;

use std::rc::Rc;

use vademecum_build::input::{BasisKind, Repair};
use vademecum_build::progress::Listener;
use vademecum_eval::{Contact, Place};
use vademecum_study::parts::{ScenarioLoads, Study, Timed};
use vademecum_study::player::{PlacedContact, Track};

use super::method::{Group, Identity, Method, Part, Precision, Stepper, Way};
use vademecum_study::StudyError;

pub use map::{LoadSites, chapter_bytes};
pub(super) use play::play;

/// Most terms of a stage in the chapter's rows; the last one has as many as the exact map.
const TERMS: [Option<usize>; 3] = [Some(20), Some(40), None];

/// True of numbers of modes that are compared: with many modes the maps take long to make.
fn compared(modes: usize) -> bool {
    (6..=8).contains(&modes)
}

/// Adds the chapter's rows on POD vectors and the repaired row on the default basis, for some numbers of
/// modes.
pub(super) fn add(
    groups: &mut [Group],
    study: &Study,
    scenario: &ScenarioLoads,
    listener: &dyn Listener,
) -> Result<(), StudyError> {
    if scenario.track.contacts.is_empty() || !scenario.track.patterns.is_empty() {
        listener.note("no canonical rows: the chapter's loads are forces at nodes, the scenario has others");
        return Ok(());
    }
    for group in groups.iter_mut().filter(|group| compared(group.basis.n_modes())) {
        let rows = match group.kind {
            BasisKind::Pod => Rows::chapter(study, scenario),
            BasisKind::Ritz => Rows::repaired(study, scenario),
            BasisKind::Modes => continue,
        };
        rows.add(group, study, listener)?;
    }
    Ok(())
}

/// Rows that differ in the limit on their terms only.
struct Rows {
    way: Way,
    repairs: &'static [Repair],
    limits: &'static [Option<usize>],
    sites: LoadSites,
    tracks: Rc<Vec<Track>>,
}

impl Rows {
    /// One march per loaded node.
    fn chapter(study: &Study, scenario: &ScenarioLoads) -> Self {
        let nodal = node_by_node(&scenario.track);
        let sites = sites(study, scenario, &nodal, magnitudes(&nodal).fold(0.0, f64::max));
        Self { way: Way::Chapter, repairs: &[], limits: &TERMS, sites, tracks: Rc::new(nodal) }
    }

    /// All loads in one march.
    fn repaired(study: &Study, scenario: &ScenarioLoads) -> Self {
        let nodal = node_by_node(&scenario.track);
        let sites = sites(study, scenario, &nodal, magnitudes(&nodal).sum());
        let tracks = Rc::new(vec![scenario.track.clone()]);
        Self { way: Way::Repaired, repairs: &Repair::ALL, limits: &[None], sites, tracks }
    }

    /// One row per limit on the terms.
    fn add(&self, group: &mut Group, study: &Study, listener: &dyn Listener) -> Result<(), StudyError> {
        // The same responses, solved and not separated.
        let solved = |method: &Method| method.way == Way::Block && method.precision == Precision::Double;
        let exact = group.methods.iter().position(solved).expect("every basis has a block row");
        let name = Identity::Reduced { basis: group.kind, way: self.way, precision: Precision::Double };
        listener.stage(&format!("{name}, {} modes", group.basis.n_modes()));
        let setting = map::chapter_setting(study, &group.basis, &self.sites, listener)?;
        for &limit in self.limits {
            let file =
                map::chapter_file(study, &group.basis, &self.sites, &setting.value, self.repairs, limit)?;
            let Timed { value: (bytes, terms), seconds } = file;
            let offline_seconds = group.shared_seconds + setting.seconds + seconds;
            let stepper = Stepper::Chapter { bytes, tracks: Rc::clone(&self.tracks) };
            group.methods.push(Method {
                terms: Some(terms),
                differs: Some((Part::Separation, exact)),
                ..Method::new(self.way, offline_seconds, stepper)
            });
        }
        Ok(())
    }
}

/// One track per loaded node.
fn node_by_node(track: &Track) -> Vec<Track> {
    let nodal = |placed: &PlacedContact| {
        let PlacedContact { ref contact, .. } = *placed;
        let corners = contact.place.entries().filter(|(_, weight)| *weight != 0.0);
        let alone = |(node, weight): (u32, f64)| {
            let force = contact.force.map(|f| weight * f);
            let contact = Contact::new(Place::triangle([node; 3], [1.0, 0.0, 0.0]), force);
            Track { contacts: vec![PlacedContact { contact, ..placed.clone() }], ..Track::default() }
        };
        corners.map(alone).collect::<Vec<_>>()
    };
    track.contacts.iter().flat_map(nodal).collect()
}

/// Size of the force on each node \[N\].
fn magnitudes(nodal: &[Track]) -> impl Iterator<Item = f64> {
    let size = |force: [f64; 3]| force.iter().map(|f| f * f).sum::<f64>().sqrt();
    nodal.iter().flat_map(move |track| track.contacts.iter().map(move |placed| size(placed.contact.force)))
}

/// The loaded nodes; marched are those with the largest share of a contact, of the nodes that can move.
fn sites(study: &Study, scenario: &ScenarioLoads, nodal: &[Track], magnitude: f64) -> LoadSites {
    let dofs = study.prepared().body.model.dofs();
    let mesh_node = |node: u32| scenario.file_nodes[node as usize];
    let moves = |node: u32| (0..3).any(|c| dofs.free(3 * mesh_node(node) as usize + c).is_some());
    let heaviest = |PlacedContact { contact, .. }: &PlacedContact| {
        let corners = contact.place.entries().filter(|(node, _)| moves(*node));
        corners.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(node, _)| mesh_node(node))
    };
    let each_once = |mut nodes: Vec<u32>| {
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    };
    LoadSites {
        nodes: each_once(
            nodal.iter().map(|track| mesh_node(track.contacts[0].contact.place.nodes()[0])).collect(),
        ),
        marched: each_once(scenario.track.contacts.iter().filter_map(heaviest).collect()),
        magnitude,
    }
}
