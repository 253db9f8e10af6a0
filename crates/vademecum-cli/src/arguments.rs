//! Arguments that several commands take, and what they mean without them.

use std::path::{Path, PathBuf};

use vademecum_build::input::Problem;
use vademecum_deck::{Dialect, ReadOptions, System};
use vademecum_eval::{SceneOptions, StructureChoice};
use vademecum_format::File;
use vademecum_study::StudyError;
use vademecum_study::frf::{FREQUENCIES, POINTS, Quantity, frequencies, with_poles};
use vademecum_study::parameters::ParameterValue;
use vademecum_study::player::PlayOptions;
use vademecum_study::scenario::Scenario;

use crate::failure::Failure;

/// Arguments of every command that writes files.
#[derive(clap::Args)]
pub struct OutputArguments {
    /// Overwrite outputs of another kind too [default: only files of the same kind].
    #[arg(long)]
    pub force: bool,
}

/// Arguments of commands that read a deck.
#[derive(clap::Args)]
pub(crate) struct DeckArguments {
    /// Program whose meaning element names of a deck have, `abaqus` or `calculix` [default: by its cards].
    #[arg(long, value_parser = ["abaqus", "calculix"])]
    dialect: Option<String>,
    /// Units of a deck; `none` keeps its numbers [default: guessed from modulus and density].
    #[arg(long, value_parser = ["m-kg-N", "mm-t-N", "mm-kg-mN", "in-lbf", "ft-lbf", "none"])]
    units: Option<String>,
}

impl DeckArguments {
    /// As the reader takes them.
    pub(crate) fn options(&self) -> ReadOptions {
        let dialect = self.dialect.as_deref();
        ReadOptions {
            dialect: dialect.map(|name| if name == "abaqus" { Dialect::Abaqus } else { Dialect::CalculiX }),
            units: self.units.as_deref().and_then(System::parse),
        }
    }

    /// True if one was given.
    pub(crate) fn given(&self) -> bool {
        self.dialect.is_some() || self.units.is_some()
    }
}

/// The problem and scenario of the demo, inside the program.
pub(crate) const PROBLEM: &str = include_str!("../assets/cantilever.toml");
/// See [`PROBLEM`].
pub(crate) const SCENARIO: &str = include_str!("../assets/push.toml");

/// The demo's problem.
pub(crate) fn demo_problem() -> Result<Problem, Failure> {
    Ok(Problem::parse(PROBLEM, "the demo's problem", PathBuf::new())?)
}

/// The demo's scenario.
pub(crate) fn demo_scenario() -> Result<Scenario, Failure> {
    Ok(Scenario::parse(SCENARIO, "the demo's scenario")?)
}

/// The problem of a file, or the demo's.
pub fn problem_or_demo(path: Option<&Path>) -> Result<Problem, Failure> {
    path.map_or_else(demo_problem, |path| Ok(Problem::read(path)?))
}

/// The scenario of a file; without one the demo's for its problem, and none for another.
pub fn scenario_or_demo(path: Option<&Path>, problem: Option<&Path>) -> Result<Option<Scenario>, Failure> {
    match (path, problem) {
        (Some(path), _) => Ok(Some(Scenario::read(path)?)),
        (None, None) => demo_scenario().map(Some),
        (None, Some(_)) => Ok(None),
    }
}

/// A live parameter and its value, from `NAME=VALUE`. A name may hold the sign itself.
pub(crate) fn setting(text: &str) -> Result<ParameterValue, String> {
    let (name, value) = text.rsplit_once('=').ok_or("expected NAME=VALUE")?;
    let number = value.trim().parse().map_err(|_| format!("`{value}` is not a number"))?;
    Ok(ParameterValue { name: name.trim().to_string(), value: number })
}

/// A positive number.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| format!("`{text}` is not a positive number; expected one such as 1e-3"))
}

/// A relative error that rounding may bring.
pub(crate) fn rounding(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| (1e-12..=0.1).contains(number));
    number.ok_or_else(|| format!("`{text}` is not a number from 1e-12 to 0.1; expected one such as 1e-4"))
}

/// Structure of the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum StructureArgument {
    /// The cheapest whose certificate keeps the tolerance.
    Auto,
    /// One 3 × 3 map per mode.
    Diagonal,
    /// One dense map.
    Block,
    /// Each mode moved exactly.
    Exact,
    /// The chapter's separated stage maps; `canonical` is the older word.
    #[value(alias = "canonical")]
    Chapter,
}

impl StructureArgument {
    /// Options of the player.
    pub(crate) fn options(self) -> PlayOptions {
        let structure = match self {
            Self::Diagonal => StructureChoice::Diagonal,
            Self::Block => StructureChoice::Block,
            Self::Exact => StructureChoice::Exact,
            Self::Auto | Self::Chapter => StructureChoice::Auto,
        };
        let scene = SceneOptions { structure, ..SceneOptions::default() };
        PlayOptions { chapter: self == Self::Chapter, scene, ..PlayOptions::default() }
    }
}

/// Quantity of a response.
#[derive(Clone, Copy, clap::ValueEnum)]
pub(crate) enum QuantityArgument {
    /// Displacement in m.
    Displacement,
    /// Velocity in m/s.
    Velocity,
    /// Acceleration in m/s².
    Acceleration,
}

