//! Scratch.
use std::time::Instant;

use faer::Mat;
use vademecum_build::dynamics::{Rayleigh, lowest_modes};
use vademecum_build::fem::GreenStrain;
use vademecum_build::input::Problem;
use vademecum_build::large::*;
use vademecum_build::linalg::{Random, project};
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};

struct Test {
    force: Vec<f64>,
    kind: usize,
    length: f64,
}
impl Test {
    fn at(&self, t: f64) -> f64 {
        if t < 0.0 || t > self.length {
            return 0.0;
        }
        match self.kind {
            0 => (std::f64::consts::PI * t / self.length).sin().powi(2),
            _ => 1.0,
        }
    }
}

fn full(
    prepared: &Prepared,
    strain: &GreenStrain<'_>,
    test: &Test,
    dt: f64,
    steps: usize,
    every: usize,
) -> Vec<Vec<f64>> {
    let pencil = prepared.body.model.pencil();
    let n = strain.n_dof();
    let (mut u, mut v) = (vec![0.0; n], vec![0.0; n]);
    let mut out = vec![];
    let mass = pencil.mass();
    let mut f0 = vec![0.0; n];
    let (mut iters, mut count) = (0, 0);
    for step in 0..steps {
        let (t0, t1) = (step as f64 * dt, (step + 1) as f64 * dt);
        let load = |t: f64| test.at(t);
        let l0 = if step == 0 && test.kind == 1 { 1.0 } else { load(t0 + 1e-12) };
        let l1 = load(t1 - 1e-12);
        strain.force(&u, &mut f0);
        // trapezoid: M(v1-v0)/dt = mean; u1 = u0 + dt/2 (v0+v1)
        let mut x: Vec<f64> = (0..n).map(|i| u[i] + dt * v[i]).collect();
        let mut f1 = vec![0.0; n];
        let mut first = 0.0;
        for it in 0..20 {
            strain.force(&x, &mut f1);
            let d = Mat::from_fn(n, 1, |i, _| 4.0 / (dt * dt) * (x[i] - u[i] - dt * v[i]));
            let mut md = Mat::zeros(n, 1);
            mass.mul_into(d.as_ref(), md.as_mut());
            let mut r = Mat::from_fn(n, 1, |i, _| test.force[i] * (l0 + l1) - f0[i] - f1[i] - md[(i, 0)]);
            let norm = r.col_as_slice(0).iter().map(|x| x * x).sum::<f64>().sqrt();
            if it == 0 {
                first = norm.max(1e-30);
            }
            if norm <= 1e-8 * first && it > 0 {
                break;
            }
            iters += 1;
            let t = strain.tangent(&x);
            let t = vademecum_build::fem::SymmetricMatrix::combine(&[(1.0, &t), (4.0 / (dt * dt), mass)]);
            let factor = match prepared.symbolic.factorize(t) {
                Ok(f) => f,
                Err(_) => {
                    let mut z = vec![0.0; strain.n_rows()];
                    strain.strain(&x, &mut z);
                    let t = strain.weighted_tangent(&x, 1.0, &z, true);
                    let t =
                        vademecum_build::fem::SymmetricMatrix::combine(&[(1.0, &t), (4.0 / (dt * dt), mass)]);
                    eprint!("!");
                    prepared.symbolic.factorize(t).expect("spd")
                }
            };
            vademecum_build::fem::Solve::new(&prepared.symbolic, 1, false)
                .solve_in_place(&factor, r.as_mut());
            for i in 0..n {
                x[i] += r[(i, 0)];
            }
        }
        for i in 0..n {
            v[i] = 2.0 / dt * (x[i] - u[i]) - v[i];
        }
        u = x;
        count += 1;
        if (step + 1) % every == 0 {
            out.push(u.clone());
        }
    }
    eprintln!("  newton {:.1} a step", iters as f64 / count as f64);
    out
}

