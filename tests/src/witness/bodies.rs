//! The witnesses: geometry, reference values and where they are from (`docs/reference/bibliography.md`).

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4, FRAC_PI_6, TAU};

use vademecum_build::mesh::{ElementKind, ElementKinds, Hexahedra, Mesh, Order, Region, block};

use super::thermal::Thermal;

/// A reference value of a natural mode.
#[derive(Clone, Copy, Debug)]
pub struct Mode {
    /// Its number among the modes computed, from 0.
    pub number: usize,
    /// Frequency \[Hz\].
    pub hz: f64,
}

/// A body with published answers, or one that is only compared with CalculiX.
pub struct Witness {
    /// The stem of its problem file.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Its mesh.
    pub mesh: fn() -> Mesh,
    /// How many modes are computed.
    pub count: usize,
    /// What the literature says of some of them.
    pub references: &'static [Mode],
    /// What it says of a stress.
    pub stress: Option<StressAt>,
    /// A temperature, in place of a load pattern.
    pub thermal: Option<Thermal>,
    /// The largest difference from the literature that is asserted, as a share; the record says why.
    pub within: f64,
}

/// A reference value of a stress under the first load pattern.
#[derive(Clone, Copy, Debug)]
pub struct StressAt {
    /// Where \[m\].
    pub point: [f64; 3],
    /// Which of xx, yy, zz, xy, yz, zx.
    pub component: usize,
    /// How much \[Pa\].
    pub stress: f64,
}

/// The witness of this name.
///
/// # Panics
/// If there is none.
pub fn witness(name: &str) -> Witness {
    witnesses()
        .into_iter()
        .find(|witness| witness.name == name)
        .unwrap_or_else(|| panic!("no witness {name}"))
}

/// All of them.
pub fn witnesses() -> Vec<Witness> {
    vec![
        Witness {
            name: "fv22",
            what: "NAFEMS FV22, clamped thick rhombic plate",
            mesh: rhombus,
            count: 6,
            references: &[
                Mode { number: 0, hz: 133.95 },
                Mode { number: 1, hz: 201.41 },
                Mode { number: 2, hz: 265.81 },
                Mode { number: 3, hz: 283.68 },
                Mode { number: 4, hz: 334.45 },
            ],
            stress: None,
            thermal: None,
            within: 0.03,
        },
        Witness {
            name: "fv32",
            what: "NAFEMS FV32, cantilevered tapered membrane",
            mesh: tapered,
            count: 6,
            references: &[
                Mode { number: 0, hz: 44.623 },
                Mode { number: 1, hz: 130.03 },
                Mode { number: 2, hz: 162.70 },
                Mode { number: 3, hz: 246.05 },
                Mode { number: 4, hz: 379.90 },
                Mode { number: 5, hz: 391.44 },
            ],
            stress: None,
            thermal: None,
            within: 0.001,
        },
        Witness {
            name: "fv52-plate",
            what: "NAFEMS FV52 with the supports of its closed form, bending",
            mesh: square,
            count: 4,
            references: &[
                Mode { number: 0, hz: 45.897 },
                Mode { number: 1, hz: 109.44 },
                Mode { number: 2, hz: 109.44 },
                Mode { number: 3, hz: 167.89 },
            ],
            stress: None,
            thermal: None,
            within: 0.01,
        },
        Witness {
            name: "fv52-quarter",
            what: "NAFEMS FV52, a quarter of the plate held at its lower edges",
            mesh: square_quarter,
            count: 4,
            // By solids, 4 × 4 × 1 of 20 nodes.
            references: &[Mode { number: 0, hz: 44.762 }],
            stress: None,
            thermal: None,
            within: 0.03,
        },
        Witness {
            name: "fv41",
            what: "NAFEMS FV41, free cylinder, an eighth of it",
            mesh: cylinder,
            count: 8,
            // Those that are symmetric in the middle of its length; the others of the list need a free body.
            references: &[
                Mode { number: 2, hz: 243.53 },
                Mode { number: 6, hz: 394.11 },
                Mode { number: 7, hz: 405.28 },
            ],
            stress: None,
            thermal: None,
            within: 0.002,
        },
        Witness {
            name: "le10",
            what: "NAFEMS LE10, thick elliptic plate under pressure",
            mesh: ellipses,
            count: 4,
            references: &[],
            stress: Some(StressAt { point: [2.0, 0.0, 0.3], component: 1, stress: -5.38e6 }),
            thermal: None,
            within: 0.01,
        },
        Witness {
            name: "le11",
            what: "NAFEMS LE11, cylinder, taper and sphere under a temperature",
            mesh: taper,
            count: 1,
            references: &[],
            stress: Some(StressAt { point: [1.0, 0.0, 0.0], component: 2, stress: -105e6 }),
            thermal: Some(Thermal { expansion: 2.3e-4, temperature: |[x, y, z]| x.hypot(y) + z }),
            within: 0.03,
        },
        Witness {
            name: "beam",
            what: "cantilever of quadratic tetrahedra under its weight",
            mesh: beam,
            count: 6,
            references: &[],
            stress: None,
            thermal: None,
            within: 0.0,
        },
        Witness {
            name: "beam-linear",
            what: "cantilever of linear tetrahedra under its weight",
            mesh: linear_beam,
            count: 6,
            references: &[],
            stress: None,
            thermal: None,
            within: 0.0,
        },
    ]
}

