//! The extension module `vademecum._native`: the evaluator and the builder for the Python package.
//!
//! Nothing is computed here. The module hands numbers and arrays to the crates of the workspace, says their
//! errors as exceptions, and lets other threads of Python run while they work. What is plain Python (data
//! classes, names, defaults) is written in Python, in `python/vademecum`.

mod adjoint;
mod arrays;
mod batch;
mod body;
mod content;
mod file;
mod gradient;
mod jobs;
mod live;
mod motion;
mod names;
mod options;
mod point;
mod problem;
mod refusal;
mod setup;
mod simulation;
mod threads;
mod watch;
mod world;

use pyo3::prelude::*;

/// The extension module.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::batch::PyBatch;
    #[pymodule_export]
    use crate::body::PyBody;
    #[pymodule_export]
    use crate::file::PyFile;
    #[pymodule_export]
    use crate::gradient::{PyKeptMarch, vjp};
    #[pymodule_export]
    use crate::jobs::{build, check, frf, init, mesh, modes, program, report, run, state_space, verify};
    #[pymodule_export]
    use crate::live::{PyTracker, sensitivities, tangents, tracker};
    #[pymodule_export]
    use crate::motion::PyMotion;
    #[pymodule_export]
    use crate::point::PyPoint;
    #[pymodule_export]
    use crate::world::PyWorld;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn start(module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::threads::note_process();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
