//! Where a force acts and what is read: channels of a request, found in a file.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use vademecum_build::input::Problem;
use vademecum_build::suggest::did_you_mean;
use vademecum_eval::{Place, Surface, SurfacePoint};
use vademecum_format::{File, SectionKind};

use crate::contents::{lines, numbers};
use crate::error::{FileError, StudyError, place as written};
use crate::near::{reach, within};

/// A point of the surface and a direction, a probe, or a load pattern: where a force acts, or what is read.
#[derive(Clone, Debug, PartialEq)]
pub enum Channel {
    /// The loadable point nearest to this one \[m\], along a direction, which need not have length 1.
    Point([f64; 3], [f64; 3]),
    /// A probe or, as an input, a load pattern by its name. As an input, a probe is a force along it, and it
    /// has to be at a loadable node.
    Named(String),
}

impl FromStr for Channel {
    type Err = ChannelError;

    /// `X,Y,Z,DIRECTION` or a name. A direction is `x`, `-x`, `y`, `-y`, `z`, `-z`, or three numbers.
    fn from_str(text: &str) -> Result<Self, ChannelError> {
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        let number = |part: &&str| part.parse::<f64>().ok().filter(|x| x.is_finite());
        let numbers: Vec<Option<f64>> = parts.iter().map(number).collect();
        let three =
            |at: usize| -> Option<[f64; 3]> { Some([numbers[at]?, numbers[at + 1]?, numbers[at + 2]?]) };
        let direction = match parts.len() {
            1 if !text.is_empty() => return Ok(Self::Named(text.into())),
            4 => {
                let (sign, axis) = match parts[3].strip_prefix('-') {
                    Some(axis) => (-1.0, axis),
                    None => (1.0, parts[3].trim_start_matches('+')),
                };
                let axis = ["x", "y", "z"].iter().position(|known| *known == axis);
                axis.map(|axis| std::array::from_fn(|c| if c == axis { sign } else { 0.0 }))
            }
            6 => three(3).filter(|direction| direction.iter().any(|c| *c != 0.0)),
            _ => None,
        };
        let point = if parts.len() > 3 { three(0) } else { None };
        let found = point.zip(direction).map(|(point, direction)| Self::Point(point, direction));
        found.ok_or_else(|| ChannelError(text.into()))
    }
}

impl fmt::Display for Channel {
    /// As a column is named: without commas.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(name) => out.write_str(name),
            Self::Point([x, y, z], [u, v, w]) => write!(out, "({x} {y} {z}) along ({u} {v} {w})"),
        }
    }
}

/// A text that is no channel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{0}` is no channel; write X,Y,Z,DIRECTION such as 1,0.04,0.1,-z or 1,0.04,0.1,0,0,-1, or a name")]
pub struct ChannelError(String);

/// Side of a channel; decides among which names it is looked up.
#[derive(Clone, Copy)]
pub(crate) enum Side {
    Input,
    Output,
}

impl Side {
    const fn what(self) -> &'static str {
        match self {
            Self::Input => "load pattern or probe at a loadable node",
            Self::Output => "probe",
        }
    }

    /// The section with the names, and that with a row of the basis for each.
    const fn sections(self) -> [SectionKind; 2] {
        match self {
            Self::Input => [SectionKind::PatternNames, SectionKind::PatternBasis],
            Self::Output => [SectionKind::ProbeNames, SectionKind::ProbeRows],
        }
    }
}

/// A channel of a file.
pub(crate) enum ResponsePoint {
    Point(SurfacePoint, [f64; 3]),
    /// The number of a load pattern (as an input) or of a probe (as an output).
    Named(usize),
}

/// Finds a channel in a file.
pub(crate) fn place(file: &File<'_>, channel: &Channel, side: Side) -> Result<ResponsePoint, StudyError> {
    match channel {
        Channel::Point(point, direction) => {
            let found = Surface::new(file).map_err(FileError::from)?.locate(*point);
            let found = found.ok_or(FileError::NoSurface)?;
            let found = within(file, reach(file)?, found, || format!("the point {}", written(*point)))?;
            let length = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
            Ok(ResponsePoint::Point(found, direction.map(|c| c / length)))
        }
        Channel::Named(name) => {
            let mut known = lines(file, side.sections()[0])?;
            let index = known.iter().position(|known| known == name);
            if let (None, Side::Input) = (index, side)
                && let Some(probe) = at_probe(file, name)?
            {
                return Ok(probe);
            }
            if let (None, Side::Input) = (index, side) {
                let probes = lines(file, SectionKind::ProbeNames)?;
                known.extend(probes.into_iter().filter(|probe| matches!(at_probe(file, probe), Ok(Some(_)))));
            }
            let index = index.ok_or_else(|| StudyError::NoChannel {
                name: name.clone(),
                what: side.what(),
                known: listed(&known) + &did_you_mean(name, known.iter().map(String::as_str)),
            })?;
            Ok(ResponsePoint::Named(index))
        }
    }
}

/// Node and direction of a probe of the problem that the file was built from, if the node is loadable.
pub(crate) fn at_probe(file: &File<'_>, name: &str) -> Result<Option<ResponsePoint>, FileError> {
    let Ok(problem) = Problem::parse(file.metadata().problem, "problem", PathBuf::new()) else {
        return Ok(None);
    };
    let Some(probe) = problem.output.probes.iter().find(|probe| probe.name == name) else { return Ok(None) };
    let coordinates = numbers(file, SectionKind::NodeCoordinates)?;
    let square = |at: &[f64; 3]| (0..3).map(|c| (at[c] - probe.point[c]).powi(2)).sum::<f64>();
    let nodes = coordinates.as_chunks::<3>().0.iter().zip(0..);
    let nearest = nodes.min_by(|a, b| square(a.0).total_cmp(&square(b.0)));
    let loadable = nearest.filter(|&(_, node)| node < file.metadata().n_load_nodes);
    let length = probe.direction.iter().map(|c| c * c).sum::<f64>().sqrt();
    Ok(loadable.map(|(&position, node)| {
        let point = SurfacePoint { place: Place::node(node), position, distance: 0.0 };
        ResponsePoint::Point(point, probe.direction.map(|c| c / length))
    }))
}

fn listed(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    if quoted.is_empty() { "none".into() } else { quoted.join(", ") }
}

/// The row of the basis that belongs to a channel.
pub(crate) fn row(file: &File<'_>, placed: &ResponsePoint, side: Side) -> Result<Vec<f64>, FileError> {
    let r = file.metadata().n_modes as usize;
    match placed {
        ResponsePoint::Named(index) => {
            let [_, kind] = side.sections();
            let rows = numbers(file, kind)?;
            rows.get(index * r..(index + 1) * r).map(<[f64]>::to_vec).ok_or(FileError::Missing { kind })
        }
        ResponsePoint::Point(point, direction) => {
            let kind = SectionKind::SurfaceBasis;
            let rows = numbers(file, kind)?;
            let mut sum = vec![0.0; r];
            for (node, weight) in point.place.entries() {
                for (c, along) in direction.iter().enumerate() {
                    let start = (3 * node as usize + c) * r;
                    let row = rows.get(start..start + r).ok_or(FileError::Missing { kind })?;
                    sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += weight * along * x);
                }
            }
            Ok(sum)
        }
    }
}
