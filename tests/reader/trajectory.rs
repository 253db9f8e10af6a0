//! What the evaluator makes of vademecum files, in full precision: for each file and each structure it has,
//! at several values of its parameters, a march of 240 steps under loads that begin and end, as a line of
//! JSON.
//! `tests/reader/check` compares them with a reader made from `formats/vademecum-1.md` alone.
//!
//! `cargo run --release -p vademecum-tests --example trajectory -- FILE... > trajectories`

use std::io::Write;

use serde_json::{Value, json};
use vademecum_chapter::{ChapterLoads, ChapterScene, ChapterState};
use vademecum_eval::{
    BindError, Contact, Field, Loads, Place, Scene, SceneOptions, State, Structure, StructureChoice, Surface,
};
use vademecum_format::{Chapter, ChapterAxis, ChapterRole, File, Metadata, SectionKind};
use vademecum_rewrite::unpack;
use vademecum_tests::stage::with_chapter;

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
            Push::Contact(Contact { place, force, .. }) => {
                json!({ "nodes": place.nodes(), "weights": place.weights(), "force": force, "amplitudes": amplitudes })
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
fn loads_of(
    metadata: &Metadata<'_>,
    chapter: Option<&Chapter<'_>>,
    surface: bool,
    inside: Option<Place>,
) -> Vec<Load> {
    let mut loads = Vec::new();
    if let Some(chapter) = chapter {
        let positions: Vec<u32> = chapter.positions().filter(|_| surface).collect();
        let (Some(&first), Some(&last)) = (positions.first(), positions.last()) else { return loads };
        let force = chapter.direction().unwrap_or([0.36, -0.48, 0.8]).map(|x| 2.5 * x);
        // Terms over state and load know one load at one node.
        let joint = chapter.parts().any(|part| part.has_state() && part.has_load());
        let weights = if joint { [1.0, 0.0, 0.0] } else { [0.25, 0.75, 0.0] };
        let late = Contact::new(Place::triangle([last, first, first], weights), force);
        let early = Contact::new(Place::triangle([first; 3], [1.0, 0.0, 0.0]), force);
        // It is there for ten steps before it pushes.
        let growing: fn(f64) -> f64 = |t| (0.05 * (t - 10.0)).clamp(0.0, 1.0);
        loads.push(Load { push: Push::Contact(early), amplitude: growing, during: [0, 60] });
        loads.push(Load { push: Push::Contact(late), amplitude: |t| 1.0 - 0.004 * t, during: [90, 150] });
        return loads;
    }
    if surface && metadata.n_load_nodes > 0 {
        let last = metadata.n_load_nodes - 1;
        let contact = |weights, force| {
            Push::Contact(Contact::new(Place::triangle([0, last / 2, last], weights), force))
        };
        let slanted = contact([0.2, 0.5, 0.3], [1.0, -2.0, 0.5]);
        loads.push(Load { push: slanted, amplitude: held, during: [0, 60] });
        let other = contact([0.6, 0.1, 0.3], [-0.7, 0.4, 1.5]);
        loads.push(Load { push: other, amplitude: swelling, during: [20, 90] });
    }
    if let Some(place) = inside {
        let contact = Contact::new(place, [0.3, 1.1, -0.9]);
        loads.push(Load { push: Push::Contact(contact), amplitude: swelling, during: [10, 100] });
    }
    for index in 0..metadata.n_patterns as usize {
        let push = Push::Pattern(index);
        loads.push(Load { push, amplitude: |t| 1.0 - 0.01 * t, during: [30, 70] });
    }
    loads
}

/// A scene with its state and its loads: the two kinds of scene have types of their own.
trait Body {
    fn instants(&self) -> [f64; 4];
    fn clear(&mut self);
    fn push(&mut self, push: &Push, amplitudes: &[f64; 4]);
    fn set(&mut self, zeta: &[f64], rate: &[f64]);
    /// Whether the step was taken.
    fn step(&mut self) -> bool;
    /// Displacement, velocity and acceleration, the last empty where the structure has none.
    fn state(&self) -> [&[f64]; 3];
    fn probe(&self, index: usize, field: Field) -> f64;
    fn node(&self, node: usize) -> [f64; 3];
    fn energy(&self) -> f64;
    /// Force and moment of each support.
    fn reactions(&self) -> Vec<[f64; 6]>;
    /// Stress and strain at each point.
    fn tensors(&self) -> [Vec<[f64; 6]>; 2];
    /// Moves to the parameters of the second half.
    fn change(&mut self);
}

struct Ours<'a, 'm> {
    scene: &'a mut Scene<'m, f64>,
    state: State<'a, f64>,
    loads: Loads<'a, f64>,
    work: &'a mut [f64],
    then: Option<SceneOptions>,
}

struct Chapters<'a, 'm> {
    scene: &'a ChapterScene<'m>,
    state: &'a mut ChapterState,
    loads: &'a mut ChapterLoads,
}

impl Body for Ours<'_, '_> {
    fn instants(&self) -> [f64; 4] {
        self.scene.instants()
    }

    fn clear(&mut self) {
        self.loads.clear();
    }

    fn push(&mut self, push: &Push, amplitudes: &[f64; 4]) {
        match push {
            Push::Contact(contact) => self.loads.add_contact_staged(self.scene, contact, amplitudes),
            Push::Pattern(index) => self.loads.add_pattern_staged(self.scene, *index, amplitudes),
        }
        .expect("a load");
    }

    fn set(&mut self, zeta: &[f64], rate: &[f64]) {
        self.scene.set(&mut self.state, zeta, rate, &self.loads).expect("a state");
    }

    fn step(&mut self) -> bool {
        self.scene.step(&mut self.state, &self.loads).expect("a step");
        true
    }

    fn state(&self) -> [&[f64]; 3] {
        [self.state.zeta(), self.state.scaled_velocity(), self.state.scaled_acceleration()]
    }

    fn probe(&self, index: usize, field: Field) -> f64 {
        self.scene.probe(&self.state, index, field).expect("a probe")
    }

    fn node(&self, node: usize) -> [f64; 3] {
        self.scene.node(&self.state, node, Field::Displacement).expect("a node")
    }

    fn energy(&self) -> f64 {
        self.scene.energy(&self.state).expect("an energy")
    }

    fn reactions(&self) -> Vec<[f64; 6]> {
        let all = 0..self.scene.n_supports();
        all.map(|s| self.scene.reaction(&self.state, s).expect("a reaction").total()).collect()
    }

    fn tensors(&self) -> [Vec<[f64; 6]>; 2] {
        let all = 0..self.scene.n_stress_points();
        let stress = |point| self.scene.stress(&self.state, point).expect("a stress").0;
        let strain = |point| self.scene.strain(&self.state, point).expect("a strain").0;
        [all.clone().map(stress).collect(), all.map(strain).collect()]
    }

    fn change(&mut self) {
        if let Some(then) = &self.then {
            self.scene.rebind(then, self.work).expect("bound anew");
            self.state.carry(self.scene).expect("carried");
        }
    }
}

impl Body for Chapters<'_, '_> {
    fn instants(&self) -> [f64; 4] {
        self.scene.instants()
    }

    fn clear(&mut self) {
        self.loads.clear();
    }

    fn push(&mut self, push: &Push, amplitudes: &[f64; 4]) {
        let Push::Contact(contact) = push else { panic!("the chapter's structure takes no pattern") };
        self.loads.add_contact_staged(self.scene, contact, amplitudes).expect("a contact");
    }

    fn set(&mut self, zeta: &[f64], rate: &[f64]) {
        self.scene.set(self.state, zeta, rate, self.loads).expect("a state");
    }

    fn step(&mut self) -> bool {
        self.scene.step(self.state, self.loads).is_ok()
    }

    fn state(&self) -> [&[f64]; 3] {
        [self.state.zeta(), self.state.scaled_velocity(), self.state.scaled_acceleration()]
    }

    fn probe(&self, index: usize, field: Field) -> f64 {
        self.scene.probe(self.state, index, field).expect("a probe")
    }

    fn node(&self, node: usize) -> [f64; 3] {
        self.scene.node(self.state, node, Field::Displacement).expect("a node")
    }

    fn energy(&self) -> f64 {
        self.scene.energy(self.state).expect("an energy")
    }

    fn reactions(&self) -> Vec<[f64; 6]> {
        vec![]
    }

    fn tensors(&self) -> [Vec<[f64; 6]>; 2] {
        [vec![], vec![]]
    }

    fn change(&mut self) {}
}

/// What every march has in common.
struct March<'a> {
    metadata: &'a Metadata<'a>,
    pushes: &'a [Load],
    nodes: &'a [usize],
}

