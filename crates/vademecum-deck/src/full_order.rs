//! The full-order model of a deck: static answers and natural modes.

use std::collections::{BTreeMap, BTreeSet};

use faer::Mat;
use vademecum_build::dynamics::{ModesError, lowest_modes};
use vademecum_build::fem::{
    Block, Constraints, ElementMatrices, Elimination, Facet, FactorError, Heat, Pencil, Prestress, Rotation,
    Solve, Symbolic, assemble_blocks, buckling_factor, facet_load, inertia_forces, internal_forces,
    pressure_stiffness, surface_facets, thermal_forces,
};

use crate::deck::{
    Attachment, Deck, Extent, Load, NodeNumber, Spring, Step, StepKind, Support, Temperatures,
};
use crate::error::DeckError;
use crate::links::{Dofs, link};

/// Share of a motion of the whole model that its own forces may leave open: a part that nothing holds but
/// rounding comes back anywhere.
const UNSETTLED: f64 = 1e-2;

/// Share by which links and springs may miss a rigid motion.
const RIGID: f64 = 1e-9;

/// Squares of displacements that differ by no more are those of symmetric nodes.
const SAME: f64 = 1e-9;

/// A deck with its dofs.
pub struct FullOrder<'a> {
    deck: &'a Deck,
    elements: ElementMatrices<'a>,
    dofs: Dofs,
    blocks: Vec<Block>,
}

/// Solution of a static step.
struct Solved {
    elimination: Elimination,
    /// Forces over all dofs, with those of the thermal strain.
    load: Vec<f64>,
    /// The latter, and the energy of the thermal strain in no displacement.
    thermal: (Vec<f64>, f64),
    /// Forces over the free dofs, less those of given displacements.
    rhs: Vec<f64>,
    /// Displacement over all dofs.
    displacement: Vec<f64>,
}

/// Answer of a static step.
#[derive(Clone, Debug)]
pub struct StaticAnswer {
    /// Name of the step.
    pub step: String,
    /// Displacement of every node, of the mesh and of points, along the axes of space.
    pub displacement: Vec<[f64; 3]>,
    /// Node of the largest displacement.
    pub node: NodeNumber,
    /// Sum of the forces of all supports.
    pub reaction_sum: [f64; 3],
    /// Strain energy of elements, springs and beams.
    pub strain_energy: f64,
    /// Free dofs.
    pub dofs: usize,
    /// `‖f − K u‖ / ‖f‖` over the free dofs.
    pub residual: f64,
}

/// Natural modes.
#[derive(Clone, Debug)]
pub struct Modes {
    /// Natural frequency \[cycles per unit of time\], ascending.
    pub frequencies_hz: Vec<f64>,
    /// Relative residual of the eigenvalue problem.
    pub residuals: Vec<f64>,
    /// Rigid motions of no frequency before these modes.
    pub rigid_motions: usize,
    /// Displacement of every node in each mode, the largest 1 long.
    pub shapes: Vec<Vec<[f64; 3]>>,
    /// Free dofs.
    pub dofs: usize,
}

impl StaticAnswer {
    /// Length of the largest displacement.
    pub fn largest_displacement(&self) -> f64 {
        let largest = self.displacement.get(self.node as usize).copied().unwrap_or_default();
        largest.iter().map(|u| u * u).sum::<f64>().sqrt()
    }
}

