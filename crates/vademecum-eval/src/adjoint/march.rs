//! The adjoint of a march of exact steps.
//!
//! A march is `y_n = A y_{n−1} + L₀ f_n⁰ + L₁ f_n¹` with loads `f` along the modes at the start and at the
//! end of step `n`, and a scalar of its outputs changes by `c_n · δy_n` with the state after step `n`. With
//!
//! ```text
//! λ_n = Aᵀ λ_{n+1} + c_n        λ_N = c_N
//! ```
//!
//! its gradient is `L₀ᵀ λ_n` and `L₁ᵀ λ_n` for the loads of step `n`, and `Aᵀ λ_1` for the state at the
//! start. No state of the march is needed. What outputs show of forces beside the modes adds its own part
//! ([`Shown`](crate::adjoint::shown::Shown)).
//!
//! Note: the step backwards is the kernel of a step with the transposed map, whose loads are the cotangents.
//! Damping makes it decay as the march itself does.

use crate::adjoint::cotangents::{Cotangents, check_exact};
use crate::adjoint::error::AdjointError;
use crate::adjoint::shown::Shown;
use crate::base::error::LoadError;
use crate::base::lend::Lender;
use crate::base::scalar::Scalar;
use crate::kernels::coordinates::Coordinates;
use crate::scene::scene::Scene;
use crate::sections::contact::{Contact, check_loadable};
use crate::sections::place::{MAX_PLACE_NODES, Place};
use crate::sections::residual::Statics;
use crate::sections::rows::dot;
use vademecum_format::{BASE_PATTERNS, BaseMotion, Numbers, SectionKind};

/// Memory to lend for an [`Adjoint`] and what goes with it, in numbers of the precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AdjointSizes {
    /// Of an [`Adjoint`].
    pub adjoint: usize,
    /// Of [`Cotangents`].
    pub cotangents: usize,
}

/// A march backwards, in lent memory: after `n` calls of [`Adjoint::back`] it gives the gradient with respect
/// to the loads of the step that is the `n`-th from the end.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # bound!(BODY, Exact: file, sizes, scene, state, loads, work);
/// // A scalar: displacement of the first probe after 50 steps.
/// let sizes = scene.adjoint_sizes()?;
/// let (mut memory, mut of_outputs) = (vec![0.0; sizes.adjoint], vec![0.0; sizes.cotangents]);
/// let mut adjoint = Adjoint::new(&scene, &mut memory)?;
/// let mut cotangents = Cotangents::new(&scene, &mut of_outputs)?;
/// cotangents.add_probe(&scene, 0, Field::Displacement, 1.0)?;
/// let mut gradient = [0.0; 50];
/// for step in (0..50).rev() {
///     adjoint.back(&scene, &cotangents)?;
///     cotangents.clear(); // it does not depend on the outputs before
///     let [start, end] = adjoint.pattern(&scene, 0)?;
///     gradient[step] = start + end; // of an amplitude held over the step
/// }
///
/// // The march is linear: the scalar is the gradient times the amplitudes.
/// let amplitudes: Vec<f64> = (0..50).map(|n| f64::from(n % 7)).collect();
/// for &amplitude in &amplitudes {
///     loads.clear();
///     loads.add_pattern(&scene, 0, amplitude)?;
///     scene.step(&mut state, &loads)?;
/// }
/// let found = scene.probe(&state, 0, Field::Displacement)?;
/// let sum: f64 = gradient.iter().zip(&amplitudes).map(|(g, a)| g * a).sum();
/// assert!((found - sum).abs() < 1e-12 * found.abs());
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Adjoint<'m, T> {
    transposed: Scene<'m, T>,
    lambda: Coordinates<'m, T>,
    /// `L₀ᵀ λ` and `L₁ᵀ λ`, `r` numbers each.
    loads: &'m mut [T],
    /// Zeros in the place of cotangents.
    none: &'m mut [T],
    shown: Shown<'m, T>,
    /// Outputs show forces at once, without the filter of the residual.
    at_once: bool,
    /// A load whose answer is asked for.
    unit: Statics<'m, T>,
}