impl March<'_> {
    fn rows(&self, body: &mut dyn Body, start: &[Vec<f64>; 2]) -> Value {
        let instants = body.instants();
        let mut rows = Vec::new();
        for step in 0..STEPS {
            if step == STEPS / 2 {
                body.change();
            }
            body.clear();
            for load in self.pushes {
                if let Some(amplitudes) = load.amplitudes(step, &instants) {
                    body.push(&load.push, &amplitudes);
                }
            }
            if step == 0 {
                body.set(&start[0], &start[1]);
            }
            // The chapter's structure ends a march that leaves an axis; the rows then end before.
            if !body.step() {
                break;
            }
            let probes = [Field::Displacement, Field::Velocity].map(|field| {
                let count = self.metadata.n_probes as usize;
                (0..count).map(|index| body.probe(index, field)).collect::<Vec<f64>>()
            });
            let [stress, strain] = body.tensors();
            rows.push(json!({
                "state": body.state().into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>(),
                "probes": probes,
                "nodes": self.nodes.iter().map(|&node| body.node(node)).collect::<Vec<_>>(),
                "energy": body.energy(),
                "reactions": body.reactions(),
                "stress": stress,
                "strain": strain,
            }));
        }
        Value::Array(rows)
    }
}

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
            options.set(metadata, &[(i, value.clamp(a, b))]).expect("a value in its range");
            named.insert(parameter.name.to_string(), json!(value.clamp(a, b)));
        }
        found.push((json!({ "parameters": named }), options));
    }
    if structure != Structure::Block {
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
    if structure == Structure::Strain {
        let options = SceneOptions { substeps: Some(3), viscosity: 0.25, ..SceneOptions::default() };
        found.push((json!({ "scales": { "substeps": 3, "viscosity": 0.25 } }), options));
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
    let surface = has(SectionKind::SurfaceBasis);
    // Where there is a residual flexibility, a contact inside of a triangle is wanted, whose nodes have
    // pairs.
    let triangle = loadable_triangle(&file).filter(|_| surface && has(SectionKind::ContactResidual));
    let pushes = loads_of(&metadata, chapter.as_ref(), surface, triangle.map(|nodes| inside(&file, nodes)));
    let mut nodes = Vec::new();
    if surface {
        nodes.push(0);
    }
    if let Some(triangle) = triangle {
        nodes.extend(triangle.map(|node| node as usize));
        nodes.push(metadata.n_load_nodes as usize - 1);
        nodes.push(metadata.n_surface_nodes as usize - 1);
    }
    if has(SectionKind::InteriorBasis) && metadata.n_nodes > metadata.n_surface_nodes {
        nodes.push(metadata.n_nodes as usize - 1);
    }
    let mut write = |structure: &str,
                     settings: &Value,
                     start: &[Vec<f64>; 2],
                     instants: [f64; 4],
                     rows: Value| {
        let loads: Vec<_> = pushes.iter().map(|load| load.describe(&instants)).collect();
        let line = json!({ "file": name, "structure": structure, "settings": settings,
            "start": start, "steps": STEPS, "instants": instants, "loads": loads, "nodes": nodes, "rows": rows });
        writeln!(out, "{line}").expect("written");
    };
    let march = March { metadata: &metadata, pushes: &pushes, nodes: &nodes };
    if let Some(chapter) = &chapter {
        // A state that fills its axes, as far as it goes: what is small beside them is rounded like them.
        let reach = |axis: ChapterAxis| axis.lower.abs().min(axis.upper.abs()) / axis.factor;
        let zeta = |axis: &ChapterAxis| matches!(axis.role, ChapterRole::State { family: 0, .. });
        let reaches = chapter.parts().flat_map(|part| part.axes().filter(zeta).map(reach));
        for start in starts(&metadata, 0.2 * reaches.fold(f64::INFINITY, f64::min)) {
            with_chapter(&raw, |scene, state, loads| {
                let instants = scene.instants();
                let rows = march.rows(&mut Chapters { scene, state, loads }, &start);
                write("canonical", &json!([{}]), &start, instants, rows);
            });
        }
    }
    let stages = !metadata.scheme.is_exact();
    let present = [
        (StructureChoice::Diagonal, Structure::Diagonal, "diagonal", metadata.diagonal && stages),
        (StructureChoice::Exact, Structure::Exact, "exact", metadata.diagonal),
        (StructureChoice::Block, Structure::Block, "block", metadata.block),
        (StructureChoice::Strain, Structure::Strain, "strain", has(SectionKind::StrainSizes)),
    ];
    for (choice, structure, word, _) in present.into_iter().filter(|s| s.3) {
        let mut bound = vec![];
        for (setting, options) in settings(&metadata, structure) {
            let options = SceneOptions { structure: choice, ..options };
            match refusal(&file, &options) {
                Some(axis) => {
                    let rest = &starts(&metadata, 0.0)[0];
                    write(word, &json!([setting]), rest, [0.0; 4], json!({ "refused": axis }));
                }
                None => bound.push((setting, options)),
            }
        }
        // Large enough for the quadratic part of the strain.
        let size = if structure == Structure::Strain { 0.1 } else { 1e-6 };
        // Every setting from beginning to end, and each with the next one in the second half.
        for (index, (setting, options)) in bound.iter().enumerate() {
            for start in starts(&metadata, size) {
                let (rows, instants) = march_scene(&file, &march, options, None, &start);
                write(word, &json!([setting]), &start, instants, rows);
            }
            let (next, then) = &bound[(index + 1) % bound.len()];
            let start = &starts(&metadata, size)[1];
            let (rows, instants) = march_scene(&file, &march, options, Some(*then), start);
            write(word, &json!([setting, next]), start, instants, rows);
        }
    }
}

fn march_scene(
    file: &File<'_>,
    march: &March<'_>,
    options: &SceneOptions,
    then: Option<SceneOptions>,
    start: &[Vec<f64>; 2],
) -> (Value, [f64; 4]) {
    let sizes = Scene::<f64>::sizes(file, options).expect("options");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let mut scene = Scene::bind(file, options, &mut memory, &mut work).expect("bound");
    let state = State::new(&scene, &mut state).expect("state memory");
    let loads = Loads::new(&scene, &mut loads).expect("load memory");
    let instants = scene.instants();
    let mut body = Ours { scene: &mut scene, state, loads, work: &mut work, then };
    (march.rows(&mut body, start), instants)
}

/// Nodes of the first loadable triangle.
fn loadable_triangle(file: &File<'_>) -> Option<[u32; 3]> {
    let triangles = file.section(SectionKind::Triangles)?.u32s().ok()?;
    let first = triangles.as_chunks::<3>().0.first().filter(|_| file.metadata().n_load_triangles > 0)?;
    Some(first.map(u32::from_le_bytes))
}

/// A point inside of a triangle, shared over the nodes of the triangle, or of the quadrangle that it is part
/// of.
fn inside(file: &File<'_>, nodes: [u32; 3]) -> Place {
    const WEIGHTS: [f64; 3] = [0.5, 0.3, 0.2];
    if file.section(SectionKind::Quadrangles).is_none() {
        return Place::triangle(nodes, WEIGHTS);
    }
    let coordinates = file.section(SectionKind::NodeCoordinates).expect("nodes").numbers().expect("raw");
    let at = |c: usize| {
        let of_node = |(node, weight)| weight * coordinates.get(3 * node as usize + c).expect("a node");
        nodes.into_iter().zip(WEIGHTS).map(of_node).sum()
    };
    let point = std::array::from_fn(at);
    Surface::new(file).expect("a surface").locate(point).expect("a point").place
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
