//! Couplings, ties, masses, springs, dashpots and loads of a deck as tables of a problem file, in SI units.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use vademecum_build::fem::{rigid_row, surface_facets};
use vademecum_build::linalg::vec3::{norm, sub};
use vademecum_build::mesh::surface::Surface;

use crate::deck::{Attachment, Deck, Dynamic, Extent, Link, Load, NodeNumber, Spring, Step, StepKind};
use crate::heat::{Rise, rise};
use crate::units::System;

/// Names of the motions of a reference point.
const MOTIONS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Springs whose ends are closer than this share of the model are taken to be in one place.
const ONE_PLACE: f64 = 1e-6;

/// Tables of a deck, and what they leave out.
pub(crate) struct Tables<'a> {
    deck: &'a Deck,
    /// Factors to metres, newtons and kilograms.
    metre: f64,
    newton: f64,
    kilogram: f64,
    text: String,
    points: BTreeSet<NodeNumber>,
    /// Reference of each node whose displacement is a rotation.
    turns: BTreeMap<NodeNumber, NodeNumber>,
    /// Nodes with the number of an earlier one, and how many such there are with them.
    alike: BTreeMap<NodeNumber, usize>,
    left_out: BTreeMap<&'static str, usize>,
    patterns: String,
    /// Names of the patterns.
    names: Vec<String>,
    /// Scenario of the first motion over time.
    scenario: Option<String>,
    /// Pattern of the first answer to harmonic loads.
    harmonic: Option<String>,
    surface: Option<Surface>,
}

