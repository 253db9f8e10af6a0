//! Errors of the evaluator in the words of the assembly file: names of parts and joints, keys, lines.

use vademecum_eval::{AssemblyError as Found, JointFault, PartFault};

use crate::error::AssemblyError;
use crate::file::AssemblyFile;

/// Why a part cannot be joined.
pub(crate) fn of_part(part: &str, fault: PartFault) -> AssemblyError {
    let part = part.to_string();
    match fault {
        PartFault::Missing { kind } => AssemblyError::Missing { part, kind },
        PartFault::NotExact => AssemblyError::Kind {
            part,
            found: "has no natural modes that are moved exactly".into(),
            expected: "a linear body with exact steps and no live stiffness of a region",
        },
        fault => AssemblyError::Fault { part, fault },
    }
}

/// Why a joint cannot be made.
pub(crate) fn of_joint(file: &AssemblyFile, index: usize, fault: JointFault) -> AssemblyError {
    let Some(entry) = file.joints.get(index) else { return AssemblyError::NoConvergence };
    let refused = |key: &str, found: String, expected: &str| {
        AssemblyError::from(file.refuse(&format!("joint[{index}].{key}"), found, expected))
    };
    match fault {
        JointFault::Redundant => AssemblyError::Redundant { joint: entry.name(index) },
        JointFault::Mixed => refused("between", "a patch and a frame".into(), "two patches, or two frames"),
        JointFault::OfPatches => refused(
            "kind",
            format!("`{}` of patches", entry.kind.word()),
            "`weld` or `bushing`; other joints are those of frames",
        ),
        JointFault::Stiffness { found, expected } => {
            let expected = match expected {
                1 => "one number, along the line between the frames",
                3 => "three numbers, along the axes of space, for each node of the first patch",
                _ => "six numbers, along and about the axes of the first frame",
            };
            refused("stiffness", format!("a list of {found}"), expected)
        }
        JointFault::NoFacets => refused("between", "a patch without facets".into(), "two patches of facets"),
        JointFault::OnePlace => {
            let expected = "two frames whose origins are apart; a `bushing` joins frames at one place";
            refused("between", "frames at one place".into(), expected)
        }
        JointFault::Apart { frames, distance, most } => {
            let what = if frames { "origins of the frames" } else { "patches" };
            let expected = format!(
                "{what} at most {most:.3e} m apart: check `position` and `rotation` of the parts, or set `distance`"
            );
            refused("between", format!("{what} {distance:.3e} m apart"), &expected)
        }
        fault => refused("between", fault.to_string(), "a joint of two ports that there are"),
    }
}

/// Why the parts cannot be joined.
pub(crate) fn of_assembly(file: &AssemblyFile, error: Found) -> AssemblyError {
    let name = |part: usize| file.parts.get(part).map_or("", |entry| &entry.name);
    match error {
        Found::Part { part, fault } => of_part(name(part), fault),
        Found::Joint { joint, fault } => of_joint(file, joint, fault),
        Found::Moves { motions, parts } => {
            let moves = |part: &usize| parts >> (*part).min(63) & 1 == 1;
            let names = (0..file.parts.len()).filter(moves).map(|part| format!("`{}`", name(part)));
            AssemblyError::Free { motions, parts: names.collect::<Vec<_>>().join(", ") }
        }
        Found::Count { what: what @ "modes", found, most } => {
            let expected = format!("at most {most}, the most a file has: parts of fewer modes");
            file.refuse("part", format!("{found} {what} of all parts"), expected).into()
        }
        Found::Count { what, found, most } => {
            let expected = format!("at most {most}: fewer nodes in the ports, or frames");
            file.refuse("joint", format!("{found} {what}"), expected).into()
        }
        Found::Format(error) => AssemblyError::Format(error),
        _ => AssemblyError::NoConvergence,
    }
}
