//! The shim to MPI and PETSc (`shim.c`) as values: all `unsafe` code of this crate.
//!
//! Calls of MPI and PETSc are made by one thread at a time, whichever it is: every value here is reached
//! through [`Calls`], of which there is one, or shares its lock.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;

use vademecum_build::fem::{EngineError, Resource};

unsafe extern "C" {
    fn vp_failed_call() -> *const c_char;
    fn vp_failed_words() -> *const c_char;
    fn vp_failed_short() -> c_int;
    fn vp_start(ranks: *mut i64) -> c_int;
    fn vp_finish() -> c_int;
    fn vp_abort(code: c_int);
    fn vp_send(bytes: *const u8, length: i64, to: c_int) -> c_int;
    fn vp_receive(bytes: *mut u8, length: i64, from: c_int) -> c_int;
    fn vp_idle() -> c_int;
    fn vp_sum(numbers: *mut f64, length: i64) -> c_int;
    fn vp_agree(numbers: *mut f64, length: i64) -> c_int;
    fn vp_matrix(
        own: i64,
        total: i64,
        starts: *const i64,
        columns: *const i64,
        values: *const f64,
        made: *mut *mut c_void,
    ) -> c_int;
    fn vp_matrix_scaled(from: *const c_void, weight: f64, made: *mut *mut c_void) -> c_int;
    fn vp_matrix_held(
        from: *const c_void,
        springy: c_int,
        rows: *const i64,
        springs: *const f64,
        count: i64,
        made: *mut *mut c_void,
    ) -> c_int;
    fn vp_matrix_multiply(matrix: *mut c_void, x: *const f64, y: *mut f64, columns: i64) -> c_int;
    fn vp_matrix_multiply_closely(
        matrix: *mut c_void,
        x: *const f64,
        rows: *const i64,
        springs: *const f64,
        count: i64,
        y: *mut f64,
    ) -> c_int;
    fn vp_matrix_free(matrix: *mut c_void);
    fn vp_factor(matrix: *mut c_void, folder: *const c_char, room: i64, made: *mut *mut c_void) -> c_int;
    fn vp_factor_fill(matrix: *mut c_void, factor: *mut c_void, room: i64) -> c_int;
    fn vp_factor_says(factor: *mut c_void, of_all: c_int, which: i64, said: *mut i64) -> c_int;
    fn vp_factor_solve(
        matrix: *mut c_void,
        factor: *mut c_void,
        forces: *mut f64,
        answers: *mut f64,
        columns: i64,
    ) -> c_int;
    fn vp_factor_free(factor: *mut c_void);
    fn vp_iteration(
        matrix: *mut c_void,
        motions: *const f64,
        block: i64,
        tolerance: f64,
        made: *mut *mut c_void,
    ) -> c_int;
    fn vp_iteration_solve(
        matrix: *mut c_void,
        iteration: *mut c_void,
        forces: *const f64,
        answers: *mut f64,
        columns: i64,
    ) -> c_int;
    fn vp_iteration_free(iteration: *mut c_void);
}

/// Result of a call: nothing, or the error that the shim keeps.
fn checked(status: c_int) -> Result<(), EngineError> {
    if status == 0 {
        return Ok(());
    }
    // SAFETY: both functions return texts of static memory that end in a zero; no other thread calls the
    // shim.
    let [call, reason] = unsafe { [CStr::from_ptr(vp_failed_call()), CStr::from_ptr(vp_failed_words())] }
        .map(|text| text.to_string_lossy().into_owned());
    // SAFETY: as above; it gives a number.
    let short = (unsafe { vp_failed_short() } != 0).then_some(Resource::Memory);
    Err(EngineError { call, reason, short })
}

/// MPI and PETSc, started.
pub struct Calls {
    /// This rank, from 0.
    pub rank: usize,
    /// Number of ranks.
    pub size: usize,
    /// Those of them on this machine.
    pub near: usize,
}

impl Calls {
    /// Starts MPI and PETSc; once in a process.
    pub fn start() -> Result<Self, EngineError> {
        let mut ranks = [0; 3];
        // SAFETY: the shim writes three numbers.
        checked(unsafe { vp_start(ranks.as_mut_ptr()) })?;
        let [rank, size, near] = ranks.map(|number| number as usize);
        Ok(Self { rank, size, near })
    }

    /// Ends MPI and PETSc.
    pub fn finish(self) -> Result<(), EngineError> {
        // SAFETY: both were started, and nothing is called afterwards: `self` is gone.
        checked(unsafe { vp_finish() })
    }

    /// Ends all ranks at once.
    pub fn abort(&self, code: u8) -> ! {
        // SAFETY: MPI was started.
        unsafe { vp_abort(code.into()) };
        std::process::exit(code.into());
    }

    /// Sends bytes to another rank.
    pub fn send(&self, bytes: &[u8], to: usize) -> Result<(), EngineError> {
        // SAFETY: the shim reads so many bytes.
        checked(unsafe { vp_send(bytes.as_ptr(), bytes.len() as i64, to as c_int) })
    }

