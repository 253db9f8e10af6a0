//! One instance: a body, its clock, its place in the course of a simulation, and the log of its master. Both
//! versions of FMI are thin over it.
#![allow(unsafe_code)]

use core::ffi::{CStr, c_int};
use core::ptr::NonNull;

use vademecum_eval::format::File;

use crate::body::{Body, MAX_STEPS};
use crate::bytes::{Cursor, Pen};
use crate::location::{Location, text};
use crate::logger::{Category, Logger, status};
use crate::memory::{Block, Chain};
use crate::mode::{Mode, Modes};
use crate::points::Points;
use crate::refusal::{Refusal, Trouble, bind};
use crate::token;
use crate::variables::Variable;
use crate::watch::Watch;
use crate::words::{Say, Words, sentence};

/// Arguments of a master that makes an instance.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// Its name.
    pub name: &'a CStr,
    /// The token of the model description.
    pub token: &'a [u8],
    /// Location of the resources.
    pub resources: Location<'a>,
    /// True if the log shows more than refusals.
    pub logging: bool,
    /// Watch of the master over steps.
    pub watch: Watch,
    /// Variables that it reads within steps.
    pub watched: &'a [u32],
}

/// An instance.
#[derive(Debug)]
pub struct Instance {
    /// Refers to the blocks below.
    body: Body,
    mode: Mode,
    /// True once start and stop of the experiment are known.
    is_set_up: bool,
    /// The master's clock \[s\].
    time: f64,
    stop: Option<f64>,
    logger: Logger,
    logging: bool,
    watch: Watch,
    token: [u8; token::LENGTH],
    /// States that the master has not freed.
    states: Chain,
    name: Block,
    _numbers: Block,
    _points: Block,
    _file: Block,
}

impl Instance {
    /// Opens the resources and makes an instance; `None` if that is refused, which the log tells.
    #[must_use]
    pub fn make(given: &Given<'_>, logger: Logger) -> Option<NonNull<Self>> {
        match Self::open(given, logger) {
            Ok(instance) => instance.place(),
            Err((what, why)) => {
                let text: [&dyn Say; 3] = [&"the instance was not made: ", &what, &why];
                logger.tell(given.name, Category::Error, &text);
                None
            }
        }
    }

    fn open(given: &Given<'_>, logger: Logger) -> Result<Self, (&'static str, &'static str)> {
        let read = |name: &'static str, told: &'static str| {
            let path = given.resources.of_file(name.as_bytes()).map_err(|why| ("", why))?;
            Block::read(text(&path)).map_err(|why| (told, why))
        };
        let file_block = read("body.vdm", "resources/body.vdm: ")?;
        let points_block = read("points.bin", "resources/points.bin: ")?;
        let token = token::token(file_block.bytes(), points_block.bytes());
        if given.token != token {
            return Err((
                "",
                "the GUID or instantiation token is not that of the file and the points in the resources: \
                 export the FMU again",
            ));
        }
        // SAFETY: the blocks are kept beside the body that is made of them, nobody writes them, and moving a
        // block does not move its bytes.
        let (bytes, table) = unsafe { (file_block.lend(), points_block.lend()) };
        let of_file = |error| ("resources/body.vdm: ", bind(&error));
        let file = File::parse(bytes).map_err(|error| of_file(error.into()))?;
        file.verify_all().map_err(|error| of_file(error.into()))?;
        let points = Points::parse(table, file.metadata().n_load_nodes)
            .ok_or(("resources/points.bin: ", "this is no table of points of this file"))?;
        let length = Body::len_for(&file, &points).map_err(of_file)?;
        let no_memory = ("", "the host has no memory left");
        let mut numbers = Block::zeroed(length.saturating_mul(8)).ok_or(no_memory)?;
        // SAFETY: the same; the body alone uses them.
        let body = Body::new(&file, points, unsafe { numbers.lend_numbers() }).map_err(of_file)?;
        let is_shown = |&reference: &u32| {
            let variable = body.counts().variable(reference);
            variable.is_some_and(Variable::is_output)
        };
        if !given.watched.iter().all(is_shown) {
            return Err(("", "within a step outputs may be read, and nothing else (intermediateUpdate)"));
        }
        let mut name = Block::zeroed(given.name.to_bytes_with_nul().len()).ok_or(no_memory)?;
        let copied = name.bytes_mut().iter_mut().zip(given.name.to_bytes_with_nul());
        copied.for_each(|(place, &byte)| *place = byte);
        let instance = Self {
            body,
            mode: Mode::Instantiated,
            is_set_up: false,
            time: 0.0,
            stop: None,
            logger,
            logging: given.logging,
            watch: given.watch,
            token,
            states: Chain::new().ok_or(no_memory)?,
            name,
            _numbers: numbers,
            _points: points_block,
            _file: file_block,
        };
        let (modes, step) = (instance.body.n_modes(), instance.body.internal_step());
        let modes = modes as u64;
        instance.tell_event(&[
            &"vademecum ",
            &VERSION,
            &": ",
            &modes,
            &" modes, internal step ",
            &step,
            &" s",
        ]);
        Ok(instance)
    }

