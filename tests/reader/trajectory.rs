//! What the evaluator makes of vademecum files, in full precision: for each file and each structure it has, at
//! several values of its parameters, a march of 240 steps under loads that begin and end, as a line of JSON.
//! `tests/reader/check` compares them with a reader made from `formats/vademecum-1.md` alone.
//!
//! `cargo run --release -p vademecum-tests --example trajectory -- FILE... > trajectories`

use std::io::Write;

use serde_json::{Value, json};
use vademecum_eval::chapter::{ChapterLoads, ChapterScene, ChapterState};
use vademecum_eval::{
    BindError, Contact, Field, Loads, Scene, SceneOptions, State, Structure, StructureChoice,
};
use vademecum_format::{Chapter, ChapterAxis, ChapterRole, File, Metadata, SectionKind};
use vademecum_rewrite::unpack;
use vademecum_tests::stage::{with_chapter, with_scene};

const STEPS: usize = 240;
const LIMIT: u64 = 1 << 24;

/// What pushes: a contact or a pattern.
enum Push {
    Contact(Contact),
    Pattern(usize),
}

/// A push, and its amplitude as a function of time in steps.
struct Load {
    push: Push,
    amplitude: fn(f64) -> f64,
    /// First step under the load, and first step without it.
    during: [usize; 2],
}

impl Load {
    fn amplitudes(&self, step: usize, instants: &[f64; 4]) -> Option<[f64; 4]> {
        (self.during[0]..self.during[1])
            .contains(&step)
            .then(|| instants.map(|c| (self.amplitude)(step as f64 + c)))
    }

    fn describe(&self, instants: &[f64; 4]) -> Value {
        let amplitudes: Vec<_> = (0..STEPS).map(|step| self.amplitudes(step, instants)).collect();
        match &self.push {
            Push::Pattern(index) => json!({ "pattern": index, "amplitudes": amplitudes }),
            Push::Contact(Contact { nodes, weights, force }) => {
                json!({ "nodes": nodes, "weights": weights, "force": force, "amplitudes": amplitudes })
            }
        }
    }
}

fn held(_: f64) -> f64 {
    1.0
}

fn swelling(t: f64) -> f64 {
    0.02 * t - 0.3
}

/// The loads a file can take.
fn loads_of(metadata: &Metadata<'_>, chapter: Option<&Chapter<'_>>, surface: bool) -> Vec<Load> {
    let mut loads = Vec::new();
    if let Some(chapter) = chapter {
        let positions = chapter.positions().filter(|_| surface);
        for ((node, during), amplitude) in
            positions.zip([[0, 60], [90, 150]]).zip([held as fn(f64) -> f64, |t| 1.0 - 0.004 * t])
        {
            let force = chapter.direction().unwrap_or([0.36, -0.48, 0.8]).map(|x| 2.5 * x);
            let push = Push::Contact(Contact { nodes: [node; 3], weights: [1.0, 0.0, 0.0], force });
            loads.push(Load { push, amplitude, during });
        }
        return loads;
    }
    if surface && metadata.n_load_nodes > 0 {
        let last = metadata.n_load_nodes - 1;
        let contact = |weights, force| Push::Contact(Contact { nodes: [0, last / 2, last], weights, force });
        let slanted = contact([0.2, 0.5, 0.3], [1.0, -2.0, 0.5]);
        loads.push(Load { push: slanted, amplitude: held, during: [0, 60] });
        let other = contact([0.6, 0.1, 0.3], [-0.7, 0.4, 1.5]);
        loads.push(Load { push: other, amplitude: swelling, during: [20, 90] });
    }
    for index in 0..metadata.n_patterns as usize {
        let push = Push::Pattern(index);
        loads.push(Load { push, amplitude: |t| 1.0 - 0.01 * t, during: [30, 70] });
    }
    loads
}