impl<'a> Tables<'a> {
    /// All tables of a deck.
    pub(crate) fn of(deck: &'a Deck, system: System) -> Tables<'a> {
        let [metre, pascal, density] = system.factors();
        let (newton, kilogram) = (pascal * metre * metre, density * metre.powi(3));
        let mut tables = Tables {
            deck,
            metre,
            newton,
            kilogram,
            text: String::new(),
            points: BTreeSet::new(),
            turns: deck.links.iter().filter_map(turn).collect(),
            alike: alike(deck),
            left_out: BTreeMap::new(),
            patterns: String::new(),
            names: vec![],
            scenario: None,
            harmonic: None,
            surface: None,
        };
        deck.links.iter().for_each(|one| tables.link(one));
        deck.attachments.iter().for_each(|one| tables.attachment(one));
        tables.skew_supports();
        tables.loads();
        tables.reference_points();
        tables
    }

    /// The tables as text.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Numbers of what was left out, in words.
    pub(crate) fn missing(&self) -> impl Iterator<Item = String> {
        self.left_out.iter().map(|(words, count)| format!("{count} {words}"))
    }

    /// Scenario of the first motion over time.
    pub(crate) fn scenario(&self) -> Option<&str> {
        self.scenario.as_deref()
    }

    /// Pattern of the first answer to harmonic loads.
    pub(crate) fn harmonic(&self) -> Option<&str> {
        self.harmonic.as_deref()
    }

    /// Tables of load patterns.
    pub(crate) fn patterns(&self) -> &str {
        &self.patterns
    }

    /// True of a node that is a reference point.
    pub(crate) fn has_point(&self, node: NodeNumber) -> bool {
        self.points.contains(&node)
    }

    fn leave_out(&mut self, words: &'static str) {
        *self.left_out.entry(words).or_default() += 1;
    }

    fn is_solid(&self, node: NodeNumber) -> bool {
        (node as usize) < self.deck.mesh.nodes.len()
    }

    /// Name of the reference point of a node: masses off their node are at points of the same number.
    fn name(&self, node: NodeNumber) -> String {
        match self.alike.get(&node) {
            None => format!("N{}", self.deck.id(node)),
            Some(place) => format!("N{}.{place}", self.deck.id(node)),
        }
    }

    /// A selection of nodes of the mesh: the group that has them, else their numbers.
    fn selection(&self, nodes: impl Iterator<Item = NodeNumber>) -> String {
        let nodes: BTreeSet<NodeNumber> = nodes.collect();
        let nodes: Vec<NodeNumber> = nodes.into_iter().collect();
        self.deck.selection(&nodes)
    }

    /// The reference point of a node; of a node of the mesh, one that it follows.
    fn point(&mut self, node: NodeNumber) -> String {
        let name = self.name(node);
        if self.points.insert(node) && self.is_solid(node) {
            let on = self.selection(std::iter::once(node));
            let _ = write!(self.text, "[[coupling]]\nreference = {name:?}\non = {on}\nkind = \"rigid\"\n\n");
        }
        name
    }

    fn link(&mut self, link: &Link) {
        match link {
            Link::Equation { terms, .. } => {
                if terms.iter().any(|&(node, c, _)| self.is_solid(node) && c >= 3) {
                    return self.leave_out("linear equations of rotations of the solid");
                }
                let outside = terms.iter().map(|term| term.0).filter(|&node| !self.is_solid(node));
                self.points.extend(outside.collect::<Vec<_>>());
                let along = terms.iter().flat_map(|&(node, c, a)| {
                    self.deck.along(node, c).into_iter().map(move |(c, share)| (node, c, a * share))
                });
                let terms: Vec<_> = along.collect();
                self.equation(&terms);
            }
            Link::Rigid { reference, nodes, components, .. } => {
                let followers: Vec<NodeNumber> =
                    nodes.iter().copied().filter(|node| node != reference).collect();
                let (followers, points): (Vec<_>, Vec<_>) =
                    followers.into_iter().partition(|&node| self.is_solid(node));
                points.into_iter().for_each(|node| self.point_link(*reference, node, components));
                if followers.is_empty() {
                    return;
                }
                let name = self.point(*reference);
                let on = self.selection(followers.into_iter());
                let _ =
                    writeln!(self.text, "[[coupling]]\nreference = {name:?}\non = {on}\nkind = \"rigid\"");
                if !components[..3].iter().all(|follows| *follows) {
                    let named = MOTIONS.iter().zip(components).take(3).filter(|(_, follows)| **follows);
                    let named: Vec<String> = named.map(|(name, _)| format!("\"{name}\"")).collect();
                    let _ = writeln!(self.text, "components = [{}]", named.join(", "));
                }
                self.text.push('\n');
            }
            Link::Mean { reference, cloud, components, .. } => {
                let first = cloud.first().map_or(0.0, |term| term.1);
                let alike = cloud.iter().all(|(_, w)| (w - first).abs() <= 1e-9 * first.abs());
                let solid = cloud.iter().all(|&(node, _)| self.is_solid(node)) && !self.is_solid(*reference);
                if !solid || !components[..3].iter().all(|follows| *follows) {
                    return self.leave_out("averaging couplings of reference points or of some components");
                }
                let name = self.point(*reference);
                let nodes = if alike {
                    format!("on = {}", self.selection(cloud.iter().map(|term| term.0)))
                } else {
                    let terms = cloud.iter().map(|&(node, w)| format!("[{}, {w:?}]", self.deck.id(node)));
                    format!("weights = [{}]", terms.collect::<Vec<_>>().join(", "))
                };
                let _ =
                    write!(self.text, "[[coupling]]\nreference = {name:?}\n{nodes}\nkind = \"average\"\n\n");
            }
            Link::Tie { slaves, faces, tolerance, .. } => {
                // A deck without a distance ties within 5 % of an edge of the nearest facet. A table has one
                // distance: that of the largest facet.
                let edge = |face: &[u32; 3]| norm(sub(self.deck.place(face[0]), self.deck.place(face[1])));
                let usual = || 0.05 * faces.iter().map(edge).fold(0.0, f64::max);
                let distance = self.metre * tolerance.unwrap_or_else(usual);
                let [on, to] = [
                    self.selection(slaves.iter().copied()),
                    self.selection(self.face_nodes(faces).into_iter()),
                ];
                let _ = write!(self.text, "[[tie]]\non = {on}\nto = {to}\ndistance = {distance:?} # m\n\n");
            }
        }
    }

    /// A reference point that follows another one, as equations.
    fn point_link(&mut self, reference: NodeNumber, node: NodeNumber, components: &[bool; 6]) {
        if self.is_solid(reference) {
            return self.leave_out("rigid links of a reference point to a node of the solid");
        }
        self.points.extend([reference, node]);
        let d = sub(self.deck.place(node), self.deck.place(reference));
        for c in (0..6_u8).filter(|c| components[usize::from(*c)]) {
            let row = match usize::from(c) {
                c @ 0..3 => rigid_row(d, c),
                c => std::array::from_fn(|k| f64::from(u8::from(k == c))),
            };
            let of_reference = (0..6_u8).zip(row).map(|(k, a)| (reference, k, -a));
            let terms = std::iter::once((node, c, 1.0)).chain(of_reference.filter(|term| term.2 != 0.0));
            self.equation(&terms.collect::<Vec<_>>());
        }
    }

    /// A linear equation between motions along the axes of space.
    fn equation(&mut self, terms: &[(NodeNumber, u8, f64)]) {
        let rows = terms.iter().map(|&(node, c, a)| {
            // Lengths stand beside rotations.
            let a = if c < 3 { a } else { self.metre * a };
            match self.is_solid(node) {
                true => format!("[{}, {}, {a:?}]", self.deck.id(node), c + 1),
                false => format!("[{:?}, {}, {a:?}]", self.name(node), c + 1),
            }
        });
        let rows: Vec<String> = rows.collect();
        let _ = write!(self.text, "[[equation]]\nterms = [{}]\n\n", rows.join(", "));
    }

    /// Supports along axes that are not those of space, as equations.
    fn skew_supports(&mut self) {
        let outside: Vec<(NodeNumber, u8)> = self.supports().filter(|of| !self.is_solid(of.0)).collect();
        for (node, c) in outside {
            if self.turns.contains_key(&node) {
                if self.deck.along(node, c).len() > 1 {
                    self.leave_out("rotations held along own axes of their node");
                }
                continue;
            }
            let terms: Vec<_> = self.deck.along(node, c).into_iter().map(|(c, a)| (node, c, a)).collect();
            if terms.len() > 1 {
                self.points.insert(node);
                self.equation(&terms);
            }
        }
        for (node, directions) in self.deck.skew_supports() {
            for direction in directions {
                let terms: Vec<_> = (0..3_u8)
                    .map(|c| (node, c, direction[usize::from(c)]))
                    .filter(|term| term.2 != 0.0)
                    .collect();
                self.equation(&terms);
            }
        }
    }

    /// All nodes of faces, which are given by three corners.
    fn face_nodes(&self, faces: &[[u32; 3]]) -> BTreeSet<NodeNumber> {
        match surface_facets(&self.deck.mesh, faces) {
            Ok(facets) => facets.iter().flat_map(|facet| facet.nodes().to_vec()).collect(),
            Err(_) => faces.iter().flatten().copied().collect(),
        }
    }

    fn attachment(&mut self, attachment: &Attachment) {
        match attachment {
            Attachment::Mass { node, mass, inertia } => {
                let name = self.point(*node);
                let (mass, square) = (self.kilogram * mass, self.metre * self.metre * self.kilogram);
                let _ = writeln!(self.text, "[[point_mass]]\nreference = {name:?}\nmass = {mass:?} # kg");
                if *inertia != [0.0; 6] {
                    let _ = writeln!(self.text, "inertia = {:?} # kg m²", inertia.map(|x| square * x));
                }
                self.text.push('\n');
            }
            Attachment::Spring(spring) => self.spring(spring, ["spring", "stiffness"], "N/m, N m"),
            Attachment::Dashpot(spring) => self.spring(spring, ["dashpot", "damping"], "N s/m, N m s"),
            Attachment::Beam { ends, stiffness, mass } => {
                let names = ends.map(|end| self.point(end));
                // Lengths stand beside rotations.
                let unit = |i: usize, j: usize| {
                    let turns = u8::from(i % 6 > 2) + u8::from(j % 6 > 2);
                    self.newton * self.metre.powi(i32::from(turns) - 1)
                };
                let rows = (0..12).map(|i| {
                    let row = (i..12).map(|j| format!("{:e}", unit(i, j) * stiffness[12 * i + j]));
                    format!("    {},\n", row.collect::<Vec<_>>().join(", "))
                });
                let rows: String = rows.collect();
                let [from, to] = &names;
                let _ = write!(
                    self.text,
                    "[[spring]]\nfrom = {from:?}\nto = {to:?}\nmatrix = [ # N/m, N, N m\n{rows}]\n\n"
                );
                let mass = self.kilogram * mass;
                if mass > 0.0 {
                    for name in names {
                        let _ = write!(
                            self.text,
                            "[[point_mass]]\nreference = {name:?}\nmass = {mass:?} # kg\n\n"
                        );
                    }
                }
            }
        }
    }

    /// A spring or a dashpot, by the names of its table and of its numbers.
    fn spring(&mut self, spring: &Spring, table: [&str; 2], units: &str) {
        match spring {
            Spring::Line { ends, stiffness } => {
                let [from, to] = ends.map(|end| self.deck.place(end));
                let along = sub(to, from);
                if norm(along) == 0.0 {
                    return self.leave_out("springs and dashpots along a line of no length");
                }
                // The axis that is farthest from the line is not along it.
                let least = (0..3).min_by(|&a, &b| along[a].abs().total_cmp(&along[b].abs())).unwrap_or(0);
                let unit = along.map(|x| x / norm(along));
                let side: [f64; 3] =
                    std::array::from_fn(|c| f64::from(u8::from(c == least)) - unit[least] * unit[c]);
                let numbers = [self.newton / self.metre * stiffness, 0.0, 0.0, 0.0, 0.0, 0.0];
                let names = ends.map(|end| self.point(end));
                self.between(&names, table, (numbers, units), Some([unit, side]));
            }
            Spring::Components { ends, stiffness } => {
                let one_place = match ends[..] {
                    [(a, c), (b, d)] => {
                        let size = self.deck.mesh.bounding_box();
                        let size = norm(sub(size.1, size.0));
                        c == d && norm(sub(self.deck.place(a), self.deck.place(b))) <= ONE_PLACE * size
                    }
                    _ => true,
                };
                let turned = ends.iter().any(|(node, _)| self.deck.axes.contains_key(node));
                let (Some(&(_, component)), true, false) = (ends.first(), one_place, turned) else {
                    return self.leave_out(
                        "springs and dashpots between components of places that are apart, or of own axes",
                    );
                };
                let mut numbers = [0.0; 6];
                let arm = if component < 3 { 1.0 / self.metre } else { self.metre };
                numbers[usize::from(component)] = self.newton * arm * stiffness;
                let names: Vec<String> = ends.iter().map(|end| self.point(end.0)).collect();
                self.between(&names, table, (numbers, units), None);
            }
        }
    }

    /// A table of two ends and six numbers.
    fn between(
        &mut self,
        names: &[String],
        [table, key]: [&str; 2],
        (numbers, units): ([f64; 6], &str),
        axes: Option<[[f64; 3]; 2]>,
    ) {
        let _ = writeln!(self.text, "[[{table}]]\nfrom = {:?}", names[0]);
        if let Some(to) = names.get(1) {
            let _ = writeln!(self.text, "to = {to:?}");
        }
        let _ = writeln!(self.text, "{key} = {numbers:?} # {units}");
        if let Some(axes) = axes {
            let _ = writeln!(self.text, "axes = {axes:?}");
        }
        self.text.push('\n');
    }

    /// Loads of the static steps, of motions over time and of answers to harmonic loads.
    fn loads(&mut self) {
        let deck = self.deck;
        for (index, step) in deck.steps.iter().enumerate() {
            let is_state = deck.steps.iter().find_map(|other| other.about) == Some(index);
            let before = self.names.len();
            match &step.kind {
                StepKind::Static => {
                    let rotation = self.patterns_of(step, &step.loads, is_state);
                    match rise(deck, step) {
                        Rise::None => {}
                        Rise::Uniform(rise) => {
                            self.pattern(&step.name, &format!("temperature = {rise:?} # K"));
                        }
                        Rise::Other => self.leave_out("temperatures that differ between nodes"),
                    }
                    if is_state && (before < self.names.len() || rotation.is_some()) {
                        self.prestress(before, rotation);
                    }
                    continue;
                }
                StepKind::Dynamic(_) if self.scenario.is_some() => {
                    self.leave_out("motions over time after the first one");
                }
                StepKind::Dynamic(dynamic) => self.motion(step, dynamic),
                StepKind::Harmonic(_) if self.harmonic.is_some() => {
                    self.leave_out("answers to harmonic loads after the first one");
                }
                StepKind::Harmonic(_) => {
                    self.patterns_of(step, &step.loads, false);
                    match &self.names[before..] {
                        [pattern] => self.harmonic = Some(pattern.clone()),
                        [] => self.leave_out("answers to harmonic loads without a load"),
                        _ => self.leave_out("harmonic loads of several kinds at a time"),
                    }
                }
                _ => continue,
            }
            if step.supports.iter().any(|support| support.value != 0.0) {
                self.leave_out("motions of supports in time or at frequencies: they are held");
            }
        }
    }

    /// Patterns and the scenario of a motion over time: a pattern for each course of its loads.
    fn motion(&mut self, step: &Step, dynamic: &Dynamic) {
        let (constant, driven) = step.loads.split_at(step.loads.len() - dynamic.follows.len());
        let mut courses: Vec<(&[[f64; 2]], Vec<Load>)> = vec![(&[], constant.to_vec())];
        courses.extend(dynamic.courses.iter().map(|course| (&course.1[..], vec![])));
        for (load, course) in driven.iter().zip(&dynamic.follows) {
            courses[1 + course].1.push(load.clone());
        }
        let Dynamic { increment, duration, .. } = dynamic;
        let mut text = format!("# Written by `vademecum init` from the deck.\nduration = {duration:?} # s\n");
        for (course, loads) in &courses {
            let before = self.names.len();
            self.patterns_of(step, loads, false);
            for name in &self.names[before..] {
                let _ =
                    write!(text, "\n[[pattern]]\nname = {name:?}\n{}", table(course, duration + increment));
            }
        }
        self.scenario = Some(text);
    }

    /// Patterns of loads: accelerations of the whole model, pressures and tractions on faces, forces at nodes
    /// and at reference points. A rotation of the whole model that makes a state is returned: speed, axis and
    /// point.
    fn patterns_of<'l>(
        &mut self,
        step: &Step,
        loads: &'l [Load],
        is_state: bool,
    ) -> Option<(f64, &'l [f64; 3], [f64; 3])> {
        let deck = self.deck;
        let mut rotation = None;
        let mut at_points: BTreeMap<NodeNumber, [f64; 6]> = BTreeMap::new();
        let mut at_nodes: BTreeMap<NodeNumber, [f64; 3]> = BTreeMap::new();
        let mut faces: BTreeMap<[u64; 4], Vec<[u32; 3]>> = BTreeMap::new();
        for load in loads {
            match load {
                Load::Force { value: 0.0, .. } => {}
                Load::Acceleration { on: Extent::All, value } => {
                    let value = value.map(|a| self.metre * a);
                    self.pattern(&step.name, &format!("acceleration = {value:?} # m/s²"));
                }
                Load::Force { node, component: component @ 0..3, value } if self.turns.contains_key(node) => {
                    let moments = at_points.entry(self.turns[node]).or_default();
                    for (c, share) in deck.along(*node, *component) {
                        moments[3 + usize::from(c)] += self.newton * self.metre * share * value;
                    }
                }
                Load::Force { node, component, value } if self.points.contains(node) => {
                    let arm = if *component < 3 { 1.0 } else { self.metre };
                    let sums = at_points.entry(*node).or_default();
                    for (c, share) in deck.along(*node, *component) {
                        sums[usize::from(c)] += self.newton * arm * share * value;
                    }
                }
                Load::Force { node, component: component @ 0..3, value } if self.is_solid(*node) => {
                    let sums = at_nodes.entry(*node).or_default();
                    for (c, share) in deck.along(*node, *component) {
                        sums[usize::from(c)] += self.newton * share * value;
                    }
                }
                Load::Pressure { faces: own, value } => {
                    faces.entry([value.to_bits(), u64::MAX, 0, 0]).or_default().extend(own);
                }
                Load::Traction { faces: own, value } => {
                    let [x, y, z] = value.map(f64::to_bits);
                    faces.entry([x, y, z, 1]).or_default().extend(own);
                }
                Load::Rotation { on: Extent::All, speed_squared, point, axis } if is_state => {
                    rotation = Some((speed_squared.sqrt(), axis, point.map(|x| self.metre * x)));
                }
                _ => self.leave_out("body forces of a part, rotations, moments on the solid"),
            }
        }
        for (key, faces) in faces {
            self.on_faces(&step.name, key, &faces);
        }
        if !at_nodes.is_empty() {
            let rows =
                at_nodes.iter().map(|(&node, [x, y, z])| format!("[{}, {x:?}, {y:?}, {z:?}]", deck.id(node)));
            let rows: Vec<String> = rows.collect();
            self.pattern(&step.name, &format!("forces = [{}] # N", rows.join(", ")));
        }
        for (node, [fx, fy, fz, mx, my, mz]) in at_points {
            let (name, force, moment) = (self.name(node), [fx, fy, fz], [mx, my, mz]);
            let mut keys = format!("reference = {name:?}");
            if force != [0.0; 3] {
                let _ = write!(keys, "\nforce = {force:?} # N");
            }
            if moment != [0.0; 3] {
                let _ = write!(keys, "\nmoment = {moment:?} # N m");
            }
            if force != [0.0; 3] || moment != [0.0; 3] {
                self.pattern(&format!("{} {name}", step.name), &keys);
            }
        }
        rotation
    }