    /// Puts the instance where a pointer can find it.
    fn place(self) -> Option<NonNull<Self>> {
        const { assert!(align_of::<Instance>() <= 16) };
        let Some(block) = Block::zeroed(size_of::<Self>()) else {
            self.tell(&[&"the instance was not made: the host has no memory left"]);
            return None;
        };
        let at = block.into_raw().cast::<Self>();
        // SAFETY: large enough, aligned to 16 bytes, and nobody else's.
        unsafe { at.write(self) };
        Some(at)
    }

    /// Frees an instance.
    ///
    /// # Safety
    /// `instance` is from [`Instance::make`], and nobody uses it any more.
    pub unsafe fn free(instance: NonNull<Self>) {
        // SAFETY: as the caller promises; the block is that of `place`.
        unsafe {
            instance.drop_in_place();
            drop(Block::of_raw(instance.cast(), size_of::<Self>()));
        }
    }

    /// Runs a call, if it is allowed where the instance is; what is refused is reported, with the name of the
    /// call.
    pub fn call(
        &mut self,
        call: &'static str,
        allowed: Modes,
        action: impl FnOnce(&mut Self) -> Result<(), Trouble>,
    ) -> c_int {
        if !allowed.holds(self.mode) {
            self.tell(&[&call, &" is not allowed now: ", &self.mode.words()]);
            return status::ERROR;
        }
        match action(self) {
            Ok(()) => status::OK,
            Err(Trouble { refusal, variable: None }) => {
                self.tell(&[&call, &": ", &refusal]);
                status::ERROR
            }
            Err(Trouble { refusal, variable: Some(variable) }) => {
                let name = Name { body: &self.body, variable };
                self.tell(&[&call, &": ", &name, &": ", &refusal]);
                status::ERROR
            }
        }
    }

    /// States that the master has not freed; they end with the instance.
    pub const fn states(&mut self) -> &mut Chain {
        &mut self.states
    }

    fn instance_name(&self) -> &CStr {
        // SAFETY: the block holds a text with its zero.
        unsafe { CStr::from_ptr(self.name.bytes().as_ptr().cast()) }
    }

    fn tell(&self, text: &[&dyn Say]) {
        self.logger.tell(self.instance_name(), Category::Error, text);
    }

    fn tell_event(&self, text: &[&dyn Say]) {
        if self.logging {
            self.logger.tell(self.instance_name(), Category::Event, text);
        }
    }