/// A block of quadratic tetrahedra, each node moved to `map` of its place in the unit cube. Mid-side nodes
/// are moved too, so that sides are curved where the map is.
fn mapped(divisions: [usize; 3], map: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh {
    let mut mesh = block([1.0; 3], divisions, Order::Quadratic);
    mesh.nodes.iter_mut().for_each(|node| *node = map(*node));
    mesh
}

/// Names the nodes that are in both groups.
fn meet(mesh: &mut Mesh, name: &str, groups: [&str; 2]) {
    let [one, other] = groups.map(|group| &mesh.node_groups[group]);
    let both = one.iter().copied().filter(|node| other.binary_search(node).is_ok()).collect();
    mesh.node_groups.insert(name.into(), both);
}

fn rhombus() -> Mesh {
    // Sides of 10 m at 45°, 1 m thick; cells are cut along their short diagonals.
    mapped([16, 16, 2], |[s, t, w]| {
        let s = 1.0 - s;
        [10.0 * (t + FRAC_1_SQRT_2 * s), 10.0 * FRAC_1_SQRT_2 * s, w - 0.5]
    })
}

fn tapered() -> Mesh {
    // 10 m long, 5 m wide at the clamp and 1 m at the end; the upper half of 0.05 m of thickness.
    mapped([16, 8, 1], |[s, t, w]| [10.0 * s, (5.0 - 4.0 * s) * (t - 0.5), 0.025 * w])
}

fn square() -> Mesh {
    // The upper half: bending is antisymmetric in the middle plane, which stays where it is in x and y.
    mapped([16, 16, 1], |[s, t, w]| [10.0 * s, 10.0 * t, 0.5 * w])
}

fn square_quarter() -> Mesh {
    // x and y from the centre, where the planes of symmetry are.
    let mut mesh = mapped([6, 6, 2], |[s, t, w]| [5.0 * s, 5.0 * t, w - 0.5]);
    meet(&mut mesh, "x_edge", ["x_max", "z_min"]);
    meet(&mut mesh, "y_edge", ["y_max", "z_min"]);
    mesh
}

fn cylinder() -> Mesh {
    // Radius 2 m to the middle of a wall of 0.4 m, 10 m long; a quarter of its circle, half of its length.
    mapped([14, 1, 14], |[s, t, w]| {
        let (radius, angle) = (2.2 - 0.4 * t, FRAC_PI_2 * s);
        let [x, y] = on_circle(angle);
        [radius * x, radius * y, 5.0 * w]
    })
}

/// The whole of the cylinder of FV41, which nothing holds: so many cells around and along it.
#[must_use]
pub fn whole_cylinder(around: usize, along: usize) -> Mesh {
    let mut mesh = block([1.0; 3], [around, 1, along], Order::Quadratic);
    // The last side of the block becomes the first.
    let key = |[_, t, w]: [f64; 3]| [t.to_bits(), w.to_bits()];
    let first = mesh.nodes.iter().zip(0u32..).filter(|(node, _)| node[0] == 0.0);
    let first: HashMap<_, _> = first.map(|(node, index)| (key(*node), index)).collect();
    let (mut kept, mut nodes) = (vec![], vec![]);
    for node in &mesh.nodes {
        kept.push(if node[0] == 1.0 {
            kept[first[&key(*node)] as usize]
        } else {
            nodes.push(*node);
            nodes.len() as u32 - 1
        });
    }
    mesh.elements.iter_mut().for_each(|node| *node = kept[*node as usize]);
    let place = |[s, t, w]: [f64; 3]| {
        let ((y, x), radius) = ((TAU * s).sin_cos(), 2.2 - 0.4 * t);
        [radius * x, radius * y, 10.0 * w]
    };
    mesh.nodes = nodes.into_iter().map(place).collect();
    mesh.node_ids = (1..=mesh.nodes.len() as u64).collect();
    mesh.node_groups = [("body".to_string(), (0..mesh.nodes.len() as u32).collect())].into();
    mesh.facet_groups.clear();
    mesh
}

/// Straight lines through numbers at equal distances from 0 to 1.
fn between(stations: &[f64], at: f64) -> f64 {
    let place = at * (stations.len() - 1) as f64;
    // A station itself, whatever the product was rounded to.
    let nearest = place.round();
    if (place - nearest).abs() < 1e-9 {
        return stations[nearest as usize];
    }
    let low = place.floor() as usize;
    stations[low] + (place - place.floor()) * (stations[low + 1] - stations[low])
}

/// Cosine and sine of an angle up to a right one, exact at both ends.
fn on_circle(angle: f64) -> [f64; 2] {
    if angle == FRAC_PI_2 { [0.0, 1.0] } else { [angle.cos(), angle.sin()] }
}

fn ellipses() -> Mesh {
    // Between the ellipses of half axes (2, 1) and (3.25, 2.75); 0.6 m thick, with a plane of nodes in the
    // middle, at whose outer edge the plate is held.
    let mut mesh = mapped([14, 8, 6], |[s, t, w]| {
        let [x, y] = on_circle(FRAC_PI_2 * s);
        // Smaller elements at the inner and at the upper side, where the stress is asked for.
        let t = (1.0 - t) * (1.0 - 0.6 * t);
        let z = between(&[-0.3, -0.2, -0.1, 0.0, 0.13, 0.24, 0.3], w);
        [(2.0 + 1.25 * t) * x, (1.0 + 1.75 * t) * y, z]
    });
    // At the outer side, `t = 0` of the block.
    let middle: Vec<u32> = mesh.node_groups["y_min"].clone();
    let middle = middle.into_iter().filter(|node| mesh.nodes[*node as usize][2].abs() < 1e-9).collect();
    mesh.node_groups.insert("middle_edge".into(), middle);
    mesh
}

fn taper() -> Mesh {
    // A quarter of a body of revolution. Inside a sphere of radius 1 m up to 45° and then a cylinder; outside
    // a sphere of 1.4 m up to 30°, a cone, and a cylinder of 1 m; 1.79 m high.
    let inner = |w: f64| -> [f64; 2] {
        let angle = FRAC_PI_4 * (2.0 * w).min(1.0);
        let above = (2.0 * w - 1.0).max(0.0);
        if above > 0.0 {
            [FRAC_1_SQRT_2, between(&[FRAC_1_SQRT_2, 1.79], above)]
        } else {
            [angle.cos(), angle.sin()]
        }
    };
    let outer = |w: f64| -> [f64; 2] {
        let [r, z] = [1.4 * FRAC_PI_6.cos(), 0.7];
        match 4.0 * w {
            w if w < 1.0 => [1.4 * (FRAC_PI_6 * w).cos(), 1.4 * (FRAC_PI_6 * w).sin()],
            w if w < 3.0 => [between(&[r, 1.0], 0.5 * (w - 1.0)), between(&[z, 1.39], 0.5 * (w - 1.0))],
            w => [1.0, between(&[1.39, 1.79], w - 3.0)],
        }
    };
    mapped([8, 6, 16], |[s, t, w]| {
        let [cos, sin] = on_circle(FRAC_PI_2 * s);
        // Smaller elements inside, where the stress is asked for.
        let t = (1.0 - t) * (1.0 - 0.6 * t);
        let ([r, z], [outer_r, outer_z]) = (inner(w), outer(w));
        let [r, z] = [r + t * (outer_r - r), z + t * (outer_z - z)];
        [r * cos, r * sin, z]
    })
}

pub(super) fn beam() -> Mesh {
    block([1.0, 0.08, 0.1], [16, 2, 2], Order::Quadratic)
}

pub(super) fn linear_beam() -> Mesh {
    block([1.0, 0.08, 0.1], [20, 3, 4], Order::Linear)
}

/// The same beam of hexahedra or of wedges, two in a cell.
pub(super) fn beam_of(kind: ElementKind, formulation: Hexahedra) -> Mesh {
    const CORNERS: [[usize; 3]; 8] =
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
    let quadratic = kind.order() == Order::Quadratic;
    let cells = [if quadratic { 8 } else { 16 }, 2, 2];
    let cut: &[&[usize]] = match kind.corners() {
        6 => &[&[0, 1, 2, 4, 5, 6], &[0, 2, 3, 4, 6, 7]],
        _ => &[&[0, 1, 2, 3, 4, 5, 6, 7]],
    };
    let edges = if quadratic { kind.edges() } else { &[] };
    let (mut known, mut nodes, mut elements) = (BTreeMap::new(), vec![], vec![]);
    for cell in 0..cells.iter().product() {
        let corner = [cell % cells[0], cell / cells[0] % cells[1], cell / cells[0] / cells[1]];
        for corners in cut {
            // On a lattice of half cells.
            let of = |&c: &usize| -> [usize; 3] { std::array::from_fn(|i| 2 * (corner[i] + CORNERS[c][i])) };
            let mut places: Vec<[usize; 3]> = corners.iter().map(of).collect();
            let middle = |&[a, b]: &[usize; 2]| std::array::from_fn(|i| (places[a][i] + places[b][i]) / 2);
            let middles: Vec<[usize; 3]> = edges.iter().map(middle).collect();
            places.extend(middles);
            elements.extend(places.into_iter().map(|at| {
                *known.entry(at).or_insert_with(|| {
                    let size = [1.0, 0.08, 0.1];
                    nodes.push(std::array::from_fn(|i| size[i] * (at[i] as f64 / (2 * cells[i]) as f64)));
                    nodes.len() as u32 - 1
                })
            }));
        }
    }
    let held = |&node: &u32| nodes[node as usize][0] == 0.0;
    let count = elements.len() / kind.nodes();
    Mesh {
        node_ids: (1..=nodes.len() as u64).collect(),
        node_groups: [("x_min".into(), (0..nodes.len() as u32).filter(held).collect())].into(),
        nodes,
        kinds: ElementKinds::Uniform(kind),
        elements,
        element_region: vec![0; count],
        regions: vec![Region { hexahedra: Some(formulation), ..Region::new(1, "body") }],
        facet_groups: BTreeMap::new(),
        notes: vec![],
    }
}
