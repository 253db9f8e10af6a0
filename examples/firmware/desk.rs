//! What the firmware does, on a desk: the same loop over the same file in single precision, from which
//! `check` takes the lines that the firmware must print.
//!
//! `firmware_on_a_desk FILE.vdm contacts.txt`; with `places` as a third argument it prints instead, for each
//! line of the contacts, its tick, where its node is in m, and its force in N.

use std::error::Error;

use vademecum_eval::format::{File, SectionKind};
use vademecum_eval::{Body, BodyOptions, Field, Place};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, path, contacts, rest @ ..] = &arguments[..] else {
        return Err("expected a vademecum file and a file of contacts".into());
    };
    let bytes = std::fs::read(path)?;
    let file = File::parse(&bytes)?;
    let mut touches = vec![];
    for line in std::fs::read_to_string(contacts)?.lines() {
        let numbers: Vec<i32> = line.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        let [tick, node, force @ ..] = &numbers[..] else {
            return Err(format!("{line}: expected TICK NODE FX FY FZ").into());
        };
        let force: [i32; 3] = force.try_into()?;
        touches.push((u32::try_from(*tick)?, u32::try_from(*node)?, force.map(|f| f64::from(f) / 1000.0)));
    }
    if !rest.is_empty() {
        let at = file.section(SectionKind::NodeCoordinates).ok_or("no coordinates")?.numbers()?;
        for (tick, node, [fx, fy, fz]) in touches {
            let [x, y, z] = [0, 1, 2].map(|i| at.get(3 * node as usize + i).unwrap_or(f64::NAN));
            println!("{tick} {x} {y} {z} {fx} {fy} {fz}");
        }
        return Ok(());
    }

    let options = BodyOptions::default();
    let mut memory = vec![0.0; Body::<f32>::len_for(&file, &options)?];
    let mut body = Body::<f32>::bind(&file, &options, &mut memory)?;
    for tick in 0..1000 {
        for &(_, node, force) in touches.iter().filter(|&&(at, ..)| at == tick) {
            body.clear();
            if force != [0.0; 3] {
                body.push(&Place::node(node), force)?;
            }
        }
        body.step()?;
        let step = tick + 1;
        for probe in (0..file.metadata().n_probes as usize).filter(|_| step % 50 == 0) {
            let moved = body.probe(probe, Field::Displacement)?;
            let speed = body.probe(probe, Field::Velocity)?;
            println!("step {step} probe {probe} moved {} speed {}", shown(moved), shown(speed));
        }
    }
    Ok(())
}

/// A value as its bits, and cut to nm or nm/s.
fn shown(value: f64) -> String {
    let sign = if value < 0.0 { "-" } else { "" };
    format!("{:016x} = {sign}{} e-9", value.to_bits(), (value.abs() * 1e9) as u64)
}
