//! Contacts as an operator: what `compliance` and `free_motion` say is what a step does, the static residual
//! makes a held load end where statics says, and a rigid sphere that is solved for neither goes into the body
//! nor gives it energy.

use std::sync::OnceLock;

use vademecum_build::fem::{Pencil, Solve, Symbolic};
use vademecum_build::input::Problem;
use vademecum_build::linalg::Random;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::prepare;
use vademecum_build::progress::Silent;
use vademecum_eval::{
    Contact, Field, LoadError, Loads, Scalar, Scene, SceneOptions, State, StepError, StructureChoice,
    SurfacePoint,
};
use vademecum_format::{File, SectionKind};
use vademecum_tests::program::repository;
use vademecum_tests::shared::shared;
use vademecum_tests::stage::with_scene;

#[path = "../../examples/press_a_sphere.rs"]
mod press_a_sphere;

use press_a_sphere::{Body, Sphere, Touch, beam, path, press};
