//! Element types of Ansys by their numbers.

use std::collections::BTreeMap;

use super::scan::Scan;
use crate::mesh::{ElementKind, Hexahedra};

/// A type that an Ansys file defines.
#[derive(Clone, Debug, Default)]
pub(super) struct ElementType {
    /// Number of the element in the library of the program, for instance 186.
    pub(super) element: u64,
    options: BTreeMap<u64, i64>,
}

/// Types of a file by their numbers.
pub(super) fn types(scan: &Scan) -> BTreeMap<u64, ElementType> {
    let mut found: BTreeMap<u64, ElementType> = BTreeMap::new();
    for row in &scan.types {
        let [number, element, options @ ..] = row.as_slice() else { continue };
        if let (Ok(number), Ok(element)) = (u64::try_from(*number), u64::try_from(*element)) {
            let options = (1..).zip(options.iter().copied()).collect();
            found.insert(number, ElementType { element, options });
        }
    }
    for command in &scan.commands {
        let number = command.field(0).parse::<u64>();
        match (command.name.as_str(), number) {
            ("ET", Ok(number)) => {
                // `186` or `SOLID186`.
                let name = command.field(1);
                let digits = name.trim_start_matches(|c: char| !c.is_ascii_digit());
                let Ok(element) = digits.parse() else { continue };
                let option = |index: u64| Some((index, command.field(index as usize + 1).parse().ok()?));
                found.insert(number, ElementType { element, options: (1..=6).filter_map(option).collect() });
            }
            // Commands may be cut to their first letters.
            (name, Ok(number)) if name.starts_with("KEYO") => {
                let (option, value) = (command.field(1).parse(), command.field(2).parse());
                if let (Some(known), Ok(option), Ok(value)) = (found.get_mut(&number), option, value) {
                    known.options.insert(option, value);
                }
            }
            _ => {}
        }
    }
    found
}

impl ElementType {
    fn option(&self, index: u64) -> i64 {
        self.options.get(&index).copied().unwrap_or(0)
    }

    /// Kind of the solids with all their nodes, and the least number of nodes that a file gives; none for
    /// other elements.
    pub(super) fn solid(&self) -> Option<(ElementKind, usize)> {
        Some(match self.element {
            45 | 185 => (ElementKind::Hex8, 8),
            95 | 186 => (ElementKind::Hex20, 8),
            92 | 187 => (ElementKind::Tet10, 4),
            285 => (ElementKind::Tet4, 4),
            _ => return None,
        })
    }

    /// Formulation of the hexahedra.
    pub(super) fn formulation(&self, kind: ElementKind) -> Option<Hexahedra> {
        Some(match (self.element, kind) {
            (45, ElementKind::Hex8) if self.option(2) == 1 => Hexahedra::Reduced,
            (45, ElementKind::Hex8) if self.option(1) == 1 => Hexahedra::Full,
            (45, ElementKind::Hex8) => Hexahedra::Incompatible,
            (185, ElementKind::Hex8) => match self.option(2) {
                0 => Hexahedra::MeanDilatation,
                1 => Hexahedra::Reduced,
                _ => Hexahedra::Incompatible,
            },
            (186, ElementKind::Hex20) if self.option(2) == 0 => Hexahedra::Reduced,
            (95, ElementKind::Hex20) if self.option(11) == 1 => Hexahedra::Reduced,
            // Eight points are full integration where there are no middles.
            (95 | 186, _) => Hexahedra::Full,
            _ => return None,
        })
    }

    /// True for a solid that is not read, which must not be missing without a word.
    pub(super) fn is_other_solid(&self) -> bool {
        name_of(self.element) == "SOLID" || self.element == 190
    }

    /// The name of the element, for messages.
    pub(super) fn name(&self) -> String {
        format!("{}{}", name_of(self.element), self.element)
    }
}

/// The first part of the name of an element.
fn name_of(element: u64) -> &'static str {
    const NAMES: [(&str, &[u64]); 15] = [
        (
            "SOLID",
            &[
                5, 45, 46, 62, 64, 65, 69, 70, 72, 73, 87, 90, 92, 95, 96, 97, 98, 122, 123, 147, 148, 164,
                168, 185, 186, 187, 191, 226, 227, 231, 232, 236, 237, 239, 240, 278, 279, 285, 291,
            ],
        ),
        ("SOLSH", &[190]),
        ("MASS", &[21, 71, 166]),
        ("BEAM", &[3, 4, 23, 24, 44, 54, 161, 188, 189]),
        ("LINK", &[1, 8, 10, 11, 33, 34, 68, 160, 167, 180]),
        ("PIPE", &[16, 17, 18, 20, 59, 60, 288, 289]),
        ("COMBIN", &[7, 14, 37, 39, 40, 165]),
        ("SHELL", &[28, 41, 43, 57, 61, 63, 91, 93, 99, 131, 132, 143, 150, 157, 163, 181, 208, 209, 281]),
        ("PLANE", &[2, 13, 25, 35, 42, 53, 55, 67, 75, 77, 78, 82, 83, 145, 146, 162, 182, 183, 223]),
        ("SURF", &[19, 22, 151, 152, 153, 154, 155, 156, 159, 251, 252]),
        ("TARGE", &[169, 170]),
        ("CONTA", &[171, 172, 173, 174, 175, 176, 177, 178]),
        ("MPC", &[184]),
        ("MESH", &[200]),
        ("MATRIX", &[27, 50]),
    ];
    let found = NAMES.iter().find(|(_, numbers)| numbers.contains(&element));
    found.map_or("element ", |(name, _)| name)
}
