//! Derivatives by complex steps: a march of a linear body over complex numbers, whose imaginary part is the
//! derivative to rounding, since nothing is subtracted.
//!
//! The march is by its definition: `M q̈ + C q̇ + K q = f` with loads that are linear over each step, moved
//! by the exponential of its matrix. It shares nothing with the evaluator.
//!
//! Source: Squire and Trapp 1998.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A complex number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Complex {
    /// Its real part.
    pub re: f64,
    /// Its imaginary part.
    pub im: f64,
}

/// Imaginary step: its square is nothing beside 1.
pub const TINY: f64 = 1e-40;

impl Complex {
    /// A real number.
    #[must_use]
    pub const fn real(re: f64) -> Self {
        Self { re, im: 0.0 }
    }

    /// A number with the imaginary step, if it is the one that the derivative is with respect to.
    #[must_use]
    pub const fn stepped(re: f64, is_stepped: bool) -> Self {
        Self { re, im: if is_stepped { TINY } else { 0.0 } }
    }

    /// The derivative of a result.
    #[must_use]
    pub const fn derivative(self) -> f64 {
        self.im / TINY
    }

    /// Square root of a number with a positive real part and next to no imaginary part.
    #[must_use]
    pub fn root(self) -> Self {
        let re = self.re.sqrt();
        Self { re, im: 0.5 * self.im / re }
    }
}

impl Add for Complex {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for Complex {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Neg for Complex {
    type Output = Self;

    fn neg(self) -> Self {
        Self { re: -self.re, im: -self.im }
    }
}

impl Mul for Complex {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

impl Div for Complex {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let square = other.re * other.re + other.im * other.im;
        let turned = self * Self { re: other.re, im: -other.im };
        Self { re: turned.re / square, im: turned.im / square }
    }
}

/// A matrix row by row, with its number of columns.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// Numbers.
    pub numbers: Vec<Complex>,
    /// Columns.
    pub columns: usize,
}

impl Matrix {
    /// Zeros.
    #[must_use]
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { numbers: vec![Complex::default(); rows * columns], columns }
    }

    /// A diagonal.
    #[must_use]
    pub fn diagonal(numbers: &[Complex]) -> Self {
        let mut all = Self::zeros(numbers.len(), numbers.len());
        for (i, &number) in numbers.iter().enumerate() {
            all.set(i, i, number);
        }
        all
    }

    /// Number `(i, j)`.
    #[must_use]
    pub fn at(&self, i: usize, j: usize) -> Complex {
        self.numbers[i * self.columns + j]
    }

    /// Writes number `(i, j)`.
    pub fn set(&mut self, i: usize, j: usize, value: Complex) {
        self.numbers[i * self.columns + j] = value;
    }

    /// `A x`.
    #[must_use]
    pub fn times(&self, x: &[Complex]) -> Vec<Complex> {
        let row = |row: &[Complex]| row.iter().zip(x).fold(Complex::default(), |sum, (&a, &x)| sum + a * x);
        self.numbers.chunks_exact(self.columns).map(row).collect()
    }

    fn product(&self, other: &Self) -> Self {
        let rows = self.numbers.len() / self.columns;
        let mut out = Self::zeros(rows, other.columns);
        for i in 0..rows {
            for k in 0..self.columns {
                let a = self.at(i, k);
                for j in 0..other.columns {
                    out.set(i, j, out.at(i, j) + a * other.at(k, j));
                }
            }
        }
        out
    }

    /// `A⁻¹ B` by elimination with pivots.
    ///
    /// # Panics
    /// If the matrix is singular.
    #[must_use]
    pub fn solve(&self, other: &Self) -> Self {
        let (n, mut a, mut b) = (self.columns, self.clone(), other.clone());
        for k in 0..n {
            let size = |i: usize| a.at(i, k).re.abs();
            let pivot = (k..n).max_by(|&i, &j| size(i).total_cmp(&size(j))).expect("rows");
            (0..n).for_each(|j| a.numbers.swap(k * n + j, pivot * n + j));
            (0..b.columns).for_each(|j| b.numbers.swap(k * b.columns + j, pivot * b.columns + j));
            assert!(a.at(k, k).re != 0.0, "singular");
            for i in (0..n).filter(|&i| i != k) {
                let share = a.at(i, k) / a.at(k, k);
                (k..n).for_each(|j| a.set(i, j, a.at(i, j) - share * a.at(k, j)));
                (0..b.columns).for_each(|j| b.set(i, j, b.at(i, j) - share * b.at(k, j)));
            }
        }
        for i in 0..n {
            (0..b.columns).for_each(|j| b.set(i, j, b.at(i, j) / a.at(i, i)));
        }
        b
    }

