//! Foundations under facets of every kind: areas, moments, and a column that its ground compresses.

use std::collections::BTreeMap;

use faer::MatRef;

use super::blocks::Block;
use super::loads::{Facet, facet_load, facet_matrix, surface_facets};
use super::material::Material;
use super::model::{Attachments, Model};
use crate::linalg::vec3::{dot, norm};
use crate::mesh::shapes::reference_nodes;
use crate::mesh::surface::Surface;
use crate::mesh::{ElementKind, FacetKind, Mesh, Region};

/// One element.
fn element(kind: ElementKind, place: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh {
    let nodes: Vec<[f64; 3]> = reference_nodes(kind).into_iter().map(place).collect();
    Mesh {
        node_ids: (1..=nodes.len() as u64).collect(),
        elements: (0..nodes.len() as u32).collect(),
        kinds: std::iter::once(kind).collect(),
        nodes,
        element_region: vec![0],
        regions: vec![Region::new(1, "body")],
        node_groups: BTreeMap::new(),
        facet_groups: BTreeMap::new(),
        notes: vec![],
    }
}

fn facets(mesh: &Mesh) -> Vec<Facet> {
    let surface = Surface::of(mesh);
    let corners = (0..surface.facet_count()).map(|f| std::array::from_fn(|k| surface.facet(f)[k]));
    surface_facets(mesh, &corners.collect::<Vec<_>>()).unwrap()
}

/// A map without symmetry that bends faces.
fn bent([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x + 0.11 * y * z + 0.05 * y * y, 1.3 * y - 0.07 * x * x + 0.04 * z, 0.8 * z + 0.09 * x * y]
}

#[test]
fn a_motion_along_the_normal_is_a_pressure_on_facets_of_every_kind() {
    let mut seen: Vec<FacetKind> = vec![];
    for kind in ElementKind::all() {
        let mesh = element(kind, bent);
        for facet in facets(&mesh) {
            // A shift answers with the stiffness along its part that is normal, and along the rest.
            let (p, t, shift) = (3.0, 0.7, [0.4, -1.1, 0.6]);
            let matrix = facet_matrix(&mesh, &facet, p, t);
            let expected = facet_load(&mesh, &[facet], |normal| {
                let area = norm(normal);
                let along = dot(normal, shift) / area;
                std::array::from_fn(|c| t * area * shift[c] + (p - t) * along * normal[c])
            });
            for (a, &node) in facet.nodes().iter().enumerate() {
                for c in 0..3 {
                    let n = 3 * facet.nodes().len();
                    let found: f64 = (0..n).map(|j| matrix[(3 * a + c, j)] * shift[j % 3]).sum();
                    let wanted = expected[3 * node as usize + c];
                    assert!((found - wanted).abs() < 1e-13, "{kind:?}: {found} for {wanted}");
                }
            }
            let symmetric = (&matrix - matrix.transpose()).norm_max();
            assert!(symmetric < 1e-15, "{kind:?}: {symmetric}");
            seen.push(facet.kind());
        }
    }
    let all = [FacetKind::Tri3, FacetKind::Tri6, FacetKind::Quad4, FacetKind::Quad8, FacetKind::Quad9];
    assert!(all.iter().all(|kind| seen.contains(kind)), "{seen:?}");
}

#[test]
fn moments_of_flat_facets_are_exact() {
    // ∫ x_i x_j over a parallelogram or a triangle from its corners and the middles of its sides (Simpson).
    let sheared = |[x, y, z]: [f64; 3]| [1.2 * x + 0.3 * y - 0.2 * z, 0.9 * y + 0.4 * x, 1.1 * z - 0.3 * y];
    for kind in ElementKind::all() {
        let mesh = element(kind, sheared);
        for facet in facets(&mesh) {
            let corners: Vec<[f64; 3]> =
                facet.nodes()[..facet.kind().corners()].iter().map(|&n| mesh.nodes[n as usize]).collect();
            let area = norm(
                facet_load(&mesh, &[facet], |n| n)
                    .chunks(3)
                    .fold([0.0; 3], |sum, f| std::array::from_fn(|c| sum[c] + f[c])),
            );
            let count = corners.len();
            let middles: Vec<[f64; 3]> = (0..count)
                .map(|k| std::array::from_fn(|c| 0.5 * (corners[k][c] + corners[(k + 1) % count][c])))
                .collect();
            let middle: [f64; 3] =
                std::array::from_fn(|c| corners.iter().map(|x| x[c]).sum::<f64>() / count as f64);
            let moment = |i: usize, j: usize| {
                let of = |x: &[f64; 3]| x[i] * x[j];
                match count {
                    3 => area / 3.0 * middles.iter().map(of).sum::<f64>(),
                    _ => {
                        let edges = 4.0 * middles.iter().map(of).sum::<f64>();
                        area / 36.0 * (corners.iter().map(of).sum::<f64>() + edges + 16.0 * of(&middle))
                    }
                }
            };
            let matrix = facet_matrix(&mesh, &facet, 1.0, 1.0);
            let at = |row: usize| mesh.nodes[facet.nodes()[row / 3] as usize];
            for i in 0..3 {
                for j in 0..3 {
                    // Displacements along x by two coordinates.
                    let rows = (0..matrix.nrows()).step_by(3);
                    let entry = |a: usize, b: usize| at(a)[i] * matrix[(a, b)] * at(b)[j];
                    let found: f64 = rows.clone().flat_map(|a| rows.clone().map(move |b| entry(a, b))).sum();
                    assert!((found - moment(i, j)).abs() < 1e-13, "{kind:?}: {found} for {}", moment(i, j));
                }
            }
        }
    }
}

#[test]
fn a_column_on_its_ground_is_compressed_evenly() {
    // u_z = −p (1/k + (z − z_0)/E) is in every element; ν = 0, so that nothing moves sideways.
    let (young, ground, pressure) = (7.0, 3.0, 0.2);
    for kind in ElementKind::all() {
        let mesh = element(kind, |[x, y, z]| [1.2 * x + 0.3 * y - 0.2 * z, 0.9 * y + 0.1 * z, 1.1 * z]);
        let lowest = mesh.nodes.iter().map(|x| x[2]).fold(f64::INFINITY, f64::min);
        let below = |facet: &Facet| facet.nodes().iter().all(|&n| mesh.nodes[n as usize][2] < lowest + 1e-9);
        let (base, rest): (Vec<Facet>, Vec<Facet>) = facets(&mesh).into_iter().partition(below);
        assert_eq!(base.len(), 1, "{kind:?}");
        let blocks = base.iter().map(|facet| {
            let dofs: Vec<u32> = facet.nodes().iter().flat_map(|&n| 3 * n..3 * n + 3).collect();
            let mass = faer::Mat::zeros(dofs.len(), dofs.len());
            Block { stiffness: facet_matrix(&mesh, facet, ground, 0.5), mass, dofs }
        });
        let attached = Attachments { blocks: blocks.collect(), ..Attachments::default() };
        // The traction of the even stress on every other facet.
        let load = facet_load(&mesh, &rest, |normal| [0.0, 0.0, -pressure * normal[2]]);
        let shift = |z: f64| -pressure * (1.0 / ground + (z - lowest) / young);
        let exact: Vec<f64> = mesh.nodes.iter().flat_map(|x| [0.0, 0.0, shift(x[2])]).collect();
        let free = vec![false; exact.len()];
        let solid = Material::isotropic(young, 0.0, 1.0);
        let model = Model::assemble_attached(mesh.clone(), &[solid], &free, attached).unwrap();
        let mut answer = faer::Mat::zeros(exact.len(), 1);
        let column = MatRef::from_column_major_slice(&exact, exact.len(), 1);
        model.pencil().stiffness().mul_into(column, answer.as_mut());
        for (dof, wanted) in load.iter().enumerate() {
            let found = answer[(dof, 0)];
            assert!((found - wanted).abs() < 1e-13, "{kind:?} dof {dof}: {found} for {wanted}");
        }
    }
}
