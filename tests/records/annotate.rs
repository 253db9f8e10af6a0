//! Prints the annotated bytes of `formats/vademecum-1.md`:
//! `cargo run --release -p vademecum-tests --example annotate`.

fn main() {
    print!("{}", vademecum_tests::annotate::annotate(&vademecum_tests::annotate::smallest()));
}
