//! A body in a microcontroller: the file lies in flash, SysTick calls 1000 times a second, and a host that
//! listens says where the body is touched and reads its probes.
//!
//! The host has a file `contacts.txt` with lines `TICK NODE FX FY FZ`, forces in mN: from that tick on the
//! only contact is this force at this node.
#![no_std]
#![no_main]

mod board;

use vademecum_eval::format::File;
use vademecum_eval::{Body, BodyOptions, Field, Place, SceneOptions};

const TICKS: u32 = 1000;
const EVERY: u32 = 50;

/// The file, in flash beside the code.
#[unsafe(link_section = ".vademecum")]
static FILE: [u8; include_bytes!(env!("BODY")).len()] = *include_bytes!(env!("BODY"));

/// What the host asks for.
struct Touch {
    tick: u32,
    node: u32,
    /// mN.
    force: [i32; 3],
}

/// The numbers of the host's file, one after the other.
struct Numbers<'a> {
    text: core::slice::Iter<'a, u8>,
}

impl Numbers<'_> {
    fn next(&mut self) -> Option<i32> {
        let (mut found, mut negative) = (None, false);
        for &byte in self.text.by_ref() {
            match (byte, found) {
                (b'0'..=b'9', _) => {
                    let digit = i32::from(byte - b'0');
                    found = Some(found.unwrap_or(0i32).wrapping_mul(10).wrapping_add(digit));
                }
                (_, Some(_)) => break,
                (byte, None) => negative = byte == b'-',
            }
        }
        found.map(|number| if negative { number.wrapping_neg() } else { number })
    }

    fn touch(&mut self) -> Option<Touch> {
        let (tick, node) = (self.next()? as u32, self.next()? as u32);
        Some(Touch { tick, node, force: [self.next()?, self.next()?, self.next()?] })
    }
}

/// Takes the loads away and touches the body anew.
fn touch(body: &mut Body<'_, f32>, asked: &Touch) -> Option<()> {
    body.clear();
    let force = asked.force.map(|force| f64::from(force) / 1000.0);
    if asked.force == [0; 3] {
        return Some(());
    }
    body.push(&Place::node(asked.node), force).ok()
}

/// Runs the loop; the words say what was refused.
fn run() -> Result<(), &'static str> {
    // Ask, lend, bind.
    let file = File::parse(&FILE).map_err(|_| "the file")?;
    let scene = SceneOptions { contacts: 1, ..SceneOptions::default() };
    let options = BodyOptions { scene, places: 0, ..BodyOptions::default() };
    let lent = Body::<f32>::len_for(&file, &options).map_err(|_| "the options")?;
    let memory = board::memory().get_mut(..lent).ok_or("the body does not fit into RAM")?;
    let mut body = Body::<f32>::bind(&file, &options, memory).map_err(|_| "binding")?;

    let mut text = [0; 1024];
    let read = board::read_file(c"contacts.txt", &mut text).ok_or("no file contacts.txt on the host")?;
    let mut numbers = Numbers { text: text.get(..read).unwrap_or(&[]).iter() };
    let mut next = numbers.touch();

    let (mut sum, mut worst, mut late) = (0, 0, 0);
    board::start_clock();
    for tick in 0..TICKS {
        late += u32::from(board::wait_for_tick() != tick + 1);
        let began = board::count();
        while let Some(asked) = next.take_if(|asked| asked.tick <= tick) {
            touch(&mut body, &asked).ok_or("a contact")?;
            next = numbers.touch();
        }
        let before = board::count();
        body.step().map_err(|_| "a step")?;
        let after = board::count();
        sum += board::between(before, after);
        worst = worst.max(board::between(began, after));
        if (tick + 1) % EVERY == 0 {
            for probe in 0..file.metadata().n_probes {
                let read = |field| body.probe(probe as usize, field).map_err(|_| "a probe");
                let (moved, speed) = (read(Field::Displacement)?, read(Field::Velocity)?);
                board::print(b"step \0");
                print_number(u64::from(tick + 1), 10, 1);
                board::print(b" probe \0");
                print_number(u64::from(probe), 10, 1);
                print_value(b" moved \0", moved);
                print_value(b" speed \0", speed);
                board::print(b"\n\0");
            }
        }
    }
    print_named(b"modes \0", body.scene().n_modes() as u32);
    print_named(b"lent \0", 8 * lent as u32);
    print_named(b"stack \0", board::stack());
    print_named(b"counts \0", sum);
    print_named(b"worst \0", worst);
    print_named(b"late \0", late);
    Ok(())
}

fn main() -> u32 {
    match run() {
        Ok(()) => 0,
        Err(what) => {
            board::print(b"refused: \0");
            board::print_bytes(what.as_bytes());
            board::print(b"\n\0");
            1
        }
    }
}

fn print_number(mut number: u64, base: u64, digits: usize) {
    let mut text = [0; 24];
    let mut used = 1;
    for place in text.iter_mut().rev().skip(1) {
        let digit = (number % base) as u8;
        *place = if digit < 10 { b'0' + digit } else { b'a' + digit - 10 };
        (number, used) = (number / base, used + 1);
        if number == 0 && used > digits {
            break;
        }
    }
    board::print(text.get(text.len() - used..).unwrap_or(b"\0"));
}

fn print_named(name: &[u8], number: u32) {
    board::print(name);
    print_number(u64::from(number), 10, 1);
    board::print(b"\n\0");
}

/// Prints a probe as its bits and in nm or nm/s.
fn print_value(name: &[u8], value: f64) {
    board::print(name);
    print_number(value.to_bits(), 16, 16);
    board::print(if value < 0.0 { b" = -\0" } else { b" = \0" });
    let nano = value * 1e9;
    print_number((if nano < 0.0 { -nano } else { nano }) as u64, 10, 1);
    board::print(b" e-9\0");
}
