//! A file, a scene, one state and its loads in one value, for a host that can pass numbers only.

use vademecum_eval::format::{File, Section, SectionKind};
use vademecum_eval::{
    BindError, Body, BodyOptions, Contact, Field, Quantity, Scalar, SceneOptions, Status, StepError,
    Structure, Surface, SurfacePoint,
};

use crate::refusal::Refusal;
use crate::tool::{Ground, MOST_PLACES, Sphere, Tool};

/// A point of the surface whose displacement is recorded beside the probes.
#[derive(Clone, Copy, Debug)]
pub struct Watch {
    /// Where.
    pub point: SurfacePoint,
    /// Unit vector of the component.
    pub direction: [f64; 3],
}

/// Everything a page needs of one bound file. `T` is the precision of the march.
#[derive(Debug)]
pub struct Session<'m, T> {
    body: Body<'m, T>,
    field: &'m mut [T],
    watch: Option<Watch>,
    tool: Option<Tool>,
    ground: Option<Ground<'m>>,
}

/// Room for the loads without the tool's forces, and for the places that the tool touches.
fn body_options(options: &SceneOptions) -> BodyOptions {
    BodyOptions {
        scene: *options,
        places: MOST_PLACES,
        keep_loads: true,
        flight: false,
        ..BodyOptions::default()
    }
}

/// Numbers of `f64` for the body and of `T` for a field of the surface that [`Session::bind`] takes.
///
/// # Errors
/// [`Refusal::Bind`].
pub fn lengths<T: Scalar>(file: &File<'_>, options: &SceneOptions) -> Result<(usize, usize), Refusal> {
    let body = Body::<T>::len_for(file, &body_options(options))?;
    Ok((body, 3 * file.metadata().n_surface_nodes as usize))
}

impl<'m, T: Scalar> Session<'m, T> {
    /// Binds `file`; the body is at rest and unloaded.
    ///
    /// # Errors
    /// [`Refusal::Bind`].
    pub fn bind(
        file: &File<'m>,
        options: &SceneOptions,
        memory: &'m mut [f64],
        field: &'m mut [T],
    ) -> Result<Self, Refusal> {
        let (found, needed) = (field.len(), 3 * file.metadata().n_surface_nodes as usize);
        let field = field.get_mut(..needed).ok_or(BindError::LentMemory { found, needed })?;
        let body = Body::bind(file, &body_options(options), memory)?;
        Ok(Self { body, field, watch: None, tool: None, ground: Ground::new(file).ok() })
    }
}

/// What a page asks of a session, whatever its precision.
pub trait Player {
    /// 1 for the diagonal structure, 2 for the block structure, 3 for the chapter's, 4 for the exact one.
    fn structure(&self) -> u32;
    /// Takes all loads away.
    fn clear_loads(&mut self);
    /// Adds a held contact.
    ///
    /// # Errors
    /// [`Refusal::Load`].
    fn add_contact(&mut self, contact: &Contact) -> Result<(), Refusal>;
    /// Adds a held load pattern.
    ///
    /// # Errors
    /// [`Refusal::Load`].
    fn add_pattern(&mut self, index: usize, amplitude: f64) -> Result<(), Refusal>;
    /// What [`Player::march`] records beside the probes.
    fn watch(&mut self, watch: Option<Watch>);
    /// Numbers of one record of [`Player::march`]: the probes, the watched component (0 without), and the
    /// scalars of the whole body ([`Quantity::totals`]), the energy first.
    fn record_len(&self) -> usize;
    /// Takes `steps` steps; after each, writes a record while `records` has room.
    ///
    /// # Errors
    /// [`Refusal`]; the steps before it are taken.
    fn march(&mut self, steps: usize, records: &mut [f64]) -> Result<Status, Refusal>;
    /// Displacement (or velocity) of the surface, kept until the next call: where it lies in memory.
    ///
    /// # Errors
    /// [`Refusal::Output`].
    fn surface(&mut self, field: Field) -> Result<*const u8, Refusal>;
    /// Von Mises' equivalent stress \[Pa\] of the surface, in the first of three numbers a node and zero
    /// where the file has none, kept until the next call as [`Player::surface`] is.
    ///
    /// # Errors
    /// [`Refusal::Output`].
    fn equivalent_stress(&mut self) -> Result<*const u8, Refusal>;
    /// Displacement (or velocity) of a point of the surface.
    ///
    /// # Errors
    /// [`Refusal::Output`].
    fn point(&self, point: &SurfacePoint, field: Field) -> Result<[f64; 3], Refusal>;
    /// Energy \[J\].
    ///
    /// # Errors
    /// [`Refusal::Output`].
    fn energy(&self) -> Result<f64, Refusal>;
    /// `ζ`, then `ζ̇`, each of length r, in SI: what survives a change of `Δt`. Shorter lent memory takes the
    /// first of them.
    fn coordinates(&self, out: &mut [f64]);
    /// Sets `ζ` and `ζ̇`; the acceleration follows from them and the loads.
    ///
    /// # Errors
    /// [`Refusal::Step`].
    fn set_coordinates(&mut self, values: &[f64]) -> Result<(), Refusal>;
    /// The body at rest, loads kept.
    fn rest(&mut self);
    /// Lays a sphere down that presses the body from the next step on, or takes it away.
    ///
    /// # Errors
    /// [`Refusal::NoTool`], [`Refusal::BadTool`].
    fn hold(&mut self, sphere: Option<Sphere>) -> Result<(), Refusal>;
    /// The sphere that presses, and what it touched in the last step.
    fn tool(&mut self) -> Option<&mut Tool>;
}

