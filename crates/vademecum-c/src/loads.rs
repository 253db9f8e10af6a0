//! What acts on a body: contacts and load patterns, held over a step or changing within it.

use vademecum_eval::format::SectionKind;
use vademecum_eval::format::scheme::MAX_STAGES;
use vademecum_eval::{BaseMotion, Contact, LoadError, Loads, Scalar, Scene, SurfacePoint};

use crate::body::{Body, Moved, moved};
use crate::types::{VdmPlace, VdmStatus};

/// Amplitudes at the instants of a step.
pub type Amplitudes = [f64; 1 + MAX_STAGES];

impl Body {
    pub fn locate(&mut self, point: [f64; 3], place: &mut VdmPlace) -> VdmStatus {
        match self.surface.as_ref().and_then(|surface| surface.locate(point)) {
            Some(SurfacePoint { place: found, position, distance }) => {
                let (nodes, weights) = found.corners().unwrap_or_default();
                *place = VdmPlace { nodes, weights, position, distance };
                VdmStatus::VDM_OK
            }
            None => self.message.note(VdmStatus::VDM_OUTPUT, &"the file has no loadable surface"),
        }
    }

    /// The place that is a node.
    pub fn at_node(&mut self, node: u32, place: &mut VdmPlace) -> VdmStatus {
        let limit = self.file.metadata().n_load_nodes;
        if node >= limit {
            return self.message.note(VdmStatus::VDM_LOAD, &LoadError::NotLoadable { node, limit });
        }
        let section = self.file.section(SectionKind::NodeCoordinates);
        let known = section.and_then(|section| section.numbers().ok());
        let at = |k: usize| known.and_then(|all| all.get(3 * node as usize + k)).unwrap_or(0.0);
        let position = [at(0), at(1), at(2)];
        *place = VdmPlace { nodes: [node; 3], weights: [1.0, 0.0, 0.0], position, distance: 0.0 };
        VdmStatus::VDM_OK
    }

    pub fn clear_loads(&mut self) -> VdmStatus {
        moved!(self.march, m => match &mut self.free {
            Some(free) => free.clear(&mut m.loads),
            None => m.loads.clear(),
        });
        VdmStatus::VDM_OK
    }

    pub fn add_contact(&mut self, place: &VdmPlace, force: [f64; 3]) -> VdmStatus {
        let contact = place.contact(force);
        let done = moved!(self.march, m => m.loads.add_contact(&m.scene, &contact));
        self.answer(done, VdmStatus::VDM_LOAD)
    }

    pub fn add_pattern(&mut self, pattern: u32, amplitude: f64) -> VdmStatus {
        let done = moved!(self.march, m => m.loads.add_pattern(&m.scene, pattern as usize, amplitude));
        self.answer(done, VdmStatus::VDM_LOAD)
    }

    pub fn add_base(&mut self, motion: &BaseMotion) -> VdmStatus {
        let done = moved!(self.march, m => m.loads.add_base(&m.scene, motion));
        self.answer(done, VdmStatus::VDM_LOAD)
    }

    pub fn instants(&self) -> Amplitudes {
        match &self.march {
            crate::body::March::Single(m) => m.scene.instants(),
            #[cfg(feature = "double")]
            crate::body::March::Double(m) => m.scene.instants(),
        }
    }

    pub fn add_contact_staged(
        &mut self,
        place: &VdmPlace,
        force: [f64; 3],
        amplitudes: &Amplitudes,
    ) -> VdmStatus {
        let contact = place.contact(force);
        let done = moved!(self.march, m => m.loads.add_contact_staged(&m.scene, &contact, amplitudes));
        self.answer(done, VdmStatus::VDM_LOAD)
    }

    pub fn add_pattern_staged(&mut self, pattern: u32, amplitudes: &Amplitudes) -> VdmStatus {
        let index = pattern as usize;
        let done = moved!(self.march, m => m.loads.add_pattern_staged(&m.scene, index, amplitudes));
        self.answer(done, VdmStatus::VDM_LOAD)
    }

    /// A force that goes from one value to another over the step.
    pub fn add_contact_ramp(&mut self, place: &VdmPlace, start: [f64; 3], end: [f64; 3]) -> VdmStatus {
        // Both are checked before the first is added, so that a refusal changes nothing.
        let finite = start.iter().chain(&end).all(|force| force.is_finite());
        let later = self.instants();
        let earlier = later.map(|t| 1.0 - t);
        let done = if finite {
            let (start, end) = (place.contact(start), place.contact(end));
            moved!(self.march, m => {
                let Moved { scene, loads, .. } = m;
                add_both(scene, loads, [(&start, &earlier), (&end, &later)])
            })
        } else {
            Err(LoadError::NotFinite)
        };
        self.answer(done, VdmStatus::VDM_LOAD)
    }

    /// The same for a pattern.
    pub fn add_pattern_ramp(&mut self, pattern: u32, start: f64, end: f64) -> VdmStatus {
        let amplitudes = self.instants().map(|t| (1.0 - t) * start + t * end);
        self.add_pattern_staged(pattern, &amplitudes)
    }

    /// Keeps the loads as they are.
    pub fn keep_loads(&mut self) -> VdmStatus {
        let done = moved!(self.march, m => match &mut m.kept {
            Some(kept) => kept.copy_from(&m.loads).map(Some),
            None => Ok(None),
        });
        self.kept(done)
    }

    /// The loads become what was kept.
    pub fn recall_loads(&mut self) -> VdmStatus {
        let done = moved!(self.march, m => match &m.kept {
            Some(kept) => m.loads.copy_from(kept).map(Some),
            None => Ok(None),
        });
        self.kept(done)
    }

    fn kept(&mut self, done: Result<Option<()>, LoadError>) -> VdmStatus {
        match done {
            Ok(Some(())) => VdmStatus::VDM_OK,
            Ok(None) => {
                let said = "there is no room for kept loads; bind with VdmOptions.keep_loads = 1";
                self.message.note(VdmStatus::VDM_MEMORY, &said)
            }
            Err(error) => self.message.note(VdmStatus::VDM_LOAD, &error),
        }
    }
}

/// Adds two contacts at one place. A second that is refused is one that the first would have been, so nothing
/// has changed then: both have the same nodes, and their forces are finite.
fn add_both<T: Scalar>(
    scene: &Scene<'_, T>,
    loads: &mut Loads<'_, T>,
    parts: [(&Contact, &Amplitudes); 2],
) -> Result<(), LoadError> {
    parts.into_iter().try_for_each(|(contact, at)| loads.add_contact_staged(scene, contact, at))
}