    /// Asks for more than refusals, or no longer. Refusals are logged in any case.
    ///
    /// # Errors
    /// [`Refusal::Unsupported`]: a category that is not in the model description.
    pub fn set_logging<'a>(
        &mut self,
        on: bool,
        mut categories: impl Iterator<Item = Option<&'a CStr>>,
    ) -> Result<(), Trouble> {
        let known =
            |category: Option<&CStr>| Category::ALL.iter().any(|known| Some(known.name()) == category);
        if !categories.all(known) {
            return Err(Refusal::Unsupported("there are the categories logStatusError and logEvents").into());
        }
        self.logging = on;
        Ok(())
    }

    /// Says when the experiment starts, and when it stops at the latest.
    ///
    /// # Errors
    /// [`Refusal::BadExperiment`].
    pub fn set_up(&mut self, start: f64, stop: Option<f64>) -> Result<(), Trouble> {
        let end = stop.unwrap_or(start);
        if !(start.is_finite() && end.is_finite() && start <= end) {
            return Err(Refusal::BadExperiment { start, stop: end }.into());
        }
        (self.time, self.stop, self.is_set_up) = (start, stop, true);
        Ok(())
    }

    /// Begins the initialization.
    ///
    /// # Errors
    /// [`Refusal::Unsupported`]: nobody has told when the experiment starts.
    pub fn begin(&mut self) -> Result<(), Trouble> {
        if !self.is_set_up {
            return Err(Refusal::Unsupported("fmi2SetupExperiment has to be called before").into());
        }
        self.mode = Mode::Initialization;
        Ok(())
    }

    /// True before the first step.
    #[must_use]
    pub fn is_starting(&self) -> bool {
        self.mode != Mode::Step
    }

    /// Goes to another mode.
    pub const fn go(&mut self, mode: Mode) {
        self.mode = mode;
    }

    /// Becomes what it was when it was made.
    ///
    /// # Errors
    /// [`Refusal::Bind`]: a file that has changed.
    pub fn reset(&mut self) -> Result<(), Trouble> {
        self.body.reset()?;
        (self.mode, self.is_set_up, self.time, self.stop) = (Mode::Instantiated, false, 0.0, None);
        Ok(())
    }

    /// Time \[s\] up to which it has stepped.
    #[must_use]
    pub const fn time(&self) -> f64 {
        self.time
    }

    /// Goes to the configuration, in which structural parameters are set.
    ///
    /// # Errors
    /// [`Refusal::Unsupported`]: an FMU without arrays.
    pub fn configure(&mut self) -> Result<(), Trouble> {
        if self.body.counts().surface == 0 {
            const NONE: &str = "this FMU has no structural parameters; export it with --surface";
            return Err(Refusal::Unsupported(NONE).into());
        }
        self.mode = Mode::Configuration;
        Ok(())
    }

    /// Steps from a communication point by a communication step: a multiple of the internal step, or of a
    /// file with exact steps any length.
    ///
    /// The instance keeps the master's clock: it takes the point from which the master steps, and after the
    /// step it is where the master's sum is. So roundings of a long run do not add up against it.
    ///
    /// # Errors
    /// [`Refusal`]; the instance is then where it was.
    pub fn advance(&mut self, point: f64, size: f64) -> Result<(), Trouble> {
        let (steps, length, end) = self.plan(point, size)?;
        self.body.step(steps, length)?;
        self.time = end;
        Ok(())
    }

    /// Number and length \[s\] of the internal steps of a communication step, and its end \[s\].
    ///
    /// # Errors
    /// [`Refusal`] of times.
    pub fn plan(&self, point: f64, size: f64) -> Result<(u64, f64, f64), Refusal> {
        let step = self.body.internal_step();
        let any = self.body.takes_any_step();
        let end = point + size;
        // The two last places of a sum of two times, which a master has to form.
        let rounding = 2.0 * f64::EPSILON * larger(magnitude(point), magnitude(end));
        // A millionth of a step is no time at all, whatever it comes from.
        let apart = 1e-6 * step + rounding;
        if !(point.is_finite() && magnitude(point - self.time) <= apart) {
            return Err(Refusal::OtherTime { point, time: self.time });
        }
        let ratio = size / step;
        if any && !(ratio.is_finite() && ratio > 1e-6) {
            return Err(Refusal::NoTime { size });
        }
        if !(ratio.is_finite() && ratio > 0.0) {
            return Err(Refusal::NoMultiple { size, step });
        }
        if ratio > MAX_STEPS as f64 {
            return Err(Refusal::TooManySteps { size, step, most: MAX_STEPS });
        }
        let steps = (ratio + 0.5) as u64;
        // `Δt` times a whole number, but for its own rounding and that of the master's times.
        let is_multiple = steps != 0 && magnitude(size - steps as f64 * step) <= 1e-9 * size + rounding;
        let (steps, length) = match is_multiple {
            true => (steps, step),
            // Steps of one length, none of them longer than the internal step.
            false if any => {
                let steps = ratio as u64 + 1;
                (steps, size / steps as f64)
            }
            false => return Err(Refusal::NoMultiple { size, step }),
        };
        if let Some(stop) = self.stop.filter(|&stop| end > stop + apart) {
            return Err(Refusal::BeyondStop { end, stop });
        }
        Ok((steps, length, end))
    }

    /// Comes to a time \[s\].
    pub const fn arrive(&mut self, time: f64) {
        self.time = time;
    }

    /// Watch of the master over steps.
    #[must_use]
    pub const fn watch(&self) -> Watch {
        self.watch
    }

    /// The body.
    #[must_use]
    pub const fn body(&self) -> &Body {
        &self.body
    }

    /// The body, to be stepped.
    pub const fn body_mut(&mut self) -> &mut Body {
        &mut self.body
    }

    /// Bytes of a saved state, always the same.
    #[must_use]
    pub const fn saved_len(&self) -> usize {
        HEAD + self.body.saved_len() + CHECKSUM
    }

    /// Saves everything that can change into a new block.
    ///
    /// # Errors
    /// [`Refusal::Memory`].
    pub fn save(&mut self) -> Result<Block, Trouble> {
        let mut block = Block::zeroed(self.saved_len()).ok_or(Refusal::Memory)?;
        let room = Refusal::Saved("there is no room for it");
        let length = self.saved_len().saturating_sub(CHECKSUM);
        let (content, checksum) = block.bytes_mut().split_at_mut_checked(length).ok_or(room)?;
        let mut pen = Pen::new(content);
        pen.put(&STATE).ok_or(room)?;
        pen.put(&self.token).ok_or(room)?;
        let flags = u8::from(self.is_set_up) + 2 * u8::from(self.stop.is_some());
        pen.put(&[self.mode as u8, flags]).ok_or(room)?;
        pen.numbers(&[self.time, self.stop.unwrap_or_default()]).ok_or(room)?;
        self.body.save_into(&mut pen)?;
        Pen::new(checksum).put(&crc32fast::hash(content).to_le_bytes()).ok_or(room)?;
        Ok(block)
    }

    /// Takes a saved state back.
    ///
    /// # Errors
    /// [`Refusal::Saved`]: damaged, cut, or of another body; the instance is then as it was.
    pub fn restore(&mut self, saved: &[u8]) -> Result<(), Trouble> {
        let content = self.check_saved(saved)?;
        let bad = Refusal::Saved("its head is damaged");
        let mut cursor = Cursor::new(content);
        cursor.take(STATE.len() + token::LENGTH).ok_or(bad)?;
        let &[mode, flags] = cursor.take(2).ok_or(bad)? else { return Err(bad.into()) };
        let mode = Mode::of_number(mode).ok_or(bad)?;
        let (time, stop) = (cursor.f64().ok_or(bad)?, cursor.f64().ok_or(bad)?);
        if flags > 3 || !time.is_finite() || !stop.is_finite() {
            return Err(bad.into());
        }
        self.body.restore(&mut cursor)?;
        (self.mode, self.time) = (mode, time);
        (self.is_set_up, self.stop) = (flags & 1 != 0, (flags & 2 != 0).then_some(stop));
        Ok(())
    }

    /// The bytes between head and checksum of a state that was saved by an instance of the same FMU.
    ///
    /// # Errors
    /// [`Refusal::Saved`].
    pub fn check_saved<'a>(&self, saved: &'a [u8]) -> Result<&'a [u8], Refusal> {
        if saved.len() != self.saved_len() {
            return Err(Refusal::Saved("it has another length"));
        }
        let (content, checksum) = saved.split_last_chunk::<4>().ok_or(Refusal::Saved("it is too short"))?;
        let rest = content.strip_prefix(&STATE).ok_or(Refusal::Saved("it begins otherwise"))?;
        if !rest.starts_with(&self.token) {
            return Err(Refusal::Saved("it belongs to another FMU"));
        }
        if crc32fast::hash(content).to_le_bytes() != *checksum {
            return Err(Refusal::Saved("its checksum does not match"));
        }
        Ok(content)
    }
}