impl<T: Scalar> Player for Session<'_, T> {
    fn structure(&self) -> u32 {
        match self.body.structure() {
            vademecum_eval::Structure::Diagonal => 1,
            vademecum_eval::Structure::Block => 2,
            vademecum_eval::Structure::Exact => 4,
            vademecum_eval::Structure::Strain => 5,
        }
    }

    fn clear_loads(&mut self) {
        self.body.clear();
    }

    fn add_contact(&mut self, contact: &Contact) -> Result<(), Refusal> {
        Ok(self.body.push(contact, contact.force)?)
    }

    fn add_pattern(&mut self, index: usize, amplitude: f64) -> Result<(), Refusal> {
        Ok(self.body.push_pattern(index, amplitude)?)
    }

    fn watch(&mut self, watch: Option<Watch>) {
        self.watch = watch;
    }

    fn record_len(&self) -> usize {
        self.body.scene().metadata().n_probes as usize + 1 + Quantity::totals().count()
    }

    fn march(&mut self, steps: usize, records: &mut [f64]) -> Result<Status, Refusal> {
        let mut rows = records.chunks_exact_mut(self.record_len());
        let mut status = Status::Moving;
        for _ in 0..steps {
            status = self.step()?;
            if let Some(row) = rows.next() {
                self.record(row)?;
            }
        }
        Ok(status)
    }

    fn surface(&mut self, field: Field) -> Result<*const u8, Refusal> {
        self.body.surface_into(field, self.field)?;
        Ok(self.field.as_ptr().cast())
    }

    fn equivalent_stress(&mut self) -> Result<*const u8, Refusal> {
        self.field.fill(T::ZERO);
        let nodes = self.field.as_chunks_mut::<3>().0;
        let (scene, state) = (self.body.scene(), self.body.state());
        for index in 0..scene.n_stress_points() {
            let stress = T::from_f64(scene.stress(state, index)?.von_mises());
            let node = scene.stress_point(index).map(|point| point.node as usize);
            // Between two regions the larger one.
            if let Some([most, ..]) = node.and_then(|node| nodes.get_mut(node))
                && stress > *most
            {
                *most = stress;
            }
        }
        Ok(self.field.as_ptr().cast())
    }

    fn point(&self, point: &SurfacePoint, field: Field) -> Result<[f64; 3], Refusal> {
        Ok(self.body.point(point, field)?)
    }

    fn energy(&self) -> Result<f64, Refusal> {
        Ok(self.body.energy()?)
    }

    fn coordinates(&self, out: &mut [f64]) {
        let (rate, state) = (1.0 / self.body.time_step(), self.body.state());
        let zeta = state.zeta().iter().map(|x| x.to_f64());
        let rates = state.scaled_velocity().iter().map(|x| x.to_f64() * rate);
        out.iter_mut().zip(zeta.chain(rates)).for_each(|(out, x)| *out = x);
    }

    fn set_coordinates(&mut self, values: &[f64]) -> Result<(), Refusal> {
        let (zeta, rates) =
            values.split_at_checked(self.body.scene().n_modes()).ok_or(StepError::Mismatch)?;
        Ok(self.body.set(zeta, rates)?)
    }

    fn rest(&mut self) {
        self.body.rest();
    }

    fn hold(&mut self, sphere: Option<Sphere>) -> Result<(), Refusal> {
        self.tool = None;
        let Some(sphere) = sphere else { return Ok(()) };
        if self.body.structure() != Structure::Exact || self.ground.is_none() {
            return Err(Refusal::NoTool);
        }
        let Sphere { radius, friction, speed, most, .. } = sphere;
        let places = sphere.centre.iter().chain(&sphere.target);
        let sound = radius > 0.0 && friction >= 0.0 && speed >= 0.0 && most > 0.0;
        if !sound || ![radius, friction, speed].iter().chain(places).all(|x| x.is_finite()) {
            return Err(Refusal::BadTool);
        }
        self.tool = Some(Tool::new(sphere));
        Ok(())
    }

    fn tool(&mut self) -> Option<&mut Tool> {
        self.tool.as_mut()
    }
}

impl<T: Scalar> Session<'_, T> {
    /// One step, with the tool where there is one.
    fn step(&mut self) -> Result<Status, Refusal> {
        let Self { body, tool, ground, .. } = self;
        match (tool, ground) {
            (Some(tool), Some(ground)) => tool.step(ground, body),
            _ => Ok(body.step()?),
        }
    }

    fn record(&self, row: &mut [f64]) -> Result<(), Refusal> {
        let n_probes = self.body.scene().metadata().n_probes as usize;
        let Some((probes, [watched, totals @ ..])) = row.split_at_mut_checked(n_probes) else {
            return Ok(());
        };
        for (index, out) in probes.iter_mut().enumerate() {
            *out = self.body.probe(index, Field::Displacement)?;
        }
        *watched = match &self.watch {
            None => 0.0,
            Some(watch) => {
                let u = self.body.point(&watch.point, Field::Displacement)?;
                u.iter().zip(watch.direction).map(|(u, d)| u * d).sum()
            }
        };
        for (quantity, out) in Quantity::totals().zip(totals) {
            *out = self.body.total(quantity)?;
        }
        Ok(())
    }
}

/// The section `kind` of `file`, stored as it is (a page reads its bytes directly).
#[must_use]
pub fn plain_section<'m>(file: &File<'m>, kind: u32) -> Option<Section<'m>> {
    let section = file.section(SectionKind::from_number(kind)?)?;
    section.raw().is_ok().then_some(section)
}

/// The loadable point nearest to `point`, if any.
///
/// # Errors
/// [`Refusal::Output`].
pub fn locate(file: &File<'_>, point: [f64; 3]) -> Result<Option<SurfacePoint>, Refusal> {
    Ok(Surface::new(file)?.locate(point))
}
