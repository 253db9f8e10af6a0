//! States of parts: their coordinates, and what loads move of their ports.

use crate::assembly::error::AssemblyError;
use crate::assembly::part::{Part, number};
use crate::sections::contact::Contact;
use vademecum_format::SectionKind;

/// The state of a part: its coordinates, those of rigid motion first ([`Part`]), their rates, and what loads
/// move of its ports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartState<'a> {
    /// Coordinates, [`Part::n_coordinates`] \[m kg^½\].
    pub displacement: &'a [f64],
    /// Their rates \[m kg^½/s\].
    pub velocity: &'a [f64],
    /// `G R F` under the loads of this instant, as [`Part::move_ports`] adds it up; empty without loads.
    pub port_motion: &'a [f64],
}

impl Part<'_> {
    /// Adds `G R F` of contacts and of pattern amplitudes to `out`, [`Part::n_port_rows`] numbers: what the
    /// loads move of the ports beside the modes. Forces are in the part.
    ///
    /// # Errors
    /// [`AssemblyError::Length`].
    pub fn move_ports(
        &self,
        contacts: &[Contact],
        amplitudes: &[(usize, f64)],
        out: &mut [f64],
    ) -> Result<(), AssemblyError> {
        let expected = self.n_port_rows();
        if out.len() != expected {
            return Err(AssemblyError::Length { what: "the motion of ports", found: out.len(), expected });
        }
        let residual = self.file.section(SectionKind::PortResidual).and_then(|found| found.numbers().ok());
        for (port_row, out) in out.iter_mut().enumerate() {
            for contact in contacts {
                for (node, weight) in contact.place.entries() {
                    let start = 3 * (port_row * self.n_surface + node as usize);
                    let moved = contact.force.iter().enumerate();
                    *out += weight * moved.map(|(c, f)| f * number(residual, start + c)).sum::<f64>();
                }
            }
            for &(pattern, amplitude) in amplitudes {
                *out += amplitude * self.pattern_port(pattern, port_row);
            }
        }
        Ok(())
    }
}

/// Refuses states that do not fit the parts.
pub(crate) fn check_states(parts: &[Part<'_>], states: &[PartState<'_>]) -> Result<(), AssemblyError> {
    let length = |what, found, expected| Err(AssemblyError::Length { what, found, expected });
    if states.len() != parts.len() {
        return length("states of parts", states.len(), parts.len());
    }
    for (part, state) in parts.iter().zip(states) {
        let (n, rows) = (part.n_coordinates(), part.n_port_rows());
        if state.displacement.len() != n {
            return length("a displacement", state.displacement.len(), n);
        }
        if state.velocity.len() != n {
            return length("a velocity", state.velocity.len(), n);
        }
        if !state.port_motion.is_empty() && state.port_motion.len() != rows {
            return length("the motion of ports under loads", state.port_motion.len(), rows);
        }
        let mut numbers = state.displacement.iter().chain(state.velocity).chain(state.port_motion);
        if !numbers.all(|x| x.is_finite()) {
            return Err(AssemblyError::Number { what: "the state of a part" });
        }
    }
    Ok(())
}
