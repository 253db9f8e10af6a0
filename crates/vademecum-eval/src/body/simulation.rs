//! A body that owns its memory: what programs with a heap want in place of five lent buffers.
//!
//! Note: the scene, the state and the loads borrow from the bytes and the numbers beside them, in
//! the same value. Their lifetime is written as `'static` in here and never shown so to anybody. Bytes and
//! numbers lie on the heap, stay where they are when the value moves, and are freed after what borrows from
//! them.
#![allow(unsafe_code)]

use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;
use core::ptr::NonNull;

use crate::base::error::{BindError, LoadError, LocateError, OutputError, StepError};
use crate::base::options::{SceneOptions, Status};
use crate::base::scalar::Scalar;
use crate::body::body::{Body, BodyOptions, BodyParts, LoadsAfter};
use crate::body::tree::SurfaceTree;
#[cfg(feature = "parametric")]
use crate::parametric::memory::{Carried, LiveMemory};
use crate::scene::loads::Loads;
use crate::scene::scene::Scene;
use crate::scene::state::State;
use crate::sections::place::Place;
use crate::sections::rows::Field;
use crate::sections::surface::{Surface, SurfacePoint};
use crate::show::reaction::Reaction;
use crate::show::stress::Tensor;
#[cfg(feature = "parametric")]
use vademecum_format::SectionKind;
use vademecum_format::{BaseMotion, File, FormatError, Parameter};

/// Bytes of a file, shared by all simulations of it.
type Bytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// A body that owns its file, its scene, its state and its loads (feature `alloc`).
///
/// ```
/// # #[cfg(feature = "std")]
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use vademecum_eval::{Field, SceneOptions, Simulation};
///
/// # let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden");
/// # let path = std::path::Path::new(folder).join("fixed-f64.vdm");
/// let mut body = Simulation::<f32>::open(path, &SceneOptions::default())?;
/// let finger = body.locate([0.1, 0.05, 0.0])?;
/// body.push(&finger, [0.0, 0.0, -20.0])?;
/// body.step(1000)?;
/// let [_, _, down] = body.point(&finger, Field::Displacement)?;
/// # assert!(down < 0.0);
/// # Ok(())
/// # }
/// # #[cfg(not(feature = "std"))]
/// # fn main() {}
/// ```
///
/// A load stays until [`Simulation::clear`], through changes of parameters too. After the first loads of the
/// largest frame nothing allocates any more. What has no method here is reached with [`Simulation::with`].
pub struct Simulation<T: Scalar + 'static> {
    // Fields are dropped in this order: what borrows goes first.
    body: Body<'static, T>,
    /// Loads as they were added, for the next parameters.
    applied: Vec<Applied>,
    /// Made when something is picked for the first time.
    picking: Option<Picking<T>>,
    /// Counts what may have moved the body.
    moves: u64,
    /// Options of the binding; the parameters may have changed since.
    options: BodyOptions,
    /// Memory of a parametric file, whose body is replaced when parameters are set.
    #[cfg(feature = "parametric")]
    live: Option<LiveMemory<'static>>,
    _numbers: Numbers<f64>,
    bytes: Bytes,
}

/// The tree over the moving surface, and what it is fitted with.
struct Picking<T> {
    tree: SurfaceTree<'static>,
    displacement: Vec<T>,
    /// The move and the scale that the tree is fitted to.
    fitted: Option<(u64, f64)>,
    _order: Numbers<u32>,
    _boxes: Numbers<f32>,
}

/// A load of a simulation.
#[derive(Clone, Copy)]
enum Applied {
    Push(Place, [f64; 3]),
    Pattern(usize, f64),
    Base(BaseMotion),
    Pull([f64; 3]),
}

impl Applied {
    fn add<T: Scalar>(&self, body: &mut Body<'_, T>) -> Result<(), LoadError> {
        match self {
            Self::Push(place, force) => body.push(place, *force),
            Self::Pattern(pattern, amplitude) => body.push_pattern(*pattern, *amplitude),
            Self::Base(motion) => body.push_base(motion),
            Self::Pull(force) => body.pull(*force),
        }
    }
}

/// Why there is no simulation.
#[derive(Debug)]
#[non_exhaustive]
pub enum SimulationError {
    /// The file cannot be read.
    #[cfg(feature = "std")]
    Read(std::io::Error),
    /// The bytes are no vademecum file, or are damaged.
    Format(FormatError),
    /// The file cannot be bound under these options.
    Bind(BindError),
}

