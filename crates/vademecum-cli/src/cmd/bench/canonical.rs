//! The chapter's vademecum in the comparison: its maps for the nodes a scenario loads, and how they march it.
//!
//! A map of the chapter (state and load in the same terms) stands under one load at one node. A contact is up to three of those,
//! so the chapter's answer is a superposition: one march from rest per loaded node, all with the same maps, summed. With state
//! and load apart, which is one of the repairs, loads add up within one march.
//!
//! The odd thing: a coordinate that leaves its range ends the march. Such a row has no error, and says where it ended.

use std::path::Path;
use std::rc::Rc;

use vademecum_build::Matrix;
use vademecum_build::input::{BasisKind, Repair};
use vademecum_build::progress::Listener;
use vademecum_eval::chapter::{ChapterLoads, ChapterScene, ChapterState, ChapterStepError};
use vademecum_eval::{Contact, SceneOptions, SurfacePoint};
use vademecum_format::File;
use vademecum_study::bench::{LoadSites, Study, Timed};

use super::candidates::{Group, March, Method, Part, Stepper};
use super::inputs::Bound;
use crate::console::{Console, cancelled};
use crate::failure::{Cause, Failure};
use crate::player::{Body, Track, with_chapter};

/// Names of the rows.
const CHAPTER: &str = "pod canonical chapter f64";
const REPAIRED: &str = "ritz canonical repaired f64";
/// Most terms of a stage in the chapter's rows; the last one has as many as the exact map.
const TERMS: [Option<usize>; 3] = [Some(20), Some(40), None];

/// Whether a row is one of the chapter's representation.
pub fn is_canonical(name: &str) -> bool {
    [CHAPTER, REPAIRED].contains(&name)
}

/// A march in coordinates `(r, instants)`, or why there is none.
pub type Played = Result<Matrix, String>;

/// Adds the chapter's rows on POD vectors and the repaired row on the default basis, for some numbers of modes.
pub fn add(
    groups: &mut [Group],
    modes: &[usize],
    study: &Study,
    scenario: &Bound,
    console: &Console,
) -> Result<(), Failure> {
    if scenario.track.contacts.is_empty() || !scenario.track.patterns.is_empty() {
        console.note("no canonical rows: the chapter's loads are forces at nodes, the scenario has others");
        return Ok(());
    }
    for group in groups.iter_mut().filter(|group| modes.contains(&group.basis.n_modes())) {
        match group.kind {
            BasisKind::Pod => chapter(group, study, scenario, console)?,
            BasisKind::Ritz => repaired(group, study, scenario, console)?,
            BasisKind::Modes => {}
        }
    }
    Ok(())
}

fn chapter(group: &mut Group, study: &Study, scenario: &Bound, console: &Console) -> Result<(), Failure> {
    let tracks = Rc::new(node_by_node(&scenario.track));
    let sites = sites(study, scenario, &tracks, magnitudes(&tracks).fold(0.0, f64::max));
    separated(group, study, &sites, (CHAPTER, &[], &TERMS), &tracks, console)
}

fn repaired(group: &mut Group, study: &Study, scenario: &Bound, console: &Console) -> Result<(), Failure> {
    let nodal = node_by_node(&scenario.track);
    let sites = sites(study, scenario, &nodal, magnitudes(&nodal).sum());
    let whole = Track { contacts: scenario.track.contacts.clone(), patterns: vec![] };
    separated(group, study, &sites, (REPAIRED, &Repair::ALL, &[None]), &Rc::new(vec![whole]), console)
}