/// First bytes of a saved state.
const STATE: [u8; 8] = *b"VDMSTAT2";
/// Bytes before the numbers of the body.
const HEAD: usize = STATE.len() + token::LENGTH + 2 + 16;
/// Bytes behind them.
const CHECKSUM: usize = 4;
/// Version of this library.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Name of a variable, as the model description has it but for quotes.
struct Name<'a> {
    body: &'a Body,
    variable: Variable,
}

impl Say for Name<'_> {
    fn say(&self, words: &mut Words) {
        if let Some((array, row, column)) = self.variable.in_array(self.body.counts().points) {
            // Elements are counted from 1, as FMI does.
            let [row, column] = [row, column].map(|index| u64::from(index).saturating_add(1));
            sentence!(words, array.kind().0, "[", row, ",", column, "]");
            return;
        }
        let (kind, component) = self.variable.kind();
        let name = self.body.name(self.variable);
        let parts = [kind, name, component.unwrap_or_default()];
        for (place, part) in parts.into_iter().filter(|part| !part.is_empty()).enumerate() {
            words.add(if place > 0 { "." } else { "" });
            words.add(part);
        }
    }
}

const fn magnitude(x: f64) -> f64 {
    if x < 0.0 { -x } else { x }
}

const fn larger(a: f64, b: f64) -> f64 {
    if a < b { b } else { a }
}
