//! A scenario through a file, and what its output plan asks to be shown of it.

use vademecum_build::input::OWN_COLUMNS;
use vademecum_build::progress::{Cancelled, Listener};
use vademecum_eval::{Field, Tensor};
use vademecum_format::{File, SectionKind};
use vademecum_rewrite::RewriteError;

use crate::contents::{Geometry, is_si, lines};
use crate::error::{FileError, LARGE_MOTION, StudyError};
use crate::notes::notes;
use crate::pace::Pace;
use crate::player::{PlayOptions, Playable, Track, play, play_free};
use crate::probes::{self, PlacedProbe, ProbeReader};
use crate::scenario::{FieldChoice, FreeEntry, OutputPlan, OutputProbe, STEPS_OF_A_RUN, Scenario, Total};
use crate::stress::{LargestStress, StressPlace, Stresses};
use crate::under_contacts::UnderContacts;

/// A scenario bound to a file, ready to be played.
pub struct Run<'a> {
    file: &'a File<'a>,
    options: PlayOptions,
    plan: &'a OutputPlan,
    free: Option<FreeEntry>,
    track: Track,
    probes: Vec<PlacedProbe>,
    names: Vec<String>,
    /// Units of the file's own probes, see [`SectionKind::ProbeUnits`].
    probe_units: Vec<String>,
    contacts: Option<UnderContacts>,
    /// Start and end of each load \[s\].
    acting: Vec<[f64; 2]>,
    stresses: Stresses,
    supports: Vec<String>,
    /// Step \[s\].
    pub time_step: f64,
    /// Number of steps.
    pub steps: usize,
}

/// One instant of a run. What the output plan does not ask for at it is absent.
pub struct Moment<'a> {
    /// Time \[s\].
    pub time: f64,
    /// The probes.
    pub probes: Option<ProbeRow<'a>>,
    /// The stress of each of [`Run::stress_places`].
    pub stress: Option<&'a [Tensor]>,
    /// The fields.
    pub fields: Option<Fields<'a>>,
}

/// Row of the table of probes.
#[derive(Clone, Copy)]
pub struct ProbeRow<'a> {
    /// Energy \[J\].
    pub energy: f64,
    /// Displacement of each probe \[m\] (of a scenario's probe its own quantity), strain of each gauge, then
    /// each stress \[Pa\].
    pub values: &'a [f64],
    /// The numbers of [`Run::flight_columns`] of a free body that was thrown; none of any other.
    pub flight: &'a [f64],
    /// The largest equivalent stress, where the file has one.
    pub largest_stress: Option<LargestStress>,
    /// Force and moment that each support exerts on the body \[N, N m\].
    pub reactions: &'a [[f64; 6]],
    /// The values of [`Run::quantities`].
    pub quantities: &'a [f64],
    /// Displacement under each contact \[m\]; none unless the scenario asks for it.
    pub contacts: &'a [[f64; 3]],
}

/// Fields at an instant, shape (nodes, 3), over the nodes of [`Run::geometry`]. Those of a free body that was
/// thrown are its motion in space, the rigid one included.
#[derive(Clone, Copy)]
pub struct Fields<'a> {
    /// Displacement \[m\].
    pub displacement: &'a [f64],
    /// Velocity \[m/s\].
    pub velocity: &'a [f64],
    /// Stress \[Pa\], shape (nodes, 6), and von Mises' equivalent stress, (nodes); NaN where the file does
    /// not know it, and empty where it knows none.
    pub stress: [&'a [f64]; 2],
}