    /// The state of the patterns from one on, and of a rotation by speed, axis and point.
    fn prestress(&mut self, first: usize, rotation: Option<(f64, &[f64; 3], [f64; 3])>) {
        let loads: Vec<String> = self.names[first..].iter().map(|name| format!("{name:?} = 1.0")).collect();
        self.patterns += "[prestress]\n";
        if !loads.is_empty() {
            let _ = writeln!(self.patterns, "loads = {{ {} }}", loads.join(", "));
        }
        if let Some((speed, axis, point)) = rotation {
            let _ = writeln!(self.patterns, "speed = {speed:?} # rad/s\naxis = {axis:?}\npoint = {point:?}");
        }
        self.patterns.push('\n');
    }

    /// A pressure or a traction on faces, where the nodes of these faces have no others.
    fn on_faces(&mut self, step: &str, key: [u64; 4], faces: &[[u32; 3]]) {
        let nodes: Vec<NodeNumber> = self.face_nodes(faces).into_iter().collect();
        let distinct: BTreeSet<[u32; 3]> = faces.iter().map(|face| sorted(*face)).collect();
        let surface = self.surface.get_or_insert_with(|| Surface::of(&self.deck.mesh));
        if surface.facets_within(&nodes).len() != distinct.len() {
            return self.leave_out("pressures on faces that share all nodes with others");
        }
        let on = self.deck.selection(&nodes);
        let pascal = self.newton / (self.metre * self.metre);
        let value = |bits: u64| pascal * f64::from_bits(bits);
        let keys = match key {
            [p, u64::MAX, ..] => format!("pressure = {:?} # Pa\non = {on}", value(p)),
            [x, y, z, _] => format!("traction = {:?} # Pa\non = {on}", [x, y, z].map(value)),
        };
        self.pattern(step, &keys);
    }

