//! Writes the golden files into `fixtures/golden`: `cargo run --release -p vademecum-tests --example golden`.
//! What it changes is a change of the format, or of the numbers in `tests/src/golden.rs`.

use vademecum_build::store::write_atomic;
use vademecum_tests::program::repository;

fn main() -> std::io::Result<()> {
    let folder = repository().join("fixtures/golden");
    std::fs::create_dir_all(&folder)?;
    for (name, bytes) in vademecum_tests::golden::all() {
        write_atomic(&folder.join(name), &bytes)?;
        println!("{name}: {} bytes", bytes.len());
    }
    Ok(())
}