    /// Receives `bytes.len()` bytes from another rank.
    pub fn receive(&self, bytes: &mut [u8], from: usize) -> Result<(), EngineError> {
        // SAFETY: the shim writes so many bytes.
        checked(unsafe { vp_receive(bytes.as_mut_ptr(), bytes.len() as i64, from as c_int) })
    }

    /// Sleeps until the first rank sends something.
    pub fn idle(&self) -> Result<(), EngineError> {
        // SAFETY: MPI was started.
        checked(unsafe { vp_idle() })
    }

    /// Adds the numbers of all ranks up; each gets the same bits.
    pub fn sum(&self, numbers: &mut [f64]) -> Result<(), EngineError> {
        // SAFETY: the shim reads and writes so many numbers.
        checked(unsafe { vp_sum(numbers.as_mut_ptr(), numbers.len() as i64) })
    }

    /// Overwrites the numbers by those of the first rank.
    pub fn agree(&self, numbers: &mut [f64]) -> Result<(), EngineError> {
        // SAFETY: the shim reads or writes so many numbers.
        checked(unsafe { vp_agree(numbers.as_mut_ptr(), numbers.len() as i64) })
    }
}

/// Rows of a symmetric matrix that one rank holds.
pub struct Matrix {
    made: *mut c_void,
    own: usize,
    total: usize,
    entries: usize,
}

// SAFETY: the value is one of PETSc's, which belong to no thread; calls are made one at a time.
unsafe impl Send for Matrix {}

impl Matrix {
    /// Own rows one after the other, of `total`: where each starts, the columns, the values.
    pub fn new(total: usize, starts: &[i64], columns: &[i64], values: &[f64]) -> Result<Self, EngineError> {
        let own = starts.len() - 1;
        assert!(starts[own] as usize == columns.len() && columns.len() == values.len());
        let entries = values.len();
        let mut made = ptr::null_mut();
        let (starts, columns, values) = (starts.as_ptr(), columns.as_ptr(), values.as_ptr());
        // SAFETY: the shim reads `own + 1` starts and as many columns and values as the last of them says,
        // keeps no pointer to them, and writes one pointer.
        checked(unsafe { vp_matrix(own as i64, total as i64, starts, columns, values, &mut made) })?;
        Ok(Self { made, own, total, entries })
    }

    /// The matrix to factorise: the same one, which takes no more memory; or a copy with springs on the
    /// diagonal, at rows of all ranks of which this one has some.
    pub fn with_springs(&self, springs: Option<&[(i64, f64)]>) -> Result<Self, EngineError> {
        let (rows, stiffness): (Vec<i64>, Vec<f64>) = springs.into_iter().flatten().copied().unzip();
        let (springy, count) = (springs.is_some().into(), rows.len() as i64);
        let mut made = ptr::null_mut();
        let (rows, stiffness) = (rows.as_ptr(), stiffness.as_ptr());
        // SAFETY: the shim reads a matrix that it made and so many rows and springs, keeps no pointer to
        // these, and writes one pointer; what both matrices share is counted by PETSc.
        checked(unsafe { vp_matrix_held(self.made, springy, rows, stiffness, count, &mut made) })?;
        Ok(Self { made, ..*self })
    }

    /// The matrix times a number.
    pub fn scaled(&self, weight: f64) -> Result<Self, EngineError> {
        let mut made = ptr::null_mut();
        // SAFETY: the shim reads a matrix that it made and writes one pointer.
        checked(unsafe { vp_matrix_scaled(self.made, weight, &mut made) })?;
        Ok(Self { made, ..*self })
    }

    /// Entries of the own rows.
    pub fn entries(&self) -> usize {
        self.entries
    }

    /// `A x`, own rows column after column.
    pub fn multiply(&mut self, x: &[f64], columns: usize) -> Result<Vec<f64>, EngineError> {
        assert_eq!(x.len(), self.own * columns);
        let mut product = vec![0.0; x.len()];
        let to = product.as_mut_ptr();
        // SAFETY: the shim reads and writes so many columns of own rows, and keeps no pointer.
        checked(unsafe { vp_matrix_multiply(self.made, x.as_ptr(), to, columns as i64) })?;
        Ok(product)
    }
}

impl Matrix {
    /// Own rows of `(A − S) x`, each summed in extended precision; `x` has all rows, by their places. `S` are
    /// springs on own rows.
    pub fn multiply_closely(
        &mut self,
        x: &[f64],
        springs: &[(usize, f64)],
        y: &mut [f64],
    ) -> Result<(), EngineError> {
        assert!(x.len() == self.total && y.len() == self.own);
        let (rows, springs): (Vec<i64>, Vec<f64>) =
            springs.iter().map(|&(row, spring)| (row as i64, spring)).unzip();
        let (count, rows, springs) = (rows.len() as i64, rows.as_ptr(), springs.as_ptr());
        let (x, y) = (x.as_ptr(), y.as_mut_ptr());
        // SAFETY: the shim reads as many numbers as there are columns, rows and springs, writes as many as
        // there are own rows, and keeps no pointer.
        checked(unsafe { vp_matrix_multiply_closely(self.made, x, rows, springs, count, y) })
    }
}

