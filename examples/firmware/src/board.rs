//! Start of a Cortex-M4F or M33, its SysTick timer, and semihosting: what a debugger or QEMU offers a
//! program. Everything `unsafe` of the firmware is here.

use core::arch::{asm, naked_asm};
use core::ffi::CStr;
use core::panic::PanicInfo;
use core::ptr::{addr_of_mut, read_volatile, write_volatile};
use core::sync::atomic::{AtomicU32, Ordering};

const SYSTICK_CONTROL: *mut u32 = 0xE000_E010 as *mut u32;
const SYSTICK_RELOAD: *mut u32 = 0xE000_E014 as *mut u32;
const SYSTICK_VALUE: *mut u32 = 0xE000_E018 as *mut u32;

/// Counts of the clock in a millisecond.
const RELOAD: u32 = parse(env!("CLOCK")) / 1000 - 1;
const PAINT: u32 = 0xC5C5_C5C5;

static TICKS: AtomicU32 = AtomicU32::new(0);

unsafe extern "C" {
    static mut pool_start: u32;
    static mut stack_bottom: u32;
    static mut stack_top: u32;
}

/// The stack, the start, and the handlers of faults and of SysTick; nothing else interrupts.
#[repr(C)]
struct Vectors {
    stack: *mut u32,
    handlers: [Option<unsafe extern "C" fn()>; 15],
}

// SAFETY: read by the processor only.
unsafe impl Sync for Vectors {}

#[used]
#[unsafe(no_mangle)]
#[unsafe(link_section = ".vectors")]
static vectors: Vectors = {
    let mut handlers: [Option<unsafe extern "C" fn()>; 15] = [Some(fault); 15];
    handlers[0] = Some(reset);
    handlers[14] = Some(systick);
    Vectors { stack: addr_of_mut!(stack_top), handlers }
};

const fn parse(text: &str) -> u32 {
    let (bytes, mut number, mut k) = (text.as_bytes(), 0, 0);
    while k < bytes.len() {
        number = 10 * number + (bytes[k] - b'0') as u32;
        k += 1;
    }
    number
}

/// In assembly, because a compiler may use floating-point registers or the stack before Rust may.
///
/// # Safety
/// Called by the processor, once.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn reset() {
    naked_asm!(
        "ldr r0, =0xE000ED88", // the floating-point unit
        "ldr r1, [r0]",
        "orr r1, r1, #0x00F00000",
        "str r1, [r0]",
        "dsb",
        "isb",
        "ldr r0, =data_start",
        "ldr r1, =data_end",
        "ldr r2, =data_in_flash",
        "1: cmp r0, r1",
        "bhs 2f",
        "ldr r3, [r2], #4",
        "str r3, [r0], #4",
        "b 1b",
        "2: movs r3, #0",
        "ldr r0, =bss_start",
        "ldr r1, =bss_end",
        "3: cmp r0, r1",
        "bhs 4f",
        "str r3, [r0], #4",
        "b 3b",
        "4: ldr r0, =stack_bottom",
        "ldr r3, ={paint}",
        "5: cmp r0, sp",
        "bhs 6f",
        "str r3, [r0], #4",
        "b 5b",
        "6: bl {start}",
        paint = const PAINT,
        start = sym start,
    )
}

extern "C" fn start() -> ! {
    exit(crate::main())
}

unsafe extern "C" fn fault() {
    print(b"fault\n\0");
    exit(1)
}

unsafe extern "C" fn systick() {
    TICKS.store(TICKS.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // Built for size, the compiler leaves checks in that it rules out when it builds for speed
    // (tests/bare-metal). None of them ever fails; this says so if one does.
    print(b"panic\n\0");
    exit(1)
}

/// Starts the clock; one tick is a millisecond.
pub fn start_clock() {
    // SAFETY: registers of every Cortex-M; on, with an interrupt, from the clock of the core.
    unsafe {
        write_volatile(SYSTICK_RELOAD, RELOAD);
        write_volatile(SYSTICK_VALUE, 0);
        write_volatile(SYSTICK_CONTROL, 7);
    }
}

/// Sleeps until there is a tick that was not waited for; how many there have been.
pub fn wait_for_tick() -> u32 {
    static SEEN: AtomicU32 = AtomicU32::new(0);
    loop {
        let ticks = TICKS.load(Ordering::Relaxed);
        if ticks != SEEN.swap(ticks, Ordering::Relaxed) {
            return ticks;
        }
        // SAFETY: sleeps until an interrupt.
        unsafe { asm!("wfi") };
    }
}

/// The clock, in counts below those of a millisecond.
pub fn count() -> u32 {
    // SAFETY: a register of every Cortex-M.
    RELOAD - unsafe { read_volatile(SYSTICK_VALUE) }
}

/// Counts between two times that are less than a millisecond apart.
pub fn between(earlier: u32, later: u32) -> u32 {
    if later >= earlier { later - earlier } else { later + RELOAD + 1 - earlier }
}

/// All RAM that nothing else uses. To be called once.
pub fn memory() -> &'static mut [f64] {
    // SAFETY: the linker script leaves this memory to nobody else; it is aligned to 16, and every pattern of
    // bits is a number.
    unsafe {
        let start = addr_of_mut!(pool_start);
        let bytes = addr_of_mut!(stack_bottom).addr() - start.addr();
        core::slice::from_raw_parts_mut(start.cast::<f64>(), bytes / 8)
    }
}

/// The largest depth of the stack so far, in bytes.
pub fn stack() -> u32 {
    // SAFETY: within the stack, which lives as long as the program.
    unsafe {
        let (mut at, top) = (addr_of_mut!(stack_bottom), addr_of_mut!(stack_top));
        while at < top && read_volatile(at) == PAINT {
            at = at.add(1);
        }
        (top.addr() - at.addr()) as u32
    }
}

fn semihosting(operation: u32, argument: *const u32) -> u32 {
    let mut result = operation;
    // SAFETY: the host reads and writes what the argument says, and each call below says it rightly.
    unsafe { asm!("bkpt 0xAB", inout("r0") result, in("r1") argument) };
    result
}

/// Prints a text that ends with a zero on the host.
pub fn print(text: &[u8]) {
    if text.last() == Some(&0) {
        semihosting(0x04, text.as_ptr().cast());
    }
}

/// Prints a text without a zero.
pub fn print_bytes(text: &[u8]) {
    for &byte in text {
        print(&[byte, 0]);
    }
}

/// Reads the start of a file of the host; how many bytes there were.
pub fn read_file(path: &CStr, out: &mut [u8]) -> Option<usize> {
    let name = [path.as_ptr().addr() as u32, 0, path.count_bytes() as u32];
    let file = semihosting(0x01, name.as_ptr());
    if file == u32::MAX {
        return None;
    }
    let wanted = [file, out.as_mut_ptr().addr() as u32, out.len() as u32];
    // The answer is how many bytes are missing.
    out.len().checked_sub(semihosting(0x06, wanted.as_ptr()) as usize)
}

/// Ends the program on the host: 0 is success.
fn exit(code: u32) -> ! {
    let reason = [0x20026, code];
    loop {
        semihosting(0x20, reason.as_ptr());
    }
}
