//! Writes the hostile files into `fixtures/hostile`:
//! `cargo run --release -p vademecum-tests --example hostile`.

use vademecum_build::store::write_atomic;
use vademecum_tests::program::repository;

fn main() -> std::io::Result<()> {
    let folder = repository().join("fixtures/hostile");
    std::fs::create_dir_all(&folder)?;
    for (name, bytes) in vademecum_tests::hostile::all() {
        write_atomic(&folder.join(&name), &bytes)?;
        println!("{name}: {} bytes", bytes.len());
    }
    Ok(())
}