/// The march of a scene of either crate path: their types differ, their methods do not.
macro_rules! march {
    ($name:ident, $scene:ty, $state:ty, $loads:ty, |$s:ident, $l:ident, $index:ident, $p:ident| $pattern:expr) => {
        fn $name(
            $s: &$scene,
            state: &mut $state,
            $l: &mut $loads,
            metadata: &Metadata<'_>,
            pushes: &[Load],
            start: &[Vec<f64>; 2],
            nodes: &[usize],
        ) -> Value {
            let instants = $s.instants();
            let mut rows = Vec::new();
            for step in 0..STEPS {
                $l.clear();
                for load in pushes {
                    let Some($p) = load.amplitudes(step, &instants) else { continue };
                    match &load.push {
                        Push::Contact(contact) => {
                            $l.add_contact_staged($s, contact, &$p).expect("a contact");
                        }
                        &Push::Pattern($index) => $pattern,
                    }
                }
                if step == 0 {
                    $s.set(state, &start[0], &start[1], $l).expect("a state");
                }
                // The chapter's structure ends a march that leaves an axis; the rows then end before.
                if $s.step(state, $l).is_err() {
                    break;
                }
                let fields = [Field::Displacement, Field::Velocity];
                let probes = fields.map(|field| {
                    let probe = |i| $s.probe(state, i, field).expect("a probe");
                    (0..metadata.n_probes as usize).map(probe).collect::<Vec<f64>>()
                });
                let moved = |&node: &usize| $s.node(state, node, Field::Displacement).expect("a node");
                rows.push(json!({
                    "state": [state.zeta(), state.scaled_velocity(), state.scaled_acceleration()],
                    "probes": probes,
                    "nodes": nodes.iter().map(moved).collect::<Vec<_>>(),
                    "energy": $s.energy(state).expect("an energy"),
                }));
            }
            Value::Array(rows)
        }
    };
}

march!(march, Scene<'_, f64>, State<'_, f64>, Loads<'_, f64>, |scene, loads, index, p| {
    loads.add_pattern_staged(scene, index, &p).expect("a pattern");
});
march!(march_chapter, ChapterScene<'_, f64>, ChapterState<'_, f64>, ChapterLoads<'_, f64>, |s, l, i, p| {
    let _ = (i, p);
    unreachable!("the chapter's structure takes contacts only")
});

/// Where a file is stepped: values of its parameters, and what the diagonal structure may set beside them.
fn settings(metadata: &Metadata<'_>, structure: Structure) -> Vec<(Value, SceneOptions)> {
    let parameters = metadata.active_parameters();
    let shares: [fn(usize) -> f64; 5] = [
        |_| 0.0,
        |_| 1.0,
        |_| 0.5,
        |i| if i % 2 == 0 { 0.3 } else { 0.8 },
        |i| if i % 2 == 0 { 1.0 } else { 0.0 },
    ];
    let mut found = vec![(json!({}), SceneOptions::default())];
    for share in shares.iter().filter(|_| !parameters.is_empty()) {
        let (mut options, mut named) = (SceneOptions::default(), serde_json::Map::new());
        for (i, parameter) in parameters.iter().enumerate() {
            let (a, b) = (parameter.lower, parameter.upper);
            let value = if parameter.log { a * (b / a).powf(share(i)) } else { a + (b - a) * share(i) };
            options.set(metadata, i, value.clamp(a, b)).expect("a value in its range");
            named.insert(parameter.name.to_string(), json!(value.clamp(a, b)));
        }
        found.push((json!({ "parameters": named }), options));
    }
    if structure == Structure::Diagonal {
        let options = SceneOptions {
            time_step: Some(1.7 * metadata.time_step),
            stiffness: 1.3,
            density: 0.8,
            alpha: Some(0.9),
            beta: Some(3e-6),
            ..SceneOptions::default()
        };
        let scales =
            json!({ "dt": options.time_step, "stiffness": 1.3, "density": 0.8, "alpha": 0.9, "beta": 3e-6 });
        found.push((json!({ "scales": scales }), options));
    }
    found
}

