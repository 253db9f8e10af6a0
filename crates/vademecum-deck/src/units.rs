//! Units of a deck, which has none: its density and its modulus tell.

use serde::Serialize;

/// A system of units in which structural programs are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum System {
    /// Metre, kilogram, newton, pascal.
    #[serde(rename = "m-kg-N")]
    MetreKilogram,
    /// Millimetre, tonne, newton, megapascal.
    #[serde(rename = "mm-t-N")]
    MillimetreTonne,
    /// Millimetre, kilogram, millinewton, kilopascal.
    #[serde(rename = "mm-kg-mN")]
    MillimetreKilogram,
    /// Inch, pound-force second squared per inch, pound-force, psi.
    #[serde(rename = "in-lbf")]
    Inch,
    /// Foot, slug, pound-force, psf.
    #[serde(rename = "ft-lbf")]
    Foot,
    /// Of its own: numbers stay as they are.
    #[serde(rename = "none")]
    Own,
}

/// Units of a deck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Their system; none where nothing tells it.
    pub system: Option<System>,
    /// True if modulus and density tell it, and nobody said it.
    pub guessed: bool,
}

/// Densities from light foam to tungsten, moduli from soft tissue to diamond, in kg/m³ and Pa.
const DENSITY: [f64; 2] = [20.0, 25e3];
const MODULUS: [f64; 2] = [1e3, 1.3e12];

/// Systems with the value of 1 kg/m³ and of 1 Pa.
const SYSTEMS: [(System, &str, f64, f64); 5] = [
    (System::MetreKilogram, "m-kg-N", 1.0, 1.0),
    (System::MillimetreTonne, "mm-t-N", 1e-12, 1e-6),
    (System::MillimetreKilogram, "mm-kg-mN", 1e-9, 1e-3),
    (System::Inch, "in-lbf", 9.357_25e-8, 1.450_38e-4),
    (System::Foot, "ft-lbf", 1.940_32e-3, 2.088_54e-2),
];

/// Name of units of its own.
const OWN: &str = "none";

impl System {
    /// Its name.
    pub fn name(self) -> &'static str {
        SYSTEMS.iter().find(|row| row.0 == self).map_or(OWN, |row| row.1)
    }

    /// Metres in a unit of length, pascals in one of pressure, kg/m³ in one of density.
    pub(crate) fn factors(self) -> [f64; 3] {
        let metre = match self {
            System::MetreKilogram | System::Own => 1.0,
            System::MillimetreTonne | System::MillimetreKilogram => 1e-3,
            System::Inch => 0.0254,
            System::Foot => 0.3048,
        };
        let (kilogram, pascal) =
            SYSTEMS.iter().find(|row| row.0 == self).map_or((1.0, 1.0), |row| (row.2, row.3));
        [metre, 1.0 / pascal, 1.0 / kilogram]
    }

    /// The system of a name.
    pub fn parse(name: &str) -> Option<System> {
        let known = SYSTEMS.iter().find(|row| row.1 == name).map(|row| row.0);
        known.or_else(|| (name == OWN).then_some(System::Own))
    }
}

impl Units {
    /// Units that modulus and density tell, if they do.
    pub(crate) fn guessed(system: Option<System>) -> Units {
        Units { system, guessed: true }
    }

    /// The system in which modulus and density are those of a solid; of several, the one in which they are
    /// nearest to those of common metals. None without a density.
    pub(crate) fn guess(young: f64, density: f64) -> Units {
        /// A stiff solid, which separates the systems: modulus and density of aluminium and steel lie
        /// about it.
        const TYPICAL: [f64; 2] = [1e11, 4e3];
        if !(young > 0.0 && density > 0.0) {
            return Units::guessed(None);
        }
        let within = |value: f64, [low, high]: [f64; 2]| (low..=high).contains(&value);
        let in_si = SYSTEMS.map(|(system, _, kilogram, pascal)| (system, young / pascal, density / kilogram));
        let fitting = in_si.iter().filter(|(_, e, rho)| within(*e, MODULUS) && within(*rho, DENSITY));
        let off =
            |(_, e, rho): &(System, f64, f64)| (e / TYPICAL[0]).ln().abs() + (rho / TYPICAL[1]).ln().abs();
        Units::guessed(fitting.min_by(|a, b| off(a).total_cmp(&off(b))).map(|found| found.0))
    }

    /// Description for the user.
    pub fn words(self) -> String {
        let name = match self.system {
            None => return "unknown: numbers are in those of the deck".into(),
            Some(System::Own) => return "not converted: numbers are in those of the deck".into(),
            Some(system) => system.name(),
        };
        format!("{name}{}", if self.guessed { " (guessed from modulus and density)" } else { "" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steel_aluminium_and_rubber_are_known_in_every_system() {
        for (young, density) in [(2.1e11, 7850.0), (7e10, 2700.0), (3e9, 1200.0), (1e7, 1100.0)] {
            for (system, _, kilogram, pascal) in SYSTEMS {
                let found = Units::guess(young * pascal, density * kilogram);
                // Soft solids may look like stiff ones of another system.
                if young > 1e9 {
                    assert_eq!(found, Units::guessed(Some(system)), "{young} {density}");
                } else {
                    assert!(found.system.is_some());
                }
            }
        }
    }

    #[test]
    fn numbers_without_a_density_or_of_no_solid_have_no_units() {
        assert_eq!(Units::guess(2.1e11, 0.0), Units::guessed(None));
        assert_eq!(Units::guess(1.0, 1.0), Units::guessed(None));
        for (system, name, ..) in SYSTEMS {
            assert_eq!(System::parse(name), Some(system));
            assert_eq!(system.name(), name);
        }
    }
}
