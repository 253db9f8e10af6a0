//! The march: order in time, what it keeps, what it damps, and the linear march at small amplitudes.

use super::test_beam::{end_load, moved, nearest};
use super::vectors::{add, dot, sum, times};
use super::{LargeDamping, LargeError, LargeMarch, LargeScheme, LargeState, Newton, Relaxation, march_large};
use crate::dynamics::schemes::{SchemeKind, bathe, newmark};
use crate::dynamics::{FullOrder, History, Interval, Rayleigh, TimedLoad, lowest_modes, march_full_order};
use crate::fem::test_mesh::{block, hold, quadratic};
use crate::fem::{GreenStrain, Material, Model, Symbolic};
use crate::linalg::Random;
use crate::mesh::Region;
use crate::progress::Silent;

const RUBBER: Material = Material::isotropic(1e7, 0.3, 1000.0);

/// A beam with its first period near 0.3 s, of two materials.
fn beam() -> Model {
    let mut mesh = quadratic(&block([6, 1, 1], [1.0, 0.2, 0.15]));
    mesh.regions.push(Region::new(2, "stiff"));
    let centre = |e: usize| mesh.element(e)[..4].iter().map(|&n| mesh.nodes[n as usize][0]).sum::<f64>();
    mesh.element_region = (0..mesh.element_count()).map(|e| u32::from(centre(e) > 2.0)).collect();
    let held = hold(&mesh, |[x, _, _]| x == 0.0);
    Model::assemble(mesh, &[RUBBER, Material::isotropic(3e7, 0.3, 1000.0)], &held).expect("a model")
}

/// A push of the end and the weight, over 0.2 s: the tip moves by half the length.
fn push(model: &Model, scale: f64) -> impl FnMut(f64, &mut [f64]) + use<> {
    let tip = end_load(model, [0.0, 3.0e4 * scale, 1.5e4 * scale], |_| 1.0);
    let weight = model.free_part(&model.body_load([0.0, 0.0, -9.81 * scale]));
    move |t, f| {
        if t < 0.2 {
            add(f, (std::f64::consts::PI * t / 0.2).sin().powi(2), &tip);
        }
        add(f, 1.0, &weight);
    }
}

struct Run {
    end: LargeState,
    largest: f64,
    corrections: usize,
    factorisations: usize,
}

