//! A body in a microcontroller: the file lies in flash, SysTick calls 1000 times a second, and a host that
//! listens says where the body is touched and reads its probes.
//!
//! The host has a file `contacts.txt` with lines `TICK NODE FX FY FZ`, forces in mN: from that tick on the
//! only contact is this force at this node.
#![no_std]
#![no_main]

mod board;

use vademecum_eval::format::File;
use vademecum_eval::{Contact, Field, Loads, Scene, SceneOptions, State, Place};

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
fn touch(scene: &Scene<'_, f32>, loads: &mut Loads<'_, f32>, asked: &Touch) -> Option<()> {
    loads.clear();
    let force = asked.force.map(|force| f64::from(force) / 1000.0);
    if asked.force == [0; 3] {
        return Some(());
    }
    let contact = Contact::new(Place::triangle([asked.node; 3], [1.0, 0.0, 0.0]), force);
    loads.add_contact(scene, &contact).ok()
}

/// The next numbers of the memory that is lent.
fn take<'m, T: Copy>(memory: &mut &'m mut [T], length: usize) -> Option<&'m mut [T]> {
    let (taken, rest) = core::mem::take(memory).split_at_mut_checked(length)?;
    *memory = rest;
    Some(taken)
}

/// Runs the loop; the words say what was refused.
fn run() -> Result<(), &'static str> {
    // Ask, lend, bind. Work is needed while binding and for parameters.
    let file = File::parse(&FILE).map_err(|_| "the file")?;
    let options = SceneOptions { contacts: 1, ..SceneOptions::default() };
    let sizes = Scene::<f32>::sizes(&file, &options).map_err(|_| "the options")?;
    let (mut singles, mut doubles) = board::memory(sizes.work);
    let too_long = "the body does not fit into RAM";
    let work = take(&mut doubles, sizes.work).ok_or(too_long)?;
    let scene = take(&mut singles, sizes.scene).ok_or(too_long)?;
    let (state, loads) = (take(&mut singles, sizes.state), take(&mut singles, sizes.loads));
    let scene = Scene::bind(&file, &options, scene, work).map_err(|_| "binding")?;
    let mut state = State::new(&scene, state.ok_or(too_long)?).map_err(|_| "a state")?;
    let mut loads = Loads::new(&scene, loads.ok_or(too_long)?).map_err(|_| "loads")?;

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
            touch(&scene, &mut loads, &asked).ok_or("a contact")?;
            next = numbers.touch();
        }
        let before = board::count();
        scene.step(&mut state, &loads).map_err(|_| "a step")?;
        let after = board::count();
        sum += board::between(before, after);
        worst = worst.max(board::between(began, after));
        if (tick + 1) % EVERY == 0 {
            for probe in 0..file.metadata().n_probes {
                let read = |field| scene.probe(&state, probe as usize, field).map_err(|_| "a probe");
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
    let lent = 4 * (sizes.scene + sizes.state + sizes.loads) + 8 * sizes.work;
    print_named(b"modes \0", scene.n_modes() as u32);
    print_named(b"lent \0", lent as u32);
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