impl<'a> Run<'a> {
    /// Binds a scenario to a file. The listener hears of loads that act elsewhere than they should, or on
    /// nothing.
    ///
    /// # Errors
    /// As [`Track::bind`] and [`Scenario::steps_within`]; [`StudyError::ProbeTwice`],
    /// [`StudyError::ColumnTwice`];
    /// [`RewriteError::Names`]: not as many names as probes.
    pub fn bind(
        file: &'a File<'a>,
        options: PlayOptions,
        scenario: &'a Scenario,
        listener: &dyn Listener,
    ) -> Result<Self, StudyError> {
        let time_step = options.scene.time_step.unwrap_or(file.metadata().time_step);
        let steps = scenario.steps_within(time_step, STEPS_OF_A_RUN, options.long)?;
        let track = Track::bind(file, scenario)?;
        notes(file, scenario, &track, time_step, steps)?.iter().for_each(|note| listener.note(note));
        let plan = &scenario.output;
        if !plan.quantities.is_empty() && options.takes_chapter(file) {
            return Err(FileError::NoQuantities.into());
        }
        let mut names = built_probes(file)?;
        let (probes, looks) = probes::place(file, &plan.probes, &names)?;
        names.extend(plan.probes.iter().map(|probe| probe.name.clone()));
        let (stresses, stress_looks) = Stresses::place(file, &plan.stresses, &mut names)?;
        if plan.stress_every > 0 && stresses.places.is_empty() {
            return Err(StudyError::NoStress);
        }
        looks.iter().chain(&stress_looks).for_each(|note| listener.note(note));
        let supports = lines(file, SectionKind::SupportNames)?;
        let contacts = plan.contacts.then(|| UnderContacts::of(&track));
        if names.is_empty() && supports.is_empty() && contacts.is_none() {
            listener.note(
                "neither the file nor the scenario has a probe, so the table has time and energy only; add \
                 `[[output.probe]]` to the scenario",
            );
        }
        if plan.fields_every > steps {
            listener.note(&format!(
                "`output.fields_every` is {}, and the run has {steps} steps: the only field is the one at its start",
                plan.fields_every
            ));
        }
        let free = file.section(SectionKind::RigidBody).is_some();
        if scenario.free.is_some() && !free {
            return Err(FileError::NotFree.into());
        }
        if free && scenario.free.is_none() {
            listener.note(
                "the file holds a free body, and the scenario has no `[free]`: its elastic motion alone is played, \
                 under forces that turn with the body",
            );
        }
        let run = Self {
            file,
            options,
            plan,
            free: scenario.free,
            track,
            probes,
            names,
            probe_units: lines(file, SectionKind::ProbeUnits)?,
            contacts,
            acting: scenario.acting(),
            stresses,
            supports,
            time_step,
            steps,
        };
        let names = run.columns().into_iter().map(|(name, _)| name);
        match twice(OWN_COLUMNS.map(String::from).into_iter().chain(names).collect()) {
            Some(name) => Err(StudyError::ColumnTwice { name }),
            None => Ok(run),
        }
    }

    /// Names of the outputs of a free body that was thrown, behind its probes: none of any other.
    pub fn flight_columns(&self) -> Vec<String> {
        if self.free.is_none() {
            return vec![];
        }
        let own = ["rigid energy_J", "centre x", "centre y", "centre z", "q_w", "q_x", "q_y", "q_z"];
        let of_probe =
            |probe: &OutputProbe| ["x", "y", "z"].map(|axis| format!("{} in space {axis}", probe.name));
        own.map(String::from).into_iter().chain(self.plan.probes.iter().flat_map(of_probe)).collect()
    }

    /// The numbers of these columns.
    fn flight_into(&self, body: &dyn Playable<Number = f64>, out: &mut Vec<f64>) -> Result<(), FileError> {
        out.clear();
        let Some(free) = body.flight() else { return Ok(()) };
        let (rigid, motion) = (free.body(), free.motion());
        out.push(motion.energy(rigid));
        out.extend(motion.position.into_iter().chain(motion.attitude));
        for probe in &self.probes {
            out.extend(motion.place(rigid, probe.position, probe.displacement(body)?));
        }
        Ok(())
    }

    /// Name and unit of each column of [`ProbeRow`] behind time and energy, in order: probes, reactions,
    /// flight, quantities, contacts. The unit is `1` of what has none, and empty where it is not known or
    /// stands in the name.
    pub fn columns(&self) -> Vec<(String, &'static str)> {
        let si = is_si(self.file);
        let known = |unit: &'static str| if si || unit == "1" { unit } else { "" };
        let (added, stresses) = (self.probes.len(), self.stresses.n_columns());
        let built = self.names.len() - added - stresses;
        let unit = |probe: usize| match probe.checked_sub(built) {
            None if self.probe_units.get(probe).is_some_and(|unit| unit == "1") => "1",
            None => "m",
            Some(place) if place < added => self.probes[place].unit(),
            Some(_) => "Pa",
        };
        let probes = self.names.iter().enumerate().map(|(i, name)| (name.clone(), known(unit(i))));
        let parts = [("fx", "N"), ("fy", "N"), ("fz", "N"), ("mx", "N m"), ("my", "N m"), ("mz", "N m")];
        let reaction =
            |support: &String| parts.map(|(part, unit)| (format!("reaction.{support}.{part}"), known(unit)));
        let place = |name: &str| if name.starts_with("q_") { "1" } else { "m" };
        let flight = self.flight_columns().into_iter().map(|name| {
            let unit = if name.ends_with("_J") { "" } else { place(&name) };
            (name, known(unit))
        });
        let totals = self.plan.quantities.iter().map(|&Total(quantity)| {
            let unit = quantity.unit(Field::Displacement).unwrap_or_default();
            (format!("{}_{unit}", quantity.name()), "")
        });
        let under = |contact| ["x", "y", "z"].map(|axis| (format!("contact.{contact}.{axis}"), known("m")));
        let contacts = 0..self.contacts.as_ref().map_or(0, UnderContacts::len);
        let reactions = self.supports.iter().flat_map(reaction);
        probes.chain(reactions).chain(flight).chain(totals).chain(contacts.flat_map(under)).collect()
    }