fn run(
    model: &Model,
    scheme: LargeScheme,
    damping: LargeDamping,
    dt: f64,
    steps: usize,
    newton: Newton,
    scale: f64,
) -> Run {
    let strain = GreenStrain::new(model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    let march = LargeMarch::new(&strain, &symbolic, scheme, dt, damping, newton).expect("a march");
    let zero = vec![0.0; strain.n_dof()];
    let node = nearest(model, [1.0, 0.1, 0.075]);
    let (mut end, mut largest) = (None, 0.0_f64);
    let work = march_large(&march, [&zero, &zero], &mut push(model, scale), steps, &Silent, |state| {
        largest = largest
            .max(dot(&moved(model, &state.displacement, node), &moved(model, &state.displacement, node)));
        end = Some(state.clone());
    });
    let work = work.expect("a motion");
    assert_eq!(work.halvings, 0);
    let end = end.expect("a state");
    Run { end, largest: largest.sqrt(), corrections: work.corrections, factorisations: work.factorisations }
}

fn apart(model: &Model, a: &LargeState, b: &LargeState) -> f64 {
    let off = sum(&a.displacement, -1.0, &b.displacement);
    let mass = model.pencil().mass();
    (mass.inner(&off, &off) / mass.inner(&b.displacement, &b.displacement)).sqrt()
}

#[test]
fn every_scheme_is_of_second_order_with_every_damping() {
    let model = beam();
    let damping = LargeDamping { mass: 0.5, stiffness: 1e-4, strain_rate: 2e-4 };
    let time = 0.24;
    let at = |scheme, steps: usize| {
        run(&model, scheme, damping, time / steps as f64, steps, Newton::default(), 1.0)
    };
    let fine = at(LargeScheme::bathe(), 960);
    println!("tip moves {:.3}", fine.largest);
    assert!(fine.largest > 0.3);
    for (name, scheme) in [
        ("Bathe", LargeScheme::bathe()),
        ("trapezoidal", LargeScheme::Table(newmark(0.25, 0.5).expect("stable constants"))),
        ("energy-momentum", LargeScheme::EnergyMomentum),
        ("rho-Bathe", LargeScheme::of(SchemeKind::RhoBathe { rho_infinity: 0.5 }).expect("a scheme")),
    ] {
        let runs = [60, 120].map(|steps| at(scheme, steps));
        let [coarse, half] = [&runs[0], &runs[1]].map(|run| apart(&model, &run.end, &fine.end));
        let order = (coarse / half).log2();
        println!(
            "{name}: {coarse:.2e} {half:.2e}, order {order:.2}; {:.2} corrections and {:.2} factors a step",
            runs[0].corrections as f64 / 60.0,
            runs[0].factorisations as f64 / 60.0
        );
        // Higher terms of the error are one part in ten at these steps, and the reference has 1/64 of it.
        assert!((order - 2.0).abs() < 0.25, "{name} {order}");
    }
}

#[test]
fn a_small_motion_is_the_linear_march() {
    let model = beam();
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).expect("a structure");
    let n = pencil.n_dof();
    let rayleigh = Rayleigh { alpha: 0.7, beta: 1e-3 };
    let linear = FullOrder::new(pencil, &symbolic, &bathe(), 0.01, rayleigh).expect("a march");
    let force = end_load(&model, [0.0, 1.0, 0.5], |_| 1.0);
    let during = Interval { start: 0.02, end: 0.11, ramp: 0.03 };
    let loads = [TimedLoad { column: 0, force, when: History::from(during) }];
    let mut expected = vec![];
    march_full_order(&linear, &loads, 1, 20, &Silent, |_, state| {
        expected = state.displacement.col_as_slice(0).to_vec();
    })
    .expect("a motion");
    // Rayleigh's damping and that of the strain rate are the same for small motions.
    for damping in [
        LargeDamping { mass: 0.7, stiffness: 1e-3, strain_rate: 0.0 },
        LargeDamping { mass: 0.7, stiffness: 0.0, strain_rate: 1e-3 },
    ] {
        let strain = GreenStrain::new(&model).expect("a strain field");
        let march =
            LargeMarch::new(&strain, &symbolic, LargeScheme::bathe(), 0.01, damping, Newton::default());
        let march = march.expect("a march");
        let zero = vec![0.0; n];
        let mut found = vec![];
        march_large(&march, [&zero, &zero], &mut timed_force(&loads, 0), 20, &Silent, |state| {
            found = state.displacement.clone();
        })
        .expect("a motion");
        let off = sum(&found, -1.0, &expected);
        let relative = (dot(&off, &off) / dot(&expected, &expected)).sqrt();
        println!("{relative:.1e}");
        // The load bends the beam by some 1e-5 of its length.
        assert!(relative < 1e-4, "{relative}");
    }
}