impl<T: Scalar> Scene<'_, T> {
    /// Memory to lend for the adjoint of a march of this scene.
    ///
    /// # Errors
    /// [`AdjointError::Structure`].
    pub fn adjoint_sizes(&self) -> Result<AdjointSizes, AdjointError> {
        let cotangents = Cotangents::len_for(self)?;
        let shape = &self.shape;
        let own = shape.map_len() + 3 * shape.padded() + 2 * shape.r;
        let adjoint = own + Shown::len(self, room(self)) + unit_len(self);
        Ok(AdjointSizes { adjoint, cotangents })
    }
}

/// Nodes with cotangents of an adjoint march: as many as a state keeps forces of.
fn room<T: Scalar>(scene: &Scene<'_, T>) -> usize {
    let shape = &scene.shape;
    if shape.is_filtered() { shape.filtered[0].max(shape.statics[0]) } else { shape.statics[0] }
}

/// Nodes and patterns of one load; none where outputs show nothing of it beside the modes.
fn unit_room<T: Scalar>(scene: &Scene<'_, T>) -> [usize; 2] {
    let [nodes, patterns] = scene.shape.statics;
    [if nodes > 0 { MAX_PLACE_NODES } else { 0 }, patterns]
}

fn unit_len<T: Scalar>(scene: &Scene<'_, T>) -> usize {
    let [nodes, patterns] = unit_room(scene);
    4 * nodes + patterns
}

impl<'m, T: Scalar> Adjoint<'m, T> {
    /// The end of a march: no cotangents yet. Lends [`AdjointSizes::adjoint`] numbers; what is in them does
    /// not matter. `O(r)`, `O(r²)` where dashpots couple the modes.
    ///
    /// # Errors
    /// [`AdjointError::Structure`], [`AdjointError::Bind`].
    pub fn new<'s: 'm>(scene: &Scene<'s, T>, memory: &'m mut [T]) -> Result<Self, AdjointError> {
        check_exact(scene)?;
        let mut memory = Lender::new(memory);
        let transposed = scene.transposed(memory.take(scene.shape.map_len())?)?;
        let lambda = Coordinates::new(scene.shape.parts(), scene.parameters.time_step, &mut memory)?;
        let loads = memory.take(2 * scene.shape.r)?;
        loads.fill(T::ZERO);
        let none = memory.take(scene.shape.padded())?;
        none.fill(T::ZERO);
        let shown = Shown::new(scene, room(scene), &mut memory)?;
        let unit = Statics::new(unit_room(scene), &mut memory)?;
        Ok(Self { transposed, lambda, loads, none, shown, at_once: false, unit })
    }

    /// Begins again at the end of a march of the same parameters.
    pub fn restart(&mut self) {
        self.lambda.come_to_rest();
        self.loads.fill(T::ZERO);
        self.shown.clear();
    }

    fn check(&self, scene: &Scene<'_, T>) -> Result<(), AdjointError> {
        if self.transposed.shape != scene.shape {
            return Err(AdjointError::Mismatch);
        }
        let same = self.transposed.generation == scene.generation;
        if same && self.transposed.parameters == scene.parameters { Ok(()) } else { Err(AdjointError::Stale) }
    }

    /// Goes back over a step, with the cotangents of the outputs after it. Costs a step. Allocates nothing.
    ///
    /// # Errors
    /// [`AdjointError::Stale`], [`AdjointError::Mismatch`], [`AdjointError::NotFinite`],
    /// [`AdjointError::TooManyNodes`].
    pub fn back(&mut self, scene: &Scene<'_, T>, cotangents: &Cotangents<'_, T>) -> Result<(), AdjointError> {
        self.check(scene)?;
        cotangents.check_scene(scene)?;
        let lambda = &mut self.lambda;
        let size = self.transposed.step_into(lambda.now, cotangents.state, lambda.next)?;
        // Held as if it were loaded: cotangents do not come to rest.
        lambda.settle(size, true, T::ZERO)?;
        self.take_loads(scene, cotangents)?;
        self.at_once = false;
        let keep = T::from_f64(if scene.shape.is_filtered() { scene.filter.keep } else { 0.0 });
        if self.shown.keep_and_add(keep, &cotangents.shown) {
            return Ok(());
        }
        Err(AdjointError::TooManyNodes { nodes: room(scene) })
    }

