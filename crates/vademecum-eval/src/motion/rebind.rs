//! Setting a bound scene to other parameters, where it is and without heap.
//!
//! The new step is fused in lent work memory and checked there; only then is the scene's own memory written,
//! so an error leaves everything as it was. Bits: a scene set to parameters is the scene freshly bound to
//! them.

use crate::base::error::BindError;
use crate::base::options::{SceneOptions, Structure, StructureChoice};
use crate::base::scalar::Scalar;
use crate::scene::bind::{Asked, fuse, lay_out};
use crate::scene::scene::{Scene, strain_step};
use crate::scene::shape;
use crate::scene::state::State;
use crate::sections::filter::filter_of;

impl<T: Scalar> Scene<'_, T> {
    /// Sets parameters of the file ([`SceneOptions::find`] tells the number of a name) and carries `state`
    /// over: displacement, velocity and acceleration stay what they are. Loads added before are stale: clear
    /// them and add them again.
    ///
    /// `work` holds at least [`Sizes::work`](crate::Sizes::work) numbers. Costs what [`Scene::bind`] costs.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(LIVE, Auto: file, sizes, scene, state, loads, work);
    /// let soft = SceneOptions::find(scene.metadata(), "soft").ok_or("no such parameter")?;
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// scene.set_parameters(&[(soft, 0.75)], &mut state, &mut work)?;
    /// assert_eq!(scene.options().regions.stiffness()[0], 0.75);
    /// assert_eq!(scene.step(&mut state, &loads), Err(StepError::StaleLoads));
    /// loads.clear();
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// scene.step(&mut state, &loads)?;
    ///
    /// // The file was built for 0.5 to 2; another value is refused and changes nothing.
    /// assert!(scene.set_parameters(&[(soft, 3.0)], &mut state, &mut work).is_err());
    /// assert_eq!(scene.options().regions.stiffness()[0], 0.75);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`BindError`]; scene and state are then unchanged.
    pub fn set_parameters(
        &mut self,
        settings: &[(usize, f64)],
        state: &mut State<'_, T>,
        work: &mut [f64],
    ) -> Result<(), BindError> {
        if state.shape != self.shape {
            return Err(BindError::Mismatch);
        }
        let mut options = self.options;
        options.set(&self.metadata, settings)?;
        self.rebind_with(&options, state, work)
    }

    /// [`Scene::rebind`], with one state that is carried over.
    pub(crate) fn rebind_with(
        &mut self,
        options: &SceneOptions,
        state: &mut State<'_, T>,
        work: &mut [f64],
    ) -> Result<(), BindError> {
        let time_step = options.time_step.unwrap_or(self.metadata.time_step);
        state.y.scale_to(time_step).map_err(|_| BindError::NotFinite)?;
        self.rebind(options, work)?;
        state.y.accept(time_step);
        Ok(())
    }

    /// Binds the scene to other options where it is; for several parameters at once, or several states, each
    /// of which then wants [`State::carry`]. The structure stays, and so does the number of terms: the
    /// options' choice must be the scene's structure or `Auto`.
    ///
    /// # Errors
    /// [`BindError`]; the scene is then unchanged.
    pub fn rebind(&mut self, options: &SceneOptions, work: &mut [f64]) -> Result<(), BindError> {
        shape::check(options)?;
        match (options.structure, self.shape.structure()) {
            (StructureChoice::Auto, _)
            | (StructureChoice::Diagonal, Structure::Diagonal)
            | (StructureChoice::Block, Structure::Block)
            | (StructureChoice::Exact, Structure::Exact)
            | (StructureChoice::Strain, Structure::Strain) => {}
            _ => return Err(BindError::OtherStructure),
        }
        match self.shape.structure() {
            Structure::Diagonal | Structure::Exact if options.moves_a_region() => {
                return Err(BindError::NotDiagonal);
            }
            Structure::Strain if options.moves_a_region() => return Err(BindError::WholeBody),
            Structure::Block => {
                let (asked, found) = (shape::terms(&self.metadata, options)?, self.shape.n_terms);
                if asked != found {
                    return Err(BindError::Terms { asked, found });
                }
            }
            _ => {}
        }
        let (found, needed) = (work.len(), self.shape.work_len());
        let work = work.get_mut(..needed).ok_or(BindError::LentMemory { found, needed })?;
        let asked = Asked::new(&self.metadata, options);
        if asked.step.beta != 0.0 && self.residual_wants_filter() {
            return Err(BindError::NoFilter);
        }
        let fused = fuse::<T>(&self.metadata, &self.sections, &asked, self.shape, work)?;
        let strain = strain_step::<T>(&self.sections.strain, self.shape, &asked.step, options)?;
        lay_out(&fused, self.shape, self.map, self.load_maps, self.weights)?;
        self.options = *options;
        self.filter = filter_of(&asked.step);
        (self.parameters, self.strain) = (asked.step, strain);
        self.lay_out_strain()?;
        self.rest_below = options.rest_threshold();
        self.generation = self.generation.wrapping_add(1);
        Ok(())
    }

    /// `true` for a scene that shows residual flexibility and has no room for its filter.
    const fn residual_wants_filter(&self) -> bool {
        let [nodes, patterns] = self.shape.statics;
        let shown = nodes != 0 || patterns != 0;
        shown && self.options.residual && !self.sections.residual.is_empty() && !self.shape.is_filtered()
    }
}
