//! Binding a file to parameters and memory.
//!
//! Binding fuses the stages (see `vademecum_format::scheme`), so a step is one small matrix-vector product.
//! The diagonal structure keeps a 3×3 block per mode and takes any `Δt`, stiffness, density and damping
//! exactly; the block structure keeps the dense `3r × 3r` map and takes what its axes allow. Both can be set
//! to other parameters where they are ([`Scene::set_parameters`]).

use crate::base::error::BindError;
use crate::base::lend::{Lender, Short};
use crate::base::options::{SceneOptions, Sizes, Structure};
use crate::base::scalar::Scalar;
use crate::kernels::strain::map::{checked_step, lay_out_force, lay_out_strain};
use crate::kernels::strain::numbers::{StrainSections, StrainStep};
use crate::scene::bind::{Asked, Sections, fuse, lay_out, sections};
use crate::scene::shape::{Shape, shape};
use crate::sections::filter::filter_of;
use vademecum_format::exact::ForceFilter;
use vademecum_format::scheme::{MAX_STAGES, SchemeTable, StepParameters};
use vademecum_format::{File, Metadata, SectionKind};

/// An opened file bound to parameters, ready to step. States and loads are apart.
#[derive(Debug)]
pub struct Scene<'m, T> {
    pub(crate) shape: Shape,
    pub(crate) metadata: Metadata<'m>,
    pub(crate) options: SceneOptions,
    pub(crate) parameters: StepParameters,
    pub(crate) sections: Sections<'m>,
    /// Counts how often the parameters changed; loads remember theirs.
    pub(crate) generation: u64,
    pub(crate) rest_below: T,
    /// The filter of the residual flexibility.
    pub(crate) filter: ForceFilter,
    /// The step of the strain structure.
    pub(crate) strain: StrainStep,
    pub(crate) map: &'m mut [T],
    pub(crate) load_maps: &'m mut [T],
    pub(crate) weights: &'m mut [T],
}