impl<'a> FullOrder<'a> {
    /// Numbers the dofs of a deck and makes the matrices of what is attached.
    pub fn new(deck: &'a Deck) -> FullOrder<'a> {
        let mut dofs = Dofs::new(deck);
        let blocks = deck.attachments.iter().filter_map(|one| block(deck, &dofs, one)).collect();
        let mut elements = ElementMatrices::new(&deck.mesh, &deck.materials, &deck.lumped);
        elements.turn(&deck.cylinders);
        if deck.of_calculix {
            dofs.end_at(elements.keep_inner_functions(dofs.count() as u32));
        }
        FullOrder { deck, elements, dofs, blocks }
    }

    /// Answers of all static steps, in order.
    ///
    /// # Errors
    /// [`DeckError`], by cause.
    pub fn static_answers(&self) -> Result<Vec<StaticAnswer>, DeckError> {
        let steps = self.deck.steps.iter().filter(|step| step.kind == StepKind::Static);
        let answers: Vec<StaticAnswer> =
            steps.map(|step| self.static_answer(step)).collect::<Result<_, _>>()?;
        if answers.is_empty() {
            let kinds = self.deck.steps.iter().map(|step| match &step.kind {
                StepKind::Other(kind) => kind.clone(),
                StepKind::Frequency(_) => "natural frequencies".into(),
                StepKind::Dynamic(_) => "motion over time".into(),
                StepKind::Harmonic(_) => "answers to harmonic loads".into(),
                StepKind::Static => "static".into(),
            });
            let found: Vec<String> = kinds.collect();
            let found = if found.is_empty() { "no step at all".into() } else { found.join(", ") };
            return Err(DeckError::NoStaticStep { file: self.deck.file.clone(), found });
        }
        Ok(answers)
    }

    fn static_answer(&self, step: &Step) -> Result<StaticAnswer, DeckError> {
        let Solved { elimination, load, thermal, rhs, displacement } = self.solve(step)?;
        let elements = self.heated(&step.temperatures);
        let internal = internal_forces(&elements, &self.blocks, &displacement)?;
        let out: Vec<f64> = internal.iter().zip(&load).map(|(k, f)| k - f).collect();
        let (unbalanced, reactions) = elimination.gather(&out);
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let scale = norm(&elimination.gather(&internal).0).max(norm(&rhs));
        let work = |forces: &[f64]| forces.iter().zip(&displacement).map(|(f, u)| f * u).sum::<f64>();
        let energy = 0.5 * work(&internal) - work(&thermal.0) + thermal.1;
        let displacement = self.of_nodes(&displacement);
        let square = |u: &[f64; 3]| u.iter().map(|x| x * x).sum::<f64>();
        // CalculiX answers for nodes of elements; others may be rotations and pressures.
        let nodes = if self.deck.of_calculix { self.deck.mesh.nodes.len() } else { displacement.len() };
        let most = displacement[..nodes].iter().map(square).fold(0.0, f64::max);
        // Of nodes that differ by rounding the first one.
        let node = displacement.iter().position(|u| square(u) >= (1.0 - SAME) * most).unwrap_or(0);
        Ok(StaticAnswer {
            step: step.name.clone(),
            node: node as NodeNumber,
            displacement,
            reaction_sum: self.reaction_sum(step, &elimination, &reactions),
            strain_energy: energy,
            dofs: rhs.len(),
            residual: if scale > 0.0 { norm(&unbalanced) / scale } else { 0.0 },
        })
    }

    /// The elements at temperatures of a step; none: the initial ones.
    fn heated<'s>(&'s self, temperatures: &'s [f64]) -> ElementMatrices<'s> {
        let Some(Temperatures { laws, initial, lowered }) = &self.deck.heat else {
            return self.elements.clone();
        };
        let now = if temperatures.is_empty() { initial } else { temperatures };
        if now.is_empty() {
            return self.elements.clone();
        }
        self.elements.heated(Heat { laws, initial, now, lowered: *lowered })
    }

    /// Solves a static step.
    fn solve(&self, step: &Step) -> Result<Solved, DeckError> {
        let elimination = self.elimination(&step.supports)?;
        let elements = self.heated(&step.temperatures);
        let pencil = assemble_blocks(&elements, &self.blocks, &elimination)?;
        let (mut load, thermal) = (self.load(&step.loads)?, thermal_forces(&elements, self.dofs.count())?);
        load.iter_mut().zip(&thermal.0).for_each(|(sum, f)| *sum += f);
        // Displacements that are given, with all free dofs at zero.
        let given = elimination.expand(&vec![0.0; elimination.n_free()]);
        let mut force = load.clone();
        if given.iter().any(|u| *u != 0.0) {
            let held = internal_forces(&elements, &self.blocks, &given)?;
            force.iter_mut().zip(held).for_each(|(f, k)| *f -= k);
        }
        let rhs = elimination.gather(&force).0;
        let symbolic = Symbolic::analyze(&pencil)?;
        let factor = symbolic.factorize(pencil.stiffness().clone()).map_err(|error| self.not_held(error))?;
        // The second column asks whether a motion of the whole model comes back from its own forces.
        let (moved, n) = (self.moved(&elimination), rhs.len());
        let mut solution = Mat::from_fn(n, 2, |i, k| if k == 0 { rhs[i] } else { moved[i] });
        let mut forces = Mat::zeros(n, 1);
        pencil.stiffness().mul_into(solution.as_ref().subcols(1, 1), forces.as_mut());
        solution.col_mut(1).copy_from(forces.col(0));
        Solve::new(&symbolic, 2, true).solve_in_place(&factor, solution.as_mut());
        let off = solution.col_as_slice(1).iter().zip(&moved).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let largest = moved.iter().map(|x| x.abs()).fold(0.0, f64::max);
        if off > UNSETTLED * largest || !solution.as_ref().is_all_finite() {
            return Err(self.loose());
        }
        let displacement = elimination.expand(solution.col_as_slice(0));
        Ok(Solved { elimination, load, thermal, rhs, displacement })
    }

    /// A translation with a rotation about the middle of the model, over the free dofs.
    fn moved(&self, elimination: &Elimination) -> Vec<f64> {
        let (low, high) = self.deck.mesh.bounding_box();
        let size = (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max);
        let (shift, turn) = ([1.0, 0.9, 0.8], [1.0, 0.7, 0.5].map(|x| x / size));
        let of_dof = |&dof: &u32| {
            let (node, c) = (dof / 3, dof as usize % 3);
            if node as usize >= self.deck.node_count() {
                return turn[c];
            }
            let at = self.deck.place(node);
            let arm: [f64; 3] = std::array::from_fn(|k| at[k] - 0.5 * (low[k] + high[k]));
            shift[c] + turn[(c + 1) % 3] * arm[(c + 2) % 3] - turn[(c + 2) % 3] * arm[(c + 1) % 3]
        };
        elimination.free().iter().map(of_dof).collect()
    }

    /// Mass and stiffness of a step, about the state of a static step where the deck asks for it.
    fn pencil(&self, step: Option<&Step>, elimination: &Elimination) -> Result<Pencil, DeckError> {
        let before = step.and_then(|step| self.deck.steps.get(step.about?));
        let elements = self.heated(before.map_or(&[], |before| &before.temperatures));
        let unloaded = assemble_blocks(&elements, &self.blocks, elimination)?;
        let Some(before) = before else { return Ok(unloaded) };
        let rotations = before.loads.iter().filter_map(rotation).collect();
        let displacement = self.solve(before)?.displacement;
        // CalculiX keeps inner functions, and takes strains about the displaced body.
        let state = Prestress { displacement, free: vec![], rotations, displaced: self.deck.of_calculix };
        let mut blocks = self.blocks.clone();
        for (value, facets) in self.pressures(&before.loads)? {
            blocks.extend(pressure_stiffness(&self.deck.mesh, &facets, value, &state.displacement));
        }
        let loaded = assemble_blocks(&elements.about(&state), &blocks, elimination)?;
        let symbolic = Symbolic::analyze(&loaded)?;
        match symbolic.factorize(loaded.stiffness().clone()) {
            Ok(_) => Ok(loaded),
            Err(FactorError::NotPositiveDefinite { .. }) => {
                let factor = buckling_factor(&symbolic, unloaded.stiffness(), loaded.stiffness())?;
                Err(DeckError::Buckled { step: before.name.clone(), factor })
            }
            Err(error) => Err(error.into()),
        }
    }

    /// The `count` lowest natural modes under the supports of the model and of the first step that asks for
    /// frequencies.
    ///
    /// # Errors
    /// [`DeckError`], by cause.
    pub fn modes(&self, count: usize) -> Result<Modes, DeckError> {
        if !self.deck.has_mass() {
            return Err(DeckError::Incomplete {
                material: self.without_density(),
                quantity: "density",
                card: "*DENSITY (RHO of MAT1, DENS)",
            });
        }
        let frequency = |step: &&Step| matches!(step.kind, StepKind::Frequency(_));
        let step = self.deck.steps.iter().find(frequency).or(self.deck.steps.first());
        let supports = step.map_or(&[][..], |step| &step.supports);
        let elimination = self.elimination(supports)?;
        let mut pencil = self.pencil(step, &elimination)?;
        if self.is_free(supports) {
            pencil = self.with_rigid_motions(pencil, &elimination);
        }
        let symbolic = Symbolic::analyze(&pencil)?;
        let count = count.min(pencil.n_elastic());
        let found = lowest_modes(&pencil, &symbolic, count).map_err(|error| match error {
            ModesError::Factor(error) => self.not_held(error),
            other => other.into(),
        })?;
        let shape = |mode: usize| {
            let mut shape = self.of_nodes(&elimination.expand(found.vectors.col_as_slice(mode)));
            let length = |u: &[f64; 3]| u.iter().map(|x| x * x).sum::<f64>().sqrt();
            let largest = shape.iter().map(length).fold(f64::MIN_POSITIVE, f64::max);
            shape.iter_mut().flatten().for_each(|x| *x /= largest);
            shape
        };
        Ok(Modes {
            frequencies_hz: found.frequencies_hz(),
            shapes: (0..found.vectors.ncols()).map(shape).collect(),
            residuals: found.residuals.clone(),
            rigid_motions: pencil.n_dof() - pencil.n_elastic(),
            dofs: pencil.n_dof(),
        })
    }

    /// True of a deck without a support or a spring to the ground.
    fn is_free(&self, supports: &[Support]) -> bool {
        let to_ground = |one: &Attachment| match one {
            Attachment::Spring(Spring::Components { ends, .. }) => ends.len() == 1,
            _ => false,
        };
        let grounded = self.deck.attachments.iter().any(to_ground);
        !grounded && self.deck.supports.is_empty() && supports.is_empty()
    }

    /// The pencil of a free body, if all links and attachments let it move as a whole.
    fn with_rigid_motions(&self, pencil: Pencil, elimination: &Elimination) -> Pencil {
        let nodes = &self.deck.mesh.nodes;
        if self.deck.links.is_empty() && elimination.n_free() == 3 * nodes.len() {
            return pencil.of_free_body(nodes);
        }
        let (low, high) = self.deck.mesh.bounding_box();
        let size = (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max);
        let rows = self.dofs.rigid_rows(self.deck, std::array::from_fn(|c| 0.5 * (low[c] + high[c])));
        for motion in 0..6 {
            let unit = if motion < 3 { 1.0 } else { size };
            let of_free = |&dof: &u32| rows[dof as usize][motion];
            let found = elimination.expand(&elimination.free().iter().map(of_free).collect::<Vec<_>>());
            // A reference node may follow a mean that is no rigid motion: it moves as its link has it.
            let solid = rows[..3 * nodes.len()].iter().zip(&found);
            let off = solid.map(|(row, u)| (u - row[motion]).abs()).fold(0.0, f64::max);
            let strains = self.blocks.iter().any(|Block { dofs, stiffness, .. }| {
                let weight =
                    |i: usize| rows[dofs[i] as usize].iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                let parts = |i: usize| -> Vec<f64> {
                    let part = |j: usize| weight(i) * stiffness[(i, j)] * found[dofs[j] as usize];
                    (0..dofs.len()).map(part).collect()
                };
                let largest = |of: &dyn Fn(usize) -> f64| (0..dofs.len()).map(of).fold(0.0, f64::max);
                let force = largest(&|i| parts(i).iter().sum::<f64>().abs());
                force > RIGID * largest(&|i| parts(i).iter().map(|x| x.abs()).sum())
            });
            if off > RIGID * unit || strains {
                return pencil;
            }
        }
        let free = elimination.free();
        let of_free = |about: [f64; 3]| {
            let rows = self.dofs.rigid_rows(self.deck, about);
            free.iter().map(|&dof| rows[dof as usize]).collect()
        };
        pencil.of_free_rows(of_free, |place| (free[place] as usize) < 3 * nodes.len())
    }

    /// Links, supports of the model and of a step; dofs that nothing moves are held.
    fn elimination(&self, supports: &[Support]) -> Result<Elimination, DeckError> {
        let mut constraints = Constraints::default();
        link(self.deck, &self.dofs, self.is_free(supports), &mut constraints)?;
        let mut moved = vec![false; self.dofs.count()];
        moved[..3 * self.deck.mesh.nodes.len()].fill(true);
        moved[self.dofs.of_nodes()..].fill(true);
        self.blocks.iter().flat_map(|block| &block.dofs).for_each(|&dof| moved[dof as usize] = true);
        constraints.dofs().for_each(|dof| moved[dof as usize] = true);
        (0..moved.len()).filter(|&dof| !moved[dof]).for_each(|dof| constraints.hold(dof as u32, 0.0));
        for support in self.deck.supports.iter().chain(supports) {
            if let Some(dof) = self.dofs.nodal(support.node, support.component) {
                constraints.hold(dof, support.value);
            }
        }
        Ok(constraints.eliminate(self.dofs.count())?)
    }

    /// Forces of a step over all dofs.
    fn load(&self, loads: &[Load]) -> Result<Vec<f64>, DeckError> {
        let (deck, n) = (self.deck, self.dofs.count());
        let mut load = vec![0.0; n];
        let add = |load: &mut [f64], forces: Vec<f64>| {
            load.iter_mut().zip(forces).for_each(|(sum, f)| *sum += f);
        };
        for one in loads {
            match one {
                Load::Force { node, component, value } => {
                    if let Some(dof) = self.dofs.nodal(*node, *component) {
                        load[dof as usize] += value;
                    }
                }
                Load::Acceleration { on, value } => {
                    add(&mut load, self.inertia(on, |_| *value)?);
                }
                Load::Rotation { on, .. } => {
                    let rotation = rotation(one).expect("a load by rotation");
                    add(&mut load, self.inertia(on, |at| rotation.acceleration(at))?);
                }
                Load::Pressure { .. } => {}
                Load::Traction { faces, value } => {
                    let facets = surface_facets(&deck.mesh, faces)?;
                    let forces = facet_load(&deck.mesh, &facets, |normal| {
                        let area = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
                        value.map(|t| t * area)
                    });
                    add(&mut load, forces);
                }
            }
        }
        for (value, facets) in self.pressures(loads)? {
            add(&mut load, facet_load(&deck.mesh, &facets, |normal| normal.map(|n| -value * n)));
        }
        Ok(load)
    }

    /// Pressures, and the facets that each acts on. Programs write a pressure for each face: those of one
    /// value are found together.
    fn pressures(&self, loads: &[Load]) -> Result<Vec<(f64, Vec<Facet>)>, DeckError> {
        let mut pressures: BTreeMap<u64, Vec<[u32; 3]>> = BTreeMap::new();
        for one in loads {
            if let Load::Pressure { faces, value } = one {
                pressures.entry(value.to_bits()).or_default().extend_from_slice(faces);
            }
        }
        let found = |(bits, faces): (u64, Vec<[u32; 3]>)| {
            Ok((f64::from_bits(bits), surface_facets(&self.deck.mesh, &faces)?))
        };
        pressures.into_iter().map(found).collect()
    }

    /// Forces of an acceleration, on elements and, where it acts on all of the model, on masses.
    fn inertia(
        &self,
        on: &Extent,
        field: impl Fn([f64; 3]) -> [f64; 3] + Sync,
    ) -> Result<Vec<f64>, DeckError> {
        let of_element = |element: usize, at: [f64; 3]| match on {
            Extent::All => Some(field(at)),
            Extent::Elements(chosen) => chosen.binary_search(&(element as u32)).is_ok().then(|| field(at)),
        };
        let mut forces = inertia_forces(&self.elements, self.dofs.count(), of_element)?;
        if *on == Extent::All {
            for attachment in &self.deck.attachments {
                let masses: Vec<(NodeNumber, f64)> = match attachment {
                    Attachment::Mass { node, mass, .. } => vec![(*node, *mass)],
                    Attachment::Beam { ends, mass, .. } => ends.iter().map(|&end| (end, *mass)).collect(),
                    _ => vec![],
                };
                for (node, mass) in masses {
                    let a = field(self.deck.place(node));
                    (0..3).for_each(|c| forces[3 * node as usize + c] += mass * a[c]);
                }
            }
        }
        Ok(forces)
    }

    /// Displacements along the axes of space.
    fn of_nodes(&self, displacement: &[f64]) -> Vec<[f64; 3]> {
        displacement[..3 * self.deck.node_count()].as_chunks::<3>().0.to_vec()
    }

    /// Sum of the forces that supports take, along the axes of space.
    fn reaction_sum(&self, step: &Step, elimination: &Elimination, reactions: &[f64]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        let mut counted = BTreeSet::new();
        for support in self.deck.supports.iter().chain(&step.supports).filter(|support| support.component < 3)
        {
            let Some(dof) = self.dofs.nodal(support.node, support.component) else { continue };
            let place = elimination.held().binary_search_by_key(&dof, |held| held.0);
            let (Ok(place), true) = (place, counted.insert(dof)) else { continue };
            let component = usize::from(support.component);
            let axes = self.deck.axes.get(&support.node).filter(|_| self.dofs.has_axes(support.node));
            let axis = axes.map_or_else(
                || std::array::from_fn(|c| f64::from(u8::from(c == component))),
                |axes| axes[component],
            );
            (0..3).for_each(|c| sum[c] += reactions[place] * axis[c]);
        }
        sum
    }

    /// The error of a factorisation: if the model can move, its bodies.
    fn not_held(&self, error: FactorError) -> DeckError {
        if !matches!(error, FactorError::NotPositiveDefinite { .. }) {
            return error.into();
        }
        self.loose()
    }

    /// The error of a model that can move, with its bodies and the contact that is not computed.
    fn loose(&self) -> DeckError {
        let parts = self.deck.parts();
        let nodes: Vec<String> = parts.iter().take(8).map(|node| self.deck.id(*node).to_string()).collect();
        let contact = self.deck.left_out.iter().find(|left| left.card.starts_with("*CONTACT"));
        let contact = contact.map_or(String::new(), |left| {
            format!("; the deck joins them by {} at line {}, which is not computed", left.card, left.line)
        });
        DeckError::NotHeld { parts: parts.len(), nodes: nodes.join(", "), contact }
    }

    fn without_density(&self) -> String {
        let bare = self.deck.materials.iter().position(|material| material.density <= 0.0);
        bare.and_then(|region| self.deck.mesh.regions.get(region)).map_or(String::new(), |r| r.name.clone())
    }
}

/// The rotation of a load by one.
fn rotation(load: &Load) -> Option<Rotation> {
    let Load::Rotation { on, speed_squared, point, axis } = load else { return None };
    let elements = match on {
        Extent::All => None,
        Extent::Elements(chosen) => Some(chosen.clone()),
    };
    Some(Rotation { elements, speed_squared: *speed_squared, point: *point, axis: *axis })
}

/// The matrices of an attachment; none of a dashpot.
fn block(deck: &Deck, dofs: &Dofs, attachment: &Attachment) -> Option<Block> {
    let global = |node: NodeNumber, c: u8| dofs.global(node, c);
    match attachment {
        Attachment::Mass { node, mass, inertia } => {
            let turning = *inertia != [0.0; 6];
            let n = if turning { 6 } else { 3 };
            let of: Option<Vec<u32>> = (0..n).map(|c| global(*node, c)).collect();
            let entry = |i: usize, j: usize| match (i, j) {
                (0..3, 0..3) if i == j => *mass,
                (3.., 3..) => {
                    let place = [[0, 3, 4], [3, 1, 5], [4, 5, 2]][i - 3][j - 3];
                    inertia[place] * if i == j { 1.0 } else { -1.0 }
                }
                _ => 0.0,
            };
            let n = usize::from(n);
            Some(Block { dofs: of?, stiffness: Mat::zeros(n, n), mass: Mat::from_fn(n, n, entry) })
        }
        Attachment::Dashpot(_) => None,
        Attachment::Spring(Spring::Line { ends, stiffness }) => {
            let [a, b] = ends.map(|end| deck.place(end));
            let length = (0..3).map(|c| (b[c] - a[c]).powi(2)).sum::<f64>().sqrt();
            let along = |i: usize| (b[i % 3] - a[i % 3]) / length * if i < 3 { -1.0 } else { 1.0 };
            let of: Option<Vec<u32>> = (0..6_u8).map(|k| global(ends[usize::from(k) / 3], k % 3)).collect();
            let stiffness = Mat::from_fn(6, 6, |i, j| stiffness * along(i) * along(j));
            (length > 0.0).then_some(())?;
            Some(Block { dofs: of?, stiffness, mass: Mat::zeros(6, 6) })
        }
        Attachment::Spring(Spring::Components { ends, stiffness }) => {
            let of: Option<Vec<u32>> = ends.iter().map(|&(node, c)| dofs.nodal(node, c)).collect();
            let n = ends.len();
            let stiffness = Mat::from_fn(n, n, |i, j| if i == j { *stiffness } else { -stiffness });
            Some(Block { dofs: of?, stiffness, mass: Mat::zeros(n, n) })
        }
        Attachment::Beam { ends, stiffness, mass } => {
            let of: Option<Vec<u32>> = (0..12_u8).map(|k| global(ends[usize::from(k) / 6], k % 6)).collect();
            let matrix = Mat::from_fn(12, 12, |i, j| stiffness[12 * i + j]);
            let heavy = |i: usize, j: usize| if i == j && i % 6 < 3 { *mass } else { 0.0 };
            Some(Block { dofs: of?, stiffness: matrix, mass: Mat::from_fn(12, 12, heavy) })
        }
    }
}