#[test]
fn the_energy_momentum_scheme_keeps_energy_to_rounding() {
    let model = beam();
    let strain = GreenStrain::new(&model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    // A blow: the velocity grows with the square of the distance.
    let places =
        model.dofs().dof_of_free().iter().map(|&dof| (model.mesh().nodes[dof as usize / 3][0], dof % 3));
    let velocity: Vec<f64> = places.map(|(x, c)| if c == 1 { 12.0 * x * x } else { 0.0 }).collect();
    let zero = vec![0.0; velocity.len()];
    let newton = Newton { tolerance: 1e-13, ..Newton::default() };
    let drift = |scheme| {
        let march = LargeMarch::new(&strain, &symbolic, scheme, 0.008, LargeDamping::default(), newton);
        let march = march.expect("a march");
        let mut energies = vec![];
        march_large(&march, [&zero, &velocity], &mut |_, _| {}, 60, &Silent, |state| {
            energies.push(march.energy(state));
        })
        .expect("a motion");
        energies.iter().map(|e| (e / energies[0] - 1.0).abs()).fold(0.0, f64::max)
    };
    let [kept, lost] = [LargeScheme::EnergyMomentum, LargeScheme::bathe()].map(drift);
    println!("energy-momentum {kept:.1e}, Bathe {lost:.1e}");
    assert!(kept < 1e-12 && lost > 1e-4, "{kept} {lost}");
}

/// Linear momentum, and angular momentum about the origin.
fn momenta(model: &Model, state: &LargeState) -> [f64; 6] {
    let p = times(model.pencil().mass(), &state.velocity);
    let mut out = [0.0; 6];
    for ((x, u), p) in
        model.mesh().nodes.iter().zip(state.displacement.as_chunks::<3>().0).zip(p.as_chunks::<3>().0)
    {
        let at: [f64; 3] = std::array::from_fn(|i| x[i] + u[i]);
        let moment = crate::linalg::vec3::cross(at, *p);
        (0..3).for_each(|i| (out[i], out[3 + i]) = (out[i] + p[i], out[3 + i] + moment[i]));
    }
    out
}

#[test]
fn a_free_body_keeps_its_momenta_and_strain_rate_damping_does_not_slow_its_turning() {
    let mesh = quadratic(&block([3, 1, 1], [1.0, 0.3, 0.2]));
    let free = vec![false; 3 * mesh.nodes.len()];
    let model = Model::assemble(mesh, &[RUBBER], &free).expect("a free body");
    let strain = GreenStrain::new(&model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    let mut random = Random::new(3);
    let velocity: Vec<f64> = model
        .mesh()
        .nodes
        .iter()
        .flat_map(|x| {
            let spin = crate::linalg::vec3::cross([3.0, 2.0, 25.0], *x);
            [spin[0] + 1.0, spin[1], spin[2]]
        })
        .map(|v| v + 2.0 * random.uniform())
        .collect();
    let zero = vec![0.0; velocity.len()];
    let newton = Newton { tolerance: 1e-13, ..Newton::default() };
    for rate in [0.0, 1e-3] {
        let damping = LargeDamping { strain_rate: rate, ..LargeDamping::default() };
        let march = LargeMarch::new(&strain, &symbolic, LargeScheme::EnergyMomentum, 0.004, damping, newton);
        let march = march.expect("a march");
        let (mut energies, mut first, mut worst) = (vec![], None, 0.0_f64);
        let mut end = vec![];
        march_large(&march, [&zero, &velocity], &mut |_, _| {}, 80, &Silent, |state| {
            let now = momenta(&model, state);
            let first = *first.get_or_insert(now);
            let size = first.iter().map(|x| x * x).sum::<f64>().sqrt();
            worst = (0..6).map(|k| (now[k] - first[k]).abs() / size).fold(worst, f64::max);
            energies.push(march.energy(state));
            end = state.displacement.clone();
        })
        .expect("a motion");
        let turned = dot(&end, &end).sqrt();
        println!(
            "strain rate {rate}: momenta {worst:.1e}, energy {:.3} {:.3}, |u| {turned:.2}",
            energies[0], energies[80]
        );
        assert!(worst < 1e-12, "{worst}");
        if rate > 0.0 {
            assert!(energies.windows(2).all(|pair| pair[1] <= pair[0] * (1.0 + 1e-13)));
            // What turns is not slowed: its energy is at least L²/2J of the angular momentum that stays.
            assert!(energies[80] > 0.5 * energies[0] && energies[80] < energies[0]);
        } else {
            assert!((energies[80] / energies[0] - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn a_step_that_fails_is_halved_and_then_named() {
    let model = beam();
    let strain = GreenStrain::new(&model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    let zero = vec![0.0; strain.n_dof()];
    let march = |newton: Newton, scheme| {
        LargeMarch::new(&strain, &symbolic, scheme, 0.02, LargeDamping::default(), newton)
    };
    // Three corrections are not enough for a whole step, and are for some part of it.
    let hasty = Newton { iterations: 4, tolerance: 1e-6, keep: 0.0 };
    for scheme in [LargeScheme::bathe(), LargeScheme::EnergyMomentum] {
        let hurried = march(hasty, scheme).expect("a march");
        let mut end = vec![];
        let work = march_large(&hurried, [&zero, &zero], &mut push(&model, 3.0), 8, &Silent, |state| {
            end = state.displacement.clone();
        });
        let work = work.expect("a motion");
        println!("{} halvings", work.halvings);
        assert!(work.halvings > 0);
    }
    let hopeless = march(Newton { iterations: 1, tolerance: 1e-12, keep: 0.0 }, LargeScheme::bathe());
    let failed =
        march_large(&hopeless.expect("a march"), [&zero, &zero], &mut push(&model, 1.0), 3, &Silent, |_| {});
    let Err(error @ LargeError::NoStep { step: 0, halvings: 6, .. }) = failed else { panic!("no error") };
    assert!(error.to_string().contains("time step 0"), "{error}");
    let infinite = march(Newton::default(), LargeScheme::bathe()).expect("a march");
    let failed = march_large(&infinite, [&zero, &zero], &mut |_, f| f[0] = f64::INFINITY, 3, &Silent, |_| {});
    assert_eq!(failed.err(), Some(LargeError::Load { at: 0.0 }));
    // What makes no march.
    let hht = LargeScheme::of(SchemeKind::HhtAlpha { alpha: -0.1 }).expect("a table");
    let exact = LargeScheme::of(SchemeKind::Exact {}).expect("a table");
    for scheme in [hht, exact] {
        assert_eq!(march(Newton::default(), scheme).err(), Some(LargeError::Scheme));
    }
    let negative = LargeDamping { strain_rate: -1.0, ..LargeDamping::default() };
    let refused =
        LargeMarch::new(&strain, &symbolic, LargeScheme::bathe(), 0.01, negative, Newton::default());
    assert_eq!(refused.err(), Some(LargeError::Damping(negative)));
    let refused = LargeMarch::new(
        &strain,
        &symbolic,
        LargeScheme::bathe(),
        0.0,
        LargeDamping::default(),
        Newton::default(),
    );
    assert_eq!(refused.err(), Some(LargeError::TimeStep(0.0)));
}

#[test]
fn a_relaxed_shape_has_least_energy_at_its_coordinates() {
    let model = beam();
    let strain = GreenStrain::new(&model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    let modes = lowest_modes(model.pencil(), &symbolic, 3).expect("modes");
    let basis = modes.vectors.as_ref();
    let mass = model.pencil().mass();
    let n = strain.n_dof();
    // The tip at rest moves by some 0.4 of the length.
    let q = [0.2 * mass.inner(&vec![1.0; n], &vec![1.0; n]).sqrt() / 3.0_f64.sqrt(), 0.3, -0.1];
    let newton = Newton { tolerance: 1e-10, ..Newton::default() };
    let relaxation = || Relaxation::new(&strain, &symbolic, basis, newton).expect("a relaxation");
    let mut way = relaxation();
    let found = way.relax(None, &q).expect("a shape");
    let tip = moved(&model, &found.displacement, nearest(&model, [1.0, 0.1, 0.075]));
    println!("q {q:?}: tip {tip:.3?}, {} factorisations", found.factorisations);
    assert!(tip.iter().map(|x| x * x).sum::<f64>().sqrt() > 0.2);
    for k in 0..3 {
        let mode = basis.col(k).try_as_col_major().expect("columns").as_slice().to_vec();
        assert!((mass.inner(&mode, &found.displacement) - q[k]).abs() < 1e-12);
    }
    // Its force is along the momenta of the basis.
    let mut force = vec![0.0; n];
    strain.force(&found.displacement, &mut force);
    let size = dot(&force, &force).sqrt();
    for k in 0..3 {
        let mode = basis.col(k).try_as_col_major().expect("columns").as_slice().to_vec();
        add(&mut force, -found.forces[k], &times(mass, &mode));
    }
    assert!(dot(&force, &force).sqrt() < 1e-8 * size, "{:.1e}", dot(&force, &force).sqrt() / size);
    // Less energy than the basis alone has.
    let mut flat = vec![0.0; n];
    for k in 0..3 {
        add(&mut flat, q[k], basis.col(k).try_as_col_major().expect("columns").as_slice());
    }
    let least = strain.energy(&found.displacement);
    assert!(least < 0.5 * strain.energy(&flat), "{least} {}", strain.energy(&flat));
    // The multipliers are the gradient of the least energy.
    let at = |k: usize, d: f64| {
        let mut way = relaxation();
        way.relax(None, &q).expect("a shape");
        let mut q = q;
        q[k] += d;
        strain.energy(&way.relax(None, &q).expect("a shape").displacement)
    };
    for k in 0..3 {
        let d = 1e-3;
        let slope = (8.0 * (at(k, d) - at(k, -d)) - (at(k, 2.0 * d) - at(k, -2.0 * d))) / (12.0 * d);
        assert!((slope / found.forces[k] - 1.0).abs() < 1e-6, "{k} {slope} {}", found.forces[k]);
    }
    // Along a path the next shape is near: few factorisations each.
    let mut factorisations = 0;
    for step in 1..=10 {
        let next = q.map(|q| q * (1.0 - 0.2 * f64::from(step)));
        factorisations += way.relax(None, &next).expect("a shape").factorisations;
    }
    println!("{factorisations} factorisations for 10 shapes");
    let away = relaxation().relax(None, &[f64::NAN, 0.0, 0.0]);
    assert!(matches!(away, Err(LargeError::NoShape { .. })), "{away:?}");
}

/// With all natural modes for a basis nothing is left out, and the march is that of the full order; with a
/// few of them it stays in their span and is another one.
#[test]
fn a_march_within_a_basis_is_galerkins() {
    let mesh = quadratic(&block([2, 1, 1], [1.0, 0.2, 0.15]));
    let held = hold(&mesh, |[x, _, _]| x == 0.0);
    let model = Model::assemble(mesh, &[RUBBER], &held).expect("a model");
    let strain = GreenStrain::new(&model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    let modes = lowest_modes(model.pencil(), &symbolic, strain.n_dof()).expect("modes").vectors;
    let zero = vec![0.0; strain.n_dof()];
    let damping = LargeDamping { mass: 0.5, stiffness: 0.0, strain_rate: 1e-3 };
    let march = || {
        LargeMarch::new(&strain, &symbolic, LargeScheme::bathe(), 0.01, damping, Newton::default())
            .expect("a march")
    };
    let end = |march: &LargeMarch<'_>| {
        let (mut end, mut force) = (vec![], push(&model, 0.05));
        march_large(march, [&zero, &zero], &mut force, 30, &Silent, |state| end = state.displacement.clone())
            .expect("steps");
        end
    };
    let size = |u: &[f64]| model.pencil().mass().inner(u, u).sqrt();
    let whole = end(&march());
    let all = end(&march().within(modes.as_ref()).expect("a basis"));
    let apart = size(&sum(&whole, -1.0, &all)) / size(&whole);
    assert!(apart < 1e-6, "{apart}");
    let few = modes.subcols(0, 4);
    let found = end(&march().within(few).expect("a basis"));
    let shares = crate::linalg::project(few, &times(model.pencil().mass(), &found));
    let mut beside = found.clone();
    for (k, share) in shares.iter().enumerate() {
        beside.iter_mut().enumerate().for_each(|(i, x)| *x -= share * few[(i, k)]);
    }
    assert!(size(&beside) < 1e-9 * size(&found), "it left the span");
    let apart = size(&sum(&whole, -1.0, &found)) / size(&whole);
    assert!((1e-3..0.9).contains(&apart), "{apart}");
    let short = march().within(modes.as_ref().subrows(0, 3));
    assert!(matches!(short.err(), Some(LargeError::Length { .. })));
}

/// The loads of one trajectory of the linear march as a force over time.
fn timed_force(loads: &[TimedLoad], column: usize) -> impl FnMut(f64, &mut [f64]) + '_ {
    move |time, force| {
        for load in loads.iter().filter(|load| load.column == column) {
            let factor = load.when.factor(time);
            if factor != 0.0 {
                add(force, factor, &load.force);
            }
        }
    }
}