    /// `e^A`, by its power series on a short step, squared.
    fn exponential(&self) -> Self {
        let n = self.columns;
        let size = self
            .numbers
            .chunks_exact(n)
            .map(|row| row.iter().map(|x| x.re.abs()).sum::<f64>())
            .fold(0.0, f64::max);
        let halvings = (size / 0.25).log2().ceil().max(0.0) as i32;
        let scale = Complex::real(0.5f64.powi(halvings));
        let short = Self { numbers: self.numbers.iter().map(|&x| x * scale).collect(), columns: n };
        // e^A − I, so that what is next to the identity keeps its digits: (I + D)² = I + 2D + D².
        let (mut sum, mut term) = (short.clone(), short.clone());
        for k in 2..20 {
            term = term.product(&short);
            let share = Complex::real(1.0 / f64::from(k));
            term.numbers.iter_mut().for_each(|x| *x = *x * share);
            sum.numbers.iter_mut().zip(&term.numbers).for_each(|(sum, &x)| *sum = *sum + x);
        }
        for _ in 0..halvings {
            let square = sum.product(&sum);
            sum.numbers.iter_mut().zip(&square.numbers).for_each(|(sum, &x)| *sum = *sum + *sum + x);
        }
        for i in 0..n {
            sum.set(i, i, sum.at(i, i) + Complex::real(1.0));
        }
        sum
    }
}

/// A march of `M q̈ + C q̇ + K q = f`.
#[derive(Debug)]
pub struct March {
    /// State `(q, h q̇)` after a step, from it and the loads `M⁻¹ f` at the start and at the end.
    step: Matrix,
    inverse: Matrix,
    time_step: Complex,
    /// `(q, h q̇)`.
    state: Vec<Complex>,
}

impl March {
    /// A body at rest. The matrices are `n` by `n`.
    #[must_use]
    pub fn new(mass: &Matrix, damping: &Matrix, stiffness: &Matrix, time_step: Complex) -> Self {
        let (n, h) = (mass.columns, time_step);
        let (k, c) = (mass.solve(stiffness), mass.solve(damping));
        // Of (q, h q̇, h² a, h² (a₁ − a₀)) with the acceleration a of the loads, over a step of 1.
        let mut whole = Matrix::zeros(4 * n, 4 * n);
        let one = Complex::real(1.0);
        for i in 0..n {
            whole.set(i, n + i, one);
            whole.set(n + i, 2 * n + i, one);
            whole.set(2 * n + i, 3 * n + i, one);
            for j in 0..n {
                whole.set(n + i, j, -(h * h * k.at(i, j)));
                whole.set(n + i, n + j, -(h * c.at(i, j)));
            }
        }
        let whole = whole.exponential();
        let step = Matrix { numbers: whole.numbers[..8 * n * n].to_vec(), columns: 4 * n };
        let inverse = mass.solve(&Matrix::diagonal(&vec![one; n]));
        Self { step, inverse, time_step, state: vec![Complex::default(); 2 * n] }
    }

    /// Displacements and velocities become these.
    pub fn set(&mut self, q: &[Complex], rates: &[Complex]) {
        let h = self.time_step;
        self.state = q.iter().copied().chain(rates.iter().map(|&v| h * v)).collect();
    }

    /// A step under loads at its start and at its end.
    pub fn step(&mut self, start: &[Complex], end: &[Complex]) {
        let square = self.time_step * self.time_step;
        let [start, end] = [start, end].map(|f| self.inverse.times(f));
        let rise = start.iter().zip(&end).map(|(&a, &b)| square * (b - a));
        let all: Vec<Complex> =
            self.state.iter().copied().chain(start.iter().map(|&a| square * a)).chain(rise).collect();
        self.state = self.step.times(&all);
    }

    /// Displacement along a row.
    #[must_use]
    pub fn displacement(&self, row: &[f64]) -> Complex {
        row.iter().zip(&self.state).fold(Complex::default(), |sum, (&c, &q)| sum + Complex::real(c) * q)
    }

    /// Velocity along a row.
    #[must_use]
    pub fn velocity(&self, row: &[f64]) -> Complex {
        let rates = &self.state[row.len()..];
        let sum = row.iter().zip(rates).fold(Complex::default(), |sum, (&c, &q)| sum + Complex::real(c) * q);
        sum / self.time_step
    }
}