impl<'m, T: Scalar> Scene<'m, T> {
    /// The memory a scene of these options asks for.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let bytes = BODY;
    /// let file = File::parse(bytes)?;
    /// let options = SceneOptions::default();
    /// let [single, double] = [Scene::<f32>::sizes(&file, &options)?, Scene::<f64>::sizes(&file, &options)?];
    /// assert_eq!(single, double); // in numbers, not in bytes
    /// assert!(single.state >= 6 * file.metadata().n_modes as usize); // old and new side by side
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`BindError::NoStructure`], [`BindError::NotDiagonal`] and [`BindError::BadOption`].
    pub fn sizes(file: &File<'_>, options: &SceneOptions) -> Result<Sizes, BindError> {
        Ok(shape::<T>(file, options)?.sizes())
    }

    /// Binds a file. `memory` and `work` hold at least what [`Scene::sizes`] says; what is in them does not
    /// matter.
    ///
    /// Cost: `O(r)` for the diagonal structure, `O(r³)` if dashpots couple the modes,
    /// `O(r³ + n_terms (r² + points of all axes))` for the block structure. The basis is not touched.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let bytes = BODY;
    /// let file = File::parse(bytes)?;
    /// let options = SceneOptions { time_step: Some(0.5e-3), ..SceneOptions::default() };
    /// let sizes = Scene::<f32>::sizes(&file, &options)?;
    /// let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    /// let scene = Scene::bind(&file, &options, &mut memory, &mut work)?;
    /// assert_eq!((scene.structure(), scene.n_modes()), (Structure::Diagonal, 3));
    /// assert_eq!(scene.parameters().time_step, 0.5e-3);
    ///
    /// let short = Scene::<f32>::bind(&file, &options, &mut [], &mut work);
    /// assert_eq!(short.err(), Some(BindError::LentMemory { found: 0, needed: sizes.scene }));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`BindError`].
    pub fn bind(
        file: &File<'m>,
        options: &SceneOptions,
        memory: &'m mut [T],
        work: &mut [f64],
    ) -> Result<Self, BindError> {
        let shape = shape::<T>(file, options)?;
        let mut sections = sections(file, shape.structure())?;
        if shape.is_strain() {
            let moving = [SectionKind::RigidBody, SectionKind::BaseFrame];
            if let Some(kind) = moving.into_iter().find(|&kind| file.section(kind).is_some()) {
                return Err(BindError::NotWithStrain { kind });
            }
        }
        if !options.residual || !shape.is_modal() {
            // Forces are remembered for reactions, too.
            (sections.residual, sections.factor) = Default::default();
        }
        Self::of_sections(*file.metadata(), sections, shape, options, memory, work)
    }

    /// The same file at the same parameters with another `Δt` \[s\], beside this scene: for a step that is
    /// cut where a load jumps, and for a loop whose steps differ. Memory and work as for [`Scene::bind`]; a
    /// state goes from one to the other by [`State::carry`](crate::State::carry).
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Exact: file, sizes, scene, state, loads, work);
    /// let mut memory = vec![0.0; sizes.scene];
    /// let half = scene.with_time_step(0.5 * scene.parameters().time_step, &mut memory, &mut work)?;
    /// scene.set(&mut state, &[1.0, 0.0, 0.0], &[0.0; 3], &loads)?;
    /// scene.step(&mut state, &loads)?;
    /// let whole = state.zeta()[0];
    ///
    /// scene.set(&mut state, &[1.0, 0.0, 0.0], &[0.0; 3], &loads)?;
    /// state.carry(&half)?;
    /// half.step(&mut state, &loads)?;
    /// half.step(&mut state, &loads)?;
    /// let apart: f64 = state.zeta()[0] - whole;
    /// assert!(apart.abs() < 1e-14); // exact steps do not depend on their length
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`BindError`].
    pub fn with_time_step<'n>(
        &self,
        time_step: f64,
        memory: &'n mut [T],
        work: &mut [f64],
    ) -> Result<Scene<'n, T>, BindError>
    where
        'm: 'n,
    {
        let options = SceneOptions { time_step: Some(time_step), ..self.options };
        Scene::of_sections(self.metadata, self.sections, self.shape, &options, memory, work)
    }

    fn of_sections(
        metadata: Metadata<'m>,
        sections: Sections<'m>,
        shape: Shape,
        options: &SceneOptions,
        memory: &'m mut [T],
        work: &mut [f64],
    ) -> Result<Self, BindError> {
        let sizes = shape.sizes();
        let asked = Asked::new(&metadata, options);
        let short = |found, needed| BindError::LentMemory { found, needed };
        let (lent, lent_work) = (memory.len(), work.len());
        let memory = memory.get_mut(..sizes.scene).ok_or(short(lent, sizes.scene))?;
        let work = work.get_mut(..sizes.work).ok_or(short(lent_work, sizes.work))?;
        let fused = fuse::<T>(&metadata, &sections, &asked, shape, work)?;
        let strain = strain_step::<T>(&sections.strain, shape, &asked.step, options)?;
        memory.fill(T::ZERO);
        let mut memory = Lender::new(memory);
        let (map, load_maps) = (memory.take(shape.map_len())?, memory.take(shape.load_maps_len())?);
        let weights = memory.take(shape.weights_len())?;
        lay_out(&fused, shape, map, load_maps, weights)?;
        let mut scene = Self {
            strain,
            shape,
            metadata,
            options: *options,
            parameters: asked.step,
            filter: filter_of(&asked.step),
            sections,
            generation: 0,
            rest_below: options.rest_threshold(),
            map,
            load_maps,
            weights,
        };
        scene.lay_out_strain()?;
        Ok(scene)
    }

    /// Writes the numbers of the strain structure where a step reads them.
    pub(crate) fn lay_out_strain(&mut self) -> Result<(), Short> {
        if self.shape.is_strain() {
            lay_out_strain(&self.sections.strain, self.shape.strain, &self.strain, Some(&mut *self.map))?;
            lay_out_force(&self.strain, self.parameters.density, self.shape.stride(), self.load_maps);
        }
        Ok(())
    }

    /// The memory that this scene asked for.
    #[must_use]
    pub const fn own_sizes(&self) -> Sizes {
        self.shape.sizes()
    }

    /// The structure the scene took.
    #[must_use]
    pub const fn structure(&self) -> Structure {
        self.shape.structure()
    }

    /// `true` if dashpots couple the modes: an exact step is then one of all modes together, `4r²`
    /// multiply-adds, and binding costs `O(r³)`.
    #[must_use]
    pub const fn is_coupled(&self) -> bool {
        self.shape.is_coupled()
    }

    /// Numbers of a state that [`State::save_into`](crate::State::save_into) writes: `3r`, or `2r` of the
    /// exact and of the strain structure.
    #[must_use]
    pub const fn state_numbers(&self) -> usize {
        self.shape.n_parts() * self.shape.r
    }

    /// `r`: the number of modes.
    #[must_use]
    pub const fn n_modes(&self) -> usize {
        self.shape.r
    }

    /// The file's metadata.
    #[must_use]
    pub const fn metadata(&self) -> &Metadata<'m> {
        &self.metadata
    }

    /// The parameters the scene is bound to.
    #[must_use]
    pub const fn parameters(&self) -> &StepParameters {
        &self.parameters
    }

    /// The options the scene is bound to, as they are after every change.
    #[must_use]
    pub const fn options(&self) -> &SceneOptions {
        &self.options
    }

    /// The scheme whose stages the scene fused.
    pub(crate) const fn scheme(&self) -> &SchemeTable {
        if self.shape.is_exact() { &SchemeTable::EXACT } else { &self.metadata.scheme }
    }

    /// Instants at which a step needs a changing load, as fractions of it: 0, then one per stage; the rest
    /// is 0.
    #[must_use]
    pub fn instants(&self) -> [f64; 1 + MAX_STAGES] {
        self.scheme().instants()
    }
}

/// The step of the strain structure, checked; nothing for the others.
pub(crate) fn strain_step<T: Scalar>(
    sections: &StrainSections<'_>,
    shape: Shape,
    asked: &StepParameters,
    options: &SceneOptions,
) -> Result<StrainStep, BindError> {
    if shape.is_strain() {
        checked_step::<T>(sections, shape.strain, asked, options)
    } else {
        Ok(StrainStep::default())
    }
}
