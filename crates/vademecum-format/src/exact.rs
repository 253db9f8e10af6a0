//! One mode moved exactly over a step, for a load that is linear in time over it.
//!
//! A mode of stiffness `λ` and decay `σ` obeys `ζ̈ + 2σ ζ̇ + λ ζ = f(t)`. With `w² = λ Δt²`, `s = σ Δt` and
//! the state `y = (ζ, Δt ζ̇)` a step is
//!
//! ```text
//! y ← y + D y + P₀ f(t_n) + P₁ (f(t_n+1) − f(t_n))
//!
//! D = [ −w² φ   S           ]     P₀ = Δt² (φ, S)     P₁ = Δt² (ψ, φ)
//!     [ −w² S  −2sS − w² φ  ]
//! ```
//!
//! where `S(τ)` is the displacement after a unit velocity, `φ = ∫₀¹ S` and `ψ = ∫₀¹ ∫₀^τ S`: the response to
//! a unit step and to a unit ramp. Nothing in `D` cancels once the three are known. They are found
//!
//! - by their power series where `w` and `s` are below 1;
//! - through `e^{−s} cosh √z` and `e^{−s} sinh √z / √z` with `z = s² − w²`, both smooth through critical
//!   damping `z = 0`, where `z` is below ¼;
//! - through the two real decays `r₁ = s + √z` and `r₂ = w²/r₁` beyond that.
//!
//! Source: the closed form for a piecewise linear load (Nigam and Jennings 1969).

use crate::scheme::StepParameters;

/// A step of the filter `β ẏ + y = F` of forces that are linear over the step: under damping `C = βK` the
/// modes without inertia show `y` instead of `F`.
///
/// ```
/// use vademecum_format::exact::ForceFilter;
/// use vademecum_format::scheme::StepParameters;
///
/// let step = StepParameters { time_step: 1e-3, alpha: 0.0, beta: 2e-3, density: 1.0, stiffness: 1.0 };
/// let filter = ForceFilter::of(&step);
/// let y = filter.keep * 0.25 + filter.drive(1.0, 1.0);
/// assert!((y - (1.0 - 0.75 * (-0.5_f64).exp())).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ForceFilter {
    /// `e`, of the filtered force before the step.
    pub keep: f64,
    /// `g − e`, of the force at the start.
    pub start: f64,
    /// `1 − g`, of the force at the end.
    pub end: f64,
}

impl ForceFilter {
    /// That of no damping: it shows forces at once.
    pub const NONE: Self = Self { keep: 0.0, start: 0.0, end: 1.0 };

    /// The filter of a step; that of no damping shows forces at once.
    #[must_use]
    pub fn of(parameters: &StepParameters) -> Self {
        if parameters.beta <= 0.0 {
            return Self::NONE;
        }
        let x = parameters.time_step / parameters.beta;
        let keep = libm::exp(-x);
        let gone = -libm::expm1(-x);
        // 1 − (1 − e)/x loses its digits for small x; the next term of the series is x⁵/720.
        let end = if x < 1e-2 {
            x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0)))
        } else {
            1.0 - gone / x
        };
        Self { keep, start: gone - end, end }
    }

    /// Share of a force held over the step that the step shows, `1 − e`.
    #[must_use]
    pub const fn held(&self) -> f64 {
        self.start + self.end
    }

    /// Contribution of an amplitude that is linear over the step.
    #[must_use]
    pub const fn drive(&self, start: f64, end: f64) -> f64 {
        self.start * start + self.end * end
    }
}

/// `e^{AΔt} − I` of one mode, and its answers to a load held over the step and to one that rises over it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Propagator {
    /// `D`, row by row.
    pub d: [f64; 4],
    /// `P₀` \[s²\]: to a unit load held over the step.
    pub held: [f64; 2],
    /// `P₁` \[s²\]: to a load that rises from 0 to 1 over the step.
    pub rising: [f64; 2],
}

impl Propagator {
    /// Of a mode of stiffness `lambda` \[rad²/s²\], at least 0, and decay `sigma` \[1/s\], at least 0, over a
    /// step of `time_step` \[s\]. For other arguments the numbers mean nothing.
    ///
    /// ```
    /// use vademecum_format::exact::Propagator;
    ///
    /// // A quarter of a period without damping: displacement becomes velocity.
    /// let quarter = Propagator::new(1.0, 0.0, std::f64::consts::FRAC_PI_2);
    /// assert!((1.0 + quarter.d[0]).abs() < 1e-15);
    /// // A load held for ever leaves the static answer f/λ.
    /// let long = Propagator::new(4.0, 1.0, 1e3);
    /// assert!((long.held[0] - 0.25).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn new(lambda: f64, sigma: f64, time_step: f64) -> Self {
        let (w2, s, square) = (lambda * time_step * time_step, sigma * time_step, time_step * time_step);
        let [impulse, step, ramp] = responses(w2, s);
        Self {
            d: [-w2 * step, impulse, -w2 * impulse, -2.0 * s * impulse - w2 * step],
            held: [square * step, square * impulse],
            rising: [square * ramp, square * step],
        }
    }
}