/// One row per limit on the terms.
fn separated(
    group: &mut Group,
    study: &Study,
    sites: &LoadSites,
    (name, repairs, limits): (&'static str, &[Repair], &[Option<usize>]),
    tracks: &Rc<Vec<Track>>,
    console: &Console,
) -> Result<(), Failure> {
    console.stage(&format!("{name}, {} modes", group.basis.n_modes()));
    let setting = study.canonical_setting(&group.basis, sites, console)?;
    // The same responses, solved and not separated.
    let exact = group.methods.iter().position(|method| method.name.ends_with("block f64"));
    let exact = exact.expect("every basis has a block row");
    for &limit in limits {
        let file = study.canonical_file(&group.basis, sites, &setting.value, repairs, limit)?;
        let Timed { value: (bytes, terms), seconds } = file;
        group.methods.push(Method {
            name,
            offline_seconds: group.shared_seconds + setting.seconds + seconds,
            stepper: Stepper::Canonical { bytes, tracks: Rc::clone(tracks) },
            terms: Some(terms),
            differs: Some((Part::Separation, exact)),
            shipped: None,
        });
    }
    Ok(())
}

/// One track per loaded node.
fn node_by_node(track: &Track) -> Vec<Track> {
    let nodal = |(contact, point, when): &(Contact, SurfacePoint, _)| {
        let corners = contact.nodes.into_iter().zip(contact.weights).filter(|(_, weight)| *weight != 0.0);
        let alone = |(node, weight): (u32, f64)| {
            let force = contact.force.map(|f| weight * f);
            let contact = Contact { nodes: [node; 3], weights: [1.0, 0.0, 0.0], force };
            Track { contacts: vec![(contact, *point, *when)], patterns: vec![] }
        };
        corners.map(alone).collect::<Vec<_>>()
    };
    track.contacts.iter().flat_map(nodal).collect()
}

/// Size of the force on each node \[N\].
fn magnitudes(nodal: &[Track]) -> impl Iterator<Item = f64> {
    let size = |force: [f64; 3]| force.iter().map(|f| f * f).sum::<f64>().sqrt();
    nodal.iter().flat_map(move |track| track.contacts.iter().map(move |c| size(c.0.force)))
}

/// The loaded nodes; marched are those with the largest share of a contact, of the nodes that can move.
fn sites(study: &Study, scenario: &Bound, nodal: &[Track], magnitude: f64) -> LoadSites {
    let dofs = study.prepared().body.model.dofs();
    let mesh_node = |node: u32| scenario.file_nodes[node as usize];
    let moves = |node: u32| (0..3).any(|c| dofs.free(3 * mesh_node(node) as usize + c).is_some());
    let heaviest = |(contact, ..): &(Contact, SurfacePoint, _)| {
        let corners = contact.nodes.into_iter().zip(contact.weights).filter(|(node, _)| moves(*node));
        corners.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(node, _)| mesh_node(node))
    };
    let each_once = |mut nodes: Vec<u32>| {
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    };
    LoadSites {
        nodes: each_once(nodal.iter().map(|track| mesh_node(track.contacts[0].0.nodes[0])).collect()),
        marched: each_once(scenario.track.contacts.iter().filter_map(heaviest).collect()),
        magnitude,
    }
}

/// A state of each march with its loads.
type Marches<'m> = Vec<(ChapterState<'m, f64>, ChapterLoads<'m, f64>)>;

/// Binds a file once and hands over a state and loads for each march.
pub fn with_marches<R>(
    name: &Path,
    file: &File<'_>,
    time_step: Option<f64>,
    count: usize,
    work: impl FnOnce(&ChapterScene<'_, f64>, &mut Marches<'_>) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let options = SceneOptions { time_step, ..SceneOptions::default() };
    let failed = |error| Failure::file(name, error);
    let sizes = ChapterScene::<f64>::sizes(file).map_err(failed)?;
    let mut memory = vec![(vec![0.0; sizes.state], vec![0.0; sizes.loads]); count];
    with_chapter::<f64, _>(name, file, &options, |scene, _, _| {
        let mut marches = vec![];
        for (state, loads) in &mut memory {
            let state = ChapterState::new(scene, state).map_err(failed)?;
            marches.push((state, ChapterLoads::new(scene, loads).map_err(failed)?));
        }
        work(scene, &mut marches)
    })
}

/// The sum of the marches of all tracks from rest.
pub fn play(bytes: &[u8], tracks: &[Track], march: &March<'_>) -> Result<Played, Failure> {
    let file = File::parse(bytes).map_err(|error| Failure::file(march.name, error))?;
    with_marches(march.name, &file, Some(march.time_step), tracks.len(), |scene, marches| {
        let instants = scene.instants();
        let factors = |track: &Track, step: usize| track.factors(&instants, march.time_step, step);
        let zero = vec![0.0; scene.n_modes()];
        let mut sum = Matrix::zeros(zero.len(), march.steps + 1);
        for (track, (state, loads)) in tracks.iter().zip(&mut *marches) {
            track.apply(&factors(track, 0), &mut Body { scene, state: &mut *state, loads: &mut *loads })?;
            let failed = |error| Failure::file(march.name, error);
            scene.set(state, &zero, &zero, loads).map_err(failed)?;
        }
        for step in 0..march.steps {
            for (track, (state, loads)) in tracks.iter().zip(&mut *marches) {
                track.apply(
                    &factors(track, step),
                    &mut Body { scene, state: &mut *state, loads: &mut *loads },
                )?;
                match scene.step(state, loads) {
                    Ok(_) => {}
                    Err(error @ ChapterStepError::OutsideAxis { .. }) => {
                        return Ok(Err(format!("left its ranges at step {}: {error}", step + 1)));
                    }
                    Err(error) => return Err(Failure::file(march.name, error)),
                }
                let column = sum.col_as_slice_mut(step + 1);
                column.iter_mut().zip(state.zeta()).for_each(|(sum, z)| *sum += z);
            }
            if cancelled() {
                return Err(Failure::new(Cause::Stopped, "stopped on request"));
            }
        }
        Ok(Ok(sum))
    })
}
