//! Sections of the joined file.

use faer::Mat;
use vademecum_build::export::Draft;
use vademecum_build::linalg::sequential_product as product;
use vademecum_format::{Element, SectionKind as S};

use crate::part::{Inputs, Part};
use crate::synthesis::{Damped, Synthesis};

/// Counts of the joined file.
#[derive(Clone, Copy, Default)]
pub(crate) struct Counts {
    pub nodes: usize,
    pub load_nodes: usize,
    pub triangles: usize,
    pub load_triangles: usize,
    pub patterns: usize,
    pub probes: usize,
}

/// The joined body.
pub(crate) struct Joined<'j> {
    pub parts: &'j [Part<'j>],
    pub synthesis: &'j Synthesis,
    /// Losses against the parts, for people.
    pub notes: Vec<String>,
    pub counts: Counts,
}

impl<'j> Joined<'j> {
    pub fn new(parts: &'j [Part<'j>], synthesis: &'j Synthesis) -> Self {
        let mut counts = Counts::default();
        for part in parts {
            let metadata = part.file.metadata();
            counts.nodes += part.places.len();
            counts.load_nodes += part.n_load();
            counts.triangles += metadata.n_triangles as usize;
            counts.load_triangles += metadata.n_load_triangles as usize;
            counts.patterns += part.patterns.names.len();
            counts.probes += part.probes.names.len();
        }
        Self { parts, synthesis, notes: vec![], counts }
    }

    /// Number of modes.
    fn r(&self) -> usize {
        self.synthesis.eigenvalues.len()
    }

    /// The place in the joined file of the first loadable and of the first other node of each part.
    fn node_starts(&self) -> Vec<[usize; 2]> {
        let (mut load, mut other) = (0, self.counts.load_nodes);
        let mut starts = vec![];
        for part in self.parts {
            starts.push([load, other]);
            load += part.n_load();
            other += part.places.len() - part.n_load();
        }
        starts
    }

    /// Part and node of the part, of each node of the joined file.
    fn nodes(&self) -> Vec<(usize, usize)> {
        let of = |load: bool| {
            self.parts.iter().enumerate().flat_map(move |(at, part)| {
                let nodes = if load { 0..part.n_load() } else { part.n_load()..part.places.len() };
                nodes.map(move |node| (at, node))
            })
        };
        of(true).chain(of(false)).collect()
    }

    /// All sections.
    pub fn sections(&mut self) -> Vec<Draft> {
        let r = self.r();
        let mut sections = self.geometry();
        let values = self.synthesis.eigenvalues.iter().copied();
        sections.push(Draft::f64s(S::Eigenvalues, [r, 1, 1], values));
        match &self.synthesis.damping {
            Damped::Alike { ratio: 0.0, .. } => {}
            Damped::Alike { ratio, .. } => {
                sections.push(Draft::f64s(S::DampingRatios, [r, 1, 1], std::iter::repeat_n(*ratio, r)));
            }
            Damped::Ratios(ratios, _) => {
                sections.push(Draft::f64s(S::DampingRatios, [r, 1, 1], ratios.iter().copied()));
            }
            Damped::Rows(rows, _) => {
                let values = (0..rows.nrows()).flat_map(|i| (0..r).map(move |k| rows[(i, k)]));
                sections.push(Draft::f64s(S::DampingRows, [rows.nrows(), r, 1], values));
            }
        }
        let of_part = |(at, part): (usize, &Part<'_>)| self.synthesis.rows(at, &part.basis, &part.residual);
        let bases: Vec<Mat<f64>> = self.parts.iter().enumerate().map(of_part).collect();
        let values = self.nodes().into_iter().flat_map(|(part, node)| {
            let basis = &bases[part];
            (0..3).flat_map(move |c| (0..r).map(move |k| basis[(3 * node + c, k)]))
        });
        sections.push(Draft::f64s(S::SurfaceBasis, [self.counts.nodes, 3, r], values));
        sections.extend(self.inputs([S::PatternNames, S::PatternBasis], |part| &part.patterns));
        sections.extend(self.inputs([S::ProbeNames, S::ProbeRows], |part| &part.probes));
        sections.extend(self.units());
        sections.extend(self.residual());
        sections
    }

    fn geometry(&self) -> Vec<Draft> {
        let starts = self.node_starts();
        let n = self.counts.nodes;
        let places = self.nodes().into_iter().flat_map(|(part, node)| self.parts[part].places[node]);
        let node = |part: usize, node: u32| {
            let (node, load) = (node as usize, self.parts[part].n_load());
            let [first, other] = starts[part];
            if node < load { first + node } else { other + node - load }
        };
        let triangles = |load: bool| {
            self.parts.iter().enumerate().flat_map(move |(part, own)| {
                let metadata = own.file.metadata();
                let (all, first) = (metadata.n_triangles as usize, metadata.n_load_triangles as usize);
                let (skip, take) = if load { (0, first) } else { (first, all - first) };
                let numbers = own.file.indices(S::Triangles).ok().flatten().unwrap_or_default();
                numbers
                    .iter()
                    .skip(3 * skip)
                    .take(3 * take)
                    .map(move |number| (part, u32::from_le_bytes(*number)))
            })
        };
        let corners = triangles(true).chain(triangles(false)).map(|(part, corner)| node(part, corner) as u32);
        let ids = (1..=n as u64).flat_map(u64::to_le_bytes).collect();
        let mut sections = vec![
            Draft { kind: S::NodeIds, element: Element::U64, shape: [n as u64, 1, 1], bytes: ids },
            Draft::f64s(S::NodeCoordinates, [n, 3, 1], places),
            Draft::u32s(S::Triangles, [self.counts.triangles, 3, 1], corners),
        ];
        sections.extend(self.quadrangles(&node));
        sections
    }

    /// Quadrangular facets of the parts; `node` gives the place of a node in the joined file.
    fn quadrangles(&self, node: &impl Fn(usize, u32) -> usize) -> Option<Draft> {
        let mut quadrangles = vec![];
        let width =
            |part: &Part<'_>| part.file.section(S::Quadrangles).map_or(0, |own| own.shape()[1] as usize);
        let widest = self.parts.iter().map(width).max().unwrap_or(0);
        let mut first = 0;
        for (part, own) in self.parts.iter().enumerate() {
            let numbers = own.file.indices(S::Quadrangles).ok().flatten().unwrap_or_default();
            for row in numbers.chunks_exact(width(own).max(1)) {
                let row: Vec<u32> = row.iter().map(|number| u32::from_le_bytes(*number)).collect();
                let of_node =
                    |&corner: &u32| if corner == u32::MAX { corner } else { node(part, corner) as u32 };
                let mut joined = vec![row[0] + first, row[1]];
                joined.extend(row[2..].iter().map(of_node));
                joined.resize(widest, u32::MAX);
                quadrangles.extend(joined);
            }
            first += own.file.metadata().n_load_triangles;
        }
        let count = quadrangles.len().checked_div(widest)?;
        (count > 0).then(|| Draft::u32s(S::Quadrangles, [count, widest, 1], quadrangles))
    }

    /// Names and rows of load patterns or probes.
    fn inputs(&self, [names, rows]: [S; 2], of: impl Fn(&'j Part<'j>) -> &'j Inputs) -> Vec<Draft> {
        let named =
            |part: &'j Part<'j>| of(part).names.iter().map(move |name| format!("{}.{name}", part.name));
        let all: Vec<String> = self.parts.iter().flat_map(named).collect();
        if all.is_empty() {
            return vec![];
        }
        let r = self.r();
        let of_part = |(at, part): (usize, &'j Part<'j>)| {
            let rows = self.synthesis.rows(at, &of(part).modal, &of(part).ports);
            (0..rows.nrows())
                .flat_map(|i| (0..r).map(move |k| (i, k)))
                .map(|place| rows[place])
                .collect::<Vec<_>>()
        };
        let values: Vec<f64> = self.parts.iter().enumerate().flat_map(of_part).collect();
        vec![
            Draft::f64s(rows, [all.len(), r, 1], values),
            Draft::names(names, all.iter().map(String::as_str)),
        ]
    }

    /// Units of the probes, where one is none of metres.
    fn units(&self) -> Option<Draft> {
        let has = |part: &&Part<'_>| part.file.section(S::ProbeUnits).is_some();
        self.parts.iter().find(has)?;
        let of = |part: &Part<'_>| -> Vec<String> {
            let text = part.file.section(S::ProbeUnits).and_then(|section| section.text().ok());
            let lines = text.map(|text| text.split('\n').map(str::to_string).collect());
            lines.unwrap_or_else(|| vec!["m".into(); part.probes.names.len()])
        };
        let all: Vec<String> = self.parts.iter().flat_map(of).collect();
        Some(Draft::names(S::ProbeUnits, all.iter().map(String::as_str)))
    }

    /// Residual flexibility `H R Hᵀ − H R Gᵀ S⁻¹ G R Hᵀ` of contacts, probes and patterns.
    fn residual(&mut self) -> Vec<Draft> {
        let without = |part: &&Part<'_>| part.n_load() > 0 && part.file.section(S::ContactResidual).is_none();
        if let Some(part) = self.parts.iter().find(without) {
            self.notes.push(format!(
                "part `{}` has no residual flexibility, so the joined body has none under contacts",
                part.name
            ));
            return vec![];
        }
        if self.counts.load_nodes == 0 {
            return vec![];
        }
        // Per part, R Gᵀ of its loadable nodes, probes and patterns over the rows of the joints, and S⁻¹
        // times it; the patterns' are of what they give at the ports.
        let over_joints = |of: &dyn Fn(&Part<'_>) -> Mat<f64>| -> Vec<Mat<f64>> {
            let parts = self.parts.iter().zip(&self.synthesis.weights);
            parts.map(|(part, weights)| product(weights.as_ref(), of(part).transpose())).collect()
        };
        let nodes = over_joints(&|part| part.residual.subrows(0, 3 * part.n_load()).to_owned());
        let probes = over_joints(&|part| part.probes.ports.clone());
        let patterns = over_joints(&|part| part.patterns.ports.clone());
        let answers: Vec<Mat<f64>> = nodes.iter().map(|columns| self.synthesis.forces(columns)).collect();
        let less = |a: &Mat<f64>, i: usize, b: &Mat<f64>, j: usize| -> f64 {
            (0..a.nrows()).map(|k| a[(k, i)] * b[(k, j)]).sum()
        };

        let mut own = Vec::with_capacity(6 * self.counts.load_nodes);
        let (mut pairs, mut blocks) = (vec![], vec![]);
        let mut first = 0;
        for (at, part) in self.parts.iter().enumerate() {
            let (columns, answers) = (&nodes[at], &answers[at]);
            let numbers = numbers_of(part, S::ContactResidual);
            for (node, &[xx, xy, xz, yy, yz, zz]) in numbers.as_chunks::<6>().0.iter().enumerate() {
                let block = part.pose.turn_matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
                for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
                    let value = block[i][j] - less(columns, 3 * node + i, answers, 3 * node + j);
                    // A node of a port that is welded has no residual but rounding.
                    own.push(if i == j { value.max(0.0) } else { value });
                }
            }
            let of_pairs = part.file.indices(S::ResidualPairs).ok().flatten().unwrap_or_default();
            let numbers = numbers_of(part, S::PairResidual);
            for (pair, block) in of_pairs.as_chunks::<2>().0.iter().zip(numbers.as_chunks::<9>().0) {
                let [a, b] = pair.map(|number| u32::from_le_bytes(number) as usize);
                let block: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| block[3 * i + j]));
                let block = part.pose.turn_matrix(block);
                pairs.extend([a, b].map(|node| (first + node) as u32));
                let entry = |i: usize, j: usize| block[i][j] - less(columns, 3 * a + i, answers, 3 * b + j);
                blocks.extend((0..9).map(|k| entry(k / 3, k % 3)));
            }
            first += part.n_load();
        }
        let mut sections = vec![Draft::f64s(S::ContactResidual, [self.counts.load_nodes, 6, 1], own)];
        if !pairs.is_empty() {
            let count = pairs.len() / 2;
            sections.push(Draft::u32s(S::ResidualPairs, [count, 2, 1], pairs));
            sections.push(Draft::f64s(S::PairResidual, [count, 9, 1], blocks));
        }
        // Answers of loadable nodes to unit forces along probes, and under patterns.
        for (kind, of_rows, columns) in [
            (
                S::ProbeResidual,
                &(|part: &Part<'_>| part.probes.names.len()) as &dyn Fn(&Part<'_>) -> usize,
                &probes,
            ),
            (S::PatternResidual, &|part: &Part<'_>| part.patterns.names.len(), &patterns),
        ] {
            let count: usize = self.parts.iter().map(of_rows).sum();
            if count == 0 {
                continue;
            }
            let mut values = Vec::with_capacity(3 * count * self.counts.load_nodes);
            for (source, part) in self.parts.iter().enumerate() {
                let own = numbers_of(part, kind);
                for row in 0..of_rows(part) {
                    for (target, other) in self.parts.iter().enumerate() {
                        for node in 0..other.n_load() {
                            let mut moved = [0.0; 3];
                            if target == source {
                                let start = 3 * (row * part.n_load() + node);
                                let local = |c: usize| own.get(start + c).copied().unwrap_or(0.0);
                                moved = part.pose.turn(std::array::from_fn(local));
                            }
                            let other =
                                |c: usize| less(&columns[source], row, &answers[target], 3 * node + c);
                            values.extend((0..3).map(|c| moved[c] - other(c)));
                        }
                    }
                }
            }
            sections.push(Draft::f64s(kind, [count, self.counts.load_nodes, 3], values));
        }
        if self.counts.probes > 0 && self.counts.patterns > 0 {
            let answers: Vec<Mat<f64>> =
                patterns.iter().map(|columns| self.synthesis.forces(columns)).collect();
            let mut values = vec![];
            for (source, part) in self.parts.iter().enumerate() {
                let (own, count) = (numbers_of(part, S::PatternProbeResidual), part.probes.names.len());
                for row in 0..part.patterns.names.len() {
                    for (target, other) in self.parts.iter().enumerate() {
                        for probe in 0..other.probes.names.len() {
                            let own = own.get(row * count + probe).filter(|_| target == source);
                            let given = less(&probes[target], probe, &answers[source], row);
                            values.push(own.copied().unwrap_or(0.0) - given);
                        }
                    }
                }
            }
            let shape = [self.counts.patterns, self.counts.probes, 1];
            sections.push(Draft::f64s(S::PatternProbeResidual, shape, values));
        }
        sections
    }

    /// Rows of the table of modes.
    pub fn mode_table(&self, rows: Mat<f64>) -> Draft {
        let values = (0..rows.nrows()).flat_map(|i| (0..6).map(move |k| (i, k))).map(|place| rows[place]);
        Draft::f64s(S::ModeTable, [rows.nrows(), 6, 1], values.collect::<Vec<_>>())
    }
}

fn numbers_of(part: &Part<'_>, kind: S) -> Vec<f64> {
    let numbers = part.file.section(kind).and_then(|section| section.numbers().ok());
    numbers.map_or(vec![], |numbers| numbers.iter().collect())
}
