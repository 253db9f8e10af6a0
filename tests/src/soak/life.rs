//! What users do: build, run, rewrite, bring matrices of their own.

use super::dice::Dice;
use super::invariant::{Breach, Held, bounded_memory, breach, same_bytes, whole_table};
use super::launch::Launch;
use super::place::{Built, Place};
use super::texts;

/// What an iteration did, beside holding: a word that is counted.
pub type Done = Result<&'static str, Breach>;

/// A problem built twice, with one thread and with two, and played.
///
/// # Errors
/// [`Breach`].
pub fn built(place: &Place<'_>, dice: &mut Dice) -> Done {
    let Some(built) = place.build(dice)? else { return Ok("refused") };
    let keep = if built.kept { "" } else { " --keep-missed" };
    let line = format!("build p.toml -o one.vdm{keep}");
    let mut launch = Launch::new(&line.split(' ').collect::<Vec<_>>(), place.limit);
    launch.threads = 1;
    super::invariant::ended_well(&place.launch(&launch), &[0])?;
    same_bytes(
        "a build with one thread and with two",
        &place.read("one.vdm").unwrap_or_default(),
        &built.bytes,
    )?;
    place.ends("info a.vdm --json", &[0])?;
    played(place, dice, &built)
}

/// A random scenario through a file, by each structure it has.
fn played(place: &Place<'_>, dice: &mut Dice, built: &Built) -> Done {
    let steps = dice.whole(1, 200);
    let (text, rows) = texts::scenario(dice, &built.problem, steps);
    place.write("s.toml", text);
    if built.problem.canonical {
        // The chapter's axes end, and it takes no patterns: a scenario may be refused.
        let ended = place.ends("run a.vdm --scenario s.toml -o out", &[0, 3, 5, 7])?;
        return if ended.code == Some(0) { table(place, "out", rows) } else { Ok("refused") };
    }
    let structure = dice.pick(&["auto", "diagonal", "block"]);
    let line = format!("run a.vdm --scenario s.toml -o out --structure {structure}");
    let ended = place.ends(&line, if *structure == "auto" { &[0] } else { &[0, 7] })?;
    if ended.code != Some(0) { Ok("refused") } else { table(place, "out", rows) }
}

fn table(place: &Place<'_>, folder: &str, rows: usize) -> Done {
    let text = place.read(&format!("{folder}/probes.csv")).unwrap_or_default();
    whole_table(&String::from_utf8_lossy(&text), Some(rows))?;
    place.left_nothing()?;
    Ok("done")
}

/// Packed, unpacked, rounded, stripped: every file is sound, and what must be the same is the same.
///
/// # Errors
/// [`Breach`].
pub fn rewritten(place: &Place<'_>, dice: &mut Dice) -> Done {
    let Some(built) = place.build(dice)? else { return Ok("refused") };
    let (scenario, rows) = texts::scenario(dice, &built.problem, 20);
    place.write("s.toml", scenario);
    let plays = place.ends("run a.vdm --scenario s.toml -o out", &[0, 3, 5, 7])?.code == Some(0);
    let expected = place.read("out/probes.csv").unwrap_or_default();

    let level = dice.whole(1, 22);
    place.ends(&format!("pack a.vdm -o packed.vdm --level {level}"), &[0])?;
    place.ends("verify packed.vdm --file-only", &[0])?;
    place.ends("unpack packed.vdm -o raw.vdm", &[0])?;
    same_bytes("packed and unpacked", &place.read("raw.vdm").unwrap_or_default(), &built.bytes)?;
    if plays {
        place.ends("run packed.vdm --scenario s.toml -o packed", &[0])?;
        let found = place.read("packed/probes.csv").unwrap_or_default();
        same_bytes("probes of a packed file", &found, &expected)?;
    }

    let tolerance = dice.log(1e-8, 1e-1);
    rewrite(place, &format!("pack a.vdm -o rounded.vdm --tolerance {tolerance:e}"), "rounded", plays, rows)?;
    let keep = dice.pick(&["probes", "surface", "all"]);
    rewrite(place, &format!("strip a.vdm -o less.vdm --keep {keep}"), "less", false, rows)?;
    place.ends("run less.vdm --scenario s.toml -o less", &[0, 3, 7])?;
    rewrite(place, &format!("strip a.vdm -o fewer.vdm --terms-for {tolerance:e}"), "fewer", plays, rows)?;
    let first = dice.pick(&["packed", "rounded"]);
    rewrite(place, &format!("strip {first}.vdm -o both.vdm --keep surface"), "both", false, rows)?;
    place.left_nothing()?;
    Ok("done")
}

/// A rewrite that is refused by its code, or gives a sound file that plays.
fn rewrite(place: &Place<'_>, line: &str, name: &str, plays: bool, rows: usize) -> Held {
    if place.ends(line, &[0, 7])?.code != Some(0) {
        return Ok(());
    }
    place.ends(&format!("verify {name}.vdm --file-only"), &[0])?;
    if plays && place.ends(&format!("run {name}.vdm --scenario s.toml -o {name}"), &[0, 5])?.code == Some(0) {
        table(place, name, rows)?;
    }
    Ok(())
}

/// The matrices of a body as another program would bring them.
///
/// # Errors
/// [`Breach`].
pub fn own_matrices(place: &Place<'_>, dice: &mut Dice) -> Done {
    let Some(built) = place.build(dice)? else { return Ok("refused") };
    if place.ends("export matrices p.toml -o m", &[0, 3])?.code != Some(0) {
        return Ok("refused");
    }
    let modes = dice.whole(1, 4);
    let text = format!(
        "[mesh.matrices]\nmass = \"m/mass.mtx\"\nstiffness = \"m/stiffness.mtx\"\ndofs = \"m/dofs.csv\"\n\
         nodes = \"m/nodes.csv\"\ntriangles = \"m/triangles.csv\"\n[load]\n[time]\nscheme.name = \"bathe\"\nstep = {:?}\n[snapshots]\n\
         positions = 2\n[basis]\nmodes = {modes}\n[tolerance]\nfloor_ratio = 3.0\nabsolute = 1e-3\nsteps = 30\n",
        built.problem.step
    );
    place.write("own.toml", text);
    place.ends("build own.toml -o own.vdm --keep-missed", &[0])?;
    place.ends("verify own.vdm --file-only", &[0])?;
    place.left_nothing()?;
    Ok("done")
}

/// A long run takes no more memory than a short one.
///
/// # Errors
/// [`Breach`].
pub fn long_run(place: &Place<'_>, dice: &mut Dice) -> Done {
    let Some(built) = place.build(dice)? else { return Ok("refused") };
    if built.problem.canonical {
        return Ok("refused");
    }
    let peak = |steps: usize| -> Result<u64, Breach> {
        place.write("s.toml", format!("duration = {:?}\n", steps as f64 * built.problem.step));
        let ended = place.ends("run a.vdm --scenario s.toml -o out", &[0])?;
        table(place, "out", steps + 1)?;
        Ok(ended.peak_kib)
    };
    // A short run may end before its memory has been looked at once it was loaded.
    let short = peak(20_000)?.max(peak(20_000)?).max(peak(20_000)?);
    let long = peak(400_000)?;
    if short == 0 {
        return breach("bounded memory", "the system does not tell how much memory a run takes");
    }
    bounded_memory(short, long)?;
    Ok("done")
}
