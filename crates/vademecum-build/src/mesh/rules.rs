//! Rules of integration over the reference elements of [`super::shapes`].

use super::kind::{EDGES, ElementKind};

/// Four points, exact for degree 2 (Hammer and Stroud 1956); weights sum to the volume 1/6.
pub(crate) fn rule_degree_2() -> Vec<([f64; 4], f64)> {
    let b = (5.0 - 5.0_f64.sqrt()) / 20.0;
    orbit_4(1.0 - 3.0 * b, b, 1.0 / 24.0)
}

/// Fourteen points, exact for degree 5, all weights positive (Walkington 2000).
pub(crate) fn rule_degree_5() -> Vec<([f64; 4], f64)> {
    let (inner, outer, edge) = (0.3108859192633005, 0.09273525031089122, 0.04550370412564965);
    let mut rule = orbit_4(1.0 - 3.0 * inner, inner, 0.018_781_320_953_002_64);
    rule.extend(orbit_4(1.0 - 3.0 * outer, outer, 0.012_248_840_519_393_66));
    for [i, j] in EDGES {
        let mut l = [edge; 4];
        (l[i], l[j]) = (0.5 - edge, 0.5 - edge);
        rule.push((l, 0.007_091_003_462_846_912));
    }
    rule
}

/// Twenty-four points, exact for degree 6, all weights positive (Keast 1986).
pub(crate) fn rule_degree_6() -> Vec<([f64; 4], f64)> {
    let mut rule = orbit_4(0.3561913862225449, 0.2146028712591517, 0.006_653_791_709_694_582);
    rule.extend(orbit_4(0.877_978_124_396_166, 0.0406739585346113, 0.001_679_535_175_886_774));
    rule.extend(orbit_4(0.0329863295731731, 0.3223378901422757, 0.009_226_196_923_942_453));
    let (pair, c, d) = (0.0636610018750175, 0.2696723314583159, 0.6030056647916491);
    for i in 0..4 {
        for j in (0..4).filter(|&j| j != i) {
            let mut l = [pair; 4];
            (l[i], l[j]) = (c, d);
            rule.push((l, 0.008_035_714_285_714_285));
        }
    }
    rule
}

/// The four points with one coordinate `a` and three `b`.
fn orbit_4(a: f64, b: f64, weight: f64) -> Vec<([f64; 4], f64)> {
    (0..4).map(|i| (std::array::from_fn(|j| if i == j { a } else { b }), weight)).collect()
}

/// Points and weights of Gauss and Legendre on `[−1, 1]`.
///
/// # Panics
/// Beyond four points.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    match n {
        1 => vec![(0.0, 2.0)],
        2 => {
            let x = (1.0_f64 / 3.0).sqrt();
            vec![(-x, 1.0), (x, 1.0)]
        }
        3 => {
            let x = 0.6_f64.sqrt();
            vec![(-x, 5.0 / 9.0), (0.0, 8.0 / 9.0), (x, 5.0 / 9.0)]
        }
        4 => {
            let root = (1.2_f64).sqrt();
            let (near, far) = ((3.0 - 2.0 * root) / 7.0, (3.0 + 2.0 * root) / 7.0);
            let (near, far) = (near.sqrt(), far.sqrt());
            let share = 30.0_f64.sqrt() / 36.0;
            vec![(-far, 0.5 - share), (-near, 0.5 + share), (near, 0.5 + share), (far, 0.5 - share)]
        }
        _ => unreachable!("no rule of {n} points is used"),
    }
}

/// `n³` points on the hexahedron.
fn gauss_box(n: usize) -> Vec<([f64; 3], f64)> {
    let line = gauss(n);
    let mut rule = Vec::with_capacity(n * n * n);
    for &(z, wz) in &line {
        for &(y, wy) in &line {
            rule.extend(line.iter().map(|&(x, wx)| ([x, y, z], wx * wy * wz)));
        }
    }
    rule
}

/// A rule of the triangle times one of `n` points along the axis.
fn gauss_wedge(triangle: &[([f64; 2], f64)], n: usize) -> Vec<([f64; 3], f64)> {
    let layer = |(z, wz): (f64, f64)| triangle.iter().map(move |&([x, y], w)| ([x, y, z], w * wz));
    gauss(n).into_iter().flat_map(layer).collect()
}

/// `n × n` points in each of `n + 1` levels of the pyramid: a conical product.
fn gauss_pyramid(n: usize) -> Vec<([f64; 3], f64)> {
    let line = gauss(n);
    let mut rule = Vec::new();
    for (level, weight) in gauss(n + 1) {
        let z = 0.5 * (1.0 + level);
        let size = 1.0 - z;
        for &(y, wy) in &line {
            let scale = 0.5 * weight * wy * size * size;
            rule.extend(line.iter().map(|&(x, wx)| ([size * x, size * y, z], scale * wx)));
        }
    }
    rule
}