    /// Takes `λ` after a step back of another march, and what outputs show of forces from cotangents of this
    /// step alone.
    pub(crate) fn take(
        &mut self,
        scene: &Scene<'_, T>,
        cotangents: &Cotangents<'_, T>,
        number: impl Fn(usize, usize) -> Option<T>,
    ) -> Result<(), AdjointError> {
        self.check(scene)?;
        cotangents.check_scene(scene)?;
        for part in 0..2 {
            for (k, out) in self.lambda.part_mut(part).iter_mut().enumerate() {
                *out = number(part, k).ok_or(AdjointError::Mismatch)?;
            }
        }
        self.take_loads(scene, cotangents)?;
        self.at_once = true;
        let fits = self.shown.keep_and_add(T::ZERO, &cotangents.shown);
        if fits { Ok(()) } else { Err(AdjointError::TooManyNodes { nodes: room(scene) }) }
    }

    /// `Lᵀ λ`, and what accelerations follow at once at the end.
    fn take_loads(
        &mut self,
        scene: &Scene<'_, T>,
        cotangents: &Cotangents<'_, T>,
    ) -> Result<(), AdjointError> {
        scene.loads_of_cotangents(self.lambda.now, self.loads)?;
        let ends = self.loads.iter_mut().skip(self.transposed.shape.r);
        ends.zip(&*cotangents.force).for_each(|(end, &own)| *end += own);
        Ok(())
    }

    /// Part of the modes, for the amplitudes at the start and at the end of the step.
    fn of_modes(&self, row: Numbers<'_>) -> [f64; 2] {
        let r = self.transposed.shape.r;
        let (start, end) = self.loads.split_at_checked(r).unwrap_or_default();
        [dot(row, start), dot(row, end)]
    }

    /// Adds what outputs show of the load in `unit`.
    fn with_shown(&self, scene: &Scene<'_, T>, [start, end]: [f64; 2]) -> Result<[f64; 2], AdjointError> {
        if self.unit.is_empty() {
            return Ok([start, end]);
        }
        let (answer, held) = (self.shown.answer(scene, &self.unit), self.shown.held(scene, &self.unit)?);
        let filtered = scene.shape.is_filtered() && !self.at_once;
        let (at_start, at_end) =
            if filtered { (scene.filter.drive(1.0, 0.0), scene.filter.drive(0.0, 1.0)) } else { (0.0, 1.0) };
        Ok([start + at_start * answer, end + at_end * answer + held])
    }

    /// Gradient with respect to the force \[N\] at a node in the step that was gone back over: at its start
    /// and at its end, between which the force is linear. That of a force held over the step is their sum.
    /// `O(r)`.
    ///
    /// # Errors
    /// [`AdjointError::Load`]: a node that cannot be loaded.
    pub fn node(&mut self, scene: &Scene<'_, T>, node: u32) -> Result<[[f64; 3]; 2], AdjointError> {
        self.check(scene)?;
        let place = Place::node(node);
        check_loadable(&place, scene.metadata.n_load_nodes)?;
        let mut gradient = [[0.0; 3]; 2];
        let [starts, ends] = &mut gradient;
        for (component, (start, end)) in starts.iter_mut().zip(ends).enumerate() {
            let row = scene.sections.rows.node_row(node as usize, component)?;
            let mut force = [0.0; 3];
            force.iter_mut().skip(component).take(1).for_each(|one| *one = 1.0);
            self.unit.clear();
            self.unit.add_contact(&Contact::new(place, force), 1.0);
            [*start, *end] = self.with_shown(scene, self.of_modes(row))?;
        }
        self.unit.clear();
        Ok(gradient)
    }

    /// Gradient with respect to a force \[N\] at a place, at the start and at the end of the step, as
    /// [`Adjoint::node`].
    ///
    /// # Errors
    /// [`AdjointError::Load`]: a place that cannot be loaded.
    pub fn force(
        &mut self,
        scene: &Scene<'_, T>,
        at: &impl AsRef<Place>,
    ) -> Result<[[f64; 3]; 2], AdjointError> {
        let place = at.as_ref();
        check_loadable(place, scene.metadata.n_load_nodes)?;
        let mut gradient = [[0.0; 3]; 2];
        for (node, weight) in place.entries() {
            let own = self.node(scene, node)?;
            let sums = gradient.as_flattened_mut().iter_mut();
            sums.zip(own.as_flattened()).for_each(|(sum, x)| *sum += weight * x);
        }
        Ok(gradient)
    }

