//! A beam bent far beyond small displacements, here and by CalculiX with `NLGEOM`.
//!
//! CalculiX reads `*ELASTIC` as the linear relation between Green–Lagrange strain and the second
//! Piola–Kirchhoff stress, which is the law of St. Venant and Kirchhoff. It integrates a linear tetrahedron
//! with one point, which is exact, and a quadratic one with four, which are not enough for the energy at
//! large displacements. Hexahedra and wedges have the same points here and there.

use std::fmt::Write as _;
use std::path::Path;

use vademecum_build::dynamics::large::{Newton, RestOptions, rest};
use vademecum_build::fem::{Elasticity, GreenStrain, Material, Model, Symbolic};
use vademecum_build::mesh::{ElementKind, Hexahedra, Mesh};

use super::{bodies, calculix, deck};

const RUBBER: Material = Material::isotropic(1e7, 0.3, 1000.0);

/// The force on the end \[N\].
const FORCE: [f64; 3] = [-20.0, 90.0, 60.0];

/// How far the two programs are apart.
#[derive(Clone, Copy, Debug)]
pub struct Bent {
    /// Largest displacement of a node \[m\]; the beam is 1 m long.
    pub largest: f64,
    /// Largest difference of two displacements, as a part of the largest displacement.
    pub apart: f64,
    /// The same without large displacements here: how much they matter.
    pub linear: f64,
}

/// Bends a beam of one kind of element under a dead force that its end shares.
///
/// # Panics
/// If anything fails, CalculiX too.
#[must_use]
pub fn bend(kind: ElementKind, formulation: Hexahedra, folder: &Path) -> Bent {
    let mesh = match kind {
        ElementKind::Tet4 => bodies::linear_beam(),
        ElementKind::Tet10 => bodies::beam(),
        _ => bodies::beam_of(kind, formulation),
    };
    let held: Vec<bool> = mesh.nodes.iter().flat_map(|x| [x[0] == 0.0; 3]).collect();
    let end: Vec<u32> =
        (0..mesh.nodes.len() as u32).filter(|&node| mesh.nodes[node as usize][0] == 1.0).collect();
    let share = FORCE.map(|f| f / end.len() as f64);
    let theirs = answer(&mesh, &end, share, folder);
    let model = Model::assemble(mesh, &[RUBBER], &held).expect("a model");
    let dofs = model.dofs();
    let mut load = vec![0.0; dofs.n_free()];
    end.iter().for_each(|&node| model.add_point_force(&[node], &[1.0], share, &mut load));
    let strain = GreenStrain::new(&model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    let options = RestOptions {
        parts: 4,
        newton: Newton { tolerance: 1e-10, ..Newton::default() },
        ..RestOptions::default()
    };
    let mut path = |s: f64, f: &mut [f64]| f.iter_mut().zip(&load).for_each(|(f, load)| *f = s * load);
    let found = rest(&strain, &symbolic, &vec![0.0; load.len()], &mut path, &options).expect("a rest");
    let factor = symbolic.factor_of(model.pencil().stiffness()).expect("a factor");
    let mut linear = faer::Mat::from_fn(load.len(), 1, |i, _| load[i]);
    vademecum_build::fem::Solve::new(&symbolic, 1, true).solve_in_place(&factor, linear.as_mut());
    let size = |u: [f64; 3]| u.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = theirs.iter().map(|u| size(*u)).fold(0.0, f64::max);
    let apart = |free: &[f64]| {
        let mut ours = vec![0.0; dofs.n_dof()];
        dofs.expand_into(free, &mut ours);
        let pairs = ours.as_chunks::<3>().0.iter().zip(&theirs);
        pairs.map(|(a, b)| size(std::array::from_fn(|i| a[i] - b[i]))).fold(0.0, f64::max) / largest
    };
    Bent { largest, apart: apart(&found.displacement), linear: apart(linear.col_as_slice(0)) }
}

/// The displacements that CalculiX finds.
fn answer(mesh: &Mesh, end: &[u32], share: [f64; 3], folder: &Path) -> Vec<[f64; 3]> {
    deck::write(&folder.join("bent.inp"), mesh);
    let mut text = String::from("*INCLUDE, INPUT=bent.inp\n*MATERIAL, NAME=material\n*ELASTIC\n");
    let Elasticity::Isotropic { young, poisson } = RUBBER.elasticity else { panic!("rubber is isotropic") };
    let _ = writeln!(text, "{young:e}, {poisson:e}");
    text.push_str("*SOLID SECTION, ELSET=body, MATERIAL=material\n*BOUNDARY\nx_min, 1, 3\n");
    // Ends at a ten-millionth of what it takes by default.
    text.push_str(
        "*STEP, NLGEOM, INC=1000\n*CONTROLS, PARAMETERS=FIELD\n1e-9, 1e-9\n*STATIC\n0.1, 1.0\n*CLOAD\n",
    );
    for &node in end {
        for (c, f) in share.iter().enumerate() {
            let _ = writeln!(text, "{}, {}, {f:.12e}", mesh.node_ids[node as usize], c + 1);
        }
    }
    text.push_str("*NODE PRINT, NSET=all, FREQUENCY=1000\nU\n*END STEP\n");
    std::fs::write(folder.join("bent-calculix.inp"), text).expect("the deck is written");
    let answer = calculix::answer(folder, "bent-calculix");
    let found = answer.of_mesh(mesh);
    assert_eq!(found.len(), mesh.nodes.len(), "{}", answer.said);
    found
}