    /// Start and end of each load \[s\].
    pub fn acting(&self) -> &[[f64; 2]] {
        &self.acting
    }

    /// Names of the probes: those of the file, then those of the scenario, then its stresses.
    pub fn probes(&self) -> &[String] {
        &self.names
    }

    /// Points with stress.
    pub fn stress_places(&self) -> &[StressPlace] {
        &self.stresses.places
    }

    /// Names of the supports whose reactions the file gives.
    pub fn supports(&self) -> &[String] {
        &self.supports
    }

    /// Scalars of the whole body that the scenario asks for.
    pub fn quantities(&self) -> &[Total] {
        &self.plan.quantities
    }

    /// Nodes and triangles that the fields are shown on; none if the plan asks for no fields.
    ///
    /// # Errors
    /// As [`Geometry::of`].
    pub fn geometry(&self) -> Result<Option<Geometry>, FileError> {
        if self.plan.fields_every == 0 {
            return Ok(None);
        }
        let mut geometry = Geometry::of(self.file)?;
        geometry.nodes.truncate(self.n_field_nodes());
        Ok(Some(geometry))
    }

    /// Bytes that the results take at least, as tables and VTU files; `geometry` is that of the fields.
    pub fn least_bytes(&self, geometry: Option<&Geometry>) -> u64 {
        // `1.234567890e0,` and 8 bytes a number of a field.
        const CELL: usize = 14;
        let instants = |every: usize| self.steps.checked_div(every).map_or(0.0, |count| 1.0 + count as f64);
        let row = (CELL * self.columns().len()) as f64;
        let stress_rows = (8 * CELL * self.stresses.places.len()) as f64;
        let field = geometry.map_or(0, |geometry| {
            let stress = if self.stresses.places.is_empty() { 0 } else { 7 };
            8 * (9 + stress) * geometry.nodes.len() + 33 * geometry.triangles.len()
        });
        let plan = self.plan;
        let tables = row * instants(plan.probes_every) + stress_rows * instants(plan.stress_every);
        (tables + field as f64 * instants(plan.fields_every)) as u64
    }

    fn n_field_nodes(&self) -> usize {
        let metadata = self.file.metadata();
        match self.plan.fields {
            FieldChoice::Surface => metadata.n_surface_nodes as usize,
            FieldChoice::Body => metadata.n_nodes as usize,
        }
    }

    /// Plays the scenario and shows the instants that the plan asks for.
    ///
    /// # Errors
    /// As [`play`], and those of `show`, which end the run; [`StudyError::NotFinite`] before the first
    /// instant with a number that is not finite is shown.
    pub fn play<E: From<StudyError>>(
        &self,
        listener: &dyn Listener,
        mut show: impl FnMut(&Moment<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut instant = InstantBuffers::new(self);
        let mut refused = None;
        listener.stage("step");
        let paced = Pace::new(self.time_step, listener);
        let mut outside: Option<Outside> = None;
        let observe = |step: usize, body: &mut dyn Playable<Number = f64>| -> Result<(), StudyError> {
            if let Some(training) = body.training().filter(|training| !training.is_inside()) {
                let known =
                    outside.get_or_insert(Outside { since: step as f64 * self.time_step, times: 0.0 });
                known.times = known.times.max(training.distance / training.largest_distance);
            }
            let moment = instant.at(self, step, body)?;
            paced.advance(step, self.steps);
            show(&moment).map_err(|error| {
                refused = Some(error);
                Cancelled.into()
            })
        };
        let played = match &self.free {
            Some(free) => {
                play_free(self.file, &self.options, (&self.track, free), self.steps, listener, observe)
            }
            None => play(self.file, &self.options, &self.track, self.steps, listener, observe),
        };
        if let Some(outside) = outside {
            listener.note(&outside.to_string());
        }
        match refused {
            Some(error) => Err(error),
            None => Ok(played?),
        }
    }
}

/// Motion at large displacements beyond that of the training.
struct Outside {
    /// First time \[s\].
    since: f64,
    /// Largest distance from rest, in that of the training.
    times: f64,
}

impl std::fmt::Display for Outside {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { since, times } = self;
        write!(f, "from {since:.3e} s on the body moves beyond what the file was trained with")?;
        if *times > 1.0 {
            write!(f, ", up to {times:.2} times as far from rest")?;
        }
        f.write_str(
            ": no error of the file speaks of that; a larger `large.displacement` in the problem, or smaller loads"
        )
    }
}

