//! Whether ranks refuse a stiffness that is not positive definite, and tell how many pivots are negative:
//! `mpirun -n 2 indefinite`, of a cube whose last front is large enough to be shared by all ranks.
//!
//! By Sylvester's law `K − σM` has as many negative pivots as there are natural frequencies below `√σ`.

use std::sync::Arc;

use vademecum_build::dynamics::lowest_modes;
use vademecum_build::fem::{Engine, FactorError, Material, Model, Symbolic};
use vademecum_build::mesh::{Order, block};
use vademecum_petsc::{Options, run};

/// Frequencies that lie below the shift.
const BELOW: usize = 3;

/// The pivots that one process and all ranks count, or what else they say.
fn refusal(engine: &Arc<dyn Engine>) -> Result<(), String> {
    let mesh = block([1.0; 3], [8; 3], Order::Quadratic);
    let held: Vec<bool> = mesh.nodes.iter().flat_map(|node| [node[0] == 0.0; 3]).collect();
    let steel = Material::isotropic(2.1e11, 0.3, 7800.0);
    let model = Model::assemble(mesh, &[steel], &held).map_err(|error| error.to_string())?;
    let (pencil, n) = (model.pencil(), model.pencil().n_dof());
    let symbolic = Symbolic::analyze(pencil).map_err(|error| error.to_string())?;
    let modes = lowest_modes(pencil, &symbolic, BELOW + 1).map_err(|error| error.to_string())?;
    let shift = 0.5 * (modes.eigenvalues[BELOW - 1] + modes.eigenvalues[BELOW]);
    let on_ranks = symbolic.on(Some(engine.clone()), || model.rigid_motions());
    match on_ranks.factor_of(&pencil.combine(-shift, 1.0)) {
        Err(FactorError::NotPositiveDefinite { pivot, .. }) if pivot == n - BELOW => {}
        other => return Err(format!("expected {BELOW} negative pivots of {n}; found {:?}", other.err())),
    }
    on_ranks.factor_of(pencil.stiffness()).map_err(|error| format!("the stiffness itself: {error}"))?;
    println!("{n} dofs on {} ranks: {BELOW} negative pivots", engine.ranks());
    Ok(())
}

fn main() {
    let tell = |refused: &Result<(), String>| match refused {
        Ok(()) => 0,
        Err(reason) => {
            eprintln!("error: {reason}");
            1
        }
    };
    match run(&Options::default(), refusal, tell) {
        Ok(done) => std::process::exit(done.as_ref().map_or(0, tell).into()),
        Err(error) => panic!("{error}"),
    }
}