fn main() {
    let path = std::env::args().nth(1).expect("problem");
    let largest: f64 = std::env::args().nth(2).unwrap().parse().unwrap();
    let modes: usize = std::env::args().nth(3).unwrap().parse().unwrap();
    let n: usize = std::env::args().nth(4).unwrap().parse().unwrap();
    let count: usize = std::env::args().nth(5).unwrap().parse().unwrap();
    let ridge: f64 = std::env::args().nth(6).unwrap().parse().unwrap();
    let problem = Problem::read(path.as_ref()).unwrap();
    let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).unwrap();
    let pencil = prepared.body.model.pencil();
    let strain = GreenStrain::new(&prepared.body.model).unwrap();
    let start = Instant::now();
    let lap = |what: &str| eprintln!("{:8.2} s {what}", start.elapsed().as_secs_f64());
    eprintln!("dofs {} rows {}", strain.n_dof(), strain.n_rows());
    let found = lowest_modes(pencil, &prepared.symbolic, modes).unwrap();
    let t1 = 1.0 / found.frequencies_hz()[0];
    lap("modes");
    eprintln!("T1 {t1:.4e}, f {:?}", found.frequencies_hz().iter().step_by(8).collect::<Vec<_>>());
    let mut momenta = Mat::zeros(strain.n_dof(), modes);
    pencil.mass().mul_into(found.vectors.as_ref(), momenta.as_mut());
    // moving rows
    let dofs = prepared.body.model.dofs();
    let free: std::collections::HashMap<u32, usize> =
        dofs.dof_of_free().iter().enumerate().map(|(i, &d)| (d, i)).collect();
    let nodes = &prepared.body.load_nodes;
    let moving = Mat::from_fn(3 * nodes.len(), modes, |i, k| {
        free.get(&(3 * nodes[i / 3] + (i % 3) as u32)).map_or(0.0, |&f| found.vectors[(f, k)])
    });
    // tests
    let mut random = Random::new(2026);
    let dt = t1 / 160.0;
    let periods = 5;
    let mut tests = vec![];
    for k in 0..4 {
        let node = nodes[random.below(nodes.len())];
        let d: [f64; 3] = std::array::from_fn(|_| random.uniform() - 0.5);
        let mut force = vec![0.0; strain.n_dof()];
        let all = &prepared.body.model.mesh().nodes;
        let size = (0..3)
            .map(|c| {
                all.iter().map(|x| x[c]).fold(f64::MIN, f64::max)
                    - all.iter().map(|x| x[c]).fold(f64::MAX, f64::min)
            })
            .fold(0.0, f64::max);
        for &other in nodes.iter() {
            let dist: f64 =
                (0..3).map(|c| (all[other as usize][c] - all[node as usize][c]).powi(2)).sum::<f64>()
                    / (0.1 * size).powi(2);
            if dist < 9.0 {
                for c in 0..3 {
                    if let Some(&f) = free.get(&(3 * other + c as u32)) {
                        force[f] = d[c] * (-dist).exp();
                    }
                }
            }
        }
        // linear static
        let q: Vec<f64> = project(found.vectors.as_ref(), &force)
            .iter()
            .zip(&found.eigenvalues)
            .map(|(f, l)| f / l)
            .collect();
        let most = (0..nodes.len())
            .map(|p| {
                (0..3)
                    .map(|c| (0..modes).map(|k| moving[(3 * p + c, k)] * q[k]).sum::<f64>().powi(2))
                    .sum::<f64>()
                    .sqrt()
            })
            .fold(0.0, f64::max);
        let s = largest * [0.7, 0.4, 0.4, 0.2][k] / most;
        force.iter_mut().for_each(|f| *f *= s);
        tests.push(Test { force, kind: k % 2, length: t1 * [0.8, 0.35, 0.6, 0.7][k] });
    }
    let steps = 160 * periods;
    let kept = format!("{path}.refs-{largest}");
    let references: Vec<Vec<Vec<f64>>> = match std::fs::read(&kept) {
        Ok(bytes) => {
            let n = strain.n_dof();
            let all: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|&b| f64::from_le_bytes(b)).collect();
            let per = all.len() / tests.len();
            all.chunks(per).map(|c| c.chunks(n).map(|x| x.to_vec()).collect()).collect()
        }
        Err(_) => {
            let r: Vec<Vec<Vec<f64>>> =
                tests.iter().map(|t| full(&prepared, &strain, t, dt, steps, 4)).collect();
            let bytes: Vec<u8> = r.iter().flatten().flatten().flat_map(|x| x.to_le_bytes()).collect();
            std::fs::write(&kept, bytes).unwrap();
            r
        }
    };
    lap("references");
    for r in &references {
        let most = r
            .iter()
            .map(|u| {
                nodes
                    .iter()
                    .map(|&p| {
                        (0..3)
                            .map(|c| free.get(&(3 * p + c)).map_or(0.0, |&f| u[f]).powi(2))
                            .sum::<f64>()
                            .sqrt()
                    })
                    .fold(0.0, f64::max)
            })
            .fold(0.0, f64::max);
        eprintln!("  largest displacement {most:.3e}");
    }
    // states
    let drawn = draw(moving.as_ref(), &found.eigenvalues, largest, count, 7);
    let cons: usize = std::env::args().nth(7).map_or(modes, |x| x.parse().unwrap());
    let states = relaxed(
        &strain,
        &prepared.symbolic,
        (found.vectors.as_ref().subcols(0, cons), momenta.as_ref().subcols(0, cons)),
        drawn.as_ref(),
    );
    lap(&format!("{} states of {count}", states.len()));
    let coupled: usize = std::env::args().nth(9).map_or(0, |x| x.parse().unwrap());
    let mut bases = vec![(
        "modes",
        found.vectors.clone(),
        found.eigenvalues.clone(),
        Prior::Condensed,
        n.min(modes).min(24),
    )];
    if std::env::args().nth(8).is_some() {
        let extra: usize = std::env::args().nth(8).unwrap().parse().unwrap();
        let kept: usize = cons;
        let basis = with_followers(
            pencil,
            (found.vectors.as_ref(), momenta.as_ref(), &found.eigenvalues),
            &states,
            extra,
        )
        .unwrap();
        let r = basis.1.len();
        let order: Vec<usize> = (0..kept).chain(modes..r).chain(kept..modes).collect();
        let v = Mat::from_fn(basis.0.nrows(), r, |i, k| basis.0[(i, order[k])]);
        let e: Vec<f64> = order.iter().map(|&k| basis.1[k]).collect();
        bases.clear();
        bases.push(("tailed", v, e, Prior::Condensed, (kept + r - modes).min(n)));
    }
    lap("basis");
    for (name, vectors, eigenvalues, prior, n) in bases {
        let r = eigenvalues.len();
        let mut momenta = Mat::zeros(strain.n_dof(), r);
        pencil.mass().mul_into(vectors.as_ref(), momenta.as_mut());
        let states = States::new(&strain, momenta.as_ref(), &states);
        lap("strains");
        let factor = prepared.symbolic.factor_of(pencil.stiffness()).unwrap();
        let pairs = Pairs { interacting: n, coupled: if name == "tailed" { coupled } else { 0 } };
        let mut columns =
            columns(&strain, (vectors.as_ref(), &eigenvalues), pairs, prior, (&prepared.symbolic, &factor));
        lap("columns");
        for fitted in [false, true] {
            if fitted {
                columns.fit(&states, ridge).unwrap();
            }
            let map = columns
                .rows(
                    states.coordinates.as_ref(),
                    std::env::var("EXTRA").map_or(2, |x| x.parse().unwrap()) * (n + coupled / 2),
                )
                .unwrap();
            lap("rows");
            let e: Vec<f64> = (0..states.energies.len())
                .map(|s| map.energy(states.coordinates.col_as_slice(s)) / states.energies[s])
                .collect();
            let mut sorted = e.clone();
            sorted.sort_by(f64::total_cmp);
            eprintln!(
                "  energies / truth: {:.3} {:.3} {:.3}",
                sorted[sorted.len() / 20],
                sorted[sorted.len() / 2],
                sorted[sorted.len() * 19 / 20]
            );
            for sub in [1usize, 4] {
                print!("{name} R={r} n={n} n1={coupled} fitted {fitted} sub {sub}:");
                for (test, reference) in tests.iter().zip(&references) {
                    let dt = t1 / 40.0;
                    let k = dt / sub as f64;
                    let f = project(vectors.as_ref(), &test.force);
                    let mut motion = Motion::new(&map, k, Rayleigh { alpha: 0.0, beta: 0.0 }, ROW_VISCOSITY);
                    let (mut err, mut floor, mut size) = (0.0, 0.0, 0.0);
                    for step in 0..40 * periods {
                        for s in 0..sub {
                            let t = step as f64 * dt + s as f64 * k;
                            let g = 0.5 * (test.at(t - 1e-9 * k) + test.at(t + 1e-9 * k));
                            motion.step(&f.iter().map(|f| g * f).collect::<Vec<_>>());
                        }
                        let u = &reference[step];
                        let full = Mat::from_fn(u.len(), 1, |i, _| u[i]);
                        let mut mu = Mat::zeros(u.len(), 1);
                        pencil.mass().mul_into(full.as_ref(), mu.as_mut());
                        let all: f64 = u.iter().zip(mu.col_as_slice(0)).map(|(a, b)| a * b).sum();
                        let q = project(momenta.as_ref(), u);
                        let inside: f64 = q.iter().map(|q| q * q).sum();
                        let off: f64 = q.iter().zip(&motion.q).map(|(a, b)| (a - b) * (a - b)).sum();
                        err += off + (all - inside).max(0.0);
                        floor += (all - inside).max(0.0);
                        size += all;
                    }
                    print!("  {:.3} ({:.3})", (err / size).sqrt(), (floor / size).sqrt());
                }
                println!();
            }
        }
        lap("done");
    }
}