impl Drop for Matrix {
    fn drop(&mut self) {
        // SAFETY: made by `vp_matrix` and freed once.
        unsafe { vp_matrix_free(self.made) };
    }
}

/// A factor `L D Lᵀ` by MUMPS, with the matrix it is of.
pub struct Factor {
    matrix: Matrix,
    made: *mut c_void,
}

// SAFETY: as of the matrix.
unsafe impl Send for Factor {}

impl Factor {
    /// Analyses a matrix. With a folder the factor will lie there. What is said of memory counts so much room
    /// in addition to what is needed \[%\].
    pub fn analyse(matrix: Matrix, folder: Option<&CString>, room: i64) -> Result<Self, EngineError> {
        let mut factor = Self { matrix, made: ptr::null_mut() };
        let folder = folder.map_or(ptr::null(), |folder| folder.as_ptr());
        // SAFETY: the shim reads the text to its zero, or is given none, and writes one pointer.
        checked(unsafe { vp_factor(factor.matrix.made, folder, room, &mut factor.made) })?;
        Ok(factor)
    }

    /// Fills the factor, with this much room in addition to its estimated memory \[%\].
    pub fn fill(&mut self, room: i64) -> Result<(), EngineError> {
        // SAFETY: both were made by the shim.
        checked(unsafe { vp_factor_fill(self.matrix.made, self.made, room) })
    }

    /// Status of MUMPS on this rank (`INFO`).
    pub fn info(&self, which: i64) -> Result<i64, EngineError> {
        self.asked(false, which)
    }

    /// Status of MUMPS over all ranks (`INFOG`).
    pub fn info_of_all(&self, which: i64) -> Result<i64, EngineError> {
        self.asked(true, which)
    }

    fn asked(&self, of_all: bool, which: i64) -> Result<i64, EngineError> {
        let mut said = 0;
        // SAFETY: made by the shim, which writes one number.
        checked(unsafe { vp_factor_says(self.made, of_all.into(), which, &mut said) })?;
        Ok(said)
    }

    /// The matrix.
    pub fn matrix(&mut self) -> &mut Matrix {
        &mut self.matrix
    }

    /// `A⁻¹` of forces, own rows column after column; the forces are lost.
    pub fn solve(&mut self, mut forces: Vec<f64>, columns: usize) -> Result<Vec<f64>, EngineError> {
        assert_eq!(forces.len(), self.matrix.own * columns);
        let mut answers = vec![0.0; forces.len()];
        let (from, to) = (forces.as_mut_ptr(), answers.as_mut_ptr());
        // SAFETY: the shim reads and writes so many columns of own rows, and keeps no pointer.
        checked(unsafe { vp_factor_solve(self.matrix.made, self.made, from, to, columns as i64) })?;
        Ok(answers)
    }
}

impl Drop for Factor {
    fn drop(&mut self) {
        if !self.made.is_null() {
            // SAFETY: made by `vp_factor` and freed once, before its matrix.
            unsafe { vp_factor_free(self.made) };
        }
    }
}

/// Conjugate gradients with algebraic multigrid, set up for a matrix.
pub struct Iteration {
    matrix: Matrix,
    made: *mut c_void,
}

// SAFETY: as of the matrix.
unsafe impl Send for Iteration {}

impl Iteration {
    /// Sets up for a positive definite matrix, with own rows of the six rigid motions of its body, one after
    /// the other. In `blocks`, the three dofs of a node stand together.
    pub fn new(matrix: Matrix, motions: &[f64], blocks: bool, tolerance: f64) -> Result<Self, EngineError> {
        assert_eq!(motions.len(), 6 * matrix.own);
        let mut iteration = Self { matrix, made: ptr::null_mut() };
        let (matrix, from) = (iteration.matrix.made, motions.as_ptr());
        // SAFETY: the shim reads six columns of own rows, keeps no pointer to them, and writes one pointer.
        checked(unsafe { vp_iteration(matrix, from, blocks.into(), tolerance, &mut iteration.made) })?;
        Ok(iteration)
    }

    /// The matrix.
    pub fn matrix(&mut self) -> &mut Matrix {
        &mut self.matrix
    }

    /// `A⁻¹` of forces, own rows column after column.
    pub fn solve(&mut self, forces: &[f64], columns: usize) -> Result<Vec<f64>, EngineError> {
        assert_eq!(forces.len(), self.matrix.own * columns);
        let mut answers = vec![0.0; forces.len()];
        let (from, to) = (forces.as_ptr(), answers.as_mut_ptr());
        // SAFETY: the shim reads and writes so many columns of own rows, and keeps no pointer.
        checked(unsafe { vp_iteration_solve(self.matrix.made, self.made, from, to, columns as i64) })?;
        Ok(answers)
    }
}

impl Drop for Iteration {
    fn drop(&mut self) {
        if !self.made.is_null() {
            // SAFETY: made by `vp_iteration` and freed once, before its matrix.
            unsafe { vp_iteration_free(self.made) };
        }
    }
}