/// From rest, and from a state that moves with coordinates up to `size`.
fn starts(metadata: &Metadata<'_>, size: f64) -> [[Vec<f64>; 2]; 2] {
    let r = metadata.n_modes as usize;
    let moving = |size: f64| (0..r).map(|k| size * (1.0 - 0.4 * k as f64) / (1 + k * k) as f64).collect();
    [[vec![0.0; r], vec![0.0; r]], [moving(size), moving(-0.02 * size / metadata.time_step)]]
}

fn march_file(name: &str, bytes: &[u8], out: &mut impl Write) {
    let raw = unpack(bytes, LIMIT).expect("unpacked");
    let file = File::parse(&raw).expect("a file");
    let metadata = *file.metadata();
    let chapter = Chapter::read(&file).expect("sound tables");
    let has = |kind| file.section(kind).is_some();
    let pushes = loads_of(&metadata, chapter.as_ref(), has(SectionKind::SurfaceBasis));
    let mut nodes = Vec::new();
    if has(SectionKind::SurfaceBasis) {
        nodes.push(0);
    }
    if has(SectionKind::InteriorBasis) && metadata.n_nodes > metadata.n_surface_nodes {
        nodes.push(metadata.n_nodes as usize - 1);
    }
    let mut write = |structure: &str,
                     setting: &Value,
                     start: &[Vec<f64>; 2],
                     instants: [f64; 4],
                     rows: Value| {
        let loads: Vec<_> = pushes.iter().map(|load| load.describe(&instants)).collect();
        let line = json!({ "file": name, "structure": structure, "setting": setting, "start": start, "steps": STEPS,
            "instants": instants, "loads": loads, "nodes": nodes, "rows": rows });
        writeln!(out, "{line}").expect("written");
    };
    if let Some(chapter) = &chapter {
        // A state that fills its axes, as far as it goes: what is small beside them is rounded like them.
        let reach = |axis: ChapterAxis| axis.lower.abs().min(axis.upper.abs()) / axis.factor;
        let zeta = |axis: &ChapterAxis| matches!(axis.role, ChapterRole::State { family: 0, .. });
        let reaches = chapter.parts().flat_map(|part| part.axes().filter(zeta).map(reach));
        for start in starts(&metadata, 0.2 * reaches.fold(f64::INFINITY, f64::min)) {
            with_chapter::<f64, _>(&raw, |scene, state, loads| {
                let rows = march_chapter(scene, state, loads, &metadata, &pushes, &start, &nodes);
                write("canonical", &json!({}), &start, scene.instants(), rows);
            });
        }
    }
    let present = [
        (StructureChoice::Diagonal, Structure::Diagonal, "diagonal", metadata.diagonal),
        (StructureChoice::Block, Structure::Block, "block", metadata.block),
    ];
    for (choice, structure, word, _) in present.into_iter().filter(|s| s.3) {
        for (setting, options) in settings(&metadata, structure) {
            let options = SceneOptions { structure: choice, ..options };
            if let Some(refusal) = refusal(&file, &options) {
                write(word, &setting, &starts(&metadata, 0.0)[0], [0.0; 4], json!({ "refused": refusal }));
                continue;
            }
            for start in starts(&metadata, 1e-6) {
                with_scene::<f64, _>(&raw, &options, |scene, state, loads| {
                    let rows = march(scene, state, loads, &metadata, &pushes, &start, &nodes);
                    write(word, &setting, &start, scene.instants(), rows);
                });
            }
        }
    }
}

/// The axis that a scene leaves, counted from 0.
fn refusal(file: &File<'_>, options: &SceneOptions) -> Option<usize> {
    let sizes = Scene::<f64>::sizes(file, options).expect("options");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    match Scene::bind(file, options, &mut memory, &mut work) {
        Ok(_) => None,
        Err(BindError::OutsideAxis { axis, .. }) => Some(axis),
        Err(other) => panic!("{other}"),
    }
}

fn main() {
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    for path in std::env::args().skip(1) {
        let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
        march_file(&path, &bytes, &mut out);
    }
}