impl fmt::Display for SimulationError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            #[cfg(feature = "std")]
            Self::Read(_) => out.write_str("the file cannot be read"),
            Self::Format(error) => error.fmt(out),
            Self::Bind(error) => error.fmt(out),
        }
    }
}

impl core::error::Error for SimulationError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            #[cfg(feature = "std")]
            Self::Read(error) => Some(error),
            // Their words are those of this error.
            Self::Format(_) | Self::Bind(_) => None,
        }
    }
}

impl From<FormatError> for SimulationError {
    fn from(error: FormatError) -> Self {
        Self::Format(error)
    }
}

impl From<BindError> for SimulationError {
    fn from(error: BindError) -> Self {
        Self::Bind(error)
    }
}

impl<T: Scalar + 'static> Simulation<T> {
    /// Reads the file at `path` into memory and binds it, at rest and without loads. Whatever becomes of the
    /// file on the disk afterwards, the simulation stays what it is. To map a file instead, hand a
    /// [`Mapped`](crate::Mapped) to [`Simulation::new`].
    ///
    /// # Errors
    /// [`SimulationError`].
    #[cfg(feature = "std")]
    pub fn open(path: impl AsRef<std::path::Path>, options: &SceneOptions) -> Result<Self, SimulationError> {
        Self::new(std::fs::read(path).map_err(SimulationError::Read)?, options)
    }

    /// Binds the bytes of a file: a `Vec<u8>`, a `&'static [u8]`, a [`Mapped`](crate::Mapped). With the
    /// feature `unpack` they may be packed; the whole file is then decoded.
    ///
    /// # Errors
    /// [`SimulationError`].
    pub fn new(
        bytes: impl AsRef<[u8]> + Send + Sync + 'static,
        options: &SceneOptions,
    ) -> Result<Self, SimulationError> {
        Self::with_options(bytes, &BodyOptions { scene: *options, flight: false, ..BodyOptions::default() })
    }

    /// The same with options of a body: one without supports then flies, if they say so.
    ///
    /// # Errors
    /// [`SimulationError`].
    pub fn with_options(
        bytes: impl AsRef<[u8]> + Send + Sync + 'static,
        options: &BodyOptions,
    ) -> Result<Self, SimulationError> {
        #[cfg(feature = "unpack")]
        if let Some(unpacked) = unpacked(bytes.as_ref())? {
            return Self::of(Arc::new(unpacked), options);
        }
        Self::of(Arc::new(bytes), options)
    }

    /// Another body of the same file, at the parameters that this one has now, at rest and without loads. The
    /// two share the bytes of the file and nothing else, and may go to different threads. For hundreds of
    /// bodies that are stepped together there is [`Batch`](crate::Batch).
    ///
    /// # Errors
    /// [`BindError`].
    pub fn another(&self) -> Result<Self, SimulationError> {
        #[cfg(feature = "parametric")]
        if let Some(live) = &self.live {
            let settings: Vec<(usize, f64)> = live.values().iter().copied().enumerate().collect();
            let mut another = Self::of(Arc::clone(&self.bytes), &self.options)?;
            another.set_parameters(&settings)?;
            return Ok(another);
        }
        let scene = *self.body.scene().options();
        Self::of(Arc::clone(&self.bytes), &BodyOptions { scene, ..self.options })
    }

    fn of(bytes: Bytes, options: &BodyOptions) -> Result<Self, SimulationError> {
        let own: &[u8] = (*bytes).as_ref();
        // SAFETY: the slice lies in what `bytes` shares. That is not dropped before `self.bytes`, which is
        // the last field, and is never borrowed mutably: nobody else has the same count of it but
        // simulations.
        let own: &'static [u8] = unsafe { core::slice::from_raw_parts(own.as_ptr(), own.len()) };
        let file = File::parse(own)?;
        #[cfg(feature = "parametric")]
        let is_parametric = file.section(SectionKind::LiveParameters).is_some();
        #[cfg(feature = "parametric")]
        let length = if is_parametric { LiveMemory::len_for::<T> } else { Body::<T>::len_for };
        #[cfg(not(feature = "parametric"))]
        let length = Body::<T>::len_for;
        let mut numbers = Numbers::<f64>::new(length(&file, options)?);
        // SAFETY: called once, and what borrows from it is dropped before `numbers`: on the way out of this
        // function as a local that came later, and with the simulation as an earlier field.
        let memory = unsafe { numbers.lend() };
        #[cfg(feature = "parametric")]
        let (live, body) = if is_parametric {
            let (live, body) = LiveMemory::bind(&file, options, memory)?;
            (Some(live), body)
        } else {
            (None, Body::bind(&file, options, memory)?)
        };
        #[cfg(not(feature = "parametric"))]
        let body = Body::bind(&file, options, memory)?;
        Ok(Self {
            body,
            applied: Vec::with_capacity(options.scene.contacts),
            picking: None,
            moves: 0,
            options: *options,
            #[cfg(feature = "parametric")]
            live,
            _numbers: numbers,
            bytes,
        })
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> &Body<'_, T> {
        &self.body
    }

    /// The file.
    #[must_use]
    pub fn file(&self) -> &File<'_> {
        self.body.file()
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene<'_, T> {
        self.body.scene()
    }

    /// The state.
    #[must_use]
    pub fn state(&self) -> &State<'_, T> {
        self.body.state()
    }

    /// The loads.
    #[must_use]
    pub fn loads(&self) -> &Loads<'_, T> {
        self.body.loads()
    }

    /// Lends the scene, the state and the loads to what has no method here. Loads that are added in this way
    /// are gone after [`Simulation::set_parameters`].
    pub fn with<R>(
        &mut self,
        run: impl for<'m> FnOnce(&mut Scene<'m, T>, &mut State<'m, T>, &mut Loads<'m, T>) -> R,
    ) -> R {
        self.moves = self.moves.wrapping_add(1);
        self.body.with(|BodyParts { scene, state, loads, .. }| run(scene, state, loads))
    }

    /// Lends the body to what has no method here. Loads that are added in this way are gone after
    /// [`Simulation::set_parameters`].
    pub fn with_body<R>(&mut self, run: impl for<'m> FnOnce(&mut Body<'m, T>) -> R) -> R {
        self.moves = self.moves.wrapping_add(1);
        run(&mut self.body)
    }

    /// The number of the probe of this name.
    #[must_use]
    pub fn find_probe(&self, name: &str) -> Option<usize> {
        self.body.file.probe_names().position(|known| known == name)
    }

    /// The number of the load pattern of this name.
    #[must_use]
    pub fn find_pattern(&self, name: &str) -> Option<usize> {
        self.body.file.pattern_names().position(|known| known == name)
    }

    /// Live parameters, in the order of their numbers.
    pub fn parameters(&self) -> impl Iterator<Item = Parameter<'_>> {
        #[cfg(feature = "parametric")]
        if let Some(live) = &self.live {
            return live.model().file().parameters();
        }
        self.body.file.parameters()
    }

    /// The number of the live parameter of this name.
    #[must_use]
    pub fn find_parameter(&self, name: &str) -> Option<usize> {
        self.parameters().position(|parameter| parameter.name == name)
    }

    /// Value of a live parameter as it is set.
    #[must_use]
    pub fn parameter(&self, index: usize) -> Option<f64> {
        #[cfg(feature = "parametric")]
        if let Some(live) = &self.live {
            return live.values().get(index).copied();
        }
        self.body.scene.options().value(self.body.scene.metadata(), index)
    }

    /// Energies of the last change of parameters; `None` of a file that is not parametric.
    #[cfg(feature = "parametric")]
    #[must_use]
    pub fn carried(&self) -> Option<Carried> {
        self.live.as_ref().map(LiveMemory::carried)
    }

    /// The nearest point of the loadable surface at rest, as [`Body::locate`].
    ///
    /// # Errors
    /// [`LocateError`].
    pub fn locate(&self, point: [f64; 3]) -> Result<SurfacePoint, LocateError> {
        self.body.locate(point)
    }

    /// First point that a ray meets on the whole surface as it has moved, magnified by `scale` in the
    /// picture, as [`SurfaceTree::pick`]. `None` where it meets nothing, and where the file does not have its
    /// whole surface. A force can be added there if the point is loadable; elsewhere [`Simulation::push`]
    /// refuses.
    ///
    /// The first search after a move fits the tree to the surface, `O(n)` with a small constant; each search
    /// is `O(log n)`.
    #[must_use]
    pub fn pick(&mut self, origin: [f64; 3], direction: [f64; 3], scale: f64) -> Option<SurfacePoint> {
        self.moved_surface(scale)?.pick(origin, direction)
    }

    /// The point of the whole surface as it has moved, magnified by `scale`, that is nearest to `point`, as
    /// [`SurfaceTree::locate`]. Costs as [`Simulation::pick`].
    #[must_use]
    pub fn nearest(&mut self, point: [f64; 3], scale: f64) -> Option<SurfacePoint> {
        self.moved_surface(scale)?.locate(point)
    }

    /// The tree, fitted to the surface as it is now.
    fn moved_surface(&mut self, scale: f64) -> Option<&SurfaceTree<'_>> {
        if self.picking.is_none() {
            self.picking = Some(Picking::new(&self.body.file)?);
        }
        let Picking { tree, displacement, fitted, .. } = self.picking.as_mut()?;
        if *fitted != Some((self.moves, scale)) {
            *fitted = None;
            self.body.surface_into(Field::Displacement, displacement).ok()?;
            tree.refit(displacement, scale).ok()?;
            *fitted = Some((self.moves, scale));
        }
        Some(tree)
    }

    /// Adds a force \[N\] at a point, as [`Loads::add_contact`].
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn push(&mut self, at: &impl AsRef<Place>, force: [f64; 3]) -> Result<(), LoadError> {
        self.apply(Applied::Push(*at.as_ref(), force))
    }

    /// Adds a load pattern, as [`Loads::add_pattern`].
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn push_pattern(&mut self, pattern: usize, amplitude: f64) -> Result<(), LoadError> {
        self.apply(Applied::Pattern(pattern, amplitude))
    }

    /// Adds the inertia of a base that moves so, as [`Loads::add_base`].
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn push_base(&mut self, motion: BaseMotion) -> Result<(), LoadError> {
        self.apply(Applied::Base(motion))
    }

    /// Pulls a body that flies at its centre, as [`Body::pull`].
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn pull(&mut self, force: [f64; 3]) -> Result<(), LoadError> {
        self.apply(Applied::Pull(force))
    }

    fn apply(&mut self, load: Applied) -> Result<(), LoadError> {
        load.add(&mut self.body)?;
        self.applied.push(load);
        Ok(())
    }

    /// Takes all loads away.
    pub fn clear(&mut self) {
        self.applied.clear();
        self.body.clear();
    }

    /// So many steps under the loads as they are; fewer once the body rests, which it then goes on doing.
    ///
    /// # Errors
    /// [`StepError`].
    pub fn step(&mut self, steps: usize) -> Result<Status, StepError> {
        self.moves = self.moves.wrapping_add(1);
        if self.body.flight().is_some() {
            // Loads of a flight act for one step.
            self.applied.clear();
        }
        self.body.march(steps)
    }

    /// Puts the body at rest; loads stay.
    pub fn rest(&mut self) {
        self.moves = self.moves.wrapping_add(1);
        self.body.rest();
    }

    /// Sets a live parameter and carries state and loads over, as [`Scene::set_parameters`].
    ///
    /// # Errors
    /// [`BindError`]. Parameter, state and loads are then what they were, with one exception: a load that
    /// leaves the range of `T` at the new value. The answer is [`BindError::NotFinite`], the value is set and
    /// no load acts any more.
    pub fn set_parameters(&mut self, settings: &[(usize, f64)]) -> Result<(), BindError> {
        self.moves = self.moves.wrapping_add(1);
        if self.changed(settings)? == LoadsAfter::Empty {
            return Ok(());
        }
        self.body.clear();
        // What was taken before is taken again, unless it leaves the precision.
        let body = &mut self.body;
        if self.applied.iter().any(|load| load.add(body).is_err()) {
            self.clear();
            return Err(BindError::NotFinite);
        }
        Ok(())
    }

    fn changed(&mut self, settings: &[(usize, f64)]) -> Result<LoadsAfter, BindError> {
        #[cfg(feature = "parametric")]
        if let Some(live) = &mut self.live {
            // It knows the surface of the body that goes.
            self.picking = None;
            // SAFETY: the body is that of this memory. What borrows from it is the picking, which is gone:
            // nobody else has seen its lifetime.
            return unsafe { live.set(settings, &mut self.body) };
        }
        self.body.set_parameters(settings)
    }

    /// A probe, as [`Scene::probe`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn probe(&self, probe: usize, field: Field) -> Result<f64, OutputError> {
        self.body.scene.probe(&self.body.state, probe, field)
    }

    /// A place, as [`Scene::point`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn point(&self, at: &impl AsRef<Place>, field: Field) -> Result<[f64; 3], OutputError> {
        self.body.scene.point(&self.body.state, at, field)
    }

    /// The number of the support of this name, if the file gives reactions.
    #[must_use]
    pub fn find_support(&self, name: &str) -> Option<usize> {
        self.body.file.support_names().position(|known| known == name)
    }

    /// Reaction of a support on the body, as [`Scene::reaction`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn reaction(&self, support: usize) -> Result<Reaction, OutputError> {
        self.body.scene.reaction(&self.body.state, support)
    }

    /// Stress at a point of the file, as [`Scene::stress`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn stress(&self, point: usize) -> Result<Tensor, OutputError> {
        self.body.scene.stress(&self.body.state, point)
    }

    /// Strain at a point of the file, as [`Scene::strain`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn strain(&self, point: usize) -> Result<Tensor, OutputError> {
        self.body.scene.strain(&self.body.state, point)
    }

    /// The whole surface, as [`Scene::surface_into`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn surface_into(&self, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        self.body.scene.surface_into(&self.body.state, field, out)
    }

    /// The whole body, as [`Scene::body_into`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn body_into(&self, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        self.body.scene.body_into(&self.body.state, field, out)
    }

    /// Kinetic and elastic energy \[J\], as [`Scene::energy`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn energy(&self) -> Result<f64, OutputError> {
        self.body.energy()
    }

    /// The state, to be kept; [`Simulation::restore`] takes it back bit by bit. Loads are not part of it.
    #[must_use]
    pub fn save(&self) -> Vec<T> {
        let mut saved = vec![T::ZERO; self.body.scene.state_numbers()];
        // The length is the scene's own.
        let _ = self.body.state.save_into(&mut saved);
        saved
    }

    /// Takes back what [`Simulation::save`] gave at the same time step. What the modes leave out of the
    /// static answer is that to the loads there are now, as [`State::restore_under`] says.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn restore(&mut self, saved: &[T]) -> Result<(), StepError> {
        self.moves = self.moves.wrapping_add(1);
        self.body.state.restore_under(saved, &self.body.loads)
    }
}

