use faer::{Mat, MatMut, MatRef};

use super::pod::gram;
use super::*;

/// A diagonal operator, cheap and not the identity.
fn apply_diagonal(weights: &[f64]) -> impl Fn(MatRef<'_, f64>, MatMut<'_, f64>) + '_ {
    move |x, mut y| {
        for j in 0..x.ncols() {
            for i in 0..x.nrows() {
                y[(i, j)] = weights[i] * x[(i, j)];
            }
        }
    }
}

/// Numbers without structure, the same at every call.
fn noise(seed: usize) -> f64 {
    let x = (seed as f64 * 12.9898).sin() * 43758.5453;
    x - x.floor() - 0.5
}

/// `count` snapshots of a space of dimension `rank`, with entries of size `scale`.
fn snapshots(n: usize, rank: usize, count: usize, scale: f64) -> Mat<f64> {
    let space = Mat::from_fn(n, rank, |i, j| noise(1 + i * rank + j));
    let weights =
        Mat::from_fn(rank, count, |i, j| scale * noise(7_777 + i * count + j) * 0.3_f64.powi(i as i32));
    space * weights
}

fn identity_error(matrix: &Mat<f64>) -> f64 {
    (matrix - Mat::<f64>::identity(matrix.nrows(), matrix.ncols())).norm_max()
}

#[test]
fn the_vectors_are_orthonormal_in_the_inner_product_and_span_the_snapshots_at_every_scale() {
    let weights: Vec<f64> = (0..200).map(|i| 0.1 + noise(i).abs()).collect();
    let mass = apply_diagonal(&weights);
    for scale in [1.0, 1e-9, 1e-60, 1e60] {
        let data = snapshots(200, 12, 150, scale);
        let mut stream = StreamingPod::new(&mass, 200, 20);
        stream.push(data.as_ref()).unwrap();
        let pod = stream.finish().unwrap();
        assert_eq!(pod.vectors.ncols(), 12, "scale {scale}");
        // QR and SVD each cost a few ε·√n.
        assert!(identity_error(&gram(&mass, pod.vectors.as_ref(), pod.vectors.as_ref())) < 1e-12);
        let coordinates = gram(&mass, pod.vectors.as_ref(), data.as_ref());
        let residual = &data - &pod.vectors * coordinates;
        assert!(residual.norm_max() < 1e-10 * data.norm_max(), "scale {scale}");
    }
}

#[test]
fn the_singular_values_of_a_large_small_matrix_are_right() {
    // 200 vectors of size 1e-16: the case in which a symmetric eigensolver on the Gram matrix goes wrong
    // unnoticed.
    let n = 260;
    let ones = vec![1.0; n];
    let identity = apply_diagonal(&ones);
    let data = Mat::from_fn(n, 200, |i, j| if i == j { 1e-16 * (1.0 + j as f64) } else { 0.0 });
    let mut stream = StreamingPod::new(&identity, n, 200);
    stream.push(data.as_ref()).unwrap();
    let pod = stream.finish().unwrap();
    for (k, sigma) in pod.singular_values.iter().enumerate() {
        let expected = 1e-16 * (200.0 - k as f64);
        assert!((sigma - expected).abs() < 1e-12 * 2e-14, "{k}: {sigma} against {expected}");
    }
}

#[test]
fn streaming_in_batches_gives_what_one_batch_gives() {
    let ones = vec![1.0; 150];
    let identity = apply_diagonal(&ones);
    let data = snapshots(150, 15, 400, 1.0);
    let mut stream = StreamingPod::new(&identity, 150, 40);
    for start in (0..400).step_by(50) {
        stream.push(data.subcols(start, 50)).unwrap();
    }
    let streamed = stream.finish().unwrap();
    let exact = data.thin_svd().unwrap();
    for k in 0..15 {
        let expected = exact.S().column_vector()[k];
        // Nothing is truncated (rank 15 of 40), so each merge costs rounding of the largest value only.
        assert!((streamed.singular_values[k] - expected).abs() < 1e-12 * exact.S().column_vector()[0]);
    }
}

#[test]
fn the_ritz_basis_is_mass_orthonormal_and_diagonal() {
    let n = 120;
    let masses: Vec<f64> = (0..n).map(|i| 1.0 + 0.5 * noise(i)).collect();
    let springs: Vec<f64> = (0..n).map(|i| 10.0 + i as f64).collect();
    let (mass, stiffness) = (apply_diagonal(&masses), apply_diagonal(&springs));
    let data = snapshots(n, 40, 120, 1e-6);
    let mut stream = StreamingPod::new(&mass, n, 40);
    stream.push(data.as_ref()).unwrap();
    let ratio: Vec<f64> = masses.iter().zip(&springs).map(|(m, k)| m / k).collect();
    let static_response = apply_diagonal(&ratio);
    let basis = ritz_basis(&mass, &stiffness, &static_response, &stream.finish().unwrap(), 8, 4).unwrap();
    assert_eq!(basis.n_modes(), 8);
    assert!(identity_error(&gram(&mass, basis.vectors.as_ref(), basis.vectors.as_ref())) < 1e-11);
    let reduced = gram(&stiffness, basis.vectors.as_ref(), basis.vectors.as_ref());
    assert!((&reduced - &basis.stiffness).norm_max() < 1e-10 * reduced.norm_max());
    assert!(basis.energy.windows(2).all(|w| w[0] >= w[1]), "most energetic first");
}

#[test]
fn a_pod_basis_in_the_euclidean_product_keeps_its_span_when_made_mass_orthonormal() {
    let n = 90;
    let masses: Vec<f64> = (0..n).map(|i| 1.0 + 0.9 * noise(i)).collect();
    let ones = vec![1.0; n];
    let (mass, identity) = (apply_diagonal(&masses), apply_diagonal(&ones));
    let mut stream = StreamingPod::new(&identity, n, 20);
    stream.push(snapshots(n, 10, 60, 1.0).as_ref()).unwrap();
    let pod = stream.finish().unwrap();
    let basis = pod_basis(&mass, &identity, &pod, 6).unwrap();
    assert!(identity_error(&gram(&mass, basis.vectors.as_ref(), basis.vectors.as_ref())) < 1e-12);
    let inside =
        pod.vectors.subcols(0, 6) * gram(&identity, pod.vectors.subcols(0, 6), basis.vectors.as_ref());
    assert!((inside - &basis.vectors).norm_max() < 1e-12);
}
