//! The table of cards: who reads each, and the consequence of those that nobody reads.

use vademecum_build::mesh::inp::InpCard;

use crate::abaqus::reader::{Reader, Section};
use crate::abaqus::{attach, damping, heat, loads, material};
use crate::error::DeckError;

/// Cards without a meaning for the result: headings, output requests, and what the mesh reader takes.
const SILENT: &[&str] = &[
    "HEADING",
    "PREPRINT",
    "RESTART",
    "NODE",
    "ELEMENT",
    "NSET",
    "ELSET",
    "SURFACE",
    "INCLUDE",
    "PART",
    "END PART",
    "INSTANCE",
    "END INSTANCE",
    "ASSEMBLY",
    "END ASSEMBLY",
    "NODE FILE",
    "EL FILE",
    "ELEMENT FILE",
    "EL PRINT",
    "NODE OUTPUT",
    "ELEMENT OUTPUT",
    "OUTPUT",
    "CONTACT FILE",
    "CONTACT PRINT",
    "CONTACT OUTPUT",
    "ENERGY OUTPUT",
    "ENERGY PRINT",
    "MONITOR",
    "PRINT",
    "FILE FORMAT",
    "TIME POINTS",
    "SECTION PRINT",
    "MATRIX GENERATE",
    "MATRIX OUTPUT",
    "SOLVER CONTROLS",
    "CONTROLS",
    "FILTER",
    "USER MATERIAL OUTPUT",
];

/// Cards that are named when they are left out, and the consequence of each.
const LEFT_OUT: &[(&[&str], &str)] = &[
    (
        &["PLASTIC", "CYCLIC HARDENING", "CREEP", "HYPERELASTIC", "HYPERFOAM", "VISCOELASTIC", "POTENTIAL"],
        "the material stays linear elastic",
    ),
    (
        &["CONDUCTIVITY", "SPECIFIC HEAT", "PHYSICAL CONSTANTS"],
        "heat does not flow: temperatures are those that the deck gives",
    ),
    (
        &[
            "CONTACT",
            "CONTACT PAIR",
            "SURFACE INTERACTION",
            "SURFACE BEHAVIOR",
            "FRICTION",
            "CONTACT INCLUSIONS",
            "CONTACT PROPERTY ASSIGNMENT",
            "CLEARANCE",
        ],
        "bodies do not touch: the answer is that without contact",
    ),
    (&["BASE MOTION"], "the base does not move"),
    (&["PRE-TENSION SECTION"], "the section is not tightened: it is joined as it is"),
    (
        &["SHELL SECTION", "BEAM SECTION", "BEAM GENERAL SECTION", "MEMBRANE SECTION"],
        "it belongs to no element",
    ),
];

/// Takes a card.
pub(crate) fn take(reader: &mut Reader<'_>, card: &InpCard) -> Result<(), DeckError> {
    match card.keyword.as_str() {
        "MATERIAL" => material::begin(reader, card),
        "ELASTIC" => material::elastic(reader, card),
        "DENSITY" => material::density(reader, card),
        "EXPANSION" => heat::expansion(reader, card),
        "INITIAL CONDITIONS" => heat::initial(reader, card),
        "TEMPERATURE" => heat::temperature(reader, card),
        "ORIENTATION" => {
            material::orientation(reader, card);
            Ok(())
        }
        "SOLID SECTION" => {
            let of = |key: &str| card.parameter(key).unwrap_or("").to_string();
            let [set, material, orientation] = ["ELSET", "MATERIAL", "ORIENTATION"].map(of);
            reader.sections.push(Section { set, material, orientation });
            Ok(())
        }
        "RIGID BODY" => attach::rigid_body(reader, card),
        "COUPLING" => attach::coupling(reader, card),
        "KINEMATIC" | "DISTRIBUTING" => attach::coupled(reader, card),
        "DISTRIBUTING COUPLING" => attach::distributing(reader, card),
        "MPC" => attach::mpc(reader, card),
        "EQUATION" => attach::equation(reader, card),
        "TIE" => attach::tie(reader, card),
        "TRANSFORM" => attach::transform(reader, card),
        "MASS" | "ROTARY INERTIA" => attach::mass(reader, card),
        "SPRING" | "DASHPOT" => attach::spring(reader, card),
        "AMPLITUDE" => loads::read_amplitude(reader, card),
        "STEP" => {
            loads::begin_step(reader, card);
            Ok(())
        }
        "END STEP" => {
            reader.end_step();
            Ok(())
        }
        "STATIC"
        | "FREQUENCY"
        | "MODAL DYNAMIC"
        | "DYNAMIC"
        | "STEADY STATE DYNAMICS"
        | "BUCKLE"
        | "COMPLEX FREQUENCY"
        | "HEAT TRANSFER"
        | "COUPLED TEMPERATURE-DISPLACEMENT"
        | "VISCO"
        | "UNCOUPLED TEMPERATURE-DISPLACEMENT"
        | "RANDOM RESPONSE"
        | "RESPONSE SPECTRUM" => loads::procedure(reader, card),
        "DAMPING" | "GLOBAL DAMPING" => damping::proportional(reader, card),
        "MODAL DAMPING" => damping::modal(reader, card),
        "NODE PRINT" => loads::node_print(reader, card),
        "BOUNDARY" => loads::boundary(reader, card),
        "CLOAD" => loads::cload(reader, card),
        "DLOAD" => loads::dload(reader, card),
        "DSLOAD" => loads::dsload(reader, card),
        "CYCLIC SYMMETRY MODEL" => {
            let expected = "a whole model: cyclic symmetry is not computed with";
            Err(reader.fault(card, None, &card.section(), expected))
        }
        keyword if SILENT.contains(&keyword) => Ok(()),
        keyword => {
            let known = LEFT_OUT.iter().find(|(cards, _)| cards.contains(&keyword));
            reader.leave(card, known.map_or("it is not known, and has no effect", |known| known.1));
            Ok(())
        }
    }
}