/// `S`, `φ`, `ψ`.
fn responses(w2: f64, s: f64) -> [f64; 3] {
    let z = s * s - w2;
    if w2 < 1.0 && s < 1.0 {
        return series(w2, s);
    }
    if z < 0.25 {
        // w is above √¾ here, so the divisions by w² do no harm.
        let decay = libm::exp(-s);
        let (cosine, sine) = if z < 0.0 { rotation(w2, s) } else { growth(z) };
        let impulse = decay * sine;
        let step = (1.0 - decay * cosine - s * impulse) / w2;
        return [impulse, step, (1.0 - impulse - 2.0 * s * step) / w2];
    }
    let root = libm::sqrt(z);
    let (fast, apart) = (s + root, 2.0 * root);
    let slow = w2 / fast;
    let slow_decay = libm::exp(-slow);
    let impulse = slow_decay * mean_decay(apart);
    let step = (mean_decay(slow) - slow_decay * mean_decay(apart)) / fast;
    let ramp = if slow < 1.0 {
        (second_mean(slow) - second_mean(fast)) / apart
    } else {
        (1.0 - impulse - 2.0 * s * step) / w2
    };
    [impulse, step, ramp]
}

/// `a b` less its rounded value, exactly, for factors below 1e300 whose product is a normal number (Dekker
/// 1971): what a fused product would give, in a fifth of the code where a processor has none.
#[must_use]
#[inline(never)]
pub fn product_error(a: f64, b: f64) -> f64 {
    let split = |x: f64| {
        let scaled = 134_217_729.0 * x;
        let high = scaled - (scaled - x);
        (high, x - high)
    };
    let ((a, low_a), (b, low_b), product) = (split(a), split(b), a * b);
    low_a * low_b - (((product - a * b) - low_a * b) - a * low_b)
}

/// `cos a` and `sin a / a` of the angle `a = √(w² − s²)`. The angle carries its own rounding along: an angle
/// of a thousand that is rounded once has lost a part in 1e13 of its sine.
fn rotation(w2: f64, s: f64) -> (f64, f64) {
    let square = s * s;
    let difference = w2 - square;
    let lost = ((w2 - difference) - square) - product_error(s, s);
    let angle = libm::sqrt(difference);
    if angle < 1e-4 {
        return (1.0 - 0.5 * difference, 1.0 - difference / 6.0);
    }
    // `difference − angle²`: the first subtraction is exact, since the two are within a unit of each other.
    let rest = (((difference - angle * angle) - product_error(angle, angle)) + lost) / (2.0 * angle);
    let (sine, cosine) = libm::sincos(angle);
    (cosine - rest * sine, (sine + rest * cosine) / (angle + rest))
}

/// `cosh √z` and `sinh √z / √z`.
fn growth(z: f64) -> (f64, f64) {
    let root = libm::sqrt(z);
    (libm::cosh(root), if root < 1e-4 { 1.0 + z / 6.0 } else { libm::sinh(root) / root })
}

/// Power series of the three in the time of the step.
fn series(w2: f64, s: f64) -> [f64; 3] {
    // c_{n+2} = −(2s (n+1) c_{n+1} + w² c_n)/((n+1)(n+2)) are the coefficients of S(τ).
    let (mut before, mut now) = (0.0, 1.0);
    let mut sums = [1.0, 0.5, 1.0 / 6.0];
    let mut n = 1.0;
    // 30 terms leave 2³⁰/30! < 1e-23.
    for _ in 0..30 {
        let next = -(2.0 * s * n * now + w2 * before) / (n * (n + 1.0));
        (before, now) = (now, next);
        n += 1.0;
        sums[0] += now;
        sums[1] += now / (n + 1.0);
        sums[2] += now / ((n + 1.0) * (n + 2.0));
    }
    sums
}

/// `(1 − e^{−r})/r`.
fn mean_decay(r: f64) -> f64 {
    if r == 0.0 { 1.0 } else { -libm::expm1(-r) / r }
}

/// `(r − 1 + e^{−r})/r²`.
fn second_mean(r: f64) -> f64 {
    if r < 0.5 {
        // Σ (−r)^k/(k+2)!
        let (mut term, mut sum) = (0.5, 0.5);
        for k in 3..20 {
            term *= -r / f64::from(k);
            sum += term;
        }
        return sum;
    }
    (1.0 - mean_decay(r)) / r
}