/// A name that occurs twice.
fn twice(mut names: Vec<String>) -> Option<String> {
    names.sort_unstable();
    names.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0].clone())
}

/// Names of the file's own probes.
fn built_probes(file: &File<'_>) -> Result<Vec<String>, FileError> {
    let names = lines(file, SectionKind::ProbeNames)?;
    let count = file.metadata().n_probes as usize;
    if names.len() != count {
        let reason = format!("it has {} names, the metadata count {count}", names.len());
        return Err(RewriteError::Names { kind: SectionKind::ProbeNames, reason }.into());
    }
    Ok(names)
}

/// Memory for what is shown of an instant.
struct InstantBuffers<'a> {
    added: ProbeReader<'a>,
    probes: Vec<f64>,
    contacts: Vec<[f64; 3]>,
    stresses: Vec<Tensor>,
    stress: Vec<f64>,
    von_mises: Vec<f64>,
    reactions: Vec<[f64; 6]>,
    quantities: Vec<f64>,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    flight: Vec<f64>,
    /// Coordinates of the nodes of the fields of a body in flight.
    nodes: Vec<[f64; 3]>,
}

impl<'a> InstantBuffers<'a> {
    fn new(run: &'a Run<'_>) -> Self {
        let n_fields = if run.plan.fields_every > 0 { 3 * run.n_field_nodes() } else { 0 };
        let n_stress = if run.stresses.places.is_empty() { 0 } else { n_fields / 3 };
        Self {
            added: ProbeReader::new(&run.probes, run.file.metadata().n_surface_nodes as usize, run.time_step),
            probes: vec![0.0; run.names.len()],
            contacts: vec![[0.0; 3]; run.contacts.as_ref().map_or(0, UnderContacts::len)],
            stresses: vec![Tensor::default(); run.stresses.places.len()],
            stress: vec![0.0; 6 * n_stress],
            von_mises: vec![0.0; n_stress],
            reactions: vec![[0.0; 6]; run.supports.len()],
            quantities: vec![0.0; run.plan.quantities.len()],
            displacement: vec![0.0; n_fields],
            velocity: vec![0.0; n_fields],
            flight: vec![],
            nodes: vec![],
        }
    }

