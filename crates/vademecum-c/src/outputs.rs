//! What is read of a body: probes, places, nodes, whole fields, energy, and its shape at rest.

use vademecum_eval::format::SectionKind;
use vademecum_eval::{Field, OutputError};

use crate::body::{Body, March, moved};
use crate::types::{VdmCost, VdmField, VdmPlace, VdmStatus, VdmStructure};

/// Which nodes a field is asked of.
#[derive(Clone, Copy)]
pub enum Part {
    Surface,
    Body,
}

/// Where a field comes from.
#[derive(Clone, Copy)]
pub enum Source {
    /// The modes, and the static residual around contacts.
    Modes,
    /// The modes, and the static answer of the whole body.
    Whole,
}

impl Body {
    /// The field of this number; for another one the message says so.
    fn field(&mut self, field: i32) -> Option<Field> {
        match field {
            f if f == VdmField::VDM_DISPLACEMENT as i32 => Some(Field::Displacement),
            f if f == VdmField::VDM_VELOCITY as i32 => Some(Field::Velocity),
            _ => {
                self.message.note(VdmStatus::VDM_ARGUMENT, &"no such field");
                None
            }
        }
    }

    pub fn probe(&mut self, probe: u32, field: i32, value: &mut f64) -> VdmStatus {
        let Some(field) = self.field(field) else { return VdmStatus::VDM_ARGUMENT };
        let found = moved!(self.march, m => m.scene.probe(&m.state, probe as usize, field));
        self.answer(found.map(|found| *value = found), VdmStatus::VDM_OUTPUT)
    }

    pub fn point(&mut self, place: &VdmPlace, field: i32, out: [&mut f64; 3]) -> VdmStatus {
        let Some(field) = self.field(field) else { return VdmStatus::VDM_ARGUMENT };
        let found = moved!(self.march, m => m.scene.point(&m.state, &place.point(), field));
        let found = found.map(|found| out.into_iter().zip(found).for_each(|(out, x)| *out = x));
        self.answer(found, VdmStatus::VDM_OUTPUT)
    }

    pub fn node(&mut self, node: u32, field: i32, out: [&mut f64; 3]) -> VdmStatus {
        let Some(field) = self.field(field) else { return VdmStatus::VDM_ARGUMENT };
        let found = moved!(self.march, m => m.scene.node(&m.state, node as usize, field));
        let found = found.map(|found| out.into_iter().zip(found).for_each(|(out, x)| *out = x));
        self.answer(found, VdmStatus::VDM_OUTPUT)
    }

    pub fn field_single(&mut self, part: Part, from: Source, field: i32, out: &mut [f32]) -> VdmStatus {
        let Some(field) = self.field(field) else { return VdmStatus::VDM_ARGUMENT };
        let done = match &mut self.march {
            March::Single(m) => whole_field(m, part, from, field, out),
            #[cfg(feature = "double")]
            March::Double(_) => {
                let said = "the body is in double precision: call the function that ends in f64";
                return self.message.note(VdmStatus::VDM_ARGUMENT, &said);
            }
        };
        self.answer(done, VdmStatus::VDM_OUTPUT)
    }

    pub fn field_double(&mut self, part: Part, from: Source, field: i32, out: &mut [f64]) -> VdmStatus {
        let Some(field) = self.field(field) else { return VdmStatus::VDM_ARGUMENT };
        #[cfg(feature = "double")]
        if let March::Double(m) = &mut self.march {
            let done = whole_field(m, part, from, field, out);
            return self.answer(done, VdmStatus::VDM_OUTPUT);
        }
        let _ = (part, from, field, out);
        let said = "the body is in single precision: call the function that ends in f32";
        self.message.note(VdmStatus::VDM_ARGUMENT, &said)
    }

    pub fn energy(&mut self, value: &mut f64) -> VdmStatus {
        let found = moved!(self.march, m => m.scene.energy(&m.state));
        self.answer(found.map(|found| *value = found), VdmStatus::VDM_OUTPUT)
    }

    pub fn reaction(&mut self, support: u32, out: &mut [f64; 6]) -> VdmStatus {
        let found = moved!(self.march, m => m.scene.reaction(&m.state, support as usize));
        self.answer(found.map(|found| *out = found.total()), VdmStatus::VDM_OUTPUT)
    }

    pub fn stress_points(&mut self) -> u32 {
        moved!(self.march, m => m.scene.n_stress_points()) as u32
    }

    pub fn stress_point(&mut self, point: u32) -> Option<[u32; 2]> {
        let found = moved!(self.march, m => m.scene.stress_point(point as usize));
        found.map(|found| [found.node, found.region])
    }