    fn pattern(&mut self, name: &str, keys: &str) {
        let name = format!("{} {}", self.names.len() + 1, name.replace(['\n', '"', ','], " "));
        self.names.push(name.clone());
        let _ = write!(self.patterns, "[[load.pattern]]\nname = {name:?}\n{keys}\n\n");
    }

    /// Supports of the model and of its first step.
    fn supports(&self) -> impl Iterator<Item = (NodeNumber, u8)> {
        let of_step = self.deck.steps.first().map_or(&[][..], |step| &step.supports);
        let all = self.deck.supports.iter().chain(of_step);
        all.map(|support| (support.node, support.component))
    }

    /// The reference points, before all that names them.
    fn reference_points(&mut self) {
        let mut text = String::new();
        for &node in &self.points {
            let at = self.deck.place(node).map(|x| self.metre * x);
            let _ = writeln!(text, "[[reference_point]]\nname = {:?}\nat = {at:?} # m", self.name(node));
            let motion = |(at, c): (NodeNumber, u8)| match self.turns.get(&at) {
                // A rotation about an axis that is none of space is left out.
                Some(&reference) => match self.deck.along(at, c)[..] {
                    [(c, _)] => (reference, c + 3),
                    _ => (reference, u8::MAX),
                },
                // A direction that is none of space is held by an equation.
                None => match self.deck.along(at, c)[..] {
                    [(c, _)] => (at, c),
                    _ => (at, u8::MAX),
                },
            };
            let of_node = self.supports().map(motion).filter(|of| of.0 == node && of.1 < 6);
            let held: BTreeSet<u8> = of_node.map(|of| of.1).collect();
            if !held.is_empty() && !self.is_solid(node) {
                let held: Vec<String> =
                    held.iter().map(|&c| format!("\"{}\"", MOTIONS[usize::from(c)])).collect();
                let _ = writeln!(text, "held = [{}]", held.join(", "));
            }
            text.push('\n');
        }
        self.text = text + &self.text;
    }
}