impl<T: Scalar> Picking<T> {
    fn new(file: &File<'static>) -> Option<Self> {
        let surface = Surface::whole(file).ok()?;
        let sizes = surface.tree_sizes();
        let (mut order, mut boxes) = (Numbers::new(sizes.order), Numbers::new(sizes.boxes));
        // SAFETY: each is called once; the tree is an earlier field of the same value.
        let lent = unsafe { (order.lend(), boxes.lend()) };
        let tree = SurfaceTree::new(&surface, lent.0, lent.1).ok()?;
        let displacement = vec![T::ZERO; 3 * file.metadata().n_surface_nodes as usize];
        Some(Self { tree, displacement, fitted: None, _order: order, _boxes: boxes })
    }
}

impl<T: Scalar + 'static> fmt::Debug for Simulation<T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Simulation").field("scene", self.body.scene()).finish_non_exhaustive()
    }
}

/// The file with every section decoded, if any is packed.
#[cfg(feature = "unpack")]
fn unpacked(bytes: &[u8]) -> Result<Option<Vec<u8>>, FormatError> {
    use vademecum_format::{Codec, unpack_into, unpacked_len};
    let file = File::parse(bytes)?;
    if file.sections().all(|section| section.codec() == Codec::Raw) {
        return Ok(None);
    }
    let mut memory = vec![0; unpacked_len(&file, |_| true)?];
    unpack_into(&file, |_| true, &mut memory)?;
    Ok(Some(memory))
}

/// Numbers on the heap that others of the same value borrow. A `Box` would not do: to move one says that
/// nothing borrows from it.
struct Numbers<T> {
    at: NonNull<[T]>,
}

// SAFETY: it owns its numbers, as a `Box` does.
unsafe impl<T: Send> Send for Numbers<T> {}
// SAFETY: nothing is reached through a shared reference to it.
unsafe impl<T: Sync> Sync for Numbers<T> {}

impl<T: Copy + Default> Numbers<T> {
    fn new(length: usize) -> Self {
        Self { at: NonNull::from(Box::leak(vec![T::default(); length].into_boxed_slice())) }
    }

    /// All of the numbers.
    ///
    /// # Safety
    /// It is called once, and what borrows from it is dropped before `self`.
    unsafe fn lend(&mut self) -> &'static mut [T] {
        // SAFETY: the pointer is that of a box that is freed when `self` is dropped.
        unsafe { &mut *self.at.as_ptr() }
    }
}

impl<T> Drop for Numbers<T> {
    fn drop(&mut self) {
        // SAFETY: the pointer came from a box, and nothing borrows from it any more.
        drop(unsafe { Box::from_raw(self.at.as_ptr()) });
    }
}