impl QuantityArgument {
    /// As the study takes it.
    pub(crate) const fn quantity(self) -> Quantity {
        match self {
            Self::Displacement => Quantity::Displacement,
            Self::Velocity => Quantity::Velocity,
            Self::Acceleration => Quantity::Acceleration,
        }
    }

    /// Unit of the outputs, to a force of 1 N or to a load pattern.
    pub(crate) const fn unit(self, by_pattern: bool) -> &'static str {
        match (self, by_pattern) {
            (Self::Displacement, false) => "m/N",
            (Self::Velocity, false) => "m/(N s)",
            (Self::Acceleration, false) => "m/(N s²)",
            (Self::Displacement, true) => "m",
            (Self::Velocity, true) => "m/s",
            (Self::Acceleration, true) => "m/s²",
        }
    }
}

/// Live parameters that are set, and the modes that are taken then.
#[derive(clap::Args)]
pub(crate) struct SetArguments {
    /// Set a live parameter of the file, by its name; may be given several times.
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    pub(crate) set: Vec<ParameterValue>,
    /// Modes that are taken of a file with live regions [default: all].
    #[arg(long, value_name = "N")]
    pub(crate) modes: Option<usize>,
}

/// Frequencies of a response.
#[derive(clap::Args)]
pub(crate) struct GridArguments {
    /// Number of frequencies. The damped natural frequencies and the half-power points of the file that lie
    /// in the range are added.
    #[arg(long, default_value_t = 1000, value_parser = points())]
    points: u32,
    /// Space the frequencies in equal ratios instead of equal steps; a picture has a logarithmic axis then.
    #[arg(long)]
    pub(crate) log: bool,
    /// Add no frequencies to those of `--points`.
    #[arg(long)]
    no_poles: bool,
}

impl GridArguments {
    /// The frequencies \[Hz\] in a range, for a file at these options.
    pub(crate) fn frequencies(
        &self,
        range: Option<[f64; 2]>,
        file: &File<'_>,
        options: &SceneOptions,
    ) -> Result<Vec<f64>, StudyError> {
        let grid = range.map_or(vec![], |range| frequencies(range, self.points as usize, self.log));
        if self.no_poles { Ok(grid) } else { with_poles(file, options, grid) }
    }
}

/// The range of `--points`, as clap takes it.
pub(crate) fn points() -> clap::builder::RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(i64::from(*POINTS.start())..=i64::from(*POINTS.end()))
}

/// Two frequencies, ascending, above 0.
pub(crate) fn range(text: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[first, last])
            if FREQUENCIES.contains(&first) && FREQUENCIES.contains(&last) && last > first =>
        {
            Ok([first, last])
        }
        _ => Err(format!(
            "`{text}` is no range of frequencies; write two ascending ones from {:e} to {:e} Hz, such as 1,500",
            FREQUENCIES.start(),
            FREQUENCIES.end()
        )),
    }
}

/// Limit on decoded sizes: the same flag for every command that decodes.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct Limit {
    /// Limit on the decoded size of the packed sections that are read, such as 500000, 512M or 4G [default:
    /// 64M and 64 times the length of the file].
    #[arg(long, value_name = "SIZE", value_parser = size)]
    limit: Option<u64>,
}

impl Limit {
    /// For a file of this length.
    pub(crate) fn of(self, file_length: usize) -> u64 {
        self.limit.unwrap_or_else(|| vademecum_rewrite::default_limit(file_length))
    }
}

/// Bytes: a whole number, with K, M, G or T for powers of 1000, or Ki, Mi, Gi or Ti for powers of 1024.
pub(crate) fn size(text: &str) -> Result<u64, String> {
    let wrong =
        || format!("`{text}` is not a size; expected bytes, or a number with K, M, G or T, such as 512M");
    let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit());
    let factor: u64 = match text[digits.len()..].to_ascii_uppercase().as_str() {
        "" | "B" => 1,
        "K" | "KB" => 1_000,
        "M" | "MB" => 1_000_000,
        "G" | "GB" => 1_000_000_000,
        "T" | "TB" => 1_000_000_000_000,
        "KI" | "KIB" => 1 << 10,
        "MI" | "MIB" => 1 << 20,
        "GI" | "GIB" => 1 << 30,
        "TI" | "TIB" => 1 << 40,
        _ => return Err(wrong()),
    };
    digits.parse::<u64>().ok().and_then(|number| number.checked_mul(factor)).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::{positive, rounding, size};

    #[test]
    fn numbers_out_of_their_range_are_no_arguments() {
        assert_eq!(positive("1e-3"), Ok(1e-3));
        for text in ["0", "-1", "nan", "inf", "1,5", ""] {
            assert!(positive(text).is_err_and(|error| error.contains("positive")), "{text}");
        }
        assert_eq!(rounding("1e-4"), Ok(1e-4));
        for text in ["0", "1", "1e-13", "x"] {
            assert!(rounding(text).is_err_and(|error| error.contains("1e-12 to 0.1")), "{text}");
        }
    }

    #[test]
    fn sizes_are_bytes_or_have_a_letter() {
        let sizes = [("0", 0), ("4096", 4096), ("512M", 512_000_000), ("4gi", 4 << 30), ("1 KiB", 1024)];
        for (text, bytes) in sizes {
            assert_eq!(size(&text.replace(' ', "")), Ok(bytes));
        }
        for text in ["", "M", "-1", "1.5G", "12Q", "99999999999999999999", "18446745T", "ü"] {
            assert!(size(text).is_err_and(|error| error.contains("512M")), "{text}");
        }
    }
}
