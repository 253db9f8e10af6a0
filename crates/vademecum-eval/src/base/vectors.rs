//! Inner loops on longer vectors, where the machine has them: the same code, compiled once more.

/// An inner loop and what it works on.
pub(crate) trait Kernel {
    /// Its result.
    type Output;

    /// Inlined, with all that it calls, or it stays as it was compiled for every machine.
    fn run(self) -> Self::Output;
}

/// Runs a kernel, with AVX2 where there is some: a product and a sum stay two roundings, so the bits are the
/// same.
#[inline(always)]
pub(crate) fn vectorised<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(all(feature = "std", target_arch = "x86_64"))]
    if let Some(with_avx2) = pulp::x86::V3::try_new() {
        return with_avx2.vectorize(Wide(kernel));
    }
    kernel.run()
}

/// A kernel for vectors of 32 bytes.
#[cfg(all(feature = "std", target_arch = "x86_64"))]
struct Wide<K>(K);

#[cfg(all(feature = "std", target_arch = "x86_64"))]
impl<K: Kernel> pulp::NullaryFnOnce for Wide<K> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.0.run()
    }
}