    fn at(
        &mut self,
        run: &Run<'_>,
        step: usize,
        body: &mut dyn Playable<Number = f64>,
    ) -> Result<Moment<'_>, StudyError> {
        let &OutputPlan { probes_every, fields_every, stress_every, fields, .. } = run.plan;
        let asked = |every: usize| every > 0 && step.is_multiple_of(every);
        let (with_fields, with_stress) = (asked(fields_every), asked(stress_every));
        let time = step as f64 * run.time_step;
        if asked(probes_every) || with_fields || with_stress {
            for (point, value) in self.stresses.iter_mut().enumerate() {
                *value = body.stress(point)?;
            }
        }
        self.added.follow(body)?;
        let mut energy = None;
        if asked(probes_every) {
            energy = Some(body.energy()?);
            let (added, stresses) = (run.probes.len(), run.stresses.n_columns());
            let built = self.probes.len() - added - stresses;
            for (probe, value) in self.probes.iter_mut().enumerate() {
                *value = match probe.checked_sub(built) {
                    None => body.probe(probe)?,
                    Some(place) if place < added => continue,
                    Some(place) => run.stresses.column(place - added, &self.stresses),
                };
            }
            self.added.read(body, &mut self.probes[built..built + added])?;
            if let Some(contacts) = &run.contacts {
                contacts.read(body, time, &mut self.contacts)?;
                for &part in self.contacts.as_flattened() {
                    check(step, run.time_step, body.zeta(), part, || {
                        "the displacement under a contact".into()
                    })?;
                }
            }
            for (support, reaction) in self.reactions.iter_mut().enumerate() {
                *reaction = body.reaction(support)?;
                let what = || format!("the reaction of support `{}`", run.supports[support]);
                for &part in &*reaction {
                    check(step, run.time_step, body.zeta(), part, what)?;
                }
            }
        }
        if let Some(energy) = energy {
            for (&Total(quantity), value) in run.plan.quantities.iter().zip(&mut self.quantities) {
                *value = body.total(quantity)?;
                check(step, run.time_step, body.zeta(), *value, || format!("the {}", quantity.name()))?;
            }
            finite(step, run.time_step, body.zeta(), energy, &self.probes, &run.names)?;
            run.flight_into(body, &mut self.flight)?;
        }
        if with_fields {
            if !self.von_mises.is_empty() {
                run.stresses.fields(&self.stresses, &mut self.stress, &mut self.von_mises);
            }
            let mut fill = |field, out: &mut [f64]| match fields {
                FieldChoice::Surface => body.surface_into(field, out),
                FieldChoice::Body => body.body_into(field, out),
            };
            fill(Field::Displacement, &mut self.displacement)?;
            fill(Field::Velocity, &mut self.velocity)?;
            for (what, field) in [("displacement", &self.displacement), ("velocity", &self.velocity)] {
                for (place, &value) in field.iter().enumerate() {
                    let what = || format!("the {what} of node {} of the file", place / 3);
                    check(step, run.time_step, body.zeta(), value, what)?;
                }
            }
        }
        if let Some(free) = body.flight().filter(|_| with_fields) {
            let (rigid, motion) = (free.body(), free.motion());
            if self.nodes.is_empty() {
                self.nodes = run.geometry()?.map_or(vec![], |geometry| geometry.nodes);
            }
            let fields = self.displacement.as_chunks_mut().0.iter_mut().zip(self.velocity.as_chunks_mut().0);
            for ((u, v), node) in fields.zip(&self.nodes) {
                *v = motion.velocity(rigid, *node, *u, *v);
                let place: [f64; 3] = motion.place(rigid, *node, *u);
                *u = std::array::from_fn(|c| place[c] - node[c]);
            }
        }
        let Self { probes, displacement, velocity, stresses, stress, von_mises, flight, reactions, .. } =
            &*self;
        let largest_stress = run.stresses.largest(stresses, time);
        Ok(Moment {
            time,
            probes: energy.map(|energy| ProbeRow {
                energy,
                values: probes,
                flight,
                largest_stress,
                reactions,
                quantities: &self.quantities,
                contacts: &self.contacts,
            }),
            stress: with_stress.then_some(stresses),
            fields: with_fields.then_some(Fields { displacement, velocity, stress: [stress, von_mises] }),
        })
    }
}

/// Reduced coordinates beyond this may have outputs that leave the range of a double.
const TOO_LARGE: f64 = 1e70;

/// An error if the energy or a probe at a step is not a finite number.
pub(crate) fn finite(
    step: usize,
    time_step: f64,
    zeta: &[f64],
    energy: f64,
    probes: &[f64],
    names: &[String],
) -> Result<(), StudyError> {
    for (probe, &value) in probes.iter().enumerate() {
        let name = names.get(probe).map_or("", String::as_str);
        check(step, time_step, zeta, value, || format!("the value of probe `{name}`"))?;
    }
    check(step, time_step, zeta, energy, || "the energy".into())
}

fn check(
    step: usize,
    time_step: f64,
    zeta: &[f64],
    value: f64,
    what: impl FnOnce() -> String,
) -> Result<(), StudyError> {
    if value.is_finite() {
        return Ok(());
    }
    let moderate = zeta.iter().all(|x| x.abs() < TOO_LARGE);
    let cause = if moderate {
        "the motion itself is moderate, so a number of the file is not finite or far too large: \
         `verify FILE --file-only` checks them"
    } else {
        LARGE_MOTION
    };
    let time = step as f64 * time_step;
    Err(StudyError::NotFinite { time, step, what: what(), value, cause })
}