/// Rules of the triangle by barycentric orbits, weights that sum to ½.
fn triangle_rule(degree: usize) -> Vec<([f64; 2], f64)> {
    let orbit = |a: f64, weight: f64| {
        let b = 1.0 - 2.0 * a;
        [([a, a], weight), ([b, a], weight), ([a, b], weight)]
    };
    match degree {
        0 | 1 => vec![([1.0 / 3.0; 2], 0.5)],
        2 => orbit(1.0 / 6.0, 1.0 / 6.0).to_vec(),
        // Strang and Fix (1973), six points, degree 4.
        _ => {
            let (a, wa) = (0.445_948_490_915_965, 0.111_690_794_839_005_5);
            let (b, wb) = (0.091_576_213_509_771, 0.054_975_871_827_661);
            orbit(a, wa).into_iter().chain(orbit(b, wb)).collect()
        }
    }
}

/// Rule of the stiffness, of full integration or reduced.
pub(crate) fn stiffness_rule(kind: ElementKind, reduced: bool) -> Vec<([f64; 3], f64)> {
    match kind {
        ElementKind::Tet4 => vec![([0.25; 3], 1.0 / 6.0)],
        ElementKind::Tet10 => barycentric(rule_degree_2()),
        ElementKind::Pyramid5 => gauss_pyramid(2),
        ElementKind::Pyramid13 => gauss_pyramid(3),
        ElementKind::Wedge6 => gauss_wedge(&triangle_rule(1), 2),
        ElementKind::Wedge15 => gauss_wedge(&triangle_rule(2), 3),
        ElementKind::Hex8 => gauss_box(if reduced { 1 } else { 2 }),
        ElementKind::Hex20 => gauss_box(if reduced { 2 } else { 3 }),
        ElementKind::Hex27 => gauss_box(3),
    }
}

/// Rule of the mass: exact where the faces are parallel.
pub(crate) fn mass_rule(kind: ElementKind) -> Vec<([f64; 3], f64)> {
    match kind {
        ElementKind::Tet4 | ElementKind::Tet10 => barycentric(rule_degree_6()),
        ElementKind::Pyramid5 | ElementKind::Pyramid13 => gauss_pyramid(3),
        ElementKind::Wedge6 => gauss_wedge(&triangle_rule(2), 3),
        ElementKind::Wedge15 => gauss_wedge(&triangle_rule(4), 3),
        ElementKind::Hex8 | ElementKind::Hex20 | ElementKind::Hex27 => gauss_box(3),
    }
}

fn barycentric(rule: Vec<([f64; 4], f64)>) -> Vec<([f64; 3], f64)> {
    rule.into_iter().map(|([_, x, y, z], weight)| ([x, y, z], weight)).collect()
}

/// Points and weights on a quadrangular facet.
pub(crate) fn quadrangle_rule() -> Vec<([f64; 2], f64)> {
    let line = gauss(3);
    line.iter().flat_map(|&(y, wy)| line.iter().map(move |&(x, wx)| ([x, y], wx * wy))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `∫ L_1^p L_2^q L_3^s = p! q! s! / (p+q+s+3)!`.
    fn exact_monomial(p: u32, q: u32, s: u32) -> f64 {
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        factorial(p) * factorial(q) * factorial(s) / factorial(p + q + s + 3)
    }

    fn check_rule(rule: &[([f64; 4], f64)], degree: u32) {
        for p in 0..=degree {
            for q in 0..=degree - p {
                for s in 0..=degree - p - q {
                    let sum: f64 = rule
                        .iter()
                        .map(|(l, w)| w * l[1].powi(p as i32) * l[2].powi(q as i32) * l[3].powi(s as i32))
                        .sum();
                    // The rule's constants carry 16 digits; 24 terms of at most the weight 1/100 each.
                    assert!((sum - exact_monomial(p, q, s)).abs() < 24.0 * 1e-2 * 1e-15, "{p} {q} {s}");
                }
            }
        }
    }

    #[test]
    fn rules_integrate_all_monomials_of_their_degree() {
        check_rule(&rule_degree_2(), 2);
        check_rule(&rule_degree_5(), 5);
        check_rule(&rule_degree_6(), 6);
    }

    #[test]
    fn rules_have_the_volume_and_centre_of_their_element() {
        for kind in ElementKind::all() {
            let (volume, height) = match kind {
                ElementKind::Tet4 | ElementKind::Tet10 => (1.0 / 6.0, 0.25),
                ElementKind::Pyramid5 | ElementKind::Pyramid13 => (4.0 / 3.0, 0.25),
                ElementKind::Wedge6 | ElementKind::Wedge15 => (1.0, 0.0),
                _ => (8.0, 0.0),
            };
            for rule in [stiffness_rule(kind, false), stiffness_rule(kind, true), mass_rule(kind)] {
                let sum: f64 = rule.iter().map(|(_, w)| w).sum();
                let first: f64 = rule.iter().map(|(at, w)| w * at[2]).sum();
                assert!((sum - volume).abs() < 1e-14 * 8.0, "{kind:?} {sum}");
                assert!((first - volume * height).abs() < 1e-14 * 8.0, "{kind:?} {first}");
            }
        }
        // ∫ x²y² over the triangle is 1/180, a monomial of degree 4.
        let sum: f64 = triangle_rule(4).iter().map(|([x, y], w)| w * x * x * y * y).sum();
        assert!((sum - 1.0 / 180.0).abs() < 1e-14);
    }
}
