//! Compiles the shim to PETSc and MPI, where the feature `petsc` asks for it.

fn main() {
    println!("cargo::rerun-if-changed=src/shim.c");
    #[cfg(feature = "petsc")]
    shim();
}

/// Finds PETSc and MPI by pkg-config, whatever MPI it is, and compiles the shim against their headers.
#[cfg(feature = "petsc")]
fn shim() {
    let mut build = cc::Build::new();
    build.file("src/shim.c").warnings(true);
    let petsc = find(&["PETSc", "petsc"], "PETSc (on Debian: libpetsc-real-dev)");
    let mpi = find(&["mpi-c", "ompi-c", "mpich", "mpi"], "MPI (on Debian: libopenmpi-dev)");
    for path in petsc.include_paths.iter().chain(&mpi.include_paths) {
        build.include(path);
    }
    build.compile("vademecum_petsc_shim");
    // Libraries are named after the archive that needs them.
    let names = petsc.libs.iter().chain(&mpi.libs);
    names.for_each(|name| println!("cargo::rustc-link-lib={name}"));
}

/// The first of these packages that pkg-config knows.
#[cfg(feature = "petsc")]
fn find(names: &[&str], what: &str) -> pkg_config::Library {
    let mut said = String::new();
    for name in names {
        match pkg_config::Config::new().cargo_metadata(true).probe(name) {
            Ok(library) => return library,
            Err(error) => said = error.to_string(),
        }
    }
    panic!("the feature `petsc` needs {what}, and pkg-config knows none of {names:?}:\n{said}");
}
