//! A body in either precision: what a scene asks of its simulation.

use numpy::{Element, PyReadonlyArray1};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use vademecum_eval::{
    BaseMotion, BindError, Contact, Field, FreeBody, LoadError, OutputError, RigidMotion, Scalar,
    SceneOptions, Simulation, Status, StepError, StressPoint, Structure, SurfacePoint, Tensor,
};
use vademecum_format::Metadata;

use crate::arrays::filled;
use crate::refusal::{of_output, of_step};

/// A precision of the evaluator and of NumPy.
pub trait Number: Scalar + Element + 'static {}

impl Number for f32 {}
impl Number for f64 {}

/// A simulation whose precision is known at run time.
pub trait Body: Send {
    fn metadata(&self) -> &Metadata<'_>;
    fn options(&self) -> SceneOptions;
    fn time_step(&self) -> f64;
    fn structure(&self) -> Structure;
    fn is_single(&self) -> bool;
    fn locate(&self, point: [f64; 3]) -> Option<SurfacePoint>;
    fn pick(&mut self, origin: [f64; 3], direction: [f64; 3], scale: f64) -> Option<SurfacePoint>;
    fn push(&mut self, at: &SurfacePoint, force: [f64; 3]) -> Result<(), LoadError>;
    fn push_pattern(&mut self, pattern: usize, amplitude: f64) -> Result<(), LoadError>;
    fn push_base(&mut self, motion: BaseMotion) -> Result<(), LoadError>;
    fn clear(&mut self);
    fn rest(&mut self);
    fn step(&mut self, steps: usize) -> Result<Status, StepError>;
    fn set(&mut self, parameter: usize, value: f64) -> Result<(), BindError>;
    fn probe(&self, probe: usize, field: Field) -> Result<f64, OutputError>;
    fn point(&self, at: &SurfacePoint, field: Field) -> Result<[f64; 3], OutputError>;
    fn node(&self, node: usize, field: Field) -> Result<[f64; 3], OutputError>;
    fn energy(&self) -> Result<f64, OutputError>;
    fn reaction(&self, support: usize) -> Result<[f64; 6], OutputError>;
    fn stress_points(&self) -> Vec<StressPoint>;
    fn stress(&self, point: usize) -> Result<Tensor, OutputError>;
    fn strain(&self, point: usize) -> Result<Tensor, OutputError>;
    fn compliance(&self, contacts: &[Contact]) -> Result<Vec<f64>, LoadError>;
    fn free_motion(&self, contacts: &[Contact]) -> Result<Vec<f64>, StepError>;
    fn place(&mut self, zeta: &[f64], zeta_dot: &[f64]) -> Result<(), StepError>;
    fn surface<'py>(&self, field: Field, out: Out<'_, 'py>) -> PyResult<Bound<'py, PyAny>>;
    fn body<'py>(&self, field: Field, out: Out<'_, 'py>) -> PyResult<Bound<'py, PyAny>>;
    fn save<'py>(&self, out: Out<'_, 'py>) -> PyResult<Bound<'py, PyAny>>;
    fn restore(&mut self, saved: &Bound<'_, PyAny>) -> PyResult<()>;
    /// The rigid motion at rest; `None` of a body with supports.
    fn free_body(&self) -> Option<FreeBody>;
    fn follow(&self, free: &mut FreeBody);
    fn ahead(&self, free: &FreeBody) -> RigidMotion;
    fn push_free(&mut self, free: &mut FreeBody, at: &SurfacePoint, force: [f64; 3])
    -> Result<(), LoadError>;
    fn push_free_pattern(
        &mut self,
        free: &mut FreeBody,
        pattern: usize,
        amplitude: f64,
    ) -> Result<(), LoadError>;
    fn clear_free(&mut self, free: &mut FreeBody);
    fn fly(&mut self, free: &mut FreeBody) -> Result<Status, StepError>;
    fn in_space(&self, free: &FreeBody, at: &SurfacePoint, field: Field) -> Result<[f64; 3], OutputError>;
}

/// Python, and the caller's array if there is one.
pub type Out<'a, 'py> = (Python<'py>, Option<&'a Bound<'py, PyAny>>);

impl<T: Number> Body for Simulation<T> {
    fn metadata(&self) -> &Metadata<'_> {
        self.scene().metadata()
    }

    fn options(&self) -> SceneOptions {
        *self.scene().options()
    }

    fn time_step(&self) -> f64 {
        self.scene().parameters().time_step
    }

    fn structure(&self) -> Structure {
        self.scene().structure()
    }

    fn is_single(&self) -> bool {
        size_of::<T>() == size_of::<f32>()
    }

    fn locate(&self, point: [f64; 3]) -> Option<SurfacePoint> {
        Self::locate(self, point)
    }

    fn pick(&mut self, origin: [f64; 3], direction: [f64; 3], scale: f64) -> Option<SurfacePoint> {
        Self::pick(self, origin, direction, scale)
    }

    fn push(&mut self, at: &SurfacePoint, force: [f64; 3]) -> Result<(), LoadError> {
        Self::push(self, at, force)
    }

    fn push_pattern(&mut self, pattern: usize, amplitude: f64) -> Result<(), LoadError> {
        Self::push_pattern(self, pattern, amplitude)
    }

    fn push_base(&mut self, motion: BaseMotion) -> Result<(), LoadError> {
        Self::push_base(self, motion)
    }

    fn clear(&mut self) {
        Self::clear(self);
    }

    fn rest(&mut self) {
        Self::rest(self);
    }

    fn step(&mut self, steps: usize) -> Result<Status, StepError> {
        Self::step(self, steps)
    }

    fn set(&mut self, parameter: usize, value: f64) -> Result<(), BindError> {
        self.set_parameters(&[(parameter, value)])
    }

    fn probe(&self, probe: usize, field: Field) -> Result<f64, OutputError> {
        Self::probe(self, probe, field)
    }

    fn point(&self, at: &SurfacePoint, field: Field) -> Result<[f64; 3], OutputError> {
        Self::point(self, at, field)
    }

    fn node(&self, node: usize, field: Field) -> Result<[f64; 3], OutputError> {
        self.scene().node(self.state(), node, field)
    }

    fn energy(&self) -> Result<f64, OutputError> {
        Self::energy(self)
    }

    fn reaction(&self, support: usize) -> Result<[f64; 6], OutputError> {
        Ok(Self::reaction(self, support)?.total())
    }

    fn stress_points(&self) -> Vec<StressPoint> {
        (0..self.scene().n_stress_points()).filter_map(|point| self.scene().stress_point(point)).collect()
    }

    fn stress(&self, point: usize) -> Result<Tensor, OutputError> {
        Self::stress(self, point)
    }

    fn strain(&self, point: usize) -> Result<Tensor, OutputError> {
        Self::strain(self, point)
    }

    fn compliance(&self, contacts: &[Contact]) -> Result<Vec<f64>, LoadError> {
        let n = 3 * contacts.len();
        let (mut w, mut work) =
            (vec![0.0; n * n], vec![T::ZERO; self.scene().compliance_work(contacts.len())]);
        self.scene().compliance_at(self.state(), contacts, &mut w, &mut work)?;
        Ok(w)
    }

    fn free_motion(&self, contacts: &[Contact]) -> Result<Vec<f64>, StepError> {
        let (mut out, mut work) =
            (vec![[0.0; 3]; contacts.len()], vec![T::ZERO; self.scene().compliance_work(contacts.len())]);
        self.scene().free_motion(self.state(), self.loads(), contacts, &mut out, &mut work)?;
        Ok(out.into_flattened())
    }

    fn place(&mut self, zeta: &[f64], zeta_dot: &[f64]) -> Result<(), StepError> {
        self.with(|scene, state, loads| scene.set(state, zeta, zeta_dot, loads))
    }

    fn surface<'py>(&self, field: Field, (py, out): Out<'_, 'py>) -> PyResult<Bound<'py, PyAny>> {
        let shape = [self.scene().metadata().n_surface_nodes as usize, 3];
        filled::<T>(py, &shape, out, |slice| self.surface_into(field, slice).map_err(of_output))
    }

    fn body<'py>(&self, field: Field, (py, out): Out<'_, 'py>) -> PyResult<Bound<'py, PyAny>> {
        let shape = [self.scene().metadata().n_nodes as usize, 3];
        filled::<T>(py, &shape, out, |slice| self.body_into(field, slice).map_err(of_output))
    }

    fn save<'py>(&self, (py, out): Out<'_, 'py>) -> PyResult<Bound<'py, PyAny>> {
        filled::<T>(py, &[self.scene().state_numbers()], out, |slice| {
            self.state().save_into(slice).map_err(of_step)
        })
    }

    fn restore(&mut self, saved: &Bound<'_, PyAny>) -> PyResult<()> {
        let wrong = || {
            PyTypeError::new_err(format!(
                "the state is no contiguous array of {}: save and restore in one precision",
                T::get_dtype(saved.py())
            ))
        };
        let saved: PyReadonlyArray1<'_, T> = saved.extract().map_err(|_| wrong())?;
        Self::restore(self, saved.as_slice().map_err(|_| wrong())?).map_err(of_step)
    }

    fn free_body(&self) -> Option<FreeBody> {
        FreeBody::new(self.scene(), RigidMotion::at_rest)
    }

    fn follow(&self, free: &mut FreeBody) {
        free.follow(self.scene());
    }

    fn ahead(&self, free: &FreeBody) -> RigidMotion {
        free.ahead(self.scene())
    }

    fn push_free(
        &mut self,
        free: &mut FreeBody,
        at: &SurfacePoint,
        force: [f64; 3],
    ) -> Result<(), LoadError> {
        self.with(|scene, _, loads| free.push(scene, loads, at, force))
    }

    fn push_free_pattern(
        &mut self,
        free: &mut FreeBody,
        pattern: usize,
        amplitude: f64,
    ) -> Result<(), LoadError> {
        self.with(|scene, _, loads| free.push_pattern(scene, loads, pattern, amplitude))
    }

    fn clear_free(&mut self, free: &mut FreeBody) {
        Self::clear(self);
        self.with(|_, _, loads| free.clear(loads));
    }

    fn fly(&mut self, free: &mut FreeBody) -> Result<Status, StepError> {
        self.with(|scene, state, loads| free.step(scene, state, loads))
    }

    fn in_space(&self, free: &FreeBody, at: &SurfacePoint, field: Field) -> Result<[f64; 3], OutputError> {
        match field {
            Field::Displacement => free.point(self.scene(), self.state(), at),
            Field::Velocity => free.velocity(self.scene(), self.state(), at),
        }
    }
}
