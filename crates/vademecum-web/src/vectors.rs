//! Arithmetic of three numbers.

/// Three components.
pub type Vector = [f64; 3];

/// `a + b`.
pub fn plus(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a − b`.
pub fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `factor a`.
pub fn times(factor: f64, a: Vector) -> Vector {
    a.map(|x| factor * x)
}

/// `a · b`.
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `|a|`.
pub fn length(a: Vector) -> f64 {
    libm::sqrt(dot(a, a))
}

/// The part of `a` perpendicular to the unit vector `normal`.
pub fn along(a: Vector, normal: Vector) -> Vector {
    minus(a, times(dot(a, normal), normal))
}