    pub fn stress(&mut self, point: u32, out: &mut [f64; 6]) -> VdmStatus {
        let found = moved!(self.march, m => m.scene.stress(&m.state, point as usize));
        self.answer(found.map(|found| *out = found.0), VdmStatus::VDM_OUTPUT)
    }

    pub fn strain(&mut self, point: u32, out: &mut [f64; 6]) -> VdmStatus {
        let found = moved!(self.march, m => m.scene.strain(&m.state, point as usize));
        self.answer(found.map(|found| *out = found.0), VdmStatus::VDM_OUTPUT)
    }

    pub fn energy_at_rest(&mut self) -> f64 {
        moved!(self.march, m => m.scene.energy_at_rest())
    }

    pub fn structure(&mut self) -> i32 {
        use vademecum_eval::Structure as S;
        let structure = match moved!(self.march, m => m.scene.structure()) {
            S::Diagonal => VdmStructure::VDM_DIAGONAL,
            S::Block => VdmStructure::VDM_BLOCK,
            S::Exact => VdmStructure::VDM_EXACT,
            S::Strain => VdmStructure::VDM_STRAIN,
        };
        structure as i32
    }

    pub fn cost(&mut self) -> VdmCost {
        let cost = moved!(self.march, m => m.scene.cost());
        VdmCost {
            terms: cost.terms,
            bind_bytes: cost.bind_bytes,
            step_operations: cost.step_operations,
            step_bytes: cost.step_bytes,
            contact_rows: cost.contact_rows,
            contact_bytes: cost.contact_bytes,
            pattern_bytes: cost.pattern_bytes,
            probe_bytes: cost.probe_bytes,
            node_bytes: cost.node_bytes,
            surface_bytes: cost.surface_bytes,
            body_bytes: cost.body_bytes,
        }
    }

    pub fn increment(&mut self, out: &mut [f64]) -> VdmStatus {
        let done = moved!(self.march, m => m.scene.increment_into(out));
        self.answer(done, VdmStatus::VDM_OUTPUT)
    }

    /// Where the nodes of the surface are at rest.
    pub fn positions(&mut self, out: &mut [f64]) -> VdmStatus {
        let kind = SectionKind::NodeCoordinates;
        let known = self.file.section(kind).and_then(|section| section.numbers().ok());
        let needed = 3 * self.file.metadata().n_surface_nodes as usize;
        let done = match known {
            Some(_) if out.len() != needed => Err(OutputError::Length { found: out.len(), needed }),
            Some(all) => {
                out.iter_mut().enumerate().for_each(|(k, out)| *out = all.get(k).unwrap_or(0.0));
                Ok(())
            }
            None => Err(OutputError::Missing { kind }),
        };
        self.answer(done, VdmStatus::VDM_OUTPUT)
    }

    /// The triangles of the surface.
    pub fn triangles(&mut self, out: &mut [u32]) -> VdmStatus {
        let kind = SectionKind::Triangles;
        let known = self.file.section(kind).and_then(|section| section.u32s().ok());
        let done = match known {
            Some(all) if out.len() != all.len() => {
                Err(OutputError::Length { found: out.len(), needed: all.len() })
            }
            Some(all) => {
                out.iter_mut().zip(all).for_each(|(out, &node)| *out = u32::from_le_bytes(node));
                Ok(())
            }
            None => Err(OutputError::Missing { kind }),
        };
        self.answer(done, VdmStatus::VDM_OUTPUT)
    }

    /// Memory that the answer of the whole body wants; 0 where the file does not have it.
    pub fn static_bytes(&mut self) -> usize {
        moved!(self.march, m => crate::solved::static_bytes(&m.scene))
    }
}

fn whole_field<T: vademecum_eval::Scalar>(
    m: &mut crate::body::Moved<T>,
    part: Part,
    from: Source,
    field: Field,
    out: &mut [T],
) -> Result<(), OutputError> {
    match (from, &mut m.statics) {
        (Source::Modes, _) => match part {
            Part::Surface => m.scene.surface_into(&m.state, field, out),
            Part::Body => m.scene.body_into(&m.state, field, out),
        },
        (Source::Whole, Some(statics)) => match part {
            Part::Surface => m.scene.surface_with(&m.state, field, statics, out),
            Part::Body => m.scene.body_with(&m.state, field, statics, out),
        },
        (Source::Whole, None) => Err(OutputError::Missing { kind: SectionKind::FactorValues }),
    }
}
