//! A finished file made into another: compressed for shipping (rounded, if that is allowed), raw for mapping,
//! or without what a target does not need.
//!
//! Each function takes the bytes of a whole file and gives the bytes of a whole new one; nothing is changed
//! in place. Metadata are taken over word for word (but for the number of terms and its certificate where
//! terms are dropped), so a section that is gone is *absent*, never of another shape, and what needs it says
//! so by name. The odd thing: sections this program does not know cannot be carried along (their meaning may
//! be tied to what is dropped), so a file that has some is not rewritten at all.

mod check;
mod codec;
mod error;
mod pack;
mod round;
mod terms;

pub use check::{Checked, check};
pub use codec::{DECODED_LIMIT, decode};
pub use error::RewriteError;
pub use pack::{pack, pack_within, read_losses};
pub use round::{Loss, WORST_MODE};
pub use terms::{Dropped, drop_terms, fewest_terms};

use vademecum_format::{Codec, File, Metadata, SectionInput, SectionKind, encode_into, encoded_len};

/// What a stripped file can still do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// Stepping under load patterns, probe values, energy, live parameters. No fields, no contacts, no
    /// geometry.
    Probes,
    /// That, and the surface: geometry, contacts, surface fields. No fields inside the body.
    Surface,
    /// Everything that is there.
    All,
}

impl Keep {
    /// Whether a section stays.
    #[must_use]
    pub fn keeps(self, kind: SectionKind) -> bool {
        use SectionKind as S;
        let inside = kind == S::InteriorBasis;
        let for_people = matches!(
            kind,
            S::SingularValues
                | S::ModeTable
                | S::EnrichmentHistory
                | S::RadiusSamples
                | S::Losses
                | S::Repairs
        );
        let surface =
            matches!(kind, S::NodeIds | S::NodeCoordinates | S::Triangles | S::SurfaceBasis | S::BlockLoad);
        match self {
            Self::Probes => !(inside || surface || for_people),
            Self::Surface => !inside,
            Self::All => true,
        }
    }

    /// Sections without which the promise would be empty.
    fn needs(self) -> &'static [SectionKind] {
        match self {
            Self::Probes => &[SectionKind::ProbeRows],
            Self::Surface => {
                &[SectionKind::SurfaceBasis, SectionKind::NodeCoordinates, SectionKind::Triangles]
            }
            Self::All => &[],
        }
    }
}

/// The file without the sections `keep` does not name. Codecs stay as they are.
///
/// # Errors
/// [`RewriteError::Format`], [`RewriteError::Unknown`]; [`RewriteError::Absent`] if what is to be kept is not
/// there; [`RewriteError::NothingToStrip`] if all of the file is to be kept.
pub fn strip(bytes: &[u8], keep: Keep) -> Result<Vec<u8>, RewriteError> {
    let file = whole(bytes)?;
    if let Some(&kind) = keep.needs().iter().find(|&&kind| file.section(kind).is_none()) {
        return Err(RewriteError::Absent { kind, keep });
    }
    let kept: Vec<SectionInput<'_>> =
        file.sections().filter(|section| keep.keeps(section.kind())).map(SectionInput::from).collect();
    if keep != Keep::All && kept.len() == file.sections().count() {
        return Err(RewriteError::NothingToStrip { keep });
    }
    write(&file, &kept)
}

/// The file with every section raw, as it is mapped. `limit` bounds the bytes of all sections together.
///
/// `unpack(pack(f)) = f` for a file `f` whose sections are all raw.
///
/// # Errors
/// [`RewriteError::Format`], [`RewriteError::Unknown`], [`RewriteError::Frame`], [`RewriteError::TooLarge`].
pub fn unpack(bytes: &[u8], limit: u64) -> Result<Vec<u8>, RewriteError> {
    let file = whole(bytes)?;
    codec::check_total(&file, limit)?;
    let mut raw = vec![];
    for section in file.sections() {
        raw.push((section, decode(&section, limit)?));
    }
    let inputs: Vec<SectionInput<'_>> = raw
        .iter()
        .map(|(section, raw)| SectionInput { codec: Codec::Raw, stored: raw, ..SectionInput::from(*section) })
        .collect();
    write(&file, &inputs)
}

/// The file, undamaged, if every section of it is known.
fn whole(bytes: &[u8]) -> Result<File<'_>, RewriteError> {
    let file = File::parse(bytes)?;
    file.verify_all()?;
    match unknown_sections(&file) {
        0 => Ok(file),
        count => Err(RewriteError::Unknown { count }),
    }
}

/// Sections of kinds this program does not know.
fn unknown_sections(file: &File<'_>) -> usize {
    file.n_sections().saturating_sub(file.sections().count())
}

fn write(file: &File<'_>, sections: &[SectionInput<'_>]) -> Result<Vec<u8>, RewriteError> {
    write_with(file.metadata(), sections)
}

fn write_with(metadata: &Metadata<'_>, sections: &[SectionInput<'_>]) -> Result<Vec<u8>, RewriteError> {
    let mut bytes = vec![0; encoded_len(metadata, sections)?];
    encode_into(metadata, sections, &mut bytes)?;
    Ok(bytes)
}