    /// Gradient with respect to the weight of each node of a place where a force \[N\] goes from `start` to
    /// `end` over the step; `out` has a number for each node. For the place itself see
    /// [`gradient_on_triangle`](crate::gradient_on_triangle).
    ///
    /// # Errors
    /// [`AdjointError::Load`], [`AdjointError::Length`].
    pub fn place(
        &mut self,
        scene: &Scene<'_, T>,
        at: &impl AsRef<Place>,
        [start, end]: [[f64; 3]; 2],
        out: &mut [f64],
    ) -> Result<(), AdjointError> {
        let place = at.as_ref();
        check_loadable(place, scene.metadata.n_load_nodes)?;
        let (found, needed) = (out.len(), place.nodes().len());
        if found != needed {
            return Err(AdjointError::Length { found, needed });
        }
        for (out, &node) in out.iter_mut().zip(place.nodes()) {
            let own = self.node(scene, node)?;
            let forces = [start, end];
            *out = own.as_flattened().iter().zip(forces.as_flattened()).map(|(g, f)| g * f).sum();
        }
        Ok(())
    }

    /// Gradient with respect to the amplitude of a load pattern at the start and at the end of the step.
    /// `O(r)`.
    ///
    /// # Errors
    /// [`AdjointError::Load`]: no such pattern.
    pub fn pattern(&mut self, scene: &Scene<'_, T>, index: usize) -> Result<[f64; 2], AdjointError> {
        self.check(scene)?;
        let (count, r) = (scene.metadata.n_patterns as usize, scene.shape.r);
        if index >= count {
            return Err(LoadError::NoPattern { index, count }.into());
        }
        let kind = SectionKind::PatternBasis;
        let missing = LoadError::Missing { kind };
        let row = scene.sections.pattern_basis.and_then(|basis| basis.row(index * r, r)).ok_or(missing)?;
        self.unit.clear();
        self.unit.add_pattern(index, 1.0);
        let gradient = self.with_shown(scene, self.of_modes(row))?;
        self.unit.clear();
        Ok(gradient)
    }

    /// Gradient with respect to the acceleration \[m/s²\] of a moving base, held over the step
    /// ([`Loads::add_base`](crate::Loads::add_base)).
    ///
    /// # Errors
    /// [`AdjointError::Load`]: a file without a moving base.
    pub fn base_acceleration(&mut self, scene: &Scene<'_, T>) -> Result<[f64; 3], AdjointError> {
        let kind = SectionKind::BaseFrame;
        let missing = LoadError::Missing { kind };
        let first = (scene.metadata.n_patterns as usize).checked_sub(BASE_PATTERNS.len());
        let first = first.filter(|_| scene.base_point().is_some()).ok_or(missing)?;
        let mut gradient = [0.0; 3];
        for (axis, out) in gradient.iter_mut().enumerate() {
            let mut motion = BaseMotion::default();
            motion.acceleration.iter_mut().skip(axis).take(1).for_each(|one| *one = 1.0);
            for (index, amplitude) in motion.amplitudes().into_iter().enumerate() {
                if amplitude != 0.0 {
                    let [start, end] = self.pattern(scene, first + index)?;
                    *out += scene.parameters.density * amplitude * (start + end);
                }
            }
        }
        Ok(gradient)
    }

    /// Writes the gradient with respect to `ζ` and `ζ̇` at the start of the step that was gone back over, `r`
    /// numbers each: after the last step back, that of the initial state. Costs a step.
    ///
    /// # Errors
    /// [`AdjointError::Length`], [`AdjointError::NotFinite`].
    pub fn initial_into(
        &mut self,
        scene: &Scene<'_, T>,
        zeta: &mut [f64],
        zeta_dot: &mut [f64],
    ) -> Result<(), AdjointError> {
        self.check(scene)?;
        for found in [zeta.len(), zeta_dot.len()] {
            let needed = scene.shape.r;
            if found != needed {
                return Err(AdjointError::Length { found, needed });
            }
        }
        let lambda = &mut self.lambda;
        if !self.transposed.step_into(lambda.now, self.none, lambda.next)?.in_range() {
            return Err(AdjointError::NotFinite);
        }
        let [of_zeta, of_rate] = lambda.next_parts()?;
        let scale = scene.parameters.time_step;
        zeta.iter_mut().zip(of_zeta).for_each(|(out, x)| *out = x.to_f64());
        zeta_dot.iter_mut().zip(of_rate).for_each(|(out, x)| *out = scale * x.to_f64());
        Ok(())
    }
}
