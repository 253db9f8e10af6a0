//! A scenario through a file, and what its output plan asks to be shown of it.

use vademecum_build::progress::{Cancelled, Listener};
use vademecum_eval::Field;
use vademecum_format::{File, SectionKind};

use crate::contents::{Geometry, lines};
use crate::error::{FileError, StudyError};
use crate::player::{PlayOptions, Playable, Track, play};
use crate::scenario::{FieldChoice, OutputPlan, Scenario};

/// A contact this far from the point given, relative to the point's largest coordinate, is worth a note.
const FAR: f64 = 1e-6;

/// A scenario bound to a file, ready to be played.
pub struct Run<'a> {
    file: &'a File<'a>,
    options: PlayOptions,
    plan: &'a OutputPlan,
    track: Track,
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
    pub probes: Option<Probed<'a>>,
    /// The fields.
    pub fields: Option<Fields<'a>>,
}

/// What the table of probes says of an instant.
#[derive(Clone, Copy)]
pub struct Probed<'a> {
    /// Energy \[J\].
    pub energy: f64,
    /// Displacement of each probe \[m\].
    pub values: &'a [f64],
}

/// Fields at an instant, shape (nodes, 3), over the nodes of [`Run::geometry`].
#[derive(Clone, Copy)]
pub struct Fields<'a> {
    /// Displacement \[m\].
    pub displacement: &'a [f64],
    /// Velocity \[m/s\].
    pub velocity: &'a [f64],
}

impl<'a> Run<'a> {
    /// Binds a scenario to a file. The listener is told of contacts that cannot act where they should.
    ///
    /// # Errors
    /// As [`Track::bind`].
    pub fn bind(
        file: &'a File<'a>,
        options: PlayOptions,
        scenario: &'a Scenario,
        listener: &dyn Listener,
    ) -> Result<Self, StudyError> {
        let track = Track::bind(file, scenario)?;
        for (i, placed) in track.contacts.iter().enumerate() {
            let size = placed.point.position.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
            if placed.point.distance > FAR * size {
                let distance = placed.point.distance;
                listener.note(&format!("contact[{i}] acts {distance:.3e} away from the point given"));
            }
        }
        let time_step = options.scene.time_step.unwrap_or(file.metadata().time_step);
        let steps = scenario.steps(time_step);
        Ok(Self { file, options, plan: &scenario.output, track, time_step, steps })
    }

    /// Names of the probes.
    ///
    /// # Errors
    /// As [`lines`].
    pub fn probes(&self) -> Result<Vec<String>, FileError> {
        lines(self.file, SectionKind::ProbeNames)
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
    /// As [`play`], and those of `show`, which end the run.
    pub fn play<E: From<StudyError>>(
        &self,
        listener: &dyn Listener,
        mut show: impl FnMut(&Moment<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut instant = Shown::new(self);
        let mut refused = None;
        listener.stage("step");
        let played = play(self.file, &self.options, &self.track, self.steps, listener, |step, body| {
            let moment = instant.at(self, step, body)?;
            listener.advance(step, self.steps);
            show(&moment).map_err(|error| {
                refused = Some(error);
                Cancelled.into()
            })
        });
        match refused {
            Some(error) => Err(error),
            None => Ok(played?),
        }
    }
}

/// Memory for what is shown of an instant.
struct Shown {
    probes: Vec<f64>,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
}

impl Shown {
    fn new(run: &Run<'_>) -> Self {
        let n_fields = if run.plan.fields_every > 0 { 3 * run.n_field_nodes() } else { 0 };
        let n_probes = run.file.metadata().n_probes as usize;
        Self { probes: vec![0.0; n_probes], displacement: vec![0.0; n_fields], velocity: vec![0.0; n_fields] }
    }

    fn at(
        &mut self,
        run: &Run<'_>,
        step: usize,
        body: &dyn Playable<Number = f64>,
    ) -> Result<Moment<'_>, FileError> {
        let OutputPlan { probes_every, fields_every, fields } = *run.plan;
        let mut energy = None;
        if step.is_multiple_of(probes_every) {
            energy = Some(body.energy()?);
            for (probe, value) in self.probes.iter_mut().enumerate() {
                *value = body.probe(probe)?;
            }
        }
        let with_fields = fields_every > 0 && step.is_multiple_of(fields_every);
        if with_fields {
            let fill = |field, out: &mut [f64]| match fields {
                FieldChoice::Surface => body.surface_into(field, out),
                FieldChoice::Body => body.body_into(field, out),
            };
            fill(Field::Displacement, &mut self.displacement)?;
            fill(Field::Velocity, &mut self.velocity)?;
        }
        let Self { probes, displacement, velocity } = self;
        Ok(Moment {
            time: step as f64 * run.time_step,
            probes: energy.map(|energy| Probed { energy, values: probes }),
            fields: with_fields.then_some(Fields { displacement, velocity }),
        })
    }
}
