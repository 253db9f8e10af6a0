//! Did a calculation meet denormal numbers? The processor keeps a flag, so the answer does not depend on how
//! fast it is.
//!
//! An operation with a denormal operand or result costs many times a normal one on most processors, and a
//! body that rings down would be full of them. A clock sees that only on a quiet machine. The status register
//! MXCSR of x86-64 remembers, until it is cleared, that some operand was denormal (DE) or that some result
//! was below the smallest normal number (UE).

/// What [`watch`] saw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Denormals {
    /// No operation took or gave a denormal number.
    None,
    /// At least one did.
    Met,
    /// This kind of processor keeps no such flag.
    Unknown,
}

/// Runs `work` and tells whether one of its operations in `f32` or `f64` took or gave a denormal number.
pub fn watch(work: impl FnOnce()) -> Denormals {
    register::clear();
    work();
    register::seen()
}

#[cfg(target_arch = "x86_64")]
mod register {
    use super::Denormals;
    use std::arch::asm;

    /// DE (bit 1) and UE (bit 4).
    const FLAGS: u32 = 1 << 1 | 1 << 4;

    fn read() -> u32 {
        let mut register = 0u32;
        // SAFETY: writes the four bytes of the status register to the place given and changes nothing else.
        // Without `pure` and with memory clobbered, no operation on lent memory moves across it.
        #[allow(unsafe_code)]
        unsafe {
            asm!("stmxcsr [{place}]", place = in(reg) &mut register, options(nostack));
        }
        register
    }

    pub fn clear() {
        let register = read() & !FLAGS;
        // SAFETY: the value is the register's own with two sticky flags cleared: rounding mode and masks stay
        // as they are.
        #[allow(unsafe_code)]
        unsafe {
            asm!("ldmxcsr [{place}]", place = in(reg) &register, options(nostack));
        }
    }

    pub fn seen() -> Denormals {
        if read() & FLAGS == 0 { Denormals::None } else { Denormals::Met }
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod register {
    use super::Denormals;

    pub fn clear() {}

    pub fn seen() -> Denormals {
        Denormals::Unknown
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::hint::black_box;

    #[test]
    fn a_denormal_operand_or_result_is_seen_and_a_normal_one_is_not() {
        if watch(|| ()) == Denormals::Unknown {
            eprintln!("skipped: this kind of processor keeps no flag of denormal numbers");
            return;
        }
        assert_eq!(watch(|| _ = black_box(black_box(1e-300f64) * black_box(1e-7))), Denormals::None);
        assert_eq!(watch(|| _ = black_box(black_box(1e-300f64) * black_box(1.1e-10))), Denormals::Met);
        assert_eq!(watch(|| _ = black_box(black_box(5e-324f64) + black_box(1.0))), Denormals::Met);
        assert_eq!(watch(|| _ = black_box(black_box(1e-30f32) * black_box(1.1e-10))), Denormals::Met);
        assert_eq!(watch(|| _ = black_box(black_box(1e-44f32) + black_box(1.0))), Denormals::Met);
        assert_eq!(watch(|| _ = black_box(black_box(0.0f32) * black_box(1e-30))), Denormals::None);
    }
}