/// Nodes with the number of an earlier one, and how many such there are with them.
fn alike(deck: &Deck) -> BTreeMap<NodeNumber, usize> {
    let mut seen: BTreeMap<u64, usize> = BTreeMap::new();
    let mut found = BTreeMap::new();
    for node in 0..deck.node_count() as NodeNumber {
        let count = seen.entry(deck.id(node)).or_default();
        *count += 1;
        if *count > 1 {
            found.insert(node, *count);
        }
    }
    found
}

/// The table of a course up to an instant; none of a constant load.
fn table(course: &[[f64; 2]], end: f64) -> String {
    let (Some(&first), Some(&last)) = (course.first(), course.last()) else { return String::new() };
    let mut rows = course.to_vec();
    // Programs hold the first and the last value; a table ends at its last row.
    if first[0] > 0.0 {
        rows.insert(0, [0.0, first[1]]);
    }
    if last[0] < end {
        rows.push([end, last[1]]);
    }
    let rows: Vec<String> = rows.iter().map(|[time, factor]| format!("[{time:?}, {factor:?}]")).collect();
    format!("table = [{}]\n", rows.join(", "))
}

/// The node whose displacement is the rotation of a reference, and the reference.
fn turn(link: &Link) -> Option<(NodeNumber, NodeNumber)> {
    match link {
        Link::Rigid { reference, rotation: Some(rotation), .. } => Some((*rotation, *reference)),
        _ => None,
    }
}

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}
